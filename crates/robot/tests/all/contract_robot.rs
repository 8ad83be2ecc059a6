//! Promises about robots and their description.
use lifelike_character::{Character, Kinematics};
use lifelike_robot::controller::RobotDescription;
use lifelike_robot::reference::standing_clip;
use lifelike_robot::{Profile, ReferenceLibrary, Robot, RobotError};

const LEG: &str = r#"<mujoco model="leg"><worldbody><body name="trunk" pos="0 0 1"><freejoint name="root"/>
  <geom type="box" size=".1 .1 .1" mass="10"/>
  <body name="thigh"><joint name="hip" axis="0 1 0" range="-1 2"/><geom type="capsule" fromto="0 0 0 0 0 -.4" size=".05" mass="3"/>
  <body name="shank" pos="0 0 -.4"><joint name="knee" axis="0 1 0" range="0.5 2"/><geom type="capsule" fromto="0 0 0 0 0 -.4" size=".04" mass="2"/></body>
  </body></body></worldbody>
  <actuator><position name="hip" joint="hip" kp="40" kv="2" forcerange="-30 30"/><motor name="knee" joint="knee" ctrlrange="-1 1" gear="25"/></actuator>
  </mujoco>"#;

fn leg() -> Character {
    let text = LEG.replace("<worldbody>", "<compiler angle=\"radian\" autolimits=\"true\"/><worldbody>");
    Character::from_mjcf(&text, "leg.xml", None).unwrap()
}

fn profile(text: &str) -> Profile {
    Profile::from_toml(text, std::path::Path::new("leg.toml")).unwrap()
}

const PARAMETERS: &str = "parameters = { kp = 1, kd = 0, friction_velocity = 0.1, static_friction = 0, \
    viscous_friction = 0, torque_max = 1, full_torque_velocity = 5, velocity_max = 9 }\n";

fn message(result: Result<Robot, RobotError>) -> String {
    result.expect_err("should be refused").to_string()
}

#[test]
fn the_built_in_robots_are_those_of_the_thesis() {
    let lima = Robot::load("lima").unwrap();
    assert_eq!((lima.joints(), lima.control_hz, lima.substeps), (20, 50.0, 4));
    assert!((lima.character.mass() - 16.2).abs() < 1e-9, "{} kg", lima.character.mass());
    assert!(!lima.profile.observe_root_height && lima.key_bodies.is_empty(), "thesis 4.3.1");
    // Table 4.1: A1 actuators in the two legs of five joints, Dynamixel in neck and arms.
    let knee = lima.layout.joints.iter().position(|n| n == "left_knee").unwrap();
    assert_eq!(lima.actuators.parameters[knee].torque_max, 34.0);
    assert_eq!(lima.actuators.parameters.iter().filter(|p| p.torque_max == 34.0).count(), 10);
    assert_eq!(lima.actuators.parameters.iter().filter(|p| p.torque_max == 4.8).count(), 10);
    assert_eq!(lima.default_pose[knee], 0.5);
    // Continuous torques: a third of the A1's largest, 1.4 N m of the Dynamixel. t^p of Table 4.1: 0.3 and 0.2 m.
    let continuous = lima.continuous_torques();
    assert!((continuous[knee] - 34.0 / 3.0).abs() < 1e-12, "{continuous:?}");
    assert_eq!(continuous.iter().filter(|t| **t == 1.4).count(), 10);
    assert_eq!(lima.deviation_limit(), 0.3);
    let humanoid = Robot::load("humanoid").unwrap();
    assert_eq!(humanoid.joints(), 36);
    assert!(humanoid.actuators.parameters.iter().all(|p| p.kp == 100.0 && p.torque_max == 500.0));
    assert_eq!(humanoid.deviation_limit(), 0.2);
    assert!(humanoid.continuous_torques().iter().all(|t| (t - 500.0 / 3.0).abs() < 1e-9));
    for robot in [lima, humanoid] {
        assert_eq!(robot.layout.end_effectors.len(), 4);
        let names: Vec<&str> = robot.character.scalar_joints().map(|j| j.name.as_str()).collect();
        assert_eq!(robot.layout.joints, names);
        assert_eq!(robot.actuators.joints, names);
    }
}

#[test]
fn an_unknown_name_lists_the_known_ones() {
    let message = message(Robot::load("limo"));
    assert!(message.contains("limo") && message.contains("lima") && message.contains("humanoid"), "{message}");
}

#[test]
fn every_joint_has_exactly_one_actuator() {
    let with = |text: &str| Robot::from_character(leg(), profile(&text.replace('@', PARAMETERS)));
    let missing = message(with("[actuator.a]\njoints = [\"h*\"]\n@"));
    assert!(missing.contains("'knee'"), "{missing}");
    let twice = message(with("[actuator.a]\njoints = [\"*\"]\n@[actuator.b]\njoints = [\"hip\"]\n@"));
    assert!(twice.contains("'hip'") && twice.contains("actuator.a") && twice.contains("actuator.b"), "{twice}");
    let unknown = message(with("[actuator.a]\njoints = [\"*\", \"ankle\"]\n@"));
    assert!(unknown.contains("'ankle'"), "{unknown}");
    assert_eq!(with("[actuator.a]\njoints = [\"hip\", \"*nee\"]\n@").unwrap().actuators.joints, ["hip", "knee"]);
}

