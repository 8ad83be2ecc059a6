//! What an episode must bear besides following its clip.

use lifelike_sim::EnvironmentParameters;
use lifelike_sim::randomization::Push;

/// The conditions of one episode. The default changes nothing.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Hardship {
    /// Where it begins (m, world).
    pub spot: [f64; 2],
    /// How robot and ground differ from the model.
    pub parameters: EnvironmentParameters,
    /// Pushes, one after the other.
    pub pushes: Vec<TimedPush>,
    /// In place of its own clip: stretches of any clips, one after the other, without a transition.
    pub stretches: Vec<Stretch>,
}

/// A push that lasts for some steps.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TimedPush {
    /// The first step that it acts in.
    pub from: usize,
    /// The first step that it no longer acts in.
    pub until: usize,
    /// Where and how hard.
    pub push: Push,
}

/// Where an episode goes on, and when.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Stretch {
    /// The step before which it is jumped to.
    pub step: usize,
    /// The frame of the library.
    pub frame: usize,
}
