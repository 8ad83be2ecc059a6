//! Values of N environments: outputs, parameters, saved states.
//!
//! Arrays are row-major `[environment, column]`, so one environment's numbers lie together. All rows refer to the robot's
//! scalar joints and sites in the order of `Robot` (which carries the names).

use lifelike_robot::MeasuredState;

/// Outputs of all environments after the last step or reset. `N` environments, `J` scalar joints, `P` sites
/// (end effectors, then key bodies), `B` bodies (world included), `F` feet (soles of the anatomy).
#[derive(Debug, Clone, Default, PartialEq)]
pub struct BatchState {
    /// Root position, `[N, 3]` (m, world).
    pub root_position: Vec<f32>,
    /// Root orientation, `[N, 4]` (wxyz).
    pub root_orientation: Vec<f32>,
    /// Root linear velocity, `[N, 3]` (m/s, world).
    pub linear_velocity_w: Vec<f32>,
    /// Root angular velocity, `[N, 3]` (rad/s, world).
    pub angular_velocity_w: Vec<f32>,
    /// Joint positions, `[N, J]` (rad).
    pub joint_position: Vec<f32>,
    /// Joint velocities, `[N, J]` (rad/s).
    pub joint_velocity: Vec<f32>,
    /// End effectors, then key bodies, `[N, P, 3]` (m, world).
    pub site_position: Vec<f32>,
    /// Position of every body frame, `[N, B, 3]` (m, world).
    pub body_position: Vec<f32>,
    /// Orientation of every body frame, `[N, B, 4]` (wxyz).
    pub body_orientation: Vec<f32>,
    /// Mean over the substeps of the squared actuator torque, `[N, J]` (N² m²): c^τ of eq. 4.8 uses the sum over joints.
    pub torque_squared: Vec<f32>,
    /// Actuator torque at the last substep, `[N, J]` (N m).
    pub torque: Vec<f32>,
    /// Total normal ground force on each foot at the last substep, `[N, F]` (N).
    pub foot_force: Vec<f32>,
    /// Force of the joint constraints (limits, dry friction) per scalar joint at the last substep, `[N, J]` (N m).
    pub constraint_force: Vec<f32>,
    /// Environments that diverged (non-finite or absurd state) in the last step, `[N]`. Such an environment is frozen at
    /// its last good state until it is reset; its neighbours are untouched.
    pub diverged: Vec<bool>,
}

impl BatchState {
    /// Returns one environment as an ideal set of sensors would measure it: what a controller is told. `effectors` is the
    /// number of the robot's end effectors, which come before its key bodies.
    ///
    /// The root's height is not set: over level ground it is the vertical coordinate, over a terrain the caller's to measure.
    pub fn measured(&self, environment: usize, effectors: usize) -> MeasuredState<'_> {
        let i = environment;
        let three = |values: &[f32]| [values[3 * i], values[3 * i + 1], values[3 * i + 2]];
        let environments = (self.root_position.len() / 3).max(1);
        let joints = self.joint_position.len() / environments;
        let sites = self.site_position.len() / self.root_position.len().max(1);
        let q = &self.root_orientation[4 * i..4 * i + 4];
        MeasuredState {
            joint_position: &self.joint_position[i * joints..(i + 1) * joints],
            joint_velocity: &self.joint_velocity[i * joints..(i + 1) * joints],
            root_orientation: [q[0], q[1], q[2], q[3]],
            angular_velocity_w: three(&self.angular_velocity_w),
            root_position: Some(three(&self.root_position)),
            root_height: None,
            linear_velocity_w: Some(three(&self.linear_velocity_w)),
            key_bodies_w: Some(&self.site_position[3 * (i * sites + effectors)..3 * (i + 1) * sites]),
        }
    }
}

/// Parameters that may differ between environments (domain randomisation, thesis 4.2.2). The default changes nothing.
#[derive(Debug, Clone, Default, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct EnvironmentParameters {
    /// Factor on each body's mass and inertia, `[B]`; empty: all one.
    pub mass_scale: Vec<f32>,
    /// Further factor on each body's inertia, `[B]`; empty: all one.
    pub inertia_scale: Vec<f32>,
    /// Offset of each body's centre of mass from the model's, `[B]` (m, frame of the body); empty: none.
    pub com_offset: Vec<[f32; 3]>,
    /// Gravity (m/s², world); `None`: as the model says.
    pub gravity: Option<[f32; 3]>,
    /// Factor on the armature of each joint, `[J]`; empty: all one.
    pub armature_scale: Vec<f32>,
    /// Factor on the damping of each joint, `[J]`; empty: all one.
    pub damping_scale: Vec<f32>,
    /// Factor on each actuator's gain κ_P, `[J]`; empty: all one.
    pub kp_scale: Vec<f32>,
    /// Factor on each actuator's gain κ_D, `[J]`; empty: all one.
    pub kd_scale: Vec<f32>,
    /// Factor on the motor torque of each joint, its limit included, `[J]`; empty: all one. A tired or weak motor.
    pub strength_scale: Vec<f32>,
    /// Sliding friction of the ground, and of the robot's parts for each other; `None`: as the model says.
    pub ground_friction: Option<f32>,
    /// Sliding friction of each foot on the ground, `[F]`: the local ground of thesis 4.2.2; empty: like the rest.
    pub foot_friction: Vec<f32>,
    /// Offset of each joint's encoder against the truth, `[J]` (rad); empty: none. Added to what is OBSERVED and
    /// subtracted from what is commanded by the caller (`randomization`), never by the engine.
    pub joint_offset: Vec<f32>,
}

/// The whole integration state of some environments: enough to continue bit for bit.
#[derive(Debug, Clone, PartialEq)]
pub struct IntegrationState {
    /// Engine that made it.
    pub engine: String,
    /// Numbers per environment.
    pub width: usize,
    /// `[N, width]`.
    pub values: Vec<f64>,
    /// Parameters of each environment.
    pub parameters: Vec<EnvironmentParameters>,
}
