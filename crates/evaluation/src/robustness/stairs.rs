//! A walk turned into a climb in the air: "the in-air stair climbing sequence" of thesis 4.3.3.

use lifelike_motion::contacts::{ContactOptions, clip_contacts};
use lifelike_motion::edit::trim;
use lifelike_motion::resample::resample;
use lifelike_motion::{MotionClip, MotionError};
use lifelike_robot::Robot;

use crate::EvaluationOptions;
use crate::schedule::start_frames;

/// Time that the body takes to rise by a step (s): about the time of one swing.
const RISE: f64 = 0.3;
/// Footfalls closer to each other than this are one (s).
const APART: f64 = 0.2;

/// A clip with fewer footfalls than this climbs no stairs.
const FOOTFALLS: usize = 2;

/// The clips that walk, each as it goes on from each of its `starts`, so that every climb begins on the ground. Cycles begin
/// at their beginning.
///
/// # Errors
/// A clip is of another robot.
pub fn stair_clips(
    clips: &[MotionClip],
    robot: &Robot,
    options: &EvaluationOptions,
) -> Result<Vec<MotionClip>, MotionError> {
    let mut all = Vec::new();
    for clip in clips {
        let clip = resample(clip, robot.control_hz)?;
        let episode = (options.seconds * robot.control_hz).round().max(1.0) as usize;
        let starts = if clip.cyclic { 1 } else { options.starts };
        for start in start_frames(clip.len(), episode, starts, false) {
            let rest = if start > 0 { trim(&clip, Some(start as f64 / clip.fps), None)? } else { clip.clone() };
            if footfalls(&rest, robot)?.len() >= FOOTFALLS {
                all.push(MotionClip { name: format!("{} from {start}", clip.name), ..rest });
            }
        }
    }
    Ok(all)
}

/// Lifts root and feet of a clip smoothly by `step` metres at every footfall, and returns each frame's height above
/// level ground (m): the floor that the clip believes in. The whole body rises as one; legs do not bend more than they
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

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use std::path::Path;

    use lifelike_motion::keyframes;
    use lifelike_motion::retarget::{RetargetOptions, retarget};

    use super::*;

    #[test]
    fn every_climb_begins_on_the_ground_and_rises_with_each_footfall() {
        let robot = Robot::load("lima").unwrap();
        let clips: Vec<MotionClip> = keyframes::builtin()
            .filter(|(name, _)| ["walk", "bow"].contains(name))
            .map(|(name, text)| {
                let source = keyframes::parse(text.as_bytes(), Path::new(name)).unwrap();
                let options = RetargetOptions { fps: robot.control_hz, ..RetargetOptions::default() };
                retarget(&source, &robot.character, &robot.anatomy, &options).unwrap().0
            })
            .collect();
        assert_eq!(clips.len(), 2);
        let options = EvaluationOptions { seconds: 3.0, starts: 3, ..EvaluationOptions::default() };
        let climbing = stair_clips(&clips, &robot, &options).unwrap();
        assert!(!climbing.is_empty() && climbing.iter().all(|c| c.name.starts_with("walk")), "nobody climbs by bowing");
        for clip in climbing {
            let (mut lifted, falls) = (clip.clone(), footfalls(&clip, &robot).unwrap().len());
            let lift = climb(&mut lifted, &robot, 0.1).unwrap();
            assert_eq!(lift[0], 0.0);
            assert_eq!(lifted.root_position[0], clip.root_position[0]);
            assert!(*lift.last().unwrap() > 0.1 * (falls as f64 - 1.0), "{} after {falls}", lift.last().unwrap());
        }
    }
}
