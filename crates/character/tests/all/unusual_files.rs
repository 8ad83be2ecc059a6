//! Files as people have them: other encodings, roots, loops, macros, copies, tendons. Each is read as MuJoCo reads it, or refused
//! with the reason.
use lifelike_character::{Character, Quat, Vec3};

const INERTIAL: &str =
    r#"<inertial><mass value="1"/><inertia ixx="1e-2" iyy="1e-2" izz="1e-2" ixy="0" ixz="0" iyz="0"/></inertial>"#;

fn link(name: &str) -> String {
    format!("<link name=\"{name}\">{INERTIAL}</link>\n")
}

fn joint(name: &str, kind: &str, [parent, child]: [&str; 2], more: &str) -> String {
    format!(
        "<joint name=\"{name}\" type=\"{kind}\"><parent link=\"{parent}\"/><child link=\"{child}\"/>{more}</joint>\n"
    )
}

fn urdf(body: &str) -> Result<Character, String> {
    Character::from_urdf(&format!("<robot name=\"r\">\n{body}</robot>"), "r.urdf", None).map_err(|e| e.to_string())
}

fn mjcf(sections: &str, bodies: &str) -> Result<Character, String> {
    let text = format!("<mujoco>\n{sections}<worldbody>{bodies}</worldbody></mujoco>");
    Character::from_mjcf(&text, "r.xml", None).map_err(|e| e.to_string())
}

const LIMIT: &str = "<limit lower=\"-1\" upper=\"1\" effort=\"3\" velocity=\"2\"/>";

#[test]
fn a_root_with_a_floating_joint_is_the_world_whatever_its_name() {
    for root in ["world", "World", "odom"] {
        let body =
            format!("<link name=\"{root}\"/>{}{}", link("pelvis"), joint("root", "floating", [root, "pelvis"], ""));
        let c = urdf(&(body + &link("leg") + &joint("hip", "revolute", ["pelvis", "leg"], LIMIT))).unwrap();
        assert_eq!((c.nq, c.joints[0].name.as_str(), c.joints[1].name.as_str()), (8, "root", "hip"));
        assert_eq!(c.bodies[1].name, "pelvis");
    }
    // Through a fixed link, with a pose: the floating body begins there.
    let origin = "<origin xyz=\"1 0 0\" rpy=\"0 0 1.5707963267948966\"/>";
    let fixed = joint("w", "fixed", ["world", "odom"], origin);
    let root = joint("root", "floating", ["odom", "pelvis"], "<origin xyz=\"2 0 0.5\"/>");
    let c = urdf(&format!("<link name=\"world\"/><link name=\"odom\"/>{}{fixed}{root}", link("pelvis"))).unwrap();
    let pelvis = &c.bodies[c.body("pelvis").unwrap()];
    assert_eq!((pelvis.parent, c.nq), (0, 7));
    assert!((pelvis.position - Vec3::new(1.0, 2.0, 0.5)).norm() < 1e-12, "{}", pelvis.position);
    let quarter = Quat::from_euler_angles(0.0, 0.0, std::f64::consts::FRAC_PI_2);
    assert!(pelvis.orientation.angle_to(&quarter) < 1e-12);

    let hanging = joint("hip", "revolute", ["pelvis", "leg"], LIMIT) + &joint("lost", "floating", ["leg", "foot"], "");
    let error = urdf(&(link("pelvis") + &link("leg") + &link("foot") + &hanging)).unwrap_err();
    assert!(error.contains("expected a floating joint on links that do not move"), "{error}");
}

#[test]
fn links_that_do_not_hang_on_the_root_are_named() {
    let hip = joint("hip", "revolute", ["pelvis", "leg"], LIMIT);
    let error = urdf(&(link("pelvis") + &link("leg") + &hip + &link("lost"))).unwrap_err();
    assert!(error.starts_with("r.urdf:5: <link>: expected one link that is no joint's child"), "{error}");
    assert!(error.contains("'pelvis' has most links below it") && error.contains("1 more: 'lost'"), "{error}");

    let links = link("pelvis") + &link("leg") + &link("shank") + &link("foot");
    let ankle = joint("ankle", "revolute", ["shank", "foot"], LIMIT);
    for parent in ["shank", "foot"] {
        let knee = joint("knee", "revolute", [parent, "shank"], LIMIT);
        let error = urdf(&(links.clone() + &hip + &knee + &ankle)).unwrap_err();
        assert!(error.contains("expected links that all hang on the root 'pelvis'"), "{error}");
        assert!(error.contains("a loop of joints that carries 'foot', 'shank'"), "{error}");
    }
}

