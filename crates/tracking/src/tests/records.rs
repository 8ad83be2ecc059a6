//! Records of a frozen controller.

use lifelike_robot::Controller;
use lifelike_train::{RewardRecords, StepEnd};

use super::*;

fn controller() -> Controller {
    frozen::trained(&robot(), &[16], None).controller().unwrap()
}

fn recorded(plan: &TrackerPlan, steps: u64) -> RewardRecords {
    let controller = controller();
    let mut told = 0;
    let mut environment = environment(&plan.frozen(&controller, 6));
    let records = environment.record(&controller, steps, |done| told = done).unwrap();
    assert_eq!((told, records.len()), (steps, 6 * steps as usize));
    records
}

fn switching() -> TrackerPlan {
    let mut plan = restless();
    plan.termination.effector = Some(0.04);
    plan.episode.switch_clips = true;
    plan.episode.seconds = 4.0;
    plan
}

#[test]
fn frames_follow_each_other_until_a_clip_is_left_or_an_episode_ends() {
    let records = recorded(&switching(), 400);
    let (n, frames) = (records.environments, [150, 100]);
    let mut seen = [0; 4];
    for i in 0..records.len() - n {
        seen[records.end[i] as usize] += 1;
        let next = records.frame[i] + 1;
        assert!((next as usize) < frames[records.sequence[i] as usize], "a step ends within its clip");
        if records.end[i] == StepEnd::Continues {
            assert_eq!((records.sequence[i + n], records.frame[i + n]), (records.sequence[i], next));
        }
        if records.end[i] == StepEnd::Jumped {
            assert_eq!(next as usize, frames[records.sequence[i] as usize] - 1, "a clip is left at its end");
        }
    }
    assert!(seen.iter().all(|count| *count > 0), "{seen:?}");
    assert!(records.reward.iter().all(|reward| reward.is_finite()));
}

#[test]
fn the_number_of_threads_changes_no_record() {
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| recorded(&switching(), 100))
    };
    assert!(with(1) == with(3));
}

#[test]
fn a_controller_that_sees_something_else_is_refused() {
    let mut plan = restless().frozen(&controller(), 6);
    plan.anchor.position = false;
    let error = environment(&plan).record(&controller(), 1, |_| {}).unwrap_err().to_string();
    assert!(error.contains("observation of the controller"), "{error}");
    let mut plan = restless().frozen(&controller(), 6);
    plan.action = ActionSpec::DefaultPose { scale: 0.5 };
    assert!(environment(&plan).record(&controller(), 1, |_| {}).is_err());
}

#[test]
fn an_exact_share_of_the_steps_is_on_the_clips_that_environments_are_kept_for() {
    let controller = controller();
    let mut environment = environment(&switching().frozen(&controller, 6));
    environment.reserve(&[false, true], 1.0 / 3.0).unwrap();
    let records = environment.record(&controller, 300, |_| {}).unwrap();
    let of_second = records.sequence.iter().filter(|clip| **clip == 1).count();
    assert_eq!((of_second, records.len()), (600, 1800));
    assert!(environment.reserve(&[true, false], 1.5).unwrap_err().to_string().contains("share"));
    environment.reserve(&[true, true], 0.5).unwrap();
}

#[test]
fn a_start_in_another_frames_state_is_off_its_reference_and_has_time_to_reach_it() {
    let (controller, library) = (controller(), library(&robot()));
    let begun = |share: f64| {
        let mut plan = exact(switching().frozen(&controller, 40));
        plan.rsi.random_start_share = share;
        let environment = environment(&plan);
        let joints = environment.state().joint_position.chunks_exact(2);
        let off = joints.zip(environment.episodes()).filter(|(now, episode)| {
            now.iter().zip(library.joints_at(episode.frame)).any(|(a, b)| (a - b).abs() > 1e-6)
        });
        (environment.episodes().iter().filter(|episode| episode.grace > 0).count(), off.count())
    };
    assert_eq!(begun(0.0), (0, 0));
    let (grace, off) = begun(1.0);
    // Another frame may have the same joints, seldom.
    assert!(grace == 40 && off > 30, "{grace} {off}");
}
