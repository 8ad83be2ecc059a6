//! Promises of a run on the simulated machine, in virtual time.
#![allow(clippy::unwrap_used)]

use std::path::Path;
use std::sync::Arc;

use lifelike_robot::{Controller, GetUpScript, Robot};
use lifelike_runtime::{Config, Phase, Playlist, Request, Summary, Supervisor, VirtualClock, drive};
use lifelike_sim::SimulationSpec;

use super::{MemoryBus, SensorOptions, SimulatedRobot, stepwise};

/// Runs lima for some seconds of standing, pushed over at 4 s; returns its phases, the account and the root's height.
fn pushed(gets_up: bool, seconds: f64) -> (Vec<Phase>, Summary, f32) {
    let robot = Arc::new(Robot::load("lima").unwrap());
    let fine = Arc::new(stepwise(&robot).unwrap());
    let options = SensorOptions { noise: 0.0005, bias: 0.0, seed: 1, battery: 24.0, has_external: false, gantry: 2.2 };
    let push = "push@4".parse::<super::Scheduled>().unwrap().of(&robot).unwrap();
    let simulation = SimulationSpec::new(1).build(fine).unwrap();
    let machine = SimulatedRobot::new(&robot, simulation, options).with_faults(vec![push]);
    let asset = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/lima-blind.controller.safetensors");
    let controller = Arc::new(Controller::load(&asset, Arc::clone(&robot)).unwrap());
    let motions = Playlist::new(&controller, &[], 0.5 * seconds).unwrap();
    let supervisor = Supervisor::new(controller, motions, Config::default()).unwrap();
    let script = GetUpScript::parse(GetUpScript::builtin("lima").unwrap()).unwrap();
    let mut supervisor = if gets_up { supervisor.with_get_up(&script).unwrap() } else { supervisor };
    let mut bus = MemoryBus::new(machine, supervisor.config().command_hz);
    bus.settle();
    let mut phases = Vec::new();
    let summary = drive(&mut supervisor, &mut bus, &mut VirtualClock::default(), None, |_, phase| {
        phases.push(phase);
        Some(if phases.len() < 18_000 { Request::Run } else { Request::Stop })
    });
    phases.dedup();
    (phases, summary, bus.robot().simulation().state().root_position[2])
}

#[test]
fn a_robot_that_is_pushed_over_gets_up_and_goes_on_standing() {
    use Phase::{BlendIn, BlendOut, Damp, GetUp, Idle, Run, Stand};
    let (phases, summary, _) = pushed(true, 60.0);
    assert_eq!(phases, [Idle, Stand, BlendIn, Run, Damp, GetUp, Run, BlendOut, Damp], "{:?}", summary.trip);
    assert_eq!((summary.falls, summary.trip), (1, None));
}

#[test]
fn without_a_script_the_run_ends_where_the_robot_fell() {
    let (phases, summary, height) = pushed(false, 60.0);
    assert_eq!(phases.last(), Some(&Phase::Damp));
    assert!(summary.falls == 0 && summary.trip.is_some_and(|trip| trip.cause.is_fall()) && height < 0.25, "{height}");
}
