//! A stack's policy as a controller of ours.

use std::collections::BTreeMap;

use lifelike_character::{Kinematics, Quat, Vec3};
use lifelike_checkpoint::Checkpoint;
use lifelike_motion::{MotionClip, Provenance};
use lifelike_robot::controller::{self, ControllerHeader};
use lifelike_robot::network::Layer;
use lifelike_robot::{ActionSpec, AnchorSpec, ControllerFile, ObservationSpec, ReferenceSpec, Robot, RobotError};
use nalgebra::{Quaternion, UnitQuaternion};

use crate::dialect::{Dialect, in_order};
use crate::lint::{self, Contradiction, Statistics};
use crate::mismatch;
use crate::reading::{Reading, Weighted, read};

/// A foreign policy, ready to be a controller.
#[derive(Debug, Clone)]
pub struct Imported {
    /// The stack whose contract the file follows.
    pub dialect: Dialect,
    /// The terms of its observation by the stack's names, in order.
    pub terms: Vec<String>,
    /// The controller.
    pub controller: ControllerFile,
    /// The motion that it carries.
    pub clip: Option<MotionClip>,
    /// Everything that was concluded: a line each.
    pub notes: Vec<String>,
    /// Contradictions between the layout and the policy's own normalizer.
    pub contradictions: Vec<Contradiction>,
}

/// Least deviation of a number of the observation: below it the frozen normalizer only centres.
const LEAST_DEVIATION: f32 = 1e-4;

/// Greatest relative difference of a gain from the robot's.
const GAIN: f64 = 0.01;

/// Makes a controller for a robot of another stack's policy. `path` is for messages and names.
///
/// Scales and default pose of the policy are taken into its first and last layer. The controller's outputs are
/// therefore offsets from the robot's own default pose in rad. `terms` takes the place of the order that the file's
/// metadata say.
///
/// # Errors
/// It is no policy of a known stack; its joints, gains or sizes are not the robot's.
pub fn import(bytes: &[u8], path: &str, robot: &Robot, terms: Option<&[String]>) -> Result<Imported, RobotError> {
    let reading = read(bytes, path)?;
    let mut contract = Contract::of(&reading, path, robot)?;
    if let Some(terms) = terms.filter(|terms| *terms != contract.terms) {
        contract.terms = terms.to_vec();
        contract.notes.push("order of the observation: as told, not as the file's metadata say".into());
        // An order by hand is tried with the likeliest scale alone: another could hide a wrong order.
        contract.scales.truncate(1);
    }
    let Contract { dialect, terms, joints, .. } = &contract;
    let spec = contract.observation(&reading, path, robot)?;

    // Which number of the file stands at each of ours.
    let from: Vec<usize> = spec.parts().iter().flat_map(|part| in_order(part, joints)).collect();
    let size = spec.size();
    let (mean, deviation) = reading.normalizer.clone().unwrap_or_else(|| (vec![0.0; size], vec![1.0; size]));
    let mean: Vec<f32> = from.iter().map(|i| mean[*i]).collect();
    let deviation: Vec<f32> = from.iter().map(|i| deviation[*i]).collect();
    let default_pose: Vec<f32> = joints.iter().map(|joint| contract.default_pose[*joint]).collect();
    let shift: Vec<f32> = default_pose.iter().zip(&spec.default_pose).map(|(theirs, ours)| theirs - ours).collect();
    let mut notes = contract.notes.clone();
    if reading.normalizer.is_none() {
        notes.push("the file has no normalizer: its layout cannot be compared with what the policy has seen".into());
    }
    // The first scale that nothing contradicts; else the first.
    let mut tried: Option<(Scaled, Vec<Contradiction>)> = None;
    for (scale, note) in &contract.scales {
        let scale: Vec<f32> = joints.iter().map(|joint| scale[*joint]).collect();
        let scaled = Scaled::new(&spec, (&mean, &deviation), scale, &shift);
        let statistics = Statistics { mean: &scaled.mean, deviation: &scaled.deviation, action_scale: 1.0 };
        let found = if reading.normalizer.is_some() { lint::check(&spec, statistics) } else { Vec::new() };
        if tried.is_none() || found.is_empty() {
            notes.retain(|old| !contract.scales.iter().any(|(_, other)| other == old));
            notes.extend((!note.is_empty()).then(|| note.clone()));
            let is_right = found.is_empty();
            tried = Some((scaled, found));
            if is_right {
                break;
            }
        }
    }
    let Some((Scaled { mean, deviation, scale }, contradictions)) = tried else {
        return Err(mismatch(format!("{path}: action scale"), "numbers", "none"));
    };
    // A squared deviation has no sign, so a negative one would be another policy.
    let is_good = |i: &usize| mean[*i].is_finite() && deviation[*i] >= LEAST_DEVIATION && deviation[*i].is_finite();
    if let Some(i) = (0..size).find(|i| !is_good(i)) {
        return Err(mismatch(
            format!("{path}: normalizer of input {}", from[i]),
            format!("a finite mean, and a deviation of at least {LEAST_DEVIATION}"),
            format!("{} and {}", mean[i], deviation[i]),
        ));
    }
    let width = reading.layers.iter().rev().find(|layer| !layer.bias.is_empty()).map_or(size, |layer| layer.bias.len());
    if width != joints.len() {
        let expected = format!("{} actions, one for each joint", joints.len());
        return Err(mismatch(format!("{path}: output of the network"), expected, width.to_string()));
    }
    let layers = ordered(reading.layers.clone(), &from, joints, &scale, &shift);
    let controller = controller(&reading, layers, spec, (&mean, &deviation), robot)?;
    let clip = contract.clip(&reading, path, robot)?;
    Ok(Imported { dialect: *dialect, terms: terms.clone(), controller, clip, notes, contradictions })
}

