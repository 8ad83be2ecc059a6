//! `lifelike export`: a trained policy as one file that needs no training framework, or as the files of another stack.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use lifelike_interop::{Dialect, Motion};
use lifelike_report::run::RunFolder;
use lifelike_robot::Robot;
use lifelike_robot::controller::{Controller, ControllerFile, EXTENSION};
use serde_json::json;

use crate::commands::controller_file::robot_of;
use crate::error::CliError;
use crate::next::{self, NextCommand, is_known};
use crate::output::Output;
use crate::shipped::{self, Kind};

/// The policy in the folder of a run.
const POLICY_OF_RUN: &str = "tracker.controller.safetensors";

/// Write a controller for deployment: for robots, or as the files of another stack.
///
/// Training writes a controller with its value function, to go on from. This command writes it without. The file
/// contains the network, the encoder of the motion prior if the policy reads latent codes, and the normaliser. It also
/// contains the environment's plan, the layout of inputs and outputs by name, gains, limits and rates. A digest of the
/// robot and golden vectors are verified by every reader.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  lifelike export runs/walk   # writes runs/walk/walk.controller.safetensors
  lifelike export runs/mine --robot my_robot.xml -o mine.controller.safetensors
  lifelike export runs/walk --for onnx     # plain ONNX of the same inputs and outputs
  lifelike export runs/g1 --for mjlab --motions dance.motion.safetensors

--for takes onnx, beyondmimic, mjlab, holosoma, unitree or wbc. It writes a folder with the files that the stack reads.
The stack must be able to build the policy's observation: the plans track-beyondmimic, track-deploy and track-wbc train
such policies.

Whatever takes --policy takes a controller or the folder of a run.")]
pub struct Args {
    /// The folder of a run of `train tracker`, or a controller's file.
    pub input: PathBuf,
    /// The robot: a name, or an MJCF or URDF file; what the policy was trained for where not given.
    #[arg(short, long)]
    pub robot: Option<String>,
    /// Another plan of the environment than the one in its file, by name or file.
    #[arg(long, value_name = "PLAN")]
    pub environment: Option<PathBuf>,
    /// The stack whose files are written.
    #[arg(long = "for", value_name = "STACK")]
    pub dialect: Option<Dialect>,
    /// The clip that goes with the policy, for stacks whose files carry the motion.
    #[arg(long, value_name = "CLIP", requires = "dialect")]
    pub motions: Option<PathBuf>,
    /// The controller's file, or the folder of a stack's files; beside the policy where not given.
    #[arg(short, long)]
    pub output: Option<PathBuf>,
}

/// Runs the command.
///
/// # Errors
/// There is no policy; it cannot make its latent codes; robot and policy do not fit each other; the file cannot be
/// written.
pub fn run(args: &Args, output: &Output) -> Result<(), CliError> {
    let destination = match args.dialect {
        None => crate::destination::network,
        Some(_) => crate::destination::folder,
    };
    let given = args.output.as_ref().map(|path| destination(&path.to_string_lossy())).transpose();
    let given = given.map_err(|reason| CliError::Usage(format!("--output: {reason}")))?;
    let Source { policy, robot, .. } = Source::of(&args.input)?;
    let mut file = ControllerFile::read(&policy)?;
    file.check_complete()?;
    let name = match args.robot.clone().or(robot) {
        Some(name) => name,
        None => robot_of(&file).map_err(|reason| {
            CliError::Usage(format!("{}: {reason}; name its MJCF or URDF file with --robot", policy.display()))
        })?,
    };
    if let Some(name) = &args.environment {
        let environment = environment_named(name, &file.header().robot)?;
        file = file.trained_in(environment)?;
    }
    let controller = Controller::new(file, Arc::new(Robot::load(&name)?))?;
    if let Some(dialect) = args.dialect {
        let folder = given.unwrap_or_else(|| policy.with_file_name(format!("{}.{dialect}", stem(&policy))));
        return foreign(&controller, dialect, args.motions.as_deref(), &folder, output);
    }
    let path = given.unwrap_or_else(|| beside(&policy));
    controller.save(&path)?;
    // What was written is what a robot will read: names, digest and golden vectors are tried once.
    let written = ControllerFile::read(&path)?;
    let eval = NextCommand::new("eval").path("--policy", &path).robot(&name);
    let steps = [eval.word("--motions").word("builtin").word("-o").word("report")];
    let value = json!({
        "controller": path, "policy": policy, "robot": name, "robot_sha256": written.robot().digest, "header": written.header(),
        "next": next::texts(&steps),
    });
    output.result(&value, || format!("controller: {}\n{}", path.display(), next::lines(&steps)))
}

