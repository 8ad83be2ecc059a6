//! Schedules of learning rates and loss weights: pure functions of the iteration.

use std::f64::consts::PI;

/// Linear annealing in cycles (Fu et al. 2019, thesis Table 4.1: 7 cycles, ratio 0.5): in each of `cycles` equal parts
/// of `total` iterations the weight rises from 0 to 1 over the first `ratio`, and then remains 1. After `total` it
/// stays at 1.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Cyclical {
    /// Iterations of all cycles together.
    pub total: u64,
    /// Number of cycles.
    pub cycles: u64,
    /// Part of each cycle spent rising, in (0, 1].
    pub ratio: f64,
}

impl Cyclical {
    /// Returns the weight at an iteration (counted from 0), in [0, 1].
    pub fn at(&self, iteration: u64) -> f64 {
        if iteration >= self.total || self.cycles == 0 {
            return 1.0;
        }
        let period = self.total as f64 / self.cycles as f64;
        let phase = (iteration as f64 / period).fract();
        (phase / self.ratio.max(f64::MIN_POSITIVE)).min(1.0)
    }
}

/// Returns the factor of cosine annealing (Loshchilov & Hutter 2017, eq. 5 without restarts): from 1 at iteration 0 to `floor` at `total`.
pub fn cosine(iteration: u64, total: u64, floor: f64) -> f64 {
    let t = (iteration.min(total) as f64) / (total.max(1) as f64);
    floor + (1.0 - floor) * 0.5 * (1.0 + (PI * t).cos())
}

/// Cosine annealing with warm restarts (Loshchilov & Hutter 2017, eq. 5; thesis Table 4.1: T_0 1000, T_mult 5).
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WarmRestarts {
    /// Iterations until the first restart.
    pub first: u64,
    /// Each period is this many times longer than the one before.
    pub factor: u64,
    /// The smallest value, reached just before each restart.
    pub floor: f64,
}

impl WarmRestarts {
    /// Returns the factor on the learning rate at an iteration (counted from 0), in [floor, 1].
    pub fn at(&self, iteration: u64) -> f64 {
        let (begin, period) = self.period(iteration);
        cosine(iteration - begin, period, self.floor)
    }

    /// Returns the iteration at which the period that `iteration` lies in began.
    pub fn begin_of_period(&self, iteration: u64) -> u64 {
        self.period(iteration).0
    }

    fn period(&self, iteration: u64) -> (u64, u64) {
        let (mut begin, mut length) = (0, self.first.max(1));
        while iteration - begin >= length {
            begin += length;
            length = length.saturating_mul(self.factor.max(1));
        }
        (begin, length)
    }
}
