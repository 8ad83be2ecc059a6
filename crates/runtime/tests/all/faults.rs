//! Faults by the thousand: the gate brakes in time, and says why.
use crate::common;
use std::collections::BTreeMap;

use crate::common::{Fault, Plant};
use lifelike_checkpoint::rng::stream;
use lifelike_runtime::gate::Cause;
use lifelike_runtime::{Mode, Request, Summary, VirtualClock, drive};
use rand::Rng;

/// First tick of a fault: the policy drives from tick 400 on.
const BEGIN: usize = 500;

/// Runs a plant with a fault and returns the account, and the last tick in which motors were driven.
fn run(fault: Fault, from: usize, seed: u64) -> (Summary, usize) {
    thread_local! {
        static CONTROLLER: std::sync::Arc<lifelike_robot::Controller> = common::controller();
    }
    let mut supervisor =
        CONTROLLER.with(|controller| common::supervisor(controller, |config| config.limits.battery_min = 21.0));
    let mut plant = Plant::new(seed);
    (plant.fault, plant.from) = (fault, from);
    plant.watch = |plant, command| {
        for (j, actuator) in plant.robot.actuators.parameters.iter().enumerate() {
            assert!(command.kp()[j] <= actuator.kp as f32 && command.kd()[j] <= actuator.kd as f32);
            assert!(command.position()[j].is_finite());
        }
    };
    let summary = drive(&mut supervisor, &mut plant, &mut VirtualClock::default(), None, |_, _| Some(Request::Run));
    assert_eq!(plant.modes.last(), Some(&Mode::Off), "{fault:?}: every run ends with motors off");
    let last = plant.modes.iter().rposition(|mode| *mode == Mode::Position).unwrap_or(0);
    (summary, last)
}

/// Reasons that the gate may give, and the longest time until it brakes (ticks); none: the run goes on.
fn expected(fault: Fault) -> Option<(&'static [Cause], usize)> {
    match fault {
        Fault::Delay(ticks) if ticks <= 40 => None,
        Fault::None | Fault::Drop(_) | Fault::Duplicate | Fault::Reorder => None,
        Fault::Delay(_) => Some((&[Cause::Lost, Cause::Delayed], 120)),
        Fault::NotANumber(_) => Some((&[Cause::NonFinite], 55)),
        Fault::Frozen(_) => Some((&[Cause::FrozenEncoder], usize::MAX)),
        // Joints with like readings first drive each other away.
        Fault::Swapped(..) => Some((&[Cause::EncoderJump, Cause::Velocity, Cause::Tracking], usize::MAX)),
        Fault::Kill | Fault::Reboot => Some((&[Cause::Lost], 55)),
        Fault::ClockJump(_) => Some((&[Cause::ClockJump, Cause::Delayed], 3)),
        Fault::Hot(_) => Some((&[Cause::Temperature], usize::MAX)),
        Fault::Button => Some((&[Cause::Button], 3)),
        Fault::Topple => Some((&[Cause::Tilt], 600)),
        Fault::Battery => Some((&[Cause::Battery], usize::MAX)),
        Fault::Dead(_) => Some((&[Cause::Tracking, Cause::EncoderJump], usize::MAX)),
    }
}

#[test]
fn without_a_fault_a_run_comes_to_its_end() {
    let (summary, _) = run(Fault::None, 0, 1);
    assert_eq!(summary.trip, None);
    // 0.5 s of standing before and after, 50 steps a second, and blending out.
    assert!((45..70).contains(&summary.steps), "{}", summary.steps);
    assert_eq!((summary.missed, summary.unsent), (0, 0));
}

