//! Getting up: a controller in robots that were dropped, and the share that stands.
//!
//! Each robot begins turned anyhow, with joints anywhere in their ranges, and falls for [`DROP`] while motors only brake. Then the
//! controller is asked to stand in the default pose. With a script, the script gets up first, and again after each fall.
//!
//! A robot stands in a step when it is upright within [`UPRIGHT`] and its root above [`HEIGHT_SHARE`] of the stand's height. Both
//! feet carry weight then, and nothing else is within [`CLEARANCE`] of the ground. It is up from the first step of [`HOLD`] in
//! which it stands throughout.

use std::sync::Arc;

use lifelike_character::rotation::from_wxyz;
use lifelike_character::{Kinematics, Vec3, anatomy};
use lifelike_checkpoint::rng::stream;
use lifelike_report::{Cell, Column, Playback, Table};
use lifelike_robot::reference::standing_clip;
use lifelike_robot::{GetUp, GetUpScript, ReferenceLibrary, Robot};
use lifelike_sim::{BatchState, fallen};

use crate::episode::EpisodeConditions;
use crate::error::EvaluationError;
use crate::recorder::Recorder;
use crate::rollout::Rollout;
use crate::runner::Runner;
use crate::setup::EvaluationSetup;
use crate::tables::playback;

/// Time for which a robot falls before it is asked to get up (s).
pub const DROP: f64 = 2.0;
/// Greatest angle between the up axis of a robot that stands and the vertical (rad; 20 deg).
pub const UPRIGHT: f64 = 0.349;
/// Least share of the standing root's height of a robot that stands.
pub const HEIGHT_SHARE: f64 = 0.85;
/// Time without a break that makes a stand (s).
pub const HOLD: f64 = 1.0;
/// Least height of all but the feet above the ground (m).
pub const CLEARANCE: f64 = 0.002;
/// Tilt at which a script begins anew (rad).
const FALLEN: f64 = 1.0;
/// A foot carries weight from this share of the robot's on.
const CARRIES: f64 = 0.02;
/// Episodes that are recorded.
const RECORDED: usize = 6;

/// Extent of the measure.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GetUpOptions {
    /// Number of dropped robots.
    pub episodes: usize,
    /// Longest time to get up (s).
    pub seconds: f64,
    /// Seed of the poses.
    pub seed: u64,
}

/// The measure.
#[derive(Debug, Clone, serde::Serialize)]
pub struct Risen {
    /// The robot.
    pub robot: String,
    /// The engine.
    pub engine: String,
    /// Seed of the poses.
    pub seed: u64,
    /// Longest time to get up (s).
    pub seconds: f64,
    /// Time after which each robot was up (s); none where it never was.
    pub up: Vec<Option<f64>>,
    /// Share that stood through the last second.
    pub standing_at_end: f64,
    /// The first episodes, to be looked at; not part of the JSON.
    #[serde(skip)]
    pub rollouts: Vec<Rollout>,
}

impl Risen {
    /// Returns the share that was up within a time (s).
    pub fn within(&self, seconds: f64) -> f64 {
        let up = self.up.iter().filter(|up| up.is_some_and(|time| time <= seconds)).count();
        up as f64 / self.up.len().max(1) as f64
    }

    /// Returns the time within which half of all robots were up (s); none where fewer were.
    pub fn median(&self) -> Option<f64> {
        let mut times: Vec<f64> = self.up.iter().map(|up| up.unwrap_or(f64::INFINITY)).collect();
        times.sort_by(f64::total_cmp);
        times.get(times.len() / 2).copied().filter(|time| time.is_finite())
    }

    /// Returns the measure as a table.
    pub fn table(&self) -> Table {
        let half = 0.5 * self.seconds;
        let columns = [
            Column::number("dropped", ""),
            Column::number(&format!("up in {half} s"), "%"),
            Column::number(&format!("up in {} s", self.seconds), "%"),
            Column::number("stand at end", "%"),
            Column::number("median", "s"),
        ];
        let mut table = Table::new("Getting up", columns.into());
        let percent = |share: f64| Cell::number(100.0 * share, 1);
        let median = self.median().map_or(Cell::number(f64::NAN, 1), |time| Cell::number(time, 1));
        table.rows = vec![vec![
            Cell::number(self.up.len() as f64, 0),
            percent(self.within(half)),
            percent(self.within(self.seconds)),
            percent(self.standing_at_end),
            median,
        ]];
        table
    }

    /// Returns the recorded episodes.
    pub fn playbacks(&self) -> Vec<Playback> {
        self.rollouts.iter().map(playback).collect()
    }
}

