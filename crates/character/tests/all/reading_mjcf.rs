//! What is not understood is refused, and the error says where.
use std::f64::consts::FRAC_PI_2;

use lifelike_character::{Character, CharacterError, EqualityKind, GeomShape, Quat, Vec3};

fn read(text: &str) -> Result<Character, CharacterError> {
    Character::from_mjcf(text, "robot.xml", None)
}

/// Wraps the content of one moving body, which starts on line 4.
fn body(content: &str) -> String {
    format!("<mujoco>\n<worldbody>\n<body name=\"b\">\n{content}\n</body>\n</worldbody>\n</mujoco>")
}

#[track_caller]
fn refused(text: &str, expected: &str) {
    let error = read(text).expect_err("an error").to_string();
    assert!(error.contains(expected), "'{error}' does not say '{expected}'");
}

#[test]
fn errors_name_file_line_and_element() {
    let ball = "<geom size=\"0.1\"/>";
    refused(
        &body(&format!("{ball}\n<joint axis=\"0 0\"/>")),
        "robot.xml:5: <joint>: expected 3 numbers for 'axis', got '0 0'",
    );
    refused(
        &body(&format!("{ball}\n\n<joint range=\"a b\"/>")),
        "robot.xml:6: <joint>: expected 2 numbers for 'range', got 'a b'",
    );
    refused(&body("<geom size=\"-1\"/>"), "robot.xml:4: <geom>: expected 1 positive number(s) for 'size' of a sphere");
    refused(&body("<geom/>"), "robot.xml:4: <geom>: expected 1 positive number(s) for 'size'");
    refused(&body(&format!("{ball}<joint damping=\"-1\"/>")), "'damping' that is not negative");
    refused(&body(&format!("{ball}<joint axis=\"0 0 0\"/>")), "expected 'axis' with a direction");
    refused(
        &body("<inertial pos=\"0 0 0\" mass=\"1\"/>"),
        "expected attribute 'diaginertia' or 'fullinertia', got none",
    );
    refused(&body("<inertial mass=\"1\" diaginertia=\"1 1 1\"/>"), "expected attribute 'pos', got none");
    refused(
        &body("<inertial pos=\"0 0 0\" mass=\"1\" diaginertia=\"1 1 9\"/>"),
        "robot.xml:3: <body>: expected moments of inertia of body 'b'",
    );
    refused(&body("<joint/>"), "robot.xml:3: <body>: expected mass in the moving body 'b', got none");
    refused(&body("<geom size=\"1e400\"/>"), "for 'size', got '1e400'");
    refused(&body("<geom size=\"nan\"/>"), "for 'size', got 'nan'");
    refused(&body("<geom size=\"0.1\" quat=\"0 0 0 0\"/>"), "expected 'quat' that gives a direction");
    refused(
        &body("<geom size=\"0.1\" quat=\"1 0 0 0\" euler=\"1 2 3\"/>"),
        "expected one way to write the orientation",
    );
}

