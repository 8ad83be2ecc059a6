//! Errors of tracking policies and their environments.

use lifelike_train::PlanError;

/// Errors of tracking policies and their environments.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum TrackerError {
    /// A file or an input that cannot be used.
    #[error(transparent)]
    Input(#[from] lifelike_checkpoint::InputError),
    /// A plan asks for something impossible.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// The character is the problem.
    #[error(transparent)]
    Character(#[from] lifelike_character::CharacterError),
    /// A clip is the problem.
    #[error(transparent)]
    Motion(#[from] lifelike_motion::MotionError),
    /// The robot is the problem.
    #[error(transparent)]
    Robot(#[from] lifelike_robot::RobotError),
    /// The simulation is the problem.
    #[error(transparent)]
    Simulation(#[from] lifelike_sim::SimError),
    /// A checkpoint or policy file is the problem.
    #[error(transparent)]
    Checkpoint(#[from] lifelike_checkpoint::CheckpointError),
    /// A file of a run or a report is the problem.
    #[error(transparent)]
    Report(#[from] lifelike_report::ReportError),
    /// The training itself is the problem.
    #[error(transparent)]
    Train(#[from] lifelike_train::TrainError),
}
