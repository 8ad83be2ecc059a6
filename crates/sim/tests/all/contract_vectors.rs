//! Instruction sets, the width of vectors and neighbours in them are a matter of speed: no bit depends on them.
use std::sync::Arc;

use crate::world::{targets, vary};
use lifelike_character::Character;
use lifelike_robot::Robot;
use lifelike_sim::{BatchState, Drive, IntegrationState, LifelikeSimulation, Simulation, Terrain};
use lifelike_simd::InstructionSet;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Lima, whose parts touch each other.
fn lima() -> Arc<Robot> {
    let mut robot = Robot::load("lima").unwrap();
    let text = robot.character.mjcf.clone().unwrap();
    let text = text.replace("contype=\"0\" conaffinity=\"1\"", "contype=\"1\" conaffinity=\"1\"");
    robot.character = Character::from_mjcf(&text, "lima", None).unwrap().into();
    assert!(lifelike_sim::engine::self_contacts(&robot) > 10);
    Arc::new(robot)
}

/// Some environments on hills, each with parameters, a push, a crumpled pose and targets by its own number: their outputs at
/// some steps and their states at the end.
fn run(instructions: InstructionSet, environments: &[usize], threads: usize) -> (Vec<BatchState>, IntegrationState) {
    let (robot, n) = (lima(), environments.len());
    let terrain = Arc::new(Terrain::hills(10.0, 0.1, 0.2, 2.0, 1).unwrap());
    let simulation = LifelikeSimulation::with_instructions(instructions, robot.clone(), n, threads).unwrap();
    let mut simulation = simulation.with_terrain(terrain);
    for (id, e) in environments.iter().enumerate() {
        let mut rng = ChaCha8Rng::seed_from_u64(*e as u64);
        let mut q = robot.default_position();
        // Some stand beyond the edge of the ground, and fall.
        let reach = if e.is_multiple_of(5) { 7.0 } else { 3.0 };
        (q[0], q[1]) = (rng.random_range(-reach..reach), rng.random_range(-reach..reach));
        q[2] += rng.random_range(0.0..0.3);
        q[7..].iter_mut().for_each(|x| *x += rng.random_range(-0.6..0.6));
        simulation.reset(&[id], &q, &vec![0.0; robot.character.nv]).unwrap();
    }
    vary(&mut simulation, environments);
    let mut states = Vec::new();
    for t in 0..40 {
        simulation.step(Drive::Targets(&targets(&robot, environments, t))).unwrap();
        if t % 10 == 9 {
            states.push(simulation.state().clone());
        }
    }
    (states, simulation.save())
}

#[test]
fn the_instruction_set_changes_no_bit() {
    let environments: Vec<usize> = (0..37).collect();
    let expected = run(InstructionSet::Portable, &environments, 2);
    assert!(expected.0[3].foot_force.iter().any(|f| *f > 0.0));
    for set in InstructionSet::available() {
        let got = run(set, &environments, 1);
        for (step, (expected, got)) in expected.0.iter().zip(&got.0).enumerate() {
            assert!(expected == got, "{set}: outputs {step}");
        }
        assert!(expected.1 == got.1, "{set}: states");
    }
}

/// What is left out because it concerns no environment of a vector is looked for in the neighbours, and never shows.
#[test]
fn neighbours_change_no_bit() {
    let environments: Vec<usize> = (0..37).collect();
    let permuted: Vec<usize> = (0..37).map(|i| (i * 7 + 3) % 37).collect();
    for set in InstructionSet::available() {
        let (_, straight) = run(set, &environments, 1);
        let (_, other) = run(set, &permuted, 3);
        let row = |state: &IntegrationState, id: usize| state.values[id * state.width..(id + 1) * state.width].to_vec();
        for (place, e) in permuted.iter().enumerate() {
            assert_eq!(row(&straight, *e), row(&other, place), "{set}: environment {e} in place {place}");
        }
        for e in (0..37).step_by(9) {
            let (_, alone) = run(set, &[e], 1);
            assert_eq!(row(&straight, e), row(&alone, 0), "{set}: environment {e} alone");
        }
    }
}
