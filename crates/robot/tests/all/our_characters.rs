//! Facts about the robots that come with the program.
use std::path::{Path, PathBuf};

use lifelike_character::anatomy::Overrides;
use lifelike_character::{Anatomy, Character, Kinematics, Role, Symmetry, Vec3};

fn load(name: &str) -> Character {
    Character::load(Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("robots/{name}.xml"))).unwrap()
}

/// A robot that is not ours; only ignored tests ask for it.
fn other(file: &str) -> Character {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let (path, command) = match file.split_once('/') {
        Some(("fetched", file)) => (root.join("third_party/robots").join(file), "run `cargo xtask test`"),
        _ => {
            let data = std::env::var_os("LIFELIKE_DATA").map_or_else(|| root.join("../shared/data"), PathBuf::from);
            (data.join("robots").join(file), "let LIFELIKE_DATA name the data folder (CONTRIBUTING.md)")
        }
    };
    assert!(path.is_file(), "no {}: {command}", path.display());
    Character::load(&path).unwrap()
}

fn world(character: &Character, anatomy: &Anatomy, role: Role) -> Vec3 {
    let place = &anatomy.places[&role];
    Kinematics::new(character).point(place.body, &place.point)
}

#[track_caller]
fn near(a: Vec3, b: [f64; 3]) {
    assert!((a - Vec3::from(b)).norm() < 1e-9, "{a} instead of {b:?}");
}

/// Top of the head's sphere over the sole.
fn height(character: &Character) -> f64 {
    let kinematics = Kinematics::new(character);
    let head = &character.geoms[character.geom("head").unwrap()];
    let lifelike_character::GeomShape::Sphere(radius) = head.shape else { panic!("a sphere") };
    let sole = &character.sites[character.site("left_foot").unwrap()];
    kinematics.point(head.body, &head.position).z + radius - kinematics.point(sole.body, &sole.position).z
}

#[test]
fn lima_is_the_thesis_robot() {
    let lima = load("lima");
    assert!((lima.mass() - 16.2).abs() < 1e-9, "{}", lima.mass());
    assert!((height(&lima) - 0.84).abs() < 1e-9, "{}", height(&lima));
    assert_eq!((lima.scalar_joints().count(), lima.nq, lima.nv, lima.actuators.len()), (20, 27, 26, 20));
    assert!(lima.joint("left_ankle_roll").is_err());
    for actuator in &lima.actuators {
        let torque = if lima.joints[actuator.joint].armature == 0.01 { 34.0 } else { 4.8 };
        assert_eq!(actuator.ctrl_range, Some((-torque, torque)), "{}", actuator.name);
    }
}

#[test]
fn the_humanoid_is_the_thesis_humanoid() {
    let humanoid = load("humanoid");
    assert!((humanoid.mass() - 75.0).abs() < 1e-9, "{}", humanoid.mass());
    assert!((height(&humanoid) - 1.75).abs() < 1e-9, "{}", height(&humanoid));
    let joints = humanoid.scalar_joints().count();
    assert_eq!((joints, humanoid.actuators.len()), (36, 36));
    // Height, orientation, velocities, joints and their velocities, twenty places, two actions: thesis 4.3.1.
    assert_eq!(1 + 6 + 6 + 2 * joints + 20 * 3 + 2 * joints, 217);
    assert!(humanoid.sites.len() >= 20);
}

#[test]
fn joint_centres_are_where_the_text_puts_them() {
    let lima = load("lima");
    let anatomy = Anatomy::guess(&lima, &Overrides::new()).unwrap();
    near(world(&lima, &anatomy, Role::Pelvis), [0.0, 0.0, 0.44]);
    near(world(&lima, &anatomy, Role::LeftThigh), [0.0, 0.07, 0.44]);
    near(world(&lima, &anatomy, Role::LeftShank), [0.0, 0.07, 0.24]);
    near(world(&lima, &anatomy, Role::RightFoot), [0.0, -0.07, 0.04]);
    near(world(&lima, &anatomy, Role::RightUpperArm), [0.0, -0.125, 0.64]);
    near(world(&lima, &anatomy, Role::LeftHand), [0.0, 0.125, 0.375]);
    near(world(&lima, &anatomy, Role::Head), [0.0, 0.0, 0.775]);
    let corners = &anatomy.soles[&Role::LeftFoot].corners;
    for expected in [[0.1, 0.035, -0.04], [0.1, -0.035, -0.04], [-0.05, 0.035, -0.04], [-0.05, -0.035, -0.04]] {
        assert!(corners.iter().any(|c| (c - Vec3::from(expected)).norm() < 1e-9), "{expected:?} in {corners:?}");
    }
    assert_eq!(corners.len(), 4);
}

