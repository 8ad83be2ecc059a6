//! Faults of a simulated machine, on demand.

use std::str::FromStr;

use lifelike_robot::Robot;
use lifelike_runtime::Measurement;

/// Kind of a fault.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fault {
    /// An encoder repeats itself.
    Frozen,
    /// The readings of a joint and its neighbour are exchanged.
    Swapped,
    /// A joint's position is no number.
    Nan,
    /// A motor gets hotter by 20 degrees per second.
    Hot,
    /// A motor does nothing.
    Dead,
    /// No packet comes any more.
    Silent,
    /// The robot's clock jumps ahead by a second.
    Clock,
    /// The stop button.
    Button,
    /// The battery loses 5 V per second.
    Battery,
    /// A push from behind that no controller withstands.
    Push,
}

/// Length of a push (s).
const PUSH_SECONDS: f64 = 0.2;

const NAMES: [(&str, Fault); 10] = [
    ("frozen", Fault::Frozen),
    ("swapped", Fault::Swapped),
    ("nan", Fault::Nan),
    ("hot", Fault::Hot),
    ("dead", Fault::Dead),
    ("silent", Fault::Silent),
    ("clock", Fault::Clock),
    ("button", Fault::Button),
    ("battery", Fault::Battery),
    ("push", Fault::Push),
];

/// A fault from a time on: `KIND@SECONDS` or `KIND@SECONDS:JOINT`.
#[derive(Debug, Clone, PartialEq)]
pub struct Scheduled {
    fault: Fault,
    from: f64,
    joint_name: Option<String>,
    joint: usize,
    other: usize,
    held: Option<f32>,
}

impl FromStr for Scheduled {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let names: Vec<&str> = NAMES.iter().map(|(name, _)| *name).collect();
        let expected = || format!("expected KIND@SECONDS or KIND@SECONDS:JOINT, KIND one of {}", names.join(", "));
        let (kind, rest) = text.split_once('@').ok_or_else(expected)?;
        let (seconds, joint) = match rest.split_once(':') {
            Some((seconds, joint)) => (seconds, Some(joint.to_string())),
            None => (rest, None),
        };
        let fault = NAMES.iter().find(|(name, _)| *name == kind).map(|(_, fault)| *fault).ok_or_else(expected)?;
        let from = seconds.parse::<f64>().ok().filter(|from| from.is_finite() && *from >= 0.0).ok_or_else(expected)?;
        Ok(Self { fault, from, joint_name: joint, joint: 0, other: 1, held: None })
    }
}

impl Scheduled {
    /// Returns the fault with its joint found in a robot; the first joint where none is named.
    ///
    /// # Errors
    /// The robot has no joint of this name.
    pub fn of(mut self, robot: &Robot) -> Result<Self, String> {
        let joints = &robot.layout.joints;
        if let Some(name) = &self.joint_name {
            self.joint = joints
                .iter()
                .position(|joint| joint == name)
                .ok_or_else(|| format!("--fault: expected a joint of '{}', got '{name}'", robot.name))?;
        }
        self.other = (self.joint + 1) % joints.len().max(1);
        Ok(self)
    }

    pub(super) fn kills_motor(&self, joint: usize, seconds: f64) -> bool {
        self.fault == Fault::Dead && joint == self.joint && seconds >= self.from
    }

    /// Returns whether it pushes the robot now.
    pub(super) fn pushes(&self, seconds: f64) -> bool {
        self.fault == Fault::Push && (self.from..self.from + PUSH_SECONDS).contains(&seconds)
    }

    /// Changes a measurement; returns false where it is lost.
    pub(super) fn apply(&mut self, seconds: f64, packet: &mut Measurement) -> bool {
        if seconds < self.from {
            return true;
        }
        let (joint, since) = (self.joint, (seconds - self.from) as f32);
        match self.fault {
            Fault::Frozen => packet.position[joint] = *self.held.get_or_insert(packet.position[joint]),
            Fault::Swapped => {
                packet.position.swap(joint, self.other);
                packet.velocity.swap(joint, self.other);
            }
            Fault::Nan => packet.position[joint] = f32::NAN,
            Fault::Hot => packet.temperature[joint] += 20.0 * since,
            Fault::Silent => return false,
            Fault::Clock => packet.clock += 1_000_000_000,
            Fault::Button => packet.stop = true,
            Fault::Battery => packet.battery -= 5.0 * since,
            Fault::Dead | Fault::Push => {}
        }
        true
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn text_says_kind_time_and_joint() {
        let fault: Scheduled = "hot@2.5:left_knee".parse().unwrap();
        let fault = fault.of(&Robot::load("lima").unwrap()).unwrap();
        assert_eq!((fault.fault, fault.from, fault.joint), (Fault::Hot, 2.5, 3));
        for bad in ["hot", "hot@", "cold@1", "hot@-1", "hot@nan"] {
            assert!(bad.parse::<Scheduled>().is_err_and(|error| error.contains("KIND@SECONDS")), "{bad}");
        }
        let unknown: Scheduled = "nan@1:tail".parse().unwrap();
        assert!(unknown.of(&Robot::load("lima").unwrap()).is_err_and(|error| error.contains("'tail'")));
    }
}
