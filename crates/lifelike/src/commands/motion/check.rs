//! `lifelike motion check`: which clips a robot cannot execute, and why.

use std::path::PathBuf;

use lifelike_evaluation::Verdict;
use lifelike_evaluation::verdict::summary;
use lifelike_motion::feasibility::{Feasibility, Kind, check};
use lifelike_report::{Cell, Column, Table, Tone};
use lifelike_robot::{Robot, Shapes};
use rayon::prelude::*;
use serde_json::json;

use crate::commands::clips;
use crate::error::CliError;
use crate::next::{self, MAX_CLIPS, NextCommand};
use crate::output::{Output, fitted};
use crate::shipped;

/// Tell which clips a robot cannot execute, and why: from kinematics and masses, without physics.
///
/// A clip is untrackable where nothing holds it up, where the ground's force would have to act beside the feet or to be rougher,
/// where joints are too fast, or where something else than the soles is on the ground or in it. A clip that passes may still
/// be too hard for motors or policy.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  lifelike motion check data/lima --robot lima
  lifelike motion check data/lima --list-trackable > trackable.txt    # for --motions @trackable.txt
  lifelike --json motion check walk.motion.safetensors | jq '.[0].findings'")]
pub struct Args {
    /// Clips: files, folders, patterns, or @list.txt with one of them per line.
    #[arg(required = true)]
    pub motions: Vec<PathBuf>,
    /// The robot: a name, or an MJCF or URDF file.
    #[arg(short, long, default_value = "lima")]
    pub robot: String,
    /// Print only the paths of the clips that can be tracked, a line each.
    #[arg(long)]
    pub list_trackable: bool,
}

/// Runs the command.
pub fn run(args: &Args, output: &Output) -> Result<(), CliError> {
    let robot = Robot::load(&args.robot)?;
    robot.require_ready(Shapes::All)?;
    let checked = clips::load_files(&args.motions, &robot)?
        .into_par_iter()
        .map(|(file, clip)| Ok((file, check(&clip, &robot.character, &robot.anatomy, &robot.speeds())?)))
        .collect::<Result<Vec<(PathBuf, Feasibility)>, CliError>>()?;
    if args.list_trackable {
        let trackable: Vec<&PathBuf> = checked.iter().filter(|(_, f)| f.trackable).map(|(file, _)| file).collect();
        return output.result(&trackable, || trackable.iter().map(|f| f.display().to_string() + "\n").collect());
    }
    let value: Vec<_> = checked.iter().map(|(file, f)| json!({ "file": file, "feasibility": f })).collect();
    let untrackable = checked.iter().any(|(_, found)| !found.trackable);
    let next = next(args, &robot, untrackable);
    output.result(&value, || text(&checked) + &next::lines(&next))
}

/// Returns the step after a check: a repair of what cannot be tracked, else physics.
fn next(args: &Args, robot: &Robot, untrackable: bool) -> Vec<NextCommand> {
    let clips =
        |line: NextCommand| args.motions.iter().take(MAX_CLIPS).fold(line, |line, clip| line.word(clip.display()));
    if untrackable {
        let repair = clips(NextCommand::new("motion repair")).word("--robot").word(&args.robot);
        return vec![repair.word("-o").word("repaired")];
    }
    if shipped::has_controller(robot) {
        return vec![clips(NextCommand::new("demo")).robot(&args.robot)];
    }
    let list = args.motions.iter().map(|clip| format!("\"{}\"", clip.display())).collect::<Vec<_>>().join(", ");
    let train = NextCommand::new("train tracker").word("--plan").word("track").word("--robot").word(&args.robot);
    vec![train.word(format!("clips=[{list}]"))]
}

fn text(checked: &[(PathBuf, Feasibility)]) -> String {
    let columns = vec![
        Column::text("clip"),
        Column::text("verdict"),
        Column::number("length", "s"),
        Column::text("worst of each kind"),
    ];
    let mut table = Table::new("Clips", columns).main_columns(&["clip", "verdict", "length"]);
    table.rows = checked.iter().map(|(_, f)| row(f)).collect();
    let verdicts: Vec<Verdict> = checked.iter().map(|(_, f)| Verdict::without_physics(f)).collect();
    let kinds = Kind::ALL.into_iter().filter_map(|kind| {
        let clips = checked.iter().filter(|(_, f)| f.reasons().any(|r| r.kind == kind)).count();
        (clips > 0).then(|| format!("{}: {clips}\n", kind.words()))
    });
    let kinds: String = kinds.collect();
    format!("{}\n{kinds}{}, as far as can be told without physics\n", fitted(&table), summary(verdicts.iter()))
}

/// The verdict, and of each kind the longest stretch with the seconds of all of them.
fn row(f: &Feasibility) -> Vec<Cell> {
    let kinds = Kind::ALL.into_iter().filter_map(|kind| {
        let all = || f.findings.iter().filter(move |x| x.kind == kind);
        // What never rules a clip out is told all the same.
        let ruling = f.reasons().find(|x| x.kind == kind);
        let ruling = ruling.or_else(|| all().find(|x| x.kind.patience().is_infinite()))?;
        let seconds: f64 = all().map(|x| x.seconds).sum();
        Some(format!("{} ({seconds:.2} s in all)", ruling.words()))
    });
    let why = kinds.collect::<Vec<_>>().join("; ");
    let tone = if f.trackable { Tone::Good } else { Tone::Bad };
    let verdict = Cell::text(Verdict::without_physics(f).to_string()).tone(Some(tone));
    vec![Cell::text(&f.clip), verdict, Cell::number(f.seconds, 1), Cell::text(why)]
}