#[test]
fn an_override_wins_over_the_guess() {
    let lima = load("lima");
    let overrides = Overrides::from([(Role::Head, "imu".to_string()), (Role::LeftFoot, "right_foot".to_string())]);
    let anatomy = Anatomy::guess(&lima, &overrides).unwrap();
    assert_eq!(anatomy.places[&Role::Head].body, lima.body("pelvis").unwrap());
    assert_eq!(anatomy.soles[&Role::LeftFoot].body, lima.body("right_foot").unwrap());
    let error = Anatomy::guess(&lima, &Overrides::from([(Role::Head, "nose".to_string())])).unwrap_err();
    assert!(error.to_string().contains("no body named 'nose'"), "{error}");
}

/// One leg as Gymnasium's humanoid has it: the foot is a body of its own without a joint.
fn leg_with_a_fixed_foot(side: &str, y: f64) -> String {
    format!(
        "<body name='{side}_thigh' pos='0 {y} 0'><joint name='{side}_hip' axis='0 1 0'/><geom size='.05 .15' type='capsule' pos='0 0 -.2'/>
         <body name='{side}_shin' pos='0 0 -.4'><joint name='{side}_knee' axis='0 1 0'/><geom size='.05 .15' type='capsule' pos='0 0 -.2'/>
         <body name='{side}_foot' pos='0 0 -.45'><geom name='{side}_sole' size='.075' pos='.03 0 0'/></body></body></body>"
    )
}

#[test]
fn a_foot_without_a_joint_is_a_foot() {
    let (left, right) = (leg_with_a_fixed_foot("left", 0.1), leg_with_a_fixed_foot("right", -0.1));
    let text = format!(
        "<mujoco><worldbody><body name='trunk' pos='0 0 1'><freejoint/><geom size='.2'/>{left}{right}</body></worldbody></mujoco>"
    );
    let walker = Character::from_mjcf(&text, "walker.xml", None).unwrap();
    let anatomy = Anatomy::guess(&walker, &Overrides::new()).unwrap();
    assert_eq!(anatomy.places[&Role::LeftFoot].body, walker.body("left_foot").unwrap());
    near(world(&walker, &anatomy, Role::RightFoot), [0.0, -0.1, 0.15]);
    assert_eq!(anatomy.soles[&Role::LeftFoot].body, walker.body("left_foot").unwrap());
    assert!(!anatomy.soles[&Role::LeftFoot].corners.is_empty());
}

/// File, names of thigh, shank and foot, whether it has arms.
type Legs = (&'static str, [&'static str; 3], bool);

#[test]
#[ignore = "needs the robots that `cargo xtask test` fetches"]
fn legs_are_found_in_fetched_robots() {
    legs_are_found([
        ("fetched/dm_control/humanoid.xml", ["left_thigh", "left_shin", "left_foot"], true),
        ("fetched/dm_control/humanoid_CMU.xml", ["lfemur", "ltibia", "lfoot"], true),
        ("fetched/unitree_g1/g1.xml", ["left_hip_yaw_link", "left_knee_link", "left_ankle_roll_link"], true),
    ]);
}

#[test]
#[ignore = "needs robots that nobody offers as one exact download: LIFELIKE_DATA"]
fn legs_are_found_in_shared_robots() {
    let duck = ["knee_and_ankle_assembly", "knee_and_ankle_assembly_2", "foot_assembly"];
    legs_are_found([
        ("amp_humanoid.xml", ["left_thigh", "left_shin", "left_foot"], true),
        ("open_duck_mini_v2/robot.xml", duck, false),
        ("open_duck_mini_v2/robot.urdf", duck, false),
        ("toddlerbot_active.xml", ["left_hip_pitch_link", "left_calf_link", "ank_roll_link"], true),
    ]);
}

