//! `lifelike man`: manual pages for packages, and the command reference of the documentation.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

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
        let mut root = Cli::command().disable_help_subcommand(true);
        root.build();
        return pages(&root, &args.output);
    }
    let file = args.output.join("commands.md");
    crate::output::write(&file, markdown())
}

/// Writes a manual page of a command and of those below it, each whole or not at all.
fn pages(command: &Command, folder: &Path) -> Result<(), CliError> {
    for sub in command.get_subcommands().filter(|sub| !sub.is_hide_set()) {
        pages(sub, folder)?;
    }
    let page = clap_mangen::Man::new(command.clone());
    let (file, mut text) = (folder.join(page.get_filename()), Vec::new());
    page.render(&mut text).map_err(CliError::write(&file))?;
    crate::output::write(&file, text)
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
#[allow(clippy::unwrap_used)]
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

    /// Longest sentence of a help text (words).
    const WORDS: usize = 25;
    /// Words that begin a question, and no other sentence.
    const QUESTIONS: [&str; 5] = ["What", "How", "Where", "Whether", "Who"];

    /// Returns the sentences of a text; indented lines are examples, and have none.
    fn sentences(text: &str) -> Vec<Vec<&str>> {
        let mut found = vec![Vec::new()];
        for line in text.lines() {
            if line.trim().is_empty() || line.starts_with(' ') {
                found.push(Vec::new());
                continue;
            }
            for word in line.split_whitespace() {
                found.last_mut().unwrap().push(word);
                if word.trim_end_matches([')', '"', '`']).ends_with(['.', '?', '!', ':']) {
                    found.push(Vec::new());
                }
            }
        }
        found.retain(|words| !words.is_empty());
        found
    }

    /// Returns the sentences of a command's help, and of its subcommands', that are long or begin as questions do.
    fn unreadable(command: &Command) -> Vec<String> {
        let texts = [command.get_long_about().or(command.get_about()), command.get_after_help()];
        let arguments = command.get_arguments().map(|argument| argument.get_long_help().or(argument.get_help()));
        let texts: Vec<String> = texts.into_iter().chain(arguments).flatten().map(ToString::to_string).collect();
        let is_wrong = |words: &Vec<&str>| {
            let is_question = words.last().is_some_and(|word| word.ends_with('?'));
            words.len() > WORDS || (QUESTIONS.contains(&words[0]) && !is_question)
        };
        let name = command.get_bin_name().unwrap_or_else(|| command.get_name());
        let wrong = texts.iter().flat_map(|text| sentences(text)).filter(is_wrong);
        let own = wrong.map(|words| format!("{name}: {}", words.join(" "))).collect();
        let shown = command.get_subcommands().filter(|sub| !sub.is_hide_set());
        std::iter::once(own).chain(shown.map(unreadable)).flatten().collect()
    }

    #[test]
    fn sentences_of_help_are_short_and_begin_with_their_subject() {
        assert_eq!(sentences("One two. Three\nfour:\n  an example\nfive").len(), 3);
        let mut root = Cli::command();
        root.build();
        let wrong = unreadable(&root);
        assert!(wrong.is_empty(), "{wrong:#?}");
    }

    /// Returns the lines of examples that a help of 100 columns would break in two, which cannot be copied then.
    fn broken(command: &Command) -> Vec<String> {
        let examples = command.get_after_help().map(ToString::to_string).unwrap_or_default();
        let long = examples.lines().filter(|line| line.starts_with("  ") && line.chars().count() > 98);
        let own = long.map(str::to_owned).collect();
        std::iter::once(own).chain(command.get_subcommands().map(broken)).flatten().collect()
    }

    #[test]
    fn examples_fit_a_line() {
        let mut root = Cli::command();
        root.build();
        let long = broken(&root);
        assert!(long.is_empty(), "{long:#?}");
    }
}
