//! What a twin promises: it is another robot than the nominal one, the same each time, and goes on from a saved state.

use std::path::Path;
use std::sync::Arc;

use lifelike_robot::Robot;
use lifelike_sim::twin::{Twin, TwinSpec};
use lifelike_sim::{Drive, Simulation, SimulationSpec};

fn robot(name: &str) -> Arc<Robot> {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../robot/robots/{name}.xml"));
    Arc::new(Robot::load(file.to_str().unwrap()).unwrap())
}

fn twin(robot: &Arc<Robot>, seed: u64, environments: usize, threads: usize) -> Twin {
    let spec = SimulationSpec { threads, ..SimulationSpec::new(environments) };
    Twin::new(robot, &TwinSpec { seed, ..TwinSpec::default() }, &spec).unwrap()
}

/// Targets that swing about the default pose, other ones in each environment.
fn targets(robot: &Robot, environments: usize, step: usize) -> Vec<f32> {
    let swing = |id: usize, j: usize| 0.3 * (step as f32 * 0.03 + j as f32 + 0.5 * id as f32).sin();
    let joints = 0..robot.joints();
    (0..environments).flat_map(|id| joints.clone().map(move |j| robot.default_pose[j] as f32 + swing(id, j))).collect()
}

fn run(simulation: &mut dyn Simulation, steps: std::ops::Range<usize>) -> Vec<f32> {
    let robot = simulation.robot().clone();
    for step in steps {
        simulation.step(Drive::Targets(&targets(&robot, simulation.len(), step))).unwrap();
    }
    assert!(simulation.state().diverged.iter().all(|diverged| !diverged));
    simulation.state().joint_position.clone()
}

#[test]
fn it_moves_like_the_nominal_robot_but_not_exactly() {
    for name in ["kickbot", "kickbot_foot", "dancebot", "lima"] {
        let robot = robot(name);
        let nominal = run(&mut *SimulationSpec::new(2).build(robot.clone()).unwrap(), 0..50);
        let (one, again) = (run(&mut twin(&robot, 1, 2, 1), 0..50), run(&mut twin(&robot, 1, 2, 2), 0..50));
        assert_eq!(one, again, "{name}: the same seed, whatever the threads");
        let other = run(&mut twin(&robot, 2, 2, 1), 0..50);
        assert_ne!(one, other, "{name}: another robot");
        let off = |a: &[f32]| nominal.iter().zip(a).map(|(x, y)| (x - y).abs()).sum::<f32>() / a.len() as f32;
        assert!((1e-3..0.3).contains(&off(&one)), "{name}: mean {} rad beside the nominal robot", off(&one));
    }
}

#[test]
fn it_goes_on_from_a_saved_state_bit_for_bit() {
    let robot = robot("lima");
    let mut twin = twin(&robot, 1, 3, 1);
    run(&mut twin, 0..7);
    let saved = twin.save();
    let (state, electric) = (twin.state().joint_velocity.clone(), twin.electric().to_vec());
    let expected = run(&mut twin, 7..20);
    let end = twin.save();
    twin.restore(&saved).unwrap();
    assert_eq!((twin.state().joint_velocity.clone(), twin.electric().to_vec()), (state, electric));
    assert_eq!(run(&mut twin, 7..20), expected);
    assert_eq!(twin.save(), end);
}

#[test]
fn encoders_have_steps_and_currents_are_ohms() {
    let robot = robot("kickbot");
    let mut twin = twin(&robot, 1, 1, 1);
    run(&mut twin, 0..100);
    let tick = std::f32::consts::TAU / 4096.0;
    for q in &twin.state().joint_position {
        assert!((q / tick - (q / tick).round()).abs() < 1e-2, "{q} is no reading of 12 bits");
    }
    assert!(twin.electric().iter().any(|own| own.current.abs() > 0.05));
    assert!(twin.electric().iter().all(|own| own.voltage.abs() <= 12.0));
}

/// What is reported is what firmware would make of the reported positions: their difference over 16 steps of 4 ms, in steps of 0.229 rpm.
#[test]
fn velocities_are_those_of_the_encoder_over_64_ms() {
    let robot = robot("kickbot");
    let mut twin = twin(&robot, 1, 1, 1);
    let mut positions: Vec<Vec<f64>> = Vec::new();
    let register = 0.229 * std::f64::consts::TAU / 60.0;
    let mut moved = 0.0_f64;
    for step in 0..60 {
        twin.step(Drive::Targets(&targets(&robot, 1, step))).unwrap();
        positions.push(twin.state().joint_position.iter().map(|q| f64::from(*q)).collect());
        let Some(before) = step.checked_sub(16) else { continue };
        for (j, velocity) in twin.state().joint_velocity.iter().enumerate() {
            let difference = (positions[step][j] - positions[before][j]) / 0.064;
            let expected = (difference / register).round() * register;
            assert!(
                (f64::from(*velocity) - expected).abs() < 1e-4,
                "joint {j}, step {step}: {velocity} for {expected}"
            );
            moved = moved.max(velocity.abs().into());
        }
    }
    assert!(moved > 0.1, "it moves");
}

#[test]
fn what_it_cannot_be_is_refused() {
    let robot = robot("kickbot");
    let torques = vec![0.0; 12];
    let text = twin(&robot, 1, 1, 1).step(Drive::Torques(&torques)).unwrap_err().to_string();
    assert!(text.contains("joint targets"), "{text}");
    for (spec, word) in [
        (TwinSpec { physics_hz: f64::NAN, ..TwinSpec::default() }, "'physics_hz' of a twin"),
        (TwinSpec { mass: -0.1, ..TwinSpec::default() }, "'mass' of a twin from 0 to 1"),
        (TwinSpec { velocity_window: -0.1, ..TwinSpec::default() }, "'velocity_window' of a twin from 0 to 1"),
        (TwinSpec { encoder_bits: 1, ..TwinSpec::default() }, "'encoder_bits' from 4 to 32"),
        (TwinSpec { resistance: f64::NAN, ..TwinSpec::default() }, "'resistance'"),
    ] {
        let text = Twin::new(&robot, &spec, &SimulationSpec::new(1)).err().unwrap().to_string();
        assert!(text.contains(word), "{text}");
    }
}
