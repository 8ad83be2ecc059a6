//! Promises of an augmented simulation, with corrections made by hand.
use std::sync::Arc;

use lifelike_robot::Robot;
use lifelike_sim::augmented::{CorrectionStep, HistorySize};
use lifelike_sim::{Augmented, Drive, EngineKind, IntegrationState, Simulation, SimulationSpec, StateCorrection};

const STEPS: usize = 40;

fn lima() -> Arc<Robot> {
    Arc::new(Robot::load("lima").unwrap())
}

fn engines() -> impl Iterator<Item = EngineKind> {
    EngineKind::ALL.iter().copied()
}

fn plain(engine: EngineKind, environments: usize, threads: usize) -> Box<dyn Simulation> {
    SimulationSpec { engine, threads, ..SimulationSpec::new(environments) }.build(lima()).unwrap()
}

/// Targets of step `t`; environment `e` gets the same whatever the batch.
fn targets(robot: &Robot, environments: &[usize], t: usize) -> Vec<f32> {
    let wriggle = |e: usize, j: usize| 0.2 * ((e * 7919 + t * 131 + j * 17) as f32).sin();
    let row = |e: usize| robot.default_pose.iter().enumerate().map(move |(j, &q)| q as f32 + wriggle(e, j));
    environments.iter().flat_map(|&e| row(e)).collect()
}

/// Reports what it is given.
struct Nothing;

