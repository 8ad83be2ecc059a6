//! `generate --pose`: poses of clips that the motion passes through.

use std::path::PathBuf;
use std::str::FromStr;

use lifelike_generation::generator::{Generator, Given, Pose};
use lifelike_generation::representation::FeatureMatrix;
use lifelike_robot::Robot;

use super::maker::Kept;
use crate::commands::clips;
use crate::error::CliError;

/// A frame of a clip, and the moment at which a motion shall be in its pose.
#[derive(Debug, Clone, PartialEq)]
pub struct PoseAt {
    clip: PathBuf,
    /// Time of the frame in the clip (s).
    at: f64,
    /// The moment (s).
    seconds: f64,
}

impl FromStr for PoseAt {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || format!("expected CLIP@SECONDS or CLIP:TIME@SECONDS, such as 'builtin:bow:1.2@3', got '{text}'");
        let time = |text: &str| text.parse().ok().filter(|time: &f64| time.is_finite() && *time >= 0.0);
        let (clip, seconds) = text.rsplit_once('@').ok_or_else(wrong)?;
        let seconds = time(seconds).ok_or_else(wrong)?;
        let (clip, at) = match clip.rsplit_once(':').and_then(|(clip, at)| Some((clip, time(at)?))) {
            Some((clip, at)) => (clip, at),
            None => (clip, 0.0),
        };
        if clip.is_empty() {
            return Err(wrong());
        }
        Ok(Self { clip: clip.into(), at, seconds })
    }
}

impl PoseAt {
    /// Returns the row of the frame in the generator's layout, and the licence of the clip.
    fn read(&self, robot: &Robot, generator: &Generator) -> Result<(Pose, String), CliError> {
        let clip = clips::load_one(&self.clip, robot)?;
        let spec = &generator.header().spec;
        let rows = FeatureMatrix::from_clip(&clip, spec)?;
        let row = (self.at * spec.fps).round();
        if row >= rows.n as f64 {
            let last = (rows.n - 1) as f64 / spec.fps;
            let text = format!("--pose: expected a time of '{}' up to {last:.2} s, got {} s", clip.name, self.at);
            return Err(CliError::Input(text));
        }
        let first = row as usize * rows.width;
        let row = rows.rows[first..first + rows.width].to_vec();
        Ok((Pose { seconds: self.seconds, row }, clip.provenance.licence))
    }
}

/// Reads the poses that a motion passes through.
pub fn read(poses: &[PoseAt], robot: &Robot, generator: &Generator) -> Result<Kept, CliError> {
    let (mut given, mut licences, mut words) = (Vec::new(), Vec::new(), Vec::new());
    for pose in poses {
        let (row, licence) = pose.read(robot, generator)?;
        given.push(row);
        words.push(format!("'{}' at {} s", pose.clip.display(), pose.seconds));
        if !licence.is_empty() && !licences.contains(&licence) {
            licences.push(licence);
        }
    }
    Ok(Kept::new(Given::Poses(given), format!("poses of {}", words.join(", ")), licences.join("; ")))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn a_pose_is_a_clip_a_time_in_it_and_a_moment() {
        let pose = |text: &str| text.parse::<PoseAt>().unwrap();
        let expected = |clip: &str, at, seconds| PoseAt { clip: clip.into(), at, seconds };
        assert_eq!(pose("a.motion.safetensors@2"), expected("a.motion.safetensors", 0.0, 2.0));
        assert_eq!(pose("builtin:bow@0.5"), expected("builtin:bow", 0.0, 0.5));
        assert_eq!(pose("builtin:bow:1.2@3"), expected("builtin:bow", 1.2, 3.0));
        for text in ["builtin:bow", "builtin:bow@", "@2", "builtin:bow@-1", "builtin:bow@nan"] {
            let error = text.parse::<PoseAt>().unwrap_err();
            assert!(error.contains("CLIP@SECONDS") && error.contains(text), "{error}");
        }
    }
}
