//! Which joint of a captured skeleton plays which role: guessed from names and topology, overridable by text.

use std::collections::BTreeMap;

use lifelike_character::Role;

use crate::error::MotionError;
use crate::source::{Skeleton, SourceClip};

/// Overrides of the guess, as TOML:
///
/// ```toml
/// left_toe = "LeftToeBase"
/// [roles]
/// left_thigh = "LeftUpLeg"
/// ```
///
/// A role's joint is the one whose rotation moves that segment: `left_thigh` is the hip joint, `left_shank` the knee,
/// `left_foot` the ankle, `left_hand` the wrist.
#[derive(Debug, Clone, Default, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Correspondence {
    /// Source joint of each role.
    pub roles: BTreeMap<Role, String>,
    /// Source joint at the ball of the left foot.
    pub left_toe: Option<String>,
    /// Source joint at the ball of the right foot.
    pub right_toe: Option<String>,
}

/// The roles of a source skeleton, as joint indices.
#[derive(Debug, Clone, PartialEq)]
pub struct SourceRoles {
    /// Joint of each role.
    pub joints: BTreeMap<Role, usize>,
    /// Joints at the balls of the feet (left, right), where there are any.
    pub toes: [Option<usize>; 2],
}

/// Words that name a part, best first. `arm` and `leg` come after the words that contain them.
const THIGH: &[&str] = &["femur", "thigh", "upperleg", "upleg", "hip"];
const SHANK: &[&str] = &["tibia", "shin", "shank", "calf", "lowerleg", "lowleg", "knee", "leg"];
const FOOT: &[&str] = &["ankle", "foot"];
const TOE: &[&str] = &["toebase", "toes", "toe", "ball"];
const UPPER_ARM: &[&str] = &["humerus", "upperarm", "uparm", "shldr", "arm", "shoulder"];
const FOREARM: &[&str] = &["radius", "forearm", "lowerarm", "lowarm", "elbow"];
const HAND: &[&str] = &["wrist", "hand"];
const HEAD: &[&str] = &["head", "neck", "upperneck", "lowerneck"];

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Side {
    Left,
    Right,
    Middle,
}

/// Splits a name into its side and the part in lower-case letters: `mixamorig:LeftUpLeg` → left, `upleg`.
fn split_side(name: &str) -> (Side, String) {
    let bare = name.rsplit([':', '|']).next().unwrap_or(name);
    let lower: String = bare.to_lowercase();
    let letters = |s: &str| s.chars().filter(|c| c.is_ascii_alphabetic()).collect::<String>();
    for (word, side) in [("left", Side::Left), ("right", Side::Right)] {
        if let Some(at) = lower.find(word) {
            return (side, letters(&format!("{}{}", &lower[..at], &lower[at + word.len()..])));
        }
    }
    for (letter, side) in [('l', Side::Left), ('r', Side::Right)] {
        for separator in ['_', '.', '-', ' '] {
            if lower.ends_with(&format!("{separator}{letter}")) {
                return (side, letters(&lower[..lower.len() - 2]));
            }
            if lower.starts_with(&format!("{letter}{separator}")) {
                return (side, letters(&lower[2..]));
            }
        }
        // lThigh, LHipJoint, lfemur: a letter glued to a known part.
        if lower.starts_with(letter) {
            let rest = letters(&lower[1..]);
            let known = [THIGH, SHANK, FOOT, TOE, UPPER_ARM, FOREARM, HAND, &["collar", "clavicle", "hipjoint"]];
            if known.iter().any(|words| words.iter().any(|w| rest.starts_with(w))) {
                return (side, rest);
            }
        }
    }
    (Side::Middle, letters(&lower))
}

fn find(parts: &[(Side, String)], side: Side, words: &[&str]) -> Option<usize> {
    let all = || parts.iter().enumerate().filter(move |(_, (s, _))| *s == side);
    for word in words {
        if let Some((i, _)) = all().find(|(_, (_, part))| part == word) {
            return Some(i);
        }
        // `foot1` and `toebase` yes, but `hipjoint` is the socket, not the hip, and `armroll` a helper bone.
        if let Some((i, _)) = all().find(|(_, (_, part))| {
            part.strip_prefix(word).is_some_and(|rest| !rest.is_empty() && rest != "joint" && rest != "roll")
                && word.len() > 3
        }) {
            return Some(i);
        }
    }
    None
}

