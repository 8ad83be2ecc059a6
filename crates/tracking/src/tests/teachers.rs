//! Contracts of trainings that learn from teachers.

use lifelike_robot::controller::KIND;
use lifelike_robot::{ActionMap, Controller, ControllerFile};
use lifelike_train::VectorEnvironment;

use super::*;
use crate::plan::TeacherSpec;

fn trainer(plan: &TrackerPlan) -> Trainer {
    let robot = robot();
    let simulation = Box::new(Followers::new(plan.ppo.environments));
    Trainer::new(plan, Arc::clone(&robot), library(&robot), simulation).unwrap()
}

/// Factor on a teacher's outputs, which are near zero after so few iterations.
const LOUD: f32 = 30.0;

/// A policy that learned a little, and the controller of it as a teacher: [`LOUD`] times the policy's outputs.
fn teacher(plan: &TrackerPlan) -> (Policy, Controller) {
    let mut trainer = trainer(plan);
    for _ in 0..4 {
        trainer.iterate().unwrap();
    }
    let quiet = trainer.policy().to_checkpoint().unwrap();
    let mut loud = Checkpoint::new();
    for (name, entry) in quiet.entries() {
        let (shape, last) = (entry.shape().to_vec(), name.starts_with("actor.mean.layers.1."));
        if last {
            let values = quiet.f32s(name, &shape).unwrap().iter().map(|x| LOUD * x).collect();
            loud.put_f32(name, &shape, values).unwrap();
        } else {
            loud.put(name, entry.clone()).unwrap();
        }
    }
    let loud = ControllerFile::new(quiet.meta(KIND).unwrap(), &loud, None, &robot()).unwrap();
    (trainer.policy(), Controller::new(loud, robot()).unwrap())
}

fn of(clips: &[&str]) -> TeacherSpec {
    TeacherSpec { policy: "a teacher".into(), clips: clips.iter().map(ToString::to_string).collect() }
}

/// Eight environments, of either clip, that are told lies about their joints.
fn pupil() -> TrackerPlan {
    let mut plan = TrackerPlan { teachers: vec![of(&["cal*"]), of(&[])], ..plan(8) };
    plan.sensors.joint_position_noise = 0.3;
    plan.network.actor = vec![24];
    plan.ppo.initial_std = 0.3;
    plan.ppo.learning_rate = 3e-3;
    plan
}

#[test]
fn each_teacher_says_for_its_clips_what_it_would_do_in_the_true_state() {
    let mut without_future = plan(3);
    without_future.inputs.future = vec![];
    let ((first, a), (second, b)) = (teacher(&plan(3)), teacher(&without_future));
    let mut e = environment(&pupil());
    let mut taught = vec![7.0];
    e.teach(&mut taught).unwrap();
    assert_eq!(taught, [7.0], "no teachers, no advice");
    e.set_teachers(vec![a, b]).unwrap();
    let starts: Vec<Start> = [40, 160, 20, 170, 0, 150, 249, 149].map(Start::at).into();
    e.reset(&(0..8).collect::<Vec<_>>(), Some(&starts)).unwrap();
    e.teach(&mut taught).unwrap();
    assert_eq!((taught.len(), taught[0]), (1 + 8 * 2, 7.0), "appended, a row for each environment");

    // The same states, observed by each teacher's own layout without noise: environments of its own plan.
    let truth = |plan: &TrackerPlan, policy: &Policy| {
        let mut other = environment(&TrackerPlan { ppo: pupil().ppo, inputs: plan.inputs.clone(), ..plan.clone() });
        other.reset(&(0..8).collect::<Vec<_>>(), Some(&starts)).unwrap();
        policy.outputs(other.actor_rows().to_vec()).unwrap()
    };
    let (calm, wild) = (truth(&plan(8), &first), truth(&without_future, &second));
    for (i, start) in starts.iter().enumerate() {
        let expected = if start.frame < 150 { &calm } else { &wild };
        for k in 2 * i..2 * i + 2 {
            assert!(
                (taught[1 + k] - LOUD * expected[k]).abs() < 1e-4,
                "environment {i}: {} {}",
                taught[1 + k],
                expected[k]
            );
        }
    }
    assert!(calm.iter().zip(&wild).any(|(a, b)| (a - b).abs() > 1e-4), "they say different things");
}

