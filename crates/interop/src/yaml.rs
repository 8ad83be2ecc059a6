//! Texts beside a policy: `deploy.yaml` of Unitree's deployment, `config.yaml` of wbc-mjlab.

use std::fmt::Write as _;

use lifelike_robot::{Controller, RobotError};

use crate::dialect::{Dialect, Placed};
use crate::metadata::{Gains, anchor_name};

fn list(values: impl IntoIterator<Item = f64>) -> String {
    let texts: Vec<String> = values.into_iter().map(|x| format!("{x:?}")).collect();
    format!("[{}]", texts.join(", "))
}

fn names<'a>(values: impl IntoIterator<Item = &'a str>) -> String {
    // JSON's strings are YAML's.
    let texts: Vec<String> = values.into_iter().map(|x| serde_json::Value::from(x).to_string()).collect();
    format!("[{}]", texts.join(", "))
}

/// Returns `deploy.yaml` as unitree_rl_lab's and unitree_rl_mjlab's deployment reads it.
///
/// # Errors
/// As [`Dialect::layout`].
pub(crate) fn deploy(controller: &Controller) -> Result<String, RobotError> {
    let (robot, gains) = (controller.robot(), Gains::of(controller));
    let joints = robot.joints();
    let mut text = String::new();
    let _ = writeln!(text, "joint_ids_map: {}", list_of_whole(0..joints));
    let _ = writeln!(text, "step_dt: {:?}", 1.0 / robot.control_hz);
    let _ = writeln!(text, "stiffness: {}", list(gains.kp.iter().copied()));
    let _ = writeln!(text, "damping: {}", list(gains.kd.iter().copied()));
    let _ = writeln!(text, "default_joint_pos: {}", list(robot.default_pose.iter().copied()));
    text.push_str("commands: {}\nactions:\n  JointPositionAction:\n    clip: null\n    joint_names: ['.*']\n");
    let _ = writeln!(text, "    scale: {}", list(vec![controller.actions().spec.scale(); joints]));
    let _ = writeln!(text, "    offset: {}", list(robot.default_pose.iter().copied()));
    text.push_str("    joint_ids: null\nobservations:\n");
    for term in Dialect::Unitree.layout(controller.observation())? {
        let (name, size) = (term.name, term.size());
        let params =
            if matches!(name, "motion_command" | "motion_anchor_ori_b") { "{command_name: motion}" } else { "{}" };
        let _ = writeln!(
            text,
            "  {name}:\n    params: {params}\n    clip: null\n    scale: {}\n    history_length: 1",
            list(vec![1.0; size])
        );
    }
    Ok(text)
}

fn list_of_whole(values: impl Iterator<Item = usize>) -> String {
    let texts: Vec<String> = values.map(|x| x.to_string()).collect();
    format!("[{}]", texts.join(", "))
}

/// Returns `config.yaml` as wbc-mjlab writes it (`wbc_tracking_params_v1`).
///
/// # Errors
/// As [`Dialect::layout`].
pub(crate) fn wbc(controller: &Controller) -> Result<String, RobotError> {
    let (robot, gains) = (controller.robot(), Gains::of(controller));
    let layout = Dialect::Wbc.layout(controller.observation())?;
    let is_reference = |name: &str| name.starts_with("ref_") || name == "command";
    let joints = robot.layout.joints.iter().map(String::as_str);
    let mut text = String::from("schema_version: wbc_tracking_params_v1\n");
    let _ = writeln!(text, "robot_id: {}", serde_json::Value::from(robot.name.as_str()));
    let _ = writeln!(text, "policy_step_dt: {:?}", 1.0 / robot.control_hz);
    let _ = writeln!(text, "joint_names: {}", names(joints));
    let _ = writeln!(text, "default_joint_pos: {}", list(robot.default_pose.iter().copied()));
    let _ = writeln!(text, "stiffness: {}", list(gains.kp.iter().copied()));
    let _ = writeln!(text, "damping: {}", list(gains.kd.iter().copied()));
    text.push_str("action:\n  action_mode: default_relative\n");
    let _ = writeln!(text, "  scale: {}", list(vec![controller.actions().spec.scale(); robot.joints()]));
    text.push_str("  command_name: motion\nactor_observations:\n");
    for term in &layout {
        let (name, size) = (term.name, term.size());
        let commanded = is_reference(name) || name.starts_with("motion_anchor");
        let params = if commanded { "{command_name: motion}" } else { "{}" };
        let scale = list(vec![1.0; size]);
        let _ = writeln!(text, "  {name}:\n    dim: {size}\n    scale: {scale}\n    params: {params}");
    }
    let terms: Vec<&str> = layout.iter().map(|term| term.name).collect();
    let reference: Vec<&str> = terms.iter().copied().filter(|name| is_reference(name)).collect();
    let command: usize = layout.iter().filter(|term| is_reference(term.name)).map(Placed::size).sum();
    let _ = writeln!(text, "tracking:\n  anchor_body_name: {}", anchor_name(controller));
    text.push_str("  has_state_estimation: false\n");
    let _ = writeln!(text, "  wbc_command_dim: {command}");
    let _ = writeln!(text, "  reference_observation_names: {}", names(reference));
    let _ = writeln!(text, "  actor_observation_names: {}", names(terms));
    text.push_str("  actor_history_length: 1\n");
    Ok(text)
}
