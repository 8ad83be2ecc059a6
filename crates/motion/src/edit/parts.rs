//! Sets of joints ("the arms") by the parts of the body they move.

use std::collections::BTreeSet;

use lifelike_character::{Anatomy, Character, Joint, Role};

use crate::error::MotionError;

/// Every name of a part, with the single parts it stands for.
const PARTS: [(&str, &[&str]); 10] = [
    ("all", &["left_arm", "right_arm", "left_leg", "right_leg", "head", "torso"]),
    ("upper_body", &["left_arm", "right_arm", "head", "torso"]),
    ("arms", &["left_arm", "right_arm"]),
    ("legs", &["left_leg", "right_leg"]),
    ("left_arm", &["left_arm"]),
    ("right_arm", &["right_arm"]),
    ("left_leg", &["left_leg"]),
    ("right_leg", &["right_leg"]),
    ("head", &["head"]),
    ("torso", &["torso"]),
];
/// The roles along each limb, the outermost first.
const LIMBS: [(&str, [Role; 3]); 4] = [
    ("left_arm", [Role::LeftHand, Role::LeftForearm, Role::LeftUpperArm]),
    ("right_arm", [Role::RightHand, Role::RightForearm, Role::RightUpperArm]),
    ("left_leg", [Role::LeftFoot, Role::LeftShank, Role::LeftThigh]),
    ("right_leg", [Role::RightFoot, Role::RightShank, Role::RightThigh]),
];

/// Returns the joints (in the character's order) that these names stand for: a joint's own name, or a part of the body
/// (`all`, `upper_body`, `arms`, `left_arm`, `right_arm`, `legs`, `left_leg`, `right_leg`, `head`, `torso`). A limb is
/// everything that hangs on the trunk by it, from clavicle or hip to fingers or toes. The torso is what no limb and no
/// head moves.
///
/// # Errors
/// [`MotionError::Mismatch`] for a name that is neither, for a part without joints, and for no name at all.
pub fn joints_of(character: &Character, anatomy: &Anatomy, names: &[String]) -> Result<Vec<String>, MotionError> {
    let of_body = part_of_bodies(character, anatomy);
    let mut picked = BTreeSet::new();
    for name in names {
        let part = PARTS.iter().find(|(part, _)| part == name);
        let meant = |joint: &Joint| match part {
            Some((_, parts)) => parts.contains(&of_body[joint.body]),
            None => joint.name == *name,
        };
        let found: Vec<usize> =
            character.scalar_joints().enumerate().filter(|(_, joint)| meant(joint)).map(|(i, _)| i).collect();
        if found.is_empty() {
            let parts: Vec<&str> = PARTS.iter().map(|(part, _)| *part).collect();
            let joints: Vec<&str> = character.scalar_joints().map(|j| j.name.as_str()).collect();
            let message = match part {
                Some(_) => format!("expected joints in part '{name}', but it has none of its own"),
                None => format!("expected one of the parts {parts:?} or of the joints {joints:?}, got '{name}'"),
            };
            return Err(mismatch(character, message));
        }
        picked.extend(found);
    }
    if picked.is_empty() {
        return Err(mismatch(character, "expected joints or parts of the body to be named, got none".into()));
    }
    Ok(character.scalar_joints().enumerate().filter(|(i, _)| picked.contains(i)).map(|(_, j)| j.name.clone()).collect())
}

fn mismatch(character: &Character, message: String) -> MotionError {
    MotionError::Mismatch { clip: "(any)".into(), character: character.name.clone(), message }
}

/// Returns the single part to which each body belongs.
fn part_of_bodies(character: &Character, anatomy: &Anatomy) -> Vec<&'static str> {
    let mut trunk = vec![false; character.bodies.len()];
    let root = character.root_joint().map(|joint| joint.body);
    let core = [Role::Pelvis, Role::Chest].iter().filter_map(|role| anatomy.places.get(role)).map(|place| place.body);
    for mut body in core.chain(root) {
        while body != 0 {
            trunk[body] = true;
            body = character.bodies[body].parent;
        }
    }
    let head = anatomy.places.get(&Role::Head).map(|place| ("head", place.body));
    let limbs = LIMBS.iter().filter_map(|(part, roles)| {
        let end = roles.iter().find_map(|role| anatomy.places.get(role))?;
        Some((*part, end.body))
    });
    let mut part = vec!["torso"; character.bodies.len()];
    for (name, end) in limbs.chain(head) {
        // Up to the trunk: what hangs there is the limb.
        let mut top = end;
        while top != 0 && !trunk[character.bodies[top].parent] && character.bodies[top].parent != 0 {
            top = character.bodies[top].parent;
        }
        if top != 0 && !trunk[top] {
            part[top] = name;
        }
    }
    for (i, body) in character.bodies.iter().enumerate().skip(1) {
        if part[i] == "torso" && !trunk[i] {
            part[i] = part[body.parent];
        }
    }
    part
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn picked(robot: &str, names: &[&str]) -> Result<Vec<String>, MotionError> {
        let file = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../../robots/{robot}.xml"));
        let character = Character::load(file).unwrap();
        let anatomy = Anatomy::guess(&character, &Default::default()).unwrap();
        joints_of(&character, &anatomy, &names.iter().map(|n| (*n).to_string()).collect::<Vec<_>>())
    }

    #[test]
    fn parts_of_lima_are_what_their_names_say() {
        assert_eq!(picked("lima", &["head"]).unwrap(), ["neck_yaw", "neck_pitch"]);
        let arm = picked("lima", &["left_arm"]).unwrap();
        assert_eq!(arm, ["left_shoulder_pitch", "left_shoulder_roll", "left_shoulder_yaw", "left_elbow"]);
        assert_eq!(picked("lima", &["legs"]).unwrap().len(), 10);
        assert_eq!(picked("lima", &["all"]).unwrap().len(), 20);
        assert_eq!(picked("lima", &["left_knee", "head", "left_knee"]).unwrap()[0], "left_knee");
        assert!(picked("lima", &["torso"]).unwrap_err().to_string().contains("none of its own"), "one rigid trunk");
        let message = picked("lima", &["arm"]).unwrap_err().to_string();
        assert!(message.contains("left_arm") && message.contains("neck_yaw"), "{message}");
        assert!(picked("lima", &[]).is_err());
    }

    #[test]
    fn parts_of_the_humanoid_are_all_of_it_once() {
        let parts = ["left_arm", "right_arm", "left_leg", "right_leg", "head", "torso"];
        let sizes: Vec<usize> = parts.iter().map(|p| picked("humanoid", &[p]).unwrap().len()).collect();
        assert_eq!(sizes.iter().sum::<usize>(), 36, "{sizes:?}");
        assert_eq!((sizes[0], sizes[2]), (sizes[1], sizes[3]), "{sizes:?}");
        assert!(picked("humanoid", &["torso"]).unwrap().iter().all(|j| !j.contains("left") && !j.contains("neck")));
    }
}
