//! What an evaluation promises, on the two-jointed robot whose joints follow their targets.

#![allow(clippy::unwrap_used)]

use std::sync::Arc;

use lifelike_character::{Quat, Vec3};
use lifelike_motion::{MotionClip, Provenance};
use lifelike_robot::ActionSpec;

use super::{Cause, Evaluation, EvaluationOptions, Outcome, evaluate};
use lifelike_robot::ReferenceLibrary;
use lifelike_sim::testing::{Followers, robot};
use lifelike_tracking::{Policy, TrackerPlan, Trainer};

pub(super) fn clip(name: &str, seconds: f64, cyclic: bool) -> MotionClip {
    let frames = (seconds * 50.0) as usize + 1;
    let angle = |i: usize| 0.3 * (i as f64 / (frames - 1) as f64 * std::f64::consts::TAU).sin();
    MotionClip {
        name: name.into(),
        fps: 50.0,
        joint_names: vec!["hip".into(), "knee".into()],
        root_position: (0..frames).map(|i| Vec3::new(2.0 + 0.01 * i as f64, 1.0, 0.5)).collect(),
        root_orientation: vec![Quat::from_axis_angle(&Vec3::z_axis(), 0.4); frames],
        joints: (0..frames).flat_map(|i| [angle(i), -angle(i)]).collect(),
        contacts: None,
        cyclic,
        provenance: Provenance::default(),
    }
}

/// A policy that was never trained; with a tiny `scale` it asks for the reference itself.
pub(super) fn policy(scale: f64) -> Policy {
    let mut plan = TrackerPlan::new("post", &[]);
    plan.ppo.environments = 2;
    plan.ppo.minibatch = 4;
    plan.network.actor = vec![8];
    plan.network.critic = vec![8];
    plan.action = ActionSpec::Reference { scale };
    let library = Arc::new(ReferenceLibrary::standing(&robot(), 1.0).unwrap());
    Trainer::new(&plan, robot(), library, Box::new(Followers::new(2))).unwrap().policy()
}

fn run(policy: &Policy, clips: &[MotionClip], simulation: Followers, options: &EvaluationOptions) -> Evaluation {
    evaluate(policy, &robot(), clips, None, Box::new(simulation), options, |_, _| {}).unwrap()
}

#[test]
fn the_joints_of_a_follower_lag_and_nothing_else_is_wrong() {
    let options = EvaluationOptions { seconds: 3.0, starts: 2, keep: 1, after_fall: 0.5 };
    let clips = [clip("once", 2.0, false), clip("cycle", 1.0, true)];
    let e = run(&policy(1e-6), &clips, Followers::new(3), &options);
    let lengths: Vec<(f64, f64)> = e.episodes.iter().map(|s| (s.start, s.planned_seconds)).collect();
    // An episode that ends with its clip lacks the clip's last frame. A cycle goes on.
    assert_eq!(lengths, [(0.0, 1.98), (1.0, 0.98), (0.0, 3.0), (0.5, 3.0)]);
    assert_eq!((e.overall.survival, e.overall.covered), (1.0, 1.0));
    assert!(e.overall.joint_error_deg > 0.1 && e.overall.joint_error_deg < 10.0, "{}", e.overall.joint_error_deg);
    // The root keeps the velocity that it began with, and the clip goes straight on at that speed, through every
    // repetition: what is left is single precision, summed 150 times.
    assert!(e.overall.heading_drift_mean_deg < 1e-3);
    assert!(e.clips.iter().all(|c| c.position_drift_end_m < 1e-4), "{}", e.clips[1].position_drift_end_m);
    assert_eq!(e.rollouts.len(), 2, "one of each clip is kept");
    // The reference is laid where the robot began: at the origin, facing as in the clip.
    let first = &e.rollouts[0].reference[0];
    assert!((first.root_position - Vec3::new(0.0, 0.0, 0.5)).norm() < 1e-6, "{}", first.root_position);
    assert!(first.root_orientation.angle_to(&Quat::from_axis_angle(&Vec3::z_axis(), 0.4)) < 1e-6);
}

#[test]
fn scores_do_not_depend_on_how_many_run_at_once() {
    let options = EvaluationOptions { seconds: 1.0, starts: 3, keep: 0, after_fall: 0.5 };
    let clips = [clip("once", 2.0, false), clip("cycle", 1.0, true)];
    let of = |n: usize| serde_json::to_string(&run(&policy(0.5), &clips, Followers::new(n), &options)).unwrap();
    let alone = of(1);
    assert_eq!(alone, of(4));
    assert_eq!(alone, of(64));
}

#[test]
fn a_diverged_episode_has_fallen_and_its_neighbours_have_not() {
    let options = EvaluationOptions { seconds: 1.0, starts: 2, keep: 1, after_fall: 0.5 };
    let mut simulation = Followers::new(2);
    simulation.diverge = Some((1, 7));
    let e = run(&policy(1e-6), &[clip("once", 4.0, false)], simulation, &options);
    assert_eq!(e.episodes.iter().map(|s| s.survived).collect::<Vec<_>>(), [true, false]);
    let failure = e.failures().next().unwrap();
    assert_eq!((failure.cause, failure.second), (Cause::Diverged, 7.0 / 50.0));
    assert_eq!(e.episodes[1].frames, 6);
    assert_eq!(e.rollouts.len(), 2, "the first of the clip, and the first that fell");
    assert_eq!(e.rollouts[1].outcome, Outcome::Fell { frame: 7, cause: Cause::Diverged });
}

#[test]
fn a_policy_of_another_rate_is_refused() {
    let mut other = (*robot()).clone();
    other.control_hz = 30.0;
    let options = EvaluationOptions::default();
    let simulation = Box::new(Followers::new(1));
    let clips = [clip("once", 2.0, false)];
    let error = evaluate(&policy(1e-6), &Arc::new(other), &clips, None, simulation, &options, |_, _| {}).unwrap_err();
    assert!(error.to_string().contains("policy rate"), "{error}");
}