#[test]
fn a_profile_knows_rotors_that_the_model_does_not() {
    let with = |armature: &str| {
        let text = format!("[actuator.a]\njoints = [\"hip\"]\n{armature}\n@[actuator.b]\njoints = [\"knee\"]\n@");
        let text = text.replace('@', PARAMETERS);
        Robot::from_character(leg(), Profile::from_toml(&text, std::path::Path::new("leg.toml"))?)
    };
    let armatures = |robot: &Robot| robot.character.scalar_joints().map(|j| j.armature).collect::<Vec<_>>();
    let plain = armatures(&with("").unwrap());
    assert_eq!(armatures(&with("armature = 0.025").unwrap()), [0.025, plain[1]]);
    let bad = message(with("armature = -1.0"));
    assert!(bad.contains("leg.toml") && bad.contains("[actuator.a]") && bad.contains("-1"), "{bad}");
}

#[test]
fn what_the_profile_does_not_say_is_guessed_and_noted() {
    let robot = Robot::from_character(leg(), Profile::default()).unwrap();
    let [hip, knee] = robot.actuators.parameters.as_slice() else { panic!("two joints") };
    assert_eq!((hip.kp, hip.kd, hip.torque_max), (40.0, 2.0, 30.0), "the position servo's own");
    assert_eq!(knee.torque_max, 25.0, "the motor's control range times its gear");
    assert!(knee.kp > 1.0 && knee.kp <= 25.0 && knee.kd > 0.0, "{knee:?}");
    assert!(robot.notes.iter().any(|n| n.contains("'knee'")), "{:?}", robot.notes);
    // A servo with gains of its own is taken as it is; the motor's rotor swings at 10 Hz on a gain of 25 N m/rad.
    let rotors: Vec<f64> = robot.character.scalar_joints().map(|j| j.armature).collect();
    assert_eq!(rotors[0], 0.0);
    assert!(
        ((25.0 / rotors[1]).sqrt() - 62.83).abs() < 0.01 && robot.notes.iter().any(|n| n.contains("rotor of 'knee'"))
    );
    assert_eq!(robot.default_pose, [0.0, 0.5], "zero, or the nearest limit");
    assert_eq!(robot.default_position()[2], 1.0);
    assert_eq!((robot.control_hz, robot.substeps), (50.0, 4));
}

/// As robots for Isaac Gym are written: `stiffness` and `damping` are the drive's gains.
#[test]
fn a_spring_that_the_motor_cannot_bend_is_its_gain() {
    let with = |stiffness: f64| {
        let text = format!(
            r#"<mujoco><worldbody><body name="torso"><freejoint/><geom size=".1" mass="5"/>
            <body name="arm" pos="0 0 -.1"><joint name="swing" axis="0 1 0" range="-57.3 114.6" stiffness="{stiffness}"
              damping="2" armature=".05"/><geom size=".1" pos="0 0 -.5" mass="4"/></body></body></worldbody>
            <actuator><motor joint="swing" gear="50" ctrlrange="-1 1"/></actuator></mujoco>"#
        );
        Robot::from_character(Character::from_mjcf(&text, "x.xml", None).unwrap(), Profile::default()).unwrap()
    };
    let (weak, strong) = (with(24.0), with(26.0));
    let joint = |robot: &Robot| robot.character.scalar_joints().map(|j| (j.stiffness, j.damping)).next().unwrap();
    assert_eq!((joint(&weak), joint(&strong)), ((24.0, 2.0), (0.0, 0.0)), "48 and 52 N m against 50");
    let motor = &strong.actuators.parameters[0];
    assert_eq!((motor.kp, motor.kd, motor.torque_max), (26.0, 2.0, 50.0));
    assert!(strong.notes.iter().any(|n| n.contains("spring of 'swing'")), "{:?}", strong.notes);
    assert!(!weak.notes.iter().any(|n| n.contains("spring of")), "{:?}", weak.notes);
}

#[test]
fn a_profile_that_contradicts_the_model_is_refused() {
    let with = |text: &str| message(Robot::from_character(leg(), profile(text)));
    assert!(with("[default_pose]\nknee = 0.1\n").contains("knee"));
    let degrees = "knee: expected 0.500 to 2.000 rad, got 60; 60 degrees would be 1.047 rad";
    assert!(with("[default_pose]\nknee = 60.0\n").contains(degrees));
    assert!(with("[default_pose]\nankle = 0.1\n").contains("ankle"));
    assert!(with("[default_pose]\nroot = 0.1\n").contains("root"));
    assert!(with("control_hz = 50\nphysics_hz = 120\n").contains("120"));
    assert!(with("control_hz = 0\n").contains("control_hz"));
    assert!(with("end_effectors = [\"paw\"]\n").contains("paw"));
}