impl StateCorrection for Nothing {
    fn name(&self) -> &str {
        "nothing"
    }
    fn history(&self, _: &Robot) -> HistorySize {
        HistorySize { steps: 2, width: 1 }
    }
    fn correct(&mut self, _: &mut [CorrectionStep<'_>]) {}
}

/// Joints that follow the simulated ones with a first-order lag: x(t) = x(t-1) + (s(t) - x(t-1)) / 4. Its record is x(t), and
/// how many steps there were; it keeps more records than it needs.
struct Lag {
    /// Joint position (rad) beyond which its result is not a number.
    limit: f32,
}

impl StateCorrection for Lag {
    fn name(&self) -> &str {
        "lag"
    }
    fn history(&self, robot: &Robot) -> HistorySize {
        HistorySize { steps: 3, width: robot.joints() + 1 }
    }
    fn correct(&mut self, environments: &mut [CorrectionStep<'_>]) {
        for step in environments {
            assert_eq!(step.wrenches.joint_load.len(), step.simulated.joint_position.len());
            assert_eq!(step.drive.values().len(), step.simulated.joint_position.len());
            // The records are the latest ones, in their order.
            let numbers: Vec<f32> = step.history.records().map(|r| r[r.len() - 1]).collect();
            assert!(numbers.windows(2).all(|pair| pair[1] == pair[0] + 1.0), "{numbers:?}");
            let (count, positions) = step.record.split_last_mut().unwrap();
            *count = step.history.last().map_or(1.0, |r| r[r.len() - 1] + 1.0);
            assert_eq!(step.history.records().len(), (*count as usize - 1).min(3));
            for (j, (x, s)) in step.corrected.joint_position.iter_mut().zip(step.simulated.joint_position).enumerate() {
                let before = step.history.last().map_or(*s, |r| r[j]);
                *x = if s.abs() > self.limit { f32::NAN } else { before + 0.25 * (s - before) };
                positions[j] = *x;
            }
        }
    }
}

fn lagging(engine: EngineKind, environments: usize, threads: usize) -> Augmented<Box<dyn Simulation>> {
    Augmented::new(plain(engine, environments, threads), Box::new(Lag { limit: f32::MAX })).unwrap()
}

fn drive(simulation: &mut dyn Simulation, environments: &[usize], steps: std::ops::Range<usize>) {
    let robot = simulation.robot().clone();
    steps.for_each(|t| simulation.step(Drive::Targets(&targets(&robot, environments, t))).unwrap());
}

#[test]
fn a_correction_of_nothing_changes_no_bit() {
    let environments: Vec<usize> = (0..5).collect();
    for engine in engines() {
        let mut bare = plain(engine, 5, 1);
        let mut augmented = Augmented::new(plain(engine, 5, 2), Box::new(Nothing)).unwrap();
        for simulation in [bare.as_mut(), &mut augmented as &mut dyn Simulation] {
            simulation.push(1, 1, [20.0, 0.0, 0.0], [0.0; 3]).unwrap();
            drive(simulation, &environments, 0..STEPS);
        }
        assert_eq!(augmented.state(), bare.state(), "{engine}");
        assert_eq!(augmented.engine(), format!("{engine}+nothing"));
    }
}

#[test]
fn a_lag_is_its_closed_form_and_leaves_the_simulation_alone() {
    let robot = lima();
    let joints = robot.joints();
    for engine in engines() {
        let (mut augmented, mut bare) = (lagging(engine, 2, 1), plain(engine, 2, 1));
        let mut simulated: Vec<Vec<f32>> = Vec::new();
        for t in 0..STEPS {
            drive(&mut augmented, &[0, 1], t..t + 1);
            drive(bare.as_mut(), &[0, 1], t..t + 1);
            simulated.push(bare.state().joint_position.clone());
            for j in 0..2 * joints {
                // The first state weighs what all before it would have.
                let weight = |k: usize| 0.25 * 0.75_f64.powi((t - k) as i32) / if k == 0 { 0.25 } else { 1.0 };
                let expected: f64 = (0..=t).map(|k| weight(k) * f64::from(simulated[k][j])).sum();
                let got = f64::from(augmented.state().joint_position[j]);
                assert!((got - expected).abs() < 1e-5, "{engine} step {t} joint {j}: {got}, expected {expected}");
            }
        }
        assert_eq!(augmented.simulation().state(), bare.state());
        assert_ne!(augmented.state().joint_position, bare.state().joint_position);
        assert_eq!(augmented.state().root_position, bare.state().root_position);
        assert_eq!(augmented.state().foot_force, bare.state().foot_force);
    }
}

/// Where the simulation itself says that bodies and sites are when the joints are where the correction puts them.
#[test]
fn bodies_and_sites_follow_corrected_joints() {
    let robot = lima();
    for engine in engines() {
        let mut augmented = lagging(engine, 1, 1);
        drive(&mut augmented, &[3], 0..STEPS);
        let state = augmented.state();
        let mut q = robot.default_position();
        let root = robot.character.root_joint().unwrap().q_index;
        let pose = state.root_position.iter().chain(&state.root_orientation);
        q[root..].iter_mut().zip(pose).for_each(|(slot, x)| *slot = f64::from(*x));
        for (joint, x) in robot.character.scalar_joints().zip(&state.joint_position) {
            q[joint.q_index] = f64::from(*x);
        }
        let mut there = plain(engine, 1, 1);
        there.reset(&[0], &q, &vec![0.0; robot.character.nv]).unwrap();
        let apart = |a: &[f32], b: &[f32]| a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        assert!(apart(&state.body_position, &there.state().body_position) < 1e-5);
        assert!(apart(&state.site_position, &there.state().site_position) < 1e-5);
        assert!(apart(&state.body_position, &augmented.simulation().state().body_position) > 1e-4, "they did move");
    }
}

#[test]
fn a_saved_history_continues_bit_for_bit() {
    let environments: Vec<usize> = (0..5).collect();
    for engine in engines() {
        let mut whole = lagging(engine, 5, 1);
        drive(&mut whole, &environments, 0..20);
        let saved = whole.save();
        let then = whole.state().clone();
        drive(&mut whole, &environments, 20..STEPS);
        // A past of its own, which must not show.
        let mut resumed = lagging(engine, 5, 2);
        drive(&mut resumed, &environments, 900..903);
        resumed.restore(&saved).unwrap();
        assert_eq!(resumed.save(), saved);
        assert_eq!(resumed.state().joint_position, then.joint_position);
        assert_eq!(resumed.state().body_orientation, then.body_orientation);
        drive(&mut resumed, &environments, 20..STEPS);
        assert_eq!(resumed.state(), whole.state(), "{engine}");
        assert_eq!(resumed.save(), whole.save(), "{engine}");
        // The simulation's own state lacks the history, and is refused.
        let bare: IntegrationState = whole.simulation().save();
        assert!(resumed.restore(&bare).unwrap_err().to_string().contains("+lag"));
    }
}

#[test]
fn the_place_in_the_batch_changes_no_bit_of_a_correction() {
    let order = [4, 0, 3];
    let joints = lima().joints();
    for engine in engines() {
        let mut all = lagging(engine, 5, 2);
        drive(&mut all, &[0, 1, 2, 3, 4], 0..STEPS);
        let mut some = lagging(engine, 3, 1);
        drive(&mut some, &order, 0..STEPS);
        for (place, e) in order.into_iter().enumerate() {
            let row = |s: &dyn Simulation, id: usize| s.state().joint_position[id * joints..(id + 1) * joints].to_vec();
            assert_eq!(row(&all, e), row(&some, place), "{engine}");
        }
    }
}

#[test]
fn a_reset_forgets_the_history_of_that_environment_alone() {
    let robot = lima();
    let joints = robot.joints();
    for engine in engines() {
        let (mut reset, mut kept, mut fresh) = (lagging(engine, 2, 1), lagging(engine, 2, 1), lagging(engine, 2, 1));
        drive(&mut reset, &[0, 1], 0..10);
        drive(&mut kept, &[0, 1], 0..10);
        reset.reset(&[1], &robot.default_position(), &vec![0.0; robot.character.nv]).unwrap();
        for simulation in [&mut reset, &mut kept, &mut fresh] {
            drive(simulation, &[0, 1], 10..20);
        }
        let joint_position = |s: &Augmented<_>| s.state().joint_position.clone();
        assert_eq!(joint_position(&reset)[joints..], joint_position(&fresh)[joints..], "{engine}: as if new");
        assert_eq!(joint_position(&reset)[..joints], joint_position(&kept)[..joints], "{engine}: untouched");
        let (a, b) = (reset.save(), fresh.save());
        assert_eq!(a.values[a.width..], b.values[b.width..], "{engine}: nothing is left of the past");
    }
}

#[test]
fn divergence_freezes_the_reported_state_and_stays_where_it_is() {
    let robot = lima();
    let joints = robot.joints();
    for engine in engines() {
        let (mut lost, mut calm) = (lagging(engine, 3, 1), lagging(engine, 3, 1));
        drive(&mut lost, &[0, 1, 2], 0..10);
        drive(&mut calm, &[0, 1, 2], 0..10);
        let before = lost.state().clone();
        for t in 10..13 {
            let mut numbers = targets(&robot, &[0, 1, 2], t);
            numbers[joints] = f32::NAN;
            lost.step(Drive::Targets(&numbers)).unwrap();
        }
        drive(&mut calm, &[0, 1, 2], 10..13);
        let (state, row) = (lost.state(), joints..2 * joints);
        assert_eq!(state.diverged, [false, true, false]);
        assert_eq!(state.joint_position[row.clone()], before.joint_position[row.clone()]);
        assert!(state.torque[row].iter().all(|x| *x == 0.0));
        for id in [0, 2] {
            let row = id * joints..(id + 1) * joints;
            assert_eq!(state.joint_position[row.clone()], calm.state().joint_position[row], "{engine}: neighbour {id}");
        }
        let wrenches = lost.constraint_wrenches(Drive::Targets(&targets(&robot, &[0, 1, 2], 13))).unwrap();
        assert!(wrenches.joint_load[joints..2 * joints].iter().all(|x| *x == 0.0));
    }
}

#[test]
fn a_correction_that_is_no_number_freezes_its_environment_until_a_reset() {
    let robot = lima();
    let joints = robot.joints();
    for engine in engines() {
        let mut simulation = Augmented::new(plain(engine, 2, 1), Box::new(Lag { limit: 1.5 })).unwrap();
        let mut q = robot.default_position().repeat(2);
        // One joint of the second environment begins beyond the limit.
        let (nq, joint) = (robot.character.nq, robot.character.scalar_joints().last().unwrap().q_index);
        q[nq + joint] = 2.5;
        simulation.reset(&[0, 1], &q, &vec![0.0; 2 * robot.character.nv]).unwrap();
        let before = simulation.state().clone();
        drive(&mut simulation, &[0, 1], 0..3);
        let state = simulation.state();
        assert_eq!(state.diverged, [false, true], "{engine}");
        assert_eq!(state.joint_position[joints..], before.joint_position[joints..]);
        assert!(state.joint_position.iter().chain(&state.body_position).all(|x| x.is_finite()));
        assert!(!simulation.simulation().state().diverged[1], "the simulation itself is sound");
        let saved = simulation.save();
        drive(&mut simulation, &[0, 1], 3..5);
        simulation.restore(&saved).unwrap();
        assert_eq!(simulation.state().diverged, [false, true], "and saved states tell");
        simulation.reset(&[1], &robot.default_position(), &vec![0.0; robot.character.nv]).unwrap();
        drive(&mut simulation, &[0, 1], 3..5);
        assert_eq!(simulation.state().diverged, [false, false], "{engine}");
    }
}
