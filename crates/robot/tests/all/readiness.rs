//! The verdict on a robot, before any time is spent on it.
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

    for round in [r#"type="cylinder" size=".05 .02""#, r#"type="ellipsoid" size=".08 .04 .02""#] {
        assert!(biped(round, round, 30.0).readiness(Shapes::Primitives).can_train(), "{round}");
    }
    let lame = biped(BOX, PICTURE, 30.0).readiness(Shapes::Primitives);
    says(&lame, Severity::CannotTrain, "no geom of its feet (left_foot, right_foot)");
    // Shanks that touch are no feet: MuJoCo's masks let the feet through the ground.
    let mismatch = r#"type="box" size=".08 .04 .01" contype="2" conaffinity="2""#;
    for foot in [PICTURE, mismatch] {
        let inertial = r#"mass="1" diaginertia=".01 .01 .01"/>"#;
        let shank = format!("{inertial}<geom type=\"capsule\" fromto=\"0 0 0 0 0 -.15\" size=\".03\"/>");
        let kneeling = built(|text| text.replace(BOX, foot).replace(inertial, &shank)).unwrap();
        says(&kneeling.readiness(Shapes::Primitives), Severity::CannotTrain, "no geom of its feet (left_foot");
    }
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

/// A biped whose numbers are changed in its text.
fn changed(change: impl Fn(&str) -> String) -> Readiness {
    built(change).unwrap().readiness(Shapes::Primitives)
}

/// The robot of [`changed`].
fn built(change: impl Fn(&str) -> String) -> Result<Robot, String> {
    let leg = |side: &str, y: f64| {
        format!(
            r#"<body name="{side}_thigh" pos="0 {y} -.1"><joint name="{side}_hip" axis="0 1 0" range="-1.8 1.2"/>
            <inertial pos="0 0 -.1" mass="1" diaginertia=".01 .01 .01"/>
            <body name="{side}_shank" pos="0 0 -.2"><joint name="{side}_knee" axis="0 1 0" range="0 2.3"/>
            <inertial pos="0 0 -.1" mass="1" diaginertia=".01 .01 .01"/>
            <body name="{side}_foot" pos="0 0 -.2"><joint name="{side}_ankle" axis="0 1 0" range="-.8 .8"/>
            <inertial pos="0 0 0" mass=".5" diaginertia=".001 .001 .001"/><geom {BOX}/></body></body></body>"#
        )
    };
    let text = format!(
        r#"<mujoco model="biped"><compiler angle="radian"/><option gravity="0 0 -9.81"/>
        <default><joint actuatorfrcrange="-30 30"/></default><worldbody><geom type="plane" size="1 1 1"/>
        <body name="pelvis" pos="0 0 .6"><freejoint/><inertial pos="0 0 0" mass="3" diaginertia=".02 .02 .02"/>
        {}{}</body></worldbody></mujoco>"#,
        leg("left", 0.1),
        leg("right", -0.1)
    );
    let character = Character::from_mjcf(&change(&text), "biped.xml", None).unwrap();
    Robot::from_character(character, Profile::default()).map_err(|error| error.to_string())
}

#[test]
fn what_is_not_the_robot_is_not_weighed_and_has_no_joints() {
    let beside = |body: &str| built(|text| text.replace("</worldbody>", &format!("{body}</worldbody>")));
    // A table of 800 kg: 1 m by 1 m by 0.8 m at 1000 kg/m3.
    let table = "<body name=\"table\" pos=\"2 0 .4\"><geom type=\"box\" size=\".5 .5 .4\"/></body>";
    let with_table = beside(table).unwrap();
    assert!((with_table.character.mass() - 8.0).abs() < 1e-12, "{} kg", with_table.character.mass());
    // MuJoCo compiles it as the obstacle that it is as a geom of the world.
    let verdict = with_table.readiness(Shapes::Primitives).verdict();
    assert!(verdict.contains("of 'table' is fixed to the world"), "{verdict}");
    assert!(with_table.readiness(Shapes::All).can_train());
    let seen = beside(&table.replace("<geom", "<geom contype=\"0\" conaffinity=\"0\"")).unwrap();
    assert_eq!(seen.readiness(Shapes::Primitives).verdict(), "ready to train");
    let door = "<body name=\"door\"><joint name=\"hinge\" axis=\"0 0 1\"/><geom size=\".1\"/></body>";
    let error = beside(door).unwrap_err();
    assert!(error.contains("expected all joints on its base 'pelvis', got 'hinge' of 'door'"), "{error}");
    let ball = "<body name=\"ball\"><freejoint/><geom size=\".1\"/></body>";
    let error = beside(ball).unwrap_err();
    assert!(error.contains("got 2:") && error.ends_with("leave only the robot in its file"), "{error}");
}