#[test]
fn each_fault_is_judged_as_it_should_be() {
    let mut counts: BTreeMap<&str, [usize; 3]> = BTreeMap::new();
    for case in 0..2_000u64 {
        let mut rng = stream(7, "faults", 0, case);
        let joint = rng.random_range(0..20);
        let (name, fault) = match case % 13 {
            0 => ("drop", Fault::Drop(rng.random_range(0.0..0.5))),
            1 => ("delay to 40 ms", Fault::Delay(rng.random_range(1..=40))),
            2 => ("delay beyond 60 ms", Fault::Delay(rng.random_range(60..150))),
            3 => ("duplicate", Fault::Duplicate),
            4 => ("reorder", Fault::Reorder),
            5 => ("not a number", Fault::NotANumber(joint)),
            // A bent knee and a joint that is bent the other way. While a robot stands, joints of one angle cannot be told apart.
            6 => ("swapped joints", Fault::Swapped(3, [2, 4, 7, 9, 15, 19, 2, 4][joint % 8])),
            7 => ("kill of the bus", Fault::Kill),
            8 => ("clock jump", Fault::ClockJump(rng.random_range(0.1..100.0))),
            9 => ("clock jump back", Fault::ClockJump(-rng.random_range(0.1..100.0))),
            10 => ("stop button", Fault::Button),
            11 => ("reboot", Fault::Reboot),
            _ => ("topple", Fault::Topple),
        };
        let from = BEGIN + rng.random_range(0..20);
        let (summary, last) = run(fault, from, case);
        let count = counts.entry(name).or_default();
        count[0] += 1;
        match (expected(fault), summary.trip) {
            (None, trip) => assert_eq!(trip, None, "{name} {fault:?}"),
            (Some((causes, within)), Some(trip)) => {
                assert!(causes.contains(&trip.cause), "{name} {fault:?}: {trip:?}");
                assert!(last <= from.saturating_add(within), "{name}: drove {} ticks on", last - from);
                count[1] += 1;
                count[2] = count[2].max(last.saturating_sub(from));
            }
            (Some(_), None) => panic!("{name} {fault:?}: no trip"),
        }
    }
    for (name, [runs, trips, latest]) in &counts {
        println!("{name:20} {runs:5} runs {trips:5} braked, at most {latest} ms later");
    }
}

#[test]
fn slow_faults_are_found_too() {
    let controller = common::controller();
    for fault in [Fault::Frozen(3), Fault::Hot(2), Fault::Battery, Fault::Dead(3)] {
        let mut supervisor = common::supervisor(&controller, |config| config.limits.battery_min = 21.0);
        let mut plant = Plant::new(3);
        (plant.fault, plant.from) = (fault, 250);
        // The frozen and the dead joint are asked to move by a policy that stands: longer, with a push of the target.
        let motions = lifelike_runtime::Playlist::new(&controller, &[bent()], 0.2).unwrap();
        supervisor =
            lifelike_runtime::Supervisor::new(controller.clone(), motions, supervisor.config().clone()).unwrap();
        let mut clock = VirtualClock::default();
        let summary = drive(&mut supervisor, &mut plant, &mut clock, None, |_, _| Some(Request::Run));
        let trip = summary.trip.unwrap_or_else(|| panic!("{fault:?}: no trip"));
        let (causes, _) = expected(fault).unwrap();
        assert!(causes.contains(&trip.cause), "{fault:?}: {trip:?}");
        println!("{fault:?}: {}", trip.words(&plant.robot.layout.joints));
    }
}

/// Knees that bend deeply, once in four seconds.
fn bent() -> lifelike_motion::MotionClip {
    let robot = common::lima();
    let mut clip = lifelike_robot::reference::standing_clip(&robot, 4.0);
    let joints = clip.joint_names.len();
    for (i, row) in clip.joints.chunks_exact_mut(joints).enumerate() {
        for (j, angle) in row.iter_mut().enumerate().filter(|(j, _)| robot.layout.joints[*j].ends_with("knee")) {
            assert!(j < joints);
            *angle = 1.3 + 0.9 * (std::f64::consts::TAU * 0.25 * i as f64 / clip.fps).sin();
        }
    }
    clip.name = "bent".into();
    clip
}
