//! Promises about the files of other stacks: what goes out comes in as it was, and what does not fit is refused.
use std::sync::Arc;

use lifelike_character::{Character, Kinematics};
use lifelike_checkpoint::Checkpoint;
use lifelike_interop::proto::Model;
use lifelike_interop::{Dialect, Motion, export, import};
use lifelike_motion::MotionClip;
use lifelike_robot::controller::{Controller, ControllerFile, ControllerHeader, PolicyWorkspace, Provenance};
use lifelike_robot::network::Layer;
use lifelike_robot::reference::standing_clip;
use lifelike_robot::{ActionSpec, AnchorSpec, ObservationSpec, ReferenceSpec, Robot, RobotError};
use prost::Message;

const TRACKING: [&str; 9] = [
    "reference_joint_position",
    "reference_joint_velocity",
    "anchor_position_b",
    "anchor_orientation_b",
    "root_linear_velocity_b",
    "root_angular_velocity_b",
    "joint_position",
    "joint_velocity",
    "last_action",
];
const ON_BOARD: [&str; 7] = [
    "reference_joint_position",
    "reference_joint_velocity",
    "anchor_orientation_b",
    "root_angular_velocity_b",
    "joint_position",
    "joint_velocity",
    "last_action",
];
const WBC: [&str; 9] = [
    "reference_height",
    "reference_linear_velocity_b",
    "reference_angular_velocity_b",
    "reference_gravity_b",
    "reference_joint_position",
    "root_angular_velocity_b",
    "joint_position",
    "joint_velocity",
    "last_action",
];

fn lima() -> Arc<Robot> {
    Arc::new(Robot::load("lima").unwrap())
}

fn numbers(count: usize, step: usize, size: f32) -> Vec<f32> {
    (0..count).map(|i| (((i * step) % 997) as f32 / 498.5 - 1.0) * size).collect()
}

/// A policy with these inputs, whose weights all differ.
fn policy(robot: &Arc<Robot>, terms: &[&str], action: ActionSpec, layers: Vec<Layer>) -> Controller {
    let anchor_body = if terms.contains(&"anchor_orientation_b") { "left_thigh" } else { "" };
    let reference = ReferenceSpec {
        terms: terms.iter().map(|term| (*term).to_string()).collect(),
        anchor_body: anchor_body.into(),
        ..ReferenceSpec::default()
    };
    let observation = ObservationSpec::new(robot, reference, AnchorSpec::default());
    observation.check_sizes().unwrap();
    let (size, joints) = (observation.size(), robot.joints());
    let header = ControllerHeader {
        layers: layers.clone(),
        provenance: Provenance { steps: 7, ..Provenance::default() },
        ..ControllerHeader::new(robot, observation, action, vec![24, 16])
    };
    let mut file = Checkpoint::new();
    let put = |file: &mut Checkpoint, i: usize, shape: &[usize], outputs: usize| {
        let weight = numbers(shape.iter().product(), 7919 + i, 0.2);
        file.put_f32(&format!("actor.mean.layers.{i}.weight"), shape, weight).unwrap();
        file.put_f32(&format!("actor.mean.layers.{i}.bias"), &[outputs], numbers(outputs, 31, 0.1)).unwrap();
    };
    if layers.is_empty() {
        for (i, pair) in [size, 24, 16, joints].windows(2).enumerate() {
            put(&mut file, i, pair, pair[1]);
        }
    }
    let mut width = size;
    for (i, layer) in layers.iter().enumerate() {
        match layer {
            Layer::Linear { outputs } => {
                put(&mut file, i, &[width, *outputs], *outputs);
                width = *outputs;
            }
            Layer::Affine | Layer::LayerNorm { .. } => put(&mut file, i, &[width], width),
            _ => {}
        }
    }
    file.put_f64("normalizer.mean", &[size], numbers(size, 17, 0.3).iter().map(|x| f64::from(*x)).collect()).unwrap();
    let variance = numbers(size, 13, 0.3).iter().map(|x| 0.5 + f64::from(*x)).collect();
    file.put_f64("normalizer.variance", &[size], variance).unwrap();
    file.put_f64("normalizer.settings", &[4], vec![1.0, 1.0, 5.0, 1.0]).unwrap();
    Controller::new(ControllerFile::new(header, &file, None, robot).unwrap(), robot.clone()).unwrap()
}

