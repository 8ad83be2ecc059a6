//! Our engine against MuJoCo.
#![cfg(feature = "mujoco")]
#![allow(clippy::unwrap_used, clippy::expect_used)]

use std::sync::Arc;

use lifelike_character::JointKind;
use lifelike_robot::Robot;
use lifelike_sim::engine::LaneSimulation;
use lifelike_sim::{Drive, MujocoSimulation, Simulation};
use mujoco_rs::mujoco_c::mjtDisableBit;
use mujoco_rs::prelude::{MjData, MjModel};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// A position anywhere within the ranges, the root at a height and turned anyhow, and velocities.
fn random_state(robot: &Robot, rng: &mut ChaCha8Rng, height: f64) -> (Vec<f64>, Vec<f64>) {
    let character = &robot.character;
    let mut q = robot.default_position();
    for joint in &character.joints {
        match joint.kind {
            JointKind::Free => {
                let wxyz: [f64; 4] = std::array::from_fn(|_| rng.random_range(-1.0..1.0));
                let norm = wxyz.iter().map(|x| x * x).sum::<f64>().sqrt();
                q[joint.q_index] = rng.random_range(-3.0..3.0);
                q[joint.q_index + 1] = rng.random_range(-3.0..3.0);
                q[joint.q_index + 2] = height;
                for (k, x) in wxyz.into_iter().enumerate() {
                    q[joint.q_index + 3 + k] = x / norm;
                }
            }
            _ => {
                let (low, high) = joint.range.unwrap_or((-1.0, 1.0));
                q[joint.q_index] = rng.random_range(low..high);
            }
        }
    }
    let v = (0..character.nv).map(|_| rng.random_range(-3.0..3.0)).collect();
    (q, v)
}

fn mujoco(robot: &Robot) -> MjData<Box<MjModel>> {
    let mut model = MjModel::from_xml_string(robot.character.mjcf.as_deref().unwrap()).unwrap();
    model.opt_mut().timestep = robot.timestep();
    model.opt_mut().disableflags |= mjtDisableBit::mjDSBL_ACTUATION as i32;
    MjData::new(Box::new(model))
}

/// ‖a − b‖ / ‖b‖.
fn relative(a: &[f64], b: &[f64]) -> f64 {
    let norm = |x: &mut dyn Iterator<Item = f64>| x.map(|x| x * x).sum::<f64>().sqrt();
    norm(&mut a.iter().zip(b).map(|(a, b)| a - b)) / norm(&mut b.iter().copied()).max(1e-12)
}

#[test]
fn masses_bias_and_accelerations_are_mujocos() {
    for name in ["lima", "humanoid"] {
        let robot = Arc::new(Robot::load(name).unwrap());
        let mut double = LaneSimulation::<f64, 4>::new(robot.clone(), 1, 1).unwrap();
        let mut single = LaneSimulation::<f32, 8>::new(robot.clone(), 1, 1).unwrap();
        let mut data = mujoco(&robot);
        let mut rng = ChaCha8Rng::seed_from_u64(7);
        let nv = robot.character.nv;
        let mut worst = [[0.0_f64; 3]; 2];
        for _ in 0..1000 {
            let (q, v) = random_state(&robot, &mut rng, 50.0);
            let applied: Vec<f64> = (0..nv).map(|_| rng.random_range(-5.0..5.0)).collect();
            data.qpos_mut().copy_from_slice(&q);
            data.qvel_mut().copy_from_slice(&v);
            data.qfrc_applied_mut().copy_from_slice(&applied);
            data.forward();
            let mut mass = vec![0.0; nv * nv];
            data.full_m(&mut mass).unwrap();
            let expected = [mass, data.qfrc_bias().to_vec(), data.qacc_smooth().to_vec()];
            let results = [double.dynamics(&q, &v, &applied), single.dynamics(&q, &v, &applied)];
            for (worst, got) in worst.iter_mut().zip(results) {
                let got = got.unwrap();
                for ((worst, got), expected) in worst.iter_mut().zip([got.0, got.1, got.2]).zip(&expected) {
                    *worst = worst.max(relative(&got, expected));
                }
            }
        }
        println!("{name}: mass, bias, acceleration: f64 {:?}, f32 {:?}", worst[0], worst[1]);
        assert!(worst[0].iter().all(|x| *x < 1e-10) && worst[1].iter().all(|x| *x < 1e-5), "{name} {worst:?}");
    }
}

/// Both engines from the same state under the same targets.
fn together(name: &str, n: usize) -> (Arc<Robot>, MujocoSimulation, LaneSimulation<f64, 4>, LaneSimulation<f32, 8>) {
    let robot = Arc::new(Robot::load(name).unwrap());
    let oracle = MujocoSimulation::new(robot.clone(), n, 2).unwrap();
    let double = LaneSimulation::new(robot.clone(), n, 1).unwrap();
    let single = LaneSimulation::new(robot.clone(), n, 1).unwrap();
    (robot, oracle, double, single)
}

#[test]
fn short_rollouts_on_the_ground_stay_together() {
    for name in ["lima", "humanoid"] {
        let n = 200;
        let (robot, mut oracle, mut double, mut single) = together(name, n);
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let (mut positions, mut velocities) = (Vec::new(), Vec::new());
        for _ in 0..n {
            let mut q = robot.default_position();
            for x in &mut q[7..] {
                *x += rng.random_range(-0.1..0.1);
            }
            q[2] += rng.random_range(-0.003..0.01);
            positions.extend(q);
            velocities.extend((0..robot.character.nv).map(|_| rng.random_range(-0.3..0.3)));
        }
        let ids: Vec<usize> = (0..n).collect();
        for simulation in [&mut oracle as &mut dyn Simulation, &mut double, &mut single] {
            simulation.reset(&ids, &positions, &velocities).unwrap();
        }
        let targets: Vec<f32> = (0..n * robot.joints())
            .map(|i| robot.default_pose[i % robot.joints()] as f32 + rng.random_range(-0.3..0.3))
            .collect();
        for step in 0..10 {
            for simulation in [&mut oracle as &mut dyn Simulation, &mut double, &mut single] {
                simulation.step(Drive::Targets(&targets)).unwrap();
            }
            let rms = |a: &dyn Simulation, b: &dyn Simulation| {
                let pairs = a.state().joint_position.iter().zip(&b.state().joint_position);
                (pairs.map(|(a, b)| f64::from(a - b).powi(2)).sum::<f64>() / (n * robot.joints()) as f64).sqrt()
            };
            let force = |s: &dyn Simulation| s.state().foot_force.iter().map(|f| f64::from(*f)).sum::<f64>() / n as f64;
            println!(
                "{name} {step}: rms rad f64 {:.1e} f32 {:.1e}, between ours {:.1e}; foot force {:.2} {:.2}",
                rms(&oracle, &double),
                rms(&oracle, &single),
                rms(&double, &single),
                force(&oracle),
                force(&double)
            );
        }
    }
}
