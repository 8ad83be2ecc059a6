//! The last step of all changes of style: joints within their ranges, and soles back on the ground.

use lifelike_character::{Anatomy, Character};

use super::joints::column;
use super::parts::joints_of;
use super::poses::{clamp_to_ranges, positions, set_positions};
use crate::clip::{Contacts, MotionClip};
use crate::error::MotionError;
use crate::retarget::rig::Rig;
use crate::retarget::{RetargetOptions, replant};

/// Finishes `edited`, made frame by frame from `before`: joints within their ranges and, where root or legs changed,
/// the soles that stood in `before` on the ground again, by the retargeter's own passes. `options` says how those are
/// to be done.
///
/// # Errors
/// [`MotionError::Mismatch`] when the clip is not the character's, or legs changed of one without soles.
pub fn settle(
    before: &MotionClip,
    mut edited: MotionClip,
    character: &Character,
    anatomy: &Anatomy,
    options: &RetargetOptions,
) -> Result<MotionClip, MotionError> {
    let old = positions(before, character)?;
    clamp_to_ranges(&mut edited, character);
    let moved = |at: usize| column(before, at) != column(&edited, at);
    let root = before.root_position != edited.root_position || before.root_orientation != edited.root_orientation;
    // What has no legs has nothing to put back.
    let legs = joints_of(character, anatomy, &["legs".into()]).unwrap_or_default();
    let mut names = edited.joint_names.iter().enumerate();
    if !root && !names.any(|(at, name)| moved(at) && legs.contains(name)) {
        return Ok(edited);
    }
    let options = RetargetOptions { fps: before.fps, ..options.clone() };
    let rig = Rig::new(character, anatomy, &options)?;
    let new = replant(&rig, &old, &positions(&edited, character)?, &standing(before, &rig), &options);
    set_positions(&mut edited, character, &new);
    Ok(edited)
}

/// Returns whether the left and the right foot stand in each frame, where the clip says so.
pub(super) fn standing(clip: &MotionClip, rig: &Rig) -> [Option<Vec<bool>>; 2] {
    [0, 1].map(|side: usize| {
        let contacts = clip.contacts.as_ref()?;
        let place = place_of(contacts, rig, side)?;
        Some(contacts.flags.iter().skip(place).step_by(contacts.names.len()).copied().collect())
    })
}

/// Writes what [`standing`] reads.
pub(super) fn set_standing(clip: &mut MotionClip, rig: &Rig, standing: &[Option<Vec<bool>>; 2]) {
    let Some(contacts) = &mut clip.contacts else { return };
    for (side, standing) in standing.iter().enumerate() {
        let (Some(standing), Some(place)) = (standing, place_of(contacts, rig, side)) else { continue };
        let width = contacts.names.len();
        contacts.flags.iter_mut().skip(place).step_by(width).zip(standing).for_each(|(flag, stands)| *flag = *stands);
    }
}

/// Place of a foot among the clip's contacts.
fn place_of(contacts: &Contacts, rig: &Rig, side: usize) -> Option<usize> {
    let foot = &rig.character.bodies[rig.legs[side].foot.body].name;
    contacts.names.iter().position(|name| name == foot)
}