fn bend(robot: &Robot) -> MotionClip {
    let mut clip = standing_clip(robot, 1.0);
    let joints = robot.joints();
    for (i, q) in clip.joints.iter_mut().enumerate() {
        *q += 0.1 * ((i / joints) as f64 * 0.2 + (i % joints) as f64).sin();
    }
    for (i, place) in clip.root_position.iter_mut().enumerate() {
        place.x += 0.01 * i as f64;
    }
    clip
}

fn model(controller: &Controller, dialect: Dialect, clip: &MotionClip) -> (Model, Vec<u8>) {
    let files = export(controller, dialect, Motion::Clip(clip)).unwrap();
    let bytes = files.into_iter().find(|file| file.name.ends_with("policy.onnx")).unwrap().bytes;
    (Model::decode(&bytes[..]).unwrap(), bytes)
}

fn text(model: &Model, key: &str) -> String {
    let found = model.metadata_props.iter().find(|property| property.key.as_deref() == Some(key));
    found.unwrap_or_else(|| panic!("no {key}")).value.clone().unwrap()
}

const UNCLAMPED: ActionSpec = ActionSpec::Unclamped { scale: 0.5 };

/// Targets for observations, `[N, O]`.
fn targets(controller: &Controller, rows: &[f32]) -> Vec<f32> {
    let joints = controller.robot().joints();
    let mut outputs = vec![0.0; rows.len() / controller.observation().size() * joints];
    controller.outputs(&mut rows.to_vec(), &mut PolicyWorkspace::batched(), &mut outputs);
    let mut targets = vec![0.0; outputs.len()];
    for (output, target) in outputs.chunks_exact(joints).zip(targets.chunks_exact_mut(joints)) {
        controller.actions().write(output, &[], target);
    }
    targets
}

#[test]
fn what_goes_out_to_a_stack_comes_in_with_the_same_targets_and_motion() {
    let robot = lima();
    let clip = bend(&robot);
    let deep = vec![
        Layer::Linear { outputs: 24 },
        Layer::LayerNorm { epsilon: 1e-5 },
        Layer::Silu,
        Layer::Linear { outputs: robot.joints() },
        Layer::Tanh,
    ];
    for (terms, dialect, layers) in [
        (&TRACKING[..], Dialect::BeyondMimic, Vec::new()),
        (&TRACKING[..], Dialect::Mjlab, Vec::new()),
        (&ON_BOARD[..], Dialect::Mjlab, deep.clone()),
        (&ON_BOARD[..], Dialect::BeyondMimic, deep),
        (&ON_BOARD[..], Dialect::Holosoma, Vec::new()),
        (&WBC[..], Dialect::Wbc, Vec::new()),
    ] {
        let ours = policy(&robot, terms, UNCLAMPED, layers);
        let (_, bytes) = model(&ours, dialect, &clip);
        let imported = import(&bytes, "x.onnx", &robot, None).unwrap();
        let back = Controller::new(imported.controller, robot.clone()).unwrap();
        // Names in the order of the file: holosoma's is alphabetical.
        let (from, to) = (ours.observation(), back.observation());
        let rows = numbers(100 * from.size(), 271, 1.0);
        let scale = UNCLAMPED.scale() as f32;
        let moved: Vec<f32> = rows
            .chunks_exact(from.size())
            .flat_map(|row| {
                let mut out = Vec::new();
                for part in to.parts() {
                    let own = from.parts().into_iter().find(|other| other.name == part.name).unwrap();
                    // The imported controller's actions are in rad.
                    let unit = if part.name == "last_action" { scale } else { 1.0 };
                    out.extend(row[own.range].iter().map(|x| x * unit));
                }
                out
            })
            .collect();
        let (expected, got) = (targets(&ours, &rows), targets(&back, &moved));
        let worst = expected.iter().zip(&got).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        assert!(worst < 1e-5, "{dialect}: {worst}");
        assert!(expected.iter().any(|x| x.abs() > 0.1));
        if dialect == Dialect::Wbc {
            assert!(imported.clip.is_none());
            continue;
        }
        let motion = imported.clip.unwrap();
        for frame in 0..clip.len() {
            assert!((motion.root_position[frame] - clip.root_position[frame]).norm() < 1e-5, "{dialect}: {frame}");
            assert!(motion.root_orientation[frame].angle_to(&clip.root_orientation[frame]) < 1e-3);
            let pairs = motion.joints_at(frame).iter().zip(clip.joints_at(frame));
            assert!(pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) < 1e-6);
        }
    }
}

