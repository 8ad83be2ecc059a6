//! Next steps with what was inspected, as commands.

use std::path::Path;

use lifelike_motion::MotionClip;
use lifelike_robot::load::NAMES;
use lifelike_robot::{ControllerFile, Robot};

use crate::commands::controller_file::robot_of;
use crate::commands::export::Source;
use crate::next::NextCommand;
use crate::shipped;

/// Returns the steps with a robot: how our own clips suit it, and its first policy.
pub fn of_robot(robot: &str) -> Vec<NextCommand> {
    let name = stem(Path::new(robot));
    let train = NextCommand::new("train tracker").word("--plan").word("track").word("--robot").word(robot);
    vec![
        NextCommand::new("motion check").word("builtin").robot(robot),
        train.word("-o").word(format!("runs/{name}")).word("budget.minutes=5"),
    ]
}

/// Returns the step with captured motion: a robot's motion.
pub fn of_captured(file: &Path) -> Vec<NextCommand> {
    vec![
        NextCommand::new("motion retarget")
            .word(file.display())
            .word("--robot")
            .word("lima")
            .word("-o")
            .word("data/lima"),
    ]
}

/// Returns the steps with a robot's motion. Only a built-in robot is found by the name in the file.
pub fn of_motion(file: &Path, clip: &MotionClip) -> Vec<NextCommand> {
    let table =
        NextCommand::new("motion convert").word(file.display()).word("--to").word("csv").word("-o").word("tables");
    let robot = clip.provenance.character.as_str();
    if !NAMES.contains(&robot) {
        return vec![table];
    }
    let check = NextCommand::new("motion check").word(file.display()).word("--robot").word(robot);
    let has_policy = Robot::load(robot).is_ok_and(|robot| shipped::has_controller(&robot));
    let demo = has_policy.then(|| NextCommand::new("demo").word(file.display()).word("--robot").word(robot));
    [Some(check), demo, Some(table)].into_iter().flatten().collect()
}

/// Returns the step with a policy: an evaluation on our own clips. The robot is the one of the policy's run, else one
/// that is found by the policy's joints. A file that only the user knows is written in capitals.
pub fn of_policy(path: &Path, file: &ControllerFile) -> Vec<NextCommand> {
    let source = Source::of(path).ok();
    let of_run = source.as_ref().and_then(|source| source.robot.clone());
    let robot = of_run.or_else(|| robot_of(file).ok()).unwrap_or_else(|| "MY_ROBOT.xml".into());
    let eval = NextCommand::new("eval").path("--policy", path).robot(&robot);
    let of_run = source.and_then(|source| source.prior).map(|prior| prior.display().to_string());
    let eval = if file.check_complete().is_err() {
        eval.word("--prior").word(of_run.unwrap_or("PRIOR.prior.safetensors".into()))
    } else {
        eval
    };
    vec![eval.word("--motions").word("builtin").word("-o").word("report")]
}

/// Returns the step with the folder of a run.
pub fn of_run(folder: &Path, plan: &toml::Table) -> Vec<NextCommand> {
    let text = |key: &str| plan.get(key).and_then(toml::Value::as_str);
    let policy = folder.join("tracker.controller.safetensors");
    if !policy.is_file() {
        return Vec::new();
    }
    let clips = plan.get("clips").and_then(toml::Value::as_array).into_iter().flatten().filter_map(toml::Value::as_str);
    let eval = NextCommand::new("eval").path("--policy", folder).robot(text("robot").unwrap_or("lima"));
    vec![
        eval.motions(&clips.collect::<Vec<_>>()).path("-o", &folder.join("evaluation")),
        NextCommand::new("train tracker").word("--resume").path("-o", folder),
    ]
}

fn stem(path: &Path) -> String {
    path.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}
