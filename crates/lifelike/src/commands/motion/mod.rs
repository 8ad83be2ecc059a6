//! `lifelike motion ...`: motion in, motion out.

pub mod check;
pub mod convert;
pub mod retarget;

use std::path::{Path, PathBuf};

use clap::Subcommand;
use lifelike_motion::container::EXTENSION;

use crate::error::CliError;
use crate::output::Output;

/// Retarget captured motion to robots, convert the motion of robots, and check whether they can execute it.
#[derive(Debug, Subcommand)]
pub enum Motion {
    Retarget(retarget::Args),
    Convert(convert::Args),
    Check(check::Args),
}

impl Motion {
    /// Does it.
    pub fn run(self, output: &Output) -> Result<(), CliError> {
        match self {
            Self::Retarget(args) => retarget::run(&args, output),
            Self::Convert(args) => convert::run(&args, output),
            Self::Check(args) => check::run(&args, output),
        }
    }
}

/// Where a clip of this name goes. Names become file names without anything that could lead to another folder.
fn target(folder: &Path, name: &str, extension: &str) -> PathBuf {
    let safe: String = name.chars().map(|c| if c.is_alphanumeric() || "-_.+".contains(c) { c } else { '_' }).collect();
    folder.join(format!("{}{extension}", safe.trim_start_matches('.')))
}

/// Where the container of a clip goes.
pub fn container_in(folder: &Path, name: &str) -> PathBuf {
    target(folder, name, EXTENSION)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_clip_cannot_choose_its_folder() {
        let at = |name| container_in(Path::new("out"), name).to_string_lossy().into_owned();
        assert_eq!(at("07_01"), "out/07_01.motion.safetensors");
        assert_eq!(at("../../etc/x y"), "out/_.._etc_x_y.motion.safetensors");
    }
}
