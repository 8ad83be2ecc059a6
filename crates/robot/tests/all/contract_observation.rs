//! Promises about what a policy sees.
use lifelike_character::{Kinematics, Quat, Vec3};
use lifelike_checkpoint::InputError;
use lifelike_motion::{FeatureLayout, Frame};
use lifelike_robot::observation::Part;
use lifelike_robot::reference::RootPose;
use lifelike_robot::{
    Alignment, AnchorSpec, MeasuredState, ObservationInputs, ObservationSpec, ReferenceSpec, ReferenceStream, Robot,
    RobotError,
};

/// A reference that stands still in one frame.
struct Still {
    layout: FeatureLayout,
    features: Vec<f32>,
    root: RootPose,
}

impl ReferenceStream for Still {
    fn layout(&self) -> &FeatureLayout {
        &self.layout
    }
    fn ahead(&self, _: u32) -> &[f32] {
        &self.features
    }
    fn around(&self, _: i32) -> &[f32] {
        &self.features
    }
    fn root(&self) -> RootPose {
        self.root
    }
    fn present_root(&self) -> RootPose {
        self.root
    }
    fn write_frame(&self, _: i32, _: &mut Frame) {}
    fn advance(&mut self) {}
}

fn humanoid() -> (Robot, ObservationSpec) {
    let robot = Robot::load("humanoid").unwrap();
    let reference =
        ReferenceSpec { frame: true, future: vec![5, 10], latent: 64, window: vec![-2, 3], ..Default::default() };
    let spec = ObservationSpec::new(&robot, reference, AnchorSpec { heading: true, position: true });
    (robot, spec)
}

/// A state in which every number differs, turned by `yaw` and moved by `shift` as a whole.
struct State {
    frame: Frame,
    key_bodies: Vec<Vec3>,
}

fn state(robot: &Robot, yaw: f64, shift: Vec3) -> State {
    let turn = Quat::from_euler_angles(0.0, 0.0, yaw);
    let mut q = robot.default_position();
    for (i, q) in q.iter_mut().enumerate().skip(7) {
        *q += 0.05 * (i as f64).sin();
    }
    let position = turn * Vec3::new(0.3, -0.2, 0.9) + shift;
    let orientation = turn * Quat::from_euler_angles(0.1, 0.2, 0.4);
    q[..3].copy_from_slice(position.as_slice());
    q[3..7].copy_from_slice(&lifelike_character::rotation::to_wxyz(&orientation));
    let mut kinematics = Kinematics::new(&robot.character);
    kinematics.update(&robot.character, &q);
    let place = |&(body, point): &(usize, Vec3)| kinematics.point(body, &point);
    State {
        frame: Frame {
            root_position: position,
            root_orientation: orientation,
            linear_velocity_w: turn * Vec3::new(1.0, 2.0, 3.0),
            angular_velocity_w: turn * Vec3::new(-1.0, 0.5, 0.25),
            joint_positions: q[7..].to_vec(),
            joint_velocities: (0..robot.joints()).map(|i| (i as f64).cos()).collect(),
            effectors_w: robot.effectors.iter().map(place).collect(),
        },
        key_bodies: robot.key_bodies.iter().map(place).collect(),
    }
}

fn narrow(values: &[f64]) -> Vec<f32> {
    values.iter().map(|&v| v as f32).collect()
}

fn three(v: &Vec3) -> [f32; 3] {
    [v.x as f32, v.y as f32, v.z as f32]
}

fn four(q: &Quat) -> [f32; 4] {
    [q.w as f32, q.i as f32, q.j as f32, q.k as f32]
}

