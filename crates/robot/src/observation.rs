//! What a policy sees: the one observation builder of the whole project.

use std::ops::Range;

use lifelike_character::rotation::{from_wxyz, heading, heading_angle, to_6d};
use nalgebra::{UnitQuaternion, Vector3};

use crate::error::RobotError;
use crate::robot::Robot;

/// What of the reference the policy sees (c_t of thesis 4.2.2).
#[derive(Debug, Clone, Default, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ReferenceSpec {
    /// The frame to reach, m_{t+1} (input M of Table 4.3).
    pub frame: bool,
    /// Frames further ahead, as offsets from t in policy steps (inputs M5, M10 of Table 4.3); none in the thesis' own.
    #[serde(default)]
    pub future: Vec<u32>,
    /// Size of the latent code z_t (input L of Table 4.3); 0: none.
    #[serde(default)]
    pub latent: usize,
    /// Frames around t+1, as offsets from it in policy steps, before and after: what an encoder that is trained with the
    /// policy sees (the end-to-end codes of Table 4.2); empty: none.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub window: Vec<i32>,
}

/// What the policy sees of where it is against where the reference is. All off in the thesis, whose policies let path
/// and heading drift.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AnchorSpec {
    /// Sine and cosine of the reference's heading against the robot's, within ±[`ObservationSpec::ANCHOR_TURN`].
    #[serde(default)]
    pub heading: bool,
    /// Where the reference's root is, on the ground, in the robot's heading frame (2 numbers, m; brought nearer where it
    /// is further than [`ObservationSpec::ANCHOR_REACH`]).
    #[serde(default)]
    pub position: bool,
}

/// The layout of an observation, with all names: what a checkpoint and a deployed policy carry.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ObservationSpec {
    /// [`Self::VERSION`] of the builder that this is the layout of.
    pub version: u32,
    /// Whether the root's height is seen (m).
    pub root_height: bool,
    /// Whether the root's linear velocity is seen: few robots can measure it.
    #[serde(default = "seen", skip_serializing_if = "is_seen")]
    pub linear_velocity: bool,
    /// Joint names, in order.
    pub joints: Vec<String>,
    /// Default angle of each joint (rad): positions are seen relative to it.
    pub default_pose: Vec<f32>,
    /// End effectors of the reference frames, in order.
    pub end_effectors: Vec<String>,
    /// Key bodies, in order.
    pub key_bodies: Vec<String>,
    /// Inputs from the reference.
    pub reference: ReferenceSpec,
    /// Inputs that tie it to the reference's path.
    pub anchor: AnchorSpec,
}

fn seen() -> bool {
    true
}

#[allow(clippy::trivially_copy_pass_by_ref)] // serde hands out a reference
fn is_seen(seen: &bool) -> bool {
    *seen
}

/// What one observation is made of, for one environment. World frame, SI units, quaternions `wxyz`.
#[derive(Debug, Clone, Copy)]
pub struct ObservationInputs<'a> {
    /// Root position (m).
    pub root_position: [f32; 3],
    /// Root orientation.
    pub root_orientation: [f32; 4],
    /// Root linear velocity (m/s, world).
    pub linear_velocity_w: [f32; 3],
    /// Root angular velocity (rad/s, world).
    pub angular_velocity_w: [f32; 3],
    /// Joint positions as measured, `[J]` (rad).
    pub joint_position: &'a [f32],
    /// Joint velocities, `[J]` (rad/s).
    pub joint_velocity: &'a [f32],
    /// Key bodies, `[K, 3]` (m, world).
    pub key_bodies_w: &'a [f32],
    /// The policy's last output, `[J]`, as [`crate::ActionSpec::clamp_output`] left it.
    pub last_action: &'a [f32],
    /// The one before, `[J]`.
    pub action_before: &'a [f32],
    /// Reference frame at t+1, features of eq. 4.1 in ITS OWN heading frame (W = 0 in 4.2.2), `[F]`; else empty.
    pub reference: &'a [f32],
    /// Frames of [`ReferenceSpec::future`], likewise, each in its own heading frame, `[offsets, F]`.
    pub future: &'a [f32],
    /// Latent code z_t, `[latent]`.
    pub latent: &'a [f32],
    /// Frames of [`ReferenceSpec::window`], each in its own heading frame, `[offsets, F]`.
    pub window: &'a [f32],
    /// Root position of the reference at t+1 (m); used by [`AnchorSpec::position`] only.
    pub reference_root_position: [f32; 3],
    /// Root orientation of the reference at t+1; used by [`AnchorSpec::heading`] only.
    pub reference_root_orientation: [f32; 4],
}

impl ObservationSpec {
    /// Version of the layout that [`Self::write`] writes.
    pub const VERSION: u32 = 2;

    /// How far off the reference's root is ever shown to be (m).
    pub const ANCHOR_REACH: f32 = 0.3;

    /// How far turned from the reference the robot is ever shown to be (rad).
    pub const ANCHOR_TURN: f32 = 0.5;

