//! The small human that keyframed clips are written for: 1.70 m, 15 joints, in the T-pose.
//!
//! Shares of mass and places of the segments' centres are those of Winter (2009, table 4.1), rounded. They serve to
//! keep the weight above the feet.

use lifelike_character::{Quat, Vec3};

use crate::source::Skeleton;

pub(super) const PELVIS: usize = 0;
pub(super) const CHEST: usize = 1;
pub(super) const HEAD: usize = 2;
/// Hip, knee, ankle of the left and the right leg.
pub(super) const LEGS: [[usize; 3]; 2] = [[3, 4, 5], [6, 7, 8]];
/// Shoulder, elbow, wrist of the left and the right arm.
pub(super) const ARMS: [[usize; 3]; 2] = [[9, 10, 11], [12, 13, 14]];
pub(super) const JOINTS: usize = 15;

/// Length of thigh and shank (m).
pub(super) const THIGH: f64 = 0.41;
pub(super) const SHANK: f64 = 0.41;
/// Height of the ankle above the sole (m).
pub(super) const ANKLE: f64 = 0.08;
/// Half the distance of the hips, and of the feet in standing (m).
pub(super) const HALF_HIPS: f64 = 0.09;
/// Height of the pelvis in standing (m): knees a little bent, for a stretched leg cannot be controlled.
pub(super) const STANDING: f64 = ANKLE + 0.985 * (THIGH + SHANK);
/// The sole from its ankle: to the heel, to the toes (m).
pub(super) const HEEL: f64 = -0.06;
pub(super) const TOE: f64 = 0.17;

/// Name, parent, offset in the T-pose (m).
const TREE: [(&str, Option<usize>, [f64; 3]); JOINTS] = [
    ("pelvis", None, [0.0, 0.0, 0.0]),
    ("chest", Some(PELVIS), [0.0, 0.0, 0.15]),
    ("head", Some(CHEST), [0.0, 0.0, 0.40]),
    ("left_hip", Some(PELVIS), [0.0, HALF_HIPS, 0.0]),
    ("left_knee", Some(3), [0.0, 0.0, -THIGH]),
    ("left_ankle", Some(4), [0.0, 0.0, -SHANK]),
    ("right_hip", Some(PELVIS), [0.0, -HALF_HIPS, 0.0]),
    ("right_knee", Some(6), [0.0, 0.0, -THIGH]),
    ("right_ankle", Some(7), [0.0, 0.0, -SHANK]),
    ("left_shoulder", Some(CHEST), [0.0, 0.18, 0.33]),
    ("left_elbow", Some(9), [0.0, 0.29, 0.0]),
    ("left_wrist", Some(10), [0.0, 0.25, 0.0]),
    ("right_shoulder", Some(CHEST), [0.0, -0.18, 0.33]),
    ("right_elbow", Some(12), [0.0, -0.29, 0.0]),
    ("right_wrist", Some(13), [0.0, -0.25, 0.0]),
];

/// Share of the body's mass, and its centre in the joint's frame (m).
const MASSES: [(f64, [f64; 3]); JOINTS] = [
    (0.142, [0.0, 0.0, 0.04]),
    (0.355, [0.0, 0.0, 0.20]),
    (0.081, [0.0, 0.0, 0.13]),
    (0.100, [0.0, 0.0, -0.433 * THIGH]),
    (0.0465, [0.0, 0.0, -0.433 * SHANK]),
    (0.0145, [0.05, 0.0, -0.05]),
    (0.100, [0.0, 0.0, -0.433 * THIGH]),
    (0.0465, [0.0, 0.0, -0.433 * SHANK]),
    (0.0145, [0.05, 0.0, -0.05]),
    (0.028, [0.0, 0.436 * 0.29, 0.0]),
    (0.016, [0.0, 0.43 * 0.25, 0.0]),
    (0.006, [0.0, 0.08, 0.0]),
    (0.028, [0.0, -0.436 * 0.29, 0.0]),
    (0.016, [0.0, -0.43 * 0.25, 0.0]),
    (0.006, [0.0, -0.08, 0.0]),
];

/// Returns the skeleton that every keyframed clip has.
pub(super) fn skeleton() -> Skeleton {
    let mut ends = vec![(HEAD, Vec3::new(0.0, 0.0, 0.26))];
    for (side, sign) in [1.0, -1.0].into_iter().enumerate() {
        ends.push((LEGS[side][2], Vec3::new(TOE, 0.0, -ANKLE)));
        ends.push((LEGS[side][2], Vec3::new(HEEL, 0.0, -ANKLE)));
        ends.push((ARMS[side][2], Vec3::new(0.0, sign * 0.17, 0.0)));
    }
    Skeleton {
        names: TREE.iter().map(|(name, ..)| (*name).to_owned()).collect(),
        parents: TREE.iter().map(|(_, parent, _)| *parent).collect(),
        offsets: TREE.iter().map(|(.., offset)| Vec3::from(*offset)).collect(),
        ends,
    }
}

/// Returns the world positions and rotations of the joints.
pub(super) fn place(root: &Vec3, rotations: &[Quat]) -> (Vec<Vec3>, Vec<Quat>) {
    let (mut places, mut turns): (Vec<Vec3>, Vec<Quat>) = (Vec::with_capacity(JOINTS), Vec::with_capacity(JOINTS));
    for (joint, (_, parent, offset)) in TREE.iter().enumerate() {
        match parent {
            None => {
                places.push(*root);
                turns.push(rotations[joint]);
            }
            Some(parent) => {
                places.push(places[*parent] + turns[*parent] * Vec3::from(*offset));
                turns.push(turns[*parent] * rotations[joint]);
            }
        }
    }
    (places, turns)
}

/// Returns the centre of mass (m, world) of a posture from [`place`].
pub(super) fn centre_of_mass(places: &[Vec3], turns: &[Quat]) -> Vec3 {
    let mut sum = Vec3::zeros();
    let mut mass = 0.0;
    for ((share, centre), (place, turn)) in MASSES.iter().zip(places.iter().zip(turns)) {
        sum += (place + turn * Vec3::from(*centre)) * *share;
        mass += share;
    }
    sum / mass
}