#[test]
fn each_stack_gets_its_names_versions_and_numbers() {
    let robot = lima();
    let clip = bend(&robot);
    let names = |values: &[lifelike_interop::proto::Value]| -> Vec<String> {
        values.iter().map(|value| value.name.clone().unwrap()).collect()
    };
    let version = |model: &Model| (model.opset_import[0].version.unwrap(), model.ir_version.unwrap());

    let tracker = policy(&robot, &TRACKING, UNCLAMPED, Vec::new());
    let (mjlab, _) = model(&tracker, Dialect::Mjlab, &clip);
    let graph = mjlab.graph.clone().unwrap();
    assert_eq!(names(&graph.input), ["obs", "time_step"]);
    let all = ["actions", "joint_pos", "joint_vel", "body_pos_w", "body_quat_w", "body_lin_vel_w", "body_ang_vel_w"];
    assert_eq!(names(&graph.output), all);
    assert_eq!(version(&mjlab), (18, 8));
    let terms = "command,motion_anchor_pos_b,motion_anchor_ori_b,base_lin_vel,base_ang_vel,joint_pos,joint_vel,actions";
    assert_eq!(text(&mjlab, "observation_names"), terms);
    assert_eq!(text(&mjlab, "observation_terms_clip").split(',').next(), Some("-inf;inf"));
    assert_eq!(text(&mjlab, "anchor_body_name"), "left_thigh");
    assert!(text(&mjlab, "action_scale").split(',').all(|scale| scale == "0.500"));
    assert_eq!(text(&mjlab, "joint_names").split(',').count(), robot.joints());

    // Isaac Lab numbers bodies level after level: both hips before both second hips.
    let (isaac, _) = model(&tracker, Dialect::BeyondMimic, &clip);
    assert_eq!(version(&isaac), (11, 6));
    let joints: Vec<String> = text(&isaac, "joint_names").split(',').map(str::to_string).collect();
    let place = |name: &str| joints.iter().position(|joint| joint.contains(name)).unwrap();
    assert!(
        place("left_hip_yaw") < place("right_hip_yaw") && place("right_hip_yaw") < place("left_hip_roll"),
        "{joints:?}"
    );
    assert_eq!(text(&isaac, "observation_history_lengths"), "1,1,1,1,1,1,1,1");

    let on_board = policy(&robot, &ON_BOARD, UNCLAMPED, Vec::new());
    let (holosoma, _) = model(&on_board, Dialect::Holosoma, &clip);
    assert_eq!(version(&holosoma), (13, 7));
    let outputs = names(&holosoma.graph.clone().unwrap().output);
    assert_eq!(outputs, ["actions", "joint_pos", "joint_vel", "ref_pos_xyz", "ref_quat_xyzw"]);
    for property in &holosoma.metadata_props {
        let value = property.value.clone().unwrap();
        assert!(
            serde_json::from_str::<serde_json::Value>(&value).is_ok(),
            "its reader parses all as JSON: {property:?}"
        );
    }

    let files = export(&on_board, Dialect::Unitree, Motion::Clip(&clip)).unwrap();
    let found: Vec<&str> = files.iter().map(|file| file.name.as_str()).collect();
    assert_eq!(found, ["exported/policy.onnx", "params/deploy.yaml", &format!("params/{}.npz", clip.name)]);
    let graph = Model::decode(&files[0].bytes[..]).unwrap().graph.unwrap();
    assert_eq!((names(&graph.input), names(&graph.output)), (vec!["obs".into()], vec!["actions".into()]));
    let yaml = String::from_utf8(files[1].bytes.clone()).unwrap();
    let order: Vec<usize> =
        ["motion_command:", "motion_anchor_ori_b:", "base_ang_vel:", "joint_pos_rel:", "last_action:"]
            .iter()
            .map(|term| yaml.find(term).unwrap())
            .collect();
    assert!(order.is_sorted(), "{yaml}");

    let files = export(&policy(&robot, &WBC, UNCLAMPED, Vec::new()), Dialect::Wbc, Motion::None).unwrap();
    let config = String::from_utf8(files[1].bytes.clone()).unwrap();
    assert!(config.contains(&format!("wbc_command_dim: {}", 10 + robot.joints())), "{config}");
}

