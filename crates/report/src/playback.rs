//! A recorded motion to look at.

use lifelike_character::rotation::to_wxyz;
use lifelike_character::{Character, Kinematics, Quat, Vec3};
use lifelike_motion::{MotionClip, MotionError};
use serde_json::{Value, json};

use super::base64::encode;

/// Pose of one body's frame: position (m, world) and orientation.
pub type BodyPose = (Vec3, Quat);

/// Frames per second that the page keeps at most; it interpolates between them.
const MOST_FPS: f64 = 30.0;

/// Physics beside its reference, or one of the two.
///
/// # Shapes
/// `simulated` and `reference` are `[frame][body]` with the world as body 0, in the character's order of bodies. Either
/// may be empty; otherwise the shorter one decides the length.
#[derive(Debug, Clone, PartialEq)]
pub struct Playback {
    /// The clip.
    pub name: String,
    /// A few words about it, such as `2.4° · survived`.
    pub note: String,
    /// Frames per second.
    pub fps: f64,
    /// Simulated poses.
    pub simulated: Vec<Vec<BodyPose>>,
    /// Reference poses.
    pub reference: Vec<Vec<BodyPose>>,
    /// Time of the fall (s).
    pub fall: Option<f64>,
    /// Names of `simulated` and `reference` on the page: [`Self::PHYSICS`] but for comparisons of something else.
    pub labels: [&'static str; 2],
}

impl Playback {
    /// Returns a playback of a simulated motion beside its reference.
    pub const PHYSICS: [&'static str; 2] = ["physics", "reference"];

    /// Returns a clip as it is, without physics.
    ///
    /// # Errors
    /// [`MotionError::Mismatch`] when the clip is of another character.
    pub fn from_clip(character: &Character, clip: &MotionClip) -> Result<Self, MotionError> {
        let columns = clip.columns_for(character)?;
        let mut kinematics = Kinematics::new(character);
        let mut q = character.reference_position();
        let reference = (0..clip.len())
            .map(|frame| {
                clip.write_position(character, &columns, frame, &mut q);
                kinematics.update(character, &q);
                kinematics.body_position.iter().copied().zip(kinematics.body_orientation.iter().copied()).collect()
            })
            .collect();
        let name = clip.name.clone();
        let labels = Self::PHYSICS;
        Ok(Self { name, note: String::new(), fps: clip.fps, simulated: Vec::new(), reference, fall: None, labels })
    }

    /// Returns a clip and what became of it, to be looked at together.
    ///
    /// # Errors
    /// [`MotionError::Mismatch`] when a clip is of another character.
    pub fn before_and_after(
        character: &Character,
        before: &MotionClip,
        after: &MotionClip,
    ) -> Result<Self, MotionError> {
        let (before, after) = (Self::from_clip(character, before)?, Self::from_clip(character, after)?);
        Ok(Self { simulated: after.reference, reference: before.reference, labels: ["after", "before"], ..after })
    }

    /// Returns the playback as the page reads it. `bodies` counts the world.
    pub(super) fn to_json(&self, character: usize, bodies: usize) -> Value {
        let frames = match (self.simulated.len(), self.reference.len()) {
            (0, n) | (n, 0) => n,
            (a, b) => a.min(b),
        };
        let stride = (self.fps / MOST_FPS).ceil().max(1.0) as usize;
        let kept: Vec<usize> = (0..frames).step_by(stride).collect();
        let track = |poses: &[Vec<BodyPose>]| {
            if poses.is_empty() { Value::Null } else { pack(poses, &kept, bodies) }
        };
        json!({
            "name": self.name,
            "note": self.note,
            "character": character,
            "fps": self.fps / stride as f64,
            "frames": kept.len(),
            "fall": self.fall,
            "labels": self.labels,
            "simulated": track(&self.simulated),
            "reference": track(&self.reference),
        })
    }
}

/// Root positions as f32, then every body (the first is the root) as seven i16: position less root in units of `unit`
/// metres, quaternion wxyz in units of 1/32767. A millimetre of a small robot takes tens of units.
fn pack(poses: &[Vec<BodyPose>], kept: &[usize], bodies: usize) -> Value {
    // A simulation that diverged may have left anything; the page shows it at the origin.
    let finite = |v: Vec3| if v.iter().all(|c| c.is_finite()) { v } else { Vec3::zeros() };
    let position = |frame: usize, body: usize| poses[frame].get(body).map_or_else(Vec3::zeros, |p| finite(p.0));
    let reach = kept
        .iter()
        .flat_map(|&f| (1..bodies).map(move |b| (f, b)))
        .map(|(f, b)| (position(f, b) - position(f, 1)).amax())
        .fold(0.0, f64::max);
    let unit = (reach / 32_767.0).max(1e-9);
    let mut bytes: Vec<u8> = Vec::with_capacity(kept.len() * (12 + 14 * bodies));
    for &frame in kept {
        position(frame, 1).iter().for_each(|c| bytes.extend((*c as f32).to_le_bytes()));
    }
    for &frame in kept {
        let root = position(frame, 1);
        for body in 1..bodies {
            let shift = (position(frame, body) - root) / unit;
            let turn = poses[frame].get(body).map_or([1.0, 0.0, 0.0, 0.0], |p| to_wxyz(&p.1)).map(|c| c * 32_767.0);
            // `as` saturates, and takes what is not a number to zero.
            shift.iter().chain(&turn).for_each(|c| bytes.extend((c.round() as i16).to_le_bytes()));
        }
    }
    json!({ "unit": unit, "data": encode(&bytes) })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn still(frames: usize, x: f64) -> Vec<Vec<BodyPose>> {
        let body = |x, z| (Vec3::new(x, 0.0, z), Quat::identity());
        vec![vec![body(0.0, 0.0), body(x, 1.0), body(x + 0.25, 1.5)]; frames]
    }

    #[test]
    fn positions_are_packed_relative_to_the_root() {
        let packed = pack(&still(1, 2.0), &[0], 3);
        let unit = packed["unit"].as_f64().unwrap_or_default();
        assert!((unit - 0.5 / 32_767.0).abs() < 1e-12, "the farthest body is half a metre away: {unit}");
        let mut expected: Vec<u8> = Vec::new();
        [2.0_f32, 0.0, 1.0].iter().for_each(|c| expected.extend(c.to_le_bytes()));
        let root: [i16; 7] = [0, 0, 0, 32_767, 0, 0, 0];
        let hand: [i16; 7] = [16_384, 0, 32_767, 32_767, 0, 0, 0];
        root.iter().chain(&hand).for_each(|c| expected.extend(c.to_le_bytes()));
        assert_eq!(packed["data"], encode(&expected));
    }

    #[test]
    fn high_rates_are_thinned_and_the_duration_stays() {
        let playback = Playback {
            labels: Playback::PHYSICS,
            name: "a".into(),
            note: String::new(),
            fps: 50.0,
            simulated: still(101, 0.0),
            reference: still(90, 0.0),
            fall: None,
        };
        let json = playback.to_json(0, 3);
        assert_eq!(json["fps"], 25.0);
        assert_eq!(json["frames"], 45, "the shorter of the two, every second frame");
    }

    #[test]
    fn what_diverged_is_no_obstacle() {
        let mut poses = still(1, 0.0);
        poses[0][2].0 = Vec3::new(f64::NAN, 0.0, 0.0);
        assert!(pack(&poses, &[0], 3)["unit"].as_f64().is_some_and(f64::is_finite));
    }
}
