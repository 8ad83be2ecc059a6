//! Whatever a file holds, reading it gives a character or an error.
use lifelike_character::anatomy::Overrides;
use lifelike_character::{Anatomy, Character, Kinematics, Symmetry};
use proptest::prelude::*;

/// Two legs in classes, with sites, actuators and exclusions; angles in radians.
const BIPED: &str = r#"<mujoco model="biped"><compiler angle="radian" autolimits="true"/><option timestep="0.005"/>
<default><geom friction="1 .01 .001" condim="3"/><joint damping=".1" armature=".01"/>
<default class="leg"><joint axis="0 1 0" range="-1 2"/><geom type="capsule" size=".04" contype="1" conaffinity="0"/></default></default>
<asset><mesh name="shell" file="shell.stl"/><material name="grey" rgba=".5 .5 .5 1"/></asset>
<worldbody><light pos="0 0 3"/><geom name="floor" type="plane" size="5 5 1"/>
<body name="pelvis" pos="0 0 .8"><freejoint name="root"/><geom type="box" size=".1 .1 .05" mass="5"/>
<geom type="mesh" mesh="shell" contype="0" conaffinity="0" mass="0"/>
<body name="left_thigh" pos="0 .1 0" childclass="leg"><joint name="left_hip"/><geom fromto="0 0 0 0 0 -.3"/>
<body name="left_foot" pos="0 0 -.3"><joint name="left_ankle"/><geom type="box" size=".08 .04 .02"/><site name="left_sole" pos="0 0 -.02"/></body></body>
<body name="right_thigh" pos="0 -.1 0" childclass="leg"><joint name="right_hip"/><geom fromto="0 0 0 0 0 -.3"/>
<body name="right_foot" pos="0 0 -.3"><joint name="right_ankle"/><geom type="box" size=".08 .04 .02"/><site name="right_sole" pos="0 0 -.02"/></body></body>
</body></worldbody><contact><exclude body1="left_foot" body2="right_foot"/></contact>
<equality><weld name="stuck" body1="left_foot" relpose="0 0 0 1 0 0 0" torquescale="0.5"/><connect body1="left_foot" body2="right_foot" anchor="0 0 0"/>
<weld site1="left_sole" site2="right_sole" active="false" solref=".02 1" solimp=".9 .95 .001"/></equality>
<actuator><position name="l" joint="left_hip" kp="40" kv="2" forcerange="-30 30"/><motor name="r" joint="right_hip" gear="25" ctrlrange="-1 1"/></actuator>
<keyframe><key name="home" qpos="0 0 .8 1 0 0 0 0 0 0 0"/></keyframe></mujoco>"#;
/// An arm of slides and balls with frames and Euler angles; angles in degrees.
const ARM: &str = r#"<mujoco><compiler eulerseq="zyx"/><worldbody><frame pos="0 0 1" euler="0 0 90"><body name="base">
<inertial pos="0 0 0" mass="2" fullinertia=".1 .1 .1 0 0 0"/><joint name="rail" type="slide" axis="1 0 0" limited="true" range="-1 1"/>
<geom type="cylinder" size=".1 .2" euler="10 20 30"/><body name="left_arm" pos="0 .2 0" quat=".7 .7 0 0"><joint name="shoulder" type="ball"/>
<geom type="ellipsoid" size=".1 .2 .3" density="500"/><body name="hand" pos="0 0 .3" axisangle="0 0 1 45"><joint name="wrist" range="-90 90" ref="10"/>
<geom size=".05" zaxis="1 0 0"/><site name="tip" xyaxes="1 0 0 0 1 0"/></body></body></body></frame></worldbody></mujoco>"#;
const URDF: &str = r#"<robot name="r"><link name="a"><inertial><origin xyz="0 0 0" rpy="0 0 0"/><mass value="1"/>
<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial><collision><geometry><box size="1 1 1"/></geometry></collision></link>
<link name="b"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>
<joint name="j" type="revolute"><origin xyz="0 0 1"/><parent link="a"/><child link="b"/><axis xyz="0 1 0"/><limit lower="-1" upper="1" effort="3"/></joint></robot>"#;

/// Reads, and uses what was read.
fn use_it(text: &str) {
    for character in
        [Character::from_mjcf(text, "t", None), Character::from_urdf(text, "t", None)].into_iter().flatten()
    {
        let kinematics = Kinematics::new(&character);
        if character.bodies.len() > 1 {
            kinematics.jacobian(&character, character.bodies.len() - 1, &kinematics.body_position[1]);
        }
        let _ = Anatomy::guess(&character, &Overrides::new());
        let _ = Symmetry::derive(&character);
        // What we write we can read.
        let again = Character::from_mjcf(character.mjcf.as_deref().unwrap(), "again", None).unwrap();
        assert_eq!(again.bodies.len(), character.bodies.len());
    }
}

/// Cuts, doubles or replaces a piece of the text at character borders.
fn mutate(text: &str, edits: &[(usize, usize, usize)]) -> String {
    let pieces = [
        "",
        "\"",
        "<",
        ">",
        "0 0 0",
        "-1",
        "1e308",
        "nan",
        "body",
        "joint",
        "geom",
        "fromto=\"0 0 0 0 0 1\"",
        "<body>",
        "</body>",
        "type=\"ball\"",
        "type=\"free\"",
        "&#0;",
        "left",
        "right",
        "<frame/>",
        "é",
        "inf",
        "0",
    ];
    let mut text: Vec<char> = text.chars().collect();
    for (at, length, piece) in edits {
        let at = at % (text.len() + 1);
        let end = (at + length).min(text.len());
        text.splice(at..end, pieces[piece % pieces.len()].chars());
    }
    text.into_iter().collect()
}

