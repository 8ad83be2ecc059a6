//! Contracts of learning in several processes, and while collecting.

use std::thread;

use super::*;
use lifelike_train::collective::threads;

/// A plan whose minibatch is everything, so that halves of it have the mean of their gradients.
fn whole_batches(environments: usize) -> TrackerPlan {
    let mut p = plan(environments);
    p.randomization = RandomizationSpec { joint_offset: 0.02, ..RandomizationSpec::default() };
    p.rsi.failure_share = 0.0;
    p.ppo.minibatch = environments * p.ppo.steps;
    p
}

#[test]
fn two_processes_learn_what_one_learns_with_twice_the_environments() {
    let (alone, _) = iterations(trainer(&whole_batches(12)), 4);
    let members: Vec<_> = threads::group(2)
        .into_iter()
        .map(|member| {
            thread::spawn(move || {
                let p = whole_batches(6);
                let robot = robot();
                let library = library(&robot);
                let simulation = Box::new(Followers::new(6));
                iterations(Trainer::distributed(&p, robot, library, simulation, Arc::new(member)).unwrap(), 4)
            })
        })
        .collect();
    let results: Vec<_> = members.into_iter().map(|m| m.join().unwrap()).collect();
    assert!(results[0].1 == results[1].1, "every process has the same policy, bit for bit");
    for (k, (one, two)) in alone.iter().zip(&results[0].0).enumerate() {
        // A mean of terms of size one that cancel: single precision knows it to some 1e-6.
        let (a, b) = (one.surrogate, two.surrogate);
        assert!((a - b).abs() <= 2e-6, "iteration {k}, surrogate: {a} alone, {b} in two processes");
        for (what, a, b) in [
            ("value loss", one.value_loss, two.value_loss),
            ("divergence", one.divergence, two.divergence),
            ("std", one.std, two.std),
            ("learning rate", one.learning_rate, two.learning_rate),
        ] {
            assert!((a - b).abs() <= 1e-4 * a.abs() + 1e-7, "iteration {k}, {what}: {a} alone, {b} in two processes");
        }
    }
    assert!(alone[3].value_loss != alone[0].value_loss && alone[3].divergence > 0.0, "something was learned");
}

#[test]
fn processes_have_environments_of_their_own() {
    let p = whole_batches(6);
    let (robot, all) = (robot(), whole_batches(12));
    let of = |process| {
        Environment::distributed(&p, robot.clone(), library(&robot), Box::new(Followers::new(6)), (process, 2)).unwrap()
    };
    let whole = environment(&all);
    let (first, second) = (of(0), of(1));
    assert_eq!([first.actor_rows(), second.actor_rows()].concat(), whole.actor_rows());
}

fn overlapped() -> TrackerPlan {
    let mut p = restless();
    p.ppo.overlap = true;
    p
}

#[test]
fn a_run_that_overlaps_is_one_update_behind_and_the_same_each_time() {
    let (a, first) = iterations(trainer(&overlapped()), 4);
    let (_, second) = iterations(trainer(&overlapped()), 4);
    assert!(first == second);
    assert_eq!((a[0].divergence, a[0].value_loss), (0.0, 0.0), "nothing to learn from yet");
    // The first rollouts are those of a run that does not overlap, and so is what is learned from the first of them.
    let mut p = overlapped();
    p.ppo.overlap = false;
    let (b, _) = iterations(trainer(&p), 2);
    assert_eq!((a[0].reward, a[1].value_loss, a[1].divergence), (b[0].reward, b[0].value_loss, b[0].divergence));
    assert_ne!(a[1].reward, b[1].reward, "the second rollout is still the fresh policy's");
}

#[test]
fn an_overlapping_run_resumes_bit_for_bit() {
    let mut whole = trainer(&overlapped());
    for _ in 0..3 {
        whole.iterate().unwrap();
    }
    let checkpoint = whole.checkpoint().unwrap();
    let mut resumed = trainer(&overlapped());
    resumed.restore(&checkpoint).unwrap();
    for t in [&mut whole, &mut resumed] {
        t.iterate().unwrap();
        t.iterate().unwrap();
    }
    let file = |t: &Trainer| t.policy().to_checkpoint().unwrap().to_bytes().unwrap();
    assert!(file(&whole) == file(&resumed));
}
