//! The command line as one value: parsed arguments, logs, exit code.

use std::ffi::OsString;
use std::process::ExitCode;

use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{ArgAction, Parser};
use lifelike_simd::InstructionSet;
use tracing_subscriber::Layer;
use tracing_subscriber::filter::{LevelFilter, Targets};
use tracing_subscriber::layer::SubscriberExt;
use tracing_subscriber::util::SubscriberInitExt;

use crate::commands::Command;
use crate::error::CliError;
use crate::output::{self, Output};

/// Lifelike motion for robots and physics-based characters.
///
/// Retarget human motion to any robot, learn a motion prior and a policy that follows it in physics, and look at it.
#[derive(Debug, Parser)]
#[command(name = "lifelike", version = VERSION, propagate_version = true, max_term_width = 100, after_help = AFTER)]
pub struct Cli {
    /// Options of every command.
    #[command(flatten)]
    pub options: GlobalOptions,
    /// The command.
    #[command(subcommand)]
    pub command: Command,
}

/// Options of every command, of this program and of others that are built on this library.
#[derive(Debug, clap::Args)]
pub struct GlobalOptions {
    /// Print JSON for scripts instead of text.
    #[arg(long, global = true)]
    pub json: bool,
    /// Say more on standard error, such as every checkpoint; twice for what libraries have to say, too.
    #[arg(short, long, global = true, action = ArgAction::Count)]
    pub verbose: u8,
    /// Say nothing but errors on standard error.
    #[arg(short, long, global = true, conflicts_with = "verbose")]
    pub quiet: bool,
    /// Show all columns of tables, however wide they become.
    #[arg(long, global = true)]
    pub wide: bool,
}

/// Version, commit and features.
const VERSION: &str = env!("LIFELIKE_VERSION");

const AFTER: &str = "\
See a robot follow motion in physics, and make motion from a sentence, without any download:
  lifelike demo
  lifelike generate \"a person waves with the right hand\" --physics -o wave.motion.safetensors

A first policy in minutes, on our own keyframed clips:
  lifelike train tracker --plan track -o runs/first budget.minutes=5
  lifelike eval --policy runs/first --motions builtin -o runs/first/evaluation

From captured motion to a robot that follows it:
  lifelike motion retarget walk.bvh --robot lima -o data/lima
  lifelike train tracker --plan track 'clips=[\"data/lima\"]' -o runs/mine
  lifelike eval --policy runs/mine --motions data/lima -o report

`lifelike plans` lists the training plans that come with the program.

Vector instructions are the best of this machine; LIFELIKE_SIMD=avx2 (or another that `lifelike inspect --machine` lists)
forces others.

Exit codes: 0 done, 1 failed, 2 wrong usage, 3 bad input, 4 this build cannot do it, 130 interrupted (and saved).";

impl Cli {
    /// Reads the program's arguments; prints what is wrong with them, or the help that they ask for, and exits.
    pub fn of_arguments() -> Self {
        Self::of(std::env::args_os())
    }

    /// Reads a command line, the program's name first; exits as [`Self::of_arguments`] does.
    pub fn of(line: impl IntoIterator<Item = impl Into<OsString> + Clone>) -> Self {
        Self::try_parse_from(line).unwrap_or_else(|error| match key_with_dashes(&error) {
            Some(hint) => {
                eprintln!("error: {hint}");
                std::process::exit(i32::from(CliError::Usage(hint).code()))
            }
            None => error.exit(),
        })
    }

    /// Runs the command, prints its result or its error, and returns the exit code.
    pub fn execute(self) -> ExitCode {
        ExitCode::from(self.exit_code())
    }

    /// As [`Self::execute`], for callers that are not `main`: the exit code is a number.
    pub fn exit_code(self) -> u8 {
        self.options.execute(|output| self.command.run(output))
    }
}

impl GlobalOptions {
    /// Starts the logs, runs a command, prints its error, and returns the exit code.
    pub fn execute(&self, command: impl FnOnce(&Output) -> Result<(), CliError>) -> u8 {
        lifelike_nn::memory::tune_allocator();
        self.start_logs();
        output::show_all_columns(self.wide);
        let output = self.output();
        // A named instruction set is wanted for its numbers or its speed: no other takes its place.
        let available = InstructionSet::from_environment().map_err(|e| CliError::Usage(e.to_string()));
        match available.and_then(|_| command(&output)) {
            Ok(()) => 0,
            Err(error) => {
                output.error(&error);
                error.code()
            }
        }
    }

