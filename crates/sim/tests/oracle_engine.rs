//! Our engine against MuJoCo.
#![cfg(feature = "mujoco")]
#![allow(clippy::unwrap_used, clippy::expect_used)]

use std::sync::Arc;

use lifelike_character::JointKind;
use lifelike_robot::Robot;
use lifelike_sim::engine::LaneSimulation;
use lifelike_sim::{Drive, EnvironmentParameters, MujocoSimulation, Simulation};
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
                for ((worst, got), expected) in
                    worst.iter_mut().zip([got.mass, got.bias, got.acceleration]).zip(&expected)
                {
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

/// States near standing, feet about on the ground.
fn near_standing(robot: &Robot, n: usize, seed: u64) -> (Vec<f64>, Vec<f64>) {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
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
    (positions, velocities)
}

fn random_targets(robot: &Robot, n: usize, seed: u64) -> Vec<f32> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let joints = robot.joints();
    (0..n * joints).map(|i| robot.default_pose[i % joints] as f32 + rng.random_range(-0.3..0.3)).collect()
}

fn all(n: usize) -> Vec<usize> {
    (0..n).collect()
}

fn rms(a: &[f32], b: &[f32]) -> f64 {
    (a.iter().zip(b).map(|(a, b)| f64::from(a - b).powi(2)).sum::<f64>() / a.len() as f64).sqrt()
}

/// Gate 4 of the engine: 0.2 s of random targets from 1000 states, joints within 0.02 rad RMS.
#[test]
fn short_rollouts_on_the_ground_stay_together() {
    for name in ["lima", "humanoid"] {
        let n = 1000;
        let (robot, mut oracle, mut double, mut single) = together(name, n);
        let (positions, velocities) = near_standing(&robot, n, 3);
        let targets = random_targets(&robot, n, 4);
        for simulation in [&mut oracle as &mut dyn Simulation, &mut double, &mut single] {
            simulation.reset(&all(n), &positions, &velocities).unwrap();
            (0..10).for_each(|_| simulation.step(Drive::Targets(&targets)).unwrap());
        }
        let joints = |s: &dyn Simulation| s.state().joint_position.clone();
        let (exact, fast) = (rms(&joints(&oracle), &joints(&double)), rms(&joints(&oracle), &joints(&single)));
        println!("{name}: 0.2 s from {n} states, joints {exact:.1e} rad RMS off MuJoCo in f64, {fast:.1e} in f32");
        assert!(exact < 2e-3 && fast < 2e-3, "{name}: {exact}, {fast}");
    }
}

/// Gate 3: the impulse of one physics step in states that touch the ground.
#[test]
fn one_step_of_contact_is_mujocos() {
    for name in ["lima", "humanoid"] {
        let mut robot = Robot::load(name).unwrap();
        (robot.control_hz, robot.substeps) = (robot.control_hz * robot.substeps as f64, 1);
        let (robot, n) = (Arc::new(robot), 1000);
        let mut oracle = MujocoSimulation::new(robot.clone(), n, 2).unwrap();
        let mut ours = LaneSimulation::<f32, 8>::new(robot.clone(), n, 1).unwrap();
        let (mut positions, velocities) = near_standing(&robot, n, 11);
        positions.iter_mut().skip(2).step_by(robot.character.nq).for_each(|z| *z -= 0.008);
        let targets = random_targets(&robot, n, 12);
        for simulation in [&mut oracle as &mut dyn Simulation, &mut ours] {
            simulation.reset(&all(n), &positions, &velocities).unwrap();
            // The second step has a warm start.
            (0..2).for_each(|_| simulation.step(Drive::Targets(&targets)).unwrap());
        }
        let (a, b) = (&oracle.state().foot_force, &ours.state().foot_force);
        let weight = robot.character.mass() * robot.character.gravity.norm();
        let feet = a.len() / n;
        let (mut touching, mut total, mut worst) = (0, 0.0, 0.0_f64);
        for (a, b) in a.chunks(feet).zip(b.chunks(feet)) {
            let (a, b): (f64, f64) = (a.iter().map(|x| f64::from(*x)).sum(), b.iter().map(|x| f64::from(*x)).sum());
            if a > 0.05 * weight {
                touching += 1;
                total += (a - b).abs() / a;
                worst = worst.max((a - b).abs() / a);
            }
        }
        let mean = total / f64::from(touching);
        println!(
            "{name}: vertical force in {touching} touching states: {:.2}% off on average, {:.1}% at worst",
            100.0 * mean,
            100.0 * worst
        );
        assert!(touching > 200 && mean < 0.01 && worst < 0.05, "{name}: {touching}, {mean}, {worst}");
    }
}

