//! Every command block of the README and of the guides, run as an installed user runs it: from an empty folder.
//!
//! A block is fenced as `sh`. One that needs data, the network or hours says so (`sh not-run: needs captures of yours`). The blocks of a
//! page are run one after the other in one folder, as a reader would. Budgets of trainings are cut short; nothing else is changed.

#![allow(clippy::unwrap_used, clippy::expect_used)]

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::{PoisonError, RwLock};

/// In place of every budget of a training.
const SHORT: &str = "budget.steps=20000";

/// Held alone by the page whose robot runs in real time: trainings beside it take its time away.
static REAL_TIME: RwLock<()> = RwLock::new(());

/// A fenced block that is a command line.
struct Block {
    line: usize,
    /// Reason for which it is not run.
    not_run: Option<String>,
    text: String,
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// Returns the command blocks of a page.
fn blocks(page: &str) -> Vec<Block> {
    let mut blocks = Vec::new();
    let mut lines = page.lines().enumerate();
    while let Some((number, line)) = lines.next() {
        let Some(info) = line.strip_prefix("```") else { continue };
        let body: Vec<&str> =
            lines.by_ref().map(|(_, line)| line).take_while(|line| !line.starts_with("```")).collect();
        let is_command = |line: &&str| ["lifelike ", "cargo ", "mpirun "].iter().any(|word| line.starts_with(word));
        match info.strip_prefix("sh") {
            Some(rest) => {
                let not_run = rest.trim().strip_prefix("not-run:").map(|reason| reason.trim().to_owned());
                blocks.push(Block { line: number + 1, not_run, text: body.join("\n") });
            }
            None => assert!(!body.iter().any(is_command), "line {}: commands in a block that is not `sh`", number + 1),
        }
    }
    blocks
}

/// Returns the text with every training's budget cut short.
fn shortened(text: &str) -> String {
    let word = |word: &str| if word.starts_with("budget.") { SHORT.to_owned() } else { word.to_owned() };
    text.split(' ')
        .map(|piece| piece.split('\n').map(word).collect::<Vec<_>>().join("\n"))
        .collect::<Vec<_>>()
        .join(" ")
}

/// Runs a page's blocks beside those of other pages.
fn follow(page: &str) {
    let _other = REAL_TIME.read().unwrap_or_else(PoisonError::into_inner);
    run_blocks(page);
}

/// Runs a page's blocks while no other page is run.
fn follow_alone(page: &str) {
    let _alone = REAL_TIME.write().unwrap_or_else(PoisonError::into_inner);
    run_blocks(page);
}

/// Runs a page's blocks from an empty folder with a robot and a capture of the reader's own in it.
fn run_blocks(page: &str) {
    let text = std::fs::read_to_string(root().join(page)).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let put = |from: &str, to: &str| std::fs::copy(root().join(from), folder.path().join(to)).unwrap();
    put("robots/lima.xml", "MY_ROBOT.xml");
    put("crates/motion/src/formats/tests/small.bvh", "walk.bvh");
    let program = Path::new(env!("CARGO_BIN_EXE_lifelike")).parent().unwrap().to_path_buf();
    let own = std::env::var_os("PATH").unwrap();
    let paths = std::env::join_paths(std::iter::once(program).chain(std::env::split_paths(&own))).unwrap();
    let mut run = 0;
    for block in blocks(&text) {
        if let Some(reason) = &block.not_run {
            assert!(!reason.is_empty(), "{page}:{}: expected a reason after not-run:", block.line);
            continue;
        }
        let script = shortened(&block.text);
        let mut shell = Command::new("sh");
        shell.args(["-e", "-c", &script]).current_dir(folder.path()).env("PATH", &paths);
        // What is written for a user does not go into the tester's own folders.
        shell.env("XDG_CACHE_HOME", folder.path().join("cache")).env("XDG_DATA_HOME", folder.path().join("own"));
        let output = shell.output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.success(), "{page}:{}: {script}\n{said}", block.line);
        run += 1;
    }
    assert!(run > 0, "{page}: no block was run");
}

#[test]
fn the_readme() {
    follow("README.md");
}

#[test]
fn training_a_new_robot() {
    follow("docs/training-a-new-robot.md");
}

#[test]
fn recipes() {
    follow("docs/recipes.md");
}

#[test]
fn directing_motion() {
    follow("docs/direction.md");
}

#[test]
fn the_studio() {
    follow("docs/studio.md");
}

#[test]
fn policies_of_other_stacks() {
    follow("docs/interop.md");
}

#[test]
fn looking_at_motion() {
    follow("docs/looking.md");
}

#[test]
fn on_the_robot() {
    follow_alone("docs/runtime.md");
}

#[test]
fn every_page_marks_its_commands() {
    for page in ["README.md", "docs/augmentation.md", "docs/text-to-motion.md", "docs/evaluation.md"] {
        blocks(&std::fs::read_to_string(root().join(page)).unwrap());
    }
}

#[test]
fn blocks_are_found_and_budgets_cut() {
    let page =
        "```sh\nlifelike demo\n```\n```toml\na = 1\n```\n```sh not-run: an hour\nlifelike x budget.minutes=5\n```\n";
    let found = blocks(page);
    assert_eq!((found.len(), found[0].line, found[0].text.as_str()), (2, 1, "lifelike demo"));
    assert_eq!(found[1].not_run.as_deref(), Some("an hour"));
    assert_eq!(shortened("a budget.minutes=5\nb budget.steps=7 c"), format!("a {SHORT}\nb {SHORT} c"));
    assert!(std::panic::catch_unwind(|| blocks("```\nlifelike demo\n```\n")).is_err());
}
