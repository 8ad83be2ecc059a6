//! Records of a frozen controller.

use lifelike_robot::Controller;
use lifelike_train::{RewardRecords, StepEnd};

use super::*;

fn controller() -> Controller {
    let robot = robot();
    let policy = frozen::trained(&robot, &[16], None).to_checkpoint().unwrap();
    Controller::from_policy(&policy, None, robot).unwrap()
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
