//! Errors of evaluations.

/// Errors of evaluations.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum EvaluationError {
    /// A file or an input that cannot be used.
    #[error(transparent)]
    Input(#[from] lifelike_checkpoint::InputError),
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
