//! Commands that passed the gate.

/// Control mode of a command.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Mode {
    /// Motors are off: both gains are zero.
    #[default]
    Off,
    /// Motors brake: no proportional gain.
    Damp,
    /// Motors drive to positions.
    Position,
}

/// A command within all limits. Only [`super::Gate`] makes one, and it cannot be kept: a bus gets a reference to the newest.
///
/// ```compile_fail,E0451
/// use lifelike_runtime::gate::{Mode, SafeCommand};
/// let forged = SafeCommand { sequence: 0, mode: Mode::Position, position: vec![9.0], kp: vec![1e3], kd: vec![0.0] };
/// ```
///
/// ```compile_fail,E0599
/// fn kept(command: &lifelike_runtime::SafeCommand) -> lifelike_runtime::SafeCommand {
///     (*command).clone()
/// }
/// ```
///
/// ```compile_fail,E0616
/// fn changed(command: &mut lifelike_runtime::SafeCommand) {
///     command.position[0] = 9.0;
/// }
/// ```
#[derive(Debug)]
pub struct SafeCommand {
    pub(super) sequence: u32,
    pub(super) mode: Mode,
    pub(super) position: Vec<f32>,
    pub(super) kp: Vec<f32>,
    pub(super) kd: Vec<f32>,
}

impl SafeCommand {
    /// Returns the number of the command; each is one above the last.
    pub fn sequence(&self) -> u32 {
        self.sequence
    }

    /// Returns the control mode.
    pub fn mode(&self) -> Mode {
        self.mode
    }

    /// Returns joint targets, `[J]` (rad).
    pub fn position(&self) -> &[f32] {
        &self.position
    }

    /// Returns proportional gains, `[J]` (N m/rad).
    pub fn kp(&self) -> &[f32] {
        &self.kp
    }

    /// Returns derivative gains, `[J]` (N m s/rad).
    pub fn kd(&self) -> &[f32] {
        &self.kd
    }

    /// Returns the torque that a joint's motor is asked for in a state (N m): `kp (target - q) - kd dq`.
    pub fn torque(&self, joint: usize, position: f32, velocity: f32) -> f32 {
        self.kp[joint] * (self.position[joint] - position) - self.kd[joint] * velocity
    }
}
