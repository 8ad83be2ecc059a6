//! `lifelike train language`: a generator of motion from text for any robot, in one command.

use std::fs;
use std::path::{Path, PathBuf};

use lifelike_generation::generator;
use lifelike_language::{CaptionedSet, Split};
use lifelike_robot::Robot;
use serde::{Deserialize, Serialize};
use serde_json::json;

use crate::error::CliError;
use crate::next::NextCommand;
use crate::output::Output;

/// File with the options, and the steps that are done.
const FILE: &str = "language.json";
/// Sentences that nothing was trained on.
const SENTENCES: &str = "sentences.txt";

/// Train a generator of motion from text for a robot: data, network, and a test, in one command.
///
/// Each step is a command that you can give yourself, and has a folder. The first makes motion with captions from our own clips
/// for this robot, the second trains the generator. With --policy a critic follows, and the generator is aligned with what
/// the policy can execute. At the end, the network alone makes sentences that nothing was trained on, and their facts are checked.
/// After Ctrl-C or a kill the same command goes on in the middle of a step.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  # overnight on two cores
  lifelike train language --robot humanoid -o runs/words
  # and aligned with its policy
  lifelike train language --robot my.xml --policy runs/track -o runs/words
  lifelike train language --robot my.xml -o runs/words --hours 0.3 --minutes 20
  # the commands, to give them yourself
  lifelike train language --robot my.xml -o runs/words --dry-run

Afterwards `lifelike generate \"wave\" --robot ROBOT --generator FILE` uses what the command names last.")]
pub struct Args {
    /// The robot: a name, or an MJCF or URDF file.
    #[arg(short, long, default_value = "lima")]
    pub robot: String,
    /// Folder of all steps.
    #[arg(short, long, value_parser = crate::destination::folder)]
    pub output: PathBuf,
    /// Policy of the robot; with it the generator is aligned with physics.
    #[arg(long)]
    pub policy: Option<String>,
    /// Duration of the motion that the network learns from.
    #[arg(long, default_value_t = 8.0)]
    pub hours: f64,
    /// Time of the network's training.
    #[arg(long, default_value_t = 115.0)]
    pub minutes: f64,
    /// Sentences of the test.
    #[arg(long, default_value_t = 60, value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub sentences: u32,
    /// Seed of data and networks.
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Print the commands of all steps, and do nothing.
    #[arg(long)]
    pub dry_run: bool,
}

/// Contents of [`FILE`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct State {
    robot: String,
    policy: Option<String>,
    hours: f64,
    minutes: f64,
    sentences: u32,
    seed: u64,
    done: Vec<String>,
}

/// A step: a command line, and the folder that it leaves.
struct Step {
    name: &'static str,
    folder: PathBuf,
    words: Vec<String>,
    /// True for a training, which goes on with its own plan.
    is_training: bool,
}

/// Runs the command.
///
/// # Errors
/// Those of the steps; [`CliError::Usage`] where the folder has the steps of other options.
pub fn run(args: &Args, output: &Output) -> Result<(), CliError> {
    for (option, value) in [("--hours", args.hours), ("--minutes", args.minutes)] {
        if !(value > 0.0 && value <= 10_000.0) {
            return Err(CliError::Usage(format!("{option}: expected more than 0 and at most 10000, got {value}")));
        }
    }
    Robot::load(&args.robot)?;
    let steps = steps(args);
    let lines: Vec<String> = steps.iter().map(|step| line(&step.words)).collect();
    if args.dry_run {
        return output.result(&json!({ "commands": lines }), || lines.join("\n") + "\n");
    }
    let mut state = opened(args)?;
    for (number, step) in steps.iter().enumerate() {
        if state.done.iter().any(|done| done == step.name) {
            continue;
        }
        if !output.quiet {
            eprintln!("step {} of {}, {}: {}", number + 1, steps.len(), step.name, lines[number]);
        }
        if step.name == "test" {
            write_sentences(args)?;
        }
        perform(step, output)?;
        state.done.push(step.name.into());
        save(&args.output, &state)?;
    }
    let (generator, test) = (result(args), args.output.join("test"));
    let next = NextCommand::new("generate").word("wave with the left hand, then bow").robot(&args.robot);
    let next = next.path("--generator", &generator);
    let value = json!({ "robot": args.robot, "generator": generator, "test": test, "steps": state.done });
    output.result(&value, || format!("generator: {}\ntest: {}\nnext: {next}\n", generator.display(), test.display()))
}