#[test]
fn a_teacher_that_corrects_the_reference_teaches_targets_to_one_that_says_them() {
    let (_, controller) = teacher(&plan(3));
    let library = library(&robot());
    let starts: Vec<Start> = [40, 160, 20, 170, 0, 155, 249, 147].map(Start::at).into();
    let pupils = |action: ActionSpec| {
        let mut e = environment(&TrackerPlan { action, teachers: vec![of(&[])], ..pupil() });
        e.set_teachers(vec![controller.clone()]).unwrap();
        e.reset(&(0..8).collect::<Vec<_>>(), Some(&starts)).unwrap();
        e
    };
    let advice = |e: &mut Environment, map: &ActionMap| {
        let mut taught = Vec::new();
        e.teach(&mut taught).unwrap();
        let mut targets = vec![0.0; taught.len()];
        let rows = taught.chunks_exact(2).zip(targets.chunks_exact_mut(2)).zip(e.episodes());
        for ((output, target), episode) in rows {
            map.write(output, library.joints_at(library.ahead(episode.frame, 1)), target);
        }
        (taught, targets)
    };
    let actions = [plan(3).action, ActionSpec::DefaultPose { scale: 0.5 }];
    let [mut one, mut other] = actions.map(&pupils);
    let [corrects, says] = actions.map(|action| ActionMap::new(action, &robot()));
    // Whatever both did before, said in either way, is what the teacher believes to have done.
    for steps in 0..4 {
        let (corrections, expected) = advice(&mut one, &corrects);
        let (outputs, targets) = advice(&mut other, &says);
        assert!(outputs.iter().zip(&corrections).any(|(a, b)| (a - b).abs() > 1e-2), "other outputs");
        let apart = targets.iter().zip(&expected).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        assert!(apart < 1e-4, "step {steps}: {apart}");
        one.step(&corrections, &mut StepOutcome::default()).unwrap();
        other.step(&outputs, &mut StepOutcome::default()).unwrap();
    }
}

#[test]
fn a_pupil_learns_what_its_teachers_do_and_goes_on_bit_for_bit() {
    let plan = TrackerPlan { sensors: SensorSpec::default(), teachers: vec![of(&[])], ..pupil() };
    let teachers = || vec![teacher(&super::plan(3)).1];
    let mut pupil = trainer(&plan).taught_by(teachers()).unwrap();
    let first = pupil.iterate().unwrap();
    for _ in 0..300 {
        pupil.iterate().unwrap();
    }
    let checkpoint = pupil.checkpoint().unwrap();
    let last = pupil.iterate().unwrap();
    let [first_kl, last_kl] = [first, last].map(|report| report.imitation.unwrap());
    assert!(last_kl < 0.1 * first_kl, "KL(teacher ‖ pupil): {first_kl} at first, {last_kl} at last");
    assert_eq!((first.surrogate, first.learning_rate, last.learning_rate), (0.0, 3e-3, 3e-3), "no trust region");
    assert!((last.std - 0.3).abs() < 1e-6, "imitation says nothing about exploration");
    assert!(last.explained_variance != 0.0, "the value function learns from rewards");

    let mut again = trainer(&plan).taught_by(teachers()).unwrap();
    again.restore(&checkpoint).unwrap();
    assert_eq!(again.iterate().unwrap().imitation, last.imitation);
    assert_eq!(again.policy().to_checkpoint().unwrap().entries(), pupil.policy().to_checkpoint().unwrap().entries());
    let identity = |trainer: &Trainer| lifelike_train::TrainingTask::identity(trainer);
    let others = trainer(&plan).taught_by(vec![teacher(&super::plan(4)).1]).unwrap();
    assert_ne!(identity(&pupil), identity(&others), "a run is not gone on with by other teachers");
}

#[test]
fn teachers_that_do_not_fit_are_refused_by_name() {
    let (_, good) = teacher(&plan(3));
    let refused = |plan: &TrackerPlan, controllers: Vec<Controller>| {
        trainer(plan).taught_by(controllers).map(|_| ()).unwrap_err().to_string()
    };
    assert!(refused(&pupil(), vec![good.clone()]).contains("expected 2, got 1"));
    let one = TrackerPlan { teachers: vec![of(&["calm"])], ..pupil() };
    assert!(refused(&one, vec![good]).contains("none of 'wild'"));
}
