//! `lifelike-thesis generation`: text to motion, measured (thesis Table 5.2, language, plausibility).

mod language;
mod made;
mod measured;
mod method;
mod tables;
mod task;

use std::path::{Path, PathBuf};

use lifelike_evaluation::{ThesisErrors, ThesisProtocol};
use lifelike_generation::critic::Critic;
use lifelike_generation::data::CaptionedMotion;
use lifelike_generation::evaluator::Evaluator;
use lifelike_generation::generator::SampleOptions;
use lifelike_generation::metrics::Gaussian;
use lifelike_generation::representation::RepresentationSpec;
use lifelike_language::grammar::Grammar;
use lifelike_language::{CaptionedSet, Entry, Split};
use lifelike_motion::MotionClip;
use lifelike_robot::Robot;
use serde::Serialize;

use self::made::Making;
use self::measured::{Measured, Motion, Ruler};
use self::method::{Method, Named};
use self::task::Task;
use lifelike::CliError;
use lifelike::Output;
use lifelike::commands::best_of::By;
use lifelike::commands::controller_file::Loaded;
use lifelike::commands::eval::{self, Job};
use lifelike::commands::physics::{self, Physics};
use lifelike::shipped::{self, Kind};

/// Measure generators on the sentences of a data set: thesis Table 5.2, exact checks of language, and plausibility.
///
/// Every sentence becomes a motion as long as the data set's own, as `lifelike generate` would make it. The first row of
/// each table is the data set itself. Intervals are 95% over the repetitions, each with other noise, pools and pairs.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  lifelike-thesis generation --data data/grammar --evaluator motion.evaluator.safetensors \\
      --generator MDM=runs/generator/motion.generator.safetensors
  lifelike-thesis generation --data data/grammar --split held_out \\
      --evaluator motion.evaluator.safetensors \\
      --critic motion.critic.safetensors --generator MDM=mdm.generator.safetensors \\
      --generator RobotMDM=aligned.generator.safetensors \\
      --guided guided=mdm.generator.safetensors@0.02 --keep kept
  lifelike-thesis generation --data data/grammar --generator MDM=mdm.generator.safetensors \\
      --tracker lima --episodes 2048          # thesis Table 5.3
  lifelike-thesis generation --data data/captures --critic c.critic.safetensors \\
      --policy p.controller.safetensors --best-of 8 \\
      --generator MDM=mdm.generator.safetensors --generator RobotMDM=aligned.generator.safetensors

Realism is the critic's mean value over a motion's rows; of what the same critic guided or aligned, it is no proof.
Metrics of the learned evaluator are comparable only where evaluator, data, split and number of motions are the same.")]
pub struct Args {
    /// Folder of captioned clips (dataset.jsonl and *.motion.safetensors).
    #[arg(long)]
    data: PathBuf,
    /// Part of the data set: train, validation, test or held_out.
    #[arg(long, default_value = "test", value_parser = split)]
    split: Split,
    /// A generator and its name in the tables.
    #[arg(long = "generator", value_name = "NAME=FILE", value_parser = method::named)]
    generators: Vec<Named>,
    /// A generator whose sampling the critic guides, with the strength of the guidance.
    #[arg(long, value_name = "NAME=FILE@STRENGTH", value_parser = method::guided, requires = "critic")]
    guided: Vec<Named>,
    /// A generator whose motions --policy plays in physics, what came of them in their place: PhysDiff's projection, one
    /// step.
    #[arg(long, value_name = "NAME=FILE", value_parser = method::projected, requires = "policy")]
    projected: Vec<Named>,
    /// Rows more for each --generator: of N motions of a sentence the best by the critic and the best by physics, as far as
    /// there are --critic and --policy.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(2..=1000))]
    best_of: Option<u64>,
    /// The controller that projects, and that chooses the best of N by physics.
    #[arg(long)]
    policy: Option<PathBuf>,
    /// Engine and threads of projection, best of N and tracker.
    #[command(flatten)]
    physics: Physics,
    /// A controller that follows the motions of every method: thesis Table 5.3, by the thesis' protocol.
    #[arg(long, value_name = "FILE")]
    tracker: Option<PathBuf>,
    /// Episodes of --tracker for each method.
    #[arg(long, default_value_t = 200, requires = "tracker", value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    episodes: u64,
    /// Length of each of these episodes (s).
    #[arg(long, default_value_t = 30.0, requires = "tracker")]
    seconds: f64,
    /// The evaluator: what `lifelike train evaluator` leaves. Without it there are no R-precision, FID and their like.
    #[arg(long)]
    evaluator: Option<PathBuf>,
    /// A critic, for Realism: what `lifelike train critic` leaves.
    #[arg(long)]
    critic: Option<PathBuf>,
    /// The robot: a built-in one's name, or its MJCF or URDF file.
    #[arg(long, default_value = "lima")]
    robot: String,
    /// Most entries, taken evenly from the split; all where not given.
    #[arg(long)]
    limit: Option<usize>,
    /// A row more for each generator: the data set's own motion, turned into its tokens and back. No training of that
    /// generator can be expected to beat it.
    #[arg(long)]
    tokens: bool,
    /// Motions of each sentence.
    #[arg(long, default_value_t = 3, value_parser = clap::value_parser!(u64).range(1..=1000))]
    repetitions: u64,
    /// Denoising steps; all of the generator's where not given.
    #[arg(long)]
    steps: Option<usize>,
    /// Noise that is added again in each step: 1 is DDPM, 0 is DDIM.
    #[arg(long, default_value_t = SampleOptions::default().eta)]
    eta: f64,
    /// Weight of the sentence: 0 ignores it, 1 takes it as it is, more exaggerates.
    #[arg(long, default_value_t = SampleOptions::default().guidance)]
    guidance: f64,
    /// Key of the randomness.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Folder for the generated clips, a folder for each method.
    #[arg(long)]
    keep: Option<PathBuf>,
    /// A JSON file of all numbers, with every check that failed.
    #[arg(short, long, value_parser = lifelike::destination::json)]
    output: Option<PathBuf>,
}

