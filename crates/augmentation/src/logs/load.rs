//! The unit of a bench's load, and angles of another unit: what the servo's gain commands is the evidence.

use super::bam::{BenchLog, DYNAMIXEL_DUTY_UNITS, commanded_duty};
use super::bench_checks::{Fault, SAME, fit};

/// Units of a load, as a log's `load_unit` says them.
#[derive(Debug, Clone, Copy, PartialEq, serde::Deserialize)]
pub(super) enum LoadUnit {
    /// 885ths, as a Dynamixel has it.
    #[serde(rename = "885ths")]
    Dynamixel,
    /// Percent.
    #[serde(rename = "%")]
    Percent,
    /// The duty itself.
    #[serde(rename = "1")]
    Duty,
}

/// A load whose unit is not said ends here if it is in percent.
const PERCENT: f64 = 100.0;
/// Loads for each radian of error, as a share of what the gain commands. Below the first they are nearer to percent than
/// to 885ths: it is the root of both units' quotient. Above the second, angles are nearer to degrees than to radians.
const LEAST_SHARE: f64 = 0.336;
const MOST_SHARE: f64 = 7.57;

impl LoadUnit {
    /// Returns the load of a duty of 1.
    pub(super) fn whole(self) -> f64 {
        match self {
            Self::Dynamixel => DYNAMIXEL_DUTY_UNITS,
            Self::Percent => PERCENT,
            Self::Duty => 1.0,
        }
    }
}

/// Returns the duty for each radian between goal and position, as a share of what the servo's gain commands. An unknown
/// servo has none, nor has a log where the two do not go together.
fn share(log: &BenchLog) -> Option<f64> {
    let commanded = commanded_duty(&log.motor)? * log.gain;
    let duty: Vec<f64> = log.voltage.as_ref()?.iter().map(|voltage| voltage / log.supply).collect();
    let on: Vec<usize> = (0..log.time.len()).filter(|i| log.enabled[*i]).collect();
    let error: Vec<f64> = on.iter().map(|i| log.goal[*i] - log.position[*i]).collect();
    let duty: Vec<f64> = on.iter().map(|i| duty[*i]).collect();
    let (slope, agreement) = fit(&error, &duty);
    (agreement > SAME).then_some(slope / commanded)
}

/// Checks loads against the gain. `guessed` is the largest load where nothing says its unit and 885ths were taken.
/// Returns a remark where nothing decides.
///
/// # Errors
/// Loads that are in percent, and angles that are in radians but were called degrees, by the gain of a known servo.
pub(super) fn check(log: &BenchLog, guessed: Option<f64>) -> Result<Option<String>, Fault> {
    let doubtful = guessed.filter(|largest| *largest <= PERCENT);
    let cure = "say \"load_unit\": \"%\" beside \"kp\"";
    match (share(log), doubtful) {
        (Some(share), _) if share > MOST_SHARE => {
            let expected = format!("radians: the duty that kp {} commands for the way to the goal", log.gain);
            let got = format!("{share:.1} times that duty (radians that the header calls degrees?)");
            Err(("position".into(), expected, got))
        }
        (Some(share), Some(largest)) if share < LEAST_SHARE => {
            let expected = format!("885ths of the duty that kp {} commands for the way to the goal", log.gain);
            let got = format!("{share:.2} times that, and at most {largest} (percent? {cure})");
            Err(("load".into(), expected, got))
        }
        (None, Some(largest)) => {
            let part = 100.0 * largest / DYNAMIXEL_DUTY_UNITS;
            Ok(Some(format!(
                "load of at most {largest} was taken for 885ths, {part:.0}% of the supply; if it is in percent, {cure}"
            )))
        }
        _ => Ok(None),
    }
}
