//! Promises of an evaluation, on the two-jointed robot whose joints follow their targets.

#![allow(clippy::unwrap_used)]

use std::sync::Arc;

use lifelike_character::{Quat, Vec3};
use lifelike_checkpoint::Checkpoint;
use lifelike_motion::{MotionClip, Provenance};
use lifelike_robot::controller::{ControllerFile, ControllerHeader};
use lifelike_robot::{ActionSpec, AnchorSpec, Controller, ObservationSpec, ReferenceSpec, Robot};
use lifelike_sim::testing::{Followers, robot};
use lifelike_sim::{Simulation, SimulationSpec};

use super::{Cause, Evaluation, EvaluationOptions, EvaluationSetup, EvaluationSuite, Outcome};
use super::{ThesisEvaluation, ThesisProtocol};

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

/// A controller that was never trained; with a tiny `scale` it asks for the reference itself.
pub(super) fn controller(scale: f64) -> Controller {
    let robot = robot();
    let reference = ReferenceSpec { frame: true, ..ReferenceSpec::default() };
    let observation = ObservationSpec::new(&robot, reference, AnchorSpec { heading: true, position: true });
    let (size, joints) = (observation.size(), robot.joints());
    let header = ControllerHeader::new(&robot, observation, ActionSpec::Reference { scale }, vec![8]);
    let numbers =
        |count: usize, size: f32| (0..count).map(|i| (((i * 7919) % 97) as f32 / 48.0 - 1.0) * size).collect();
    let mut file = Checkpoint::new();
    for (i, [inputs, outputs]) in [[size, 8], [8, joints]].into_iter().enumerate() {
        let weight = numbers(inputs * outputs, 0.1);
        file.put_f32(&format!("actor.mean.layers.{i}.weight"), &[inputs, outputs], weight).unwrap();
        file.put_f32(&format!("actor.mean.layers.{i}.bias"), &[outputs], vec![0.0; outputs]).unwrap();
    }
    file.put_f64("normalizer.mean", &[size], vec![0.0; size]).unwrap();
    file.put_f64("normalizer.variance", &[size], vec![1.0; size]).unwrap();
    file.put_f64("normalizer.settings", &[4], vec![1.0, 1.0, 5.0, 1.0]).unwrap();
    Controller::new(ControllerFile::new(header, &file, None, &robot).unwrap(), robot).unwrap()
}

/// Evaluates in a simulation of so many environments.
fn run(controller: &Controller, clips: &[MotionClip], environments: usize, options: &EvaluationOptions) -> Evaluation {
    let simulate = |_, _| Ok(Box::new(Followers::new(environments)) as Box<dyn Simulation>);
    let setup = EvaluationSetup { controller, encoder: None, simulate: &simulate, environments };
    setup.evaluate(clips, options, |_, _| {}).unwrap()
}