#[test]
fn a_policy_that_a_stack_cannot_feed_is_refused_with_the_plan_that_trains_one() {
    let robot = lima();
    let clip = bend(&robot);
    let refused = |controller: &Controller, dialect: Dialect, motion: Motion<'_>| {
        export(controller, dialect, motion).unwrap_err().to_string()
    };
    let assets = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../lifelike/assets");
    let ours = Controller::load(&assets.join("lima-path.controller.safetensors"), robot.clone()).unwrap();
    let error = refused(&ours, Dialect::Mjlab, Motion::Clip(&clip));
    assert!(error.contains("track-beyondmimic") && error.contains("root_orientation_h"), "{error}");
    let tracker = policy(&robot, &TRACKING, UNCLAMPED, Vec::new());
    let error = refused(&tracker, Dialect::Unitree, Motion::Clip(&clip));
    assert!(error.contains("anchor_position_b") && error.contains("track-deploy"), "{error}");
    let error = refused(&tracker, Dialect::Mjlab, Motion::None);
    assert!(error.contains("--motions"), "{error}");
    let reference = policy(&robot, &ON_BOARD, ActionSpec::Reference { scale: 0.5 }, Vec::new());
    let error = refused(&reference, Dialect::Holosoma, Motion::Clip(&clip));
    assert!(error.contains("action.base = \"unclamped\""), "{error}");
    let fewer = policy(&robot, &ON_BOARD[..5], UNCLAMPED, Vec::new());
    let error = refused(&fewer, Dialect::Holosoma, Motion::Clip(&clip));
    assert!(error.contains("all of the observations actions"), "{error}");
}

