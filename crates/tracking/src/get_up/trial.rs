//! Trials of keyframes: candidates on all robots, from states in which these lie.

use std::sync::Arc;

use lifelike_character::Vec3;
use lifelike_character::rotation::from_wxyz;
use lifelike_checkpoint::rng::stream;
use lifelike_robot::get_up::Key;
use lifelike_robot::{GetUpScript, Robot};
use lifelike_sim::twin::{Twin, TwinSpec};
use lifelike_sim::{BatchState, Drive, Simulation, SimulationSpec, fallen};
use rand::seq::SliceRandom;

use super::GetUpPlan;
use crate::{FromInput, TrackerError};

/// Dropped robots from which starts are drawn.
const DROPPED: usize = 96;
/// Time for which a robot falls (s).
const DROP: f64 = 2.0;
/// A robot lies on its belly when the vertical part of its forward axis is below this, on its back or side otherwise.
const ON_BELLY: f64 = -0.6;
/// Longest time of a trial of `roll` and of `rise` (s); the last pose is held.
const LONGEST: [f64; 2] = [2.4, 4.2];
/// Time for which a robot must be where `roll` and `rise` lead (s). One that rolls must not roll on; after `rise` a controller takes
/// over.
const HOLD: [f64; 2] = [0.5, 0.06];
/// Up axis and height of a robot on its feet, and forward axis of one that lies flat on its belly. Both of the first are a little
/// above those at which a controller takes over.
const UPRIGHT: f64 = 0.92;
const HEIGHT: f64 = 0.78;
const FLAT: f64 = -0.85;
/// Squared speed of a robot that lies, and of one that a controller can take over (m²/s²).
const CALM: [f64; 2] = [0.1, 0.6];
/// Share of the weight that each foot carries at least.
const CARRIES: f64 = 0.1;
/// Value of a trial that succeeds at once; one that succeeds late has half of it.
const SUCCEEDED: f64 = 2.0;
/// Weight of the root's squared speed (1/(m/s)²): slow motion is safer.
const SPEED: f64 = 0.5;

/// A stage that is searched.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Stage {
    Roll,
    Rise,
}

impl Stage {
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Roll => "roll",
            Self::Rise => "rise",
        }
    }
}

/// Outcome of a candidate.
#[derive(Debug, Clone)]
pub(super) struct Outcome {
    pub(super) value: f64,
    /// Share of trials that succeeded, of each robot.
    pub(super) success: Vec<f64>,
}

/// One trial so far.
#[derive(Debug, Clone, Default)]
struct Course {
    /// Best quality so far, and its sum over the frames: soon is better than late.
    best: f64,
    sum: f64,
    /// Frames in a row in which the robot is where the stage leads.
    streak: usize,
    /// Frame in which it has been there for long enough.
    succeeded: Option<usize>,
}

impl Course {
    fn take(&mut self, frame: usize, quality: f64, is_there: bool, hold: usize) {
        self.best = self.best.max(quality);
        self.sum += self.best;
        self.streak = if is_there { self.streak + 1 } else { 0 };
        if self.streak >= hold {
            self.succeeded.get_or_insert(frame);
        }
    }

    fn value(&self, frames: usize) -> f64 {
        let success = self.succeeded.map_or(0.0, |frame| SUCCEEDED * (1.0 - 0.5 * frame as f64 / frames as f64));
        self.sum / frames as f64 + success
    }
}

/// One robot, nominal or a twin, and the states in which it lies.
struct Machine {
    name: String,
    simulation: Box<dyn Simulation>,
    /// Generalised positions on the back or a side, and on the belly.
    starts: [Vec<Vec<f64>>; 2],
}

/// All robots.
pub(super) struct Trials {
    robot: Arc<Robot>,
    machines: Vec<Machine>,
    seed: u64,
    starts: usize,
    /// Height of the standing root (m), and weight (N).
    height: f64,
    weight: f64,
}

