//! `lifelike train ...`: a motion prior, then a policy; a motion spline for editing.

pub mod hardware;
pub mod prior;
pub mod processes;
pub mod sequences;
mod source;
pub mod spline;
pub mod tracker;

use clap::Subcommand;

use crate::error::CliError;
use crate::output::Output;

/// Train a motion prior, a tracking policy, or a motion spline.
#[derive(Debug, Subcommand)]
pub enum Train {
    Prior(prior::Args),
    Tracker(tracker::Args),
    Spline(spline::Args),
}

impl Train {
    /// Does it.
    pub fn run(self, output: &Output) -> Result<(), CliError> {
        match self {
            Self::Prior(args) => prior::run(&args, output),
            Self::Tracker(args) => tracker::run(&args, output),
            Self::Spline(args) => spline::run(&args, output),
        }
    }
}
