//! One observation's ingredients: the robot as it was measured, its last actions, its reference.

use lifelike_character::rotation::from_wxyz;
use nalgebra::Vector3;

use crate::reference::{Alignment, ReferenceStream};

/// A robot as its sensors tell. SI units, quaternions `wxyz`.
#[derive(Debug, Clone, Copy, Default)]
pub struct MeasuredState<'a> {
    /// Joint positions as the encoders say, `[J]` (rad).
    pub joint_position: &'a [f32],
    /// Joint velocities, `[J]` (rad/s).
    pub joint_velocity: &'a [f32],
    /// Root orientation in the robot's world.
    pub root_orientation: [f32; 4],
    /// Root angular velocity (rad/s, world); see [`Self::with_gyroscope`].
    pub angular_velocity_w: [f32; 3],
    /// Root position (m, world), where it is known: by policies that see their place on the reference's path.
    pub root_position: Option<[f32; 3]>,
    /// Root height above the ground below it (m); without it the vertical coordinate of `root_position` is taken.
    pub root_height: Option<f32>,
    /// Root linear velocity (m/s, world), where it is known.
    pub linear_velocity_w: Option<[f32; 3]>,
    /// Key bodies, `[K, 3]` (m, world); without them a controller computes them from the joints.
    pub key_bodies_w: Option<&'a [f32]>,
}

impl MeasuredState<'_> {
    /// Sets the angular velocity from a gyroscope's numbers (rad/s, in the frame of the root).
    #[must_use]
    pub fn with_gyroscope(self, angular_velocity_b: [f32; 3]) -> Self {
        let turned = from_wxyz(self.root_orientation).map(|root| root * Vector3::from(angular_velocity_b));
        Self { angular_velocity_w: turned.map_or([f32::NAN; 3], Into::into), ..self }
    }
}

/// Everything that one observation is made of.
#[derive(Clone, Copy)]
pub struct ObservationInputs<'a> {
    /// The robot.
    pub measured: &'a MeasuredState<'a>,
    /// Offsets of the joints' encoders, added to the measured positions, `[J]` (rad); empty: none.
    pub joint_offset: &'a [f32],
    /// The policy's last output, `[J]`, as [`crate::ActionSpec::clamp_output`] left it.
    pub last_action: &'a [f32],
    /// The one before, `[J]`.
    pub action_before: &'a [f32],
    /// The motion to follow.
    pub reference: &'a dyn ReferenceStream,
    /// Pose of the reference's world in the robot's.
    pub alignment: Alignment,
    /// Latent code z_t, `[latent]`; empty without.
    pub latent: &'a [f32],
    /// Own states of earlier steps, the oldest first, `[history · remembered]`; empty without, or before the first step.
    pub past: &'a [f32],
}