#[test]
fn an_element_that_stands_twice_is_refused() {
    let twice = format!("<link name=\"pelvis\">{INERTIAL}\n{INERTIAL}</link>");
    let error = urdf(&twice).unwrap_err();
    assert!(
        error.starts_with("r.urdf:3: <inertial>: expected one <inertial> in link 'pelvis', got a second one"),
        "{error}"
    );
    let hip = joint("hip", "revolute", ["pelvis", "leg"], &(LIMIT.to_string() + LIMIT));
    assert!(urdf(&(link("pelvis") + &link("leg") + &hip)).unwrap_err().contains("one <limit> in joint 'hip'"));
}

#[test]
fn limits_are_read_or_told() {
    let with = |kind: &str, limit: &str| {
        urdf(&(link("pelvis") + &link("leg") + &joint("hip", kind, ["pelvis", "leg"], limit)))
    };
    let c = with("revolute", LIMIT).unwrap();
    let hip = &c.joints[c.joint("hip").unwrap()];
    assert_eq!(
        (hip.range, hip.velocity_limit, hip.actuator_force_range),
        (Some((-1.0, 1.0)), Some(2.0), Some((-3.0, 3.0)))
    );
    assert!(c.warnings.is_empty(), "{:?}", c.warnings);
    // No range: it turns without end, and that is said; a continuous joint is meant to.
    for limit in
        ["", "<limit effort=\"3\" velocity=\"2\"/>", "<limit lower=\"1\" upper=\"1\" effort=\"3\" velocity=\"2\"/>"]
    {
        let c = with("revolute", limit).unwrap();
        assert_eq!(c.joints[1].range, None);
        assert!(
            c.warnings[0].contains("joints without a range") && c.warnings[0].ends_with(": hip"),
            "{:?}",
            c.warnings
        );
    }
    assert!(with("continuous", "").unwrap().warnings.is_empty());
    let zeros = with("continuous", "<limit effort=\"0\" velocity=\"0\"/>").unwrap();
    assert_eq!((zeros.joints[1].velocity_limit, zeros.joints[1].actuator_force_range), (None, None));
    assert!(zeros.warnings[0].contains("effort of hip (0), velocity of hip (0)"), "{:?}", zeros.warnings);
    let negative = with("continuous", "<limit effort=\"-60\" velocity=\"-1\"/>").unwrap();
    let said = "limits that are not above zero, which are ignored: effort of hip (-60), velocity of hip (-1)";
    assert!(negative.warnings[0].contains(said), "{:?}", negative.warnings);
    let error = with("revolute", "<limit lower=\"1\" upper=\"-1\" effort=\"3\" velocity=\"2\"/>").unwrap_err();
    assert!(error.contains("<limit>: expected 'lower' below 'upper' for joint 'hip', got 1 and -1"), "{error}");
}

#[test]
fn macros_are_called_macros() {
    let of = |attributes: &str, inside: &str| {
        let text = format!("<robot name=\"r\" {attributes}>\n{inside}</robot>");
        Character::from_urdf(&text, "r.xacro", None).unwrap_err().to_string()
    };
    let namespace = "xmlns:xacro=\"http://www.ros.org/wiki/xacro\"";
    for (attributes, inside) in [
        (namespace, "<xacro:include filename=\"leg.xacro\"/>".to_string()),
        ("", "<xacro:leg/>".to_string()),
        (namespace, format!("<link name=\"${{side}}_leg\">{INERTIAL}</link>")),
    ] {
        let error = of(attributes, &inside);
        assert!(error.starts_with("r.xacro:2: <xacro>: expected URDF without macros"), "{error}");
        assert!(error.contains("`xacro r.xacro > robot.urdf`"), "{error}");
    }
    // An expanded file still names the language.
    let text = format!("<robot name=\"r\" {namespace}>{}</robot>", link("pelvis"));
    assert!(Character::from_urdf(&text, "r.urdf", None).is_ok());
}