    /// The layout for a robot.
    pub fn new(robot: &Robot, reference: ReferenceSpec, anchor: AnchorSpec) -> Self {
        Self {
            version: Self::VERSION,
            root_height: robot.profile.observe_root_height,
            linear_velocity: true,
            joints: robot.layout.joints.clone(),
            default_pose: robot.default_pose.iter().map(|&q| q as f32).collect(),
            end_effectors: robot.layout.end_effectors.clone(),
            key_bodies: robot.profile.key_bodies.clone(),
            reference,
            anchor,
        }
    }

    /// The same for a robot that cannot measure how fast its root moves.
    #[must_use]
    pub fn without_linear_velocity(self) -> Self {
        Self { linear_velocity: false, ..self }
    }

    /// Whether this layout, as saved with a policy, is that of `robot`.
    ///
    /// # Errors
    /// [`RobotError::Mismatch`] for another version or other names, also in another order.
    pub fn check(&self, robot: &Robot) -> Result<(), RobotError> {
        let mismatch = |what: &str, expected: String, got: String| {
            Err(RobotError::Mismatch { what: format!("observation of robot '{}': {what}", robot.name), expected, got })
        };
        if self.version != Self::VERSION {
            return mismatch("version", Self::VERSION.to_string(), self.version.to_string());
        }
        let own = Self::new(robot, self.reference.clone(), self.anchor);
        for (what, expected, got) in [
            ("joints", &own.joints, &self.joints),
            ("end effectors", &own.end_effectors, &self.end_effectors),
            ("key bodies", &own.key_bodies, &self.key_bodies),
        ] {
            if expected != got {
                return mismatch(what, expected.join(", "), got.join(", "));
            }
        }
        if own.root_height != self.root_height {
            return mismatch("root height", own.root_height.to_string(), self.root_height.to_string());
        }
        if own.default_pose != self.default_pose {
            return mismatch("default pose", format!("{:?}", own.default_pose), format!("{:?}", self.default_pose));
        }
        Ok(())
    }

    /// Length F of a reference frame: the feature vector of eq. 4.1.
    pub fn frame_size(&self) -> usize {
        13 + 2 * self.joints.len() + 3 * self.end_effectors.len()
    }

    /// Length of the robot's own state, the last two actions included: 217 for the thesis' humanoid (4.3.1).
    pub fn state_size(&self) -> usize {
        usize::from(self.root_height)
            + 9
            + 3 * usize::from(self.linear_velocity)
            + 4 * self.joints.len()
            + 3 * self.key_bodies.len()
    }

    /// Length of an observation.
    pub fn size(&self) -> usize {
        let frames = usize::from(self.reference.frame) + self.reference.future.len();
        let anchor = 2 * (usize::from(self.anchor.heading) + usize::from(self.anchor.position));
        self.state_size() + frames * self.frame_size() + self.reference.latent + anchor + self.window_size()
    }

    /// Length of the window: the last numbers of an observation.
    pub fn window_size(&self) -> usize {
        self.reference.window.len() * self.frame_size()
    }

    /// What lies where, in order and without gaps.
    pub fn parts(&self) -> Vec<(String, Range<usize>)> {
        let (joints, frame) = (self.joints.len(), self.frame_size());
        let mut parts = Vec::new();
        let mut start = 0;
        let mut part = |name: &str, size: usize| {
            if size > 0 {
                parts.push((name.to_string(), start..start + size));
                start += size;
            }
        };
        part("root_height", usize::from(self.root_height));
        part("root_orientation_h", 6);
        part("root_linear_velocity_h", 3 * usize::from(self.linear_velocity));
        part("root_angular_velocity_h", 3);
        part("joint_position", joints);
        part("joint_velocity", joints);
        part("key_bodies_h", 3 * self.key_bodies.len());
        part("last_action", joints);
        part("action_before", joints);
        part("reference", if self.reference.frame { frame } else { 0 });
        for offset in &self.reference.future {
            part(&format!("reference+{offset}"), frame);
        }
        part("latent", self.reference.latent);
        part("anchor_heading", 2 * usize::from(self.anchor.heading));
        part("anchor_position", 2 * usize::from(self.anchor.position));
        for offset in &self.reference.window {
            part(&format!("window{offset:+}"), frame);
        }
        parts
    }

