//! Motion to follow, at the policy's rate, in flat arrays.

use std::collections::BTreeSet;

use lifelike_character::rotation::{from_wxyz, to_wxyz};
use lifelike_character::{JointKind, Kinematics, Vec3};
use lifelike_checkpoint::rng::stream;
use lifelike_motion::features::frames_of;
use lifelike_motion::resample::resample;
use lifelike_motion::{FeatureLayout, MotionClip};
use rand::seq::SliceRandom;
use sha2::{Digest, Sha256};

use super::encoder::LatentEncoder;
use crate::robot::Robot;
use crate::{FromInput, RobotError};

/// Air below a robot that begins in a frame (m): a foot that begins in the ground is thrown out of it.
const START_CLEARANCE: f64 = 0.002;

/// A sole of the reference lower than this is on the ground (m): retargeted feet stand within a millimetre of it, and swing
/// at least two centimetres above.
pub const SOLE_DOWN: f64 = 0.005;

/// Every frame of every clip, clip after clip. `T` frames in all, `J` joints, `E` end effectors, `F` features.
#[derive(Debug, Clone, PartialEq)]
pub struct ReferenceLibrary {
    /// Names of joints and end effectors.
    pub layout: FeatureLayout,
    /// Clip names.
    pub names: Vec<String>,
    /// First frame of each clip, and T at the end.
    pub starts: Vec<usize>,
    /// Root position, `[T, 3]` (m, the clip's world).
    pub root_position: Vec<f32>,
    /// Root orientation, `[T, 4]` (`wxyz`).
    pub root_orientation: Vec<f32>,
    /// Root linear velocity, `[T, 3]` (m/s, the clip's world).
    pub linear_velocity_w: Vec<f32>,
    /// Root angular velocity, `[T, 3]` (rad/s, the clip's world).
    pub angular_velocity_w: Vec<f32>,
    /// Features of eq. 4.1, each frame in its own heading frame (thesis 4.2.2, W = 0), `[T, F]`.
    pub features: Vec<f32>,
    /// Standard deviation of each feature over all frames, `[F]`.
    pub deviation: Vec<f32>,
    /// Latent codes z_t, `[T, latent]`.
    pub latents: Vec<f32>,
    /// Size of a latent code; 0 without an encoder.
    pub latent: usize,
    /// The clip of each frame, `[T]`: asked for several times a step, where a search of [`Self::starts`] would show.
    clip: Vec<u32>,
}

impl ReferenceLibrary {
    /// Resamples the clips to the robot's policy rate and takes them apart.
    ///
    /// # Errors
    /// No clips; two of one name. A clip that does not fit the robot, is shorter than three frames at the policy's
    /// rate, or holds a number that is not finite.
    pub fn new(robot: &Robot, clips: &[MotionClip], encoder: Option<&dyn LatentEncoder>) -> Result<Self, RobotError> {
        let layout = robot.layout.clone();
        let mut library = Self {
            deviation: vec![0.0; layout.size()],
            layout,
            names: Vec::new(),
            starts: vec![0],
            root_position: Vec::new(),
            root_orientation: Vec::new(),
            linear_velocity_w: Vec::new(),
            angular_velocity_w: Vec::new(),
            features: Vec::new(),
            latents: Vec::new(),
            latent: encoder.map_or(0, LatentEncoder::latent_size),
            clip: Vec::new(),
        };
        let mut seen = BTreeSet::new();
        for clip in clips {
            if !seen.insert(clip.name.as_str()) {
                return Err(RobotError::mismatch(format!("clip '{}'", clip.name), "one clip of this name", "two"));
            }
            library.add(robot, clip, encoder)?;
        }
        if library.names.is_empty() {
            return Err(RobotError::mismatch("clips", "at least one", "none"));
        }
        library.measure();
        Ok(library)
    }