/// Statistics of an observation in rad, for one action scale.
struct Scaled {
    mean: Vec<f32>,
    deviation: Vec<f32>,
    scale: Vec<f32>,
}

impl Scaled {
    /// Takes scales and the difference of the default poses into the statistics of joints and actions.
    fn new(spec: &ObservationSpec, (mean, deviation): (&[f32], &[f32]), scale: Vec<f32>, shift: &[f32]) -> Self {
        let (mut mean, mut deviation) = (mean.to_vec(), deviation.to_vec());
        for part in spec.parts() {
            match part.name.as_str() {
                "joint_position" => part.range.zip(shift).for_each(|(i, shift)| mean[i] += shift),
                "last_action" => {
                    for ((i, shift), scale) in part.range.zip(shift).zip(&scale) {
                        mean[i] = mean[i] * scale + shift;
                        deviation[i] *= scale;
                    }
                }
                _ => {}
            }
        }
        Self { mean, deviation, scale }
    }
}

/// Returns the names of the joints that a policy's file is for; none where it does not say.
///
/// # Errors
/// It is no ONNX file.
pub fn joints_of(bytes: &[u8], path: &str) -> Result<Vec<String>, RobotError> {
    let metadata = crate::reading::metadata(bytes, path)?;
    let names = ["dof_names", "joint_names"].iter().find_map(|key| metadata.get(*key));
    Ok(names.map(|text| list(text)).unwrap_or_default())
}

/// The contract that a file's metadata state.
struct Contract {
    dialect: Dialect,
    terms: Vec<String>,
    /// Place in the file of each joint of the robot.
    joints: Vec<usize>,
    /// In the file's order.
    default_pose: Vec<f32>,
    /// Offset of a target for an output of 1 (rad), as it may be, the likeliest first; with what is to be said of it.
    scales: Vec<(Vec<f32>, String)>,
    anchor: String,
    bodies: Vec<String>,
    notes: Vec<String>,
}