impl Trials {
    pub(super) fn new(
        plan: &GetUpPlan,
        robot: &Arc<Robot>,
        script: &GetUpScript,
        threads: usize,
    ) -> Result<Self, TrackerError> {
        let root = robot.character.root_joint().map_or(0, |joint| joint.q_index);
        let mut own = Self {
            height: robot.default_position()[root + 2],
            weight: robot.character.mass() * robot.character.gravity.norm(),
            robot: Arc::clone(robot),
            machines: Vec::new(),
            seed: plan.seed,
            starts: plan.starts,
        };
        for twin in std::iter::once(None).chain(plan.twins.iter().copied().map(Some)) {
            let build = |environments: usize| -> Result<Box<dyn Simulation>, TrackerError> {
                let spec = SimulationSpec { threads, ..SimulationSpec::new(environments) };
                Ok(match twin {
                    None => spec.build(Arc::clone(robot))?,
                    Some(seed) => Box::new(Twin::new(robot, &TwinSpec { seed, ..TwinSpec::default() }, &spec)?),
                })
            };
            let starts = own.lay_down(build(DROPPED)?.as_mut(), script)?;
            let name = twin.map_or("nominal".into(), |seed| format!("twin {seed}"));
            if let Some(side) = starts.iter().position(Vec::is_empty) {
                let place = ["the back", "the belly"][side];
                let expected = format!("a script whose 'lie' leaves some robots on {place}");
                return Err(TrackerError::mismatch(name, expected, "none"));
            }
            let simulation = build(plan.candidates * plan.starts)?;
            own.machines.push(Machine { name, simulation, starts });
        }
        Ok(own)
    }

    /// Returns the names of the robots.
    pub(super) fn names(&self) -> impl Iterator<Item = &str> {
        self.machines.iter().map(|machine| machine.name.as_str())
    }

    /// Drops robots, stretches them out by the script, and returns the positions in which they lie: on the back, on the belly.
    fn lay_down(
        &self,
        simulation: &mut dyn Simulation,
        script: &GetUpScript,
    ) -> Result<[Vec<Vec<f64>>; 2], TrackerError> {
        let character = &self.robot.character;
        let (mut positions, mut velocities) = (Vec::new(), Vec::new());
        for number in 0..DROPPED {
            let (mut q, mut v) = (self.robot.default_position(), vec![0.0; character.nv]);
            let mut rng = stream(self.seed, "get up", number as u64, 0);
            fallen::lay_down(character, 0.0, 1.0, &mut rng, &mut q, &mut v);
            positions.extend(q);
            velocities.extend(v);
        }
        let ids: Vec<usize> = (0..DROPPED).collect();
        simulation.reset(&ids, &positions, &velocities)?;
        for _ in 0..self.frames(DROP) {
            let targets = simulation.state().joint_position.clone();
            simulation.step(Drive::Targets(&targets))?;
        }
        let from = simulation.state().joint_position.clone();
        let lie = [script.lie.clone()];
        self.play(simulation, &lie, &from, None, script.lie.iter().map(|key| key.seconds).sum(), |_, _| {})?;
        let (state, mut starts) = (simulation.state(), [Vec::new(), Vec::new()]);
        for i in ids.into_iter().filter(|i| !state.diverged[*i]) {
            let mut q = self.robot.default_position();
            let root = character.root_joint().map_or(0, |joint| joint.q_index);
            q[root + 2] = state.root_position[3 * i + 2].into();
            (0..4).for_each(|k| q[root + 3 + k] = state.root_orientation[4 * i + k].into());
            let joints = self.robot.joints();
            for (j, joint) in character.scalar_joints().enumerate() {
                q[joint.q_index] = state.joint_position[i * joints + j].into();
            }
            character.follow(&mut q, &mut vec![0.0; character.nv]);
            starts[usize::from(axis(state, i, Vec3::x()) < ON_BELLY)].push(q);
        }
        Ok(starts)
    }

