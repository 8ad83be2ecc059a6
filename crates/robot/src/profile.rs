//! The text beside a robot's model: which actuators it has, and what of it is observed and tracked.

use std::collections::BTreeMap;
use std::path::Path;

use crate::actuator::{ActuatorParameters, models};
use crate::{FromInput, RobotError};

/// The text beside a robot's MJCF (`lima.toml` beside `lima.xml`). Every part is optional: what is missing is guessed
/// from the model.
#[derive(Debug, Clone, Default, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Profile {
    /// Roles that the guess gets wrong: role = body or site name.
    #[serde(default)]
    pub anatomy: lifelike_character::anatomy::Overrides,
    /// Kinds of actuators, by a name of their own.
    #[serde(default)]
    pub actuator: BTreeMap<String, ActuatorGroup>,
    /// Sites whose positions are tracked (p of eq. 4.1): names of sites, bodies or roles (`left_hand`).
    #[serde(default)]
    pub end_effectors: Vec<String>,
    /// Further sites in the policy's observation; empty for robots that cannot measure them (thesis 4.3.1).
    #[serde(default)]
    pub key_bodies: Vec<String>,
    /// Permission to observe the root's height (thesis 4.3.1: the humanoid may, the robot may not).
    #[serde(default)]
    pub observe_root_height: bool,
    /// Policy rate (Hz); 50 where not said.
    #[serde(default)]
    pub control_hz: Option<f64>,
    /// Physics rate (Hz); 200 where not said. A multiple of the policy rate.
    #[serde(default)]
    pub physics_hz: Option<f64>,
    /// Largest end-effector deviation without consequence (m): t^p of thesis Table 4.1; 0.3, its robot's, where not said.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub deviation_limit: Option<f64>,
    /// Joint angles of the default pose (rad); joints not named are at zero, or the nearest limit.
    #[serde(default)]
    pub default_pose: BTreeMap<String, f64>,
}

/// One kind of actuator and the joints that have it.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ActuatorGroup {
    /// Joint names; `*` stands for anything.
    pub joints: Vec<String>,
    /// Inertia of the rotors through their gears (kg m²), in place of the model's own armature. URDF cannot say it,
    /// and many a MJCF leaves it out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub armature: Option<f64>,
    /// Torque that the motor holds for any time without overheating (N m); [`CONTINUOUS_SHARE`] of `torque_max` where not said.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub torque_continuous: Option<f64>,
    /// Parameters of Table 4.1; a profile may give those of another of [`MODELS`](crate::actuator::MODELS) by `model`.
    pub parameters: ActuatorParameters,
}

/// Continuous torque of an actuator whose data sheet is not known, as a share of its largest torque. Published ratios of robot
/// actuators are 0.29 (Dynamixel XH540, Table 4.1's limit), 0.35 (RobStride 02: 6 of 17 N m) and 0.41 (Mini Cheetah: 6.9 of 17 N m,
/// Katz 2018).
pub const CONTINUOUS_SHARE: f64 = 1.0 / 3.0;

impl ActuatorGroup {
    /// Returns the continuous torque (N m), known or by [`CONTINUOUS_SHARE`].
    pub fn continuous(&self) -> f64 {
        self.torque_continuous.unwrap_or(CONTINUOUS_SHARE * self.parameters.torque_max)
    }
}

impl Profile {
    /// Reads a profile. `path` is for the error messages only.
    ///
    /// # Errors
    /// [`RobotError::Profile`] with line and key for text that is not a profile, and for numbers out of range.
    pub fn from_toml(text: &str, path: &Path) -> Result<Self, RobotError> {
        let fail = |message: String| RobotError::Profile { path: path.to_path_buf(), message };
        let profile: Self = match models::resolve(text).map_err(fail)? {
            Some(resolved) => resolved.try_into().map_err(|e: toml::de::Error| fail(e.to_string()))?,
            None => toml::from_str(text).map_err(|e| fail(e.to_string()))?,
        };
        for (name, group) in &profile.actuator {
            group.parameters.check().map_err(|message| fail(format!("[actuator.{name}.parameters]: {message}")))?;
            if let Some(armature) = group.armature.filter(|a| !(a.is_finite() && *a >= 0.0)) {
                let got = format!("[actuator.{name}]: armature: expected a number of at least 0, got {armature}");
                return Err(fail(got));
            }
            let most = group.parameters.torque_max;
            if let Some(torque) = group.torque_continuous.filter(|t| !(*t > 0.0 && *t <= most)) {
                let expected = format!("expected a number above 0 and at most torque_max ({most})");
                return Err(fail(format!("[actuator.{name}]: torque_continuous: {expected}, got {torque}")));
            }
        }
        if let Some(limit) = profile.deviation_limit.filter(|limit| !(limit.is_finite() && *limit > 0.0)) {
            return Err(fail(format!("deviation_limit: expected a number above 0 (m), got {limit}")));
        }
        Ok(profile)
    }