impl Contract {
    fn of(reading: &Reading, path: &str, robot: &Robot) -> Result<Self, RobotError> {
        let text = |key: &str| reading.metadata.get(key).map(String::as_str);
        let dialect = match (text("dof_names"), text("observation_names"), text("policy_only_export")) {
            (Some(_), ..) => Dialect::Holosoma,
            (None, Some(_), Some(_)) => Dialect::Wbc,
            (None, Some(_), None) => Dialect::Mjlab,
            (None, None, _) => {
                let expected =
                    "metadata of a stack: 'observation_names' (mjlab, BeyondMimic, wbc), or 'dof_names' (holosoma)";
                let names: Vec<&str> = reading.metadata.keys().map(String::as_str).collect();
                return Err(mismatch(path, expected, if names.is_empty() { "none".into() } else { names.join(", ") }));
            }
        };
        let mut notes = Vec::new();
        let names = if dialect == Dialect::Holosoma { "dof_names" } else { "joint_names" };
        let joints = list(text(names).unwrap_or_default());
        let places = places(&joints, robot, &format!("{path}: {names}"))?;
        let numbers =
            |key: &str| text(key).map(|text| numbers(text, joints.len(), &format!("{path}: {key}"))).transpose();
        let parameters = &robot.actuators.parameters;
        let in_file = |of: &dyn Fn(usize) -> f64| -> Vec<f32> {
            let mut values = vec![0.0; joints.len()];
            places.iter().enumerate().for_each(|(joint, place)| values[*place] = of(joint) as f32);
            values
        };
        let default_pose = numbers("default_joint_pos")?.unwrap_or_else(|| {
            notes.push("default pose: the robot's; the file has none".into());
            in_file(&|joint| robot.default_pose[joint])
        });
        contract_of_terms(&reading.metadata, path)?;
        let scales = match numbers("action_scale")? {
            Some(scale) if scale.iter().any(|scale| *scale <= 0.0) => {
                return Err(mismatch(format!("{path}: action_scale"), "numbers above 0", format!("{scale:?}")));
            }
            Some(scale) => vec![(scale, String::new())],
            // Released files have neither of the two that were in use.
            None => vec![
                (
                    in_file(&|joint| 0.25 * parameters[joint].torque_max / parameters[joint].kp),
                    "action scale: 0.25 torque_max / kp, as holosoma has it for the G1; the file has none".into(),
                ),
                (
                    vec![1.0; joints.len()],
                    "action scale: 1 rad; the file has none, and 0.25 torque_max / kp contradicts its normalizer"
                        .into(),
                ),
            ],
        };
        let (kp, kd) = if dialect == Dialect::Holosoma { ("kp", "kd") } else { ("joint_stiffness", "joint_damping") };
        for (key, gain) in [(kp, (|p| p.kp) as fn(&lifelike_robot::ActuatorParameters) -> f64), (kd, |p| p.kd)] {
            let Some(theirs) = numbers(key)? else { continue };
            let differs = |(joint, place): (usize, &usize)| {
                let (expected, got) = (f64::from(theirs[*place]), gain(&parameters[joint]));
                ((expected - got).abs() > GAIN * expected.abs().max(got.abs())).then_some((joint, expected, got))
            };
            if let Some((joint, expected, got)) = places.iter().enumerate().find_map(differs) {
                return Err(mismatch(
                    format!("{path}: {key} of joint '{}'", robot.layout.joints[joint]),
                    format!("{expected}, which the policy was trained with (write it into the robot's profile)"),
                    format!("{got} of robot '{}'", robot.name),
                ));
            }
        }
        let terms = match dialect {
            Dialect::Holosoma if reading.motion.contains_key("ref_quat_xyzw") => {
                dialect.terms().iter().map(|(name, _)| (*name).to_string()).collect()
            }
            Dialect::Holosoma => {
                let expected = "a whole-body tracker, whose file carries a motion ('ref_quat_xyzw')";
                return Err(mismatch(path, expected, "a locomotion policy, which follows velocity commands"));
            }
            _ => list(text("observation_names").unwrap_or_default()),
        };
        let anchor = match text("anchor_body_name") {
            Some(name) => serde_json::from_str(name).unwrap_or_else(|_| name.to_string()),
            None => {
                notes.push("anchor body: 'torso_link', as the stack has it for the G1; the file names none".into());
                "torso_link".into()
            }
        };
        let bodies = list(text("body_names").unwrap_or_default());
        Ok(Self { dialect, terms, joints: places, default_pose, scales, anchor, bodies, notes })
    }