#[test]
fn a_file_that_is_no_policy_of_a_stack_is_refused_by_what_is_wrong_with_it() {
    let robot = lima();
    let clip = bend(&robot);
    let (good, _) = model(&policy(&robot, &ON_BOARD, UNCLAMPED, Vec::new()), Dialect::Mjlab, &clip);
    let refused = |model: &Model| -> String {
        let error: RobotError = import(&model.encode_to_vec(), "x.onnx", &robot, None).unwrap_err();
        error.to_string()
    };
    let with = |key: &str, value: &str| {
        let mut model = good.clone();
        let property = model.metadata_props.iter_mut().find(|property| property.key.as_deref() == Some(key)).unwrap();
        property.value = Some(value.into());
        refused(&model)
    };
    assert!(import(b"not onnx", "x.onnx", &robot, None).unwrap_err().to_string().contains("an ONNX file"));
    let mut bare = good.clone();
    bare.metadata_props.clear();
    assert!(refused(&bare).contains("observation_names"));
    let error = with("observation_names", "command,motion_anchor_ori_b,base_ang_vel,joint_pos,joint_vel");
    assert!(error.contains("numbers of the observation") && error.contains("by its network"), "{error}");
    assert!(with("observation_names", "command,smell").contains("'smell'"));
    assert!(with("joint_names", "a,b").contains("'a'"));
    let stiff = text(&good, "joint_stiffness").replacen(char::is_numeric, "9", 1);
    assert!(with("joint_stiffness", &format!("9{stiff}")).contains("joint_stiffness of joint"));
    assert!(with("action_scale", "0.1,0.2").contains("one for each joint"));
    assert!(with("action_scale", "-0.25").contains("above 0"));
    assert!(
        with("joint_stiffness", &text(&good, "joint_stiffness").replacen(char::is_numeric, "nan", 1))
            .contains("joint_stiffness")
    );
    let twice = "command,motion_anchor_ori_b,base_ang_vel,joint_pos,joint_pos,actions";
    assert!(with("observation_names", twice).contains("'joint_pos' twice"));
    assert!(with("observation_terms_scale", "1.000,1.000,1.000,1.000,0.050,1.000").contains("got 0.050"));
    assert!(with("observation_terms_history_length", "5,0,0,0,0,0").contains("got 5"));
    assert!(with("observation_terms_clip", "-1.000;1.000").contains("-inf;inf"));
    let joints = text(&good, "joint_names");
    let first = joints.split(',').next().unwrap();
    assert!(with("joint_names", &format!("{joints},{first}")).contains("twice"));
    assert!(with("anchor_body_name", "tail").contains("tail"));
    let mut other = good;
    for node in &mut other.graph.as_mut().unwrap().node {
        if node.op_type.as_deref() == Some("Elu") {
            node.op_type = Some("Softplus".into());
        }
    }
    let error = refused(&other);
    assert!(error.contains("Softplus") && error.contains("LayerNormalization"), "{error}");
}

#[test]
fn the_robot_in_holosomas_file_has_the_same_kinematics() {
    let robot = lima();
    let clip = bend(&robot);
    let (model, _) = model(&policy(&robot, &ON_BOARD, UNCLAMPED, Vec::new()), Dialect::Holosoma, &clip);
    let urdf: String = serde_json::from_str(&text(&model, "robot_urdf")).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("x.urdf");
    std::fs::write(&path, urdf).unwrap();
    let read = Character::load(&path).unwrap();
    assert!((read.mass() - robot.character.mass()).abs() < 1e-9);
    let columns = |character: &Character| clip.columns_for(character).unwrap();
    let pose = |character: &Character| {
        let mut q = character.reference_position();
        clip.write_position(character, &columns(character), 20, &mut q);
        let mut kinematics = Kinematics::new(character);
        kinematics.update(character, &q);
        kinematics
    };
    let (ours, theirs) = (pose(&robot.character), pose(&read));
    for (i, body) in robot.character.bodies.iter().enumerate().skip(1) {
        let j = read.bodies.iter().position(|other| other.name == body.name).unwrap();
        assert!((ours.body_position[i] - theirs.body_position[j]).norm() < 1e-9, "{}", body.name);
        assert!(ours.body_orientation[i].angle_to(&theirs.body_orientation[j]) < 1e-7, "{}", body.name);
    }
}

