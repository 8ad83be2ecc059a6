//! A clip as generalised positions (MuJoCo's layout), and back.

use lifelike_character::rotation::from_wxyz;
use lifelike_character::{Character, Vec3};

use super::joints::{column, set_column};
use super::path::continuous;
use crate::clip::MotionClip;
use crate::error::MotionError;

/// Returns the generalised position of every frame.
///
/// # Errors
/// [`MotionError::Mismatch`] when the clip's joints are not the character's, [`MotionError::Unfit`] for a clip that is
/// not consistent.
pub(super) fn positions(clip: &MotionClip, character: &Character) -> Result<Vec<Vec<f64>>, MotionError> {
    clip.check()?;
    let columns = clip.columns_for(character)?;
    let frame = |t| {
        let mut q = character.reference_position();
        clip.write_position(character, &columns, t, &mut q);
        q
    };
    Ok((0..clip.len()).map(frame).collect())
}

/// Writes generalised positions into a clip of as many frames, in the clip's own order of joints.
pub(super) fn set_positions(clip: &mut MotionClip, character: &Character, positions: &[Vec<f64>]) {
    let root = character.root_joint().map(|joint| joint.q_index);
    let width = clip.joint_names.len();
    let of = |name: &String| character.scalar_joints().find(|joint| &joint.name == name).map(|joint| joint.q_index);
    let places: Vec<Option<usize>> = clip.joint_names.iter().map(of).collect();
    for (t, q) in positions.iter().enumerate() {
        if let Some(at) = root {
            clip.root_position[t] = Vec3::new(q[at], q[at + 1], q[at + 2]);
            if let Some(turn) = from_wxyz([q[at + 3], q[at + 4], q[at + 5], q[at + 6]]) {
                clip.root_orientation[t] = turn;
            }
        }
        for (value, place) in clip.joints[t * width..].iter_mut().zip(&places) {
            *value = place.map_or(*value, |at| q[at]);
        }
    }
    continuous(&mut clip.root_orientation);
}

/// Puts every joint into its range.
pub(super) fn clamp_to_ranges(clip: &mut MotionClip, character: &Character) {
    for joint in character.scalar_joints() {
        let at = clip.joint_names.iter().position(|name| *name == joint.name);
        if let (Some(at), Some((low, high))) = (at, joint.range) {
            let within: Vec<f64> = column(clip, at).iter().map(|v| v.max(low).min(high)).collect();
            set_column(clip, at, &within);
        }
    }
}