    /// Writes one observation. Nothing is normalised: that is the network's part.
    ///
    /// Allocates nothing. A root orientation without a direction (zero or NaN) gives NaN, for the caller to quarantine.
    ///
    /// # Errors
    /// [`RobotError::Mismatch`] when an array has the wrong length.
    pub fn write(&self, inputs: ObservationInputs<'_>, out: &mut [f32]) -> Result<(), RobotError> {
        self.check_lengths(&inputs, out)?;
        let mut out = Writer { rest: out };
        let root = orientation(inputs.root_orientation);
        let yaw = heading(&root);
        let to_heading = yaw.inverse();
        let position = Vector3::from(inputs.root_position);
        if self.root_height {
            out.put(&[position.z]);
        }
        out.put(&to_6d(&(to_heading * root)));
        if self.linear_velocity {
            out.put((to_heading * Vector3::from(inputs.linear_velocity_w)).as_slice());
        }
        out.put((to_heading * Vector3::from(inputs.angular_velocity_w)).as_slice());
        out.put_difference(inputs.joint_position, &self.default_pose);
        out.put(inputs.joint_velocity);
        for p in inputs.key_bodies_w.chunks_exact(3) {
            out.put((to_heading * (Vector3::new(p[0], p[1], p[2]) - position)).as_slice());
        }
        out.put(inputs.last_action);
        out.put(inputs.action_before);
        self.put_frames(inputs.reference, &mut out);
        self.put_frames(inputs.future, &mut out);
        out.put(inputs.latent);
        if self.anchor.heading {
            let error = heading_angle(&orientation(inputs.reference_root_orientation)) - heading_angle(&root);
            let error = error.sin().atan2(error.cos()).clamp(-Self::ANCHOR_TURN, Self::ANCHOR_TURN);
            out.put(&[error.sin(), error.cos()]);
        }
        if self.anchor.position {
            let error = to_heading * (Vector3::from(inputs.reference_root_position) - position);
            let share = Self::ANCHOR_REACH / error.x.hypot(error.y).max(Self::ANCHOR_REACH);
            out.put(&[share * error.x, share * error.y]);
        }
        self.put_frames(inputs.window, &mut out);
        debug_assert!(out.rest.is_empty());
        Ok(())
    }

    /// Frames of eq. 4.1 as the policy sees them: joint positions relative to the default pose.
    ///
    /// # Shapes
    /// `frames: [N, F]` into `out: [N, F]`.
    ///
    /// # Errors
    /// [`RobotError::Mismatch`] when the lengths differ or are no multiple of F.
    pub fn write_frames(&self, frames: &[f32], out: &mut [f32]) -> Result<(), RobotError> {
        if frames.len() != out.len() || !frames.len().is_multiple_of(self.frame_size()) {
            return Err(RobotError::Mismatch {
                what: "length of reference frames".into(),
                expected: format!("{}, a multiple of {}", out.len(), self.frame_size()),
                got: frames.len().to_string(),
            });
        }
        self.put_frames(frames, &mut Writer { rest: out });
        Ok(())
    }

    fn put_frames(&self, frames: &[f32], out: &mut Writer<'_>) {
        let joints = self.joints.len();
        for frame in frames.chunks_exact(self.frame_size()) {
            out.put(&frame[..13]);
            out.put_difference(&frame[13..13 + joints], &self.default_pose);
            out.put(&frame[13 + joints..]);
        }
    }

    fn check_lengths(&self, inputs: &ObservationInputs<'_>, out: &[f32]) -> Result<(), RobotError> {
        let (joints, frame) = (self.joints.len(), self.frame_size());
        let lengths = [
            ("observation", self.size(), out.len()),
            ("default pose", joints, self.default_pose.len()),
            ("joint positions", joints, inputs.joint_position.len()),
            ("joint velocities", joints, inputs.joint_velocity.len()),
            ("key bodies", 3 * self.key_bodies.len(), inputs.key_bodies_w.len()),
            ("last action", joints, inputs.last_action.len()),
            ("action before", joints, inputs.action_before.len()),
            ("reference frame", if self.reference.frame { frame } else { 0 }, inputs.reference.len()),
            ("future frames", self.reference.future.len() * frame, inputs.future.len()),
            ("latent", self.reference.latent, inputs.latent.len()),
            ("window", self.window_size(), inputs.window.len()),
        ];
        match lengths.iter().find(|(_, expected, got)| expected != got) {
            None => Ok(()),
            Some((what, expected, got)) => Err(RobotError::Mismatch {
                what: format!("length of {what}"),
                expected: expected.to_string(),
                got: got.to_string(),
            }),
        }
    }
}

/// The rotation, or NaN where the numbers have no direction.
fn orientation(wxyz: [f32; 4]) -> UnitQuaternion<f32> {
    from_wxyz(wxyz).unwrap_or_else(|| {
        UnitQuaternion::new_unchecked(nalgebra::Quaternion::new(f32::NAN, f32::NAN, f32::NAN, f32::NAN))
    })
}

/// Fills a slice from front to back. The lengths were checked before.
struct Writer<'a> {
    rest: &'a mut [f32],
}

impl Writer<'_> {
    fn next(&mut self, n: usize) -> &mut [f32] {
        let (head, tail) = std::mem::take(&mut self.rest).split_at_mut(n);
        self.rest = tail;
        head
    }

    fn put(&mut self, values: &[f32]) {
        self.next(values.len()).copy_from_slice(values);
    }

    fn put_difference(&mut self, values: &[f32], origin: &[f32]) {
        for ((slot, value), origin) in self.next(values.len()).iter_mut().zip(values).zip(origin) {
            *slot = value - origin;
        }
    }
}
