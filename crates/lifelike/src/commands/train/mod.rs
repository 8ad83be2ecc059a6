//! `lifelike train ...`: a motion prior, then a policy; a motion spline for editing.

pub mod hardware;
pub mod prior;
pub mod processes;
pub mod spline;
pub mod tracker;

use std::path::{Path, PathBuf};

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

/// The folder of a run: as given, or `runs/` and the plan's name.
fn run_folder(given: Option<&Path>, plan: Option<&Path>) -> Result<PathBuf, CliError> {
    match (given, plan.and_then(Path::file_stem)) {
        (Some(folder), _) => Ok(folder.to_path_buf()),
        (None, Some(name)) => Ok(Path::new("runs").join(name)),
        (None, None) => Err(CliError::Usage("say which run with -o FOLDER, or which plan with --plan FILE".into())),
    }
}