#[test]
fn ground_that_our_engine_refuses_is_told_before_training() {
    let plane = |other: &'static str| move |text: &str| text.replace("<geom type=\"plane\" size=\"1 1 1\"/>", other);
    for (ground, why) in [
        ("<geom name=\"slope\" type=\"plane\" size=\"1 1 1\" euler=\"0 .3 0\"/>", "the plane 'slope' is not level"),
        ("<geom name=\"floor\" type=\"box\" size=\"1 1 1\" pos=\"0 0 -1\"/>", "'floor' is fixed to the world"),
        (
            "<geom type=\"plane\" size=\"1 1 1\"/><geom name=\"b\" type=\"plane\" size=\"1 1 1\"/>",
            "'b' is a second plane",
        ),
    ] {
        let robot = built(plane(ground)).unwrap();
        says(&robot.readiness(Shapes::Primitives), Severity::CannotTrain, why);
        assert!(robot.readiness(Shapes::All).can_train(), "MuJoCo has it: {why}");
    }
    let high = "<geom type=\"plane\" size=\"1 1 1\" pos=\"0 0 .3\"/>";
    assert!(changed(plane(high)).can_train());
}

#[test]
fn contacts_by_pairs_are_named_where_nothing_else_touches() {
    let robot = built(|text| {
        let text = text.replace(BOX, PICTURE).replacen("<geom type=\"box\"", "<geom name=\"foot\" type=\"box\"", 1);
        let text = text.replace("<geom type=\"plane\"", "<geom name=\"floor\" type=\"plane\"");
        text.replace("</worldbody>", "</worldbody><contact><pair geom1=\"floor\" geom2=\"foot\"/></contact>")
    });
    let robot = robot.unwrap();
    says(&robot.readiness(Shapes::Primitives), Severity::CannotTrain, "its contacts are pairs (<pair>)");
    says(&robot.readiness(Shapes::Primitives), Severity::Warning, "act in MuJoCo alone (floor and foot)");
    assert!(robot.readiness(Shapes::All).can_train(), "{:?}", robot.readiness(Shapes::All));
}

