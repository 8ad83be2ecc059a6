//! An episode, and its conditions besides following its clip.

use lifelike_sim::EnvironmentParameters;
use lifelike_sim::randomization::Push;

/// One episode to run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Episode {
    /// Its number, from 0: the address of its randomness.
    pub number: usize,
    /// The frame of the library that it begins at.
    pub frame: usize,
    /// Frames that it has without a fall, the start included.
    pub planned: usize,
}

/// Conditions of one episode. The default changes nothing.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct EpisodeConditions {
    /// Place on the ground where it begins (m, world).
    pub position: [f64; 2],
    /// Differences of robot and ground from the model.
    pub parameters: EnvironmentParameters,
    /// Pushes, one after the other.
    pub pushes: Vec<TimedPush>,
    /// In place of its own clip: segments of any clips, one after the other, without a transition.
    pub segments: Vec<ReferenceSegment>,
}

/// A push that lasts for some steps.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TimedPush {
    /// The first step that it acts in.
    pub from: usize,
    /// The first step that it no longer acts in.
    pub until: usize,
    /// Body and force.
    pub push: Push,
}

/// A frame at which the reference goes on, and when.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ReferenceSegment {
    /// The step before which it is jumped to.
    pub step: usize,
    /// The frame of the library.
    pub frame: usize,
}