/// `joint`, its parent, and so on up to the root.
pub(super) fn ancestors(skeleton: &Skeleton, joint: usize) -> impl Iterator<Item = usize> + '_ {
    std::iter::successors(Some(joint), |&j| skeleton.parents[j])
}

fn common_ancestor(skeleton: &Skeleton, a: usize, b: usize) -> Option<usize> {
    let of_a: Vec<usize> = ancestors(skeleton, a).skip(1).collect();
    ancestors(skeleton, b).skip(1).find(|j| of_a.contains(j))
}

/// Whether the chain `joints` goes outwards: each below the one before.
fn goes_outwards(skeleton: &Skeleton, joints: &[usize]) -> bool {
    joints.windows(2).all(|w| ancestors(skeleton, w[1]).skip(1).any(|j| j == w[0]))
}

impl SourceRoles {
    /// Guesses the roles of a clip's skeleton and applies the overrides.
    ///
    /// # Errors
    /// [`MotionError::Unfit`] when an override names no joint, or when there are no two legs: without them nothing can
    /// be retargeted.
    pub fn guess(clip: &SourceClip, overrides: &Correspondence) -> Result<Self, MotionError> {
        let skeleton = &clip.skeleton;
        let unfit = |message: String| MotionError::Unfit { clip: clip.name.clone(), message };
        let parts: Vec<(Side, String)> = skeleton.names.iter().map(|n| split_side(n)).collect();
        let mut joints = BTreeMap::new();
        let mut toes = [None, None];
        let sides = [
            (Side::Left, [Role::LeftThigh, Role::LeftShank, Role::LeftFoot]),
            (Side::Right, [Role::RightThigh, Role::RightShank, Role::RightFoot]),
        ];
        for (i, (side, roles)) in sides.into_iter().enumerate() {
            for (role, words) in roles.into_iter().zip([THIGH, SHANK, FOOT]) {
                if let Some(joint) = find(&parts, side, words) {
                    joints.insert(role, joint);
                }
            }
            toes[i] = find(&parts, side, TOE);
        }
        let arms = [
            (Side::Left, [Role::LeftUpperArm, Role::LeftForearm, Role::LeftHand]),
            (Side::Right, [Role::RightUpperArm, Role::RightForearm, Role::RightHand]),
        ];
        for (side, roles) in arms {
            for (role, words) in roles.into_iter().zip([UPPER_ARM, FOREARM, HAND]) {
                if let Some(joint) = find(&parts, side, words) {
                    joints.insert(role, joint);
                }
            }
        }
        if let Some(head) = find(&parts, Side::Middle, HEAD) {
            joints.insert(Role::Head, head);
        }
        let named = |name: &str| {
            skeleton.names.iter().position(|n| n == name).ok_or_else(|| {
                let there = skeleton.names.join(", ");
                unfit(format!("the correspondence names joint '{name}', but there are only: {there}"))
            })
        };
        for (role, name) in &overrides.roles {
            joints.insert(*role, named(name)?);
        }
        for (toe, name) in toes.iter_mut().zip([&overrides.left_toe, &overrides.right_toe]) {
            if let Some(name) = name {
                *toe = Some(named(name)?);
            }
        }
        for (side, roles) in [("left", sides[0].1), ("right", sides[1].1)] {
            let chain: Vec<usize> = roles.iter().filter_map(|r| joints.get(r).copied()).collect();
            if chain.len() < 3 || !goes_outwards(skeleton, &chain) {
                let there = skeleton.names.join(", ");
                return Err(unfit(format!("no {side} leg (hip, knee, ankle) among the joints: {there}")));
            }
        }
        // An arm that is not a chain, or lacks a joint, is no arm.
        for (_, roles) in arms {
            let chain: Vec<usize> = roles.iter().filter_map(|r| joints.get(r).copied()).collect();
            if chain.len() < 3 || !goes_outwards(skeleton, &chain) {
                roles.iter().for_each(|r| {
                    joints.remove(r);
                });
            }
        }
        for (role, a, b) in
            [(Role::Pelvis, Role::LeftThigh, Role::RightThigh), (Role::Chest, Role::LeftUpperArm, Role::RightUpperArm)]
        {
            if let (Some(&a), Some(&b)) = (joints.get(&a), joints.get(&b))
                && let Some(joint) = common_ancestor(skeleton, a, b)
            {
                joints.entry(role).or_insert(joint);
            }
        }
        let pelvis = *joints.entry(Role::Pelvis).or_insert(0);
        joints.entry(Role::Chest).or_insert(pelvis);
        Ok(Self { joints, toes })
    }

