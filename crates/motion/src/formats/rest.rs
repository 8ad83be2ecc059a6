//! One rest pose for every format: the T-pose.
//!
//! Legs hang straight down, feet point forward and lie flat, arms point straight to the sides with the elbows' hinges
//! vertical (bending a forearm brings it forward). Formats differ: the legs of an ASF are spread by 20 degrees, the
//! forearms of a Daz figure are bent by 17, DeepMimic's arms hang down. With one rest pose the rotation of a thigh
//! means the same wherever it came from, and a knee's local rotation is the angle between its two bones.

use lifelike_character::{Quat, Vec3};

use crate::source::Skeleton;

/// Thigh, shin, foot, upper arm, forearm, hand of the left side, in the names of one family of files. Compared in lower
/// case without punctuation.
const FAMILIES: [[&str; 6]; 6] = [
    ["lfemur", "ltibia", "lfoot", "lhumerus", "lradius", "lwrist"],
    ["lthigh", "lshin", "lfoot", "lshldr", "lforearm", "lhand"],
    ["upperlegl", "lowerlegl", "footl", "upperarml", "lowerarml", "handl"],
    ["leftupleg", "leftleg", "leftfoot", "leftarm", "leftforearm", "lefthand"],
    ["lefthip", "leftknee", "leftankle", "leftshoulder", "leftelbow", "leftwrist"],
    ["leftthigh", "leftshin", "leftfoot", "leftupperarm", "leftforearm", "lefthand"],
];

/// The joints of one side: thigh, shin, foot, upper arm, forearm, hand.
pub(crate) type Limbs = [usize; 6];

/// The left and the right limbs of a skeleton whose names are known.
pub(crate) fn limbs(names: &[String]) -> Option<[Limbs; 2]> {
    let plain: Vec<String> = names.iter().map(|n| plain(n)).collect();
    FAMILIES.iter().find_map(|family| {
        let find = |name: &str| plain.iter().position(|n| n == name);
        let mut sides = [[0; 6]; 2];
        for (at, left) in family.iter().enumerate() {
            sides[0][at] = find(left)?;
            sides[1][at] = find(&mirrored(left))?;
        }
        Some(sides)
    })
}

/// Lower case letters and digits only, without a prefix up to a colon (`mixamorig:LeftLeg`).
fn plain(name: &str) -> String {
    let name = name.rsplit(':').next().unwrap_or(name);
    name.chars().filter(char::is_ascii_alphanumeric).map(|c| c.to_ascii_lowercase()).collect()
}

/// The right-hand name of a left-hand name of [`FAMILIES`].
fn mirrored(left: &str) -> String {
    if let Some(rest) = left.strip_prefix("left") {
        format!("right{rest}")
    } else if let Some(rest) = left.strip_suffix('l') {
        format!("{rest}r")
    } else {
        left.replacen('l', "r", 1)
    }
}

/// Changes the rest pose of a skeleton (z up, x forward, y left) to the T-pose, as far as its limbs are known by name.
/// Returns the world rotation by which each joint's segment was turned.
pub(crate) fn straighten(skeleton: &mut Skeleton) -> Vec<Quat> {
    let n = skeleton.names.len();
    let mut own: Vec<Option<Quat>> = vec![None; n];
    if let Some(sides) = limbs(&skeleton.names) {
        let positions = positions(skeleton);
        let bone = |from: usize, to: usize| positions[to] - positions[from];
        for (side, [thigh, shin, foot, upper, fore, hand]) in sides.into_iter().enumerate() {
            let aside = if side == 0 { Vec3::y() } else { -Vec3::y() };
            own[thigh] = Quat::rotation_between(&bone(thigh, shin), &-Vec3::z());
            own[shin] = Quat::rotation_between(&bone(shin, foot), &-Vec3::z());
            // The sole lies flat in every rest pose met, seen from the side; only the legs' spread must be undone.
            let down = bone(shin, foot);
            own[foot] = Quat::rotation_between(&Vec3::new(0.0, down.y, down.z), &-Vec3::z());
            own[upper] = Quat::rotation_between(&bone(upper, fore), &aside);
            own[fore] = Quat::rotation_between(&bone(fore, hand), &aside);
        }
    }
    let mut turns: Vec<Quat> = Vec::with_capacity(n);
    for joint in 0..n {
        let parent = skeleton.parents[joint].map_or_else(Quat::identity, |p| turns[p]);
        skeleton.offsets[joint] = parent * skeleton.offsets[joint];
        turns.push(own[joint].unwrap_or(parent));
    }
    for (joint, offset) in &mut skeleton.ends {
        *offset = turns[*joint] * *offset;
    }
    turns
}

/// Positions of the joints in the rest pose, the root at the origin (m).
pub(crate) fn positions(skeleton: &Skeleton) -> Vec<Vec3> {
    let mut positions: Vec<Vec3> = Vec::with_capacity(skeleton.names.len());
    for (offset, parent) in skeleton.offsets.iter().zip(&skeleton.parents) {
        positions.push(parent.map_or_else(Vec3::zeros, |p| positions[p] + offset));
    }
    positions
}