    /// A library of one clip in which the robot stands in its default pose: for tests and first checks of a new robot.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn standing(robot: &Robot, seconds: f64) -> Result<Self, RobotError> {
        Self::new(robot, &[standing_clip(robot, seconds)], None)
    }

    fn add(&mut self, robot: &Robot, clip: &MotionClip, encoder: Option<&dyn LatentEncoder>) -> Result<(), RobotError> {
        let clip = resample(clip, robot.control_hz)?;
        let frames = frames_of(&clip, &robot.character, &robot.effectors)?;
        let what = || format!("clip '{}'", clip.name);
        if frames.len() < 3 {
            return Err(RobotError::mismatch(what(), "at least 3 frames at the policy's rate", frames.len()));
        }
        let mut row = vec![0.0; self.layout.size()];
        for (i, frame) in frames.iter().enumerate() {
            frame.write_features(&frame.root_orientation, &mut row);
            if let Some(bad) = row.iter().find(|x| !x.is_finite()) {
                return Err(RobotError::mismatch(what(), "finite numbers", format!("{bad} in frame {i}")));
            }
            self.features.extend(row.iter().map(|x| *x as f32));
            self.root_position.extend(frame.root_position.iter().map(|x| *x as f32));
            self.root_orientation.extend(to_wxyz(&frame.root_orientation).map(|x| x as f32));
            self.linear_velocity_w.extend(frame.linear_velocity_w.iter().map(|x| *x as f32));
            self.angular_velocity_w.extend(frame.angular_velocity_w.iter().map(|x| *x as f32));
        }
        if let Some(encoder) = encoder {
            let codes = encoder.encode(&clip, &frames, robot.control_hz)?;
            if codes.len() != frames.len() * self.latent {
                let expected = format!("{} latent numbers", frames.len() * self.latent);
                return Err(RobotError::mismatch(what(), expected, codes.len()));
            }
            self.latents.extend(codes);
        }
        self.clip.extend(std::iter::repeat_n(self.names.len() as u32, frames.len()));
        self.names.push(clip.name.clone());
        self.starts.push(self.len() + frames.len());
        Ok(())
    }

    /// Gives every frame the latent code of another one, drawn by a seed: each code is used once.
    ///
    /// # Errors
    /// [`RobotError::Input`] for a library without codes.
    pub fn permute_codes(&mut self, seed: u64) -> Result<(), RobotError> {
        if self.latent == 0 {
            return Err(RobotError::mismatch("permuted codes", "a policy that sees latent codes", "one without"));
        }
        let mut order: Vec<usize> = (0..self.len()).collect();
        order.shuffle(&mut stream(seed, "permuted codes", 0, 0));
        self.latents = order.iter().flat_map(|frame| self.latent_at(*frame).to_vec()).collect();
        Ok(())
    }

    fn measure(&mut self) {
        let (size, frames) = (self.layout.size(), self.len() as f64);
        for i in 0..size {
            let column = || self.features.iter().skip(i).step_by(size).map(|x| f64::from(*x));
            let mean = column().sum::<f64>() / frames;
            self.deviation[i] = (column().map(|x| (x - mean).powi(2)).sum::<f64>() / frames).sqrt() as f32;
        }
    }

    /// Writes the generalised position and velocity of a robot (MuJoCo's layout) in the state of a frame. Its root is
    /// above `place` on the ground (m), and `lift` metres higher than in the clip.
    ///
    /// # Panics
    /// `q` or `v` is not as long as the robot's.
    pub fn write_state(&self, frame: usize, robot: &Robot, place: [f64; 2], lift: f64, q: &mut [f64], v: &mut [f64]) {
        let root = from_wxyz(self.orientation_at(frame).map(f64::from)).unwrap_or_default();
        let linear = self.linear_velocity_at(frame).map(f64::from);
        let angular_b = root.inverse() * Vec3::from(self.angular_velocity_at(frame).map(f64::from));
        q.copy_from_slice(&robot.default_position());
        let mut scalars = self.joints_at(frame).iter().zip(self.joint_velocities_at(frame)).peekable();
        for joint in &robot.character.joints {
            let (at, rate) = (joint.q_index, joint.v_index);
            if joint.kind == JointKind::Free {
                let height = f64::from(self.position_at(frame)[2]) + lift + START_CLEARANCE;
                q[at..at + 3].copy_from_slice(&[place[0], place[1], height]);
                q[at + 3..at + 7].copy_from_slice(&to_wxyz(&root));
                v[rate..rate + 3].copy_from_slice(&linear);
                v[rate + 3..rate + 6].copy_from_slice(angular_b.as_slice());
            } else if let Some((position, velocity)) = scalars.next_if(|_| joint.is_scalar()) {
                q[at] = f64::from(*position);
                v[rate] = f64::from(*velocity);
            }
        }
        robot.character.follow(q, v);
    }

    /// Returns whether each sole of the robot is on the ground in each frame, in the order of the anatomy's soles.
    ///
    /// # Shapes
    /// `[T, soles]`.
    pub fn soles_down(&self, robot: &Robot) -> Vec<bool> {
        let (mut q, mut v) = (vec![0.0; robot.character.nq], vec![0.0; robot.character.nv]);
        let mut kinematics = Kinematics::new(&robot.character);
        let mut down = Vec::with_capacity(self.len() * robot.anatomy.soles.len());
        for frame in 0..self.len() {
            // Without the air that episodes begin with.
            self.write_state(frame, robot, [0.0; 2], -START_CLEARANCE, &mut q, &mut v);
            kinematics.update(&robot.character, &q);
            down.extend(
                robot
                    .anatomy
                    .soles
                    .values()
                    .map(|sole| sole.corners.iter().any(|corner| kinematics.point(sole.body, corner).z < SOLE_DOWN)),
            );
        }
        down
    }

    /// Returns the SHA-256 of all of it, hexadecimal: two libraries of one digest hold the same motion under the same names.
    pub fn digest(&self) -> String {
        let mut hash = Sha256::new();
        for (name, start) in self.names.iter().zip(&self.starts) {
            hash.update((name.len() as u64).to_le_bytes());
            hash.update(name);
            hash.update((*start as u64).to_le_bytes());
        }
        // The other arrays follow from these.
        for values in [&self.root_position, &self.root_orientation, &self.features, &self.latents] {
            hash.update((values.len() as u64).to_le_bytes());
            values.iter().for_each(|x| hash.update(x.to_le_bytes()));
        }
        hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
    }

    /// Number of frames T.
    pub fn len(&self) -> usize {
        self.starts.last().copied().unwrap_or(0)
    }

    /// Returns false: a library has at least one clip.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Number of clips.
    pub fn clips(&self) -> usize {
        self.names.len()
    }

    /// Returns the clip that a frame belongs to; the last one for frames beyond the end.
    #[inline]
    pub fn clip_of(&self, frame: usize) -> usize {
        self.clip.get(frame).map_or(self.clips() - 1, |clip| *clip as usize)
    }

    /// Returns the frame so many steps ahead, or its clip's last.
    #[inline]
    pub fn ahead(&self, frame: usize, steps: usize) -> usize {
        (frame + steps).min(self.starts[self.clip_of(frame) + 1] - 1)
    }

    /// Returns the frame so many steps ahead or back, or the last or first of its clip.
    #[inline]
    pub fn around(&self, frame: usize, steps: i32) -> usize {
        let range = self.range(self.clip_of(frame));
        frame.saturating_add_signed(steps as isize).clamp(range.start, range.end - 1)
    }

    /// Features of the frames at offsets from one, each in its own heading frame, `[offsets, F]`.
    pub fn window_at(&self, frame: usize, offsets: &[i32]) -> Vec<f32> {
        offsets.iter().flat_map(|offset| self.features_at(self.around(frame, *offset))).copied().collect()
    }

    /// The frames of a clip.
    pub fn range(&self, clip: usize) -> std::ops::Range<usize> {
        self.starts[clip]..self.starts[clip + 1]
    }

    /// Features of one frame, `[F]`.
    #[inline]
    pub fn features_at(&self, frame: usize) -> &[f32] {
        let size = self.layout.size();
        &self.features[frame * size..(frame + 1) * size]
    }

    /// Joint positions of one frame, `[J]` (rad).
    #[inline]
    pub fn joints_at(&self, frame: usize) -> &[f32] {
        &self.features_at(frame)[self.layout.joint_positions()]
    }

    /// Joint velocities of one frame, `[J]` (rad/s).
    pub fn joint_velocities_at(&self, frame: usize) -> &[f32] {
        &self.features_at(frame)[self.layout.joint_velocities()]
    }

    /// Latent code of one frame, `[latent]`.
    pub fn latent_at(&self, frame: usize) -> &[f32] {
        &self.latents[frame * self.latent..(frame + 1) * self.latent]
    }

    /// Root position of one frame (m, the clip's world).
    #[inline]
    pub fn position_at(&self, frame: usize) -> [f32; 3] {
        three(&self.root_position, frame)
    }

    /// Root orientation of one frame (`wxyz`, the clip's world).
    #[inline]
    pub fn orientation_at(&self, frame: usize) -> [f32; 4] {
        let q = &self.root_orientation[4 * frame..4 * frame + 4];
        [q[0], q[1], q[2], q[3]]
    }

    /// Root linear velocity of one frame (m/s, the clip's world).
    pub fn linear_velocity_at(&self, frame: usize) -> [f32; 3] {
        three(&self.linear_velocity_w, frame)
    }

    /// Root angular velocity of one frame (rad/s, the clip's world).
    pub fn angular_velocity_at(&self, frame: usize) -> [f32; 3] {
        three(&self.angular_velocity_w, frame)
    }
}

/// A clip in which the robot stands still in its default pose, where the model puts it.
pub fn standing_clip(robot: &Robot, seconds: f64) -> MotionClip {
    let frames = (seconds * robot.control_hz).round().max(3.0) as usize;
    let root = lifelike_character::Kinematics::new(&robot.character);
    let body = robot.character.root_body();
    MotionClip {
        name: "stand".into(),
        fps: robot.control_hz,
        joint_names: robot.layout.joints.clone(),
        root_position: vec![root.body_position[body]; frames],
        root_orientation: vec![root.body_orientation[body]; frames],
        joints: robot.default_pose.repeat(frames),
        contacts: None,
        cyclic: true,
        provenance: lifelike_motion::Provenance { character: robot.name.clone(), ..Default::default() },
    }
}

#[inline]
fn three(values: &[f32], frame: usize) -> [f32; 3] {
    let v = &values[3 * frame..3 * frame + 3];
    [v[0], v[1], v[2]]
}

impl AsRef<ReferenceLibrary> for ReferenceLibrary {
    fn as_ref(&self) -> &Self {
        self
    }
}