fn observe(robot: &Robot, spec: &ObservationSpec, state: &State, reference: &Frame) -> Vec<f32> {
    let mut features = vec![0.0; robot.layout.size()];
    reference.write_features(&reference.root_orientation, &mut features);
    let features = narrow(&features);
    let (position, velocity) = (narrow(&state.frame.joint_positions), narrow(&state.frame.joint_velocities));
    let keys: Vec<f32> = state.key_bodies.iter().flat_map(three).collect();
    let actions: Vec<f32> = (0..2 * robot.joints()).map(|i| i as f32).collect();
    let latent = vec![0.5; spec.reference.latent];
    let reference = Still {
        layout: robot.layout.clone(),
        features,
        root: RootPose { position: three(&reference.root_position), orientation: four(&reference.root_orientation) },
    };
    let measured = MeasuredState {
        root_position: Some(three(&state.frame.root_position)),
        root_orientation: four(&state.frame.root_orientation),
        linear_velocity_w: Some(three(&state.frame.linear_velocity_w)),
        angular_velocity_w: three(&state.frame.angular_velocity_w),
        joint_position: &position,
        joint_velocity: &velocity,
        key_bodies_w: Some(&keys),
        root_height: None,
    };
    let inputs = ObservationInputs {
        measured: &measured,
        joint_offset: &[],
        last_action: &actions[..robot.joints()],
        action_before: &actions[robot.joints()..],
        reference: &reference,
        alignment: Alignment::default(),
        latent: &latent,
        past: &[],
    };
    let mut out = vec![f32::NAN; spec.size()];
    spec.write(&inputs, &mut out).unwrap();
    out
}

#[test]
fn the_humanoids_state_has_the_217_numbers_of_the_thesis() {
    let (_, spec) = humanoid();
    assert_eq!(spec.state_size(), 217);
    assert_eq!(spec.frame_size(), 13 + 2 * 36 + 3 * 4);
    assert_eq!(spec.size(), 217 + 3 * 97 + 64 + 4 + 2 * 97);
    let lima = Robot::load("lima").unwrap();
    let spec = ObservationSpec::new(&lima, ReferenceSpec { frame: true, ..Default::default() }, AnchorSpec::default());
    assert_eq!(spec.state_size(), 12 + 4 * 20, "neither root height nor key bodies");
    assert_eq!(spec.size(), 92 + lima.layout.size());
    let blind = spec.without_linear_velocity();
    assert_eq!(blind.state_size(), 89);
    assert!(blind.parts().iter().all(|part| part.name != "root_linear_velocity_h"));
}

#[test]
fn parts_tile_the_observation() {
    let (_, spec) = humanoid();
    let parts = spec.parts();
    let mut end = 0;
    for Part { name, range, .. } in &parts {
        assert_eq!(range.start, end, "{name}");
        assert!(range.end > range.start, "{name}");
        end = range.end;
    }
    assert_eq!(end, spec.size());
    let names: Vec<&str> = parts.iter().map(|part| part.name.as_str()).collect();
    assert!(names.contains(&"reference+10") && names.contains(&"latent"), "{names:?}");
}

#[test]
fn a_robot_on_its_reference_sees_itself_in_it() {
    let (robot, spec) = humanoid();
    let state = state(&robot, 0.7, Vec3::zeros());
    let out = observe(&robot, &spec, &state, &state.frame);
    let part = |name: &str| out[spec.parts().into_iter().find(|part| part.name == name).unwrap().range].to_vec();
    let reference = part("reference");
    let close = |a: &[f32], b: &[f32], what: &str| {
        assert_eq!(a.len(), b.len(), "{what}");
        a.iter().zip(b).for_each(|(a, b)| assert!((a - b).abs() < 2e-6, "{what}: {a} against {b}"));
    };
    // The reference's features come from `motion`, in f64: the two definitions of eq. 4.1 are the same.
    close(&part("root_height"), &reference[..1], "height");
    close(&part("root_orientation_h"), &reference[1..7], "orientation");
    close(&part("root_linear_velocity_h"), &reference[7..10], "linear velocity");
    close(&part("root_angular_velocity_h"), &reference[10..13], "angular velocity");
    close(&part("joint_position"), &reference[13..49], "joint positions");
    close(&part("joint_velocity"), &reference[49..85], "joint velocities");
    close(&part("reference+5"), &reference, "future");
    close(&part("anchor_heading"), &[0.0, 1.0], "heading");
    close(&part("anchor_position"), &[0.0, 0.0], "position");
    // A key body that is also an end effector is where the reference says.
    let key = robot.profile.key_bodies.iter().position(|n| n == "left_foot").unwrap();
    close(&part("key_bodies_h")[3 * key..3 * key + 3], &reference[85..88], "left foot");
    assert_eq!(part("last_action")[3], 3.0);
    assert_eq!(part("action_before")[3], 39.0);
}