impl EvaluationSetup<'_> {
    /// Drops robots and asks the controller to stand, after a script where there is one; measures how many do. `progress` gets
    /// the number of episodes that are done, and of all.
    ///
    /// # Errors
    /// The controller or the simulation does not fit the robot, or the simulation fails as a whole.
    pub fn get_up(
        &self,
        script: Option<&GetUpScript>,
        options: &GetUpOptions,
        mut progress: impl FnMut(usize, usize),
    ) -> Result<Risen, EvaluationError> {
        let (robot, hz) = (self.robot(), self.robot().control_hz);
        let frames = |seconds: f64| (seconds * hz).round().max(1.0) as usize;
        let (steps, hold) = (frames(options.seconds + HOLD), frames(HOLD));
        let clip = standing_clip(robot, (steps + 2) as f64 / hz);
        let library = ReferenceLibrary::new(robot, &[clip], self.latent_encoder()?)?;
        let width = options.episodes.min(self.environments).max(1);
        let simulation = (self.simulate)(None, width)?;
        let engine = simulation.engine().to_owned();
        let mut runner = Runner::new(self.controller, &library, simulation)?;
        let recorder = Recorder::new(robot, &library, &[]);
        let script = script.map(|script| GetUp::new(script, Arc::clone(robot))).transpose()?;
        let mut stance = Stance::new(robot, f64::from(library.position_at(0)[2]));
        let mut kinematics = Kinematics::new(&robot.character);
        let (mut up, mut standing, mut rollouts) = (Vec::new(), 0, Vec::new());
        for first in (0..options.episodes).step_by(width) {
            let count = width.min(options.episodes - first);
            runner.begin(&vec![0; count], &vec![EpisodeConditions::default(); count])?;
            let (positions, velocities) = poses(robot, options.seed, first..first + count);
            runner.drop(&positions, &velocities, frames(DROP))?;
            let kept = if first == 0 { count.min(RECORDED) } else { 0 };
            let mut own: Vec<Rollout> = (0..kept).map(|_| recorder.begin(0, steps)).collect();
            let mut stands = vec![Vec::with_capacity(steps); count];
            let mut scripts = vec![script.clone(); count];
            for (i, script) in scripts.iter_mut().enumerate() {
                begin(script, &mut runner, i);
            }
            // Robots that the controller drives.
            let mut driven = vec![script.is_none(); count];
            for _ in 0..steps {
                for (i, rollout) in own.iter_mut().enumerate() {
                    recorder.record(rollout, &runner.moment(i), &mut kinematics);
                }
                for (i, script) in scripts.iter_mut().enumerate() {
                    let Some(script) = script.as_mut().filter(|_| !driven[i]) else { continue };
                    driven[i] = runner.get_up(i, script);
                    if driven[i] {
                        runner.take_over(i)?;
                    }
                }
                runner.step(|i| driven[i])?;
                for (i, (stands, script)) in stands.iter_mut().zip(&mut scripts).enumerate() {
                    stands.push(stance.holds(robot, runner.moment(i).state, i));
                    if script.is_some() && driven[i] && uprightness(runner.moment(i).state, i) < FALLEN.cos() {
                        driven[i] = false;
                        begin(script, &mut runner, i);
                    }
                }
            }
            up.extend(stands.iter().map(|stands| first_run(stands, hold).map(|step| step as f64 / hz)));
            standing += stands.iter().filter(|stands| stands.iter().rev().take(hold).all(|stands| *stands)).count();
            rollouts.extend(own);
            progress(first + count, options.episodes);
        }
        let standing_at_end = standing as f64 / options.episodes.max(1) as f64;
        let GetUpOptions { seconds, seed, .. } = *options;
        Ok(Risen { robot: robot.name.clone(), engine, seed, seconds, up, standing_at_end, rollouts })
    }
}

/// Begins a script from where the joints of robot `i` are.
fn begin(script: &mut Option<GetUp>, runner: &mut Runner<'_>, i: usize) {
    let joints = &runner.moment(i).state.joint_position;
    if let Some(script) = script {
        script.begin(&joints[i * script.joints()..(i + 1) * script.joints()]);
    }
}

/// Returns the vertical part of the up axis of robot `i`.
fn uprightness(state: &BatchState, i: usize) -> f64 {
    let wxyz: [f64; 4] = std::array::from_fn(|k| state.root_orientation[4 * i + k].into());
    from_wxyz(wxyz).map_or(-1.0, |turn| (turn * Vec3::z()).z)
}

/// Returns the place of the first `length` values in a row that are true.
fn first_run(values: &[bool], length: usize) -> Option<usize> {
    values.windows(length.max(1)).position(|window| window.iter().all(|value| *value))
}

