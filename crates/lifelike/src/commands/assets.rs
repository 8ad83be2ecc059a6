//! What ships with the program: networks of `assets/`.

use std::path::{Path, PathBuf};

use lifelike_robot::Robot;

use crate::error::CliError;
use crate::next::NextCommand;

/// Returns a robot's file of this kind (`controller`, `generator`, ...) in `assets/`, if there is one: beside the program,
/// above it (as in target/release), where we stand, or where it was built.
pub fn asset(robot: &Robot, kind: &str) -> Option<PathBuf> {
    let name = format!("{}.{kind}.safetensors", robot.name);
    let program = std::env::current_exe().ok();
    let above = program.iter().flat_map(|p| p.ancestors().skip(1));
    let built = Path::new(env!("CARGO_MANIFEST_DIR")).ancestors();
    above
        .chain([Path::new(".")])
        .chain(built)
        .map(|folder| folder.join("assets").join(&name))
        .find(|file| file.is_file())
}

/// Returns the controller of a robot: this file, or what ships.
///
/// # Errors
/// [`CliError::Input`] where nothing ships, with the commands that make one and use it; `again` is the beginning of the
/// second.
pub fn controller(
    given: Option<&Path>,
    robot: &Robot,
    file: &str,
    again: impl FnOnce() -> NextCommand,
) -> Result<PathBuf, CliError> {
    let shipped = || asset(robot, "controller").or_else(|| asset(robot, "policy"));
    given.map(Path::to_path_buf).or_else(shipped).ok_or_else(|| {
        let train = NextCommand::new("train tracker").word("--plan").word("track").word(format!("robot={file}"));
        CliError::Input(format!(
            "no pretrained controller for '{}' (assets/{}.controller.safetensors). Train one and name it:\n\
             \x20 {}\n\
             \x20 {}",
            robot.name,
            robot.name,
            train.word("-o").word("runs/mine").word("budget.minutes=5"),
            again().robot(file).word("--policy").word("runs/mine/tracker.policy.safetensors")
        ))
    })
}