    /// The layout by our names.
    fn observation(&self, reading: &Reading, path: &str, robot: &Robot) -> Result<ObservationSpec, RobotError> {
        let mut terms = Vec::new();
        if let Some(twice) = (0..self.terms.len()).find(|&i| self.terms[..i].contains(&self.terms[i])) {
            let expected = "each term once";
            return Err(mismatch(
                format!("{path}: terms of the observation"),
                expected,
                format!("'{}' twice", self.terms[twice]),
            ));
        }
        for term in &self.terms {
            let known = || {
                let names: Vec<&str> = self.dialect.terms().iter().map(|(name, _)| *name).collect();
                mismatch(format!("{path}: term of the observation"), names.join(", "), format!("'{term}'"))
            };
            terms.extend(self.dialect.parts_of(term).ok_or_else(known)?.iter().map(|part| (*part).to_string()));
        }
        let compares_anchors = terms.iter().any(|term| term.starts_with("anchor_"));
        let anchor_body = if compares_anchors { self.anchor.clone() } else { String::new() };
        let reference = ReferenceSpec { terms, anchor_body, ..ReferenceSpec::default() };
        let spec = ObservationSpec::new(robot, reference, AnchorSpec::default());
        spec.check_sizes()?;
        if spec.size() != reading.inputs {
            return Err(mismatch(
                format!("{path}: numbers of the observation"),
                format!("{} by its terms {} for robot '{}'", spec.size(), self.terms.join(", "), robot.name),
                format!("{} by its network", reading.inputs),
            ));
        }
        Ok(spec)
    }

    /// The motion in the file, where it has one.
    fn clip(&self, reading: &Reading, path: &str, robot: &Robot) -> Result<Option<MotionClip>, RobotError> {
        let Some((shape, joints)) = reading.motion.get("joint_pos") else { return Ok(None) };
        let (frames, count) = (shape.first().copied().unwrap_or(0), self.joints.len());
        if frames < 3 {
            return Ok(None);
        }
        let expected =
            |what: &str| mismatch(format!("{path}: motion"), format!("an array '{what}' of {frames} rows"), "none");
        if joints.len() != frames * count {
            return Err(expected("joint_pos"));
        }
        let rows = |name: &str, width: usize| -> Result<Vec<f32>, RobotError> {
            let values = reading.motion.get(name).map(|(_, values)| values.clone()).unwrap_or_default();
            if values.len() == frames * width { Ok(values) } else { Err(expected(name)) }
        };
        let character = &robot.character;
        let (body, positions, quaternions) = if self.dialect == Dialect::Holosoma {
            let to_wxyz = |q: &[f32; 4]| [q[3], q[0], q[1], q[2]];
            let xyzw = rows("ref_quat_xyzw", 4)?;
            (self.anchor.clone(), rows("ref_pos_xyz", 3)?, xyzw.as_chunks::<4>().0.iter().map(to_wxyz).collect())
        } else {
            let width = self.bodies.len().max(1);
            let every = |values: Vec<f32>, size: usize| -> Vec<f32> {
                values.chunks_exact(width * size).flat_map(|row| row[..size].to_vec()).collect()
            };
            let turns = every(rows("body_quat_w", 4 * width)?, 4);
            let body = self.bodies.first().cloned().unwrap_or_default();
            (body, every(rows("body_pos_w", 3 * width)?, 3), turns.as_chunks::<4>().0.to_vec())
        };
        let Some(body) = character.bodies.iter().position(|other| other.name == body) else {
            return Err(mismatch(format!("{path}: body of the motion"), "a body of the robot", body));
        };
        let mut clip = MotionClip {
            name: lifelike_motion::formats::clip_name(std::path::Path::new(path)),
            fps: robot.control_hz,
            joint_names: robot.layout.joints.clone(),
            root_position: Vec::new(),
            root_orientation: Vec::new(),
            joints: Vec::new(),
            contacts: None,
            cyclic: false,
            provenance: Provenance { character: robot.name.clone(), source: path.into(), ..Provenance::default() },
        };
        let mut kinematics = Kinematics::new(character);
        let columns: Vec<usize> = (0..count).collect();
        for frame in 0..frames {
            let row = &joints[frame * count..(frame + 1) * count];
            clip.joints.extend(self.joints.iter().map(|place| f64::from(row[*place])));
            let [w, x, y, z] = quaternions[frame].map(f64::from);
            let turn = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z));
            let place = Vec3::from_iterator(positions[3 * frame..3 * frame + 3].iter().map(|x| f64::from(*x)));
            // The root is where it has to be for the body to be there.
            clip.root_position.push(Vec3::zeros());
            clip.root_orientation.push(Quat::identity());
            let mut q = robot.default_position();
            clip.write_position(character, &columns, frame, &mut q);
            kinematics.update(character, &q);
            let root = turn * kinematics.body_orientation[body].inverse();
            clip.root_position[frame] = place - root * kinematics.body_position[body];
            let flips = frame > 0 && clip.root_orientation[frame - 1].coords.dot(&root.coords) < 0.0;
            clip.root_orientation[frame] = if flips { Quat::new_unchecked(-root.into_inner()) } else { root };
        }
        clip.check()?;
        Ok(Some(clip))
    }
}

