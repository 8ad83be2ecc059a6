//! `cargo xtask docs`: the documentation as a site that needs no network.

use std::fs;
use std::path::Path;
use std::process::Command;

use lifelike_fetch::at;

use crate::root;

/// Source folder of the book, as `book.toml` names it.
const SOURCE: &str = "target/book/source";

/// Collects the pages, writes the command reference by the program (built where none is named), and builds the site into
/// `target/book/html`.
///
/// # Errors
/// When the program or mdBook fails, mdBook is missing, or a file cannot be written.
pub fn build(program: Option<&String>) -> Result<(), String> {
    let source = root().join(SOURCE);
    let _ = fs::remove_dir_all(&source);
    copy(&root().join("docs"), &source)?;
    let mut reference = program.map_or_else(built, Command::new);
    succeed(reference.args(["man", "--markdown", "-o"]).arg(&source).current_dir(root()))?;
    let missing = |_| "mdBook is missing: cargo install mdbook --locked".to_string();
    Command::new("mdbook").arg("--version").output().map_err(missing)?;
    succeed(Command::new("mdbook").arg("build").arg(root()))?;
    println!("{}", root().join("target/book/html/index.html").display());
    Ok(())
}

/// Returns the program of this checkout.
fn built() -> Command {
    let mut cargo = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    cargo.args(["run", "--release", "--package", "lifelike", "--bin", "lifelike", "--"]);
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
