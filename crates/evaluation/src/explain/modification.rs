//! Changes that make a clip easier.

use lifelike_character::{Character, Kinematics, Vec3};
use lifelike_motion::edit::{Warp, warp};
use lifelike_motion::{MotionClip, MotionError};
use lifelike_robot::Robot;

/// One change of a whole clip.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ClipModification {
    /// This many times as long.
    Slower(f64),
    /// Joints deviate from their mean by this share of what they did, and the root goes this share of its way. Soles
    /// are as high as they were.
    Smaller(f64),
}

impl ClipModification {
    /// Modifications that are tried, as factors, the mildest first.
    pub const ALL: [Self; 11] = [
        Self::Slower(1.1),
        Self::Smaller(0.9),
        Self::Slower(1.2),
        Self::Smaller(0.8),
        Self::Slower(1.35),
        Self::Smaller(0.7),
        Self::Slower(1.5),
        Self::Smaller(0.6),
        Self::Slower(1.75),
        Self::Smaller(0.5),
        Self::Slower(2.0),
    ];

    /// Returns the factor on the clip's length.
    pub fn stretch(self) -> f64 {
        if let Self::Slower(factor) = self { factor } else { 1.0 }
    }

    /// In words.
    pub fn words(self) -> String {
        match self {
            Self::Slower(factor) => format!("{factor} times slower"),
            Self::Smaller(share) => format!("attenuated to {share}"),
        }
    }

    /// The changed clip, at the rate it had. Its name and its provenance say what was done.
    ///
    /// # Errors
    /// The clip is of another robot.
    pub fn apply(self, clip: &MotionClip, robot: &Robot) -> Result<MotionClip, MotionError> {
        let mut changed = match self {
            Self::Slower(factor) => warp(clip, &Warp::Speed(1.0 / factor))?,
            Self::Smaller(share) => attenuated(clip, robot, share)?,
        };
        changed.name = match self {
            Self::Slower(factor) => format!("{}-slower{factor}", clip.name),
            Self::Smaller(share) => format!("{}-smaller{share}", clip.name),
        };
        let source = &mut changed.provenance.source;
        source.push_str(if source.is_empty() { "" } else { "; " });
        source.push_str(&format!("modified for {}: {}", robot.name, self.words()));
        Ok(changed)
    }
}

fn attenuated(clip: &MotionClip, robot: &Robot, share: f64) -> Result<MotionClip, MotionError> {
    let character = &robot.character;
    let columns = clip.columns_for(character)?;
    let mut changed = clip.clone();
    let (frames, joints) = (clip.len(), clip.joint_names.len());
    for joint in 0..joints {
        let column = || clip.joints.iter().skip(joint).step_by(joints);
        let mean = column().sum::<f64>() / frames.max(1) as f64;
        for (to, from) in changed.joints.iter_mut().skip(joint).step_by(joints).zip(column()) {
            *to = mean + share * (from - mean);
        }
    }
    let first = clip.root_position.first().copied().unwrap_or_else(Vec3::zeros);
    for root in &mut changed.root_position {
        root.x = first.x + share * (root.x - first.x);
        root.y = first.y + share * (root.y - first.y);
    }
    let (before, after) = (lowest_soles(clip, robot, &columns), lowest_soles(&changed, robot, &columns));
    changed.root_position.iter_mut().zip(before.iter().zip(&after)).for_each(|(root, (b, a))| root.z += b - a);
    // Feet that hardly leave the ground any more do so at other moments.
    changed.contacts = None;
    Ok(changed)
}

/// Height of the lowest sole of each frame (m), of the root where there are no soles.
pub(super) fn lowest_soles(clip: &MotionClip, robot: &Robot, columns: &[usize]) -> Vec<f64> {
    let character: &Character = &robot.character;
    let mut kinematics = Kinematics::new(character);
    let mut q = character.reference_position();
    (0..clip.len())
        .map(|frame| {
            clip.write_position(character, columns, frame, &mut q);
            kinematics.update(character, &q);
            let soles = robot.anatomy.soles.values();
            let corners = soles.flat_map(|sole| sole.corners.iter().map(|c| kinematics.point(sole.body, c).z));
            let lowest = corners.fold(f64::INFINITY, f64::min);
            if lowest.is_finite() { lowest } else { clip.root_position[frame].z }
        })
        .collect()
}
