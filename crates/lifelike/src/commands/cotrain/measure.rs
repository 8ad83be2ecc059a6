//! Generators beside trackers.

use lifelike_evaluation::{Evaluation, EvaluationOptions};
use lifelike_generation::align::PhysicsMarks;
use lifelike_motion::MotionClip;
use lifelike_report::{Cell, Column, Table};
use serde::{Deserialize, Serialize};

/// One generator's motion, followed by one tracker.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Pair {
    /// Round of the generator; 0: what the run began with.
    pub generator: usize,
    /// Round of the tracker; 0: what the run began with.
    pub tracker: usize,
    /// Motions.
    pub motions: usize,
    /// Share of motions followed without a fall.
    pub survival: f64,
    /// Share of those with the mean body error never above 0.5 m.
    pub success: f64,
    /// Mean absolute joint error before a fall (deg).
    pub joint_error_deg: f64,
    /// Mean error of the root's orientation before a fall (deg).
    pub root_rotation_error_deg: f64,
    /// The judge's marks; none in records of before.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub physics: Option<PhysicsMarks>,
}

impl Pair {
    /// Sums up an evaluation.
    pub fn of(generator: usize, tracker: usize, evaluation: &Evaluation) -> Self {
        let all = &evaluation.overall;
        // JSON has no NaN, and who falls at once has no error.
        let known = |error: f64| if error.is_finite() { error } else { 0.0 };
        Self {
            generator,
            tracker,
            motions: all.episodes,
            survival: all.survival,
            success: all.success,
            joint_error_deg: known(all.joint_error_deg),
            root_rotation_error_deg: known(all.root_rotation_error_deg),
            physics: None,
        }
    }
}

/// Returns the round of the generator that gets on best in physics with a tracker: the judge's marks relative to those of
/// round 0, the earliest of equal ones.
pub fn best_round(pairs: &[Pair], tracker: usize) -> usize {
    let marks = |generator: usize| {
        let of = |pair: &&Pair| (pair.generator, pair.tracker) == (generator, tracker);
        pairs.iter().find(of).and_then(|pair| pair.physics)
    };
    let Some(before) = marks(0) else { return 0 };
    let rounds = (1..).map_while(|round| Some((round, marks(round)?.relative_to(&before))));
    rounds.fold((0, 1.0), |best, now| if now.1 < best.1 { now } else { best }).0
}

/// Returns whole motions as episodes, each from its start.
pub fn episodes(clips: &[MotionClip]) -> EvaluationOptions {
    let seconds = clips.iter().map(MotionClip::seconds).fold(0.0, f64::max);
    EvaluationOptions { seconds, starts: 1, keep: 0, ..EvaluationOptions::default() }
}

/// Returns the table of all pairs.
pub fn table(pairs: &[Pair]) -> Table {
    let columns = [
        ("generator", ""),
        ("tracker", ""),
        ("motions", ""),
        ("survival", "%"),
        ("success", "%"),
        ("joints", "deg"),
        ("root rot.", "deg"),
        ("falls", "%"),
        ("lin. vel.", "m/s"),
        ("ang. vel.", "rad/s"),
        ("tilt", "deg"),
        ("upper", "deg"),
        ("lower", "deg"),
    ];
    let columns = columns.map(|(name, unit)| Column::number(name, unit)).to_vec();
    let mut table = Table::new("Every generator with every tracker", columns);
    table.caption = "By their rounds; 0 is what the run began with. Motions of sentences that nothing was trained on, \
                     whole, from their start, without noise; errors are means before a fall. The columns from falls on are \
                     the judge's episodes by the thesis' protocol, errors over all frames (thesis Table 5.3)."
        .into();
    let row = |pair: &Pair| {
        let judged = |marks: PhysicsMarks| {
            let [falls, errors @ ..] = marks.row();
            [Cell::number(100.0 * falls, 1)].into_iter().chain(errors.map(|error| Cell::number(error, 3))).collect()
        };
        let judged: Vec<Cell> = pair.physics.map_or_else(|| vec![Cell::text("–"); 6], judged);
        let own = vec![
            Cell::number(pair.generator as f64, 0),
            Cell::number(pair.tracker as f64, 0),
            Cell::number(pair.motions as f64, 0),
            Cell::number(100.0 * pair.survival, 1),
            Cell::number(100.0 * pair.success, 1),
            Cell::number(pair.joint_error_deg, 2),
            Cell::number(pair.root_rotation_error_deg, 2),
        ];
        [own, judged].concat()
    };
    table.rows = pairs.iter().map(row).collect();
    table
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_round_that_falls_least_with_the_last_tracker_is_the_best() {
        let pair = |generator, tracker, falls| {
            let physics = Some(PhysicsMarks { falls, errors: [1.0; 5] });
            Pair { generator, tracker, physics, ..Pair::default() }
        };
        let pairs =
            [pair(0, 0, 0.6), pair(1, 0, 0.1), pair(0, 1, 0.5), pair(1, 1, 0.4), pair(2, 1, 0.2), pair(3, 1, 0.2)];
        assert_eq!((best_round(&pairs, 1), best_round(&pairs, 0), best_round(&pairs, 7)), (2, 1, 0));
        assert_eq!(
            best_round(&[pair(0, 0, 0.5), pair(1, 0, 0.7)], 0),
            0,
            "the beginning is kept where nothing is better"
        );
    }
}
