//! `cargo xtask docs`: the documentation as a site that needs no network.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use lifelike_fetch::at;

use crate::{root, third_party};

/// Source folder of the book, as `book.toml` names it.
const SOURCE: &str = "target/book/source";

/// Version of mdBook that is installed where none is found.
const MDBOOK: &str = "0.5.4";

/// Pages of the repository's top that the site has as well: file, page, title.
const TOP: [(&str, &str, &str); 3] = [
    ("ARCHITECTURE.md", "architecture.md", "Architecture"),
    ("CONTRIBUTING.md", "contributing.md", "Contributing"),
    ("CHANGELOG.md", "changelog.md", "Changelog"),
];

/// Collects the pages, writes the command reference by the program (built where none is named), and builds the site into
/// `target/book/html`.
///
/// # Errors
/// When the program or mdBook fails or cannot be installed, or a file cannot be written.
pub fn build(program: Option<&String>) -> Result<(), String> {
    let source = root().join(SOURCE);
    let _ = fs::remove_dir_all(&source);
    collect(&root(), &source)?;
    let mut reference = program.map_or_else(built, Command::new);
    succeed(reference.args(["man", "--markdown", "-o"]).arg(&source).current_dir(root()))?;
    succeed(Command::new(mdbook()?).arg("build").arg(root()))?;
    println!("{}", root().join("target/book/html/index.html").display());
    Ok(())
}

/// Collects the pages of a checkout; the command reference comes from the program.
///
/// # Errors
/// A file cannot be read or written.
pub fn collect(checkout: &Path, source: &Path) -> Result<(), String> {
    copy(&checkout.join("docs"), source)?;
    let summary = source.join("SUMMARY.md");
    let mut chapters = fs::read_to_string(&summary).map_err(at(&summary))?;
    chapters.push_str("\n# Project\n\n");
    for (file, page, title) in TOP {
        let (from, to) = (checkout.join(file), source.join(page));
        let text = fs::read_to_string(&from).map_err(at(&from))?;
        fs::write(&to, text.replace("](docs/", "](")).map_err(at(&to))?;
        chapters.push_str(&format!("- [{title}]({page})\n"));
    }
    fs::write(&summary, chapters).map_err(at(&summary))
}

/// Returns mdBook: the one on the path, or ours, which is installed into `third_party` where it is missing.
fn mdbook() -> Result<PathBuf, String> {
    if Command::new("mdbook").arg("--version").output().is_ok_and(|output| output.status.success()) {
        return Ok("mdbook".into());
    }
    let folder = third_party().join("mdbook");
    let program = folder.join("bin/mdbook");
    if !program.is_file() {
        let install = ["install", "mdbook", "--version", MDBOOK, "--locked", "--no-default-features", "--features"];
        succeed(cargo(&install).args(["search", "--debug", "--root"]).arg(&folder))?;
    }
    Ok(program)
}

/// Returns the program of this checkout.
fn built() -> Command {
    cargo(&["run", "--release", "--package", "lifelike", "--bin", "lifelike", "--"])
}

fn cargo(arguments: &[&str]) -> Command {
    let mut cargo = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    cargo.args(arguments).current_dir(root());
    cargo
}

/// Copies a folder of pages and pictures.
fn copy(from: &Path, to: &Path) -> Result<(), String> {
    fs::create_dir_all(to).map_err(at(to))?;
    for entry in fs::read_dir(from).map_err(at(from))? {
        let path = entry.map_err(at(from))?.path();
        let target = to.join(path.file_name().unwrap_or_default());
        if path.is_dir() {
            copy(&path, &target)?;
        } else {
            fs::copy(&path, &target).map_err(at(&target))?;
        }
    }
    Ok(())
}

fn succeed(command: &mut Command) -> Result<(), String> {
    let status = command.status().map_err(|e| format!("{command:?}: {e}"))?;
    if status.success() { Ok(()) } else { Err(format!("{command:?} failed ({status})")) }
}
