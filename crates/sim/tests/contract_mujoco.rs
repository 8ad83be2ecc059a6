//! Promises of the MuJoCo engine.
#![cfg(feature = "mujoco")]
#![allow(clippy::unwrap_used, clippy::expect_used)]

use std::sync::Arc;

use lifelike_robot::Robot;
use lifelike_sim::{BatchState, Drive, EnvironmentParameters, MujocoSimulation, Simulation};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

fn lima() -> Arc<Robot> {
    Arc::new(Robot::load("lima").unwrap())
}

/// Targets around the default pose; environment `e` of step `t` gets the same whatever the batch.
fn targets(robot: &Robot, environments: &[usize], t: usize) -> Vec<f32> {
    let mut out = Vec::new();
    for &e in environments {
        let mut rng = ChaCha8Rng::seed_from_u64((e * 10_000 + t) as u64);
        out.extend(robot.default_pose.iter().map(|&q| q as f32 + rng.random_range(-0.3..0.3)));
    }
    out
}

/// Different masses, friction and pushes, by the environment's own number.
fn vary(simulation: &mut MujocoSimulation, environments: &[usize]) {
    let bodies = simulation.robot().character.bodies.len();
    for (id, &e) in environments.iter().enumerate() {
        let mut rng = ChaCha8Rng::seed_from_u64(e as u64);
        if e % 3 != 0 {
            let parameters = EnvironmentParameters {
                mass_scale: (0..bodies).map(|_| rng.random_range(0.9..1.1)).collect(),
                ground_friction: (e % 2 == 0).then(|| rng.random_range(0.3..1.2)),
                joint_offset: Vec::new(),
            };
            simulation.set_parameters(id, parameters).unwrap();
        }
        if e % 4 == 1 {
            simulation.push(id, 1, [rng.random_range(-30.0..30.0), 5.0, 0.0], [0.0, 1.0, 0.0]).unwrap();
        }
    }
}

fn run(environments: &[usize], threads: usize, steps: usize) -> (Vec<BatchState>, MujocoSimulation) {
    let robot = lima();
    let mut simulation = MujocoSimulation::new(robot.clone(), environments.len(), threads).unwrap();
    vary(&mut simulation, environments);
    let mut states = Vec::new();
    for t in 0..steps {
        simulation.step(Drive::Targets(&targets(&robot, environments, t))).unwrap();
        states.push(simulation.state().clone());
    }
    (states, simulation)
}

#[test]
fn the_number_of_threads_changes_no_bit() {
    let environments: Vec<usize> = (0..37).collect();
    let (one, saved) = run(&environments, 1, 40);
    for threads in [2, 3] {
        let (other, simulation) = run(&environments, threads, 40);
        assert!(one == other, "{threads} threads");
        assert_eq!(saved.save(), simulation.save());
    }
}

#[test]
fn the_place_in_the_batch_changes_no_bit() {
    let straight: Vec<usize> = (0..19).collect();
    let permuted: Vec<usize> = (0..19).map(|i| (i * 7 + 3) % 19).collect();
    let (a, _) = run(&straight, 1, 30);
    let (b, _) = run(&permuted, 2, 30);
    let joints = lima().joints();
    for (a, b) in a.iter().zip(&b) {
        for (place, &e) in permuted.iter().enumerate() {
            let row = |v: &[f32], id: usize, n: usize| v[id * n..(id + 1) * n].to_vec();
            assert_eq!(row(&a.root_position, e, 3), row(&b.root_position, place, 3));
            assert_eq!(row(&a.joint_velocity, e, joints), row(&b.joint_velocity, place, joints));
            assert_eq!(row(&a.torque_squared, e, joints), row(&b.torque_squared, place, joints));
            assert_eq!(row(&a.foot_force, e, 2), row(&b.foot_force, place, 2));
        }
    }
}

#[test]
fn a_saved_state_continues_bit_for_bit() {
    let environments: Vec<usize> = (0..11).collect();
    let (whole, end) = run(&environments, 2, 50);
    let (_, half) = run(&environments, 1, 20);
    let saved = half.save();
    let robot = lima();
    let mut resumed = MujocoSimulation::new(robot.clone(), 11, 3).unwrap();
    // A past of its own, which must not show.
    for t in 0..7 {
        resumed.step(Drive::Targets(&targets(&robot, &environments, 900 + t))).unwrap();
    }
    resumed.restore(&saved).unwrap();
    assert_eq!(resumed.state().root_position, whole[19].root_position);
    assert_eq!(resumed.state().place_position, whole[19].place_position);
    for t in 20..50 {
        resumed.step(Drive::Targets(&targets(&robot, &environments, t))).unwrap();
        assert!(*resumed.state() == whole[t], "step {t}");
    }
    assert_eq!(resumed.save(), end.save());
}
