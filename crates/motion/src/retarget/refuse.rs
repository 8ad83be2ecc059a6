//! Refusals: clips that cannot be retargeted, with the reason.

use lifelike_character::Vec3;

use super::feet::{Stance, in_flight};
use super::human::Human;
use crate::contacts::runs;
use crate::error::MotionError;
use crate::source::SourceClip;

/// The longest time (s) in which a leap may keep a person off the ground although no free fall shows at the hips.
const LONGEST_LEAP: f64 = 0.6;

/// Refuses clips of upright people whose feet never rest: their heights cannot be right.
pub(super) fn check_stance(clip: &SourceClip, human: &Human, feet: &[Stance; 2]) -> Result<(), MotionError> {
    let upright = human.frames.iter().filter(|f| (f.pelvis * Vec3::z()).z > 0.7).count();
    let stands = (0..human.frames.len()).any(|t| feet.iter().any(|foot| foot.any(t)));
    if stands || 2 * upright < human.frames.len() {
        return Ok(());
    }
    let message = "an upright person whose feet never rest on the ground: the capture's heights are not credible";
    Err(MotionError::Unfit { clip: clip.name.clone(), message: message.into() })
}

/// Refuses clips in which something other than flat ground carries the person for long.
pub(super) fn check_ground(clip: &SourceClip, human: &Human, feet: &[Stance; 2], fps: f64) -> Result<(), MotionError> {
    let size = human.leg_length / 0.9;
    let flying = in_flight(human, fps);
    let hanging: Vec<bool> = human
        .frames
        .iter()
        .enumerate()
        .map(|(t, f)| f.lowest > 0.17 * size && !flying[t] && !feet.iter().any(|foot| foot.any(t)))
        .collect();
    let longest = runs(&hanging, true).into_iter().max_by_key(|(a, b)| b - a);
    let share = hanging.iter().filter(|h| **h).count() as f64 / hanging.len() as f64;
    match longest {
        Some((a, b)) if (b - a) as f64 > LONGEST_LEAP * fps || share > 0.25 => {
            let height = human.frames[a..b].iter().map(|f| f.lowest).fold(0.0, f64::max);
            let (start, end) = ((a as f64 - human.padding as f64) / fps, (b as f64 - human.padding as f64) / fps);
            let message = format!(
                "from {start:.2} to {end:.2} s the person neither touches flat ground nor falls (lowest point up to \
                 {height:.2} m high): it stands on or hangs from something that is not there"
            );
            Err(MotionError::Unfit { clip: clip.name.clone(), message })
        }
        _ => Ok(()),
    }
}
