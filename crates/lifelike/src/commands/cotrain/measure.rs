//! Generators beside trackers.

use lifelike_evaluation::{Evaluation, EvaluationOptions};
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
        }
    }
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
    ];
    let columns = columns.map(|(name, unit)| Column::number(name, unit)).to_vec();
    let mut table = Table::new("Every generator with every tracker", columns);
    table.caption = "By their rounds; 0 is what the run began with. Motions of sentences that nothing was trained on, \
                     whole, from their start, without noise; errors are means before a fall."
        .into();
    let row = |pair: &Pair| {
        vec![
            Cell::number(pair.generator as f64, 0),
            Cell::number(pair.tracker as f64, 0),
            Cell::number(pair.motions as f64, 0),
            Cell::number(100.0 * pair.survival, 1),
            Cell::number(100.0 * pair.success, 1),
            Cell::number(pair.joint_error_deg, 2),
            Cell::number(pair.root_rotation_error_deg, 2),
        ]
    };
    table.rows = pairs.iter().map(row).collect();
    table
}
