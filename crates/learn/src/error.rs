//! What can go wrong while learning, evaluating and reporting.

use std::path::{Path, PathBuf};

/// Everything that a run can fail with.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum LearnError {
    /// A file of a run cannot be read or written.
    #[error("{path}: {source}")]
    Io {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// A file of a run is not what it should be.
    #[error("{path}: expected {expected}, got {got}")]
    Format {
        /// The file (with the line, where there are lines).
        path: String,
        /// What should be there.
        expected: String,
        /// What is there.
        got: String,
    },
    /// Two things that must fit each other do not.
    #[error("{what}: expected {expected}, got {got}")]
    Mismatch {
        /// What was compared.
        what: String,
        /// What should be there.
        expected: String,
        /// What is there.
        got: String,
    },
    /// A plan asks for something impossible.
    #[error("plan: {key}: expected {expected}, got {got}")]
    Plan {
        /// The key.
        key: String,
        /// The range or the choices.
        expected: String,
        /// What the plan says.
        got: String,
    },
    /// The character is the problem.
    #[error(transparent)]
    Character(#[from] lifelike_character::CharacterError),
    /// A clip is the problem.
    #[error(transparent)]
    Motion(#[from] lifelike_motion::MotionError),
    /// A device does not hand out its numbers.
    #[error(transparent)]
    Numbers(#[from] lifelike_nn::numbers::Unreadable),
    /// The robot is the problem.
    #[error(transparent)]
    Robot(#[from] lifelike_robot::RobotError),
    /// The simulation is the problem.
    #[error(transparent)]
    Simulation(#[from] lifelike_sim::SimError),
    /// Sizes that make no network.
    #[error(transparent)]
    Network(#[from] lifelike_nn::transformer::NetworkError),
    /// A pass through a network cannot be made.
    #[error(transparent)]
    Pass(#[from] lifelike_nn::transformer::backprop::PassError),
    /// A checkpoint or policy file is the problem.
    #[error(transparent)]
    Checkpoint(#[from] lifelike_nn::checkpoint::CheckpointError),
}

impl LearnError {
    /// For `map_err` on file operations.
    pub fn io(path: &Path) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.to_path_buf();
        move |source| Self::Io { path, source }
    }
}
