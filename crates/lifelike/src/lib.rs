//! Floor 8: the command `lifelike` as a library. The program is [`Cli`], parsed and executed.
//!
//! The main path of every command: typed arguments ([`commands`], one file each, with a `run` function) → a plan
//! ([`plans`]: a built-in one or a file, with `key=value` changes) → the libraries below do the work, with progress and
//! Ctrl-C → an [`Output`]: text for people, JSON for scripts, files. Failures are [`CliError`]s with an exit code.
//! Results go to standard output; progress and logs go to standard error.
//!
//! ```
//! use clap::Parser;
//! use lifelike::commands::{Command, motion::Motion};
//! use lifelike::{Cli, Output};
//!
//! // The arguments of a command are a value: from a command line ...
//! let folder = std::env::temp_dir().join("lifelike-doc");
//! let line = ["lifelike", "motion", "trim", "builtin:wave", "--end", "3", "-o"];
//! let cli = Cli::parse_from(line.into_iter().chain(folder.to_str()));
//! let Command::Motion(Motion::Trim(mut arguments)) = cli.command else { unreachable!() };
//! // ... changed, and run.
//! arguments.end = Some(2.0);
//! lifelike::commands::motion::trim::run(&arguments, &Output { json: true, quiet: true, silent: false })?;
//! # Ok::<(), lifelike::CliError>(())
//! ```
//!
//! # Features
//! `mpi` adds several processes that train one policy.

pub mod bounds;
mod cli;
pub mod commands;
pub mod destination;
mod error;
mod folders;
mod interrupt;
mod next;
pub mod output;
pub mod overrides;
pub mod plans;
pub mod progress;
pub mod shipped;
pub mod simulated_robot;

pub use cli::{Cli, GlobalOptions, run};
pub use error::CliError;
pub use output::{Output, table};