/// Everything measured.
#[derive(Debug, Serialize)]
struct Results {
    data: PathBuf,
    split: &'static str,
    evaluator: Option<PathBuf>,
    critic: Option<PathBuf>,
    /// Entries measured on, and how many there are.
    entries: usize,
    of: usize,
    /// Entries among them that are longer than a generator can make.
    left_out: usize,
    repetitions: u64,
    guidance: f64,
    steps: Option<usize>,
    eta: f64,
    seed: u64,
    /// The controller that followed the motions, and the protocol.
    tracker: Option<PathBuf>,
    protocol: ThesisProtocol,
    /// The data set, then every method.
    rows: Vec<Measured>,
}

/// Loads an evaluator from its file or by its name.
fn load_evaluator(path: &Path) -> Result<Evaluator, CliError> {
    Ok(Evaluator::load(&shipped::file(path, Kind::Evaluator)?)?)
}

/// Runs the command.
pub fn run(args: &Args, output: &Output) -> Result<(), CliError> {
    let robot = Robot::load(&args.robot)?;
    let spec = RepresentationSpec::of(&robot.layout);
    let evaluator = args.evaluator.as_deref().map(load_evaluator).transpose()?;
    evaluator.iter().try_for_each(|evaluator| evaluator.check(&spec))?;
    let critic = args.critic.as_deref().map(Critic::load).transpose()?;
    critic.iter().try_for_each(|critic| critic.check(&spec))?;
    if args.best_of.is_some() && critic.is_none() && args.policy.is_none() {
        return Err(CliError::Usage("--best-of needs --critic or --policy to choose by".into()));
    }
    let best = best_of(args);
    let named = args.generators.iter().chain(&best).chain(&args.guided).chain(&args.projected);
    let methods = Method::load_all(named, &robot)?;
    let loaded = args.policy.as_deref().map(|file| Loaded::load(file, Some(&args.robot), None)).transpose()?;
    let tracker = args.tracker.as_deref().map(|file| Loaded::load(file, Some(&args.robot), None)).transpose()?;
    let protocol =
        ThesisProtocol { episodes: args.episodes as usize, seconds: args.seconds, ..ThesisProtocol::default() };
    eval::checked(&protocol).map_err(CliError::Usage)?;
    physics::available(&args.physics.engine)?;
    let set = CaptionedSet::read(&args.data)?;
    let all: Vec<(usize, &Entry)> =
        set.entries.iter().enumerate().filter(|(_, entry)| entry.split == args.split).collect();
    if all.is_empty() {
        let (data, split) = (args.data.display(), args.split.name());
        return Err(CliError::Input(format!("{data}: expected entries of the split {split}, got none")));
    }
    let longest = methods.iter().map(Method::max_seconds).fold(f64::INFINITY, f64::min);
    let chosen = chosen(&all, args.limit);
    let count = chosen.len();
    let tasks: Vec<Task> = chosen.into_iter().filter(|(_, e)| e.seconds <= longest).map(Task::from).collect();

    let reference = match &evaluator {
        Some(evaluator) if all.len() > 1 => {
            let motions = CaptionedMotion::read(&set, all.iter().map(|(_, entry)| *entry), &spec)?;
            let rows: Vec<_> = motions.into_iter().map(|motion| motion.rows).collect();
            Some(Gaussian::of(&evaluator.motions(&rows)?)?)
        }
        _ => None,
    };
    let ruler = Ruler {
        robot: &robot,
        spec: &spec,
        evaluator: evaluator.as_ref(),
        critic: critic.as_ref(),
        grammar: Grammar::builtin()?,
        reference,
        keep_clips: tracker.is_some(),
        seed: args.seed,
        repetitions: args.repetitions,
    };
    let making = Making {
        ruler: &ruler,
        tasks: &tasks,
        options: SampleOptions {
            steps: args.steps,
            eta: args.eta,
            guidance: args.guidance,
            seed: args.seed,
            ..SampleOptions::default()
        },
        keep: args.keep.as_deref(),
    };
    let physics = loaded.as_ref().map(|loaded| Job { loaded, physics: &args.physics });
    let tracker = tracker.as_ref().map(|loaded| Job { loaded, physics: &args.physics });
    let measure = |name: &str, made: Vec<Motion>, seconds: Option<f64>| -> Result<Measured, CliError> {
        let measured = ruler.measure(name, &tasks, &made, seconds)?;
        let tracking = tracker.as_ref().map(|job| tracked(job, made, &protocol, output)).transpose()?;
        Ok(Measured { tracking, ..measured })
    };
    let mut rows = vec![measure("data set", making.of_data(&set)?, None)?];
    for method in methods.iter().filter(|_| args.tokens) {
        let name = format!("data set as tokens of {}", method.name);
        rows.push(measure(&name, making.of_tokens(method, &set)?, None)?);
    }
    for method in &methods {
        let (made, seconds) = making.of(method, physics.as_ref(), output)?;
        rows.push(measure(&method.name, made, Some(seconds))?);
    }
    let results = Results {
        data: args.data.clone(),
        split: args.split.name(),
        evaluator: args.evaluator.clone(),
        critic: args.critic.clone(),
        entries: tasks.len(),
        of: all.len(),
        left_out: count - tasks.len(),
        repetitions: args.repetitions,
        guidance: args.guidance,
        steps: args.steps,
        eta: args.eta,
        seed: args.seed,
        tracker: args.tracker.clone(),
        protocol,
        rows,
    };
    if let Some(file) = &args.output {
        lifelike::output::write_json(file, &results)?;
    }
    output.result(&results, || tables::text(&results))
}

