//! Numbers that a training tells of itself on the way.

use lifelike_train::ppo::Iteration;

/// Results of one iteration.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrackerMetrics {
    /// Those of the algorithm.
    pub ppo: Iteration,
    /// Environment steps per second.
    pub steps_per_second: f64,
    /// Mean length of the last episodes (s).
    pub episode_seconds: f64,
    /// Share of episodes that do not fail, mean over the clips.
    pub survival: f64,
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