fn legs_are_found<const N: usize>(robots: [Legs; N]) {
    for (file, expected, has_arms) in robots {
        let character = other(file);
        let anatomy = Anatomy::guess(&character, &Overrides::new()).unwrap();
        let name = |role: Role| character.bodies[anatomy.places[&role].body].name.as_str();
        assert_eq!([Role::LeftThigh, Role::LeftShank, Role::LeftFoot].map(name), expected, "{file}");
        for (left, right) in [
            (Role::LeftThigh, Role::RightThigh),
            (Role::LeftShank, Role::RightShank),
            (Role::LeftFoot, Role::RightFoot),
        ] {
            let (left, right) = (world(&character, &anatomy, left), world(&character, &anatomy, right));
            assert!((left.z - right.z).abs() < 0.01 && (left - right).norm() > 0.03, "{file}: {left} {right}");
        }
        let z = |role| world(&character, &anatomy, role).z;
        assert!(z(Role::LeftThigh) > z(Role::LeftShank) && z(Role::LeftShank) > z(Role::LeftFoot), "{file}");
        for foot in [Role::LeftFoot, Role::RightFoot] {
            let sole = &anatomy.soles[&foot];
            let kinematics = Kinematics::new(&character);
            let lowest = sole.corners.iter().map(|c| kinematics.point(sole.body, c).z).fold(f64::MAX, f64::min);
            assert!(sole.corners.len() >= 3 && lowest < z(foot), "{file}: {:?}", sole.corners);
        }
        assert_eq!(anatomy.places.contains_key(&Role::LeftHand), has_arms, "{file}");
        assert_eq!(anatomy.places.contains_key(&Role::RightForearm), has_arms, "{file}");
    }
}

#[test]
fn left_mirrors_right() {
    for name in ["lima", "humanoid"] {
        let character = load(name);
        let symmetry = Symmetry::derive(&character).unwrap();
        let names: Vec<&str> = character.scalar_joints().map(|j| j.name.as_str()).collect();
        for (i, own) in names.iter().enumerate() {
            let image =
                if own.starts_with("left_") { own.replace("left_", "right_") } else { own.replace("right_", "left_") };
            assert_eq!(names[symmetry.joint[i]], image);
            // Turns about the lateral axis keep their sign.
            let lateral = own.ends_with("pitch") || own.ends_with("knee") || own.ends_with("elbow");
            assert_eq!(symmetry.sign[i], if lateral { 1.0 } else { -1.0 }, "{own}");
        }
        let q: Vec<f64> =
            character.reference_position().iter().enumerate().map(|(i, x)| x + (i as f64).sin() * 0.3).collect();
        let twice = symmetry.mirror_position(&character, &symmetry.mirror_position(&character, &q));
        let norm = q[3..7].iter().map(|x| x * x).sum::<f64>().sqrt();
        for (i, (a, b)) in q.iter().zip(&twice).enumerate() {
            let a = if (3..7).contains(&i) { a / norm } else { *a };
            assert!((a - b).abs() < 1e-12, "{name} {i}: {a} {b}");
        }
    }
}

#[test]
#[ignore = "needs the robots that `cargo xtask test` fetches"]
fn fetched_robots_are_symmetric() {
    ["dm_control/humanoid.xml", "dm_control/humanoid_CMU.xml", "unitree_g1/g1.xml"]
        .iter()
        .for_each(|file| is_symmetric(&format!("fetched/{file}")));
}

#[test]
#[ignore = "needs robots that nobody offers as one exact download: LIFELIKE_DATA"]
fn shared_robots_are_symmetric_or_it_is_said_why_not() {
    ["amp_humanoid.xml", "open_duck_mini_v2/robot.xml"].iter().for_each(|file| is_symmetric(file));
    let error = Symmetry::derive(&other("toddlerbot_active.xml")).unwrap_err().to_string();
    assert!(error.contains("right_wrist_roll") && error.contains("degrees"), "{error}");
}

fn is_symmetric(file: &str) {
    let symmetry = Symmetry::derive(&other(file)).unwrap();
    for (i, partner) in symmetry.joint.iter().enumerate() {
        assert_eq!(symmetry.joint[*partner], i, "{file}");
    }
}

#[test]
fn one_short_leg_is_not_symmetric() {
    let text = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("robots/lima.xml")).unwrap();
    let short =
        text.replace("<body name=\"left_shank\" pos=\"0 0 -0.2\">", "<body name=\"left_shank\" pos=\"0 0 -0.15\">");
    assert_ne!(text, short);
    let error = Symmetry::derive(&Character::from_mjcf(&short, "short", None).unwrap()).unwrap_err().to_string();
    assert!(error.contains("not symmetric") && error.contains("shank"), "{error}");
    let twisted = text.replacen("axis=\"0 1 0\" range=\"0 2.4\"", "axis=\"0.3 1 0\" range=\"0 2.4\"", 1);
    let error = Symmetry::derive(&Character::from_mjcf(&twisted, "t", None).unwrap()).unwrap_err().to_string();
    assert!(error.contains("axis") && error.contains("knee"), "{error}");
}
