//! The motion of a scene for a machine, and the parts of the scene that a machine cannot do.

use std::path::Path;
use std::sync::Arc;

use lifelike_motion::MotionClip;
use lifelike_robot::{Controller, Robot};
use lifelike_studio::{Built, Camera, Scene, Switch, name_of};

use crate::commands::generate::verdict::reasons;
use crate::commands::stage;
use crate::error::CliError;

/// Most reasons, and most names in a line.
const MOST: usize = 4;

/// The motion of a scene.
pub(super) struct SceneMotion {
    /// All blocks as one clip.
    pub(super) clip: MotionClip,
    /// Parts of the scene that are left out, a line for each kind.
    pub(super) left_out: Vec<String>,
}

impl SceneMotion {
    /// Composes the motion of a scene as `lifelike play` does, for the robot of a controller.
    ///
    /// # Errors
    /// With file and line: the scene cannot be read; it is another robot's; a block cannot be made; no robot can follow it.
    pub(super) fn of(given: &Path, controller: &Controller, policy: &Path) -> Result<Self, CliError> {
        let file = stage::file(given)?;
        let scene = Scene::load(&file)?;
        check_robot(&scene, &file, controller.robot())?;
        let stage = stage::with(Arc::new(controller.clone()), &file)?;
        let built = stage.workshop().build(&scene).map_err(|error| Scene::located(&file, error))?;
        check_motion(&built, &scene, &file, controller.robot())?;
        let mut left_out = left_out(&scene, policy);
        let doubts = built.spans.iter().filter(|span| !span.doubt.is_empty());
        left_out.extend(doubts.map(|span| format!("block '{}': {}", span.id, span.doubt)));
        Ok(Self { clip: MotionClip { name: name_of(&file), ..built.clip }, left_out })
    }
}

/// Compares the robot of a scene with that of the controller.
fn check_robot(scene: &Scene, file: &Path, robot: &Robot) -> Result<(), CliError> {
    let loaded = Robot::load(&scene.robot).and_then(|other| other.in_joint_order(&robot.layout.joints));
    let got = match loaded {
        Ok(other) if other.name == robot.name && other.layout.joints == robot.layout.joints => return Ok(()),
        Ok(other) => format!("'{}' with {} joints", other.name, other.joints()),
        Err(error) => error.to_string(),
    };
    let message = format!(
        "robot: expected that of the controller, '{}' with {} joints, got {got}; name a controller of the scene's robot",
        robot.name,
        robot.joints()
    );
    Err(Scene::refused(file, None, message).into())
}

/// Judges the whole motion without physics, as `lifelike generate` does.
fn check_motion(built: &Built, scene: &Scene, file: &Path, robot: &Robot) -> Result<(), CliError> {
    let reasons = reasons(&built.clip, robot)?;
    let blocks = || built.spans.iter().filter(|span| scene.motion.iter().any(|block| block.id == span.id));
    let lines: Vec<String> = reasons
        .iter()
        .take(MOST)
        .map(|reason| {
            let block = blocks().rfind(|span| span.from <= reason.from).map(|span| span.id.as_str());
            let message = format!("block '{}': not feasible: {} of the scene", block.unwrap_or_default(), reason.words);
            Scene::refused(file, block, message).to_string()
        })
        .collect();
    if lines.is_empty() {
        return Ok(());
    }
    let more = reasons.len().saturating_sub(MOST);
    let more = if more > 0 { format!("\n  and {more} more") } else { String::new() };
    let lines = lines.join("\n  ");
    Err(CliError::Input(format!("{lines}{more}\n  repair it by `feasible = true` in the block, or change the block")))
}

/// Returns a line for each kind of thing that a machine cannot do.
fn left_out(scene: &Scene, policy: &Path) -> Vec<String> {
    let names = |ids: Vec<&str>| {
        let more = ids.len().saturating_sub(MOST);
        let more = if more > 0 { format!(" and {more} more") } else { String::new() };
        format!("{}{more}", ids[..ids.len().min(MOST)].join(", "))
    };
    let pushes: Vec<&str> = scene.push.iter().map(|push| push.id.as_str()).collect();
    let switches = |acts: fn(&Switch) -> bool| -> Vec<&str> {
        scene.switch.iter().filter(|switch| acts(switch)).map(|switch| switch.id.as_str()).collect()
    };
    let kinds = [
        ("pushes", pushes),
        ("friction", switches(|switch| switch.friction.is_some())),
        ("loads", switches(|switch| switch.load.is_some())),
        ("strength of motors", switches(|switch| switch.strength.is_some())),
    ];
    let there = kinds.into_iter().filter(|(_, ids)| !ids.is_empty());
    let mut lines: Vec<String> =
        there.map(|(kind, ids)| format!("left out, a machine cannot do it: {kind} ({})", names(ids))).collect();
    if scene.camera != Camera::default() {
        lines.push("left out, a machine cannot do it: camera".into());
    }
    let other = scene.policy.as_ref().filter(|own| Path::new(own) != policy);
    lines.extend(other.map(|own| format!("left out: policy '{own}' of the scene; '{}' runs", policy.display())));
    lines
}