#[test]
fn the_joints_of_a_follower_lag_and_nothing_else_is_wrong() {
    let options =
        EvaluationOptions { seconds: 3.0, starts: 2, keep: 1, after_fall: 0.5, ..EvaluationOptions::default() };
    let clips = [clip("once", 2.0, false), clip("cycle", 1.0, true)];
    let e = run(&controller(1e-6), &clips, 3, &options);
    let lengths: Vec<(f64, f64)> = e.episodes.iter().map(|s| (s.start, s.planned_seconds)).collect();
    // An episode that ends with its clip lacks the clip's last frame. A cycle goes on.
    assert_eq!(lengths, [(0.0, 1.98), (1.0, 0.98), (0.0, 3.0), (0.5, 3.0)]);
    assert_eq!((e.overall.survival, e.overall.covered), (1.0, 1.0));
    // Whoever falls was to go as far.
    let simulate = |_, _| Ok(Box::new(Followers::new(3)) as Box<dyn Simulation>);
    let setup = EvaluationSetup { controller: &controller(1e-6), encoder: None, simulate: &simulate, environments: 3 };
    let suite = EvaluationSuite::new(&setup, &clips, &options).unwrap();
    assert_eq!(suite.episodes().iter().map(|e| e.planned).collect::<Vec<_>>(), [100, 50, 151, 151]);
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

/// Evaluates by the thesis' protocol; from step 7 on, environment 1 diverges where `diverge` says so.
fn thesis(clips: &[MotionClip], environments: usize, protocol: &ThesisProtocol, diverge: bool) -> ThesisEvaluation {
    let simulate = |_, _| {
        let mut simulation = Followers::new(environments);
        simulation.diverge = diverge.then_some((1, 7));
        Ok(Box::new(simulation) as Box<dyn Simulation>)
    };
    let setup = EvaluationSetup { controller: &controller(1e-6), encoder: None, simulate: &simulate, environments };
    setup.evaluate_thesis(clips, protocol, |_, _| {}).unwrap()
}

#[test]
fn the_thesis_protocol_fills_its_time_whatever_the_clips_are_and_how_many_run_at_once() {
    let protocol = ThesisProtocol { episodes: 6, seconds: 4.0, seed: 3, ..ThesisProtocol::default() };
    let clips = [clip("one", 2.0, false), clip("two", 1.5, false)];
    let e = thesis(&clips, 2, &protocol, false);
    assert_eq!((e.errors.frames, e.errors.terminations, e.clips), (6 * 200, 0, 2));
    assert_eq!(e.protocol.distance, Some(0.3), "the robot's own");
    // The joints lag as they do in the other protocol; the root goes on at its speed, also across clips.
    let options = EvaluationOptions { seconds: 1.0, starts: 1, ..EvaluationOptions::default() };
    let lag = run(&controller(1e-6), &clips, 2, &options).overall.joint_error_deg;
    assert!((e.errors.joint_error_deg / lag - 1.0).abs() < 0.5, "{} and {lag}", e.errors.joint_error_deg);
    assert!(e.errors.root_velocity_error < 1e-3, "{}", e.errors.root_velocity_error);
    let json = |e: &ThesisEvaluation| serde_json::to_string(e).unwrap();
    assert_eq!(json(&e), json(&thesis(&clips, 5, &protocol, false)));
    let other = ThesisProtocol { seed: 4, ..protocol };
    assert_ne!(json(&e), json(&thesis(&clips, 2, &other, false)), "other frames");
}

#[test]
fn an_episode_that_deviates_or_diverges_goes_on_with_another_motion() {
    let clips = [clip("one", 2.0, false), clip("two", 1.5, false)];
    // Every deviation is too large: after 0.1 s of 5 frames the sixth ends the motion, 33 times in 200 frames.
    let strict = ThesisProtocol { episodes: 2, seconds: 4.0, distance: Some(1e-9), patience: 0.1, seed: 3 };
    let e = thesis(&clips, 2, &strict, false);
    assert_eq!(e.errors.frames, 400);
    assert!((40..=66).contains(&e.errors.terminations), "{}", e.errors.terminations);
    assert!((e.errors.terminations_per_minute - e.errors.terminations as f64 * 60.0 / 8.0).abs() < 1e-9);
    let lax = ThesisProtocol { distance: Some(10.0), ..strict.clone() };
    assert_eq!(thesis(&clips, 2, &lax, false).errors.terminations, 0);
    // A deviation lasts on from clip to clip: f is longer than either of them.
    let long = ThesisProtocol { seconds: 8.0, patience: 2.5, ..strict };
    assert!((2..=6).contains(&thesis(&clips, 2, &long, false).errors.terminations));
    // A state that is no state has no error, and ends the motion at once.
    let diverged = thesis(&clips, 2, &lax, true);
    assert!(diverged.errors.terminations >= 1, "{:?}", diverged.errors);
    assert_eq!(diverged.errors.frames + diverged.errors.terminations, 400);
    assert!(diverged.errors.joint_error_deg.is_finite());
}

#[test]
fn scores_do_not_depend_on_how_many_run_at_once() {
    let options =
        EvaluationOptions { seconds: 1.0, starts: 3, keep: 0, after_fall: 0.5, ..EvaluationOptions::default() };
    let clips = [clip("once", 2.0, false), clip("cycle", 1.0, true)];
    let of = |n: usize| serde_json::to_string(&run(&controller(0.5), &clips, n, &options)).unwrap();
    let alone = of(1);
    assert_eq!(alone, of(4));
    assert_eq!(alone, of(64));
}

#[test]
fn a_diverged_episode_has_fallen_and_its_neighbours_have_not() {
    let options =
        EvaluationOptions { seconds: 1.0, starts: 2, keep: 1, after_fall: 0.5, ..EvaluationOptions::default() };
    let simulate = |_, environments| {
        let mut simulation = Followers::new(environments);
        simulation.diverge = Some((1, 7));
        Ok(Box::new(simulation) as Box<dyn Simulation>)
    };
    let controller = controller(1e-6);
    let setup = EvaluationSetup { controller: &controller, encoder: None, simulate: &simulate, environments: 2 };
    let e = setup.evaluate(&[clip("once", 4.0, false)], &options, |_, _| {}).unwrap();
    assert_eq!(e.episodes.iter().map(|s| s.survived).collect::<Vec<_>>(), [true, false]);
    let failure = e.failures().next().unwrap();
    assert_eq!((failure.cause, failure.second), (Cause::Diverged, 7.0 / 50.0));
    assert_eq!(e.episodes[1].frames, 6);
    assert_eq!(e.rollouts.len(), 2, "the first of the clip, and the first that fell");
    assert_eq!(e.rollouts[1].outcome, Outcome::Fell { frame: 7, cause: Cause::Diverged });
}

#[test]
fn a_simulation_of_another_robot_is_refused() {
    let lima = Arc::new(Robot::load("lima").unwrap());
    let simulate = |_, n| SimulationSpec::new(n).build(Arc::clone(&lima));
    let controller = controller(1e-6);
    let setup = EvaluationSetup { controller: &controller, encoder: None, simulate: &simulate, environments: 1 };
    let clips = [clip("once", 2.0, false)];
    let error = setup.evaluate(&clips, &EvaluationOptions::default(), |_, _| {}).unwrap_err().to_string();
    assert!(error.contains("expected those of robot 'post', got those of 'lima'"), "{error}");
}
