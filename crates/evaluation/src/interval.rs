//! Bootstrap 95% confidence intervals of means over clips or episodes.

use lifelike_checkpoint::rng::stream;
use rand::Rng;

use super::accuracy::mean;
use super::score::ClipScore;

/// Drawn data sets.
const DRAWS: usize = 2000;

/// 95% intervals of means over clips, each clip with the same weight (percentile bootstrap over clips, Efron and Tibshirani 1993).
/// Episodes of a clip are alike, so an interval over episodes would be too narrow.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Intervals {
    /// Of the share of episodes without a fall.
    pub survival: [f64; 2],
    /// Of the share of episodes that succeed.
    pub success: [f64; 2],
    /// Of the mean absolute joint error (deg).
    pub joint_error_deg: [f64; 2],
}

impl Intervals {
    /// Of these clips; `None` for fewer than three.
    pub fn of(clips: &[ClipScore]) -> Option<Self> {
        let of = |value: fn(&ClipScore) -> f64| interval(&clips.iter().map(value).collect::<Vec<_>>());
        (clips.len() >= 3).then(|| Self {
            survival: of(|clip| clip.survival),
            success: of(|clip| clip.success),
            joint_error_deg: of(|clip| clip.joint_error_deg),
        })
    }
}

/// Returns the middle 95% of the means of data sets that are drawn from these values with replacement; NaN values are left out.
pub(super) fn interval(values: &[f64]) -> [f64; 2] {
    let values: Vec<f64> = values.iter().copied().filter(|value| value.is_finite()).collect();
    if values.is_empty() {
        return [f64::NAN; 2];
    }
    let mut rng = stream(0, "bootstrap over clips", 0, 0);
    let mut means: Vec<f64> =
        (0..DRAWS).map(|_| mean(values.iter().map(|_| values[rng.random_range(0..values.len())]))).collect();
    means.sort_by(f64::total_cmp);
    [means[DRAWS / 40], means[DRAWS - 1 - DRAWS / 40]]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_interval_is_that_of_the_normal_law_where_there_are_many() {
        // Half of 400 clips survive: ± 1.96 √(0.25 / 400).
        let values: Vec<f64> = (0..400).map(|i| f64::from(i % 2)).collect();
        let [low, high] = interval(&values);
        assert!((low - 0.451).abs() < 0.006 && (high - 0.549).abs() < 0.006, "{low} {high}");
        assert_eq!(interval(&[2.0, f64::NAN, 2.0]), [2.0, 2.0]);
        assert!(interval(&[]).iter().all(|x| x.is_nan()));
    }
}