/// Writes the files of another stack.
fn foreign(
    controller: &Controller,
    dialect: Dialect,
    motion: Option<&Path>,
    folder: &Path,
    output: &Output,
) -> Result<(), CliError> {
    let clip = motion.map(|path| lifelike_robot::clips::load_one(path, controller.robot())).transpose()?;
    let motion = clip.as_ref().map_or(Motion::None, Motion::Clip);
    let files = lifelike_interop::export(controller, dialect, motion)?;
    let taken = files.iter().map(|file| folder.join(&file.name)).find(|path| path.is_dir());
    if let Some(taken) = taken {
        return Err(CliError::Input(format!("{}: expected a file or nothing there, got a folder", taken.display())));
    }
    let mut paths = Vec::new();
    for file in &files {
        let path = folder.join(&file.name);
        if let Some(parent) = path.parent() {
            std::fs::create_dir_all(parent).map_err(CliError::write(parent))?;
        }
        lifelike_checkpoint::write_file(&path, &file.bytes).map_err(CliError::write(&path))?;
        paths.push(path);
    }
    let is_read = !matches!(dialect, Dialect::Onnx | Dialect::Unitree);
    let steps: Vec<NextCommand> =
        is_read.then(|| NextCommand::new("inspect").word(paths[0].display())).into_iter().collect();
    if clip.is_some() && matches!(dialect, Dialect::Onnx | Dialect::Wbc) {
        tracing::warn!("files for {dialect} hold no motion: --motions is not used");
    }
    let terms = lifelike_interop::terms(controller, dialect)?;
    let value = json!({ "stack": dialect.name(), "files": paths, "observation": terms, "next": next::texts(&steps) });
    output.result(&value, || {
        let lines: String = paths.iter().map(|path| format!("{}\n", path.display())).collect();
        let terms: Vec<String> = terms.iter().map(|(name, size)| format!("{name} {size}")).collect();
        format!("{lines}observation for {dialect}, in order: {}\n{}", terms.join(", "), next::lines(&steps))
    })
}

/// Returns a tracking plan, by name or file, as a controller has it.
fn environment_named(name: &Path, robot: &str) -> Result<String, CliError> {
    let plan = crate::commands::rollouts::tracker_plan(name, robot, 0)?;
    plan.as_environment(robot).map_err(|error| CliError::Failed(error.to_string()))
}

/// A policy, and what its run says about it.
pub(crate) struct Source {
    /// The policy's or controller's file.
    pub policy: PathBuf,
    /// The motion prior that the run's plan names.
    pub prior: Option<PathBuf>,
    /// The robot that the run's plan names.
    pub robot: Option<String>,
}

impl Source {
    /// Finds the policy of a run, or takes a file as it is.
    ///
    /// # Errors
    /// The folder is no run of `train tracker`, or has no policy yet.
    pub fn of(input: &Path) -> Result<Self, CliError> {
        if let Some(network) = shipped::named(input, Kind::Controller).filter(|_| !input.exists()) {
            let robot = Some(network.name).filter(|name| is_known(name)).map(str::to_owned);
            return Ok(Self { policy: network.file()?, prior: None, robot });
        }
        if !input.is_dir() {
            // A run's policy by its own name: the plan is beside it.
            let policy = shipped::file(input, Kind::Controller)?;
            let plan = plan_around(&policy);
            let text = |key: &str| plan.as_ref()?.get(key)?.as_str();
            let robot = text("robot").filter(|robot| is_known(robot) || Path::new(robot).is_file()).map(str::to_owned);
            let prior = text("prior").map(PathBuf::from).filter(|prior| prior.is_file());
            return Ok(Self { policy, prior, robot });
        }
        let plan: toml::Table = RunFolder::open(input)?.plan()?;
        let text = |key: &str| plan.get(key).and_then(toml::Value::as_str);
        let policy = input.join(POLICY_OF_RUN);
        if !policy.is_file() {
            let expected = "`train tracker` writes it with each checkpoint and when a run ends or is interrupted";
            return Err(CliError::Input(format!("{}: expected a policy, got no file; {expected}", policy.display())));
        }
        let (prior, robot) = (text("prior").map(PathBuf::from), text("robot").map(str::to_owned));
        Ok(Self { policy, prior, robot })
    }
}

/// Returns the plan of the run in whose folder a policy's file is.
fn plan_around(policy: &Path) -> Option<toml::Table> {
    let is_policy = policy.file_name()?.to_str()?.starts_with("tracker.");
    RunFolder::open(policy.parent()?).ok().filter(|_| is_policy)?.plan().ok()
}

/// Returns the file that is written where none is named: the run's name in its folder, else the file's beside it.
fn beside(policy: &Path) -> PathBuf {
    let of_run = policy.parent().and_then(Path::file_name).filter(|_| policy.ends_with(POLICY_OF_RUN));
    let stem = of_run.map_or_else(|| format!("{}-export", stem(policy)), |run| run.to_string_lossy().into_owned());
    policy.with_file_name(format!("{stem}{EXTENSION}"))
}

/// Returns the name of a controller's file without its ending.
fn stem(policy: &Path) -> String {
    let name = policy.file_name().unwrap_or_default().to_string_lossy();
    name.strip_suffix(EXTENSION).unwrap_or(&name).to_owned()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn a_controller_stands_beside_its_policy() {
        let name = |policy: &str| beside(Path::new(policy)).display().to_string();
        assert_eq!(name("runs/a/tracker.controller.safetensors"), "runs/a/a.controller.safetensors");
        assert_eq!(name("x.controller.safetensors"), "x-export.controller.safetensors");
    }
}