    /// Reads a profile file.
    ///
    /// # Errors
    /// [`RobotError::Input`], and what [`Self::from_toml`] fails with.
    pub fn from_file(path: &Path) -> Result<Self, RobotError> {
        let text = std::fs::read_to_string(path).map_err(RobotError::io(path))?;
        Self::from_toml(&text, path)
    }
}

impl ActuatorParameters {
    /// Checks whether the numbers can be an actuator's; says what is wrong.
    pub(crate) fn check(&self) -> Result<(), String> {
        let at_least_zero = [
            ("kp", self.kp),
            ("kd", self.kd),
            ("static_friction", self.static_friction),
            ("viscous_friction", self.viscous_friction),
            ("full_torque_velocity", self.full_torque_velocity),
        ];
        for (key, value) in at_least_zero {
            if !(value.is_finite() && value >= 0.0) {
                return Err(format!("{key}: expected a number of at least 0, got {value}"));
            }
        }
        for (key, value) in [("friction_velocity", self.friction_velocity), ("torque_max", self.torque_max)] {
            if !(value.is_finite() && value > 0.0) {
                return Err(format!("{key}: expected a number above 0, got {value}"));
            }
        }
        if !(self.velocity_max.is_finite() && self.velocity_max > self.full_torque_velocity) {
            return Err(format!(
                "velocity_max: expected more than full_torque_velocity ({}), got {}",
                self.full_torque_velocity, self.velocity_max
            ));
        }
        self.extended_friction
            .map_or(Ok(()), |friction| friction.check().map_err(|why| format!("extended_friction: {why}")))
    }
}

