//! A controller as the files that another stack reads.

use lifelike_checkpoint::Checkpoint;
use lifelike_motion::MotionClip;
use lifelike_motion::formats::robot_motion::Traversal;
use lifelike_robot::controller::PolicyWorkspace;
use lifelike_robot::{ActionSpec, Controller, RobotError};
use prost::Message;
use serde_json::json;

use crate::dialect::{Dialect, in_order};
use crate::graph::{self, Builder, Orders};
use crate::metadata::{Gains, metadata};
use crate::proto::{Model, OperatorSet, Property};
use crate::reference::Reference;
use crate::{GOLDEN, LAYOUT, mismatch, yaml};

/// Golden rows in a file.
const ROWS: usize = 8;

/// The motion that an export carries.
#[derive(Debug, Clone, Copy)]
pub enum Motion<'a> {
    /// None: the stack's program brings its own.
    None,
    /// This clip of the controller's robot.
    Clip(&'a MotionClip),
}

/// One file of an export.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ExportedFile {
    /// Its name, with the folders below the export's.
    pub name: String,
    /// Its content.
    pub bytes: Vec<u8>,
}

/// Returns the terms of a controller's observation by a stack's names, in the stack's order, with their sizes.
///
/// # Errors
/// The observation is not one that the stack builds.
pub fn terms(controller: &Controller, dialect: Dialect) -> Result<Vec<(String, usize)>, RobotError> {
    if dialect == Dialect::Onnx {
        return Ok(controller.observation().parts().into_iter().map(|part| (part.name, part.range.len())).collect());
    }
    let layout = dialect.layout(controller.observation())?;
    Ok(layout.iter().map(|term| (term.name.to_string(), term.size())).collect())
}

/// Returns the files of a controller for a stack. Numbers of the observation and joints stand in the stack's order.
///
/// # Errors
/// The controller's observation or action is not one that the stack builds; the motion is missing, or is another robot's.
pub fn export(controller: &Controller, dialect: Dialect, motion: Motion<'_>) -> Result<Vec<ExportedFile>, RobotError> {
    check(controller, dialect)?;
    let robot = controller.robot();
    let joints = joints(controller, dialect);
    let orders = Orders { inputs: inputs(controller, dialect, &joints)?, joints: joints.clone() };
    let is_ours =
        orders.inputs.iter().copied().eq(0..orders.inputs.len()) && joints.iter().copied().eq(0..joints.len());
    let orders = (!is_ours).then_some(orders);
    let file = controller.file().to_checkpoint()?;
    let (size, count) = (controller.observation().size(), joints.len());

    let mut builder = Builder::default();
    let rows = if dialect == Dialect::Onnx { 0 } else { 1 };
    builder.input("obs", &[rows, size]);
    builder.output("actions", &[rows, count]);
    graph::policy(&mut builder, &file, controller.header(), orders.as_ref(), &controller.actions().limits)?;
    builder.named("actions");
    if dialect == Dialect::Onnx {
        targets(&mut builder, controller);
    }
    let bodies = Dialect::bodies(&robot.character);
    let clip = match motion {
        Motion::Clip(clip) => Some(clip),
        Motion::None if dialect.has_motion() || dialect == Dialect::Unitree => {
            let expected = "a clip (--motions): its files carry the motion, one clip each";
            return Err(mismatch(format!("motion for {dialect}"), expected, "none"));
        }
        Motion::None => None,
    };
    if let Some(clip) = clip.filter(|_| dialect.has_motion()) {
        let (wanted, anchor) = bodies_of(controller, dialect, &bodies);
        Reference::new(robot, clip, &wanted, anchor)?.write(&mut builder, dialect, &joints);
    }
    let mut properties = metadata(controller, dialect, &joints, &bodies)?;
    properties.push(property(LAYOUT, layout(controller, dialect, &joints)));
    properties.push(property(GOLDEN, golden(controller, &file, orders.as_ref())?));
    let model = model(builder, dialect, controller, properties);

    let in_folder = |folder: &str, name: &str| if folder.is_empty() { name.into() } else { format!("{folder}/{name}") };
    let (networks, texts) = if dialect == Dialect::Unitree { ("exported", "params") } else { ("", "") };
    let mut files = vec![ExportedFile { name: in_folder(networks, "policy.onnx"), bytes: model.encode_to_vec() }];
    let text = match dialect {
        Dialect::Unitree => Some(("deploy.yaml", yaml::deploy(controller)?)),
        Dialect::Wbc => Some(("config.yaml", yaml::wbc(controller)?)),
        _ => None,
    };
    files.extend(text.map(|(name, text)| ExportedFile { name: in_folder(texts, name), bytes: text.into_bytes() }));
    if let Some(clip) = clip.filter(|_| dialect == Dialect::Unitree) {
        let clip = lifelike_motion::resample::resample(clip, robot.control_hz)?;
        let layout = lifelike_motion::formats::robot_motion::by_name("mjlab")
            .map_err(|got| mismatch("layout of the motion", "mjlab", got))?;
        let bytes = lifelike_motion::formats::robot_motion::write(&clip, layout, Some(&robot.character))?;
        files.push(ExportedFile { name: in_folder(texts, &format!("{}.npz", clip.name)), bytes });
    }
    Ok(files)
}

