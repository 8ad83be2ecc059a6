//! Origin of a BVH file: which way its skeleton faces, and in which pose it rests.

use lifelike_character::{Quat, Vec3};

use super::hierarchy::Joint;
use crate::formats::standing::Known;
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

/// Angles (rad) below the horizontal when the Bandai skeleton's feet are flat, of the line from ankle to toe joint and
/// of the toes' x axis: medians over standing feet in its walks (ankle 11.7 cm, toe joint 4.2 cm high).
const BANDAI_FOOT_DIP: f64 = 0.693;
const BANDAI_TOE_DIP: f64 = 0.37;
/// The rest pose and the frames into which a filter of the conversion smeared it: against the CMU originals the arms
/// are off by 76, 48, 22, 7, 10, 10 degrees in frames 1 to 6 (medians over 20 trials). From then on it is a constant
/// 7.
const DAZ_REST_FRAMES: usize = 7;
/// Tilt of the elbows' hinges of the Daz skeleton (rad): median over the CMU walks.
const DAZ_ELBOW_TILT: f64 = 0.47;
/// The Daz head against the CMU originals (rad): median over the 20 trials that exist in both.
const DAZ_HEAD_LOOKS_UP: f64 = 0.27;

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

    /// Returns the frames at the start that are no motion.
    pub(super) fn rest_frames(self) -> usize {
        if self == Self::Daz { DAZ_REST_FRAMES } else { 0 }
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

    /// Returns axes and rest pose. Daz and Bandai figures stand along y and face z; those of others are to be found.
    pub(super) fn known(self, joints: &[Joint]) -> Option<Known> {
        let rest = match self {
            Self::Daz => vec![Quat::identity(); joints.len()],
            Self::Bandai => joints.iter().map(|joint| bandai_rest(&joint.name)).collect(),
            Self::Other => return None,
        };
        Some(Known { basis: raw::from_y_up_z_forward(), rest })
    }

    /// Facts that the zero pose does not show: found by comparing the Daz files with the CMU originals of the same
    /// trials.
    pub(super) fn hints(self, joints: &[Joint]) -> rest::Hints {
        if self != Self::Daz {
            return rest::Hints::default();
        }
        let head = joints.iter().position(|j| j.name == "head");
        rest::Hints {
            elbow_tilt: DAZ_ELBOW_TILT,
            drawn_bent: true,
            looks_up: head.map(|head| (head, DAZ_HEAD_LOOKS_UP)),
        }
    }
}

/// Returns the frames of the Bandai skeleton in a T-pose, found from what its joints do: bones lie along x (left) or -x
/// (right), elbows and knees bend about y. Columns are the frame's x, y, z in the world (y up, z forward, x left).
fn bandai_rest(name: &str) -> Quat {
    let (left, up, forward) = (Vec3::x(), Vec3::y(), Vec3::z());
    let dipping = |angle: f64| forward * angle.cos() - up * angle.sin();
    let (foot, toes) = (dipping(BANDAI_FOOT_DIP), dipping(BANDAI_TOE_DIP));
    let (x, y) = match name {
        "Hips" => (up, -left),
        "Spine" | "Chest" | "Neck" | "Head" => (up, forward),
        "Shoulder_L" | "UpperArm_L" | "LowerArm_L" | "Hand_L" => (left, up),
        "Shoulder_R" | "UpperArm_R" | "LowerArm_R" | "Hand_R" => (left, -up),
        "UpperLeg_L" | "LowerLeg_L" => (-up, left),
        "UpperLeg_R" | "LowerLeg_R" => (up, left),
        "Foot_L" => (foot, left),
        "Foot_R" => (-foot, left),
        "Toes_L" => (toes, left),
        "Toes_R" => (-toes, left),
        _ => return Quat::identity(),
    };
    Quat::from_matrix(&nalgebra::Matrix3::from_columns(&[x, y, x.cross(&y)]))
}
