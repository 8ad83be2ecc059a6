//! `lifelike motion lint`: mistakes of convention in motion of a robot, and their correction.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use lifelike_checkpoint::FromInput;
use lifelike_motion::feasibility::{self, Feasibility};
use lifelike_motion::formats::{self, FileMotion, ReadOptions};
use lifelike_motion::lint::{Flaw, lint};
use lifelike_motion::{MotionClip, MotionError, container, dataset};
use lifelike_report::{Cell, Column, Table, Tone};
use lifelike_robot::{Robot, Shapes};
use rayon::prelude::*;
use serde::Serialize;

use super::{clip_name, container_in};
use crate::commands::clips;
use crate::error::CliError;
use crate::output::{Output, fitted};

/// Find mistakes in motion of a robot: quaternion order, units, axes, rate, whole turns, exchanged joints, height.
///
/// A mistake is reported when its correction puts the robot on the ground, upright and within its joints' ranges. Other
/// findings are listed as `motion check` lists them. The exit code is 3 when any clip has a mistake that is not fixed.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  lifelike motion lint data/lima --robot lima
  lifelike motion lint data/others --robot g1 --fix -o data/fixed
  lifelike --json motion lint walk.motion.safetensors | jq '.[0].mistakes'")]
pub struct Args {
    /// Motion of the robot: files, folders, patterns, or @list.txt with one of them per line.
    #[arg(required = true)]
    pub motions: Vec<PathBuf>,
    /// Layout of the motion.
    #[command(flatten)]
    pub layout: clips::LayoutArgument,
    /// The robot: a name, or an MJCF or URDF file.
    #[arg(short, long, default_value = "lima")]
    pub robot: String,
    /// Write corrected clips into the folder of --output.
    #[arg(long, requires = "output")]
    pub fix: bool,
    /// Folder of the corrected clips.
    #[arg(short, long, requires = "fix", value_parser = crate::destination::folder)]
    pub output: Option<PathBuf>,
}

/// Outcome of one clip.
#[derive(Debug, Serialize)]
struct Linted {
    file: PathBuf,
    clip: String,
    mistakes: Vec<Flaw>,
    /// Findings that remain after the corrections.
    remaining: Feasibility,
    /// File of the corrected clip.
    #[serde(skip_serializing_if = "Option::is_none")]
    fixed: Option<PathBuf>,
}

/// Runs the command.
pub fn run(args: &Args, output: &Output) -> Result<(), CliError> {
    let robot = Robot::load(&args.robot)?;
    robot.require_ready(Shapes::All)?;
    let is_of_robot = |format: &formats::Format| matches!(format.reader, formats::Reader::Robot(_));
    let files = dataset::find_motion(&dataset::with_lists(&args.motions)?, is_of_robot)?;
    let targets = targets(&files, args)?;
    let linted =
        files.par_iter().zip(&targets).map(|(file, target)| look_at(file, target.as_deref(), args.layout, &robot));
    let linted = linted.collect::<Result<Vec<_>, CliError>>()?;
    output.result(&linted, || text(&linted))?;
    let open = linted.iter().filter(|one| !one.mistakes.is_empty() && one.fixed.is_none()).count();
    if open == 0 {
        return Ok(());
    }
    Err(CliError::Input(format!("{open} of {} clips have mistakes; --fix -o FOLDER corrects them", linted.len())))
}

/// Returns the file of each corrected clip: each its own, and none of them an input.
fn targets(files: &[PathBuf], args: &Args) -> Result<Vec<Option<PathBuf>>, CliError> {
    let Some(folder) = &args.output else { return Ok(vec![None; files.len()]) };
    let mut taken: BTreeSet<PathBuf> = files.iter().cloned().collect();
    let target = |file: &PathBuf| {
        let target = container_in(folder, &clip_name(file))?;
        if !taken.insert(target.clone()) {
            let message = format!("{}: {} is taken; choose another --output", file.display(), target.display());
            return Err(CliError::Input(message));
        }
        Ok(Some(target))
    };
    files.iter().map(target).collect()
}

fn look_at(
    file: &Path,
    target: Option<&Path>,
    layout: clips::LayoutArgument,
    robot: &Robot,
) -> Result<Linted, CliError> {
    let clip = read(file, layout, robot)?;
    let (fixed, mistakes) = lint(&clip, &robot.character, &robot.anatomy)?;
    let remaining = feasibility::check(&fixed, &robot.character, &robot.anatomy, &robot.speeds())?;
    if let Some(target) = target {
        container::write(target, &fixed)?;
    }
    let (file, fixed) = (file.to_path_buf(), target.map(Path::to_path_buf));
    Ok(Linted { file, clip: clip.name, mistakes, remaining, fixed })
}

fn read(file: &Path, layout: clips::LayoutArgument, robot: &Robot) -> Result<MotionClip, MotionError> {
    let options = ReadOptions { robot: Some(robot.character.clone()), layout: layout.layout, ..ReadOptions::default() };
    match formats::read(file, &options)? {
        FileMotion::Robot(clip) => Ok(clip),
        FileMotion::Source(_) => Err(MotionError::format(
            file.display(),
            "motion of a robot",
            "human motion, which `lifelike motion retarget` reads",
        )),
    }
}

fn text(linted: &[Linted]) -> String {
    let columns = vec![Column::text("clip"), Column::text("mistakes"), Column::text("remaining")];
    let mut table = Table::new("Clips", columns).main_columns(&["clip", "mistakes"]);
    table.rows = linted.iter().map(row).collect();
    let wrong = linted.iter().filter(|one| !one.mistakes.is_empty()).count();
    let evidence = linted.iter().flat_map(|one| one.mistakes.iter().map(move |flaw| (one, flaw)));
    let evidence: String = evidence.map(|(one, flaw)| format!("{}: {}\n", one.clip, flaw.words())).collect();
    let fixed = linted.iter().filter_map(|one| one.fixed.as_ref()).map(|file| format!("wrote {}\n", file.display()));
    format!(
        "{}\n{evidence}{}{wrong} of {} clips have mistakes\n",
        fitted(&table),
        fixed.collect::<String>(),
        linted.len()
    )
}

fn row(one: &Linted) -> Vec<Cell> {
    let mistakes: Vec<String> = one.mistakes.iter().map(|flaw| flaw.mistake.words()).collect();
    let tone = if mistakes.is_empty() { Tone::Good } else { Tone::Bad };
    let words = if mistakes.is_empty() { "none".into() } else { mistakes.join("; ") };
    let remaining: Vec<String> = one.remaining.reasons().map(feasibility::Finding::words).collect();
    vec![Cell::text(&one.clip), Cell::text(words).tone(Some(tone)), Cell::text(remaining.join("; "))]
}