/// Checks that a stack can build the observation and apply the action.
fn check(controller: &Controller, dialect: Dialect) -> Result<(), RobotError> {
    if dialect == Dialect::Onnx {
        return Ok(());
    }
    dialect.layout(controller.observation())?;
    let of_root = |name: &str| name.starts_with("reference_") && name.ends_with("_b");
    let chain = &controller.observation().anchor_chain;
    if !chain.links.is_empty() && controller.observation().parts().iter().any(|part| of_root(&part.name)) {
        return Err(mismatch(
            format!("anchor body for {dialect}"),
            "the root (inputs.anchor_body = \"\"), since the reference's velocities are the root's",
            chain.body.clone(),
        ));
    }
    match controller.actions().spec {
        ActionSpec::Unclamped { .. } | ActionSpec::DefaultPose { .. } => Ok(()),
        ActionSpec::Absolute | ActionSpec::Reference { .. } => Err(mismatch(
            format!("action of a policy for {dialect}"),
            format!(
                "offsets from the default pose (action.base = \"unclamped\"); `--plan {}` trains one",
                dialect.plan()
            ),
            "another base",
        )),
    }
}

/// The order of the joints in the file: which joint of ours stands at a place.
fn joints(controller: &Controller, dialect: Dialect) -> Vec<usize> {
    let robot = controller.robot();
    if !dialect.is_breadth_first() {
        return (0..robot.joints()).collect();
    }
    let place = |name: String| robot.layout.joints.iter().position(|joint| *joint == name);
    Traversal::BreadthFirst.joints(&robot.character).into_iter().filter_map(place).collect()
}

/// The order of the observation's numbers: the stack's terms, and its joints in those of one number a joint.
fn inputs(controller: &Controller, dialect: Dialect, joints: &[usize]) -> Result<Vec<usize>, RobotError> {
    let observation = controller.observation();
    let parts = match dialect {
        Dialect::Onnx => observation.parts(),
        _ => dialect.layout(observation)?.into_iter().flat_map(|term| term.parts).collect(),
    };
    Ok(parts.iter().flat_map(|part| in_order(part, joints)).collect())
}

/// The bodies whose states are written, and the place of the anchor among them.
fn bodies_of(controller: &Controller, dialect: Dialect, bodies: &[usize]) -> (Vec<usize>, usize) {
    let name = crate::metadata::anchor_name(controller);
    let anchor = controller.robot().character.bodies.iter().position(|body| body.name == name).unwrap_or(1);
    if dialect == Dialect::Holosoma {
        return (vec![anchor], 0);
    }
    (bodies.to_vec(), bodies.iter().position(|body| *body == anchor).unwrap_or(0))
}