#[test]
fn default_pose_is_seen_as_zero() {
    let (robot, spec) = humanoid();
    let mut state = state(&robot, 0.0, Vec3::zeros());
    state.frame.joint_positions.clone_from(&robot.default_pose);
    let out = observe(&robot, &spec, &state, &state.frame);
    for name in ["joint_position", "reference"] {
        let range = spec.parts().into_iter().find(|part| part.name == name).unwrap().range;
        let joints = if name == "reference" { &out[range][13..49] } else { &out[range] };
        assert!(joints.iter().all(|&q| q == 0.0), "{name}: {joints:?}");
    }
}

#[test]
fn heading_and_place_in_the_world_cannot_be_seen() {
    let (robot, spec) = humanoid();
    let at = |yaw: f64, shift: Vec3| {
        let state = state(&robot, yaw, shift);
        observe(&robot, &spec, &state, &state.frame)
    };
    let (here, there) = (at(0.0, Vec3::zeros()), at(2.5, Vec3::new(3.0, -4.0, 0.0)));
    for (i, (a, b)) in here.iter().zip(&there).enumerate() {
        assert!((a - b).abs() < 1e-5, "number {i}: {a} against {b}");
    }
}

#[test]
fn the_anchor_points_to_the_reference() {
    let (robot, spec) = humanoid();
    let start = spec.parts().into_iter().find(|part| part.name == "anchor_heading").unwrap().range.start;
    let place = start..start + 4;
    let state_now = state(&robot, 1.0, Vec3::zeros());
    let mut reference = state_now.frame.clone();
    let yaw = lifelike_character::rotation::heading_angle(&state_now.frame.root_orientation);
    // 0.12 m ahead of the robot, 0.16 m to its left (0.2 m away), turned left by 0.3 rad.
    let to_world = Quat::from_euler_angles(0.0, 0.0, yaw);
    reference.root_position += to_world * Vec3::new(0.12, 0.16, 0.0);
    reference.root_orientation = Quat::from_euler_angles(0.0, 0.0, 0.3) * reference.root_orientation;
    let out = observe(&robot, &spec, &state_now, &reference);
    let anchor = &out[place.clone()];
    for (got, expected) in anchor.iter().zip([0.3_f32.sin(), 0.3_f32.cos(), 0.12, 0.16]) {
        assert!((got - expected).abs() < 1e-5, "{anchor:?}");
    }
    // Six times as far away and turned by 0.9 rad: the direction stays, and no more than 0.3 m and 0.5 rad are shown.
    reference.root_position += to_world * Vec3::new(0.6, 0.8, 0.0);
    reference.root_orientation = Quat::from_euler_angles(0.0, 0.0, 0.6) * reference.root_orientation;
    let out = observe(&robot, &spec, &state_now, &reference);
    let anchor = &out[place.clone()];
    for (got, expected) in anchor.iter().zip([0.5_f32.sin(), 0.5_f32.cos(), 0.18, 0.24]) {
        assert!((got - expected).abs() < 1e-5, "{anchor:?}");
    }
}

