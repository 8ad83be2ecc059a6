//! Who wrote a BVH file: which way its skeleton faces, and in which pose it rests.

use lifelike_character::{Quat, Vec3};

use super::hierarchy::Joint;
use crate::formats::{raw, rest};

/// The families of files that are told apart by their joints' names.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Convention {
    /// B. Hahne's Daz-friendly conversion of the CMU data.
    Daz,
    /// The Bandai-Namco Research Motion Dataset.
    Bandai,
    /// Anything else.
    Other,
}

/// Angle (rad) by which the line from ankle to toe joint of the Bandai skeleton dips when the foot stands flat.
const BANDAI_FOOT_DIP: f64 = 0.52;

impl Convention {
    pub(super) fn of(hierarchy: &super::Hierarchy) -> Self {
        let has = |name: &str| hierarchy.joints.iter().any(|j| j.name == name);
        if ["hip", "abdomen", "lButtock", "rButtock", "lShldr"].into_iter().all(has) {
            Self::Daz
        } else if ["joint_Root", "Hips", "UpperLeg_L", "Toes_R", "Hand_L"].into_iter().all(has) {
            Self::Bandai
        } else {
            Self::Other
        }
    }

    /// Frames at the start that are no motion.
    pub(super) fn rest_frames(self) -> usize {
        usize::from(self == Self::Daz)
    }

    pub(super) fn provenance(self) -> &'static str {
        match self {
            Self::Daz => {
                "BVH of the Daz-friendly skeleton: CMU Graphics Lab Motion Capture Database (mocap.cs.cmu.edu, NSF \
                 EIA-0196217), free for research, not for resale; converted by B. Hahne"
            }
            Self::Bandai => "BVH, Bandai-Namco Research Motion Dataset, CC BY-NC 4.0",
            Self::Other => "BVH",
        }
    }

    /// World rotation of the joints' frames (the file's axes) in the rest pose.
    pub(super) fn rest(self, joints: &[Joint]) -> Vec<Quat> {
        joints.iter().map(|j| if self == Self::Bandai { bandai_rest(&j.name) } else { Quat::identity() }).collect()
    }

    /// The turn from the file's axes to ours. Daz and Bandai figures stand along y and face z. Another skeleton's up is
    /// the axis along which its hips lie farthest above its feet, its left the one along which its left joints lie
    /// farthest from its right ones; where the names do not tell, y is up and z forward.
    pub(super) fn basis(self, joints: &[Joint], parents: &[Option<usize>], offsets: &[Vec3]) -> Quat {
        let guessed = if self == Self::Other { guess(joints, parents, offsets) } else { None };
        guessed.unwrap_or_else(raw::from_y_up_z_forward)
    }
}

fn guess(joints: &[Joint], parents: &[Option<usize>], offsets: &[Vec3]) -> Option<Quat> {
    let names: Vec<String> = joints.iter().map(|j| j.name.clone()).collect();
    let [left, right] = rest::limbs(&names)?;
    let mut places: Vec<Vec3> = Vec::with_capacity(offsets.len());
    for (offset, parent) in offsets.iter().zip(parents) {
        places.push(parent.map_or_else(Vec3::zeros, |p| places[p] + offset));
    }
    let (thigh, foot) = (0, 2);
    let up = nearest_axis(places[left[thigh]] + places[right[thigh]] - places[left[foot]] - places[right[foot]])?;
    let aside = left.iter().zip(&right).fold(Vec3::zeros(), |sum, (l, r)| sum + places[*l] - places[*r]);
    let aside = nearest_axis(aside - up * up.dot(&aside))?;
    // The rows of the turn are our axes in the file's.
    let rows = [aside.cross(&up).transpose(), aside.transpose(), up.transpose()];
    Some(Quat::from_matrix(&nalgebra::Matrix3::from_rows(&rows)))
}

/// The signed coordinate axis next to a direction.
fn nearest_axis(direction: Vec3) -> Option<Vec3> {
    let axis = direction.iamax();
    let sign = direction[axis];
    (sign.abs() > 1e-9).then(|| {
        let mut unit = Vec3::zeros();
        unit[axis] = sign.signum();
        unit
    })
}

/// The frames of the Bandai skeleton in a T-pose, found from what its joints do: bones lie along x (left) or -x (right),
/// elbows and knees bend about y. Columns are the frame's x, y, z in the world (y up, z forward, x left).
fn bandai_rest(name: &str) -> Quat {
    let (left, up, forward) = (Vec3::x(), Vec3::y(), Vec3::z());
    let toe = forward * BANDAI_FOOT_DIP.cos() - up * BANDAI_FOOT_DIP.sin();
    let (x, y) = match name {
        "Hips" => (up, -left),
        "Spine" | "Chest" | "Neck" | "Head" => (up, forward),
        "Shoulder_L" | "UpperArm_L" | "LowerArm_L" | "Hand_L" => (left, up),
        "Shoulder_R" | "UpperArm_R" | "LowerArm_R" | "Hand_R" => (left, -up),
        "UpperLeg_L" | "LowerLeg_L" => (-up, left),
        "UpperLeg_R" | "LowerLeg_R" => (up, left),
        "Foot_L" => (toe, left),
        "Foot_R" => (-toe, left),
        "Toes_L" => (forward, left),
        "Toes_R" => (-forward, left),
        _ => return Quat::identity(),
    };
    Quat::from_matrix(&nalgebra::Matrix3::from_columns(&[x, y, x.cross(&y)]))
}