/// Returns whether `name` is what `pattern` describes; `*` stands for any number of any characters.
pub fn glob(pattern: &str, name: &str) -> bool {
    let mut parts = pattern.split('*');
    let Some(mut rest) = parts.next().and_then(|first| name.strip_prefix(first)) else { return false };
    let mut parts = parts.peekable();
    if parts.peek().is_none() {
        return rest.is_empty();
    }
    while let Some(part) = parts.next() {
        if parts.peek().is_none() {
            return rest.ends_with(part);
        }
        match rest.find(part) {
            Some(at) => rest = &rest[at + part.len()..],
            None => return false,
        }
    }
    true
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::expect_used)]
    use super::*;

    #[test]
    fn a_star_stands_for_anything() {
        for (pattern, name) in [("*", "left_hip"), ("left_*", "left_hip"), ("*_hip_*", "left_hip_yaw"), ("a", "a")] {
            assert!(glob(pattern, name), "{pattern} should match {name}");
        }
        for (pattern, name) in [("left_*", "right_hip"), ("*_hip", "left_hip_yaw"), ("a", "ab"), ("ab*b", "ab")] {
            assert!(!glob(pattern, name), "{pattern} should not match {name}");
        }
        assert!(glob("ab*b", "abb"));
        assert!(glob("*a*a*", "aa"));
        assert!(!glob("*a*a*", "a"));
    }

    #[test]
    fn an_actuator_may_be_described_by_another_model() {
        let path = Path::new("x.toml");
        let read = |model: &str, parameters: &str| {
            let text = format!(
                "[actuator.leg]\njoints = [\"*\"]\nmodel = \"{model}\"\n[actuator.leg.parameters]\n{parameters}"
            );
            Profile::from_toml(&text, path).map_err(|error| error.to_string())
        };
        let ideal = read("ideal-pd", "kp = 20\nkd = 0.5\ntorque_max = 7").unwrap().actuator["leg"].parameters;
        assert_eq!((ideal.kp, ideal.static_friction, ideal.torque_max), (20.0, 0.0, 7.0));
        let servo = "proportional = 3\nsupply = 12\nresistance = 4\ntorque_constant = 1.5";
        let servo = read("dc-servo", servo).unwrap().actuator["leg"].parameters;
        assert_eq!((servo.kp, servo.torque_max, servo.velocity_max), (13.5, 4.5, 8.0));
        // M6 and M3 of an XL330 by Rhoban's BAM; one share of M3 is that of motor and outside.
        let servo_of = "kp = 400\nvin = 7.5\nerror_gain = 0.003\nkt = 0.366\nR = 2.81\narmature = 0.0018\nfriction_base = 0.005\n\
            friction_viscous = 0.0054\nq_offset = 0.03\nactuator = \"xl330\"\n";
        let m6 = "model = \"m6\"\nfriction_stribeck = 0.0047\nload_friction_motor = 0.27\nload_friction_external = 1e-5\n\
            load_friction_external_stribeck = 0.08\nload_friction_motor_quad = 0.01\ndtheta_stribeck = 2.9\nalpha = 8.7";
        let bam = read("bam", &format!("{servo_of}{m6}")).unwrap().actuator["leg"].clone();
        assert_eq!(bam.armature, Some(0.0018));
        let (law, friction) = (bam.parameters, bam.parameters.extended_friction.unwrap());
        assert!((law.kp - 0.366 * 7.5 * 400.0 * 0.003 / 2.81).abs() < 1e-12);
        assert_eq!((law.static_friction, law.viscous_friction), (0.0, 0.0054));
        assert_eq!(
            (friction.load, friction.load_quadratic, friction.stribeck_exponent),
            ([0.27, 1e-5], [0.01, 0.0], 8.7)
        );
        let m3 = read("bam", &format!("{servo_of}load_friction_base = 0.2")).unwrap().actuator["leg"].parameters;
        assert_eq!(m3.extended_friction.unwrap().load, [0.2, 0.2]);
        // Written out and read again by the names of the law.
        let written = toml::to_string(&law).unwrap();
        let written = written.replace("[extended_friction]", "[actuator.leg.parameters.extended_friction]");
        assert_eq!(read("thesis", &written).unwrap().actuator["leg"].parameters, law);
        let twice = read("thesis", &written.replace("viscous = 0.0", "viscous = 0.1")).unwrap_err();
        assert!(
            twice.contains("extended_friction: viscous: expected 0, as viscous_friction stands beside it, got 0.1"),
            "{twice}"
        );
        let thesis = toml::to_string(&servo).unwrap();
        assert_eq!(read("thesis", &thesis).unwrap().actuator["leg"].parameters, servo);
        for (model, parameters, told) in [
            ("spring", "", "[actuator.leg]: model: expected one of thesis, ideal-pd, dc-servo, bam, got \"spring\""),
            ("ideal-pd", "kp = 20\nkd = 0.5", "[actuator.leg.parameters]: missing field `torque_max`"),
            ("ideal-pd", "kp = 20\nkd = 0.5\ntorque_max = 7\nfriction = 1", "unknown field `friction`"),
            ("ideal-pd", "kp = -1\nkd = 0.5\ntorque_max = 7", "kp: expected a number of at least 0, got -1"),
        ] {
            let error = read(model, parameters).unwrap_err();
            assert!(error.contains(told), "{error}");
        }
    }

    #[test]
    fn errors_name_the_key() {
        let path = Path::new("x.toml");
        let error = Profile::from_toml("control_herz = 50\n", path).unwrap_err().to_string();
        assert!(error.contains("x.toml") && error.contains("control_herz"), "{error}");
        let text = "[actuator.leg]\njoints = [\"*\"]\n[actuator.leg.parameters]\nkp = 1\nkd = 0\n\
            friction_velocity = 0.1\nstatic_friction = 0\nviscous_friction = 0\ntorque_max = 1\n\
            full_torque_velocity = 5\nvelocity_max = 5\n";
        let error = Profile::from_toml(text, path).unwrap_err().to_string();
        assert!(error.contains("actuator.leg") && error.contains("velocity_max"), "{error}");
        let right = text.replace("\nvelocity_max = 5", "\nvelocity_max = 6");
        assert!(Profile::from_toml(&right, path).is_ok());
        let hot = right.replace("[actuator.leg.parameters]", "torque_continuous = 2\n[actuator.leg.parameters]");
        let error = Profile::from_toml(&hot, path).unwrap_err().to_string();
        assert!(error.contains("at most torque_max (1), got 2"), "{error}");
        let error = Profile::from_toml("deviation_limit = 0\n", path).unwrap_err().to_string();
        assert!(error.contains("deviation_limit: expected a number above 0 (m), got 0"), "{error}");
    }
}
