//! Runs every size of every disturbance.

use lifelike_motion::MotionClip;

use super::curve::{Point, Robustness, RobustnessCurve};
use super::options::RobustnessOptions;
use super::trial::Trial;
use crate::EvaluationError;
use crate::{ClipScore, EvaluationSetup, EvaluationSuite, Outcome, Rollout};

/// A curve that grows stops after the first size at which no more survive than this share.
const GONE: f64 = 0.02;

/// Survival and error of a policy on clips against every disturbance of the options, deterministically for their seed.
///
/// `progress` is told which disturbance and size is done, and how many of how many.
///
/// # Errors
/// As [`EvaluationSuite::new`], and what the simulations fail with.
pub fn sweep(
    setup: &EvaluationSetup<'_>,
    clips: &[MotionClip],
    options: &RobustnessOptions,
    mut progress: impl FnMut(&str, usize, usize),
) -> Result<Robustness, EvaluationError> {
    let plain = EvaluationSuite::new(setup, clips, &options.evaluation)?;
    let total: usize = options.disturbances.iter().map(|d| options.sizes_of(*d).len()).sum();
    let (mut before, mut engine, mut curves, mut rollouts) = (0, String::new(), Vec::new(), Vec::new());
    for &disturbance in &options.disturbances {
        let trial = Trial { setup, clips, options, plain: &plain, disturbance };
        let sizes = options.sizes_of(disturbance);
        let (mut points, mut seen) = (Vec::new(), Seen::default());
        for (k, &size) in sizes.iter().enumerate() {
            let label = format!("{} {size} {}", disturbance.name(), disturbance.unit());
            progress(&label, before + k, total);
            let evaluations = trial.run(size)?;
            let episodes: Vec<_> = evaluations.iter().flat_map(|e| &e.episodes).collect();
            if episodes.is_empty() {
                break;
            }
            let score = ClipScore::of(disturbance.name(), &episodes);
            for evaluation in evaluations {
                engine = evaluation.engine;
                seen.look(evaluation.rollouts, &label, score.survival);
            }
            let gone = score.survival <= GONE && disturbance.grows();
            points.push(Point { size, score });
            if gone {
                break;
            }
        }
        before += sizes.len();
        rollouts.extend(seen.survived.into_iter().chain(seen.fell));
        if !points.is_empty() {
            let (name, unit, what) = (disturbance.name(), disturbance.unit(), disturbance.words());
            curves.push(RobustnessCurve { disturbance, name, unit, what, points });
        }
    }
    progress("", total, total);
    let clips = clips.iter().map(|c| c.name.clone()).collect();
    let (robot, seed, episode_seconds) = (setup.robot().name.clone(), options.seed, options.evaluation.seconds);
    Ok(Robustness { robot, engine, seed, clips, episode_seconds, curves, rollouts })
}

/// The episodes of a curve that are worth looking at.
#[derive(Default)]
struct Seen {
    /// Of the hardest size that one survived.
    survived: Option<Rollout>,
    /// Of the mildest size that most did not survive, or else of the hardest at all.
    fell: Option<Rollout>,
    most_fell: bool,
}

impl Seen {
    fn look(&mut self, rollouts: Vec<Rollout>, label: &str, survival: f64) {
        for mut rollout in rollouts {
            rollout.clip = format!("{label}: {}", rollout.clip);
            if rollout.outcome == Outcome::Survived {
                self.survived = Some(rollout);
            } else if !self.most_fell {
                self.most_fell = survival < 0.5;
                self.fell = Some(rollout);
            }
        }
    }
}
