//! Physics as the judge of an alignment's weights: a critic that is exploited cannot choose them.

use lifelike_language::Split;

use crate::GenerationError;
use crate::generator::Generator;

/// Share of falls below which halving it counts no more.
const FALLS_FLOOR: f64 = 0.01;

/// A policy's marks on the motion of one generator.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PhysicsMarks {
    /// Share of episodes with a fall.
    pub falls: f64,
    /// Errors of thesis Table 5.3: root's linear velocity (m/s), angular velocity (rad/s) and rotation without
    /// heading (deg), joints of the upper and of the lower body (deg); over all frames. Not a number, `null` in JSON, where everything fell at once.
    #[serde(deserialize_with = "null_is_nan")]
    pub errors: [f64; 5],
}

fn null_is_nan<'de, D: serde::Deserializer<'de>>(deserializer: D) -> Result<[f64; 5], D::Error> {
    let errors: [Option<f64>; 5] = serde::Deserialize::deserialize(deserializer)?;
    Ok(errors.map(|error| error.unwrap_or(f64::NAN)))
}

impl PhysicsMarks {
    /// Returns the mean of two ratios to another generator's marks: falls, and the mean ratio of the errors. 1 where nothing
    /// differs, lower is better, infinite where an error is not a number and the other's is.
    pub fn relative_to(&self, before: &Self) -> f64 {
        let pairs = self.errors.iter().zip(before.errors).filter(|(_, before)| before.is_finite() && *before > 0.0);
        let ratios: Vec<f64> = pairs.map(|(now, before)| now / before).collect();
        let errors = if ratios.is_empty() { 1.0 } else { ratios.iter().sum::<f64>() / ratios.len() as f64 };
        let falls = self.falls.max(FALLS_FLOOR) / before.falls.max(FALLS_FLOOR);
        let mean = 0.5 * (falls + errors);
        if mean.is_nan() { f64::INFINITY } else { mean }
    }

    /// Returns falls and errors in one row.
    pub fn row(&self) -> [f64; 6] {
        let [a, b, c, d, e] = self.errors;
        [self.falls, a, b, c, d, e]
    }

    /// Returns the marks of such a row.
    pub fn of_row([falls, a, b, c, d, e]: [f64; 6]) -> Self {
        Self { falls, errors: [a, b, c, d, e] }
    }
}

/// Plays a generator's motion in physics. The same generator gets the same marks.
pub trait PhysicsJudge: std::fmt::Debug {
    /// Returns the marks of a generator's motion.
    ///
    /// # Errors
    /// Motion cannot be made, or not be played.
    fn judge(&self, generator: &Generator) -> Result<PhysicsMarks, GenerationError>;
}

/// Motion that the judge plays.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct JudgePlan {
    /// Largest number of sentences, evenly from the split.
    #[schemars(extend("unit" = "1"), range(min = 1, max = 100_000))]
    pub sentences: usize,
    /// Split of the sentences.
    pub split: Split,
    /// Number of episodes of the thesis' protocol (5.3.3), which continue after a fall.
    #[schemars(extend("unit" = "1"), range(min = 1, max = 1_000_000))]
    pub episodes: usize,
    /// Length of an episode (s).
    #[schemars(extend("unit" = "s"), range(min = 0.1, max = 3600.0))]
    pub seconds: f64,
}

impl Default for JudgePlan {
    fn default() -> Self {
        Self { sentences: 48, split: Split::Validation, episodes: 256, seconds: 10.0 }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    const BEFORE: PhysicsMarks = PhysicsMarks { falls: 0.5, errors: [0.2, 0.4, 10.0, 4.0, 8.0] };

    #[test]
    fn half_the_falls_and_a_quarter_off_the_legs_by_hand() {
        assert_eq!(BEFORE.relative_to(&BEFORE), 1.0);
        // Falls 1/2; errors (1 + 1 + 1 + 1 + 0.75) / 5 = 0.95.
        let now = PhysicsMarks { falls: 0.25, errors: [0.2, 0.4, 10.0, 4.0, 6.0] };
        assert!((now.relative_to(&BEFORE) - 0.725).abs() < 1e-12);
        assert_eq!(PhysicsMarks::of_row(now.row()), now);
    }

    #[test]
    fn what_never_falls_cannot_win_by_falls_and_what_always_falls_at_once_never_wins() {
        let calm = PhysicsMarks { falls: 0.004, ..BEFORE };
        assert_eq!(PhysicsMarks { falls: 0.0, ..BEFORE }.relative_to(&calm), 1.0);
        let fallen = PhysicsMarks { falls: 1.0, errors: [f64::NAN; 5] };
        assert_eq!(fallen.relative_to(&BEFORE), f64::INFINITY);
        // Nothing to compare errors with: falls alone count.
        assert_eq!(BEFORE.relative_to(&fallen), 0.75);
        let back: PhysicsMarks = serde_json::from_str(&serde_json::to_string(&fallen).unwrap()).unwrap();
        assert!(back.falls == 1.0 && back.errors.iter().all(|error| error.is_nan()));
    }
}
