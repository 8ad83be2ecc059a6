//! Roles of a captured skeleton's joints: guessed from names and topology, overridable by text.

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

/// Returns `joint`, its parent, and so on up to the root.
pub(super) fn ancestors(skeleton: &Skeleton, joint: usize) -> impl Iterator<Item = usize> + '_ {
    std::iter::successors(Some(joint), |&j| skeleton.parents[j])
}

fn common_ancestor(skeleton: &Skeleton, a: usize, b: usize) -> Option<usize> {
    let of_a: Vec<usize> = ancestors(skeleton, a).skip(1).collect();
    ancestors(skeleton, b).skip(1).find(|j| of_a.contains(j))
}

/// Returns whether the chain `joints` goes outwards: each below the one before.
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

    /// Returns the joint of a role.
    pub fn get(&self, role: Role) -> Option<usize> {
        self.joints.get(&role).copied()
    }
}

#[cfg(test)]
mod tests;