#[test]
fn wrong_lengths_and_layouts_are_refused_by_name() {
    let (robot, spec) = humanoid();
    let state = state(&robot, 0.0, Vec3::zeros());
    let joints = vec![0.0; 36];
    let reference = Still {
        layout: robot.layout.clone(),
        features: vec![0.0; spec.frame_size()],
        root: RootPose { position: [0.0; 3], orientation: [1.0, 0.0, 0.0, 0.0] },
    };
    let measured = MeasuredState {
        root_position: Some(three(&state.frame.root_position)),
        root_orientation: [1.0, 0.0, 0.0, 0.0],
        linear_velocity_w: Some([0.0; 3]),
        joint_position: &joints,
        joint_velocity: &joints,
        key_bodies_w: Some(&[0.0; 60]),
        ..MeasuredState::default()
    };
    let inputs = ObservationInputs {
        measured: &measured,
        joint_offset: &[],
        last_action: &joints,
        action_before: &joints,
        reference: &reference,
        alignment: Alignment::default(),
        latent: &[0.0; 63],
        past: &[],
    };
    let error = spec.write(&inputs, &mut vec![0.0; spec.size()]).unwrap_err();
    assert!(
        matches!(&error, RobotError::Input(InputError::Mismatch { expected, got, .. }) if expected == "64" && got == "63"),
        "{error}"
    );

    let blind = MeasuredState { linear_velocity_w: None, ..measured };
    let inputs = ObservationInputs { measured: &blind, latent: &[0.0; 64], ..inputs };
    let error = spec.write(&inputs, &mut vec![0.0; spec.size()]).unwrap_err().to_string();
    assert!(
        error.contains("root_linear_velocity_h") && error.contains("expected the root's linear velocity"),
        "{error}"
    );

    spec.check(&robot).unwrap();
    let mut other = spec.clone();
    other.joints.swap(2, 3);
    assert!(other.check(&robot).unwrap_err().to_string().contains("joints"));
    let lima = Robot::load("lima").unwrap();
    assert!(spec.check(&lima).is_err());
    let text = toml::to_string(&spec).unwrap();
    assert_eq!(toml::from_str::<ObservationSpec>(&text).unwrap(), spec, "text carries all of it");
    assert!(toml::from_str::<ObservationSpec>(&format!("extra = 1\n{text}")).is_err());
}

#[test]
fn a_further_part_is_seen_where_its_name_is_asked_for_and_an_unknown_one_is_refused() {
    let robot = Robot::load("lima").unwrap();
    let of = |parts: &[&str]| {
        let parts = parts.iter().map(|part| (*part).to_string()).collect();
        ObservationSpec::new(&robot, ReferenceSpec { parts, ..Default::default() }, AnchorSpec::default())
    };
    let (plain, spec) = (of(&[]), of(&["projected_gravity_b"]));
    assert!(spec.check_sizes().is_ok());
    assert_eq!(spec.size(), plain.size() + 3);
    let part = spec.parts().into_iter().find(|part| part.name == "projected_gravity_b").unwrap();
    let mut state = state(&robot, 0.0, Vec3::zeros());
    state.frame.root_orientation = Quat::from_euler_angles(0.0, std::f64::consts::FRAC_PI_2, 0.3);
    let seen = observe(&robot, &spec, &state, &state.frame.clone());
    // Face down: gravity points where the robot looks.
    assert!(seen[part.range].iter().zip([1.0, 0.0, 0.0]).all(|(a, b)| (a - b).abs() < 1e-6));
    assert!(of(&["smell"]).check_sizes().unwrap_err().to_string().contains("smell"));
}