    fn frames(&self, seconds: f64) -> usize {
        (seconds * self.robot.control_hz).round().max(1.0) as usize
    }

    /// Plays keys for some seconds and holds the last pose: environment i plays candidate i modulo their number.
    fn play(
        &self,
        simulation: &mut dyn Simulation,
        candidates: &[Vec<Key>],
        from: &[f32],
        mirrored: Option<(&[bool], &lifelike_character::Symmetry)>,
        seconds: f64,
        mut look: impl FnMut(usize, &BatchState),
    ) -> Result<(), TrackerError> {
        let (joints, dt) = (self.robot.joints(), 1.0 / self.robot.control_hz);
        let (mut targets, mut pose) = (from.to_vec(), vec![0.0; joints]);
        for frame in 0..self.frames(seconds) {
            let time = (frame + 1) as f64 * dt;
            for (i, targets) in targets.chunks_exact_mut(joints).enumerate() {
                let keys = &candidates[i % candidates.len()];
                let own = mirrored.filter(|(mirrored, _)| mirrored[i]).map(|(_, symmetry)| symmetry);
                write(keys, &from[i * joints..(i + 1) * joints], own, time, &mut pose, targets);
            }
            simulation.step(Drive::Targets(&targets))?;
            look(frame, simulation.state());
        }
        Ok(())
    }

    /// Tries candidates on all robots, all from the same states of an iteration.
    pub(super) fn run(
        &mut self,
        stage: Stage,
        candidates: &[Vec<Key>],
        iteration: u64,
    ) -> Result<Vec<Outcome>, TrackerError> {
        let mut values = vec![Vec::new(); candidates.len()];
        let mut success = vec![Vec::new(); candidates.len()];
        let mut machines = std::mem::take(&mut self.machines);
        let tried = machines.iter_mut().try_for_each(|machine| {
            for (candidate, (value, share)) in
                self.run_on(machine, stage, candidates, iteration)?.into_iter().enumerate()
            {
                values[candidate].push(value);
                success[candidate].push(share);
            }
            Ok(())
        });
        self.machines = machines;
        tried.map(|()| {
            let outcome = |(values, success): (Vec<f64>, Vec<f64>)| {
                let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
                let worst = values.into_iter().fold(f64::INFINITY, f64::min);
                Outcome { value: 0.5 * (mean + worst), success }
            };
            values.into_iter().zip(success).map(outcome).collect()
        })
    }

    /// Returns each candidate's mean value on one robot, and the share of its trials that succeeded.
    fn run_on(
        &self,
        machine: &mut Machine,
        stage: Stage,
        candidates: &[Vec<Key>],
        iteration: u64,
    ) -> Result<Vec<(f64, f64)>, TrackerError> {
        let (nv, count) = (self.robot.character.nv, candidates.len());
        let all = &machine.starts[usize::from(stage == Stage::Rise)];
        let mut order: Vec<usize> = (0..all.len()).collect();
        order.shuffle(&mut stream(self.seed, "starts", iteration, 0));
        // Environment i: candidate i modulo count, start i / count.
        let starts: Vec<&Vec<f64>> = (0..self.starts * count).map(|i| &all[order[(i / count) % order.len()]]).collect();
        let positions: Vec<f64> = starts.into_iter().flatten().copied().collect();
        let ids: Vec<usize> = (0..self.starts * count).collect();
        let simulation = machine.simulation.as_mut();
        simulation.reset(&ids, &positions, &vec![0.0; ids.len() * nv])?;
        let state = simulation.state();
        let from = state.joint_position.clone();
        let mirrored: Vec<bool> =
            ids.iter().map(|i| stage == Stage::Roll && axis(state, *i, Vec3::y()) < 0.0).collect();
        let symmetry = lifelike_character::Symmetry::derive(&self.robot.character)?;
        let index = usize::from(stage == Stage::Rise);
        let frames = self.frames(LONGEST[index]);
        let hold = self.frames(HOLD[index]);
        let mut courses = vec![Course::default(); ids.len()];
        self.play(simulation, candidates, &from, Some((&mirrored, &symmetry)), LONGEST[index], |frame, state| {
            for (i, course) in courses.iter_mut().enumerate() {
                if !state.diverged[i] {
                    let (quality, is_there) = self.judge(stage, state, i);
                    course.take(frame, quality, is_there, hold);
                }
            }
        })?;
        let outcome = |candidate: usize| {
            let own = (0..self.starts).map(|start| start * count + candidate);
            let mean = own.clone().map(|i| courses[i].value(frames)).sum::<f64>() / self.starts as f64;
            (mean, own.filter(|i| courses[*i].succeeded.is_some()).count() as f64 / self.starts as f64)
        };
        Ok((0..count).map(outcome).collect())
    }

