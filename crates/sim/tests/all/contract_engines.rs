//! Promises of every engine.
use std::sync::Arc;

use crate::world::{targets, vary};
use lifelike_robot::Robot;
use lifelike_sim::{
    BatchState, ConstraintWrenches, Drive, EngineKind, EnvironmentParameters, Simulation, SimulationSpec,
};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// All engines.
fn engines() -> impl Iterator<Item = EngineKind> {
    EngineKind::ALL.iter().copied()
}

fn make(engine: EngineKind, environments: usize, threads: usize) -> Box<dyn Simulation> {
    SimulationSpec { engine, threads, ..SimulationSpec::new(environments) }.build(lima()).unwrap()
}

fn lima() -> Arc<Robot> {
    Arc::new(Robot::load("lima").unwrap())
}

fn run(
    engine: EngineKind,
    environments: &[usize],
    threads: usize,
    steps: usize,
) -> (Vec<BatchState>, Box<dyn Simulation>) {
    let robot = lima();
    let mut simulation = make(engine, environments.len(), threads);
    vary(simulation.as_mut(), environments);
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
    for engine in engines() {
        let (one, saved) = run(engine, &environments, 1, 40);
        for threads in [2, 3] {
            let (other, simulation) = run(engine, &environments, threads, 40);
            assert!(one == other, "{engine}, {threads} threads");
            assert_eq!(saved.save(), simulation.save());
        }
    }
}

#[test]
fn the_place_in_the_batch_changes_no_bit() {
    let straight: Vec<usize> = (0..19).collect();
    let permuted: Vec<usize> = (0..19).map(|i| (i * 7 + 3) % 19).collect();
    let joints = lima().joints();
    for engine in engines() {
        let (a, _) = run(engine, &straight, 1, 30);
        let (b, _) = run(engine, &permuted, 2, 30);
        for (a, b) in a.iter().zip(&b) {
            for (place, &e) in permuted.iter().enumerate() {
                let row = |v: &[f32], id: usize, n: usize| v[id * n..(id + 1) * n].to_vec();
                assert_eq!(row(&a.root_position, e, 3), row(&b.root_position, place, 3), "{engine}");
                assert_eq!(row(&a.joint_velocity, e, joints), row(&b.joint_velocity, place, joints), "{engine}");
                assert_eq!(row(&a.torque_squared, e, joints), row(&b.torque_squared, place, joints), "{engine}");
                assert_eq!(row(&a.foot_force, e, 2), row(&b.foot_force, place, 2), "{engine}");
            }
        }
    }
}

#[test]
fn a_saved_state_continues_bit_for_bit() {
    for engine in engines() {
        let environments: Vec<usize> = (0..11).collect();
        let (whole, end) = run(engine, &environments, 2, 50);
        let (_, half) = run(engine, &environments, 1, 20);
        let saved = half.save();
        let robot = lima();
        let mut resumed = make(engine, 11, 3);
        // A past of its own, which must not show.
        for t in 0..7 {
            resumed.step(Drive::Targets(&targets(&robot, &environments, 900 + t))).unwrap();
        }
        resumed.restore(&saved).unwrap();
        assert_eq!(resumed.state().root_position, whole[19].root_position);
        assert_eq!(resumed.state().site_position, whole[19].site_position);
        for (t, expected) in whole.iter().enumerate().skip(20) {
            resumed.step(Drive::Targets(&targets(&robot, &environments, t))).unwrap();
            assert!(resumed.state() == expected, "step {t}");
        }
        assert_eq!(resumed.save(), end.save());
    }
}

/// Environments 0..6 with `bad` torques in environment 2 at step 10, and the same without.
fn with_and_without(engine: EngineKind, bad: f32) -> (Box<dyn Simulation>, Box<dyn Simulation>) {
    let robot = lima();
    let joints = robot.joints();
    let run = |disturbed: bool| {
        let mut simulation = make(engine, 6, 2);
        for t in 0..30 {
            let mut torques = vec![0.5; 6 * joints];
            if disturbed && t == 10 {
                torques[2 * joints..3 * joints].fill(bad);
            }
            simulation.step(Drive::Torques(&torques)).unwrap();
            let lost = disturbed && t >= 10;
            let expected: Vec<bool> = (0..6).map(|e| lost && e == 2).collect();
            assert_eq!(simulation.state().diverged, expected, "step {t}");
        }
        simulation
    };
    (run(true), run(false))
}

