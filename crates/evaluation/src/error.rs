//! Errors of evaluations.

/// Errors of evaluations.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum EvaluationError {
    /// Two things that must fit each other do not.
    #[error("{what}: expected {expected}, got {got}")]
    Mismatch {
        /// The things compared.
        what: String,
        /// The expected value.
        expected: String,
        /// The value found.
        got: String,
    },
    /// An MCAP file cannot be made.
    #[error("MCAP: {0}")]
    Record(String),
    /// A clip is the problem.
    #[error(transparent)]
    Motion(#[from] lifelike_motion::MotionError),
    /// The robot is the problem.
    #[error(transparent)]
    Robot(#[from] lifelike_robot::RobotError),
    /// The simulation is the problem.
    #[error(transparent)]
    Simulation(#[from] lifelike_sim::SimError),
}