#[test]
fn what_would_change_the_dynamics_is_refused() {
    refused(
        "<mujoco><worldbody/><equality><joint joint1=\"a\"/></equality></mujoco>",
        "<joint>: expected the name of a joint for 'joint1', got 'a'",
    );
    refused("<mujoco><worldbody/><tendon><fixed/></tendon></mujoco>", "<fixed>: expected a path, got an empty tendon");
    refused("<mujoco><option windy=\"1\"/></mujoco>", "unsupported attribute 'windy'");
    refused("<mujoco><compiler fusestatic=\"true\"/></mujoco>", "unsupported attribute 'fusestatic'");
    refused("<mujoco><wheels/></mujoco>", "<wheels>: unsupported section");
    refused(&body("<geom size=\"0.1\" colour=\"red\"/>"), "unsupported attribute 'colour'");
    refused(&body("<geom size=\"0.1\"/><composite/>"), "<composite>: unsupported element in a body");
    let mesh = "<geom type=\"mesh\" mesh=\"m\" shellinertia=\"true\"/><joint/>";
    refused(&body(mesh), "unsupported 'shellinertia' of a mesh; give its <mesh> inertia=\"shell\"");
    let whole = "<attach>: unsupported element in a body; MuJoCo writes the whole model";
    refused(&body("<geom size=\"0.1\"/><attach model=\"m\" prefix=\"p\"/>"), whole);
    let linear = "'damping' with more than a linear term; keep its first number";
    refused(&body("<geom size=\"0.1\"/><joint damping=\"1 2\"/>"), linear);
    refused(&body("<geom type=\"box\" mesh=\"m\"/>"), "a box fitted to a mesh; give 'size' in its place");
    refused(&body("<freejoint align=\"true\"/><geom size=\"0.1\"/>"), "'align' that is true: it would move");
    refused(&body("<geom type=\"mesh\" mesh=\"m\"/><joint/>"), "expected <inertial> in body 'b'");
    refused(
        "<mujoco><include file=\"x.xml\"/></mujoco>",
        "robot.xml:1: <include>: unsupported include in a text without a folder",
    );
    refused("<robot/>", "expected root element 'mujoco', got 'robot'");
    refused("<mujoco><worldbody></mujoco>", "robot.xml:1: not well-formed XML");
}

#[test]
fn names_must_be_known_and_different() {
    let ball = "<geom size=\"0.1\"/>";
    refused(
        &body(&format!("{ball}<joint name=\"j\"/><joint name=\"j\"/>")),
        "expected a joint name that is not taken, got 'j'",
    );
    refused(
        "<mujoco><worldbody/><actuator>\n<motor joint=\"knee\"/></actuator></mujoco>",
        "robot.xml:2: <motor>: expected the name of a joint, got 'knee'",
    );
    refused(
        "<mujoco><worldbody/><contact><exclude body1=\"a\" body2=\"b\"/></contact></mujoco>",
        "name of a body for 'body1'",
    );
    refused(&body("<geom class=\"soft\" size=\"1\"/>"), "expected a default class (there are: main), got 'soft'");
    refused(
        "<mujoco><default><default class=\"a\"/><default class=\"a\"/></default></mujoco>",
        "expected a class name that is not taken",
    );
    let character = read(&body(ball)).unwrap();
    let error = character.joint("knee").unwrap_err().to_string();
    assert!(error.contains("no joint named 'knee'"), "{error}");
}

#[test]
fn limits_follow_autolimits() {
    let with = |compiler: &str, joint: &str| {
        let text = format!(
            "<mujoco><compiler angle=\"radian\" {compiler}/><worldbody><body><geom size=\"0.1\"/><joint {joint}/></body></worldbody></mujoco>"
        );
        read(&text).map(|c| c.joints[0].range)
    };
    assert_eq!(with("", "range=\"-1 2\"").unwrap(), Some((-1.0, 2.0)));
    assert_eq!(with("", "range=\"-1 2\" limited=\"false\"").unwrap(), None);
    assert_eq!(with("", "").unwrap(), None);
    assert_eq!(with("autolimits=\"false\"", "range=\"-1 2\" limited=\"true\"").unwrap(), Some((-1.0, 2.0)));
    assert!(with("autolimits=\"false\"", "range=\"-1 2\"").is_err());
    assert!(with("", "range=\"2 -1\"").is_err());
    assert!(with("", "limited=\"true\"").is_err());
}

