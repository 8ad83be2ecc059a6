//! The mean of repeated measurements with its 95% confidence interval.

use std::fmt;

/// A mean with its 95% confidence interval, mean ± `half_width`.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Interval {
    /// Mean over the repetitions.
    pub mean: f64,
    /// 1.96 σ / √n with the population's standard deviation σ, as Guo et al. compute it.
    pub half_width: f64,
}

impl Interval {
    /// Returns the interval of repeated measurements; not a number where there is none.
    pub fn of(values: &[f64]) -> Self {
        let n = values.len() as f64;
        let mean = values.iter().sum::<f64>() / n;
        let variance = values.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / n;
        Self { mean, half_width: 1.96 * variance.sqrt() / n.sqrt() }
    }
}

/// `0.684 ± 0.007`.
impl fmt::Display for Interval {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:.3} ± {:.3}", self.mean, self.half_width)
    }
}
