//! Bounds of a conversion's errors: beyond them the result is another motion than the captured one, and is refused.

use super::report::RetargetReport;
use crate::error::MotionError;

/// Largest mean errors of a conversion. The defaults are about one and a half times the worst of 202 conversions of
/// captured dances, climbs, runs and karate (docs/results/inputs.md). A misread skeleton is beyond twice that.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Bounds {
    /// Distance of key bodies from their targets, as a share of the character's leg length.
    pub position: f64,
    /// Angle between orientations (deg).
    pub angle: f64,
    /// Speed of standing soles, in leg lengths per second.
    pub skate: f64,
}

impl Default for Bounds {
    fn default() -> Self {
        Self { position: 0.15, angle: 25.0, skate: 0.2 }
    }
}

impl Bounds {
    /// Refuses a conversion that is beyond a bound. `leg` is the character's leg length (m), `travels` whether the root does.
    ///
    /// # Errors
    /// [`MotionError::Unfit`] with every bound that is exceeded, and the options that would accept it.
    pub(super) fn check(&self, report: &RetargetReport, leg: f64, travels: bool) -> Result<(), MotionError> {
        let (position, angle) = (report.mean_position_error() / leg, report.mean_orientation_error());
        let skate = report.foot_skate.mean / leg;
        let measures = [
            ("position", "key bodies are off by", position, self.position, "of the leg's length"),
            ("angle", "orientations are off by", angle, self.angle, "deg"),
            ("skate", "standing soles move at", skate, self.skate, "leg lengths per second"),
        ];
        let beyond: Vec<_> = measures.into_iter().filter(|(_, _, got, bound, _)| got > bound).collect();
        if beyond.is_empty() {
            return Ok(());
        }
        let told = beyond.iter().map(|(_, what, got, bound, unit)| format!("{what} {got:.2} {unit} (at most {bound})"));
        let why = match skate > self.skate && !travels {
            true => {
                "The root stays at its place: a treadmill, or a capture without positions of the root. Else compare"
            }
            false => "Compare",
        };
        // Half as much again, rounded up: the same clip passes, another cause of error does not.
        let options = beyond.iter().map(|(key, _, got, ..)| format!("bounds.{key}={:.2}", 1.5 * got + 0.005));
        let message = format!(
            "the result is not the captured motion: {}. {why} the capture's axes, unit, rate and roles with its names \
             (correspondence.roles.ROLE=JOINT, --scale). To convert it as it is: {}",
            told.collect::<Vec<_>>().join("; "),
            options.collect::<Vec<_>>().join(" ")
        );
        Err(MotionError::Unfit { clip: report.clip.clone(), message })
    }
}