#[test]
fn numbers_of_other_units_are_called_so() {
    assert_eq!(changed(str::to_string), Readiness::default());
    let refused = |change: &dyn Fn(&str) -> String, words: &[&str]| {
        let readiness = changed(change);
        let verdict = readiness.verdict();
        assert!(!readiness.can_train() && words.iter().all(|word| verdict.contains(word)), "{words:?}: {verdict}");
    };
    let grams = |text: &str| text.replace("mass=\"1\"", "mass=\"1000\"").replace("mass=\"3\"", "mass=\"3000\"");
    refused(&grams, &["masses look like grams", "weighs 7001", "masses in kg"]);
    let millimetres = |text: &str| text.replace(" -.2\"", " -200\"").replace(" -.1\"", " -100\"");
    refused(&millimetres, &["lengths look like millimetres", "weighs 8.000000 kg"]);
    // 1.8 rad as 103 degrees, read as radians; and radians read as degrees.
    let degrees =
        |text: &str| text.replace("-1.8 1.2", "-103 69").replace("0 2.3", "0 132").replace("-.8 .8", "-46 46");
    refused(&degrees, &["more than two turns", "left_knee (0.0000 to 132.0000 rad)", "write them in radians"]);
    let radians = |text: &str| text.replace("<compiler angle=\"radian\"/>", "");
    refused(&radians, &["can hardly move", "left_knee (0.0000 to 0.0401 rad)", "set <compiler angle=\"radian\"/>"]);
    let sideways = |text: &str| text.replace("gravity=\"0 0 -9.81\"", "gravity=\"0 -9.81 0\"");
    refused(&sideways, &["its gravity is 0 -9.81 0 m/s2: not down"]);
    // One joint is a doubt, not a mistake of units; a slope is none.
    let one = |text: &str| text.replacen("-.8 .8", "-46 46", 1);
    says(
        &changed(one),
        Severity::Warning,
        "more than two turns, which look like degrees taken for radians: left_ankle",
    );
    let endless = |text: &str| text.replace("-.8 .8", "-1e16 1e16");
    assert_eq!(changed(endless), Readiness::default());
    let slope = |text: &str| text.replace("gravity=\"0 0 -9.81\"", "gravity=\"-1.7 0 -9.66\"");
    assert_eq!(changed(slope), Readiness::default());
    for other in ["-1.62", "-3.7", "-981", "0"] {
        let there = |text: &str| text.replace("gravity=\"0 0 -9.81\"", &format!("gravity=\"0 0 {other}\""));
        says(&changed(there), Severity::Warning, &format!("its gravity is 0 0 {other} m/s2, not the earth's"));
    }
    // 0.01 kg m2 as kg mm2 and as kg cm2: of 1 kg at 0.58 m from the root, 100 m and 10 m wide.
    for (moment, radius) in [("10000", "100.000 m"), ("100", "10.000 m")] {
        let wide = |text: &str| text.replacen(".01 .01 .01", &[moment; 3].join(" "), 1);
        refused(&wide, &["left_thigh", radius, "write inertias in kg m2"]);
    }
    // 0.5 kg with 0.5 kg m2: wider than the robot, and less than the robot's mass has there.
    let doubt = |text: &str| text.replacen(".001 .001 .001", ".5 .5 .5", 1);
    says(&changed(doubt), Severity::Warning, "left_foot (0.5 kg m2 with 0.5 kg: a radius of gyration of 1.000 m)");
    let none =
        |text: &str| text.replace("<option gravity=\"0 0 -9.81\"/>", "<option><flag gravity=\"disable\"/></option>");
    says(&changed(none), Severity::Warning, "remove <flag gravity=\"disable\"/>");
}

#[test]
fn torques_that_no_motor_has_are_placeholders() {
    for torque in ["100000", "1000"] {
        let placeholder = |text: &str| text.replace("-30 30", &format!("-{torque} {torque}"));
        let readiness = changed(placeholder);
        says(&readiness, Severity::Warning, &format!("left_hip ({torque} N m)"));
    }
    // Ten times what standing takes is much, and what a strong robot has.
    assert_eq!(changed(|text| text.replace("-30 30", "-150 150")), Readiness::default());
}

#[test]
fn a_speed_limit_of_the_file_is_the_actuators() {
    let text = r#"<robot name="r"><link name="base"><inertial><mass value="1"/><inertia ixx="1e-2" iyy="1e-2" izz="1e-2"
        ixy="0" ixz="0" iyz="0"/></inertial></link><link name="arm"><inertial><mass value="1"/><inertia ixx="1e-2" iyy="1e-2"
        izz="1e-2" ixy="0" ixz="0" iyz="0"/></inertial></link><joint name="a" type="revolute"><parent link="base"/>
        <child link="arm"/><limit lower="-1" upper="1" effort="3" velocity="12"/></joint></robot>"#;
    let robot = |text: &str| {
        Robot::from_character(Character::from_urdf(text, "r.urdf", None).unwrap(), Profile::default()).unwrap()
    };
    let p = robot(text).actuators.parameters[0];
    assert_eq!((p.velocity_max, p.full_torque_velocity, p.torque_max), (12.0, 4.0, 3.0));
    let p = robot(&text.replace("velocity=\"12\"", "")).actuators.parameters[0];
    assert_eq!((p.velocity_max, p.full_torque_velocity), (30.0, 10.0));
}

