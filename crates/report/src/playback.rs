//! A recorded motion to look at.

use lifelike_character::rotation::to_wxyz;
use lifelike_character::{Anatomy, Character, Kinematics, Quat, Vec3};
use lifelike_motion::{MotionClip, MotionError, Skeleton, SourceClip};
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
    /// Feet with their contacts.
    pub feet: Vec<Foot>,
    /// Names of the joints that are drawn over time.
    pub joint_names: Vec<String>,
    /// Positions of these joints (rad or m), `[frame][joint]`, of `simulated` and of `reference`. Either may be empty.
    pub joints: [Vec<Vec<f64>>; 2],
    /// Skeleton of `reference` where that is no motion of the character: of the human a motion was captured from.
    pub skeleton: Option<Skeleton>,
}

/// A foot and its contacts, frame by frame.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Foot {
    /// Its body.
    pub body: usize,
    /// Middle of its sole in the body's frame (m).
    pub middle: Vec3,
    /// Ground force in physics as a share of the weight; empty without physics.
    pub force: Vec<f32>,
    /// Contact in the reference.
    pub down: Vec<bool>,
}

impl Default for Playback {
    fn default() -> Self {
        Self {
            name: String::new(),
            note: String::new(),
            fps: 1.0,
            simulated: Vec::new(),
            reference: Vec::new(),
            fall: None,
            labels: Self::PHYSICS,
            feet: Vec::new(),
            joint_names: Vec::new(),
            joints: [Vec::new(), Vec::new()],
            skeleton: None,
        }
    }
}