/// Checks that the terms are plain numbers of the present: neither scaled, clipped nor stacked.
fn contract_of_terms(metadata: &BTreeMap<String, String>, path: &str) -> Result<(), RobotError> {
    let plain: [(&str, &[&str], &str); 5] = [
        ("observation_terms_scale", &["1", "1.0", "1.000"], "1 for every term"),
        ("observation_terms_clip", &["-inf;inf", "None"], "-inf;inf for every term"),
        ("observation_terms_history_length", &["0", "1", "0.000", "1.000"], "0 or 1 for every term"),
        ("observation_history_lengths", &["0", "1", "0.000", "1.000"], "1 for every term"),
        ("action_mode", &["default_relative"], "default_relative"),
    ];
    for (key, allowed, expected) in plain {
        let text = metadata.get(key).map_or("", String::as_str);
        if let Some(other) = list(text).into_iter().find(|value| !allowed.contains(&value.as_str())) {
            return Err(mismatch(format!("{path}: {key}"), expected, other));
        }
    }
    Ok(())
}

/// Comma-separated names, or a JSON list.
fn list(text: &str) -> Vec<String> {
    serde_json::from_str(text).unwrap_or_else(|_| {
        text.split(',').map(|name| name.trim().to_string()).filter(|name| !name.is_empty()).collect()
    })
}

/// Comma-separated numbers or a JSON list of them; a single one is for every joint.
fn numbers(text: &str, count: usize, what: &str) -> Result<Vec<f32>, RobotError> {
    let parsed: Result<Vec<f32>, _> = match serde_json::from_str::<Vec<f32>>(text) {
        Ok(values) => Ok(values),
        Err(_) => text.split(',').map(|number| number.trim().parse::<f32>()).collect(),
    };
    match parsed {
        Ok(values) if values.iter().any(|x| !x.is_finite()) => Err(mismatch(what, "finite numbers", text)),
        Ok(values) if values.len() == count => Ok(values),
        Ok(values) if values.len() == 1 => Ok(vec![values[0]; count]),
        Ok(values) => Err(mismatch(what, format!("{count} numbers, one for each joint"), values.len().to_string())),
        Err(error) => Err(mismatch(what, "numbers separated by commas, or a JSON list", error.to_string())),
    }
}

/// Places of the robot's joints among a file's.
fn places(names: &[String], robot: &Robot, what: &str) -> Result<Vec<usize>, RobotError> {
    let own = &robot.layout.joints;
    if let Some(twice) = (0..names.len()).find(|&i| names[..i].contains(&names[i])) {
        return Err(mismatch(what, "each joint once", format!("'{}' twice", names[twice])));
    }
    if let Some(unknown) = names.iter().find(|name| !own.contains(name)) {
        let expected =
            format!("joints of robot '{}', such as '{}'", robot.name, own.first().map_or("", String::as_str));
        return Err(mismatch(what, expected, format!("'{unknown}'")));
    }
    let place = |joint: &String| {
        let missing =
            || mismatch(what, format!("joint '{joint}' of robot '{}'", robot.name), format!("{} others", names.len()));
        names.iter().position(|name| name == joint).ok_or_else(missing)
    };
    own.iter().map(place).collect()
}