#[test]
fn a_file_may_begin_late_or_be_latin() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("r.urdf");
    let body = format!("<robot name=\"r\">{}</robot>", link("pelvis"));
    let write = |bytes: &[u8]| std::fs::write(&path, bytes).unwrap();
    write(format!("\n<?xml version=\"1.0\"?>\n{body}").as_bytes());
    assert_eq!(Character::load(&path).unwrap().mass(), 1.0);
    write(&[b"<?xml version=\"1.0\" encoding=\"ISO-8859-1\"?><!-- f\xfcr -->", body.as_bytes()].concat());
    assert_eq!(Character::load(&path).unwrap().mass(), 1.0);
    write(&[b"<!--\n f\xfcr -->", body.as_bytes()].concat());
    let error = Character::load(&path).unwrap_err().to_string();
    assert!(error.contains("r.urdf:2: ") && error.contains("byte 0xfc") && error.contains("ISO-8859-1"), "{error}");
    // Errors keep their lines behind a late declaration.
    write(b"\n<?xml version=\"1.0\"?>\n<robot name=\"r\"><link/></robot>");
    assert!(Character::load(&path).unwrap_err().to_string().contains("r.urdf:3: <link>"));
}

const PELVIS: &str = "<body name=\"pelvis\"><freejoint/><geom size=\".1\" mass=\"2\"/>\
    <body name=\"arm\"><joint name=\"a\" axis=\"0 1 0\"/><geom size=\".1\" mass=\"1\"/>\
    <body name=\"hand\"><joint name=\"b\" axis=\"0 1 0\"/><geom size=\".1\" mass=\"1\"/></body></body></body>";

#[test]
fn copies_are_moved_and_turned_one_after_the_other() {
    // As MuJoCo 4.0 compiles it: each copy half a metre ahead of the one before, and turned by 30 degrees more.
    let copies = "<replicate count=\"12\" offset=\".5 0 0\" euler=\"0 0 30\" sep=\"-\"><geom name=\"g\" size=\".01\"/></replicate>";
    let c = mjcf("", &(copies.to_string() + PELVIS)).unwrap();
    let geom = |name: &str| &c.geoms[c.geom(name).unwrap()];
    for (name, x, y, angle) in [
        ("g-00", 0.0, 0.0, 0.0),
        ("g-02", 0.933_012_7, 0.25, 60.0),
        ("g-05", 0.933_012_7, 1.616_025_4, 150.0),
        ("g-11", -0.433_012_7, 0.25, 330.0),
    ] {
        let geom = geom(name);
        assert!((geom.position - Vec3::new(x, y, 0.0)).norm() < 1e-7, "{name}: {}", geom.position);
        let expected = Quat::from_euler_angles(0.0, 0.0, f64::to_radians(angle));
        assert!(geom.orientation.angle_to(&expected) < 1e-7, "{name}");
    }
    let bodies = "<replicate count=\"3\" offset=\"0 0 .1\"><body name=\"b\"><joint name=\"k\"/><geom size=\".01\"/></body></replicate>";
    let c = mjcf("", bodies).unwrap();
    let names: Vec<&str> = c.joints.iter().map(|j| j.name.as_str()).collect();
    assert_eq!(names, ["k0", "k1", "k2"]);
    assert!(c.mjcf.unwrap().contains("name=\"b2\""), "the text for MuJoCo has the copies");
    let none = "<replicate count=\"0\" offset=\"0 0 .1\"><geom name=\"g\" size=\".01\"/></replicate>";
    assert!(mjcf("", &(none.to_string() + PELVIS)).unwrap().geom("g").is_err(), "no copy, as in MuJoCo");
    let many = "<replicate count=\"1000\"><replicate count=\"1000\"><geom size=\".1\"/></replicate></replicate>";
    assert!(mjcf("", many).unwrap_err().contains("at most 200000 elements of all copies"));
}

#[test]
fn tendons_without_forces_change_nothing_and_others_are_told() {
    let tendon = |attributes: &str| {
        format!(
            "<tendon><fixed name=\"t\" {attributes}><joint joint=\"a\" coef=\"1\"/><joint joint=\"b\" coef=\"-1\"/></fixed></tendon>"
        )
    };
    let c = mjcf(&tendon("stiffness=\"0\""), PELVIS).unwrap();
    assert!(
        c.warnings.is_empty() && c.notes.contains(&"1 tendons have neither stiffness nor limits".to_string()),
        "{:?}",
        c.notes
    );
    for (attributes, why) in
        [("stiffness=\"3\"", "t (stiffness)"), ("range=\"-1 1\" damping=\"2\"", "t (damping, range)")]
    {
        let c = mjcf(&tendon(attributes), PELVIS).unwrap();
        assert!(c.warnings[0].contains("tendons with forces") && c.warnings[0].ends_with(why), "{:?}", c.warnings);
    }
    let sites = PELVIS.replace("<freejoint/>", "<freejoint/><site name=\"s\"/>");
    assert!(mjcf("<tendon><spatial><site site=\"s\"/></spatial></tendon>", &sites).unwrap().warnings.is_empty());
}

