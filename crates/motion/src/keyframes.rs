//! Clips of our own, written as poses at times in a readable text.
//!
//! A `*.keys.toml` file describes motion as a person would: at a time the chest leans by an angle, then a foot steps to
//! a place. The main path of [`parse`]: text → `text::Script` (checked numbers) → curves of every joint (`curve`) and
//! both feet (`feet`) → `balance` (position of the weight) → `figure` → [`SourceClip`]. The figure is a small human
//! whose legs reach its feet (`legs`). The source clip is retargeted like captured motion.
//!
//! # The text
//! ```toml
//! about = "bows politely"   # a caption
//! seconds = 4.0
//! fps = 60                  # optional
//! cyclic = false            # optional; a cyclic clip has no steps, and its last pose runs into its first
//! gravity = 9.81            # optional (m/s^2): of flights; of a robot half as tall, twice as much in the figure's metres
//! arm_swing = 0.0           # optional: degrees of shoulder per metre by which the other foot is ahead
//!
//! [[pose]]                  # what is not said in any pose stays as in standing; what is not said in the first or the
//! time = 1.5                # last pose is there as in standing
//! chest = { pitch = 35 }    # degrees: pitch forward, roll to the right, yaw to the left
//! head = { pitch = -10 }
//! pelvis = { z = -0.05 }    # m: forward x, left y, up z, added to where balance puts it; pitch, roll, yaw
//! feet = { heel = 20 }      # both; or left_foot, right_foot: tilt about the toes, or below 0 about the heel
//! arms = { raise = -10 }    # both; or left_arm, right_arm: raise forward, aside, turn inward, elbow, twist of the hand
//!
//! [[step]]                  # a foot that stands nowhere else in between
//! foot = "left"
//! start = 1.0
//! end = 1.6
//! to = [0.2, 0.0]           # m from where it stood at the start of the clip
//! yaw = 20                  # optional, degrees
//! height = 0.06             # optional, m
//! via = [{ time = 1.3, to = [0.3, 0.0], height = 0.3 }]   # optional: places on the way, in order of time
//!
//! [[gait]]                  # a row of steps: foot after foot, each by `by` beyond the other; a last one closes up
//! foot = "left"             # the first to move
//! start = 1.0
//! steps = 8
//! period = 0.6              # from step to step (s)
//! swing = 0.45              # in the air (s)
//! by = [0.3, 0.0]           # m per step
//! height = 0.06             # optional, m
//! ahead = 0.1               # optional: m by which a foot is farther ahead in the middle of its way; or `aside`, outward
//! out = -0.05               # optional: m by which the feet come down outward of their lines
//! early = 0.1               # optional: s by which every second step comes early, as in a limp
//!
//! [[jump]]                  # both feet leave the ground, or one of them while the other is up; it lands by gravity
//! start = 1.5               # take-off (s)
//! height = 0.08             # rise of the centre of mass (m)
//! foot = "left"             # optional; both
//! by = [0.2, 0.0]           # optional, m
//! apart = 0.1               # optional: m by which each foot lands farther out
//! tuck = 0.05               # optional: m by which the soles rise
//! ```
//! Angles are interpolated by quintic polynomials from key to key with continuous velocity and acceleration and without
//! overshoot. A foot's path in the air is a minimum-jerk line, its height a bump that leaves and meets the ground at rest.

use std::path::Path;

use crate::clip::Caption;
use crate::error::MotionError;
use crate::formats::{self, Format, Reader, clip_name};
use crate::source::SourceClip;

mod balance;
mod builtin;
pub mod curve;
mod feet;
mod figure;
mod flight;
mod legs;
mod motion;
mod text;

pub use builtin::{BASIC, builtin};

/// The format, for the table of all.
pub const FORMAT: Format = Format {
    name: "keyframes as text",
    suffixes: &[".keys.toml"],
    shared_suffixes: &[],
    companion: "",
    not_motion: &[],
    clip_name: |_| None,
    // Only by its name: plans are TOML too.
    sniff: |_| false,
    reader: Reader::Source(|bytes, file, _| parse(bytes, file)),
};

/// Makes a clip of a text. `file` is for its name and for messages only.
///
/// # Errors
/// [`MotionError::Parse`] with the line for a text that is not as the module describes, and for steps that overlap.
/// [`MotionError::Unfit`] with the time for a foot that a leg cannot reach.
pub fn parse(bytes: &[u8], file: &Path) -> Result<SourceClip, MotionError> {
    let content = formats::decode(bytes, file)?;
    let script = text::Script::parse(content, file)?;
    let mut clip = motion::animate(&script, &clip_name(file))?;
    if !script.about.is_empty() {
        clip.captions.push(Caption { start: 0.0, end: script.seconds, text: script.about });
    }
    Ok(clip)
}

#[cfg(test)]
mod tests;
