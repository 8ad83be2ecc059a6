//! Columns that carry the names of other joints.

use lifelike_character::{Character, Symmetry};

use crate::clip::MotionClip;

/// An order of joints that other programs write.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum JointOrder {
    /// Left and right change places.
    OtherSide,
    /// Level after level of the tree (Isaac Lab), under names limb after limb (MuJoCo).
    BreadthFirst,
    /// Limb after limb, under names level after level.
    DepthFirst,
    /// From the last joint to the first.
    Reversed,
}

impl JointOrder {
    pub(super) const ALL: [Self; 4] = [Self::OtherSide, Self::BreadthFirst, Self::DepthFirst, Self::Reversed];

    /// Returns the clip with every column under its own name: none if the order is the same.
    pub(super) fn corrected(self, clip: &MotionClip, character: &Character, columns: &[usize]) -> Option<MotionClip> {
        let joints: Vec<(&str, usize)> =
            character.scalar_joints().map(|joint| (joint.name.as_str(), depth(character, joint.body))).collect();
        let mut levels: Vec<usize> = (0..joints.len()).collect();
        levels.sort_by_key(|&joint| joints[joint].1);
        // Joint whose values each place holds.
        let held: Vec<usize> = match self {
            // By the mirror image of the body, whatever its joints are called; by names where it has none.
            Self::OtherSide => Symmetry::derive(character).map(|symmetry| symmetry.joint).unwrap_or_else(|_| {
                let partner = |name: &str| joints.iter().position(|(other, _)| *other == other_side(name));
                joints.iter().enumerate().map(|(i, (name, _))| partner(name).unwrap_or(i)).collect()
            }),
            Self::BreadthFirst => levels,
            Self::DepthFirst => {
                let mut places = vec![0; levels.len()];
                levels.iter().enumerate().for_each(|(place, &joint)| places[joint] = place);
                places
            }
            Self::Reversed => (0..joints.len()).rev().collect(),
        };
        if held.iter().enumerate().all(|(place, joint)| place == *joint) {
            return None;
        }
        let mut corrected = clip.clone();
        let width = columns.len();
        for (to, from) in corrected.joints.chunks_exact_mut(width).zip(clip.joints.chunks_exact(width)) {
            held.iter().enumerate().for_each(|(place, &joint)| to[columns[joint]] = from[columns[place]]);
        }
        Some(corrected)
    }
}

fn depth(character: &Character, body: usize) -> usize {
    std::iter::successors(Some(body), |&b| (b != 0).then(|| character.bodies[b].parent)).count()
}

fn other_side(name: &str) -> String {
    if name.contains("left") { name.replace("left", "right") } else { name.replace("right", "left") }
}