#[test]
fn the_terms_of_other_stacks_are_what_their_sources_say() {
    let robot = Robot::load("lima").unwrap();
    let names = [
        "last_action",
        "root_linear_velocity_b",
        "root_angular_velocity_b",
        "projected_gravity_b",
        "anchor_position_b",
        "anchor_orientation_b",
        "reference_joint_position",
        "reference_joint_velocity",
        "reference_height",
        "reference_linear_velocity_b",
        "reference_angular_velocity_b",
        "reference_gravity_b",
        "joint_position",
    ];
    let terms = names.map(str::to_string).to_vec();
    let anchored = |anchor: &str| {
        let reference = ReferenceSpec { terms: terms.clone(), anchor_body: anchor.into(), ..Default::default() };
        ObservationSpec::new(&robot, reference, AnchorSpec { heading: true, position: true })
    };
    let spec = anchored("left_forearm");
    spec.check_sizes().unwrap();
    spec.check(&robot).unwrap();
    let parts: Vec<String> = spec.parts().into_iter().map(|part| part.name).collect();
    assert_eq!(parts, names, "nothing but the terms, in their order");
    let text = toml::to_string(&spec).unwrap();
    assert_eq!(toml::from_str::<ObservationSpec>(&text).unwrap(), spec, "text carries the way to the anchor");

    let own = state(&robot, 0.4, Vec3::new(1.0, 2.0, 0.0));
    let other = state(&robot, -0.7, Vec3::new(1.2, 1.9, 0.1));
    let seen = observe(&robot, &spec, &own, &other.frame);
    let part = |name: &str| {
        let range = spec.parts().into_iter().find(|part| part.name == name).unwrap().range;
        seen[range].to_vec()
    };
    let close = |name: &str, expected: &[f64]| {
        let got = part(name);
        let off = got.iter().zip(expected).map(|(a, b)| (f64::from(*a) - b).abs()).fold(0.0, f64::max);
        assert!(got.len() == expected.len() && off < 1e-5, "{name}: {got:?} is not {expected:?}");
    };
    // Poses of the anchor by the kinematics of the whole robot.
    let anchor = |frame: &Frame| {
        let mut q = robot.default_position();
        q[..3].copy_from_slice(frame.root_position.as_slice());
        q[3..7].copy_from_slice(&lifelike_character::rotation::to_wxyz(&frame.root_orientation));
        q[7..].copy_from_slice(&frame.joint_positions);
        let mut kinematics = Kinematics::new(&robot.character);
        kinematics.update(&robot.character, &q);
        let body = robot.character.bodies.iter().position(|body| body.name == "left_forearm").unwrap();
        (kinematics.body_position[body], kinematics.body_orientation[body])
    };
    let (mine, theirs) = (anchor(&own.frame), anchor(&other.frame));
    close("anchor_position_b", (mine.1.inverse() * (theirs.0 - mine.0)).as_slice());
    let m = (mine.1.inverse() * theirs.1).to_rotation_matrix().into_inner();
    // torch: matrix[..., :2].reshape(-1).
    close("anchor_orientation_b", &[m[(0, 0)], m[(0, 1)], m[(1, 0)], m[(1, 1)], m[(2, 0)], m[(2, 1)]]);
    let in_root = |frame: &Frame, v: Vec3| frame.root_orientation.inverse() * v;
    close("root_linear_velocity_b", in_root(&own.frame, own.frame.linear_velocity_w).as_slice());
    close("root_angular_velocity_b", in_root(&own.frame, own.frame.angular_velocity_w).as_slice());
    close("projected_gravity_b", in_root(&own.frame, -Vec3::z()).as_slice());
    close("reference_linear_velocity_b", in_root(&other.frame, other.frame.linear_velocity_w).as_slice());
    close("reference_angular_velocity_b", in_root(&other.frame, other.frame.angular_velocity_w).as_slice());
    close("reference_gravity_b", in_root(&other.frame, -Vec3::z()).as_slice());
    close("reference_joint_position", &other.frame.joint_positions);
    close("reference_joint_velocity", &other.frame.joint_velocities);
    close("reference_height", &[other.frame.root_position.z]);
    let relative = own.frame.joint_positions.iter().zip(&robot.default_pose);
    close("joint_position", &relative.map(|(q, origin)| q - origin).collect::<Vec<f64>>());

    assert!(anchored("tail").check_sizes().unwrap_err().to_string().contains("tail"));
    assert!(anchored("pelvis").check_sizes().is_ok(), "the root by its name");
    let wrong = ReferenceSpec { terms: vec!["smell".into()], ..Default::default() };
    let wrong = ObservationSpec::new(&robot, wrong, AnchorSpec::default());
    assert!(wrong.check_sizes().unwrap_err().to_string().contains("smell"));
}
