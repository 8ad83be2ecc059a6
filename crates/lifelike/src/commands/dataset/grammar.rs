//! `lifelike dataset grammar`: captioned motion of our own.

use std::path::PathBuf;
use std::time::Instant;

use lifelike_language::CaptionedSet;
use lifelike_language::grammar::{Generator, Grammar, Options, write};
use lifelike_robot::Robot;
use serde_json::json;

use super::{extent, extent_table, make_folders, rejected_table};
use crate::commands::clips;
use crate::error::CliError;
use crate::interrupt;
use crate::output::Output;
use crate::progress::Progress;

/// Make captioned motion of our own: sentences of a grammar, and clips that do what they say.
///
/// The grammar draws verbs, sides, directions, counts, speeds, sizes, moods, and pairs of actions. Keyframed clips are
/// changed accordingly and retargeted to the robot. Forward kinematics verifies every clip; clips that contradict their
/// captions are dropped and counted. No captured motion is needed, and the result is free to use. Some combinations and
/// words are held out for tests.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  lifelike dataset grammar --robot lima -o data/lima/grammar                 # 8 hours, in minutes
  lifelike dataset grammar --robot g1 -o data/g1/small --hours 0.2 --seed 3
  lifelike dataset grammar --robot g1 -o data/g1/small --hours 0.2 --seed 3 --resume
  # other verbs, other words
  lifelike dataset grammar --grammar my_grammar.toml -o data/lima/mine
  lifelike dataset check data/lima/grammar

The grammar is a text (crates/language/src/grammar/grammar.toml): verbs with their clip, what of it repeats,
and phrases.")]
pub struct Args {
    /// The robot: a name, or an MJCF or URDF file.
    #[arg(short, long, default_value = "lima")]
    pub robot: String,
    /// Folder of the data set; new or empty.
    #[arg(short, long, value_parser = crate::destination::folder)]
    pub output: PathBuf,
    /// Duration of all clips together.
    #[arg(long, default_value_t = 8.0)]
    pub hours: f64,
    /// Seed: another one makes other clips.
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Go on with the unfinished data set in the folder, after Ctrl-C or a kill.
    #[arg(long)]
    pub resume: bool,
    /// A grammar of your own (TOML) instead of the built-in one.
    #[arg(long)]
    pub grammar: Option<PathBuf>,
}

/// Runs the command.
pub fn run(args: &Args, output: &Output) -> Result<(), CliError> {
    if !(args.hours > 0.0 && args.hours <= 1000.0) {
        return Err(CliError::Usage(format!("--hours: expected more than 0 and at most 1000, got {}", args.hours)));
    }
    let grammar = load_grammar(args.grammar.as_deref())?;
    let robot = Robot::load(&args.robot)?;
    let mut options = clips::retarget_options(&robot);
    clips::limit_speeds(&mut options, &robot);
    if !args.resume {
        make_folders(&args.output)?;
    }
    let generator = Generator::new(&grammar, &robot.character, &robot.anatomy, options)?;
    for (verb, why) in &generator.left_out {
        tracing::warn!("{} cannot do '{verb}': {why}", robot.name);
    }
    let stop = interrupt::flag()?;
    let wanted = (3600.0 * args.hours).ceil() as u64;
    let mut progress = Progress::new(output, "seconds of motion", wanted);
    let limits = Options { hours: args.hours, seed: args.seed, resume: args.resume };
    let started = Instant::now();
    let summary = write(&generator, &args.output, &limits, &stop, |seconds| {
        progress.update(seconds as u64, wanted, || format!("{:.2} h", seconds / 3600.0));
    })?;
    let took = started.elapsed().as_secs_f64();
    progress.finish();
    let set = CaptionedSet::read(&args.output)?;
    let true_share = 1.0 - summary.dropped as f64 / summary.made.max(1) as f64;
    let value = json!({
        "summary": summary, "splits": extent(&set), "left_out": generator.left_out, "true_share": true_share,
        "seconds": took,
    });
    output.result(&value, || {
        let untrue = summary.untrue.iter().map(|(what, count)| (format!("not true: {what}"), *count));
        let failed = summary.failed.iter().map(|(why, count)| (format!("not made: {why}"), *count));
        let rejected = untrue.chain(failed).chain([("shorter or longer than clips are".into(), summary.unsuitable)]);
        format!(
            "{}\n{}\n{} clips, {:.2} hours, {} captions ({} different) in {}; {:.1} clips/s\n\
             true before untrue ones were dropped: {:.1} % of {}\n",
            extent_table(&set),
            rejected_table(&rejected.collect(), summary.drawn as usize),
            summary.clips,
            summary.hours,
            summary.captions,
            summary.different_captions,
            args.output.display(),
            summary.clips as f64 / took.max(1e-9),
            100.0 * true_share,
            summary.made
        )
    })?;
    if stop.load(std::sync::atomic::Ordering::SeqCst) {
        return Err(CliError::Interrupted(format!(
            "{:.2} of {} hours are in the data set; go on with the same command and --resume",
            summary.hours, args.hours
        )));
    }
    Ok(())
}

/// Loads a grammar; the built-in one where no file is named.
pub(super) fn load_grammar(file: Option<&std::path::Path>) -> Result<Grammar, CliError> {
    match file {
        None => Ok(Grammar::builtin()?),
        Some(path) => {
            let text = std::fs::read_to_string(path)
                .map_err(|error| CliError::Input(format!("{}: {error}", path.display())))?;
            Grammar::parse(&text).map_err(|error| CliError::Input(format!("{}: {error}", path.display())))
        }
    }
}