#[test]
fn degrees_are_the_default_and_classes_are_inherited() {
    let text = r#"<mujoco>
      <default><joint range="0 90" damping="1"/><default class="stiff"><joint damping="2"/>
        <default class="stiffer"><joint stiffness="5"/></default></default></default>
      <worldbody><body childclass="stiff"><geom size="0.1"/>
        <joint name="a"/><joint name="b" class="stiffer"/><joint name="c" class="main" type="slide" range="0 90"/>
      </body></worldbody></mujoco>"#;
    let c = read(text).unwrap();
    let of = |name: &str| &c.joints[c.joint(name).unwrap()];
    assert_eq!(of("a").range, Some((0.0, FRAC_PI_2)));
    assert_eq!((of("a").damping, of("a").stiffness), (2.0, 0.0));
    assert_eq!((of("b").damping, of("b").stiffness), (2.0, 5.0));
    assert_eq!((of("c").damping, of("c").range), (1.0, Some((0.0, 90.0))));
}

#[test]
fn unnamed_things_get_names_of_their_own() {
    let c = read(&body("<freejoint/><geom size=\"0.1\"/><geom name=\"geom0\" size=\"0.1\"/><site/>")).unwrap();
    assert_eq!(c.joints[0].name, "b_free");
    assert_eq!(c.geoms[0].name, "geom0_");
    assert_eq!(c.sites[0].name, "site0");
}

#[test]
fn included_files_stand_where_the_include_stood() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(
        folder.path().join("arm.xml"),
        "<mujocoinclude>\n<body name=\"arm\">\n<geom size=\"x\"/></body></mujocoinclude>",
    )
    .unwrap();
    let text = "<mujoco><worldbody><include file=\"arm.xml\"/></worldbody></mujoco>";
    let load = || Character::from_mjcf(text, "main.xml", Some(folder.path()));
    let error = load().unwrap_err().to_string();
    assert!(error.contains("arm.xml:3: <geom>"), "{error}");
    std::fs::write(folder.path().join("arm.xml"), "<x><body name=\"arm\"><geom size=\"0.1\"/></body></x>").unwrap();
    let c = load().unwrap();
    assert_eq!(c.bodies[1].name, "arm");
    // What engines get needs no folder.
    let again = read(c.mjcf.as_deref().unwrap()).unwrap();
    assert_eq!((again.bodies, again.geoms), (c.bodies, c.geoms));
    std::fs::write(folder.path().join("arm.xml"), "<x><include file=\"arm.xml\"/></x>").unwrap();
    assert!(load().unwrap_err().to_string().contains("a file that was not included before"));
    std::fs::remove_file(folder.path().join("arm.xml")).unwrap();
    assert!(load().unwrap_err().to_string().contains("main.xml:1: <include>: expected a file that can be read"));
}

#[test]
fn a_missing_include_is_a_warning_where_the_model_stands_without_it() {
    let folder = tempfile::tempdir().unwrap();
    let load = |text: &str| Character::from_mjcf(text, "main.xml", Some(folder.path()));
    let sky = "<include file=\"common/sky.xml\"/>";
    let ball = "<body><geom size=\"0.1\" material=\"self\"/><joint/></body>";
    let model = |head: &str, body: &str| format!("<mujoco>\n{head}\n<worldbody>{body}</worldbody></mujoco>");

    let c = load(&model(&format!("{sky}<asset><include file=\"colours.xml\"/></asset>"), ball)).unwrap();
    assert_eq!((c.bodies.len(), c.warnings.len()), (2, 2), "{:?}", c.warnings);
    assert!(c.warnings[0].starts_with("main.xml:2: <include>: file 'common/sky.xml' is missing"), "{:?}", c.warnings);
    let again = read(c.mjcf.as_deref().unwrap()).unwrap();
    assert_eq!((again.bodies, again.warnings.len()), (c.bodies, 0), "engines get a text without the include");

    let error = |text: &str| load(text).unwrap_err().to_string();
    let undefined = error(&model(sky, "<body><geom class=\"soft\" size=\"0.1\"/></body>"));
    let expected =
        ["main.xml:3: <geom>", "'soft'", "file 'common/sky.xml', which main.xml:2: <include> includes, is missing"];
    assert!(expected.iter().all(|part| undefined.contains(part)), "{undefined}");
    let empty = error(&model(sky, "<geom type=\"plane\"/>"));
    assert!(empty.contains("main.xml:2: <include>: expected a file with the bodies"), "{empty}");
    for needed in [
        model("", &format!("{ball}{sky}")),
        model(&format!("<default>{sky}</default>"), ball),
        model(&format!("<actuator>{sky}</actuator>"), ball),
    ] {
        assert!(error(&needed).contains("expected a file that can be read"), "{needed}");
    }
    // The same from within a file that is there.
    std::fs::write(folder.path().join("arm.xml"), format!("<x>{sky}{ball}</x>")).unwrap();
    assert!(error(&model("", "<include file=\"arm.xml\"/>")).contains("expected a file that can be read"));
    std::fs::write(folder.path().join("head.xml"), format!("<x>{sky}</x>")).unwrap();
    assert_eq!(load(&model("<include file=\"head.xml\"/>", ball)).unwrap().warnings.len(), 1);
}

