//! The verdict on a robot, before any time is spent on it.
#![allow(clippy::unwrap_used)]

use std::path::Path;

use lifelike_character::{Character, Quat};
use lifelike_robot::{Profile, Readiness, Robot, Severity, Shapes};

/// A biped of 8 kg with a trunk, two legs and feet; `foot` and `trunk` stand in the geoms, `torque` limits all joints.
fn biped(trunk: &str, foot: &str, torque: f64) -> Robot {
    biped_in(None, trunk, foot, torque)
}

/// Its mesh is `part.stl` of a folder.
fn biped_in(folder: Option<&Path>, trunk: &str, foot: &str, torque: f64) -> Robot {
    let leg = |side: &str, y: f64| {
        format!(
            r#"<body name="{side}_thigh" pos="0 {y} -.1"><joint name="{side}_hip" axis="0 1 0"/>
            <inertial pos="0 0 -.1" mass="1" diaginertia=".01 .01 .01"/>
            <body name="{side}_shank" pos="0 0 -.2"><joint name="{side}_knee" axis="0 1 0"/>
            <inertial pos="0 0 -.1" mass="1" diaginertia=".01 .01 .01"/>
            <body name="{side}_foot" pos="0 0 -.2"><joint name="{side}_ankle" axis="0 1 0"/>
            <inertial pos="0 0 0" mass=".5" diaginertia=".001 .001 .001"/><geom {foot}/></body></body></body>"#
        )
    };
    let text = format!(
        r#"<mujoco model="biped"><asset><mesh name="part" file="part.stl"/></asset>
        <default><joint actuatorfrcrange="-{torque} {torque}"/></default><worldbody><geom type="plane" size="1 1 1"/>
        <body name="pelvis" pos="0 0 .6"><freejoint/><inertial pos="0 0 0" mass="3" diaginertia=".02 .02 .02"/><geom {trunk}/>
        {}{}</body></worldbody></mujoco>"#,
        leg("left", 0.1),
        leg("right", -0.1)
    );
    Robot::from_character(Character::from_mjcf(&text, "biped.xml", folder).unwrap(), Profile::default()).unwrap()
}

const BOX: &str = r#"type="box" size=".08 .04 .01""#;
const PICTURE: &str = r#"type="box" size=".08 .04 .01" contype="0" conaffinity="0""#;
const MESH: &str = r#"type="mesh" mesh="part""#;

#[track_caller]
fn says(readiness: &Readiness, severity: Severity, text: &str) {
    let found = readiness.problems.iter().any(|p| p.severity == severity && p.problem.contains(text));
    assert!(found, "{severity:?} '{text}' is not in {readiness:?}");
}

#[test]
fn our_robots_are_ready() {
    for name in lifelike_robot::load::NAMES {
        assert_eq!(Robot::load(name).unwrap().readiness(Shapes::Primitives).verdict(), "ready to train");
    }
    let sound = biped(BOX, BOX, 30.0);
    assert_eq!(sound.readiness(Shapes::Primitives), Readiness::default());
    sound.require_ready(Shapes::Primitives).unwrap();
}

#[test]
fn what_nothing_holds_up_cannot_be_trained() {
    for (geom, why) in [(PICTURE, "none of its 3 geoms collides"), (MESH, "none of its 3 geoms collides")] {
        let falling = biped(geom, geom, 30.0);
        let verdict = falling.readiness(Shapes::All).verdict();
        assert!(verdict.starts_with("cannot be trained: nothing of it can touch the ground: "), "{verdict}");
        assert!(verdict.contains(why) && verdict.contains("type box"), "{verdict}");
        let refused = falling.require_ready(Shapes::All).unwrap_err().to_string();
        assert!(refused.contains("biped") && refused.contains(&verdict), "{refused}");
    }
    let meshes = biped(MESH, MESH, 30.0).readiness(Shapes::Primitives);
    says(&meshes, Severity::Warning, "3 mesh geoms would collide, but their files are missing");

    let cylinder = r#"type="cylinder" size=".05 .02""#;
    assert!(biped(cylinder, cylinder, 30.0).readiness(Shapes::All).can_train());
    says(
        &biped(cylinder, cylinder, 30.0).readiness(Shapes::Primitives),
        Severity::CannotTrain,
        "not spheres, capsules or",
    );
    let lame = biped(BOX, PICTURE, 30.0).readiness(Shapes::Primitives);
    says(&lame, Severity::CannotTrain, "no geom of its feet (left_foot, right_foot)");
}

#[test]
fn feet_that_are_meshes_stand_on_the_boxes_around_them() {
    let folder = tempfile::tempdir().unwrap();
    let corners = ["-0.08 -0.04 -0.02", "0.08 0.04 0.02", "-0.08 0.04 0"].map(|corner| format!("vertex {corner}\n"));
    let facet = format!("facet normal 0 0 1\nouter loop\n{}endloop\nendfacet\n", corners.concat());
    std::fs::write(folder.path().join("part.stl"), format!("solid part\n{facet}endsolid part\n")).unwrap();
    let robot = biped_in(Some(folder.path()), MESH, MESH, 30.0);
    assert_eq!(robot.readiness(Shapes::Primitives), Readiness::default());
    for side in ["left", "right"] {
        let said = format!("mesh of '{side}_foot' touches as the box around it, 0.160 x 0.080 x 0.040 m");
        assert!(robot.notes.contains(&said), "{:?}", robot.notes);
    }
    for sole in robot.anatomy.soles.values() {
        assert_eq!(sole.corners.len(), 4);
        assert!(sole.corners.iter().all(|c| (c.x.abs() - 0.08).abs() < 1e-7 && (c.z + 0.02).abs() < 1e-7));
    }
    assert!(biped_in(Some(folder.path()), BOX, BOX, 30.0).notes.iter().all(|note| !note.contains("around it")));
}

#[test]
fn a_robot_that_lies_because_its_file_has_another_axis_up() {
    let mut lying = Character::clone(&biped(BOX, BOX, 30.0).character);
    // What was up is along y.
    lying.bodies[1].orientation = Quat::from_euler_angles(-std::f64::consts::FRAC_PI_2, 0.0, 0.0);
    let lying = Robot::from_character(lying, Profile::default()).unwrap();
    says(&lying.readiness(Shapes::Primitives), Severity::Warning, "its legs go along -y, not down, and z is up");
}

#[test]
fn legs_that_cannot_carry_the_weight_are_told() {
    // 8 kg at 0.4 m: standing takes about 19 N m by the rule of thumb.
    let verdict = |torque: f64| biped(BOX, BOX, torque).readiness(Shapes::Primitives);
    assert!(verdict(10.0).problems.is_empty());
    says(&verdict(2.0), Severity::Warning, "has 2.000 N m");
    assert!(verdict(2.0).verdict().starts_with("ready to train, with 1 warning"));
    says(&verdict(0.1), Severity::CannotTrain, "too weak");
}