/// Adds joint targets (rad) to a plain export.
fn targets(builder: &mut Builder, controller: &Controller) {
    let (spec, joints) = (controller.actions().spec, controller.robot().joints());
    let scale = builder.floats("action.scale", &[], &[spec.scale() as f32]);
    let offset = builder.node("Mul", &["actions", &scale], &[]);
    let base = match spec {
        ActionSpec::Absolute => None,
        ActionSpec::Reference { .. } => {
            builder.input("reference_joint_position", &[0, joints]);
            Some("reference_joint_position".to_string())
        }
        ActionSpec::DefaultPose { .. } | ActionSpec::Unclamped { .. } => {
            Some(builder.floats("action.default_pose", &[1, joints], &controller.actions().default_pose))
        }
    };
    let mut target = match base {
        Some(base) => builder.node("Add", &[&base, &offset], &[]),
        None => offset,
    };
    if !matches!(spec, ActionSpec::Unclamped { .. }) {
        let limits = &controller.actions().limits;
        let low: Vec<f32> = limits.iter().map(|limit| limit.0).collect();
        let high: Vec<f32> = limits.iter().map(|limit| limit.1).collect();
        let (low, high) =
            (builder.floats("target.low", &[1, joints], &low), builder.floats("target.high", &[1, joints], &high));
        target = builder.node("Max", &[&target, &low], &[]);
        builder.node("Min", &[&target, &high], &[]);
    }
    builder.named("joint_targets");
    builder.output("joint_targets", &[0, joints]);
}

fn model(builder: Builder, dialect: Dialect, controller: &Controller, metadata_props: Vec<Property>) -> Model {
    let (version, ir) = dialect.versions();
    // The operator of layer normalization came with version 17.
    let needs = builder.graph.node.iter().any(|node| node.op_type.as_deref() == Some("LayerNormalization"));
    let (version, ir) = if needs { (version.max(17), ir.max(8)) } else { (version, ir) };
    let graph = crate::proto::Graph { name: Some(controller.robot().name.clone()), ..builder.graph };
    Model {
        ir_version: Some(ir),
        producer_name: Some("lifelike".into()),
        producer_version: Some(env!("CARGO_PKG_VERSION").into()),
        graph: Some(graph),
        opset_import: vec![OperatorSet { domain: Some(String::new()), version: Some(version) }],
        metadata_props,
    }
}

fn property(key: &str, value: serde_json::Value) -> Property {
    Property { key: Some(key.into()), value: Some(value.to_string()) }
}

/// Names, sizes and units of everything that goes in and out.
fn layout(controller: &Controller, dialect: Dialect, joints: &[usize]) -> serde_json::Value {
    let (robot, spec, gains) = (controller.robot(), controller.observation(), Gains::of(controller));
    let parts: Vec<(String, usize)> = spec.parts().into_iter().map(|part| (part.name, part.range.len())).collect();
    let names: Vec<&String> = joints.iter().map(|joint| &robot.layout.joints[*joint]).collect();
    let pick = |of: &[f64]| -> Vec<f64> { joints.iter().map(|joint| of[*joint]).collect() };
    json!({
        "dialect": dialect.name(),
        "robot": robot.name,
        "control_hz": robot.control_hz,
        "observation": parts,
        "joints": names,
        "default_pose": pick(&robot.default_pose),
        "kp": pick(&gains.kp),
        "kd": pick(&gains.kd),
        "action": controller.actions().spec,
        "units": "SI, radians, quaternions wxyz",
    })
}

/// Observations with the actions that the controller gives.
fn golden(
    controller: &Controller,
    file: &Checkpoint,
    orders: Option<&Orders>,
) -> Result<serde_json::Value, RobotError> {
    let (size, joints) = (controller.observation().size(), controller.robot().joints());
    let all = file.entry("golden.observations")?.shape().first().copied().unwrap_or(0);
    let observations = file.f32s("golden.observations", &[all, size])?;
    let observations = &observations[..ROWS.min(all) * size];
    let mut outputs = vec![0.0; ROWS.min(all) * joints];
    controller.outputs(&mut observations.to_vec(), &mut PolicyWorkspace::live(), &mut outputs);
    if let Some(bounds) = graph::bounds(controller.header(), &controller.actions().limits) {
        for row in outputs.chunks_exact_mut(joints) {
            row.iter_mut().zip(&bounds).for_each(|(y, (low, high))| *y = y.max(*low).min(*high));
        }
    }
    let ordered = |row: &[f32], order: Option<&[usize]>| -> Vec<f32> {
        order.map_or_else(|| row.to_vec(), |order| order.iter().map(|i| row[*i]).collect())
    };
    let rows = |of: &[f32], width: usize, order: Option<&[usize]>| -> Vec<Vec<f32>> {
        of.chunks_exact(width).map(|row| ordered(row, order)).collect()
    };
    Ok(json!({
        "obs": rows(observations, size, orders.map(|orders| &orders.inputs[..])),
        "actions": rows(&outputs, joints, orders.map(|orders| &orders.joints[..])),
    }))
}
