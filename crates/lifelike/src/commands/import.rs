//! `lifelike import`: a policy of another stack as a controller.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use lifelike_interop::Imported;
use lifelike_robot::controller::{Controller, EXTENSION};
use lifelike_robot::{FromInput, Robot, RobotError};
use serde_json::json;

use crate::error::CliError;
use crate::next::{self, NextCommand};
use crate::output::Output;

/// Read a policy of another stack (ONNX), so that every command runs it.
///
/// The layout of its observation is read from its metadata. It is compared with the statistics of the policy's own
/// normalizer, and a contradiction is refused. The motion that the file carries is written beside the controller.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  lifelike inspect dance.onnx     # only says what is in it
  lifelike import dance.onnx      # writes dance.controller.safetensors, dance.motion.safetensors
  lifelike eval --robot g1 --policy dance.controller.safetensors --motions dance.motion.*

Trackers of mjlab, BeyondMimic, holosoma and wbc-mjlab are read. `lifelike fetch g1` gets the robot of most of them.")]
pub struct Args {
    /// The policy's ONNX file.
    pub input: PathBuf,
    /// The robot: a name, or an MJCF or URDF file; the one with the policy's joints where not given.
    #[arg(short, long)]
    pub robot: Option<String>,
    /// The terms of the observation in order, where the file's metadata are wrong.
    #[arg(long, value_delimiter = ',', value_name = "TERM,TERM,...")]
    pub terms: Option<Vec<String>>,
    /// Reads it although its layout contradicts its normalizer, as that of a policy that has hardly learnt may.
    #[arg(long)]
    pub force: bool,
    /// The controller's file; beside the policy where not given.
    #[arg(short, long, value_parser = crate::destination::network)]
    pub output: Option<PathBuf>,
}

/// Runs the command.
///
/// # Errors
/// The file is no policy of a known stack, contradicts its own normalizer, or is another robot's.
pub fn run(args: &Args, output: &Output) -> Result<(), CliError> {
    let (robot, imported) = read(&args.input, args.robot.as_deref(), args.terms.as_deref())?;
    if !args.force {
        refuse(&args.input, &imported)?;
    }
    imported.contradictions.iter().for_each(|found| tracing::warn!("{found}"));
    let path = args.output.clone().unwrap_or_else(|| with_ending(&args.input, EXTENSION));
    let stem = path.to_string_lossy().trim_end_matches(".safetensors").trim_end_matches(".controller").to_string();
    let controller = Controller::new(imported.controller.clone(), robot.clone())?;
    let clip = PathBuf::from(format!("{stem}{}", lifelike_motion::container::EXTENSION));
    if let Some(folder) = [&path, &clip].into_iter().find(|path| path.is_dir()) {
        return Err(CliError::Input(format!("{}: expected a file or nothing there, got a folder", folder.display())));
    }
    controller.save(&path)?;
    if let Some(motion) = &imported.clip {
        lifelike_motion::container::write(&clip, motion)?;
    }
    let name = args.robot.clone().unwrap_or_else(|| known_as(&robot));
    let eval = NextCommand::new("eval").path("--policy", &path).robot(&name);
    let eval =
        if imported.clip.is_some() { eval.path("--motions", &clip) } else { eval.word("--motions").word("builtin") };
    let steps = [eval.word("-o").word("report")];
    let value = json!({
        "controller": path, "stack": imported.dialect.name(), "terms": imported.terms, "notes": imported.notes,
        "motion": imported.clip.as_ref().map(|_| &clip), "robot": name, "next": next::texts(&steps),
    });
    output.result(&value, || {
        let mut text = said(&imported);
        text += &format!("controller: {}\n", path.display());
        if let Some(motion) = &imported.clip {
            text += &format!("motion: {} ({:.1} s)\n", clip.display(), motion.seconds());
        }
        text + &next::lines(&steps)
    })
}

/// Reads a foreign policy for a robot: the one that is named, or one with its joints.
pub(super) fn read(
    path: &Path,
    robot: Option<&str>,
    terms: Option<&[String]>,
) -> Result<(Arc<Robot>, Imported), CliError> {
    let bytes = std::fs::read(path).map_err(RobotError::io(path))?;
    let shown = path.display().to_string();
    let robot = match robot {
        Some(name) => Robot::load(name)?,
        None => of_joints(&lifelike_interop::joints_of(&bytes, &shown)?, &shown)?,
    };
    let imported = lifelike_interop::import(&bytes, &shown, &robot, terms)?;
    Ok((Arc::new(robot), imported))
}

/// Refuses a layout that its own normalizer contradicts.
fn refuse(path: &Path, imported: &Imported) -> Result<(), CliError> {
    if imported.contradictions.is_empty() {
        return Ok(());
    }
    let lines: Vec<String> = imported.contradictions.iter().map(|found| format!("\n  {found}")).collect();
    Err(CliError::Input(format!(
        "{}: the observation {} contradicts what the policy's normalizer has seen:{}\nthe policy was trained with another \
         order (name it with --terms), or has hardly learnt to follow (--force)",
        path.display(),
        imported.terms.join(", "),
        lines.concat()
    )))
}

/// The contract and the assumptions, for people.
pub(super) fn said(imported: &Imported) -> String {
    let mut text = format!("a policy of {}\nobservation, in order: {}\n", imported.dialect, imported.terms.join(", "));
    imported.notes.iter().for_each(|note| text += &format!("{note}\n"));
    text
}

/// Finds a robot with these joints among those that are known by name.
fn of_joints(joints: &[String], path: &str) -> Result<Robot, CliError> {
    if joints.is_empty() {
        let expected = "expected a policy of mjlab, BeyondMimic, holosoma or wbc-mjlab";
        return Err(CliError::Input(format!("{path}: {expected}, got no names of joints in the file's metadata")));
    }
    let mut last = None;
    for name in lifelike_robot::load::known() {
        match Robot::load(name) {
            Ok(robot) if joints.len() == robot.joints() && joints.iter().all(|j| robot.layout.joints.contains(j)) => {
                return Ok(robot);
            }
            Ok(_) => {}
            Err(error @ RobotError::NotFetched { .. }) => last = Some(error),
            Err(error) => return Err(error.into()),
        }
    }
    let first = joints.first().map_or("none", String::as_str);
    let hint = last.map_or(String::new(), |error| format!("\nperhaps it is one that was not fetched: {error}"));
    Err(CliError::Input(format!(
        "{path}: expected a policy of a known robot, got one with {} joints, the first '{first}'; name its MJCF or URDF file \
         with --robot{hint}",
        joints.len()
    )))
}

/// The name by which a robot is loaded again.
fn known_as(robot: &Robot) -> String {
    let same = |name: &&str| Robot::load(name).is_ok_and(|other| other.layout.joints == robot.layout.joints);
    lifelike_robot::load::known().find(same).map_or_else(|| robot.name.clone(), str::to_owned)
}

fn with_ending(path: &Path, ending: &str) -> PathBuf {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    path.with_file_name(format!("{stem}{ending}"))
}
