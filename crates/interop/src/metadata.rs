//! Named texts in a file, as each stack writes them.

use lifelike_robot::{Controller, RobotError};
use serde_json::json;

use crate::dialect::{Dialect, Placed};
use crate::proto::Property;

/// Gains of every joint.
pub(crate) struct Gains {
    /// Stiffness (N m/rad).
    pub(crate) kp: Vec<f64>,
    /// Damping (N m s/rad).
    pub(crate) kd: Vec<f64>,
}

impl Gains {
    pub(crate) fn of(controller: &Controller) -> Self {
        let parameters = &controller.robot().actuators.parameters;
        Self { kp: parameters.iter().map(|p| p.kp).collect(), kd: parameters.iter().map(|p| p.kd).collect() }
    }

    fn in_order(&self, joints: &[usize]) -> Self {
        let pick = |of: &[f64]| joints.iter().map(|joint| of[*joint]).collect();
        Self { kp: pick(&self.kp), kd: pick(&self.kd) }
    }
}

/// Returns the name of the anchor body.
pub(crate) fn anchor_name(controller: &Controller) -> String {
    let robot = controller.robot();
    match controller.observation().anchor_chain.body.as_str() {
        "" => robot.character.bodies.iter().find(|body| body.parent == 0 && body.name != "world"),
        name => robot.character.bodies.iter().find(|body| body.name == name),
    }
    .map(|body| body.name.clone())
    .unwrap_or_default()
}

/// Three decimals and commas, as mjlab's and BeyondMimic's readers want them.
fn csv(values: impl IntoIterator<Item = f64>) -> String {
    let texts: Vec<String> = values.into_iter().map(|x| format!("{x:.3}")).collect();
    texts.join(",")
}

/// Returns a controller's metadata for a stack. `joints` is the order of the joints in the file.
///
/// # Errors
/// As [`Dialect::layout`].
pub(crate) fn metadata(
    controller: &Controller,
    dialect: Dialect,
    joints: &[usize],
    bodies: &[usize],
) -> Result<Vec<Property>, RobotError> {
    let robot = controller.robot();
    let names: Vec<&str> = joints.iter().map(|joint| robot.layout.joints[*joint].as_str()).collect();
    let gains = Gains::of(controller).in_order(joints);
    let pose: Vec<f64> = joints.iter().map(|joint| robot.default_pose[*joint]).collect();
    let scale = vec![controller.actions().spec.scale(); names.len()];
    let run = format!("lifelike/{}", controller.header().provenance.policy.get(..12).unwrap_or("unknown"));
    let texts: Vec<(&str, String)> = match dialect {
        Dialect::Onnx => Vec::new(),
        Dialect::Holosoma => vec![
            ("dof_names", json!(names).to_string()),
            ("kp", json!(gains.kp).to_string()),
            ("kd", json!(gains.kd).to_string()),
            ("action_scale", json!(scale).to_string()),
            ("command_ranges", "null".into()),
            // Its reader parses every text as JSON.
            ("anchor_body_name", json!(anchor_name(controller)).to_string()),
            ("robot_urdf", json!(crate::urdf::urdf(&robot.character)).to_string()),
            ("robot_urdf_path", json!(format!("{}.urdf", robot.name)).to_string()),
            ("wandb_run_path", json!(run).to_string()),
            ("iteration", json!(controller.header().provenance.steps).to_string()),
        ],
        Dialect::BeyondMimic | Dialect::Mjlab | Dialect::Unitree | Dialect::Wbc => {
            let layout = dialect.layout(controller.observation())?;
            let terms: Vec<&str> = layout.iter().map(|term| term.name).collect();
            let bodies: Vec<&str> = bodies.iter().map(|body| robot.character.bodies[*body].name.as_str()).collect();
            let each = |value: &str| vec![value; terms.len()].join(",");
            let mut texts = vec![
                ("run_path", run),
                ("joint_names", names.join(",")),
                ("joint_stiffness", csv(gains.kp)),
                ("joint_damping", csv(gains.kd)),
                ("default_joint_pos", csv(pose)),
                ("command_names", "motion".into()),
                ("observation_names", terms.join(",")),
                ("action_scale", csv(scale)),
                ("anchor_body_name", anchor_name(controller)),
                ("body_names", bodies.join(",")),
            ];
            match dialect {
                Dialect::BeyondMimic => texts.push(("observation_history_lengths", each("1"))),
                Dialect::Mjlab => texts.extend([
                    ("observation_terms_scale", each("1.000")),
                    ("observation_terms_flatten_history_dim", each("1.000")),
                    ("observation_terms_history_length", each("0.000")),
                    ("observation_terms_clip", each("-inf;inf")),
                ]),
                Dialect::Wbc => {
                    let reference =
                        layout.iter().filter(|term| term.name.starts_with("ref_") || term.name == "command");
                    texts.extend([
                        ("policy_only_export", "true".into()),
                        ("action_mode", "default_relative".into()),
                        ("wbc_command_dim", reference.map(Placed::size).sum::<usize>().to_string()),
                    ]);
                }
                _ => {}
            }
            texts
        }
    };
    Ok(texts.into_iter().map(|(key, value)| Property { key: Some(key.into()), value: Some(value) }).collect())
}
