//! Errors of a robot's description, of a controller, and of data that is handed to them.

use std::path::PathBuf;

/// Everything that making or using a robot can fail with.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RobotError {
    /// A file or an input that cannot be used.
    #[error(transparent)]
    Input(#[from] lifelike_checkpoint::InputError),
    /// The profile is not what it should be.
    #[error("{path}: {message}")]
    Profile {
        /// The file.
        path: PathBuf,
        /// Message, with line and key.
        message: String,
    },
    /// No robot of this name.
    #[error("no robot named '{name}': not a file, and not one of {available}{hint}")]
    Unknown {
        /// The name.
        name: String,
        /// The built-in ones.
        available: String,
        /// The nearest of them, as a question.
        hint: String,
    },
    /// A robot of other people that is not on this machine yet.
    #[error("robot '{name}' is not in the box, being somebody else's; fetch it once:\n  lifelike fetch {name}")]
    NotFetched {
        /// The name.
        name: String,
    },
    /// A policy that was trained for a robot with other joints.
    #[error(
        "the policy is for robot '{policy}' ({joints}), and '{robot}' is another ({robot_joints}); each robot needs a policy \
         of its own: lifelike train tracker --plan track --robot FILE"
    )]
    OtherRobot {
        /// Name of the policy's robot.
        policy: String,
        /// Number of its joints, and one that the robot lacks.
        joints: String,
        /// Name of the robot.
        robot: String,
        /// Number of its joints, and one that the policy lacks.
        robot_joints: String,
    },
    /// The robot cannot be controlled, or its description contradicts itself.
    #[error("robot '{robot}': {message}")]
    Unfit {
        /// The robot.
        robot: String,
        /// Message, with names.
        message: String,
    },
    /// An observation asks for something that was not measured.
    #[error("observation part '{part}': expected {needed}, got none: measure or estimate it, or use another policy")]
    Unmeasured {
        /// The part.
        part: String,
        /// The missing measurement.
        needed: &'static str,
    },
    /// A controller's file replays its golden vectors with other numbers.
    #[error(
        "{path}: {what} of golden vector {row}: expected {expected}, got {got} (tolerance {tolerance}): the networks or \
         this machine's arithmetic are not those that the file was made with; export it again"
    )]
    Golden {
        /// The file.
        path: String,
        /// Output or code.
        what: &'static str,
        /// Number of the row.
        row: usize,
        /// Number in the file.
        expected: f32,
        /// Number of the replay.
        got: f32,
        /// Greatest difference that is tolerated.
        tolerance: f32,
    },
    /// An encoder of latent codes fails.
    #[error("latent codes of clip '{clip}': {source}")]
    Encoder {
        /// The clip.
        clip: String,
        /// Why.
        source: Box<dyn std::error::Error + Send + Sync>,
    },
    /// None of the clips is of use, or one of those that are all needed.
    #[error("expected clips of the robot, got none of:\n  {reasons}")]
    Clips {
        /// The files with what is wrong with each.
        reasons: String,
    },
    /// A clip is the problem.
    #[error(transparent)]
    Motion(#[from] lifelike_motion::MotionError),
    /// A file of weights is the problem.
    #[error(transparent)]
    Checkpoint(#[from] lifelike_checkpoint::CheckpointError),
    /// The character itself is the problem.
    #[error(transparent)]
    Character(#[from] lifelike_character::CharacterError),
}