    /// Joint of a role.
    pub fn get(&self, role: Role) -> Option<usize> {
        self.joints.get(&role).copied()
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::expect_used)]
    use super::*;
    use lifelike_character::Vec3;

    fn clip(tree: &[(&str, Option<usize>)]) -> SourceClip {
        SourceClip {
            name: "c".into(),
            fps: 30.0,
            skeleton: Skeleton {
                names: tree.iter().map(|(n, _)| (*n).to_string()).collect(),
                parents: tree.iter().map(|(_, p)| *p).collect(),
                offsets: vec![Vec3::zeros(); tree.len()],
                ends: Vec::new(),
            },
            root_position: Vec::new(),
            rotations: Vec::new(),
            cyclic: false,
            captions: Vec::new(),
            provenance: String::new(),
        }
    }

    /// Roots first; (thigh, shank, foot, upper arm, forearm, hand) of the left side, then pelvis, chest, head.
    fn check(tree: &[(&str, Option<usize>)], expected: [&str; 9]) {
        let clip = clip(tree);
        let roles = SourceRoles::guess(&clip, &Correspondence::default()).unwrap();
        use Role::*;
        let wanted = [LeftThigh, LeftShank, LeftFoot, LeftUpperArm, LeftForearm, LeftHand, Pelvis, Chest, Head];
        for (role, name) in wanted.into_iter().zip(expected) {
            assert_eq!(roles.get(role).map(|j| tree[j].0), Some(name), "{role:?}");
        }
        assert!(tree[roles.get(RightThigh).unwrap()].0.to_lowercase().contains('r'));
        assert_ne!(roles.get(RightThigh), roles.get(LeftThigh));
    }

    #[test]
    fn cmu_asf() {
        check(
            &[
                ("root", None),
                ("lhipjoint", Some(0)),
                ("lfemur", Some(1)),
                ("ltibia", Some(2)),
                ("lfoot", Some(3)),
                ("ltoes", Some(4)),
                ("rhipjoint", Some(0)),
                ("rfemur", Some(6)),
                ("rtibia", Some(7)),
                ("rfoot", Some(8)),
                ("rtoes", Some(9)),
                ("lowerback", Some(0)),
                ("upperback", Some(11)),
                ("thorax", Some(12)),
                ("lowerneck", Some(13)),
                ("upperneck", Some(14)),
                ("head", Some(15)),
                ("lclavicle", Some(13)),
                ("lhumerus", Some(17)),
                ("lradius", Some(18)),
                ("lwrist", Some(19)),
                ("lhand", Some(20)),
                ("rclavicle", Some(13)),
                ("rhumerus", Some(22)),
                ("rradius", Some(23)),
                ("rwrist", Some(24)),
                ("rhand", Some(25)),
            ],
            ["lfemur", "ltibia", "lfoot", "lhumerus", "lradius", "lwrist", "root", "thorax", "head"],
        );
    }

    #[test]
    fn daz_bvh() {
        check(
            &[
                ("hip", None),
                ("abdomen", Some(0)),
                ("chest", Some(1)),
                ("neck", Some(2)),
                ("head", Some(3)),
                ("leftEye", Some(4)),
                ("rCollar", Some(2)),
                ("rShldr", Some(6)),
                ("rForeArm", Some(7)),
                ("rHand", Some(8)),
                ("lCollar", Some(2)),
                ("lShldr", Some(10)),
                ("lForeArm", Some(11)),
                ("lHand", Some(12)),
                ("rButtock", Some(0)),
                ("rThigh", Some(14)),
                ("rShin", Some(15)),
                ("rFoot", Some(16)),
                ("lButtock", Some(0)),
                ("lThigh", Some(18)),
                ("lShin", Some(19)),
                ("lFoot", Some(20)),
            ],
            ["lThigh", "lShin", "lFoot", "lShldr", "lForeArm", "lHand", "hip", "chest", "head"],
        );
    }

    #[test]
    fn deepmimic() {
        check(
            &[
                ("root", None),
                ("chest", Some(0)),
                ("neck", Some(1)),
                ("right_hip", Some(0)),
                ("right_knee", Some(3)),
                ("right_ankle", Some(4)),
                ("right_shoulder", Some(1)),
                ("right_elbow", Some(6)),
                ("right_wrist", Some(7)),
                ("left_hip", Some(0)),
                ("left_knee", Some(9)),
                ("left_ankle", Some(10)),
                ("left_shoulder", Some(1)),
                ("left_elbow", Some(12)),
                ("left_wrist", Some(13)),
            ],
            [
                "left_hip",
                "left_knee",
                "left_ankle",
                "left_shoulder",
                "left_elbow",
                "left_wrist",
                "root",
                "chest",
                "neck",
            ],
        );
    }

    #[test]
    fn bandai_and_mixamo() {
        check(
            &[
                ("joint_Root", None),
                ("Hips", Some(0)),
                ("Spine", Some(1)),
                ("Chest", Some(2)),
                ("Neck", Some(3)),
                ("Head", Some(4)),
                ("Shoulder_L", Some(3)),
                ("UpperArm_L", Some(6)),
                ("LowerArm_L", Some(7)),
                ("Hand_L", Some(8)),
                ("Shoulder_R", Some(3)),
                ("UpperArm_R", Some(10)),
                ("LowerArm_R", Some(11)),
                ("Hand_R", Some(12)),
                ("UpperLeg_L", Some(1)),
                ("LowerLeg_L", Some(14)),
                ("Foot_L", Some(15)),
                ("Toes_L", Some(16)),
                ("UpperLeg_R", Some(1)),
                ("LowerLeg_R", Some(18)),
                ("Foot_R", Some(19)),
            ],
            ["UpperLeg_L", "LowerLeg_L", "Foot_L", "UpperArm_L", "LowerArm_L", "Hand_L", "Hips", "Chest", "Head"],
        );
        check(
            &[
                ("mixamorig:Hips", None),
                ("mixamorig:Spine2", Some(0)),
                ("mixamorig:Head", Some(1)),
                ("mixamorig:LeftShoulder", Some(1)),
                ("mixamorig:LeftArm", Some(3)),
                ("mixamorig:LeftForeArm", Some(4)),
                ("mixamorig:LeftHand", Some(5)),
                ("mixamorig:RightShoulder", Some(1)),
                ("mixamorig:RightArm", Some(7)),
                ("mixamorig:RightForeArm", Some(8)),
                ("mixamorig:RightHand", Some(9)),
                ("mixamorig:LeftUpLeg", Some(0)),
                ("mixamorig:LeftLeg", Some(11)),
                ("mixamorig:LeftFoot", Some(12)),
                ("mixamorig:LeftToeBase", Some(13)),
                ("mixamorig:RightUpLeg", Some(0)),
                ("mixamorig:RightLeg", Some(15)),
                ("mixamorig:RightFoot", Some(16)),
            ],
            [
                "mixamorig:LeftUpLeg",
                "mixamorig:LeftLeg",
                "mixamorig:LeftFoot",
                "mixamorig:LeftArm",
                "mixamorig:LeftForeArm",
                "mixamorig:LeftHand",
                "mixamorig:Hips",
                "mixamorig:Spine2",
                "mixamorig:Head",
            ],
        );
    }

    #[test]
    fn a_skeleton_without_legs_is_refused_with_its_joints() {
        let error = SourceRoles::guess(&clip(&[("root", None), ("tail", Some(0))]), &Correspondence::default());
        let text = error.unwrap_err().to_string();
        assert!(text.contains("no left leg") && text.contains("root, tail"), "{text}");
    }

    #[test]
    fn overrides_are_text_and_unknown_keys_are_refused() {
        let given: Correspondence = toml::from_str("left_toe = \"t\"\n[roles]\nleft_thigh = \"a\"").unwrap();
        assert_eq!(given.roles[&Role::LeftThigh], "a");
        assert!(toml::from_str::<Correspondence>("left_tow = \"t\"").is_err());
        let error = SourceRoles::guess(&clip(&[("root", None)]), &given).unwrap_err().to_string();
        assert!(error.contains("'a'"), "{error}");
    }
}