#[test]
fn meshes_are_pictures_where_their_files_are_absent() {
    let text = r#"<mujoco><asset><mesh name="m" file="m.stl"/><texture name="t" file="t.png"/><material name="x" texture="t"/></asset>
      <worldbody><body><inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/><joint/>
        <geom type="mesh" mesh="m" material="x"/><geom type="mesh" mesh="m" contype="0" conaffinity="0"/></body></worldbody></mujoco>"#;
    let c = read(text).unwrap();
    assert_eq!(c.geoms[0].shape, GeomShape::Mesh("m".into()));
    assert!(c.notes.iter().any(|n| n == "1 mesh geoms are pictures only"), "{:?}", c.notes);
    assert!(c.warnings.iter().any(|n| n.starts_with("1 mesh geoms would collide")), "{:?}", c.warnings);
    let engine = c.mjcf.unwrap();
    assert!(!engine.contains("m.stl") && !engine.contains("material") && !engine.contains("t.png"), "{engine}");
}

/// Frames that are not said are those of the reference position: by hand.
#[test]
fn equalities_hold_what_the_reference_position_holds() {
    let model = |equality: &str| {
        let text = format!(
            "<mujoco>\n<default><equality solref=\"0.01\"/><default class=\"soft\"><equality solimp=\".5 .6\" active=\"false\"/></default></default>\n\
             <worldbody><body name=\"a\" pos=\"0 0 1\" euler=\"0 0 90\"><joint/><geom size=\".1\"/><site name=\"s\" pos=\".1 0 0\"/></body>\n\
             <body name=\"b\" pos=\"2 0 1\"><joint/><geom size=\".1\"/><site name=\"t\" euler=\"0 0 90\"/></body></worldbody>\n\
             <equality>{equality}</equality></mujoco>"
        );
        read(&text)
    };
    let one = |equality: &str| model(equality).unwrap().equalities.remove(0);
    let near = |a: Vec3, b: [f64; 3]| (a - Vec3::from(b)).norm() < 1e-12;
    // x of `a` is y of the world.
    let ball = one("<connect body1=\"a\" body2=\"b\" anchor=\"1 0 0\"/>");
    assert_eq!(
        (ball.kind, ball.bodies, ball.active, ball.name.as_str()),
        (EqualityKind::Connect, [1, 2], true, "equality0")
    );
    assert!(near(ball.anchors[0], [1.0, 0.0, 0.0]) && near(ball.anchors[1], [-2.0, 1.0, 0.0]), "{ball:?}");
    assert_eq!((ball.solref, ball.solimp), ([0.01, 1.0], [0.9, 0.95, 0.001, 0.5, 2.0]));
    let ground = one("<connect body1=\"b\" anchor=\"0 0 -1\" class=\"soft\"/>");
    assert!(ground.bodies == [2, 0] && near(ground.anchors[1], [2.0, 0.0, 0.0]) && !ground.active, "{ground:?}");
    assert_eq!(ground.solimp, [0.5, 0.6, 0.001, 0.5, 2.0]);
    // The anchor of a weld is in its second body.
    let weld = one("<weld name=\"w\" body1=\"a\" body2=\"b\" anchor=\"0 0 1\" torquescale=\"0.5\"/>");
    assert_eq!((weld.kind, weld.name.as_str()), (EqualityKind::Weld { torque_scale: 0.5 }, "w"));
    assert!(near(weld.anchors[0], [0.0, -2.0, 1.0]) && near(weld.anchors[1], [0.0, 0.0, 1.0]), "{weld:?}");
    assert!((weld.orientations[0].scaled_axis() - Vec3::new(0.0, 0.0, -FRAC_PI_2)).norm() < 1e-12);
    assert_eq!(weld.orientations[1], Quat::identity());
    let posed = one("<weld body1=\"a\" body2=\"b\" relpose=\"1 2 3 0 0 0 2\" anchor=\"4 5 6\"/>");
    assert!(near(posed.anchors[0], [1.0, 2.0, 3.0]) && near(posed.anchors[1], [4.0, 5.0, 6.0]), "{posed:?}");
    assert!((posed.orientations[0].angle() - 2.0 * FRAC_PI_2).abs() < 1e-12);
    let unsaid = one("<weld body1=\"a\" body2=\"b\" relpose=\"1 2 3 0 0 0 0\" anchor=\"0 0 1\"/>");
    assert_eq!((unsaid.anchors, unsaid.orientations), (weld.anchors, weld.orientations));
    let sites = one("<weld site1=\"s\" site2=\"t\"/>");
    assert!(sites.bodies == [1, 2] && near(sites.anchors[0], [0.1, 0.0, 0.0]), "{sites:?}");
    assert!((sites.orientations[1].angle() - FRAC_PI_2).abs() < 1e-12);

    let refused = |equality: &str, expected: &str| {
        let error = model(equality).unwrap_err().to_string();
        assert!(error.contains(expected), "'{error}' does not say '{expected}'");
    };
    refused("<connect body1=\"a\" body2=\"b\"/>", "robot.xml:5: <connect>: expected attribute 'anchor', got none");
    refused("<connect body2=\"b\" anchor=\"0 0 0\"/>", "expected attribute 'body1', got none");
    refused("<weld body1=\"c\"/>", "robot.xml:5: <weld>: expected the name of a body for 'body1', got 'c'");
    refused("<weld body1=\"a\" relpose=\"0 0 0\"/>", "expected 7 numbers for 'relpose', got '0 0 0'");
    refused("<weld site1=\"s\" body2=\"b\"/>", "expected sites or bodies, got 'body2' beside a site");
    refused("<weld site1=\"s\"/>", "expected attribute 'site2', got none");
    refused("<connect body1=\"a\" anchor=\"0 0 0\" torquescale=\"1\"/>", "unsupported attribute 'torquescale'");
    refused("<tendon tendon1=\"a\"/>", "robot.xml:5: <tendon>: unsupported element in <equality>");
    refused(
        "<weld name=\"w\" body1=\"a\"/><weld name=\"w\" body1=\"b\"/>",
        "expected a equality name that is not taken",
    );
}

#[test]
fn a_position_servo_has_gains_and_may_inherit_its_range() {
    let text = body("<geom size=\"0.1\"/><joint name=\"j\" range=\"-60 20\"/>").replace(
        "</worldbody>",
        "</worldbody><actuator><position joint=\"j\" kp=\"7\" kv=\"2\" inheritrange=\"0.5\" gear=\"3\"/></actuator>",
    );
    let c = read(&text).unwrap();
    let a = &c.actuators[0];
    assert_eq!((a.gain, a.bias, a.gear), (7.0, [0.0, -7.0, -2.0], 3.0));
    let (low, high) = a.ctrl_range.unwrap();
    assert!((low.to_degrees() + 40.0).abs() < 1e-12 && high.abs() < 1e-12, "{low} {high}");
}
