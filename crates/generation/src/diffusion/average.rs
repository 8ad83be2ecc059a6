//! Exponential moving average of weights.

/// The mean of all weights so far, the last ones counting most: mean ← r mean + (1 − r) weights.
///
/// r is the rate, but never more than (1 + n) / (10 + n) at step n: a short training is not averaged with its beginning.
#[derive(Debug, Clone, PartialEq)]
pub struct Average {
    rate: f64,
    values: Vec<f32>,
}

impl Average {
    /// Returns an average that begins with these weights.
    pub fn new(rate: f64, values: Vec<f32>) -> Self {
        Self { rate, values }
    }

    /// Adds the weights after step n (counted from 0).
    pub fn add(&mut self, weights: &[f32], n: u64) {
        let rate = self.rate.min((1.0 + n as f64) / (10.0 + n as f64));
        let share = (1.0 - rate) as f32;
        self.values.iter_mut().zip(weights).for_each(|(mean, x)| *mean += share * (x - *mean));
    }

    /// Returns the averaged weights.
    pub fn values(&self) -> &[f32] {
        &self.values
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_forgets_at_its_rate_once_it_has_begun() {
        let mut average = Average::new(0.5, vec![0.0]);
        average.add(&[1.0], 0);
        assert!((average.values()[0] - 0.9).abs() < 1e-6, "the first step counts 0.9: {average:?}");
        average.add(&[0.0], 1_000_000);
        assert!((average.values()[0] - 0.45).abs() < 1e-6, "{average:?}");
    }
}
