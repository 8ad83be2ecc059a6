//! `lifelike motion repair`: motion that a robot cannot execute becomes motion that it can.

use std::path::PathBuf;

use lifelike_motion::edit::{Repaired, repair};
use lifelike_motion::{MotionClip, container};
use lifelike_report::{Cell, Column, Table, Tone};
use lifelike_robot::{Robot, Shapes};
use rayon::prelude::*;
use serde_json::json;

use super::container_in;
use crate::commands::clips;
use crate::error::CliError;
use crate::output::Output;
use crate::progress::Progress;

/// Make motion feasible for a robot with as little change as it takes, or refuse it with the reason.
///
/// Jumps that fall slower than things do and joints that are too fast get another pace; what hovers comes down; where the ground's force
/// would have to act beside the feet, the body sways above its steps. Arms, trunk and steps stay. Clips that can be tracked are
/// written as they are. What lies, rolls or climbs is refused.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  lifelike motion repair data/lima --robot lima -o data/lima-feasible
  lifelike motion repair jump.motion.safetensors -o out && lifelike motion check out
  lifelike motion retarget mocap/cmu --feasible -o motions/lima           # the same after retargeting")]
pub struct Args {
    /// Clips: files, folders, patterns, or @list.txt with one of them per line.
    #[arg(required = true)]
    pub motions: Vec<PathBuf>,
    /// The robot: a name, or an MJCF or URDF file.
    #[arg(short, long, default_value = "lima")]
    pub robot: String,
    /// Write also what was made better but not feasible.
    #[arg(long)]
    pub keep_all: bool,
    /// Folder of the results.
    #[arg(short, long)]
    pub output: PathBuf,
}

/// Runs the command.
pub fn run(args: &Args, output: &Output) -> Result<(), CliError> {
    let robot = Robot::load(&args.robot)?;
    robot.require_ready(Shapes::All)?;
    let mut options = clips::retarget_options(&robot);
    clips::limit_speeds(&mut options, &robot);
    let loaded = clips::load_files(&args.motions, &robot)?;
    let progress = Progress::new(output, "repairing", loaded.len() as u64);
    let bar = progress.shared();
    let one = |(_, clip): &(PathBuf, MotionClip)| {
        let made = repair(clip, &robot.character, &robot.anatomy, &robot.speeds(), &options)?;
        bar.inc(1);
        Ok(made)
    };
    let repaired = loaded.par_iter().map(one).collect::<Result<Vec<(MotionClip, Repaired)>, CliError>>()?;
    progress.finish();
    std::fs::create_dir_all(&args.output).map_err(CliError::write(&args.output))?;
    let mut written = 0;
    for (clip, _) in repaired.iter().filter(|(_, r)| args.keep_all || r.after.trackable) {
        container::write(&container_in(&args.output, &clip.name), clip)?;
        written += 1;
    }
    let reports: Vec<&Repaired> = repaired.iter().map(|(_, report)| report).collect();
    let file = args.output.join("repair.json");
    let value = json!({ "folder": args.output, "written": written, "clips": reports });
    let text = serde_json::to_string_pretty(&value).map_err(|error| CliError::Failed(error.to_string()))?;
    std::fs::write(&file, text).map_err(CliError::write(&file))?;
    output.result(&value, || summary(&reports, written, args))?;
    if written == 0 { Err(CliError::Input("every clip was refused".into())) } else { Ok(()) }
}

fn summary(reports: &[&Repaired], written: usize, args: &Args) -> String {
    let columns = vec![
        Column::text("clip"),
        Column::text("verdict"),
        Column::number("root", "cm"),
        Column::number("feet", "cm"),
        Column::number("legs", "deg"),
        Column::number("others", "deg"),
        Column::number("longer", "s"),
        Column::text("was"),
        Column::text("still is"),
    ];
    let mut table = Table::new("Changed clips (mean over frames)", columns);
    for report in reports.iter().filter(|report| !report.before.trackable) {
        let (verdict, tone) = match report.after.trackable {
            true => ("repaired", Tone::Good),
            false => ("refused", Tone::Bad),
        };
        let c = &report.change;
        let why = |found: &lifelike_motion::feasibility::Feasibility| {
            found.reasons().next().map_or_else(String::new, lifelike_motion::feasibility::Finding::words)
        };
        table.rows.push(vec![
            Cell::text(&report.clip),
            Cell::text(verdict).tone(Some(tone)),
            Cell::number(100.0 * c.root[0], 1),
            Cell::number(100.0 * c.feet[0], 1),
            Cell::number(c.legs[0].to_degrees(), 1),
            Cell::number(c.others[0].to_degrees(), 1),
            Cell::number(c.longer, 2),
            Cell::text(why(&report.before)),
            Cell::text(why(&report.after)),
        ]);
    }
    let wrong = reports.iter().filter(|r| !r.before.trackable).count();
    let still = reports.iter().filter(|r| !r.after.trackable).count();
    format!(
        "{}\n{} of {} clips could be tracked as they were, {} were repaired, {still} are refused; {written} are in {}\n",
        table.to_text(),
        reports.len() - wrong,
        reports.len(),
        wrong - still,
        args.output.display()
    )
}