/// A box of 2 kg with a small arm, on ground that `gravity` makes a slope.
fn sliding_box(friction: f64, slope: f64) -> Arc<Robot> {
    let (x, z) = (9.81 * slope.sin(), -9.81 * slope.cos());
    let text = format!(
        r#"<mujoco model="box">
  <compiler angle="radian"/>
  <option timestep="0.005" integrator="Euler" gravity="{x} 0 {z}" cone="pyramidal" iterations="50" tolerance="1e-10"/>
  <worldbody>
    <geom name="floor" type="plane" size="5 5 1" friction="{friction}"/>
    <body name="box" pos="0 0 0.05">
      <freejoint name="root"/>
      <geom name="box" type="box" size="0.1 0.08 0.05" mass="2" friction="{friction}"/>
      <body name="arm" pos="0 0 0.05">
        <joint name="arm" axis="0 0 1" range="-1 1" limited="true" armature="0.01"/>
        <geom name="arm" type="sphere" size="0.01" mass="0.01" contype="0" conaffinity="0"/>
      </body>
    </body>
  </worldbody>
</mujoco>"#
    );
    let character = lifelike_character::Character::from_mjcf(&text, "box.xml", None).unwrap();
    Arc::new(Robot::from_character(character, lifelike_robot::Profile::default()).unwrap())
}

fn slide(simulation: &mut dyn Simulation, seconds: f64) -> f64 {
    let robot = simulation.robot().clone();
    let steps = (seconds * robot.control_hz) as usize;
    let targets = vec![0.0; robot.joints()];
    (0..steps).for_each(|_| simulation.step(Drive::Targets(&targets)).unwrap());
    f64::from(simulation.state().root_position[0])
}

#[test]
fn boxes_stick_and_slip_on_slopes_as_they_should() {
    // Soft contacts creep: what sticks moves a little. Measured after the box has come to rest on its springs.
    let friction = 0.5_f64;
    let way = |slope: f64| {
        let mut ours = LaneSimulation::<f32, 8>::new(sliding_box(friction, slope), 1, 1).unwrap();
        let mut oracle = MujocoSimulation::new(sliding_box(friction, slope), 1, 1).unwrap();
        let settled = (slide(&mut ours, 1.5), slide(&mut oracle, 1.5));
        (slide(&mut ours, 1.0) - settled.0, slide(&mut oracle, 1.0) - settled.1)
    };
    // With a hundred sweeps only single precision is left between the two.
    let creep = |sweeps: usize| {
        let robot = sliding_box(friction, (0.98 * friction).atan());
        slide(&mut LaneSimulation::<f32, 8>::new(robot, 1, 1).unwrap().with_sweeps(sweeps), 1.0)
    };
    let converged =
        slide(&mut MujocoSimulation::new(sliding_box(friction, (0.98 * friction).atan()), 1, 1).unwrap(), 1.0);
    println!(
        "0.98, first second: {:.6} m with 12 sweeps, {:.6} with 100, MuJoCo {converged:.6}",
        creep(12),
        creep(100)
    );
    assert!((creep(100) / converged - 1.0).abs() < 1e-3);
    for factor in [0.9, 0.98, 1.02, 1.1] {
        let (ours, mujoco) = way((factor * friction).atan());
        println!("{factor} of the friction angle: {ours:.4} m in a second, MuJoCo {mujoco:.4} m");
        assert_eq!(ours > 0.05, factor > 1.0, "{factor}: {ours}");
        assert_eq!(mujoco > 0.05, factor > 1.0, "{factor}: {mujoco}");
    }
}