    /// Returns the quality of a state, from 0 to 1, and whether the robot is where the stage leads.
    fn judge(&self, stage: Stage, state: &BatchState, i: usize) -> (f64, bool) {
        let square = |v: &[f32]| v.iter().map(|x| f64::from(*x).powi(2)).sum::<f64>();
        let speed = square(&state.linear_velocity_w[3 * i..3 * i + 3])
            + 0.1 * square(&state.angular_velocity_w[3 * i..3 * i + 3]);
        let slow = 1.0 / (1.0 + SPEED * speed);
        match stage {
            Stage::Roll => {
                let forward = axis(state, i, Vec3::x());
                (0.5 * (1.0 - forward) * slow, forward < FLAT && speed < CALM[0])
            }
            Stage::Rise => {
                let height = (f64::from(state.root_position[3 * i + 2]) / self.height).clamp(0.0, 1.0);
                let up = axis(state, i, Vec3::z());
                let feet = self.robot.anatomy.soles.len();
                let forces = &state.foot_force[i * feet..(i + 1) * feet];
                let carries = forces.iter().all(|force| f64::from(*force) > CARRIES * self.weight);
                let stands = up > UPRIGHT && height > HEIGHT && carries && speed < CALM[1];
                (height * (0.5 + 0.5 * up) * slow, stands)
            }
        }
    }
}

/// Returns the vertical part of an axis of environment `i`'s root.
fn axis(state: &BatchState, i: usize, axis: Vec3) -> f64 {
    let wxyz: [f64; 4] = std::array::from_fn(|k| state.root_orientation[4 * i + k].into());
    from_wxyz(wxyz).map_or(0.0, |turn| (turn * axis).z)
}

/// Writes the pose at a time (s), as [`lifelike_robot::GetUp`] goes from key to key; the last pose holds. `pose` is scratch.
fn write(
    keys: &[Key],
    from: &[f32],
    mirror: Option<&lifelike_character::Symmetry>,
    mut time: f64,
    pose: &mut [f32],
    out: &mut [f32],
) {
    let mut number = 0;
    while number + 1 < keys.len() && time > keys[number].seconds {
        time -= keys[number].seconds;
        number += 1;
    }
    let share = (time / keys[number].seconds).min(1.0) as f32;
    let weight = share * share * (3.0 - 2.0 * share);
    let copy = |key: &Key, to: &mut [f32]| match mirror {
        None => to.copy_from_slice(&key.pose),
        Some(symmetry) => {
            for (joint, (partner, sign)) in symmetry.joint.iter().zip(&symmetry.sign).enumerate() {
                to[*partner] = *sign as f32 * key.pose[joint];
            }
        }
    };
    copy(&keys[number], out);
    match number {
        0 => pose.copy_from_slice(from),
        number => copy(&keys[number - 1], pose),
    }
    for (target, before) in out.iter_mut().zip(&*pose) {
        *target = before + (*target - before) * weight;
    }
}
