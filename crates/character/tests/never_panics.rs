//! Whatever a file holds, reading it gives a character or an error.
#![allow(clippy::unwrap_used, clippy::expect_used)]

use lifelike_character::anatomy::Overrides;
use lifelike_character::{Anatomy, Character, Kinematics, Symmetry};
use proptest::prelude::*;

const LIMA: &str = include_str!("../../../robots/lima.xml");
const HUMANOID: &str = include_str!("../../../robots/humanoid.xml");
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

proptest! {
    #[test]
    fn random_bytes(bytes in proptest::collection::vec(any::<u8>(), 0..400)) {
        use_it(&String::from_utf8_lossy(&bytes));
    }

    #[test]
    fn cut_and_pasted_models(which in 0..3usize, edits in proptest::collection::vec((any::<usize>(), 0..60usize, any::<usize>()), 1..4)) {
        use_it(&mutate([LIMA, HUMANOID, URDF][which], &edits));
    }

    #[test]
    fn models_with_other_values(which in 0..3usize, edits in proptest::collection::vec((any::<usize>(), any::<usize>()), 1..4)) {
        use_it(&replace_values([LIMA, HUMANOID, URDF][which], &edits));
    }
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
