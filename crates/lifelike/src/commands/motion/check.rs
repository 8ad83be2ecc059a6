//! `lifelike motion check`: which clips a robot cannot execute, and why.

use std::path::PathBuf;

use lifelike_evaluation::Verdict;
use lifelike_evaluation::verdict::summary;
use lifelike_motion::feasibility::{Feasibility, Kind, check};
use lifelike_motion::lint::{Flaw, lint};
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
/// Mistakes of convention are named (`motion lint`).
/// A clip is untrackable if the robot has no support, or needs a ground force beside its feet or beyond friction. It is
/// also untrackable if joints are too fast, or if other parts than the soles touch the ground. A clip that passes may
/// still be too hard for motors or policy.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  lifelike motion check data/lima --robot lima
  # for --motions @trackable.txt
  lifelike motion check data/lima --list-trackable > trackable.txt
  lifelike --json motion check walk.motion.safetensors | jq '.[0].findings'")]
pub struct Args {
    /// Clips: files, folders, patterns, or @list.txt with one of them per line.
    #[arg(required = true)]
    pub motions: Vec<PathBuf>,
    /// Layout of the motion.
    #[command(flatten)]
    pub layout: clips::LayoutArgument,
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
    let checked = clips::load_files(&args.motions, args.layout, &robot)?
        .into_par_iter()
        .map(|(file, clip)| {
            let found = check(&clip, &robot.character, &robot.anatomy, &robot.speeds())?;
            let mistakes = lint(&clip, &robot.character, &robot.anatomy)?.1;
            Ok(Checked { file, found, mistakes })
        })
        .collect::<Result<Vec<Checked>, CliError>>()?;
    if args.list_trackable {
        let trackable: Vec<&PathBuf> = checked.iter().filter(|c| c.is_good()).map(|c| &c.file).collect();
        return output.result(&trackable, || trackable.iter().map(|f| f.display().to_string() + "\n").collect());
    }
    let value = |c: &Checked| json!({ "file": c.file, "feasibility": c.found, "mistakes": c.mistakes });
    let value: Vec<_> = checked.iter().map(value).collect();
    let untrackable = checked.iter().any(|c| !c.found.trackable);
    let next = match checked.iter().any(|c| !c.mistakes.is_empty()) {
        true => vec![fix(args)],
        false => next(args, &robot, untrackable),
    };
    output.result(&value, || text(&checked) + &next::lines(&next))
}

/// A clip, its findings and its mistakes of convention.
struct Checked {
    file: PathBuf,
    found: Feasibility,
    mistakes: Vec<Flaw>,
}

impl Checked {
    fn verdict(&self) -> Verdict {
        match self.mistakes.first() {
            Some(flaw) => Verdict::Untrackable { reason: flaw.mistake.words() },
            None => Verdict::without_physics(&self.found),
        }
    }

    fn is_good(&self) -> bool {
        self.verdict().is_good()
    }
}

/// Returns the command that corrects mistakes of convention.
fn fix(args: &Args) -> NextCommand {
    let clips = args.motions.iter().take(MAX_CLIPS);
    let line = clips.fold(NextCommand::new("motion lint"), |line, clip| line.word(clip.display()));
    line.word("--robot").word(&args.robot).word("--fix").word("-o").word("fixed")
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

fn text(checked: &[Checked]) -> String {
    let columns = vec![
        Column::text("clip"),
        Column::text("verdict"),
        Column::number("length", "s"),
        Column::text("worst of each kind"),
    ];
    let mut table = Table::new("Clips", columns).main_columns(&["clip", "verdict", "length"]);
    table.rows = checked.iter().map(row).collect();
    let verdicts: Vec<Verdict> = checked.iter().map(Checked::verdict).collect();
    let kinds = Kind::ALL.into_iter().filter_map(|kind| {
        let clips = checked.iter().filter(|c| c.found.reasons().any(|r| r.kind == kind)).count();
        (clips > 0).then(|| format!("{}: {clips}\n", kind.words()))
    });
    let kinds: String = kinds.collect();
    let mistakes = checked.iter().flat_map(|c| c.mistakes.iter().map(move |flaw| (c, flaw)));
    let mistakes: String = mistakes.map(|(c, flaw)| format!("{}: {}\n", c.found.clip, flaw.words())).collect();
    format!(
        "{}\n{kinds}{mistakes}{}, as far as can be told without physics\n",
        fitted(&table),
        summary(verdicts.iter())
    )
}

/// The verdict, and of each kind the longest stretch with the seconds of all of them.
fn row(checked: &Checked) -> Vec<Cell> {
    let f = &checked.found;
    let kinds = Kind::ALL.into_iter().filter_map(|kind| {
        let all = || f.findings.iter().filter(move |x| x.kind == kind);
        let ruling = f.reasons().find(|x| x.kind == kind)?;
        let seconds: f64 = all().map(|x| x.seconds).sum();
        Some(format!("{} ({seconds:.2} s in all)", ruling.words()))
    });
    let why = kinds.collect::<Vec<_>>().join("; ");
    let tone = if checked.is_good() { Tone::Good } else { Tone::Bad };
    let verdict = Cell::text(checked.verdict().to_string()).tone(Some(tone));
    vec![Cell::text(&f.clip), verdict, Cell::number(f.seconds, 1), Cell::text(why)]
}