/// Nothing but gravity and the joints' own inertia: a second of flight ends where MuJoCo's does.
#[test]
fn flight_is_mujocos() {
    let robot = Arc::new(Robot::load("lima").unwrap());
    let n = 20;
    let mut rng = ChaCha8Rng::seed_from_u64(21);
    let (mut positions, mut velocities) = (Vec::new(), Vec::new());
    for _ in 0..n {
        let (q, v) = random_state(&robot, &mut rng, 50.0);
        positions.extend(q);
        velocities.extend(v.iter().map(|x| 0.5 * x));
    }
    let end = |simulation: &mut dyn Simulation| {
        simulation.reset(&all(n), &positions, &velocities).unwrap();
        let torques = vec![0.0; n * robot.joints()];
        (0..50).for_each(|_| simulation.step(Drive::Torques(&torques)).unwrap());
        simulation.state().clone()
    };
    let mut oracle = MujocoSimulation::new(robot.clone(), n, 1).unwrap();
    let mut ours = LaneSimulation::<f32, 8>::new(robot.clone(), n, 1).unwrap();
    let (a, b) = (end(&mut oracle), end(&mut ours));
    let position = rms(&a.root_position, &b.root_position);
    let joints = rms(&a.joint_velocity, &b.joint_velocity);
    println!("a second of flight: root {position:.1e} m, joint velocities {joints:.1e} rad/s off MuJoCo");
    // Single precision at 50 m resolves 4e-6 m; limits are hit, so velocities differ more.
    assert!(position < 1e-4 && joints < 0.02, "{position} {joints}");
}

/// Gate 4: while they fall, as many have fallen at any time as in MuJoCo, and they are as high.
#[test]
fn long_rollouts_look_like_mujocos() {
    let n = 1000;
    let (robot, mut oracle, _, mut ours) = together("lima", n);
    let (positions, velocities) = near_standing(&robot, n, 31);
    let mut perturbed = positions.clone();
    let mut rng = ChaCha8Rng::seed_from_u64(32);
    perturbed
        .chunks_mut(robot.character.nq)
        .for_each(|q| q[7..].iter_mut().for_each(|x| *x += rng.random_range(-1e-3..1e-3)));
    let targets = random_targets(&robot, n, 33);
    // Every 0.2 s: mean height (m), share that has fallen, feet on the ground per robot.
    let course = |simulation: &mut dyn Simulation, positions: &[f64]| -> Vec<[f64; 3]> {
        simulation.reset(&all(n), positions, &velocities).unwrap();
        let mut course = Vec::new();
        for _ in 0..10 {
            (0..10).for_each(|_| simulation.step(Drive::Targets(&targets)).unwrap());
            let state = simulation.state();
            let heights: Vec<f64> = state.root_position.chunks(3).map(|p| f64::from(p[2])).collect();
            let mean = heights.iter().sum::<f64>() / n as f64;
            let fallen = heights.iter().filter(|h| **h < 0.25).count() as f64 / n as f64;
            let feet = state.foot_force.iter().filter(|f| **f > 1.0).count() as f64 / n as f64;
            course.push([mean, fallen, feet]);
        }
        course
    };
    let theirs = course(&mut oracle, &positions);
    let aside = course(&mut oracle, &perturbed);
    let own = course(&mut ours, &positions);
    let farthest = |course: &[[f64; 3]], k: usize| {
        course.iter().zip(&theirs).map(|(a, b)| (a[k] - b[k]).abs()).fold(0.0, f64::max)
    };
    for (k, what) in ["height (m)", "fallen", "feet down"].into_iter().enumerate() {
        let (ours, theirs) = (farthest(&own, k), farthest(&aside, k));
        println!("{what}: at most {ours:.4} off MuJoCo; MuJoCo from 1 mrad beside {theirs:.4} off itself");
        // A thousandth per robot: one robot that falls a moment later is not a difference.
        assert!(ours < 3.0 * theirs + 3e-3, "{what}: {ours} {theirs}");
    }
    let fallen: Vec<f64> = theirs.iter().map(|c| c[1]).collect();
    assert!(fallen.iter().any(|f| (0.2..0.8).contains(f)), "a time at which some have fallen: {fallen:?}");
}