#[test]
fn speeds_in_degrees_and_compensated_gravity_are_told() {
    let text = |velocity: &str| {
        let link = |name: &str| {
            let inertia = r#"<inertia ixx="1e-2" iyy="1e-2" izz="1e-2" ixy="0" ixz="0" iyz="0"/>"#;
            format!("<link name=\"{name}\"><inertial><mass value=\"1\"/>{inertia}</inertial></link>")
        };
        let limit = format!("<limit lower=\"-1\" upper=\"1\" effort=\"3\" velocity=\"{velocity}\"/>");
        let joint = "<joint name=\"a\" type=\"revolute\"><parent link=\"base\"/><child link=\"arm\"/>";
        format!("<robot name=\"r\">{}{}{joint}{limit}</joint></robot>", link("base"), link("arm"))
    };
    let readiness = |velocity: &str| {
        let character = Character::from_urdf(&text(velocity), "r.urdf", None).unwrap();
        Robot::from_character(character, Profile::default()).unwrap().readiness(Shapes::Primitives)
    };
    says(&readiness("600"), Severity::Warning, "look like degrees per second: a (600 rad/s)");
    assert!(readiness("30").problems.iter().all(|p| !p.problem.contains("per second")));
    let lifted = |text: &str| text.replace("<body name=\"left_foot\"", "<body gravcomp=\"1\" name=\"left_foot\"");
    says(&changed(lifted), Severity::CannotTrain, "gravcomp of 'left_foot'");
}

#[test]
fn a_home_beyond_the_ranges_is_clamped_and_told() {
    let key = |angle: f64| {
        let key =
            format!("<keyframe><key name=\"home\" qpos=\"0 0 .6 1 0 0 0 0 {angle} 0 0 0 0\"/></keyframe></mujoco>");
        move |text: &str| text.replace("</mujoco>", &key)
    };
    says(&changed(key(2.9)), Severity::Warning, "clamped: left_knee (2.9 beyond 0.0000 to 2.3000)");
    assert_eq!(changed(key(2.3)), Readiness::default());
}

#[test]
fn rates_that_no_robot_has_are_refused() {
    let with = |profile: &str| {
        let profile = Profile::from_toml(profile, Path::new("r.toml")).unwrap();
        let character = biped(BOX, BOX, 30.0).character;
        Robot::from_character(character, profile).map(|robot| robot.substeps).map_err(|e| e.to_string())
    };
    assert!(
        with("physics_hz = 1e9\n").unwrap_err().contains("physics_hz: expected a rate above 0 and at most 20000 Hz")
    );
    assert!(
        with("control_hz = 1e9\n").unwrap_err().contains("control_hz: expected a rate above 0 and at most 2000 Hz")
    );
    assert_eq!(with("physics_hz = 1000\n"), Ok(20));
}

#[test]
fn four_legs_are_told_from_two() {
    let leg = |name: &str, x: f64, y: f64| {
        format!(
            r#"<body name="{name}_thigh" pos="{x} {y} 0"><joint name="{name}_hip" axis="0 1 0"/><geom size=".03" mass=".5"/>
            <body name="{name}_calf" pos="0 0 -.2"><joint name="{name}_knee" axis="0 1 0"/>
            <geom type="capsule" fromto="0 0 0 0 0 -.2" size=".02" mass=".3"/></body></body>"#
        )
    };
    let readiness = |legs: &[(&str, f64, f64)]| {
        let legs: String = legs.iter().map(|(name, x, y)| leg(name, *x, *y)).collect();
        let text = format!(
            r#"<mujoco><worldbody><body name="trunk" pos="0 0 .42"><freejoint/><geom type="box" size=".2 .1 .05" mass="6"/>
            {legs}</body></worldbody></mujoco>"#
        );
        let character = Character::from_mjcf(&text, "dog.xml", None).unwrap();
        Robot::from_character(character, Profile::default()).unwrap().readiness(Shapes::Primitives)
    };
    let four = [("FL", 0.2, 0.1), ("FR", 0.2, -0.1), ("RL", -0.2, 0.1), ("RR", -0.2, -0.1)];
    says(&readiness(&four), Severity::Warning, "it has 4 legs");
    let two = readiness(&[("left", 0.0, 0.1), ("right", 0.0, -0.1)]);
    assert!(two.problems.iter().all(|p| !p.problem.contains("legs:")), "{two:?}");
}
