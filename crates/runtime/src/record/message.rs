//! Messages of a record.

use serde::{Deserialize, Serialize};

use crate::bus::{External, Measurement};
use crate::gate::Mode;
use crate::phase::{Phase, Request};

/// A packet of the robot.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MeasuredMessage {
    /// Arrival (ns since the loop's start).
    pub time_ns: u64,
    /// Number of the packet.
    pub sequence: u32,
    /// Time on the robot's clock (ns).
    pub clock_ns: u64,
    /// The robot's stop button.
    pub stop: bool,
    /// Root orientation (`wxyz`).
    pub orientation: [Option<f32>; 4],
    /// Root angular velocity (rad/s, frame of the root).
    pub gyroscope: [Option<f32>; 3],
    /// Specific force at the root (m/s², frame of the root).
    #[serde(default)]
    pub accelerometer: [Option<f32>; 3],
    /// Supply voltage (V).
    pub battery: Option<f32>,
    /// Joint positions (rad).
    pub position: Vec<Option<f32>>,
    /// Joint velocities (rad/s).
    pub velocity: Vec<Option<f32>>,
    /// Joint torques (N m).
    pub torque: Vec<Option<f32>>,
    /// Motor temperatures (degrees Celsius).
    pub temperature: Vec<Option<f32>>,
    /// Root position (m) and linear velocity (m/s) from outside of the robot.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub external: Option<[Option<f32>; 6]>,
}

/// One tick and its command.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CommandMessage {
    /// Time of the tick (ns since the loop's start).
    pub time_ns: u64,
    /// Request of the operator.
    pub request: Request,
    /// Phase after the tick.
    pub phase: Phase,
    /// Number of the command.
    pub sequence: u32,
    /// Control mode.
    pub mode: Mode,
    /// Joint targets (rad).
    pub position: Vec<f32>,
    /// Proportional gains (N m/rad).
    pub kp: Vec<f32>,
    /// Derivative gains (N m s/rad).
    pub kd: Vec<f32>,
}

/// One step of the policy.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PolicyMessage {
    /// Time of the tick (ns since the loop's start).
    pub time_ns: u64,
    /// The policy's joint targets (rad).
    pub targets: Vec<Option<f32>>,
    /// Modelled heat of each motor; 1 is its continuous rating.
    pub heat: Vec<Option<f32>>,
}

pub(super) fn finite(x: f32) -> Option<f32> {
    x.is_finite().then_some(x)
}

pub(super) fn all(values: &[f32]) -> Vec<Option<f32>> {
    values.iter().copied().map(finite).collect()
}

fn number(x: Option<f32>) -> f32 {
    x.unwrap_or(f32::NAN)
}

impl MeasuredMessage {
    pub(super) fn of(time_ns: u64, packet: &Measurement) -> Self {
        Self {
            time_ns,
            sequence: packet.sequence,
            clock_ns: packet.clock,
            stop: packet.stop,
            orientation: packet.orientation.map(finite),
            gyroscope: packet.gyroscope_b.map(finite),
            accelerometer: packet.accelerometer_b.map(finite),
            battery: finite(packet.battery),
            position: all(&packet.position),
            velocity: all(&packet.velocity),
            torque: all(&packet.torque),
            temperature: all(&packet.temperature),
            external: packet
                .external
                .map(|External { position: [a, b, c], linear_velocity_w: [d, e, f] }| [a, b, c, d, e, f].map(finite)),
        }
    }

    /// Returns the packet.
    pub fn packet(&self) -> Measurement {
        let numbers = |values: &[Option<f32>]| values.iter().copied().map(number).collect();
        Measurement {
            sequence: self.sequence,
            clock: self.clock_ns,
            stop: self.stop,
            orientation: self.orientation.map(number),
            gyroscope_b: self.gyroscope.map(number),
            accelerometer_b: self.accelerometer.map(number),
            battery: number(self.battery),
            position: numbers(&self.position),
            velocity: numbers(&self.velocity),
            torque: numbers(&self.torque),
            temperature: numbers(&self.temperature),
            external: self.external.map(|values| {
                let [a, b, c, d, e, f] = values.map(number);
                External { position: [a, b, c], linear_velocity_w: [d, e, f] }
            }),
        }
    }
}

/// JSON schema of a topic, as Foxglove reads it.
pub(super) fn schema(topic: &str) -> serde_json::Value {
    use serde_json::json;
    let numbers = json!({ "type": "array", "items": { "type": ["number", "null"] } });
    let (integer, text) = (json!({ "type": "integer" }), json!({ "type": "string" }));
    let properties = match topic {
        super::MEASURED => json!({
            "time_ns": integer, "sequence": integer, "clock_ns": integer, "stop": { "type": "boolean" },
            "orientation": numbers, "gyroscope": numbers, "accelerometer": numbers, "battery": { "type": ["number", "null"] },
            "position": numbers, "velocity": numbers, "torque": numbers, "temperature": numbers, "external": numbers,
        }),
        super::COMMAND => json!({
            "time_ns": integer, "request": text, "phase": text, "sequence": integer, "mode": text,
            "position": numbers, "kp": numbers, "kd": numbers,
        }),
        _ => json!({ "time_ns": integer, "targets": numbers, "heat": numbers }),
    };
    json!({ "title": format!("lifelike{}", topic.replace('/', ".")), "type": "object", "properties": properties })
}