/// A pendulum on a post: nothing to move through the world, but joints to drive.
#[test]
fn a_robot_may_be_fixed_to_the_world() {
    let text = r#"<mujoco><worldbody><body name="post" pos="1 2 3" quat="0 0 0 1"><geom size=".1" mass="5"/>
      <body name="arm" pos="0 0 -.1"><joint name="swing" axis="0 1 0"/><geom size=".1" pos="0 0 -.5" mass="1"/></body></body></worldbody></mujoco>"#;
    let robot = Robot::from_character(Character::from_mjcf(text, "x.xml", None).unwrap(), Profile::default()).unwrap();
    assert_eq!((robot.joints(), robot.default_position().len()), (1, 1));
    assert_eq!(robot.character.root_body(), 1);
    let (position, orientation) = robot.character.fixed_base().unwrap();
    assert_eq!((position.as_slice(), orientation.k), (&[1.0, 2.0, 3.0][..], 1.0));
    let verdict = robot.readiness(lifelike_robot::Shapes::Primitives).verdict();
    assert!(verdict.contains("fixed to the world") && verdict.contains("'post'"), "{verdict}");
    assert!(Robot::load("lima").unwrap().character.fixed_base().is_none());
}

#[test]
fn characters_that_cannot_be_controlled_are_refused() {
    let of = |text: &str| {
        message(Robot::from_character(Character::from_mjcf(text, "x.xml", None).unwrap(), Profile::default()))
    };
    let link = "<geom size=\".1\" mass=\"1\"/>";
    let ball = of(&format!(
        "<mujoco><worldbody><body><freejoint/>{link}<body><joint name=\"shoulder\" type=\"ball\"/>{link}</body></body></worldbody></mujoco>"
    ));
    assert!(ball.contains("shoulder"), "{ball}");
    let stone = of(&format!("<mujoco><worldbody><body><freejoint/>{link}</body></worldbody></mujoco>"));
    assert!(stone.contains("joints to control"), "{stone}");
}

/// A sole is down within five millimetres of the ground, wherever it is that an episode begins a little above it.
#[test]
fn soles_are_down_in_the_frames_in_which_they_touch_the_ground() {
    let robot = Robot::load("lima").unwrap();
    let clip = standing_clip(&robot, 0.2);
    let lowest = {
        let mut kinematics = Kinematics::new(&robot.character);
        let mut q = robot.default_position();
        q[2] = clip.root_position[0].z;
        kinematics.update(&robot.character, &q);
        let corners = robot.anatomy.soles.values().flat_map(|sole| sole.corners.iter().map(move |c| (sole.body, c)));
        corners.map(|(body, corner)| kinematics.point(body, corner).z).fold(f64::INFINITY, f64::min)
    };
    let down = |above: f64| {
        let mut clip = clip.clone();
        clip.root_position.iter_mut().for_each(|root| root.z += above - lowest);
        ReferenceLibrary::new(&robot, &[clip], None).unwrap().soles_down(&robot)
    };
    assert_eq!(down(0.0), vec![true; 2 * clip.len()]);
    assert_eq!(down(0.004), vec![true; 2 * clip.len()]);
    assert_eq!(down(0.006), vec![false; 2 * clip.len()]);
}

#[test]
fn joints_are_matched_by_name_and_not_by_their_place_in_the_file() {
    let lima = Robot::load("lima").unwrap();
    let order = lima.layout.joints.clone();
    // As a file whose right limbs come first.
    let mut mirrored = order.clone();
    let of_side = |name: &String, side: &str| name.starts_with(side);
    mirrored.sort_by_key(|name| (of_side(name, "left"), !of_side(name, "right")));
    assert_ne!(mirrored, order);
    let other = lima.clone().in_joint_order(&mirrored).unwrap();
    assert_eq!(other.layout.joints, mirrored);
    for (joint, parameters) in other.actuators.joints.iter().zip(&other.actuators.parameters) {
        let index = order.iter().position(|name| name == joint).unwrap();
        assert_eq!(*parameters, lima.actuators.parameters[index], "{joint}");
    }
    let (ours, theirs) = (Kinematics::new(&lima.character), Kinematics::new(&other.character));
    for (i, body) in lima.character.bodies.iter().enumerate() {
        let j = other.character.body(&body.name).unwrap();
        assert!((ours.body_position[i] - theirs.body_position[j]).norm() < 1e-15, "{}", body.name);
        assert_eq!(body.inertial, other.character.bodies[j].inertial);
    }
    let back = other.in_joint_order(&order).unwrap();
    assert_eq!(RobotDescription::of(&back), RobotDescription::of(&lima));

    // A knee does not come before its hip, and other joints are another robot's.
    let mut swapped = order.clone();
    swapped.swap(0, 1);
    assert!(lima.clone().in_joint_order(&swapped).is_err());
    assert_eq!(lima.clone().in_joint_order(&["hip".into()]).unwrap().layout.joints, order);
}