/// Other masses, another friction and a push do what they do in MuJoCo.
#[test]
fn parameters_and_pushes_act_as_in_mujoco() {
    let n = 64;
    let (robot, mut oracle, _, ours) = together("lima", n);
    // What is asked is whether the same numbers arrive in the same places: with converged forces, so that nothing else differs.
    let mut ours = ours.with_sweeps(100);
    let bodies = robot.character.bodies.len();
    let (positions, velocities) = near_standing(&robot, n, 41);
    let targets = random_targets(&robot, n, 42);
    let mut end = |changed: bool| {
        [&mut oracle as &mut dyn Simulation, &mut ours].map(|simulation| {
            let mut rng = ChaCha8Rng::seed_from_u64(43);
            simulation.reset(&all(n), &positions, &velocities).unwrap();
            for id in 0..n {
                let mass_scale = (0..bodies).map(|_| rng.random_range(0.7..1.4)).collect();
                let ground_friction = Some(rng.random_range(0.05..1.0));
                let force = std::array::from_fn(|_| rng.random_range(-40.0..40.0));
                let torque = std::array::from_fn(|_| rng.random_range(-2.0..2.0));
                if changed {
                    let parameters = EnvironmentParameters { mass_scale, ground_friction, joint_offset: Vec::new() };
                    simulation.set_parameters(id, parameters).unwrap();
                    simulation.push(id, 1 + id % (bodies - 1), force, torque).unwrap();
                }
            }
            (0..10).for_each(|_| simulation.step(Drive::Targets(&targets)).unwrap());
            simulation.state().joint_position.clone()
        })
    };
    let plain = end(false);
    let [theirs, own] = end(true);
    let (off, effect) = (rms(&theirs, &own), rms(&theirs, &plain[0]));
    println!(
        "masses, friction and pushes move joints by {effect:.1e} rad RMS in 0.2 s; ours are {off:.1e} off MuJoCo's"
    );
    assert!(off < 5e-4 && effect > 100.0 * off, "{off} {effect}");
}

/// At rest the spring of the contacts carries the weight: the same depth is the same force.
#[test]
fn a_box_at_rest_sinks_as_deep_as_in_mujoco() {
    let robot = sliding_box(0.8, 0.0);
    let mut ours = LaneSimulation::<f32, 8>::new(robot.clone(), 1, 1).unwrap();
    let mut oracle = MujocoSimulation::new(robot, 1, 1).unwrap();
    slide(&mut ours, 2.0);
    slide(&mut oracle, 2.0);
    let (a, b) = (ours.state().root_position[2], oracle.state().root_position[2]);
    let (deep, theirs) = (0.05 - f64::from(a), 0.05 - f64::from(b));
    println!("a box of 2 kg sinks {deep:.2e} m, in MuJoCo {theirs:.2e} m");
    assert!(deep > 0.0 && (deep / theirs - 1.0).abs() < 0.01, "{deep} {theirs}");
}

#[test]
fn what_is_hostile_is_quarantined_or_refused() {
    let robot = Arc::new(Robot::load("lima").unwrap());
    let (nv, joints) = (robot.character.nv, robot.joints());
    let run = |spoil: &dyn Fn(&mut LaneSimulation<f32, 8>)| {
        let mut simulation = LaneSimulation::<f32, 8>::new(robot.clone(), 8, 1).unwrap();
        spoil(&mut simulation);
        (0..20).for_each(|_| simulation.step(Drive::Targets(&vec![0.1; 8 * joints])).unwrap());
        simulation.state().clone()
    };
    let calm = run(&|_| ());
    let fast = run(&|s| s.reset(&[3], &robot.default_position(), &vec![1e6; nv]).unwrap());
    let far = run(&|s| {
        let mut q = robot.default_position();
        q[7..].fill(1e6);
        s.reset(&[3], &q, &vec![0.0; nv]).unwrap();
    });
    let sunk = run(&|s| {
        let mut q = robot.default_position();
        q[2] = -1e4;
        s.reset(&[3], &q, &vec![0.0; nv]).unwrap();
    });
    for (what, state) in [("fast", &fast), ("far", &far), ("sunk", &sunk)] {
        for e in (0..8).filter(|e| *e != 3) {
            let row = |s: &lifelike_sim::BatchState| s.joint_position[e * joints..(e + 1) * joints].to_vec();
            assert_eq!(row(state), row(&calm), "{what}: neighbour {e}");
        }
        let numbers = state.joint_position.iter().chain(&state.joint_velocity).chain(&state.torque);
        assert!(numbers.clone().all(|x| x.is_finite()), "{what}");
    }
    assert!(fast.diverged[3]);
}
