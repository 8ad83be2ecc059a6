//! Best of N: the cheapest way to feasible motion, beside an alignment. One of several motions of a sentence is kept.

use lifelike_evaluation::{EpisodeScore, EvaluationOptions};
use lifelike_motion::MotionClip;

use crate::commands::eval::Job;
use crate::error::CliError;
use crate::output::Output;

/// Cost of a fall beside that of any error (m).
const FALL: f64 = 1000.0;

/// Judge of candidates.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum By {
    /// The critic's mean value over the rows.
    Critic,
    /// A policy in physics: without a fall first, then the least mean body error in the world.
    Physics,
}

impl By {
    /// Returns its name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Critic => "critic",
            Self::Physics => "physics",
        }
    }
}

/// Returns the cost of every clip in physics, played once from its start: lower is better.
pub fn costs(job: &Job<'_>, clips: &[MotionClip], output: &Output) -> Result<Vec<f64>, CliError> {
    let seconds = clips.iter().map(MotionClip::seconds).fold(0.0, f64::max);
    let options = EvaluationOptions { seconds, starts: 1, keep: 0, ..EvaluationOptions::default() };
    // Candidates of one sentence have one name, and scores are by name.
    let named = |(i, clip): (usize, &MotionClip)| MotionClip { name: format!("candidate-{i:05}"), ..clip.clone() };
    let clips: Vec<MotionClip> = clips.iter().enumerate().map(named).collect();
    let evaluation = job.run(&clips, &options, output)?;
    if evaluation.episodes.len() != clips.len() {
        let message = format!("expected {} episodes, got {}", clips.len(), evaluation.episodes.len());
        return Err(CliError::Failed(message));
    }
    let of = |e: &EpisodeScore| cost(e.survived, e.frames as f64 / e.planned_frames.max(1) as f64, e.body_error_m);
    Ok(evaluation.episodes.iter().map(of).collect())
}

/// Returns the cost of an episode: the error (m) of one that survives; else more, the less of it was reached.
fn cost(survived: bool, reached: f64, error: f64) -> f64 {
    if survived && error.is_finite() { error } else { FALL * (2.0 - reached) }
}

/// Returns whether a cost is that of a fall.
pub fn is_fall(cost: f64) -> bool {
    cost >= FALL
}

/// Returns the number of the least cost, the first of equal ones.
pub fn least(costs: &[f64]) -> Option<usize> {
    (0..costs.len()).min_by(|a, b| costs[*a].total_cmp(&costs[*b]))
}

/// Returns of each group of clips the one with the least cost.
pub fn chosen(job: &Job<'_>, groups: Vec<Vec<MotionClip>>, output: &Output) -> Result<Vec<MotionClip>, CliError> {
    let all: Vec<MotionClip> = groups.iter().flatten().cloned().collect();
    let costs = costs(job, &all, output)?;
    let mut first = 0;
    let best = groups.into_iter().filter_map(|mut group| {
        let own = &costs[first..first + group.len()];
        first += group.len();
        least(own).map(|best| group.swap_remove(best))
    });
    Ok(best.collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn who_stays_on_its_feet_is_before_who_falls_and_a_late_fall_before_an_early_one() {
        let costs = [cost(false, 0.9, 0.01), cost(true, 1.0, 0.7), cost(true, 1.0, 0.2), cost(false, 0.1, f64::NAN)];
        assert_eq!(costs, [1100.0, 0.7, 0.2, 1900.0]);
        assert_eq!((least(&costs), least(&[3.0, 1.0, 1.0]), least(&[])), (Some(2), Some(1), None));
    }
}
