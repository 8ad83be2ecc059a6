//! `lifelike demo`: the shortest way to see a robot follow motion in physics.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

use lifelike_evaluation::EvaluationOptions;
use lifelike_motion::MotionClip;
use lifelike_robot::Robot;
use serde_json::json;

use crate::commands::clips;
use crate::commands::controller_file::Loaded;
use crate::commands::eval::{Job, save, text};
use crate::commands::export::Source;
use crate::commands::physics::{self, Physics};
use crate::error::CliError;
use crate::next::{self, NextCommand};
use crate::output::Output;
use crate::shipped::{self, Kind};

/// See a robot follow motion in physics: a pretrained policy, our own clips, one page to look at.
///
/// Needs no download: clips and policies of lima and humanoid are in the program. Name files to see the policy on your own motion.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  lifelike demo
  lifelike demo --robot g1                 # the Unitree G1, once fetched: lifelike fetch g1
  lifelike demo my_walk.bvh my_wave.bvh -o runs/mine")]
pub struct Args {
    /// Motion to follow instead of our own clips: captured motion, keyframes or *.motion.safetensors.
    pub motions: Vec<PathBuf>,
    /// Layout of the motion.
    #[command(flatten)]
    pub layout: clips::LayoutArgument,
    /// Folder of the report.
    #[arg(short, long, default_value = "runs/demo", value_parser = crate::destination::folder)]
    pub output: PathBuf,
    /// Another policy than the one that comes with the program: a name, a file, or the folder of a run.
    #[arg(long)]
    pub policy: Option<PathBuf>,
    /// Robot of the policy: a name, or an MJCF or URDF file.
    #[arg(short, long, default_value = "lima")]
    pub robot: String,
    /// Longest episode (s).
    #[arg(long, default_value_t = 10.0)]
    pub seconds: f64,
    /// Engine and threads.
    #[command(flatten)]
    pub physics: Physics,
}

/// Runs the command.
pub fn run(args: &Args, output: &Output) -> Result<(), CliError> {
    physics::available(&args.physics.engine)?;
    let began = Instant::now();
    let robot = Arc::new(Robot::load(&args.robot)?);
    args.physics.require_ready(&robot)?;
    let file = shipped::controller(args.policy.as_deref(), &robot, &args.robot, || NextCommand::new("demo"))?;
    let Source { policy: file, prior, .. } = Source::of(&file)?;
    let loaded = Loaded::new(&file, Arc::clone(&robot), prior.as_deref())?;
    let clips = if args.motions.is_empty() {
        clips::builtin(&robot)
    } else {
        clips::load_as(&args.motions, args.layout, &robot)?
    };
    tracing::info!("{} clips retargeted to {} in {:.1} s", clips.len(), robot.name, began.elapsed().as_secs_f64());
    let options = EvaluationOptions { seconds: args.seconds, starts: 1, keep: 1, ..EvaluationOptions::default() };
    let job = Job { loaded: &loaded, physics: &args.physics };
    let evaluation = job.run(&clips, &options, output)?;
    let report =
        save(&evaluation, None, &robot, &format!("{} follows {} motions", robot.name, clips.len()), &args.output)?;
    let seconds = began.elapsed().as_secs_f64();
    let report = std::path::absolute(&report).unwrap_or(report);
    let value = json!({ "evaluation": evaluation, "report": report, "policy": file, "seconds": seconds });
    let next = next_steps(args);
    output.result(&value, || {
        format!(
            "{}{}\nfrom start to motion to look at: {seconds:.1} s\nopen this in a browser: {}\n{}",
            text(&evaluation),
            shortened(&clips, args.seconds),
            report.display(),
            next::lines(&next)
        )
    })
}

/// Returns a line on clips that are longer than what is played of them; nothing where there are none.
fn shortened(clips: &[MotionClip], seconds: f64) -> String {
    let longest = clips.iter().map(MotionClip::seconds).fold(0.0, f64::max);
    let count = clips.iter().filter(|clip| clip.seconds() > seconds).count();
    if count == 0 {
        return String::new();
    }
    format!(
        "{count} of {} clips are longer than {seconds} s and were cut; play all with --seconds {:.0}\n",
        clips.len(),
        longest.ceil()
    )
}

/// Returns the steps after the demo: motion from a sentence, and a policy of one's own.
fn next_steps(args: &Args) -> Vec<NextCommand> {
    let robot = args.robot.as_str();
    let has_generator = Robot::load(robot).is_ok_and(|robot| shipped::of_robot(&robot, Kind::Generator).is_some());
    let say = NextCommand::new("generate").word("a person waves with the right hand").word("--physics");
    let say = if robot == "lima" { say } else { say.word("--robot").word(robot) };
    let train = NextCommand::new("train tracker").word("--plan").word("track").word("--robot").word(robot);
    has_generator.then_some(say).into_iter().chain([train.word("budget.minutes=5")]).collect()
}
