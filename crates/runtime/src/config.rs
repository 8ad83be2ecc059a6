//! Settings of a run.

use crate::gate::LimitSettings;
use crate::phase::Durations;
use crate::{FromInput, RuntimeError};

/// Settings of a run (TOML). Every key has a default.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Config {
    /// Commands per second (Hz): a multiple of the policy's rate.
    pub command_hz: f64,
    /// Share of a policy step in which targets go over to the policy's new ones; 0: at once, 1: until the next step.
    pub interpolation: f64,
    /// Largest speed of targets while standing up (rad/s).
    pub stand_rate: f64,
    /// Estimate the root's state by IMU and legs for policies that see it, where the machine does not send it.
    pub estimate_root: bool,
    /// Lengths of the phases.
    pub durations: Durations,
    /// Limits of the gate.
    pub limits: LimitSettings,
}

impl Default for Config {
    fn default() -> Self {
        Self {
            command_hz: 1000.0,
            interpolation: 0.25,
            stand_rate: 1.5,
            estimate_root: true,
            durations: Durations::default(),
            limits: LimitSettings::default(),
        }
    }
}

impl Config {
    /// Reads settings from TOML.
    ///
    /// # Errors
    /// An unknown key, a wrong type or a number out of range.
    pub fn from_toml(text: &str) -> Result<Self, RuntimeError> {
        let config: Self = toml::from_str(text)
            .map_err(|error| RuntimeError::mismatch("settings", "TOML of the runtime's keys", error.message()))?;
        config.check()?;
        Ok(config)
    }

    /// Checks the numbers that do not depend on a robot.
    ///
    /// # Errors
    /// The first that is out of range.
    pub fn check(&self) -> Result<(), RuntimeError> {
        let within = |key: &str, value: f64, low: f64, high: f64| {
            let good = (low..=high).contains(&value);
            let expected = format!("a number from {low} to {high}");
            if good { Ok(()) } else { Err(RuntimeError::mismatch(key, &expected, value)) }
        };
        within("command_hz", self.command_hz, 1.0, 10_000.0)?;
        within("interpolation", self.interpolation, 0.0, 1.0)?;
        within("stand_rate", self.stand_rate, 1e-3, 100.0)?;
        let Durations { stand, blend_in, blend_out, damp, get_up } = self.durations;
        let durations =
            [("stand", stand), ("blend_in", blend_in), ("blend_out", blend_out), ("damp", damp), ("get_up", get_up)];
        for (key, value) in durations {
            within(&format!("durations.{key}"), value, 0.0, 60.0)?;
        }
        self.limits.check()
    }

    /// Returns the number of commands per policy step.
    ///
    /// # Errors
    /// The policy's rate (Hz) does not divide the rate of commands.
    pub fn ticks_per_step(&self, control_hz: f64) -> Result<usize, RuntimeError> {
        let ticks = (self.command_hz / control_hz).round();
        if ticks < 1.0 || (ticks * control_hz - self.command_hz).abs() > 1e-6 {
            let expected = format!("a multiple of the policy's rate ({control_hz} Hz)");
            return Err(RuntimeError::mismatch("command_hz", &expected, self.command_hz));
        }
        Ok(ticks as usize)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn keys_are_checked_by_name() {
        assert_eq!(Config::from_toml("").unwrap(), Config::default());
        for (text, part) in [
            ("command_herz = 1", "command_herz"),
            ("command_hz = 0", "command_hz: expected a number from 1 to 10000, got 0"),
            ("[limits]\ntorque_share = 1.5", "limits.torque_share: expected a share above 0 and at most 1, got 1.5"),
            ("[limits]\ntilt_max = nan", "limits.tilt_max"),
            ("[limits]\ntemperature_max = 60", "more than limits.temperature_derate (70), got 60"),
            ("[durations]\ndamp = -1", "durations.damp"),
        ] {
            let error = Config::from_toml(text).unwrap_err().to_string();
            assert!(error.contains(part), "{error}");
        }
        let error = Config::default().ticks_per_step(300.0).unwrap_err().to_string();
        assert!(error.contains("command_hz: expected a multiple of the policy's rate (300 Hz), got 1000"), "{error}");
    }
}
