//! `lifelike augment ...`: how far a simulation is from a robot's logs, and what closes the gap (thesis chapter 2).

pub mod apply;
pub mod estimate;
pub mod excite;
pub mod identify;
mod page;
mod records;
pub mod report;
pub mod simulate;
mod sources;
pub mod twin;

pub(crate) use sources::traces;

use clap::Subcommand;
use lifelike_augmentation::Feedback;

use crate::error::CliError;
use crate::output::Output;

/// Compare a simulation with logs of the real thing, and correct it.
///
/// `excite` makes reference motions; run them on a robot, or on a `twin` that replaces one. `simulate` turns logs into
/// traces with simulated and measured states side by side. `report` shows the gap. `identify` fits the parameters of a
/// servo's model. `lifelike train augmentation` learns the remaining error, and `apply` corrects traces with it.
/// `estimate` computes the state of the whole robot from a log of its joints.
#[derive(Debug, Subcommand)]
#[allow(missing_docs)] // a comment on a variant would take the place of the command's help text
pub enum Augment {
    Excite(excite::Args),
    Twin(twin::Args),
    Simulate(simulate::Args),
    Identify(identify::Args),
    Report(report::Args),
    Apply(apply::Args),
    Estimate(estimate::Args),
}

impl Augment {
    /// Runs it.
    ///
    /// # Errors
    /// As the command.
    pub fn run(&self, output: &Output) -> Result<(), CliError> {
        match self {
            Self::Excite(args) => excite::run(args, output),
            Self::Twin(args) => twin::run(args, output),
            Self::Simulate(args) => simulate::run(args, output),
            Self::Identify(args) => identify::run(args, output),
            Self::Report(args) => report::run(args, output),
            Self::Apply(args) => apply::run(args, output),
            Self::Estimate(args) => estimate::run(args, output),
        }
    }
}

/// Earlier errors that the network reads.
#[derive(Debug, Clone, Copy, clap::ValueEnum)]
pub enum FeedbackName {
    /// Nothing: corrections follow from the simulation alone.
    None,
    /// Its own predictions.
    Predicted,
    /// Measured errors.
    Measured,
}

impl From<FeedbackName> for Feedback {
    fn from(name: FeedbackName) -> Self {
        match name {
            FeedbackName::None => Self::None,
            FeedbackName::Predicted => Self::Predicted,
            FeedbackName::Measured => Self::Measured,
        }
    }
}