/// Returns the steps.
fn steps(args: &Args) -> Vec<Step> {
    let folder = |name: &str| args.output.join(name);
    let text = |path: &Path| path.display().to_string();
    let words = |line: &[&str]| line.iter().map(|word| (*word).to_string()).collect::<Vec<_>>();
    let (data, seed) = (folder("data"), args.seed.to_string());
    let clips = format!("clips=[{:?}]", text(&data));
    let robot = format!("robot={:?}", args.robot);
    let mut out = vec![
        Step {
            name: "data",
            words: words(&[
                "dataset",
                "grammar",
                "--robot",
                &args.robot,
                "--hours",
                &args.hours.to_string(),
                "--seed",
                &seed,
                "-o",
                &text(&data),
            ]),
            folder: data,
            is_training: false,
        },
        Step {
            name: "generator",
            words: words(&[
                "train",
                "generator",
                "--plan",
                "generator",
                &robot,
                &clips,
                &format!("minutes={}", args.minutes),
                &format!("seed={seed}"),
                "-o",
                &text(&folder("generator")),
            ]),
            folder: folder("generator"),
            is_training: true,
        },
    ];
    if let Some(policy) = &args.policy {
        let critic = words(&[
            "train",
            "critic",
            "--plan",
            "critic",
            &robot,
            &format!("controller={policy:?}"),
            &clips,
            &format!("seed={seed}"),
            "-o",
            &text(&folder("critic")),
        ]);
        let align = words(&[
            "align",
            "--plan",
            "align",
            &robot,
            &clips,
            "--generator",
            &text(&folder("generator")),
            "--critic",
            &text(&folder("critic")),
            "--policy",
            policy,
            "-o",
            &text(&folder("aligned")),
        ]);
        out.push(Step { name: "critic", words: critic, folder: folder("critic"), is_training: true });
        out.push(Step { name: "alignment", words: align, folder: folder("aligned"), is_training: true });
    }
    let mut test = words(&["generate", "--prompts", &text(&folder(SENTENCES)), "--made-by", "network"]);
    test.extend(words(&["--robot", &args.robot, "--generator", &text(&result(args)), "--seed", &seed]));
    if let Some(policy) = &args.policy {
        test.extend(words(&["--physics", "--policy", policy]));
    }
    test.extend(words(&["-o", &text(&folder("test"))]));
    out.push(Step { name: "test", words: test, folder: folder("test"), is_training: false });
    out
}

/// Returns the generator that is the result.
fn result(args: &Args) -> PathBuf {
    args.output.join(if args.policy.is_some() { "aligned" } else { "generator" }).join(generator::FILE)
}

fn line(words: &[String]) -> String {
    words.iter().skip(1).fold(NextCommand::new(&words[0]), NextCommand::word).to_string()
}

/// Returns the state of the folder: what is there, or a new one.
fn opened(args: &Args) -> Result<State, CliError> {
    let new = State {
        robot: args.robot.clone(),
        policy: args.policy.clone(),
        hours: args.hours,
        minutes: args.minutes,
        sentences: args.sentences,
        seed: args.seed,
        done: Vec::new(),
    };
    let path = args.output.join(FILE);
    if !path.exists() {
        fs::create_dir_all(&args.output).map_err(CliError::write(&args.output))?;
        save(&args.output, &new)?;
        return Ok(new);
    }
    let text = fs::read_to_string(&path).map_err(|error| CliError::Input(format!("{}: {error}", path.display())))?;
    let old: State =
        serde_json::from_str(&text).map_err(|error| CliError::Input(format!("{}: {error}", path.display())))?;
    if (State { done: Vec::new(), ..old.clone() }) != new {
        let message = "the folder has steps of other options; give those, or another folder";
        return Err(CliError::Usage(format!("{}: {message}", path.display())));
    }
    Ok(old)
}

fn save(folder: &Path, state: &State) -> Result<(), CliError> {
    let path = folder.join(FILE);
    let text = serde_json::to_string_pretty(state).map_err(|error| CliError::Input(error.to_string()))?;
    lifelike_checkpoint::write_file(&path, text.as_bytes()).map_err(CliError::write(&path))
}

/// Performs a step, from where it was stopped.
fn perform(step: &Step, output: &Output) -> Result<(), CliError> {
    let is_begun = fs::read_dir(&step.folder).is_ok_and(|mut files| files.next().is_some());
    let folder = step.folder.display().to_string();
    let kind: Vec<&str> = step.words.iter().take_while(|word| !word.starts_with('-')).map(String::as_str).collect();
    let mut words: Vec<&str> = step.words.iter().map(String::as_str).collect();
    match (is_begun, step.is_training, step.name) {
        (true, true, _) => words = [&kind[..], &["--resume", "-o", &folder]].concat(),
        (true, false, "data") => words.push("--resume"),
        _ => {}
    }
    // Of a chain in JSON only the end is printed.
    crate::cli::run_part(&words, &Output { silent: output.silent || output.json, ..*output })
}

/// Writes sentences of the splits that nothing was trained on, spread over the data set.
fn write_sentences(args: &Args) -> Result<(), CliError> {
    let set = CaptionedSet::read(&args.output.join("data"))?;
    let mut entries: Vec<_> =
        set.entries.iter().filter(|entry| matches!(entry.split, Split::Test | Split::HeldOut)).collect();
    if entries.is_empty() {
        tracing::warn!(
            "nothing is held out of {} hours: the test repeats what was trained on; give more --hours",
            args.hours
        );
        entries = set.entries.iter().collect();
    }
    let count = (args.sentences as usize).min(entries.len());
    let spread = (0..count).map(|number| entries[number * entries.len() / count]);
    let sentences: Vec<&str> = spread.filter_map(|entry| entry.captions.first()).map(String::as_str).collect();
    let path = args.output.join(SENTENCES);
    fs::write(&path, sentences.join("\n") + "\n").map_err(CliError::write(&path))
}