#[test]
fn a_joint_that_follows_another_has_no_number_of_its_own() {
    let equality = |attributes: &str| format!("<equality><joint joint1=\"b\" joint2=\"a\" {attributes}/></equality>");
    let c = mjcf(&(equality("polycoef=\"0.1 2\"") + "<actuator><motor joint=\"a\"/></actuator>"), PELVIS).unwrap();
    let names: Vec<&str> = c.scalar_joints().map(|joint| joint.name.as_str()).collect();
    assert_eq!((c.nq, names, c.warnings.len()), (9, vec!["a"], 0));
    assert_eq!(c.couplings[0].polynomial, [0.1, 2.0, 0.0, 0.0, 0.0]);

    let driven = equality("") + "<actuator><motor joint=\"a\"/><motor joint=\"b\"/></actuator>";
    let c = mjcf(&driven, PELVIS).unwrap();
    assert_eq!((c.scalar_joints().count(), c.couplings.len()), (2, 1));
    assert!(c.warnings[0].contains("physics has the constraint, retargeting has not: b"), "{:?}", c.warnings);

    let round = equality("") + "<equality><joint joint1=\"a\" joint2=\"b\"/></equality>";
    let c = mjcf(&round, PELVIS).unwrap();
    assert_eq!((c.scalar_joints().count(), c.couplings.len(), c.warnings.len()), (1, 2, 1));

    let c = mjcf(&equality("active=\"false\""), PELVIS).unwrap();
    assert_eq!((c.scalar_joints().count(), c.couplings.len(), c.warnings.len()), (2, 0, 0));
    for (wrong, why) in [
        ("<equality><joint joint1=\"b\" joint2=\"b\"/></equality>", "two different joints"),
        ("<equality><joint joint1=\"b\" joint2=\"c\"/></equality>", "the name of a joint for 'joint2'"),
    ] {
        assert!(mjcf(wrong, PELVIS).unwrap_err().contains(why));
    }
}

#[test]
fn a_time_constant_and_a_damping_ratio_are_a_spring() {
    // A point of 2 kg at 0.5 m and its rotor: 2 · 0.25 + 0.1 + 0.4 · 2 · 0.01 of the sphere.
    let world = "<body><joint name=\"a\" axis=\"0 1 0\" springdamper=\"0.1 0.5\" armature=\"0.1\"/>\
        <geom size=\"0.1\" pos=\"0.5 0 0\" mass=\"2\"/></body>";
    let c = mjcf("", world).unwrap();
    let inertia = 0.5 + 0.1 + 0.008;
    assert!((c.joints[0].stiffness - inertia / (0.01 * 0.25)).abs() < 1e-9, "{}", c.joints[0].stiffness);
    assert!((c.joints[0].damping - 2.0 * inertia / 0.1).abs() < 1e-9);
    assert!(mjcf("", &world.replace("0.1 0.5", "0.1 0")).unwrap_err().contains("two positive numbers"));
}

/// MuJoCo 4.0 compiles it, with a limit that never acts.
#[test]
fn a_range_from_minus_infinity_to_infinity_limits_nothing() {
    let leg = |range: &str| {
        let joint = format!("<joint name=\"knee\" type=\"hinge\" axis=\"0 1 0\" range=\"{range}\"/>");
        mjcf("", &format!("<body name=\"leg\">{joint}<geom type=\"sphere\" size=\"0.1\"/></body>"))
    };
    for range in ["-inf inf", "-INF  Inf"] {
        assert_eq!(leg(range).unwrap().joints[0].range, None, "{range}");
    }
    assert!(leg("-90 90").unwrap().joints[0].range.is_some());
    assert!(leg("-1 inf").unwrap_err().contains("expected 2 numbers for 'range'"));
}

