//! Errors of the runtime.

/// Everything that running a controller on a machine can fail with.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RuntimeError {
    /// A file or an input that cannot be used.
    #[error(transparent)]
    Input(#[from] lifelike_checkpoint::InputError),
    /// The connection to the machine fails.
    #[error("bus {bus}: expected {expected}, got {got}")]
    Bus {
        /// The bus as it was named.
        bus: String,
        /// Expected answer, and what to do.
        expected: String,
        /// Actual answer.
        got: String,
    },
    /// The machine is not the one of the controller.
    #[error("the machine is not the one that the controller was made for:\n  {0}")]
    Refused(String),
    /// The controller or the robot is the problem.
    #[error(transparent)]
    Robot(#[from] lifelike_robot::RobotError),
    /// A clip is the problem.
    #[error(transparent)]
    Motion(#[from] lifelike_motion::MotionError),
    /// An array file is the problem.
    #[error(transparent)]
    Checkpoint(#[from] lifelike_checkpoint::CheckpointError),
}
