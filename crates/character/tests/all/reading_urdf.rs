//! What files of real robots have and no simulation can do, put right and said.
use std::path::Path;

use lifelike_character::{Character, GeomShape, Kinematics, Vec3};

const INERTIA: &str = r#"<inertia ixx="1e-3" iyy="1e-3" izz="1e-3" ixy="0" ixz="0" iyz="0"/>"#;

fn link(name: &str, mass: f64) -> String {
    format!(r#"<link name="{name}"><inertial><mass value="{mass}"/>{INERTIA}</inertial></link>"#)
}

fn joint(name: &str, [parent, child]: [&str; 2], more: &str) -> String {
    format!(
        r#"<joint name="{name}" type="revolute"><origin xyz="0 0 0.1"/><parent link="{parent}"/><child link="{child}"/><axis xyz="0 1 0"/>
        <limit lower="-1" upper="1" effort="3" velocity="1"/>{more}</joint>"#
    )
}

fn read(parts: &[String], folder: Option<&Path>) -> Character {
    let text = format!("<robot name=\"r\">{}</robot>", parts.concat());
    Character::from_urdf(&text, "r.urdf", folder).unwrap()
}

fn moving(character: &Character) -> Vec<&str> {
    character.scalar_joints().map(|joint| joint.name.as_str()).collect()
}

fn warned(character: &Character, words: &str) -> bool {
    character.warnings.iter().any(|warning| warning.contains(words))
}

#[test]
fn a_joint_that_mimics_follows() {
    let mimic = r#"<mimic joint="finger" multiplier="-1" offset="0.5"/>"#;
    let second = r#"<mimic joint="thumb" multiplier="2" offset="0.1"/>"#;
    let c = read(
        &[
            link("palm", 1.0),
            link("a", 0.1),
            link("b", 0.1),
            link("c", 0.1),
            joint("finger", ["palm", "a"], ""),
            joint("thumb", ["palm", "b"], mimic),
            joint("tip", ["b", "c"], second),
        ],
        None,
    );
    assert_eq!((moving(&c), c.nv), (vec!["finger"], 9));
    assert_eq!(c.couplings[0].polynomial, [0.5, -1.0, 0.0, 0.0, 0.0]);
    // The thumb turns by 0.5 - 0.2 about y, and the tip by 2 · 0.3 + 0.1 more.
    let mut kinematics = Kinematics::new(&c);
    let mut q = c.reference_position();
    q[c.joints[c.joint("finger").unwrap()].q_index] = 0.2;
    kinematics.update(&c, &q);
    let up = |body: &str| kinematics.body_orientation[c.body(body).unwrap()] * Vec3::z();
    assert!((up("b") - Vec3::new(0.3_f64.sin(), 0.0, 0.3_f64.cos())).norm() < 1e-12);
    assert!((up("c") - Vec3::new(1.0_f64.sin(), 0.0, 1.0_f64.cos())).norm() < 1e-12);
}

#[test]
fn of_a_gear_and_the_leg_that_it_drives_the_leg_leads() {
    let mimic = r#"<mimic joint="gear" multiplier="0.5" offset="0.1"/>"#;
    let parts = |leg: f64| {
        [
            link("trunk", 5.0),
            link("wheel", 0.1),
            link("leg", leg),
            joint("gear", ["trunk", "wheel"], ""),
            joint("hip", ["trunk", "leg"], mimic),
        ]
    };
    let heavy = read(&parts(2.0), None);
    assert_eq!(moving(&heavy), ["hip"]);
    // hip = gear / 2 + 0.1, so gear = 2 hip - 0.2.
    assert_eq!(heavy.couplings[0].polynomial, [-0.2, 2.0, 0.0, 0.0, 0.0]);
    assert!(warned(&heavy, "joint 'hip' carries more than 'gear', which it mimics: it leads"));
    assert_eq!(moving(&read(&parts(0.15), None)), ["gear"]);
}

#[test]
fn who_mimics_itself_or_nobody() {
    let parts = |mimic: &str| [link("a", 1.0), link("b", 1.0), joint("j", ["a", "b"], mimic)].concat();
    let itself = format!("<robot name=\"r\">{}</robot>", parts("<mimic joint=\"j\"/>"));
    let error = Character::from_urdf(&itself, "r.urdf", None).unwrap_err().to_string();
    assert!(error.contains("not mimic each other in a circle, got 'j' mimics 'j'"), "{error}");
    let circle = [
        [link("a", 1.0), link("b", 1.0), link("c", 1.0)].concat(),
        joint("left", ["a", "b"], "<mimic joint=\"right\"/>") + &joint("right", ["a", "c"], "<mimic joint=\"left\"/>"),
    ];
    let circle = format!("<robot name=\"r\">{}</robot>", circle.concat());
    let error = Character::from_urdf(&circle, "r.urdf", None).unwrap_err().to_string();
    assert!(error.contains("'right' mimics 'left' mimics 'right'"), "{error}");
    let nobody = read(&[parts("<mimic joint=\"left_j\"/>")], None);
    assert!(moving(&nobody).is_empty() && warned(&nobody, "joint 'j' mimics 'left_j', which there is not: held"));
}

#[test]
fn moments_that_no_body_has_are_replaced() {
    let body = |name: &str, inertia: &str| {
        format!(r#"<link name="{name}"><inertial><mass value="2"/><inertia {inertia}/></inertial></link>"#)
    };
    let c = read(
        &[
            body("sound", r#"ixx="3" iyy="4" izz="5" ixy="0" ixz="0" iyz="0""#),
            // 1 and 1 cannot bear 10; xy larger than what it is mixed of; a point.
            body("rod", r#"ixx="10" iyy="1" izz="1" ixy="0" ixz="0" iyz="0""#),
            body("mixed", r#"ixx="1" iyy="1" izz="1" ixy="2" ixz="0" iyz="0""#),
            body("point", r#"ixx="0" iyy="0" izz="0" ixy="1e-20" ixz="0" iyz="0""#),
            joint("j1", ["sound", "rod"], ""),
            joint("j2", ["sound", "mixed"], ""),
            joint("j3", ["sound", "point"], ""),
        ],
        None,
    );
    assert!(warned(&c, "moments of inertia that no body has were replaced, of links: rod, mixed, point"));
    let moments = |body: &str| c.bodies[c.body(body).unwrap()].inertial.diagonal;
    assert!(!warned(&c, "without ixy"));
    let plain = read(&[body("plain", r#"ixx="3" iyy="4" izz="5" ixy="0" iyz="0""#)], None);
    assert!(warned(&plain, "without ixy, ixz or iyz, which are taken for zero, of links: plain"));
    assert!((moments("sound") - Vec3::new(5.0, 4.0, 3.0)).norm() < 1e-12);
    assert!((moments("rod") - Vec3::repeat(4.0)).norm() < 1e-12);
    assert!((moments("mixed") - Vec3::repeat(1.0)).norm() < 1e-12);
    assert!((moments("point") - Vec3::repeat(0.4 * 2.0 * 1e-4)).norm() < 1e-18);
}

#[test]
fn what_weighs_nothing_carries_or_is_held() {
    let virtual_link = |name: &str| format!("<link name=\"{name}\"/>");
    let c = read(
        &[
            link("shank", 3.0),
            virtual_link("ankle"),
            link("foot", 1.0),
            virtual_link("camera"),
            joint("ankle_z", ["shank", "ankle"], ""),
            joint("ankle_x", ["ankle", "foot"], ""),
            joint("pan", ["shank", "camera"], ""),
        ],
        None,
    );
    assert_eq!(moving(&c), ["ankle_z", "ankle_x"]);
    assert!(warned(&c, "links that move and weigh nothing weigh next to nothing now: ankle"));
    assert!(warned(&c, "joints that move nothing that weighs are held: pan"));
    assert!((c.mass() - 4.0).abs() < 1e-4 && c.mass() > 4.0);
    let broken = "<robot name=\"r\"><link name=\"a\"><inertial><mass value=\"much\"/></inertial></link></robot>";
    assert!(Character::from_urdf(broken, "r.urdf", None).unwrap_err().to_string().contains("'much'"));
}

/// Two points at the corners of a box, and a third.
fn stl(low: [f64; 3], high: [f64; 3]) -> String {
    let point = |p: [f64; 3]| format!("vertex {} {} {}\n", p[0], p[1], p[2]);
    let points = [point(low), point(high), point([low[0], high[1], low[2]])].concat();
    format!("solid s\nfacet normal 0 0 1\nouter loop\n{points}endloop\nendfacet\nendsolid s\n")
}

/// The robot of `package/urdf/r.urdf`: a trunk, and a foot whose mesh is said by `uri`, turned by a quarter about z.
fn with_foot(folder: &Path, uri: &str, scale: &str) -> Character {
    with_foot_that_is("collision", "", folder, uri, scale)
}

fn with_foot_that_is(what: &str, trunk: &str, folder: &Path, uri: &str, scale: &str) -> Character {
    let foot = format!(
        r#"<link name="foot"><inertial><mass value="1"/>{INERTIA}</inertial><{what}><origin xyz="0 0 -0.05" rpy="0 0 1.5707963267948966"/>
        <geometry><mesh filename="{uri}" scale="{scale}"/></geometry></{what}></link>"#
    );
    let far = joint("knee", ["trunk", "foot"], "").replace("0 0 0.1", "0 0 -0.8");
    let trunk = link("trunk", 5.0).replace("</link>", &format!("{trunk}</link>"));
    read(&[trunk, foot, far], Some(folder))
}

#[test]
fn a_foot_that_is_a_mesh_gets_the_box_around_it() {
    let folder = tempfile::tempdir().unwrap();
    let urdf = folder.path().join("my_robot/urdf");
    std::fs::create_dir_all(&urdf).unwrap();
    std::fs::create_dir_all(folder.path().join("my_robot/meshes")).unwrap();
    std::fs::write(folder.path().join("my_robot/meshes/foot.STL"), stl([-60., -40., -30.], [140., 50., 10.])).unwrap();
    for uri in ["package://my_robot/meshes/foot.STL", "package:///my_robot/meshes/foot.STL", "../meshes/foot.STL"] {
        let mut c = with_foot(&urdf, uri, "0.001 0.001 0.001");
        assert!(c.warnings.is_empty(), "{uri}: {:?}", c.warnings);
        let foot = c.body("foot").unwrap();
        let touches = |c: &Character| c.geoms.iter().filter(|g| g.contype != 0).count();
        assert_eq!(touches(&c), 0, "a mesh touches nothing");
        let fitted = c.fit_boxes(&[foot]);
        assert!((fitted[0].size - Vec3::new(0.2, 0.09, 0.04)).norm() < 1e-7, "{fitted:?}");
        assert!(c.fit_boxes(&[foot]).is_empty(), "it has one now");
        // The middle (0.04, 0.005, -0.01), turned, and the origin.
        let geom = &c.geoms[fitted[0].geom];
        assert!((geom.position - Vec3::new(-0.005, 0.04, -0.06)).norm() < 1e-7, "{}", geom.position);
        let again = Character::from_mjcf(c.mjcf.as_deref().unwrap(), "text", None).unwrap();
        assert_eq!((touches(&c), touches(&again)), (1, 1));
        let other = again.geoms.iter().find(|g| g.contype != 0).unwrap();
        assert!(
            (other.position - geom.position).norm() < 1e-12 && other.orientation.angle_to(&geom.orientation) < 1e-7
        );
        assert!(
            matches!((&other.shape, &geom.shape), (GeomShape::Box(a), GeomShape::Box(b)) if (a - b).norm() < 1e-12)
        );
        assert_eq!(again.mass(), c.mass());
    }
    // Millimetres that nobody scaled.
    let mut large = with_foot(&urdf, "package://my_robot/meshes/foot.STL", "1 1 1");
    let foot = large.body("foot").unwrap();
    assert!(large.fit_boxes(&[foot]).is_empty());
    assert!(
        warned(&large, "is 200.00 m long and the whole robot 0.80 m (is its scale missing?): it touches nothing"),
        "{:?}",
        large.warnings
    );
    let absent = with_foot(&urdf, "package://other/meshes/foot.STL", "1 1 1");
    assert!(warned(&absent, "their files are missing") && absent.meshes.is_empty());
}

#[test]
fn a_robot_that_is_only_to_be_seen_stands_on_what_is_seen() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("foot.stl"), stl([-0.06, -0.04, -0.03], [0.14, 0.05, 0.01])).unwrap();
    let boxes = |trunk: &str| {
        let mut c = with_foot_that_is("visual", trunk, folder.path(), "foot.stl", "1 1 1");
        let foot = c.body("foot").unwrap();
        c.fit_boxes(&[foot]).len()
    };
    assert_eq!(boxes(""), 1);
    let trunk = r#"<collision><geometry><sphere radius="0.1"/></geometry></collision>"#;
    assert_eq!(boxes(trunk), 0, "a robot with shapes has those that it was given");
}

#[test]
fn collada_is_read_in_its_unit_and_only_where_up_is_certain() {
    let folder = tempfile::tempdir().unwrap();
    let text = |up: &str| {
        format!(
            r##"<?xml version="1.0"?><COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1"><asset><unit name="centimeter" meter="0.01"/>{up}</asset>
<library_geometries><geometry id="g" name="g"><mesh><source id="p"><float_array id="pa" count="9">0 0 0 20 10 4 20 0 0</float_array><technique_common>
<accessor source="#pa" count="3" stride="3"><param name="X" type="float"/><param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices><triangles count="1"><input semantic="VERTEX" source="#v" offset="0"/><p>0 1 2</p></triangles></mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s"><node id="n"><instance_geometry url="#g"/></node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#s"/></scene></COLLADA>"##
        )
    };
    let fit = |up: &str| {
        std::fs::write(folder.path().join("foot.dae"), text(up)).unwrap();
        let mut c = with_foot(folder.path(), "foot.dae", "1 1 1");
        let foot = c.body("foot").unwrap();
        (c.fit_boxes(&[foot]), c)
    };
    let (fitted, _) = fit("<up_axis>Z_UP</up_axis>");
    assert!((fitted[0].size - Vec3::new(0.2, 0.1, 0.04)).norm() < 1e-7, "{fitted:?}");
    for (up, got) in [("<up_axis>Y_UP</up_axis>", "got Y_UP"), ("", "got none (which is Y_UP)")] {
        let (fitted, c) = fit(up);
        assert!(fitted.is_empty() && warned(&c, got), "{:?}", c.warnings);
    }
    let (fitted, c) = fit("<up_axis>Z_UP</up_axis></asset");
    assert!(fitted.is_empty() && warned(&c, "it touches nothing"), "{:?}", c.warnings);
}