#[test]
fn networks_of_unusual_form_come_in_as_they_are_or_not_at_all() {
    let robot = lima();
    let clip = bend(&robot);
    let joints = robot.joints();
    // The first layer is no matrix, the last is a normalization; Isaac's order has to be undone in both.
    let odd = vec![
        Layer::Affine,
        Layer::Tanh,
        Layer::Linear { outputs: joints },
        Layer::Relu,
        Layer::LayerNorm { epsilon: 1e-3 },
    ];
    let ours = policy(&robot, &ON_BOARD, UNCLAMPED, odd);
    let (good, bytes) = model(&ours, Dialect::BeyondMimic, &clip);
    let back = Controller::new(import(&bytes, "x.onnx", &robot, None).unwrap().controller, robot.clone()).unwrap();
    let size = ours.observation().size();
    let rows = numbers(50 * size, 271, 1.0);
    let mut moved = rows.clone();
    let action = ours.observation().parts().into_iter().find(|part| part.name == "last_action").unwrap().range;
    moved.chunks_exact_mut(size).for_each(|row| row[action.clone()].iter_mut().for_each(|y| *y *= 0.5));
    let pairs = targets(&ours, &rows).into_iter().zip(targets(&back, &moved));
    let worst = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    assert!(worst < 1e-5, "{worst}");

    let refused = |change: &dyn Fn(&mut Model)| -> String {
        let mut model = good.clone();
        change(&mut model);
        import(&model.encode_to_vec(), "x.onnx", &robot, None).unwrap_err().to_string()
    };
    fn constant<'a>(model: &'a mut Model, name: &str) -> &'a mut lifelike_interop::proto::Tensor {
        let found = model.graph.as_mut().unwrap().initializer.iter_mut();
        found.into_iter().find(|tensor| tensor.name.as_deref() == Some(name)).unwrap()
    }
    let negative = refused(&|model| {
        let inverse = constant(model, "normalizer.inverse_deviation");
        let raw = inverse.raw_data.as_mut().unwrap();
        raw[..4].copy_from_slice(&(-2.0_f32).to_le_bytes());
    });
    assert!(negative.contains("deviation of at least"), "{negative}");
    for (name, bytes) in [("actor.mean.layers.2.weight", f32::NAN), ("normalizer.mean", f32::NAN)] {
        let said = refused(&|model| {
            let raw = constant(model, name).raw_data.as_mut().unwrap();
            raw[..4].copy_from_slice(&bytes.to_le_bytes());
        });
        assert!(said.contains("network after"), "{name}: {said}");
    }
    let huge = refused(&|model| constant(model, "normalizer.mean").dims = vec![1 << 62, 1 << 62]);
    assert!(huge.contains("network after"), "{huge}");
    let elsewhere = refused(&|model| constant(model, "actor.mean.layers.2.weight").data_location = Some(1));
    assert!(elsewhere.contains("network after"), "{elsewhere}");
    let elsewhere = refused(&|model| {
        model.graph.as_mut().unwrap().output.retain(|output| output.name.as_deref() != Some("actions"))
    });
    assert!(elsewhere.contains("'actions'"), "{elsewhere}");
    let wide = refused(&|model| {
        let input = model.graph.as_mut().unwrap().input.iter_mut().next().unwrap();
        let kind = input.kind.as_mut().unwrap().tensor_type.as_mut().unwrap();
        kind.shape.as_mut().unwrap().dim[1].dim_value = Some(1 << 62);
    });
    assert!(wide.contains("a width from 1 to"), "{wide}");
    let more = refused(&|model| {
        let input = model.graph.as_ref().unwrap().input[0].clone();
        let other = lifelike_interop::proto::Value { name: Some("hidden_state".into()), ..input };
        model.graph.as_mut().unwrap().input.push(other);
    });
    assert!(more.contains("hidden_state"), "{more}");
    let foreign = refused(&|model| model.graph.as_mut().unwrap().node[0].domain = Some("com.foo".into()));
    assert!(foreign.contains("com.foo"), "{foreign}");
    let lost = refused(&|model| model.graph.as_mut().unwrap().initializer.clear());
    assert!(lost.contains("network after"), "{lost}");
}