#[test]
fn the_keyframe_home_is_the_default_pose() {
    let key = |name: &str, qpos: &str| format!("<keyframe><key name=\"{name}\" qpos=\"{qpos}\"/></keyframe>");
    let c = mjcf(&key("home", "0 0 .7 1 0 0 0 .3 -.2"), PELVIS).unwrap();
    assert_eq!(c.home, Some(vec![0.0, 0.0, 0.7, 1.0, 0.0, 0.0, 0.0, 0.3, -0.2]));
    let other = mjcf(&key("squat", "0 0 .7 1 0 0 0 .3 -.2"), PELVIS).unwrap();
    assert!(
        other.home.is_none() && other.notes[0].contains("the default pose is the one named 'home'"),
        "{:?}",
        other.notes
    );
    assert!(mjcf(&key("home", "0 0 nan"), PELVIS).unwrap_err().contains("finite numbers for 'qpos'"));
    for name in ["home", "squat"] {
        let c = mjcf(&key(name, "0 0 .7 1 0 0 0"), PELVIS).unwrap();
        let said = format!("r.xml:2: <key>: expected 9 numbers for 'qpos' of keyframe '{name}', got 7");
        assert!(c.home.is_none() && c.warnings[0].contains(&said), "{:?}", c.warnings);
    }
}

#[test]
fn options_that_change_the_motion_are_told() {
    let warnings = |sections: &str| mjcf(sections, PELVIS).unwrap().warnings;
    let is = |sections: &str, text: &str| {
        let warnings = warnings(sections);
        assert!(warnings.len() == 1 && warnings[0].contains(text), "{warnings:?}");
    };
    is("<option><flag gravity=\"disable\"/></option>", "remove <flag gravity=\"disable\"/>");
    is("<option gravity=\"0 0 0\"/>", "set <option gravity=\"0 0 -9.81\"/>");
    is("<option><flag contact=\"disable\"/></option>", "contact is off in MuJoCo and on in our engine");
    is("<option density=\"1.2\" wind=\"1 0 0\"/>", "option density asks for forces of a fluid");
    assert!(warnings("<option gravity=\"0 0 -1.6\"><flag warmstart=\"disable\"/></option>").is_empty());
    // A body that a program moves is a fixed one.
    let target = format!("{PELVIS}<body name=\"target\" mocap=\"true\" pos=\"0 0 1\"><geom size=\".02\"/></body>");
    let c = mjcf("", &target).unwrap();
    assert_eq!((c.nq, c.bodies.len()), (9, 5));
    assert!(c.notes.iter().any(|note| note.contains("1 mocap bodies stay where they are")), "{:?}", c.notes);
}

#[test]
fn tendons_of_one_joint_drive_it_and_others_are_told() {
    let model = |coefficients: &[(&str, f64)], actuator: &str| {
        let joints: String =
            coefficients.iter().map(|(joint, c)| format!("<joint joint=\"{joint}\" coef=\"{c}\"/>")).collect();
        let tendon = format!("<tendon><fixed name=\"t\">{joints}</fixed></tendon>");
        mjcf(&format!("{tendon}<actuator>{actuator}</actuator>"), PELVIS).unwrap()
    };
    let servo = "<position name=\"servo\" tendon=\"t\" kp=\"90\" kv=\"3\" forcerange=\"-50 50\"/>";
    // The tendon's length is twice the angle, and its force acts at an arm of 2: gains times four, torque times two.
    let drive = model(&[("a", 2.0)], servo).drive(1).unwrap();
    assert_eq!((drive.stiffness, drive.damping, drive.torque), (360.0, 12.0, Some((-100.0, 100.0))));
    let c = model(&[("a", 1.0), ("b", -1.0)], servo);
    assert!(c.drive(1).is_none());
    assert!(c.warnings[0].contains("pull several joints by a tendon") && c.warnings[0].ends_with(": servo"));
    assert!(mjcf("<actuator><motor tendon=\"x\"/></actuator>", PELVIS).unwrap_err().contains("name of a tendon"));
    let push = "<general joint=\"a\" gear=\"2\" gainprm=\"80\" biastype=\"affine\" biasprm=\"5 -80 -4\"/>";
    let warnings = model(&[("a", 1.0)], push).warnings;
    assert!(warnings[0].contains("constant forces") && warnings[0].ends_with("a (10 N m)"), "{warnings:?}");
}

#[test]
fn ground_of_height_fields_is_told() {
    let field = "<asset><hfield name=\"h\" nrow=\"3\" ncol=\"3\" size=\"5 5 1 .1\"/></asset>";
    let c = mjcf(field, &format!("<geom type=\"hfield\" hfield=\"h\"/>{PELVIS}")).unwrap();
    assert!(c.warnings[0].contains("height fields are ground in MuJoCo alone"), "{:?}", c.warnings);
}