#[test]
fn divergence_stays_where_it_is() {
    for engine in engines() {
        for bad in [f32::NAN, f32::INFINITY, 1e12] {
            let (mut disturbed, calm) = with_and_without(engine, bad);
            let joints = disturbed.robot().joints();
            let (a, b) = (disturbed.state(), calm.state());
            for e in [0, 1, 3, 4, 5] {
                assert_eq!(
                    a.root_position[3 * e..3 * e + 3],
                    b.root_position[3 * e..3 * e + 3],
                    "{bad}: neighbour {e}"
                );
                let rows = e * joints..(e + 1) * joints;
                assert_eq!(a.joint_velocity[rows.clone()], b.joint_velocity[rows]);
            }
            assert!(a.root_position.iter().chain(&a.joint_velocity).chain(&a.torque).all(|x| x.is_finite()));
            // Frozen at the last good state, which is that of step 9.
            let robot = lima();
            let mut nine = make(engine, 6, 1);
            (0..10).for_each(|_| nine.step(Drive::Torques(&vec![0.5; 6 * joints])).unwrap());
            assert_eq!(a.joint_position[2 * joints..3 * joints], nine.state().joint_position[2 * joints..3 * joints]);
            // A reset brings it back to life.
            let (position, velocity) = (robot.default_position(), vec![0.0; robot.character.nv]);
            disturbed.reset(&[2, 0], &position.repeat(2), &velocity.repeat(2)).unwrap();
            assert!(!disturbed.state().diverged[2]);
            disturbed.step(Drive::Torques(&vec![0.5; 6 * joints])).unwrap();
            let state = disturbed.state();
            assert_eq!(state.diverged, [false; 6]);
            assert_eq!(
                state.joint_velocity[..joints],
                state.joint_velocity[2 * joints..3 * joints],
                "like its neighbour"
            );
        }
    }
}

#[test]
fn a_target_that_is_no_number_is_not_taken_for_one() {
    let robot = lima();
    let joints = robot.joints();
    for engine in engines() {
        let mut simulation = make(engine, 3, 1);
        let mut numbers = vec![0.1; 3 * joints];
        numbers[joints + 4] = f32::NAN;
        simulation.step(Drive::Targets(&numbers)).unwrap();
        let state = simulation.state();
        assert_eq!(state.diverged, [false, true, false], "{engine}");
        let at_start = robot.default_pose[4] as f32;
        assert!((state.joint_position[joints + 4] - at_start).abs() < 1e-6, "{engine}: frozen where it was");
        assert!(state.torque[joints..2 * joints].iter().chain(&state.foot_force[2..4]).all(|x| *x == 0.0), "{engine}");
    }
}

#[test]
fn a_reset_ends_pushes() {
    let robot = lima();
    let (position, velocity) = (robot.default_position(), vec![0.0; robot.character.nv]);
    for engine in engines() {
        let mut simulation = make(engine, 2, 1);
        let fresh = simulation.save();
        simulation.push(1, 1, [30.0, 0.0, 0.0], [0.0; 3]).unwrap();
        assert_ne!(simulation.save(), fresh, "{engine}");
        simulation.reset(&[1], &position, &velocity).unwrap();
        assert_eq!(simulation.save(), fresh, "{engine}");
    }
}

#[test]
fn a_refused_call_says_why_and_changes_nothing() {
    for engine in engines() {
        let robot = lima();
        let (nq, nv, joints) = (robot.character.nq, robot.character.nv, robot.joints());
        let mut simulation = make(engine, 2, 1);
        let before = simulation.save();
        let error = simulation.step(Drive::Targets(&vec![0.0; joints])).unwrap_err().to_string();
        assert!(error.contains("targets") && error.contains("40") && error.contains("20"), "{error}");
        let position = robot.default_position();
        assert!(simulation.reset(&[0], &position[1..], &vec![0.0; nv]).is_err());
        assert!(simulation.reset(&[2], &position, &vec![0.0; nv]).is_err());
        let mut nan = position.repeat(2);
        nan[nq] = f64::NAN;
        let error = simulation.reset(&[0, 1], &nan, &vec![1.0; 2 * nv]).unwrap_err().to_string();
        assert!(error.contains("environment 1") && error.contains("NaN"), "{error}");
        let mut lost = position.clone();
        lost[3..7].fill(0.0);
        assert!(simulation.reset(&[0], &lost, &vec![0.0; nv]).is_err());
        let wrong = EnvironmentParameters { mass_scale: vec![1.0; 3], ..Default::default() };
        assert!(simulation.set_parameters(0, wrong).unwrap_err().to_string().contains("mass_scale"));
        let wrong = EnvironmentParameters { ground_friction: Some(-1.0), ..Default::default() };
        assert!(simulation.set_parameters(0, wrong).is_err());
        assert!(simulation.push(0, 0, [0.0; 3], [0.0; 3]).is_err());
        assert!(simulation.push(0, 1, [f32::NAN, 0.0, 0.0], [0.0; 3]).is_err());
        let mut foreign = before.clone();
        foreign.engine = "other".into();
        assert!(simulation.restore(&foreign).unwrap_err().to_string().contains("other"));
        let other = make(engine, 3, 1).save();
        assert!(simulation.restore(&other).is_err());
        assert_eq!(simulation.save(), before);
    }
}

#[test]
fn engines_are_known_by_name() {
    for engine in engines() {
        assert_eq!(make(engine, 2, 1).engine(), engine.name());
    }
    for &engine in EngineKind::ALL {
        assert_eq!(engine.to_string().parse::<EngineKind>().unwrap(), engine);
    }
    let error = "bullet".parse::<EngineKind>().unwrap_err().to_string();
    assert_eq!(error, "no engine 'bullet'; there are: lifelike, mujoco");
    assert_eq!(EngineKind::default(), EngineKind::Lifelike);
}

