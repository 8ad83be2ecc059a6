//! `lifelike man`: manual pages for packages, and the command reference of the documentation.

use std::fmt::Write as _;
use std::path::PathBuf;

use clap::{Command, CommandFactory};

use crate::cli::Cli;
use crate::error::CliError;

/// Width of help texts in the reference: what a page shows without scrolling.
const COLUMNS: usize = 90;

/// Write a manual page for every command, or all of them as one Markdown page.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Folder of the pages.
    #[arg(short, long, value_parser = crate::destination::folder)]
    pub output: PathBuf,
    /// Write commands.md, the help texts of all commands, in place of manual pages.
    #[arg(long)]
    pub markdown: bool,
}

/// Runs the command.
///
/// # Errors
/// A file cannot be written.
pub fn run(args: &Args) -> Result<(), CliError> {
    std::fs::create_dir_all(&args.output).map_err(CliError::write(&args.output))?;
    if !args.markdown {
        return clap_mangen::generate_to(Cli::command(), &args.output).map_err(CliError::write(&args.output));
    }
    let file = args.output.join("commands.md");
    crate::output::write(&file, markdown())
}

/// Returns the help texts of all commands as one page, a section each.
pub fn markdown() -> String {
    let mut root = Cli::command().max_term_width(COLUMNS).term_width(COLUMNS);
    root.build();
    let mut page = String::from(
        "# Commands\n\nThis page is generated from the program: it is what `lifelike COMMAND --help` prints.\n\n",
    );
    add(&mut page, &mut root);
    page
}

/// Adds a section on a command, then those on its subcommands.
fn add(page: &mut String, command: &mut Command) {
    let name = command.get_bin_name().unwrap_or_else(|| command.get_name()).to_string();
    let level = "#".repeat((name.split(' ').count() + 1).min(4));
    let _ = write!(page, "{level} {name}\n\n```text\n{}\n```\n\n", command.render_long_help().to_string().trim_end());
    for sub in command.get_subcommands_mut().filter(|sub| !sub.is_hide_set() && sub.get_name() != "help") {
        add(page, sub);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_command_has_a_section_that_fits() {
        let page = markdown();
        for command in ["lifelike", "lifelike motion retarget", "lifelike bench robustness", "lifelike eval"] {
            assert!(page.lines().any(|line| line.trim_start_matches('#').trim() == command), "{command}");
        }
        assert!(!page.contains("lifelike man\n"), "hidden commands are left out");
    }
}