#[test]
fn document_types_are_read_and_pages_and_pointers_called_so() {
    let of = |text: &str| Character::from_urdf(text, "r.urdf", None).map(|c| c.mass()).map_err(|e| e.to_string());
    let body = format!("<robot name=\"r\">{}</robot>", link("pelvis"));
    assert_eq!(of(&format!("<!DOCTYPE robot>{body}")), Ok(1.0));
    let page = of("<!DOCTYPE html><html><body>404: Not Found</body></html>").unwrap_err();
    assert!(page.contains("expected root element") && page.contains("'html'"), "{page}");
    let pointer = of("version https://git-lfs.github.com/spec/v1\noid sha256:4d7a\nsize 12345\n").unwrap_err();
    assert!(pointer.contains("git lfs pull"), "{pointer}");
    // Entities that become a gigabyte are refused before they do.
    let mut bomb = "<!DOCTYPE robot [<!ENTITY a0 \"<link name='x'/>\">".to_string();
    for i in 1..12 {
        bomb += &format!("<!ENTITY a{i} \"{}\">", format!("&a{};", i - 1).repeat(10));
    }
    assert!(of(&format!("{bomb}]><robot name=\"r\">&a11;</robot>")).is_err());
}

/// A box of 20 by 10 by 10 cm with a dent in its upper side.
const DENTED: &str = "vertex=\"0 0 0 .2 0 0 .2 .1 0 0 .1 0 0 0 .1 .2 0 .1 .2 .1 .1 0 .1 .1 .1 .05 .03\" \
    face=\"0 2 1 0 3 2 0 1 5 0 5 4 1 2 6 1 6 5 2 3 7 2 7 6 3 0 4 3 4 7 4 5 8 5 6 8 6 7 8 7 4 8\"";

/// Mark of the box's corners alone.
const NO_FACES: &str = "no faces";

#[test]
fn meshes_weigh_what_mujoco_says() {
    let model = |mesh: &str, geom: &str| {
        let shape = if mesh == NO_FACES { DENTED.split("face").next().unwrap_or_default() } else { DENTED };
        let mesh = if mesh == NO_FACES { "" } else { mesh };
        let assets = format!("<asset><mesh name=\"m\" {shape} {mesh}/></asset>");
        let geom = format!("<geom type=\"mesh\" mesh=\"m\" pos=\".1 .2 .3\" euler=\"10 20 30\" {geom}/>");
        mjcf(&assets, &format!("<body name=\"b\"><freejoint/>{geom}</body>"))
    };
    // MuJoCo 4.0's body_mass, body_ipos and body_inertia.
    let legacy = ([0.172_968_11, 0.288_347_57, 0.336_256_66], [0.007_636_43, 0.007_221_78, 0.002_639_93]);
    let exact = ([0.171_605_44, 0.288_997_69, 0.332_569_63], [0.007_166_67, 0.006_671_32, 0.002_371_32]);
    let stretched = ([0.254_296_09, 0.342_756_09, 0.315_629_13], [0.051_893_4, 0.051_061_48, 0.005_273_18]);
    let surface = ([0.174_314_18, 0.287_705_36, 0.339_898_77], [0.649_632_45, 0.618_203, 0.288_421]);
    let hull = ([0.174_988_46, 0.287_383_67, 0.341_723_21], [0.008_333_33, 0.008_333_33, 0.003_333_33]);
    let moved = "refpos=\".5 .1 0\" refquat=\"1 1 0 0\"";
    let both = format!("{moved} scale=\"2 1 1\"");
    let times = |moments: [f64; 3], factor: f64| moments.map(|moment| moment * factor);
    for (mesh, geom, mass, com, moments) in [
        ("", "", 1.721_238_52, legacy.0, legacy.1),
        ("inertia=\"exact\"", "", 1.533_333_39, exact.0, exact.1),
        ("", "mass=\"3\"", 3.0, legacy.0, [0.013_309_77, 0.012_587_07, 0.004_601_21]),
        ("", "density=\"500\"", 0.860_619_26, legacy.0, times(legacy.1, 0.5)),
        ("scale=\"2 1 1\"", "", 3.438_439_43, stretched.0, stretched.1),
        ("", "contype=\"0\" conaffinity=\"0\"", 1.721_238_52, legacy.0, legacy.1),
        ("inertia=\"shell\"", "density=\"1\"", 0.109_411_21, surface.0, times(surface.1, 1e-3)),
        ("inertia=\"convex\"", "", 2.000_000_09, hull.0, hull.1),
        (NO_FACES, "", 2.000_000_09, hull.0, hull.1),
        (moved, "", 1.721_238_52, [-0.229_134_94, 0.010_602_02, 0.442_277_1], legacy.1),
        (both.as_str(), "", 3.438_439_43, [-0.554_582_87, -0.207_057_88, 0.524_178_49], stretched.1),
    ] {
        let read = model(mesh, geom).unwrap();
        // The text for engines has no pictures, and the same bodies.
        let again = Character::from_mjcf(read.mjcf.as_deref().unwrap(), "again", None).unwrap();
        for c in [&read, &again] {
            let inertial = &c.bodies[1].inertial;
            assert!((inertial.mass - mass).abs() < 1e-7 * mass, "{mesh} {geom}: {}", inertial.mass);
            assert!((inertial.com - Vec3::from(com)).norm() < 2e-8, "{mesh} {geom}: {}", inertial.com);
            let apart = (inertial.diagonal - Vec3::from(moments)).abs().max();
            assert!(apart < 1e-8, "{mesh} {geom}: {}", inertial.diagonal);
        }
    }
    let error = model("inertia=\"soft\"", "").unwrap_err();
    assert!(error.contains("inertia of its meshes is unknown") && error.contains("\"soft\""), "{error}");
    assert!(model("builtin=\"sphere\"", "").unwrap_err().contains("'builtin'"));
}

