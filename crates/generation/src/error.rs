//! Errors of text to motion.

/// Errors of text to motion.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum GenerationError {
    /// A file or an input that cannot be used.
    #[error(transparent)]
    Input(#[from] lifelike_checkpoint::InputError),
    /// A prompt that is no sentence.
    #[error("prompt: expected {expected}, got {got}")]
    Prompt {
        /// The accepted form.
        expected: String,
        /// The text found.
        got: String,
    },
    /// A judge of generated motion failed.
    #[error("physics of generated motion: {0}")]
    Judge(String),
    /// A clip is the problem.
    #[error(transparent)]
    Motion(#[from] lifelike_motion::MotionError),
    /// A robot is the problem.
    #[error(transparent)]
    Robot(#[from] lifelike_robot::RobotError),
    /// A captioned data set is the problem.
    #[error(transparent)]
    Language(#[from] lifelike_language::LanguageError),
    /// A plan asks for something impossible.
    #[error(transparent)]
    Plan(#[from] lifelike_train::PlanError),
    /// A model file or checkpoint is the problem.
    #[error(transparent)]
    Checkpoint(#[from] lifelike_checkpoint::CheckpointError),
    /// A file of a run or a report is the problem.
    #[error(transparent)]
    Report(#[from] lifelike_report::ReportError),
    /// The training itself is the problem.
    #[error(transparent)]
    Train(#[from] lifelike_train::TrainError),
}

impl GenerationError {
    /// Returns the error of a prompt.
    pub(crate) fn prompt(expected: impl ToString, got: impl ToString) -> Self {
        Self::Prompt { expected: expected.to_string(), got: got.to_string() }
    }
}