/// Layers with inputs and joints in our order, and outputs that are offsets from the robot's default pose (rad).
fn ordered(mut layers: Vec<Weighted>, from: &[usize], joints: &[usize], scale: &[f32], shift: &[f32]) -> Vec<Weighted> {
    let is_linear = |layer: &Weighted| matches!(layer.layer, Layer::Linear { .. });
    if !layers.first().is_some_and(is_linear) {
        let identity = identity(from.len());
        layers.insert(0, identity);
    }
    if let Some(first) = layers.first_mut() {
        let width = first.bias.len();
        first.weight = from.iter().flat_map(|i| first.weight[i * width..(i + 1) * width].to_vec()).collect();
    }
    let count = joints.len();
    let is_scaled = |layer: &Weighted| is_linear(layer) || layer.layer == Layer::Affine;
    if !layers.last().is_some_and(is_scaled) {
        layers.push(Weighted { layer: Layer::Affine, weight: vec![1.0; count], bias: vec![0.0; count] });
    }
    if let Some(Weighted { weight, bias, .. }) = layers.pop_if(|last| last.layer == Layer::Affine) {
        // A scale cannot change the order of joints.
        let mut last = identity(count);
        last.weight.iter_mut().enumerate().for_each(|(i, w)| *w *= weight[i % count]);
        last.bias = bias;
        layers.push(last);
    }
    if let Some(last) = layers.last_mut() {
        let row = |row: &[f32]| -> Vec<f32> { joints.iter().zip(scale).map(|(place, s)| row[*place] * s).collect() };
        last.weight = last.weight.chunks_exact(count).flat_map(row).collect();
        last.bias = row(&last.bias).iter().zip(shift).map(|(b, shift)| b + shift).collect();
    }
    layers
}

/// A layer that changes nothing.
fn identity(width: usize) -> Weighted {
    let weight = (0..width * width).map(|i| if i / width == i % width { 1.0 } else { 0.0 }).collect();
    Weighted { layer: Layer::Linear { outputs: width }, weight, bias: vec![0.0; width] }
}

/// A controller's file of layers and normalizer.
fn controller(
    reading: &Reading,
    layers: Vec<Weighted>,
    observation: ObservationSpec,
    (mean, deviation): (&[f32], &[f32]),
    robot: &Robot,
) -> Result<ControllerFile, RobotError> {
    let kinds: Vec<Layer> = layers.iter().map(|layer| layer.layer).collect();
    let linear = |i: usize| if let Some(Layer::Linear { outputs }) = kinds.get(i) { Some(*outputs) } else { None };
    let is_plain = kinds.len() % 2 == 1
        && (0..kinds.len()).all(|i| if i % 2 == 0 { linear(i).is_some() } else { kinds[i] == Layer::Elu });
    let steps = reading.metadata.get("iteration").and_then(|text| text.parse().ok()).unwrap_or(0);
    let hidden = (0..kinds.len().saturating_sub(1)).filter_map(linear).collect();
    let header = ControllerHeader {
        layers: if is_plain { Vec::new() } else { kinds },
        provenance: controller::Provenance { steps, ..controller::Provenance::default() },
        ..ControllerHeader::new(robot, observation, ActionSpec::Unclamped { scale: 1.0 }, hidden)
    };
    let mut file = Checkpoint::new();
    let mut width = mean.len();
    for (i, Weighted { layer, weight, bias }) in layers.into_iter().enumerate() {
        let outputs = bias.len();
        let shape = if matches!(layer, Layer::Linear { .. }) { vec![width, outputs] } else { vec![width] };
        if !bias.is_empty() {
            let name = format!("actor.mean.layers.{}", if is_plain { i / 2 } else { i });
            file.put_f32(&format!("{name}.weight"), &shape, weight)?;
            file.put_f32(&format!("{name}.bias"), &[outputs], bias)?;
            width = outputs;
        }
    }
    let wide = |of: &[f32]| of.iter().map(|x| f64::from(*x)).collect::<Vec<f64>>();
    file.put_f64("normalizer.mean", &[mean.len()], wide(mean))?;
    file.put_f64("normalizer.variance", &[mean.len()], wide(deviation).iter().map(|d| d * d).collect())?;
    let clip = reading.clip.map_or(f64::INFINITY, f64::from);
    file.put_f64("normalizer.settings", &[4], vec![1.0, 1.0, clip, 1.0])?;
    ControllerFile::new(header, &file, None, robot)
}