impl Playback {
    /// Names of a simulated motion beside its reference.
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
        let joints = (0..clip.len()).map(|frame| clip.joints_at(frame).to_vec()).collect();
        let (name, joint_names) = (clip.name.clone(), clip.joint_names.clone());
        Ok(Self { name, fps: clip.fps, reference, joint_names, joints: [Vec::new(), joints], ..Self::default() })
    }

    /// Adds the contacts of the clip that this playback was made from.
    pub fn with_contacts(mut self, character: &Character, anatomy: &Anatomy, clip: &MotionClip) -> Self {
        let Some(contacts) = &clip.contacts else { return self };
        for (column, name) in contacts.names.iter().enumerate() {
            let is_it = |body: usize| character.bodies.get(body).is_some_and(|body| body.name == *name);
            let Some(sole) = anatomy.soles.values().find(|sole| is_it(sole.body)) else { continue };
            let down = contacts.flags.iter().skip(column).step_by(contacts.names.len()).copied().collect();
            self.feet.push(Foot { body: sole.body, middle: sole.middle(), force: Vec::new(), down });
        }
        self
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
        let [[_, was], [_, is]] = [before.joints, after.joints];
        Ok(Self {
            simulated: after.reference,
            reference: before.reference,
            labels: ["after", "before"],
            joints: [is, was],
            ..after
        })
    }

    /// Puts the human that a clip was captured from beside it: scaled by `scale`, `tempo` times as fast, and moved to where
    /// the clip begins.
    pub fn beside_source(self, source: &SourceClip, scale: f64, tempo: f64) -> Self {
        let frames = self.reference.len();
        let at = |frame: usize| {
            let time = frame as f64 / self.fps * tempo;
            world_poses(source, (time * source.fps).round() as usize, scale)
        };
        let mut human: Vec<Vec<BodyPose>> = (0..frames).map(at).collect();
        let start = |poses: &[Vec<BodyPose>]| poses.first().and_then(|p| p.get(1)).map_or_else(Vec3::zeros, |p| p.0);
        let mut shift = start(&self.reference) - start(&human);
        shift.z = 0.0;
        human.iter_mut().flat_map(|frame| frame.iter_mut().skip(1)).for_each(|pose| pose.0 += shift);
        let mut skeleton = source.skeleton.clone();
        skeleton.offsets.iter_mut().chain(skeleton.ends.iter_mut().map(|(_, offset)| offset)).for_each(|o| *o *= scale);
        let [_, joints] = self.joints;
        Self {
            simulated: self.reference,
            reference: human,
            labels: ["robot", "human"],
            joints: [joints, Vec::new()],
            skeleton: Some(skeleton),
            ..self
        }
    }

    /// Returns the playback as the page reads it, of these characters on the page. `bodies` counts the world.
    pub(super) fn to_json(&self, character: usize, reference: usize, bodies: usize) -> Value {
        let frames = match (self.simulated.len(), self.reference.len()) {
            (0, n) | (n, 0) => n,
            (a, b) => a.min(b),
        };
        let stride = (self.fps / MOST_FPS).ceil().max(1.0) as usize;
        let kept: Vec<usize> = (0..frames).step_by(stride).collect();
        let track = |poses: &[Vec<BodyPose>], bodies: usize| {
            if poses.is_empty() { Value::Null } else { pack(poses, &kept, bodies) }
        };
        let shadow = self.skeleton.as_ref().map_or(bodies, |skeleton| skeleton.names.len() + 1);
        let foot = |foot: &Foot| {
            let down: Vec<u8> = kept.iter().map(|f| u8::from(foot.down.get(*f).copied().unwrap_or(false))).collect();
            let share =
                |f: &usize| (foot.force.get(*f).copied().unwrap_or(0.0) * 100.0).round().clamp(0.0, 255.0) as u8;
            let force: Vec<u8> = kept.iter().filter(|_| !foot.force.is_empty()).map(share).collect();
            let at = [foot.middle.x, foot.middle.y, foot.middle.z];
            json!({ "body": foot.body.saturating_sub(1), "at": at, "down": encode(&down), "force": encode(&force) })
        };
        let angles = |joints: &Vec<Vec<f64>>| {
            let rows = kept.iter().filter_map(|f| joints.get(*f)).flatten();
            // Ten thousandths of a radian or metre.
            encode(&rows.flat_map(|q| ((q * 1e4).round() as i16).to_le_bytes()).collect::<Vec<u8>>())
        };
        json!({
            "name": self.name,
            "note": self.note,
            "character": character,
            "referenceCharacter": reference,
            "fps": self.fps / stride as f64,
            "frames": kept.len(),
            "fall": self.fall,
            "labels": self.labels,
            "simulated": track(&self.simulated, bodies),
            "reference": track(&self.reference, shadow),
            "feet": self.feet.iter().map(foot).collect::<Vec<_>>(),
            "jointNames": self.joint_names,
            "joints": self.joints.each_ref().map(angles),
        })
    }
}

/// Poses of a captured skeleton's joints in one frame, the world first; the last frame where there are no more.
fn world_poses(source: &SourceClip, frame: usize, scale: f64) -> Vec<BodyPose> {
    let (positions, rotations) = source.pose(frame.min(source.len().saturating_sub(1)));
    let joints = positions.into_iter().map(|p| p * scale).zip(rotations);
    std::iter::once((Vec3::zeros(), Quat::identity())).chain(joints).collect()
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
            name: "a".into(),
            fps: 50.0,
            simulated: still(101, 0.0),
            reference: still(90, 0.0),
            feet: vec![Foot { body: 2, force: vec![0.5, 9.0, 1.2], ..Foot::default() }],
            joints: [vec![vec![0.25]; 3], Vec::new()],
            ..Playback::default()
        };
        let json = playback.to_json(0, 0, 3);
        let mut force = vec![0_u8; 45];
        (force[0], force[1]) = (50, 120);
        assert_eq!(
            json["feet"][0]["force"],
            encode(&force),
            "per cent of the weight; nothing where nothing was recorded"
        );
        assert_eq!(json["joints"][0], encode(&[0xc4, 0x09, 0xc4, 0x09]), "2500 of ten thousandths, frames 0 and 2");
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
