//! `lifelike motion repair`: motion that a robot cannot execute becomes motion that it can.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use lifelike_evaluation::particles::{self, Executed, ParticleOptions};
use lifelike_motion::contacts::clip_contacts;
use lifelike_motion::edit::{self, Repaired};
use lifelike_motion::feasibility::{Feasibility, Finding};
use lifelike_motion::retarget::RetargetOptions;
use lifelike_motion::{MotionClip, container};
use lifelike_report::{Cell, Column, Table, Tone};
use lifelike_robot::{Robot, Shapes};
use rayon::prelude::*;
use serde_json::json;

use super::container_in;
use crate::commands::export::Source;
use crate::commands::physics::Physics;
use crate::commands::{clips, controller_file};
use crate::error::CliError;
use crate::next::{self, NextCommand};
use crate::output::Output;
use crate::progress::Progress;

/// Make motion feasible for a robot with as little change as it takes, or refuse it with the reason.
///
/// Without a policy, the repair uses kinematics and masses. It retimes jumps and joints that are too fast, and
/// lowers a robot that hovers. It sways the body to keep the ground's force below the feet. Arms, trunk and steps stay.
/// Trackable clips are copied unchanged. Clips that lie, roll or climb are refused.
///
/// With --policy, the repair uses physics. Many robots execute the motion at once, each with its own noise on actions.
/// Those that follow best are copied over those that fall. The result is a motion that was simulated from beginning to
/// end. A clip on which every robot falls is refused.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  lifelike motion repair data/lima --robot lima -o data/lima-feasible
  lifelike motion repair jump.motion.safetensors -o out && lifelike motion check out
  lifelike motion repair dance.motion.safetensors --policy lima -o out
  # without a policy, after retargeting
  lifelike motion retarget mocap/cmu --feasible -o motions/lima")]
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
    /// Write also what was made better but not feasible, or what came before all fell.
    #[arg(long)]
    pub keep_all: bool,
    /// The controller, or the policy, that is to execute the motion.
    #[arg(short, long)]
    pub policy: Option<PathBuf>,
    /// Robots that try at once.
    #[arg(long, default_value_t = 256, requires = "policy", value_parser = clap::value_parser!(u32).range(1..=65_536))]
    pub particles: u32,
    /// The largest standard deviation of the noise on actions, in units of the policy's outputs.
    #[arg(long, default_value_t = 0.2, requires = "policy")]
    pub noise: f64,
    /// Key of the noise.
    #[arg(long, default_value_t = 1, requires = "policy")]
    pub seed: u64,
    /// Cutoff of the low-pass filter on executed motion (Hz).
    #[arg(long, default_value_t = 4.0, requires = "policy")]
    pub cutoff: f64,
    /// Engine and threads.
    #[command(flatten)]
    pub physics: Physics,
    /// Folder of the results.
    #[arg(short, long, value_parser = crate::destination::folder)]
    pub output: PathBuf,
}

/// Runs the command.
pub fn run(args: &Args, output: &Output) -> Result<(), CliError> {
    if !(0.0..=10.0).contains(&args.noise) {
        return Err(CliError::Usage(format!("--noise: expected 0 to 10, got {}", args.noise)));
    }
    if args.cutoff.is_nan() || args.cutoff <= 0.0 {
        return Err(CliError::Usage(format!("--cutoff: expected a frequency above 0 Hz, got {}", args.cutoff)));
    }
    let robot = Arc::new(Robot::load(&args.robot)?);
    robot.require_ready(Shapes::All)?;
    let mut options = clips::retarget_options(&robot);
    clips::limit_speeds(&mut options, &robot);
    let loaded = clips::load_files(&args.motions, args.layout, &robot)?;
    let repaired = match &args.policy {
        Some(policy) => executed(args, policy, &robot, &options, &loaded, output)?,
        None => by_kinematics(&robot, &options, &loaded, output)?,
    };
    std::fs::create_dir_all(&args.output).map_err(CliError::write(&args.output))?;
    let mut written = 0;
    for (clip, _) in repaired.iter().filter(|(_, r)| args.keep_all || r.done()) {
        container::write(&container_in(&args.output, &clip.name)?, clip)?;
        written += 1;
    }
    let reports: Vec<&Outcome> = repaired.iter().map(|(_, report)| report).collect();
    let file = args.output.join("repair.json");
    let value = json!({ "folder": args.output, "written": written, "clips": reports });
    crate::output::write_json(&file, &value)?;
    output.result(&value, || summary(&reports, written, args))?;
    if written == 0 { Err(CliError::Input("every clip was refused".into())) } else { Ok(()) }
}

