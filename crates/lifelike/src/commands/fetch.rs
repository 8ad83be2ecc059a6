//! `lifelike fetch`: files of other people, on request.

use std::path::PathBuf;

use lifelike_fetch::{mujoco, text_model};
use lifelike_robot::load::{FETCHED, G1_PROFILE};
use serde_json::json;

use crate::error::CliError;
use crate::folders;
use crate::next::NextCommand;
use crate::output::Output;

/// Fetch somebody else's robot, text encoder or physics engine, once, checked by its digest.
///
/// This is the only command that touches the network. It downloads one exact wheel of the Python package index with pip and unpacks
/// the files that are needed; no Python code runs.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  lifelike fetch g1   # Unitree G1 with meshes (BSD-3-Clause), 12 MB; then --robot g1
  lifelike fetch g1 --without-meshes
  lifelike fetch dm_control              # the humanoids of dm_control (Apache-2.0)
  lifelike fetch minilm                  # text encoder all-MiniLM-L6-v2 (Apache-2.0), 83 MB
  lifelike fetch mujoco                  # MuJoCo 3.17.0 (Apache-2.0); then --engine mujoco")]
pub struct Args {
    /// Name: g1, dm_control, minilm or mujoco.
    pub name: String,
    /// Skip the meshes of a robot: physics needs none of them.
    #[arg(long)]
    pub without_meshes: bool,
    /// Folder to put it into; the user's data folder where not given (see `lifelike config`).
    #[arg(short, long, value_parser = crate::destination::folder)]
    pub output: Option<PathBuf>,
}

/// Runs the command.
///
/// # Errors
/// [`CliError::Usage`] for an unknown name, [`CliError::Failed`] where a download or a file fails.
pub fn run(args: &Args, output: &Output) -> Result<(), CliError> {
    let known = || ["g1"].into_iter().chain(lifelike_fetch::NAMES).chain([text_model::NAME, mujoco::NAME]);
    if !known().any(|name| name == args.name) {
        let names = known().collect::<Vec<_>>().join(", ");
        let near = lifelike_robot::nearest::hint(&args.name, known());
        return Err(CliError::Usage(format!("expected one of {names}; got '{}'{near}", args.name)));
    }
    let folder = |below: &str| args.output.clone().unwrap_or_else(|| folders::data().join(below));
    if args.name == text_model::NAME {
        let folder = text_model::ensure(&folder("")).map_err(CliError::Failed)?;
        return output.result(&json!({ "folder": folder }), || format!("{}\n", folder.display()));
    }
    if args.name == mujoco::NAME {
        let library = mujoco::ensure(&folder("")).map_err(CliError::Failed)?;
        let next = NextCommand::new("bench engine");
        return output.result(&json!({ "library": library }), || format!("{}\nnext:  {next}\n", library.display()));
    }
    let name = if args.name == "g1" { "unitree_g1" } else { args.name.as_str() };
    let models = lifelike_fetch::robot(name, !args.without_meshes, &folder("robots"), G1_PROFILE);
    let models = models.map_err(CliError::Failed)?;
    let by_name = FETCHED.iter().find(|(_, file)| args.output.is_none() && file.starts_with(name));
    let robot = by_name.map_or_else(|| models[0].display().to_string(), |(name, _)| (*name).to_owned());
    output.result(&json!({ "models": models, "robot": robot }), || {
        let files: String = models.iter().map(|model| format!("{}\n", model.display())).collect();
        format!("{files}next:  {}\n", NextCommand::new("inspect").word(&robot))
    })
}