/// Replaces whole attribute values, which keeps the XML well-formed and so reaches deeper.
fn replace_values(text: &str, edits: &[(usize, usize)]) -> String {
    let values = [
        "", "0", "-1", "1e308", "1e-308", "0 0 0", "1 2 3 4", "true", "capsule", "ball", "free", "world", "pelvis",
        "0 0 0 0",
    ];
    let mut parts: Vec<String> = text.split('"').map(str::to_string).collect();
    for (at, value) in edits {
        let at = (at % (parts.len() / 2)) * 2 + 1;
        parts[at] = values[value % values.len()].to_string();
    }
    parts.join("\"")
}

/// A foot of one triangle, in each language that meshes are read in.
const MESHES: [(&str, &str); 3] = [
    (
        "stl",
        "solid s\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 0.1 0 0\nvertex 0 0.1 0\nendloop\nendfacet\nendsolid s\n",
    ),
    ("obj", "mtllib none.mtl\no foot\nv 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nvn 0 0 1\nvt 0 0\nf 1/1/1 2/1/1 3/1/1\n"),
    (
        "dae",
        r##"<?xml version="1.0"?><COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1"><asset><unit meter="0.01"/><up_axis>Z_UP</up_axis></asset>
<library_geometries><geometry id="g"><mesh><source id="p"><float_array id="pa" count="9">0 0 0 20 10 4 20 0 0</float_array><technique_common>
<accessor source="#pa" count="3" stride="3"><param name="X" type="float"/><param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices><triangles count="1"><input semantic="VERTEX" source="#v" offset="0"/><p>0 1 2</p></triangles></mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s"><node id="n"><matrix>1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1</matrix><instance_geometry url="#g"/></node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#s"/></scene></COLLADA>"##,
    ),
];

/// Stands a robot on a mesh of these bytes; returns whether there was a box to stand on.
fn stands_on(ending: &str, bytes: &[u8]) -> bool {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join(format!("foot.{ending}")), bytes).unwrap();
    let foot = format!("<mesh filename=\"foot.{ending}\"/>");
    let text = URDF.replace("<sphere radius=\"0.1\"/>", &foot).replace(
        "<link name=\"b\">",
        "<link name=\"b\"><inertial><mass value=\"1\"/><inertia ixx=\"1\" iyy=\"1\" izz=\"1\"/></inertial>",
    );
    let mut character = Character::from_urdf(&text, "t", Some(folder.path())).unwrap();
    let body = character.body("b").unwrap();
    character.fit_boxes(&[body]).len() == 1
}

#[test]
fn meshes_that_are_spoilt_were_sound() {
    for (ending, text) in MESHES {
        assert!(stands_on(ending, text.as_bytes()), "{ending}");
    }
}

proptest! {
    #[test]
    fn cut_and_pasted_meshes(which in 0..3usize, edits in proptest::collection::vec((any::<usize>(), 0..60usize, any::<usize>()), 1..4)) {
        stands_on(MESHES[which].0, mutate(MESHES[which].1, &edits).as_bytes());
    }

    #[test]
    fn meshes_of_random_bytes(which in 0..3usize, bytes in proptest::collection::vec(any::<u8>(), 0..400)) {
        stands_on(MESHES[which].0, &bytes);
    }

    #[test]
    fn random_bytes(bytes in proptest::collection::vec(any::<u8>(), 0..400)) {
        use_it(&String::from_utf8_lossy(&bytes));
    }

    #[test]
    fn cut_and_pasted_models(which in 0..3usize, edits in proptest::collection::vec((any::<usize>(), 0..60usize, any::<usize>()), 1..4)) {
        use_it(&mutate([BIPED, ARM, URDF][which], &edits));
    }

    #[test]
    fn models_with_other_values(which in 0..3usize, edits in proptest::collection::vec((any::<usize>(), any::<usize>()), 1..4)) {
        use_it(&replace_values([BIPED, ARM, URDF][which], &edits));
    }
}

#[test]
fn what_is_spoilt_was_sound() {
    for text in [BIPED, ARM] {
        Character::from_mjcf(text, "t", None).unwrap();
    }
    Character::from_urdf(URDF, "t", None).unwrap();
}

#[test]
fn endless_nesting_is_refused() {
    let deep = format!("<mujoco><worldbody>{}{}</worldbody></mujoco>", "<body>".repeat(5000), "</body>".repeat(5000));
    assert!(Character::from_mjcf(&deep, "deep", None).is_err());
    let mut chain = String::from("<robot name=\"r\"><link name=\"0\"/>");
    for i in 0..1000 {
        chain += &format!(
            "<link name=\"{}\"/><joint name=\"j{i}\" type=\"fixed\"><parent link=\"{i}\"/><child link=\"{}\"/></joint>",
            i + 1,
            i + 1
        );
    }
    assert!(Character::from_urdf(&(chain + "</robot>"), "chain", None).is_err());
}