    fn output(&self) -> Output {
        Output { json: self.json, quiet: self.quiet, silent: false }
    }

    fn start_logs(&self) {
        let lines = tracing_subscriber::fmt::layer().with_writer(std::io::stderr).with_target(false).without_time();
        let lines = lines.with_ansi(output::colours(&std::io::stderr()));
        tracing_subscriber::registry().with(lines.with_filter(self.logs())).init();
    }

    /// Returns the level of messages of each crate. Libraries say what they do only to those who ask twice: what a
    /// card's compiler says would fill a disk.
    fn logs(&self) -> Targets {
        let (own, libraries) = match (self.quiet, self.verbose) {
            (true, _) => (LevelFilter::ERROR, LevelFilter::ERROR),
            (false, 0) => (LevelFilter::INFO, LevelFilter::WARN),
            (false, 1) => (LevelFilter::DEBUG, LevelFilter::WARN),
            (false, _) => (LevelFilter::TRACE, LevelFilter::TRACE),
        };
        // Names of this project's crates begin so.
        Targets::new().with_default(libraries).with_target("lifelike", own)
    }
}

/// Runs one command line, without the program's name, in the calling process.
///
/// # Errors
/// [`CliError::Usage`] for arguments that are none, else as the command.
pub fn run(arguments: &[&str]) -> Result<(), CliError> {
    let cli = parsed(arguments)?;
    cli.command.run(&cli.options.output())
}

/// Runs one command line as a part of another command, which says how it prints.
///
/// # Errors
/// As [`run`].
pub(crate) fn run_part(arguments: &[&str], output: &Output) -> Result<(), CliError> {
    parsed(arguments)?.command.run(output)
}

fn parsed(arguments: &[&str]) -> Result<Cli, CliError> {
    Cli::try_parse_from(std::iter::once(&"lifelike").chain(arguments)).map_err(|e| CliError::Usage(e.to_string()))
}

/// Returns the remedy for `--budget.minutes=5`: keys of a plan stand without dashes.
fn key_with_dashes(error: &clap::Error) -> Option<String> {
    let argument = match error.get(ContextKind::InvalidArg)? {
        ContextValue::String(argument) if error.kind() == ErrorKind::UnknownArgument => argument,
        _ => return None,
    };
    let key = argument.strip_prefix("--").filter(|key| key.contains('.'))?;
    Some(format!("unexpected argument '{argument}': a key of a plan has no dashes, as in '{key}=VALUE'"))
}

#[cfg(test)]
mod tests {
    use clap::{CommandFactory, Parser};
    use tracing::Level;

    #[test]
    fn the_arguments_are_consistent() {
        super::Cli::command().debug_assert();
    }

    #[test]
    fn a_key_with_dashes_is_told_without() {
        let hint = |argument| {
            let parsed = super::Cli::try_parse_from(["lifelike", "train", "tracker", argument]);
            parsed.err().and_then(|error| super::key_with_dashes(&error))
        };
        let expected =
            "unexpected argument '--budget.minutes': a key of a plan has no dashes, as in 'budget.minutes=VALUE'";
        assert_eq!(hint("--budget.minutes=5").as_deref(), Some(expected));
        assert_eq!(hint("--budget"), None);
    }

    #[test]
    fn libraries_speak_only_when_asked_twice() {
        let says = |flags: &[&str], target, level| {
            let words = [&["lifelike"], flags, &["plans"]].concat();
            super::Cli::parse_from(words).options.logs().would_enable(target, &level)
        };
        for (flags, own, libraries) in [
            (&["-q"][..], Level::ERROR, Level::ERROR),
            (&[], Level::INFO, Level::WARN),
            (&["-v"], Level::DEBUG, Level::WARN),
            (&["-vv"], Level::TRACE, Level::TRACE),
        ] {
            for (target, least) in
                [("lifelike::cli", own), ("lifelike_report::run", own), ("symphonia_core", libraries)]
            {
                for level in [Level::ERROR, Level::WARN, Level::INFO, Level::DEBUG, Level::TRACE] {
                    assert_eq!(says(flags, target, level), level <= least, "{flags:?} {target} {level}");
                }
            }
        }
    }
}