/// Lets a controller follow motions by the thesis' protocol; each has a name of its own.
fn tracked(
    job: &Job<'_>,
    motions: Vec<Motion>,
    protocol: &ThesisProtocol,
    output: &Output,
) -> Result<ThesisErrors, CliError> {
    let clips = motions.into_iter().filter_map(|motion| motion.clip).enumerate();
    let clips: Vec<_> = clips.map(|(i, clip)| MotionClip { name: format!("{i} {}", clip.name), ..clip }).collect();
    Ok(job.thesis(&clips, protocol, output)?.errors)
}

/// Returns the rows of the best of several motions: by critic and by physics, as far as there are such.
fn best_of(args: &Args) -> Vec<Named> {
    let judges = [(By::Critic, args.critic.is_some()), (By::Physics, args.policy.is_some())];
    let there = judges.into_iter().filter(|(_, there)| *there).map(|(by, _)| by);
    let of = |(count, by): (u64, By)| args.generators.iter().map(move |named| named.best_of(count as usize, by));
    there.filter_map(|by| Some((args.best_of?, by))).flat_map(of).collect()
}

/// Returns entries evenly from all of a split.
fn chosen<'a>(all: &[(usize, &'a Entry)], limit: Option<usize>) -> Vec<(usize, &'a Entry)> {
    let count = limit.unwrap_or(all.len()).clamp(1, all.len());
    (0..count).map(|i| all[i * all.len() / count]).collect()
}

fn split(text: &str) -> Result<Split, String> {
    let known = || Split::ALL.map(Split::name).join(", ");
    Split::ALL.into_iter().find(|split| split.name() == text).ok_or_else(|| format!("expected one of {}", known()))
}
