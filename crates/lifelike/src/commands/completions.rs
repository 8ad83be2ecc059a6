//! `lifelike completions`: scripts that complete commands and options in a shell.

use clap::CommandFactory;

use crate::cli::Cli;
use crate::error::CliError;

/// Print a completion script for a shell.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  lifelike completions bash > ~/.local/share/bash-completion/completions/lifelike
  lifelike completions zsh > ~/.zfunc/_lifelike")]
pub struct Args {
    /// The shell.
    pub shell: clap_complete::Shell,
}

/// Runs the command.
///
/// # Errors
/// [`CliError::Failed`] where standard output cannot be written.
pub fn run(args: &Args) -> Result<(), CliError> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut Cli::command(), "lifelike", &mut script);
    std::io::Write::write_all(&mut std::io::stdout(), &script).map_err(|e| CliError::Failed(e.to_string()))
}
