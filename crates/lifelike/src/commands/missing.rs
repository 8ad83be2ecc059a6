//! A command that this build has in name only, because it was made without the training framework.

use crate::error::CliError;
use crate::output::Output;

/// (Not in this build: it needs the feature `learning`.)
#[derive(Debug, clap::Args)]
#[command(disable_help_flag = true)]
pub struct Args {
    /// Whatever the command is told; it is not read.
    #[arg(hide = true, trailing_var_arg = true, allow_hyphen_values = true)]
    pub arguments: Vec<String>,
}

/// Says how to get a build that has the command.
///
/// # Errors
/// Always [`CliError::Unavailable`].
pub fn run(_: &Args, _: &Output) -> Result<(), CliError> {
    Err(CliError::Unavailable(
        "this build was made without the training framework (feature `learning`). The whole command is built by\n\
         \x20 cargo install --path crates/lifelike\n\
         or run in place by\n\
         \x20 cargo run --release --bin lifelike -- ..."
            .into(),
    ))
}
