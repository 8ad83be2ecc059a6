//! One size of one disturbance.

use std::sync::Arc;

use lifelike_checkpoint::rng::stream;
use lifelike_motion::MotionClip;
use lifelike_sim::{EnvironmentParameters, Terrain};
use rand::Rng;

use super::disturbance::Disturbance;
use super::options::RobustnessOptions;
use super::push::{punches, pushes};
use super::stairs::{climb, stair_clips};
use super::switches::segments;
use crate::EvaluationError;
use crate::{Episode, EpisodeConditions, Evaluation, EvaluationOptions, EvaluationSetup, EvaluationSuite};

/// Hills: side of the ground, distance of its heights, longest wave (m), and how many different ones.
const HILLS: (f64, f64, f64) = (60.0, 0.1, 3.0);
/// See [`HILLS`].
const LANDSCAPES: u64 = 3;
/// One disturbance of a policy.
pub(super) struct Trial<'a> {
    pub(super) setup: &'a EvaluationSetup<'a>,
    pub(super) clips: &'a [MotionClip],
    pub(super) options: &'a RobustnessOptions,
    pub(super) plain: &'a EvaluationSuite<'a>,
    pub(super) disturbance: Disturbance,
}

impl Trial<'_> {
    /// The evaluations of one size: several on hills, none where the robot or the clips have not what is disturbed.
    pub(super) fn run(&self, size: f64) -> Result<Vec<Evaluation>, EvaluationError> {
        let (robot, seed) = (self.setup.robot(), self.options.seed);
        let level = |suite: &EvaluationSuite<'_>,
                     conditions: &dyn Fn(&Episode) -> EpisodeConditions|
         -> Result<Vec<Evaluation>, EvaluationError> {
            let simulation = (self.setup.simulate)(None, self.width(suite))?;
            Ok(vec![suite.run(simulation, conditions, |_, _| {})?])
        };
        let differing =
            |parameters: EnvironmentParameters| EpisodeConditions { parameters, ..EpisodeConditions::default() };
        match self.disturbance {
            Disturbance::Push(part) if part.bodies(robot).is_empty() => Ok(Vec::new()),
            Disturbance::Push(part) => level(self.plain, &|episode| EpisodeConditions {
                pushes: pushes(robot, part, size, episode, seed),
                ..EpisodeConditions::default()
            }),
            Disturbance::Punches => level(self.plain, &|episode| EpisodeConditions {
                pushes: punches(robot, size, episode, seed),
                ..EpisodeConditions::default()
            }),
            Disturbance::Friction => level(self.plain, &|_| {
                differing(EnvironmentParameters { ground_friction: Some(size as f32), ..Default::default() })
            }),
            Disturbance::Mass => level(self.plain, &|_| {
                let mass_scale = vec![size as f32; robot.character.bodies.len()];
                differing(EnvironmentParameters { mass_scale, ..Default::default() })
            }),
            Disturbance::Calibration => level(self.plain, &|episode| {
                let mut rng = stream(seed, "robustness calibration", episode.number as u64, 0);
                let joint_offset = (0..robot.joints()).map(|_| size as f32 * rng.random_range(-1.0..=1.0)).collect();
                differing(EnvironmentParameters { joint_offset, ..Default::default() })
            }),
            Disturbance::Hills => self.hills(size),
            Disturbance::Stairs => {
                let Some(suite) = self.stairs(size)? else { return Ok(Vec::new()) };
                level(&suite, &|_| EpisodeConditions::default())
            }
            Disturbance::Switches => {
                let every = (robot.control_hz / size).round() as usize;
                let frames = (self.options.evaluation.seconds * robot.control_hz).round() as usize;
                level(self.plain, &|episode| EpisodeConditions {
                    segments: if size > 0.0 {
                        segments(self.plain.library(), episode, frames, every, seed)
                    } else {
                        Vec::new()
                    },
                    ..EpisodeConditions::default()
                })
            }
        }
    }

    /// Environments for a suite.
    fn width(&self, suite: &EvaluationSuite<'_>) -> usize {
        suite.episodes().len().clamp(1, self.setup.environments.max(1))
    }

    fn hills(&self, height: f64) -> Result<Vec<Evaluation>, EvaluationError> {
        let (side, spacing, wavelength) = HILLS;
        let landscape = |number: u64| {
            let seed = stream(self.options.seed, "robustness hills", number, 0).random();
            let terrain = Arc::new(Terrain::hills(side, spacing, height, wavelength, seed)?);
            let simulation = (self.setup.simulate)(Some(terrain), self.width(self.plain))?;
            let conditions = |episode: &Episode| {
                let mut rng = stream(self.options.seed, "robustness spot", episode.number as u64, number);
                let mut along = || 0.25 * side * rng.random_range(-1.0..=1.0);
                EpisodeConditions { position: [along(), along()], ..EpisodeConditions::default() }
            };
            self.plain.run(simulation, conditions, |_, _| {})
        };
        (0..LANDSCAPES).map(landscape).collect()
    }

    /// The clips that walk, climbing by so much at every footfall.
    fn stairs(&self, step: f64) -> Result<Option<EvaluationSuite<'_>>, EvaluationError> {
        let walking = stair_clips(self.clips, self.setup.robot(), &self.options.evaluation)?;
        if walking.is_empty() {
            return Ok(None);
        }
        let change = |clip: &mut MotionClip| Ok(climb(clip, self.setup.robot(), step)?);
        let options = EvaluationOptions { starts: 1, ..self.options.evaluation.clone() };
        EvaluationSuite::changed(self.setup, &walking, &options, change).map(Some)
    }
}