/// Returns the states from which robots of these numbers drop.
fn poses(robot: &Robot, seed: u64, numbers: std::ops::Range<usize>) -> (Vec<f64>, Vec<f64>) {
    let (mut positions, mut velocities) = (Vec::new(), Vec::new());
    for number in numbers {
        let (mut q, mut v) = (robot.default_position(), vec![0.0; robot.character.nv]);
        let mut rng = stream(seed, "get up", number as u64, 0);
        fallen::lay_down(&robot.character, 0.0, 1.0, &mut rng, &mut q, &mut v);
        positions.extend(q);
        velocities.extend(v);
    }
    (positions, velocities)
}

/// Judge of single steps.
struct Stance {
    kinematics: Kinematics,
    /// Least height of the root (m).
    height: f64,
    /// Least force of a foot that carries weight (N).
    force: f64,
}

impl Stance {
    /// Returns the judge for a robot whose root stands at this height (m).
    fn new(robot: &Robot, standing: f64) -> Self {
        let character = &robot.character;
        Self {
            kinematics: Kinematics::new(character),
            height: HEIGHT_SHARE * standing,
            force: CARRIES * character.mass() * character.gravity.norm(),
        }
    }

    /// Returns whether robot `i` stands on its feet alone, on level ground.
    fn holds(&mut self, robot: &Robot, state: &BatchState, i: usize) -> bool {
        let (character, soles) = (&robot.character, &robot.anatomy.soles);
        let forces = &state.foot_force[i * soles.len()..(i + 1) * soles.len()];
        if state.diverged[i]
            || uprightness(state, i) < UPRIGHT.cos()
            || f64::from(state.root_position[3 * i + 2]) < self.height
            || forces.iter().any(|force| f64::from(*force) < self.force)
        {
            return false;
        }
        let bodies = character.bodies.len();
        for body in 0..bodies {
            let at = i * bodies + body;
            let p: [f64; 3] = std::array::from_fn(|k| state.body_position[3 * at + k].into());
            let q: [f64; 4] = std::array::from_fn(|k| state.body_orientation[4 * at + k].into());
            self.kinematics.body_position[body] = Vec3::from(p);
            self.kinematics.body_orientation[body] = from_wxyz(q).unwrap_or_default();
        }
        let is_foot = |body: usize| soles.values().any(|sole| sole.body == body);
        let solid = |geom: &&lifelike_character::Geom| geom.body != 0 && (geom.contype | geom.conaffinity) != 0;
        let others = character.geoms.iter().filter(solid).filter(|geom| !is_foot(geom.body));
        others.flat_map(|geom| anatomy::lowest(geom, &self.kinematics)).all(|point| point.z > CLEARANCE)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use lifelike_sim::{Drive, SimulationSpec};

    use super::*;

    #[test]
    fn a_run_begins_where_nothing_breaks_it() {
        let values = [true, false, true, true, true, false];
        assert_eq!((first_run(&values, 2), first_run(&values, 3), first_run(&values, 4)), (Some(2), Some(2), None));
    }

    #[test]
    fn shares_and_median_by_hand() {
        let up = vec![Some(1.0), None, Some(5.0), Some(7.0)];
        let found = Risen {
            robot: "r".into(),
            engine: "e".into(),
            seed: 1,
            seconds: 10.0,
            up,
            standing_at_end: 0.5,
            rollouts: Vec::new(),
        };
        assert_eq!((found.within(5.0), found.within(10.0), found.median()), (0.5, 0.75, Some(7.0)));
    }

    #[test]
    fn lima_stands_on_its_feet_and_neither_on_its_head_nor_on_its_knees() {
        let robot = Arc::new(Robot::load("lima").unwrap());
        let mut simulation = SimulationSpec::new(3).build(Arc::clone(&robot)).unwrap();
        let stand = robot.default_position();
        // Upside down on its head, and upright with its shanks on the ground.
        let (mut head, mut knees) = (stand.clone(), stand.clone());
        (head[2], head[3], head[4]) = (0.41, 0.0, 1.0);
        let knee = robot.character.joints.iter().filter(|joint| joint.name.ends_with("_knee"));
        knee.for_each(|joint| knees[joint.q_index] = 1.9);
        knees[2] = 0.25;
        let q = [stand, head, knees].concat();
        simulation.reset(&[0, 1, 2], &q, &vec![0.0; 3 * robot.character.nv]).unwrap();
        let targets: Vec<f32> = simulation.state().joint_position.clone();
        for _ in 0..5 {
            simulation.step(Drive::Targets(&targets)).unwrap();
        }
        let mut stance = Stance::new(&robot, 0.44);
        assert_eq!([0, 1, 2].map(|i| stance.holds(&robot, simulation.state(), i)), [true, false, false]);
    }
}