#[test]
fn shells_weigh_what_mujoco_says() {
    for (shape, mass, moments) in [
        ("sphere\" size=\".2", 502.654_824_574, [13.404_128_655, 13.404_128_655, 13.404_128_655]),
        ("capsule\" size=\".1 .3", 502.654_824_574, [29.112_091_923, 29.112_091_923, 4.607_669_225]),
        ("cylinder\" size=\".1 .3", 439.822_971_503, [19.006_635_554, 19.006_635_554, 4.084_070_45]),
        ("box\" size=\".1 .2 .3", 880.0, [54.133_333_333, 42.133_333_333, 24.266_666_667]),
        ("ellipsoid\" size=\".1 .2 .3", 489.719_333_337, [18.075_174_883, 14.068_366_576, 8.102_680_937]),
    ] {
        let geom = format!("<geom type=\"{shape}\" shellinertia=\"true\"/>");
        let body = mjcf("", &format!("<body name=\"b\"><freejoint/>{geom}</body>")).unwrap().bodies[1].inertial.clone();
        let apart = (body.diagonal - Vec3::from(moments)).abs().max();
        assert!((body.mass / mass - 1.0).abs() < 1e-9 && apart < 1e-8 * mass, "{shape}: {body:?}");
    }
}

#[test]
fn a_root_with_limbs_is_not_aligned() {
    let model = |align: &str| {
        let limb = "<body name=\"limb\" pos=\"0 0 .3\"><joint name=\"j\"/><geom size=\".1\"/></body>";
        let geom = "<geom type=\"box\" pos=\".1 .2 0\" euler=\"0 30 0\" size=\".1 .2 .3\"/>";
        mjcf("", &format!("<body name=\"b\" pos=\"0 0 1\"><freejoint {align}/>{geom}{limb}</body>")).unwrap()
    };
    // MuJoCo 4.0 aligns bodies without children.
    assert_eq!(model("align=\"true\"").bodies, model("").bodies);
}

