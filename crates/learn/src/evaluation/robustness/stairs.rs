//! A walk turned into a climb in the air: "the in-air stair climbing sequence" of thesis 4.3.3.

use lifelike_motion::contacts::{ContactOptions, clip_contacts};
use lifelike_motion::{MotionClip, MotionError};
use lifelike_robot::Robot;

/// How long the body takes to rise by a step (s): about the time of one swing.
const RISE: f64 = 0.3;
/// Footfalls closer to each other than this are one (s).
const APART: f64 = 0.2;

/// Lifts root and feet of a clip by `step` metres at every footfall, smoothly, and returns how high above level ground each
/// frame then stands (m): the floor that the clip believes in. The whole body rises as one; legs do not bend more than they
/// did.
///
/// # Errors
/// The clip is of another robot.
pub fn climb(clip: &mut MotionClip, robot: &Robot, step: f64) -> Result<Vec<f64>, MotionError> {
    let falls = footfalls(clip, robot)?;
    let height = |frame: usize| {
        let risen = falls.iter().map(|fall| {
            let share = ((frame as f64 - *fall as f64) / (RISE * clip.fps)).clamp(0.0, 1.0);
            share * share * (3.0 - 2.0 * share)
        });
        step * risen.sum::<f64>()
    };
    let lift: Vec<f64> = (0..clip.len()).map(height).collect();
    clip.root_position.iter_mut().zip(&lift).for_each(|(root, lift)| root.z += lift);
    Ok(lift)
}

/// Frames in which a foot comes down.
pub(super) fn footfalls(clip: &MotionClip, robot: &Robot) -> Result<Vec<usize>, MotionError> {
    let root = robot.character.root_joint().map_or(0.9, |joint| robot.default_position()[joint.q_index + 2]);
    let options = ContactOptions::default().scaled(root);
    let contacts = clip_contacts(clip, &robot.character, &robot.anatomy, &options)?;
    let feet = contacts.names.len();
    let lands =
        |t: usize| (0..feet).any(|foot| !contacts.flags[(t - 1) * feet + foot] && contacts.flags[t * feet + foot]);
    let mut falls: Vec<usize> = Vec::new();
    for t in (1..clip.len()).filter(|t| lands(*t)) {
        if falls.last().is_none_or(|last| (t - last) as f64 > APART * clip.fps) {
            falls.push(t);
        }
    }
    Ok(falls)
}
