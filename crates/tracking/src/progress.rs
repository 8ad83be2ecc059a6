//! What a training run tells of itself, on the way and at its end.

use std::path::PathBuf;

/// How far a run is: for progress bars.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Progress {
    /// Iterations done.
    pub iteration: u64,
    /// Environment steps done.
    pub steps: u64,
    /// Environment steps of the budget.
    pub budget: u64,
    /// Wall time so far, earlier parts included (s).
    pub seconds: f64,
    /// Environment steps per second in the last iteration.
    pub steps_per_second: f64,
    /// Mean length of the last episodes (s).
    pub episode_seconds: f64,
    /// Share of episodes that do not fail, mean over the clips.
    pub survival: f64,
    /// Mean reward per step.
    pub reward: f64,
}

/// One clip in training.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ClipProgress<'a> {
    /// Its name.
    pub name: &'a str,
    /// Share of episodes that do not fail; NaN before the first.
    pub survival: f64,
    /// Share of its motion that was ever seen.
    pub seen: f64,
}

/// How a run ended.
#[derive(Debug, Clone, PartialEq)]
pub struct Summary {
    /// The policy's file.
    pub policy: PathBuf,
    /// How far it got.
    pub progress: Option<Progress>,
    /// It was asked to stop before the budget was spent; it can be resumed.
    pub interrupted: bool,
}