/// Outcome of a repair.
#[derive(serde::Serialize)]
struct Outcome {
    #[serde(flatten)]
    repaired: Repaired,
    /// Share of the clip that physics reached, with --policy.
    #[serde(skip_serializing_if = "Option::is_none")]
    reached: Option<f64>,
}

impl Outcome {
    /// Returns whether it can be used in place of the clip.
    fn done(&self) -> bool {
        self.reached.map_or(self.repaired.after.trackable, |share| share >= 1.0)
    }
}

type Loaded = [(PathBuf, MotionClip)];

fn by_kinematics(
    robot: &Robot,
    options: &RetargetOptions,
    loaded: &Loaded,
    output: &Output,
) -> Result<Vec<(MotionClip, Outcome)>, CliError> {
    let progress = Progress::new(output, "repairing", loaded.len() as u64);
    let bar = progress.shared();
    let one = |(_, clip): &(PathBuf, MotionClip)| {
        let (made, repaired) = edit::repair(clip, &robot.character, &robot.anatomy, &robot.speeds(), options)?;
        bar.inc(1);
        Ok((made, Outcome { repaired, reached: None }))
    };
    let all = loaded.par_iter().map(one).collect();
    progress.finish();
    all
}

/// The motions as a policy executes them at its best.
fn executed(
    args: &Args,
    policy: &Path,
    robot: &Arc<Robot>,
    options: &RetargetOptions,
    loaded: &Loaded,
    output: &Output,
) -> Result<Vec<(MotionClip, Outcome)>, CliError> {
    let Source { policy, prior, .. } = Source::of(policy)?;
    let controller = controller_file::Loaded::new(&policy, Arc::clone(robot), prior.as_deref())?;
    let simulate = |terrain, n| args.physics.simulate(terrain, robot, n);
    let setup = controller.setup(&simulate);
    let search = ParticleOptions {
        particles: args.particles as usize,
        noise: args.noise,
        seed: args.seed,
        ..ParticleOptions::default()
    };
    let mut progress = Progress::new(output, "executing", loaded.len() as u64);
    let mut all = Vec::with_capacity(loaded.len());
    for (k, (_, clip)) in loaded.iter().enumerate() {
        let Executed { mut motion, reached, .. } = particles::execute(&setup, clip, &search, |_, _| {})?;
        let (character, anatomy) = (&robot.character, &robot.anatomy);
        motion = edit::low_passed(&motion, args.cutoff)?;
        motion.contacts = Some(clip_contacts(&motion, character, anatomy, &options.contact.without_noise())?);
        let repaired = edit::compare(clip, &motion, character, anatomy, &robot.speeds(), options)?;
        all.push((motion, Outcome { repaired, reached: Some(reached) }));
        progress.update(k as u64 + 1, loaded.len() as u64, || clip.name.clone());
    }
    progress.finish();
    Ok(all)
}

fn summary(reports: &[&Outcome], written: usize, args: &Args) -> String {
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
    let words = |found: &Feasibility| found.reasons().next().map_or_else(String::new, Finding::words);
    for report in reports.iter().filter(|report| report.reached.is_some() || !report.repaired.before.trackable) {
        let (verdict, tone) = if report.done() { ("repaired", Tone::Good) } else { ("refused", Tone::Bad) };
        let Repaired { clip, before, after, change } = &report.repaired;
        let fell = report.reached.filter(|share| *share < 1.0);
        let still = fell.map_or_else(|| words(after), |share| format!("all fell by {:.0}% of it", 100.0 * share));
        table.rows.push(vec![
            Cell::text(clip),
            Cell::text(verdict).tone(Some(tone)),
            Cell::number(100.0 * change.root.mean, 1),
            Cell::number(100.0 * change.feet.mean, 1),
            Cell::number(change.legs.mean.to_degrees(), 1),
            Cell::number(change.others.mean.to_degrees(), 1),
            Cell::number(change.longer, 2),
            Cell::text(words(before)),
            Cell::text(still),
        ]);
    }
    let wrong = reports.iter().filter(|r| !r.repaired.before.trackable).count();
    let refused = reports.iter().filter(|r| !r.done()).count();
    format!(
        "{}\n{} of {} clips could be tracked as they were, as far as can be told without physics; {refused} are refused; \
         {written} are in {}\n{}",
        crate::output::fitted(&table),
        reports.len() - wrong,
        reports.len(),
        args.output.display(),
        next::lines(&[NextCommand::new("motion check").word(args.output.display()).robot(&args.robot)])
    )
}
