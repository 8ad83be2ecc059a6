//! Errors of scenes and of the studio.

/// Errors of scenes and of the studio.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum StudioError {
    /// A file or an input that cannot be used.
    #[error(transparent)]
    Input(#[from] lifelike_checkpoint::InputError),
    /// A scene that is not in the expected form.
    #[error("{place}: {message}")]
    Scene {
        /// File and line.
        place: String,
        /// The reason, and the remedy.
        message: String,
    },
    /// An operation that the scene does not allow.
    #[error("{0}")]
    Operation(String),
    /// A block whose motion cannot be made.
    #[error("block '{id}': {message}")]
    Block {
        /// The block.
        id: String,
        /// The reason.
        message: String,
    },
    /// Robot, controller and physics that do not fit each other.
    #[error(transparent)]
    Robot(#[from] lifelike_robot::RobotError),
    /// A simulation that fails as a whole.
    #[error(transparent)]
    Simulation(#[from] lifelike_sim::SimError),
    /// A motion that cannot be edited.
    #[error(transparent)]
    Motion(#[from] lifelike_motion::MotionError),
    /// The server cannot start.
    #[error("server: {0}")]
    Server(String),
}

impl StudioError {
    /// Returns a closure for `map_err` on the motion of a block.
    pub(crate) fn block<E: std::fmt::Display>(id: &str) -> impl FnOnce(E) -> Self {
        let id = id.to_string();
        move |error| Self::Block { id, message: error.to_string() }
    }
}