/// Lima after some steps of its own, and what it is driven by next.
fn moving(engine: EngineKind, environments: &[usize], threads: usize) -> (Box<dyn Simulation>, Vec<f32>) {
    let (_, simulation) = run(engine, environments, threads, 12);
    let next = targets(simulation.robot(), environments, 12);
    (simulation, next)
}

#[test]
fn asking_for_constraint_wrenches_changes_no_bit() {
    let environments: Vec<usize> = (0..19).collect();
    for engine in engines() {
        let (mut asked, next) = moving(engine, &environments, 2);
        let (mut silent, _) = moving(engine, &environments, 1);
        let wrenches = asked.constraint_wrenches(Drive::Targets(&next)).unwrap();
        assert_eq!(asked.save(), silent.save(), "{engine}");
        assert_eq!(asked.state(), silent.state(), "{engine}");
        assert_eq!(silent.constraint_wrenches(Drive::Targets(&next)).unwrap(), wrenches, "{engine}, threads");
        for simulation in [&mut asked, &mut silent] {
            simulation.step(Drive::Targets(&next)).unwrap();
        }
        assert_eq!(asked.state(), silent.state(), "{engine}");
        assert!(asked.constraint_wrenches(Drive::Targets(&next[1..])).is_err());
    }
}

/// Newton: all joints of a body, contacts and pushes together carry the robot's weight while it does not accelerate; and
/// of all bodies together the joints' forces cancel.
#[test]
fn constraint_wrenches_obey_newton() {
    let robot = lima();
    let bodies = robot.character.bodies.len();
    for engine in engines() {
        let mut simulation = make(engine, 2, 1);
        let stand: Vec<f32> = robot.default_pose.iter().map(|&q| q as f32).collect();
        (0..15).for_each(|_| simulation.step(Drive::Targets(&stand.repeat(2))).unwrap());
        let ConstraintWrenches { joint, constraint, contact, joint_load } =
            simulation.constraint_wrenches(Drive::Targets(&stand.repeat(2))).unwrap();
        assert_eq!(joint_load.len(), 2 * robot.joints());
        assert!(
            joint[..6].iter().chain(&constraint[..6]).chain(&contact[..6]).all(|x| *x == 0.0),
            "the world has none"
        );
        let sum = |wrenches: &[f32], k: usize| (0..bodies).map(|b| f64::from(wrenches[6 * b + k])).sum::<f64>();
        let weight = robot.character.mass() * 9.81;
        for k in 3..6 {
            assert!(sum(&constraint, k).abs() < 1e-3 * weight, "{engine}: {}", sum(&constraint, k));
        }
        // The trunk's joint is free: it carries nothing.
        let root = robot.character.root_joint().unwrap().body;
        assert!(joint[6 * root..6 * root + 6].iter().all(|x| x.abs() < 1e-2), "{engine}: {:?}", &joint[..12]);
        let up = sum(&contact, 5);
        assert!((0.2 * weight..3.0 * weight).contains(&up), "{engine}: {up} of {weight} N");
        assert!(joint_load.iter().any(|x| x.abs() > 0.1), "{engine}: {joint_load:?}");
    }
}

#[test]
fn a_diverged_environment_has_no_constraint_wrenches() {
    let joints = lima().joints();
    for engine in engines() {
        let mut simulation = make(engine, 3, 1);
        let mut torques = vec![0.1; 3 * joints];
        torques[joints] = f32::NAN;
        simulation.step(Drive::Torques(&torques)).unwrap();
        torques[joints] = 0.1;
        torques[2 * joints] = f32::INFINITY;
        let wrenches = simulation.constraint_wrenches(Drive::Torques(&torques)).unwrap();
        let rows = wrenches.joint.len() / 3;
        assert!(wrenches.joint[..rows].iter().any(|x| *x != 0.0), "{engine}");
        assert!(wrenches.joint[rows..].iter().chain(&wrenches.joint_load[joints..]).all(|x| *x == 0.0), "{engine}");
        assert!(!simulation.state().diverged[2], "{engine}: asking is not stepping");
    }
}

#[test]
fn pushes_come_and_go_by_schedule() {
    for engine in engines() {
        use lifelike_sim::randomization::{PushSchedule, PushSpec};
        let spec = PushSpec { duration: [0.1, 0.1], interval: [0.2, 0.2], ..PushSpec::default() };
        let mut simulation = make(engine, 2, 1);
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        let mut schedule = PushSchedule::new(&spec, 50.0, &mut rng);
        let idle = simulation.save();
        let pushed: Vec<bool> = (0..40)
            .map(|_| {
                if !schedule.waits() {
                    schedule.change(&spec, simulation.as_mut(), 1, &mut rng).unwrap();
                }
                assert_eq!(schedule.active.is_some(), simulation.save() != idle);
                schedule.active.is_some()
            })
            .collect();
        // 0.2 s are 10 policy steps, 0.1 s are 5.
        let expected: Vec<bool> = (0..40).map(|t| (t + 6) % 15 < 5 && t > 5).collect();
        assert_eq!(pushed, expected);
    }
}
