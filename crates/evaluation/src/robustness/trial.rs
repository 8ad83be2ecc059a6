//! One size of one disturbance.

use std::sync::Arc;

use lifelike_checkpoint::rng::stream;
use lifelike_motion::MotionClip;
use lifelike_robot::{LatentEncoder, Robot};
use lifelike_sim::{EnvironmentParameters, Terrain};
use rand::Rng;

use super::disturbance::Disturbance;
use super::options::{Ground, RobustnessOptions};
use super::push::pushes;
use super::stairs::{climb, climbers};
use super::switches::stretches;
use crate::EvaluationError;
use crate::{Course, Evaluation, EvaluationOptions, Hardship, Task};
use lifelike_tracking::Policy;

/// Hills: side of the ground, distance of its heights, longest wave (m), and how many different ones.
const HILLS: (f64, f64, f64) = (60.0, 0.1, 3.0);
/// See [`HILLS`].
const LANDSCAPES: u64 = 3;
/// One disturbance of a policy.
pub(super) struct Trial<'a> {
    pub(super) policy: &'a Policy,
    pub(super) robot: &'a Arc<Robot>,
    pub(super) clips: &'a [MotionClip],
    pub(super) prior: Option<&'a dyn LatentEncoder>,
    pub(super) ground: Ground<'a>,
    pub(super) most: usize,
    pub(super) options: &'a RobustnessOptions,
    pub(super) plain: &'a Course<'a>,
    pub(super) disturbance: Disturbance,
}

impl Trial<'_> {
    /// The evaluations of one size: several on hills, none where the robot or the clips have not what is disturbed.
    pub(super) fn run(&self, size: f64) -> Result<Vec<Evaluation>, EvaluationError> {
        let (robot, seed) = (self.robot, self.options.seed);
        let level =
            |course: &Course<'_>, hardship: &dyn Fn(&Task) -> Hardship| -> Result<Vec<Evaluation>, EvaluationError> {
                let simulation = (self.ground)(None, course.tasks().len().clamp(1, self.most))?;
                Ok(vec![course.run(simulation, hardship, |_, _| {})?])
            };
        let differing = |parameters: EnvironmentParameters| Hardship { parameters, ..Hardship::default() };
        match self.disturbance {
            Disturbance::Push(part) if part.bodies(robot).is_empty() => Ok(Vec::new()),
            Disturbance::Push(part) => level(self.plain, &|task| Hardship {
                pushes: pushes(robot, part, size, task, seed),
                ..Hardship::default()
            }),
            Disturbance::Friction => level(self.plain, &|_| {
                differing(EnvironmentParameters { ground_friction: Some(size as f32), ..Default::default() })
            }),
            Disturbance::Mass => level(self.plain, &|_| {
                let mass_scale = vec![size as f32; robot.character.bodies.len()];
                differing(EnvironmentParameters { mass_scale, ..Default::default() })
            }),
            Disturbance::Calibration => level(self.plain, &|task| {
                let mut rng = stream(seed, "robustness calibration", task.number as u64, 0);
                let joint_offset = (0..robot.joints()).map(|_| size as f32 * rng.random_range(-1.0..=1.0)).collect();
                differing(EnvironmentParameters { joint_offset, ..Default::default() })
            }),
            Disturbance::Hills => self.hills(size),
            Disturbance::Stairs => {
                let Some(course) = self.stairs(size)? else { return Ok(Vec::new()) };
                level(&course, &|_| Hardship::default())
            }
            Disturbance::Switches => {
                let every = (robot.control_hz / size).round() as usize;
                let frames = (self.options.evaluation.seconds * robot.control_hz).round() as usize;
                level(self.plain, &|task| Hardship {
                    stretches: if size > 0.0 {
                        stretches(self.plain.library(), task, frames, every, seed)
                    } else {
                        Vec::new()
                    },
                    ..Hardship::default()
                })
            }
        }
    }

    fn hills(&self, height: f64) -> Result<Vec<Evaluation>, EvaluationError> {
        let (side, spacing, wavelength) = HILLS;
        let landscape = |number: u64| {
            let seed = stream(self.options.seed, "robustness hills", number, 0).random();
            let terrain = Arc::new(Terrain::hills(side, spacing, height, wavelength, seed)?);
            let simulation = (self.ground)(Some(terrain), self.plain.tasks().len().clamp(1, self.most))?;
            let hardship = |task: &Task| {
                let mut rng = stream(self.options.seed, "robustness spot", task.number as u64, number);
                let mut along = || 0.25 * side * rng.random_range(-1.0..=1.0);
                Hardship { spot: [along(), along()], ..Hardship::default() }
            };
            self.plain.run(simulation, hardship, |_, _| {})
        };
        (0..LANDSCAPES).map(landscape).collect()
    }

    /// The clips that walk, climbing by so much at every footfall.
    fn stairs(&self, step: f64) -> Result<Option<Course<'_>>, EvaluationError> {
        let walking = climbers(self.clips, self.robot, &self.options.evaluation)?;
        if walking.is_empty() {
            return Ok(None);
        }
        let change = |clip: &mut MotionClip| Ok(climb(clip, self.robot, step)?);
        let options = EvaluationOptions { starts: 1, ..self.options.evaluation.clone() };
        Course::changed(self.policy, self.robot, &walking, self.prior, &options, change).map(Some)
    }
}