#[test]
fn direct_current_motors_have_mujocos_law() {
    let drive = |default: &str, attributes: &str| {
        let sections = format!(
            "<default>{default}</default><actuator><dcmotor joint=\"a\" ctrlrange=\"-12 12\" {attributes}/></actuator>"
        );
        mjcf(&sections, PELVIS).map(|c| (c.actuators[0].gain, c.drive(1).unwrap()))
    };
    // MuJoCo 4.0's forces at 1 V and at 1 rad/s.
    for (default, attributes, per_volt, per_speed) in [
        ("", "motorconst=\"0.5 0.4\" resistance=\"2\" gear=\"20\"", 4.472_136, 40.0),
        ("", "motorconst=\"0.5\" resistance=\"2\"", 0.25, 0.125),
        ("", "nominal=\"24 3 100\"", 0.125, 0.03),
        ("<dcmotor motorconst=\"0.5\" resistance=\"2\"/>", "", 0.25, 0.125),
        ("", "motorconst=\"1\" resistance=\"2\"", 0.5, 0.5),
    ] {
        let (gain, drive) = drive(default, attributes).unwrap();
        let gear = if attributes.contains("gear") { 20.0 } else { 1.0 };
        assert!((gain * gear - per_volt).abs() < 1e-6 && (drive.damping - per_speed).abs() < 1e-9, "{attributes}");
        let (low, high) = drive.torque.unwrap();
        assert!((high - 12.0 * per_volt).abs() < 1e-5 && low == -high && drive.stiffness == 0.0, "{attributes}");
    }
    assert!(drive("", "motorconst=\"1\" resistance=\"2\" cogging=\"1 6 0\"").unwrap_err().contains("'cogging'"));
    assert!(drive("", "resistance=\"2\"").unwrap_err().contains("above zero"));
}

#[test]
fn settings_of_mujoco_in_a_urdf_act() {
    let cube = "<collision><geometry><box size=\"0.2 0.2 0.2\"/></geometry></collision>";
    let pelvis = link("pelvis").replace("</link>", &format!("{cube}</link>"));
    let mass =
        |settings: &str| urdf(&(format!("<mujoco>{settings}</mujoco>") + &pelvis)).unwrap().bodies[1].inertial.mass;
    assert_eq!(mass(""), 1.0);
    // A cube of 0.2 m at 1000 kg/m3.
    assert!((mass("<compiler inertiafromgeom=\"true\"/>") - 8.0).abs() < 1e-12);
    let moon = urdf(&("<mujoco><option gravity=\"0 0 -1.62\"/></mujoco>".to_string() + &link("pelvis"))).unwrap();
    assert_eq!(moon.gravity, Vec3::new(0.0, 0.0, -1.62));
}

#[test]
fn angles_beyond_a_turn_are_told() {
    let warnings_of = |rpy: &str| {
        let origin = format!("<origin rpy=\"{rpy}\"/>{LIMIT}");
        urdf(&(link("pelvis") + &link("leg") + &joint("hip", "revolute", ["pelvis", "leg"], &origin))).unwrap().warnings
    };
    assert!(
        warnings_of("0 90 0")[0].contains("looks like degrees") && warnings_of("0 90 0")[0].ends_with(": hip"),
        "{:?}",
        warnings_of("0 90 0")
    );
    assert!(warnings_of("0 -6.2831853 3.14159").is_empty());
}

#[test]
fn actuators_that_mujoco_switches_off_or_delays_are_told() {
    let body = format!("<body>{}<joint name=\"knee\" axis=\"0 1 0\"/><geom size=\".1\"/></body>", "");
    let with = |option: &str, more: &str| {
        let actuator = format!("<actuator><motor joint=\"knee\" group=\"2\" {more}/></actuator>");
        mjcf(&format!("{option}{actuator}"), &body).unwrap()
    };
    let off = with("<option actuatorgroupdisable=\"2\"/>", "");
    assert!(off.warnings[0].contains("actuators of group 2 are off in MuJoCo"), "{:?}", off.warnings);
    let late = with("", "delay=\".02\" nsample=\"5\"");
    assert!(late.notes[0].contains("actuator of 'knee' (motor) filters, integrates or delays"), "{:?}", late.notes);
    assert!(with("", "").notes.is_empty());
}

#[test]
fn a_pair_names_geoms_that_are_there() {
    let body = "<geom name=\"floor\" type=\"plane\" size=\"1 1 1\"/><body><freejoint/><geom name=\"ball\" size=\".1\"/></body>";
    let c = mjcf("<contact><pair geom1=\"floor\" geom2=\"ball\"/></contact>", body).unwrap();
    assert_eq!(c.pairs, [["floor".to_string(), "ball".to_string()]]);
    let error = mjcf("<contact><pair geom1=\"floor\" geom2=\"bal\"/></contact>", body).unwrap_err();
    assert!(error.contains("expected the name of a geom for 'geom2', got 'bal'"), "{error}");
}

#[test]
fn usd_is_called_usd() {
    let error = Character::from_urdf("#usda 1.0\n(\n)\n", "robot.usda", None).unwrap_err().to_string();
    assert!(error.contains("got USD, which is not read"), "{error}");
}
