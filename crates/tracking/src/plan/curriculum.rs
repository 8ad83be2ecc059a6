//! The curriculum: difficulties that grow while a policy learns.

use crate::TrackerError;
use lifelike_train::limits::{range, wrong};

/// Ramps over environment steps; a difficulty that is not named has its full value from the start.
#[derive(Debug, Clone, Copy, Default, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Curriculum {
    /// Share of `[randomization]` in force, usually from 0 to 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub randomization: Option<Ramp>,
    /// Factor on the limits of `[termination]`; above 1 forgives more.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub termination: Option<Ramp>,
    /// Factor on the reward's penalties of actions and torques.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub smoothness: Option<Ramp>,
}

/// A number that stays, moves in a straight line, and stays again.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Ramp {
    /// Value until `begin`.
    #[schemars(extend("unit" = "1"), range(min = 0.0, max = 100.0))]
    pub from: f64,
    /// Value after `end`.
    #[serde(default = "one")]
    #[schemars(extend("unit" = "1"), range(min = 0.0, max = 100.0))]
    pub to: f64,
    /// Environment steps at which the value begins to move (steps).
    #[serde(default)]
    #[schemars(extend("unit" = "steps"))]
    pub begin: u64,
    /// Environment steps at which it arrives (steps).
    #[schemars(extend("unit" = "steps"))]
    pub end: u64,
}

fn one() -> f64 {
    1.0
}

impl Ramp {
    /// Returns the value after so many environment steps.
    pub fn at(&self, steps: u64) -> f64 {
        let share = (steps.saturating_sub(self.begin)) as f64 / (self.end - self.begin).max(1) as f64;
        self.from + (self.to - self.from) * share.min(1.0)
    }
}

impl Curriculum {
    /// Returns the values after so many environment steps: randomisation, termination, smoothness.
    pub fn at(&self, steps: u64) -> [f64; 3] {
        [self.randomization, self.termination, self.smoothness].map(|ramp| ramp.map_or(1.0, |r| r.at(steps)))
    }

    /// Checks that every ramp rises in time and stays in its range.
    ///
    /// # Errors
    /// [`TrackerError::Plan`] with the key, the expected and the given value.
    pub fn check(&self) -> Result<(), TrackerError> {
        for (name, ramp, low, high) in [
            ("randomization", self.randomization, 0.0, 1.0),
            ("termination", self.termination, 0.05, 100.0),
            ("smoothness", self.smoothness, 0.0, 100.0),
        ] {
            let Some(ramp) = ramp else { continue };
            range(&format!("curriculum.{name}.from"), ramp.from, low, high)?;
            range(&format!("curriculum.{name}.to"), ramp.to, low, high)?;
            if ramp.end <= ramp.begin {
                let expected = format!("above begin ({})", ramp.begin);
                return Err(wrong(&format!("curriculum.{name}.end"), &expected, ramp.end).into());
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ramp_by_hand() {
        let ramp = Ramp { from: 2.0, to: 1.0, begin: 100, end: 300 };
        assert_eq!([0, 100, 200, 300, 900].map(|s| ramp.at(s)), [2.0, 2.0, 1.5, 1.0, 1.0]);
        let curriculum = Curriculum { termination: Some(ramp), ..Curriculum::default() };
        assert_eq!(curriculum.at(200), [1.0, 1.5, 1.0]);
    }

    #[test]
    fn a_ramp_backwards_in_time_is_refused() {
        let backwards = Some(Ramp { from: 0.0, to: 1.0, begin: 10, end: 10 });
        let curriculum = Curriculum { randomization: backwards, ..Curriculum::default() };
        assert!(curriculum.check().is_err_and(|e| e.to_string().contains("curriculum.randomization.end")));
        let steep = Some(Ramp { from: 0.0, to: 2.0, begin: 0, end: 10 });
        let curriculum = Curriculum { randomization: steep, ..Curriculum::default() };
        assert!(curriculum.check().is_err_and(|e| e.to_string().contains("curriculum.randomization.to")));
    }
}
