//! Reasons for which the gate brakes.

/// Reason of a trip.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Cause {
    /// No usable packet for too long.
    Lost,
    /// Packets arrive later and later.
    Delayed,
    /// The robot's clock jumped ahead.
    ClockJump,
    /// A measurement holds a number that is not finite.
    NonFinite,
    /// A joint moved further than it can.
    EncoderJump,
    /// A joint's position stays the same while it must move.
    FrozenEncoder,
    /// The policy's target is not finite.
    Target,
    /// The root is tilted against the reference.
    Tilt,
    /// A joint does not follow the reference.
    Tracking,
    /// A joint turns too fast.
    Velocity,
    /// The modelled heat of a motor.
    Heat,
    /// The measured temperature of a motor.
    Temperature,
    /// The supply's voltage.
    Battery,
    /// The robot's own stop button.
    Button,
    /// The loop was not run for too long.
    Overrun,
}

impl Cause {
    /// Returns whether the robot has fallen, where nothing is broken.
    pub fn is_fall(self) -> bool {
        matches!(self, Self::Tilt | Self::Tracking)
    }
}

/// A trip of the gate: it brakes until the run ends, or until a robot that fell may get up.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Trip {
    /// Time (ns since the loop's start).
    pub time: u64,
    /// Reason.
    pub cause: Cause,
    /// The joint, where one is the reason.
    pub joint: Option<u16>,
    /// Number that is out of bounds, in the unit of its limit; null in a record where it is not finite.
    pub value: Option<f32>,
    /// The limit.
    pub limit: f32,
}

impl Trip {
    /// Returns the trip as a sentence, with the names of the joints.
    pub fn words(&self, joints: &[String]) -> String {
        let name = self.joint.and_then(|joint| joints.get(usize::from(joint))).map_or("?", String::as_str);
        let value = self.value.map_or("no number".to_string(), |value| format!("{value:.3}"));
        let limit = self.limit;
        match self.cause {
            Cause::Lost => format!("no usable packet for {value} s (limit {limit} s)"),
            Cause::Delayed => format!("packets are {value} s late (limit {limit} s)"),
            Cause::ClockJump => format!("the robot's clock jumped ahead by {value} s (limit {limit} s)"),
            Cause::NonFinite => format!("joint '{name}': measurement is no finite number"),
            Cause::EncoderJump => format!("joint '{name}': moved {value} rad between packets (limit {limit:.3} rad)"),
            Cause::FrozenEncoder => format!("joint '{name}': encoder frozen for {value} s (limit {limit} s)"),
            Cause::Target => format!("joint '{name}': the policy's target is no finite number"),
            Cause::Tilt => format!("root tilted {value} rad against the reference (limit {limit} rad)"),
            Cause::Tracking => format!("joint '{name}': {value} rad off the reference (limit {limit} rad)"),
            Cause::Velocity => format!("joint '{name}': velocity {value} rad/s (limit {limit} rad/s)"),
            Cause::Heat => format!("joint '{name}': modelled heat {value} of the continuous rating (limit {limit})"),
            Cause::Temperature => format!("joint '{name}': motor at {value} C (limit {limit} C)"),
            Cause::Battery => format!("battery at {value} V (limit {limit} V)"),
            Cause::Button => "the robot's stop button".into(),
            Cause::Overrun => format!("the loop was not run for {value} s (limit {limit} s)"),
        }
    }
}
