//! A smooth curve through values at times.
//!
//! Between two keys a quintic polynomial with the keys' slopes and no acceleration at the keys: position, velocity and
//! acceleration are continuous (C2), and equal neighbours are held exactly. A key's slope is the harmonic mean of its two
//! secants, zero where they differ in sign: at most twice the flatter secant, which keeps the quintic monotone between
//! keys, so no curve overshoots what was written.

/// A curve through keys.
#[derive(Debug, Clone, PartialEq)]
pub struct Curve {
    /// Time (s), value, slope; times rise.
    keys: Vec<[f64; 3]>,
    /// Length of the cycle (s), of a curve that repeats.
    period: Option<f64>,
}

impl Curve {
    /// Returns the curve through these keys (time, value), whose times rise and which are at least one. With a period
    /// the curve repeats after it, and all times are in `[0, period)`.
    pub fn new(keys: &[(f64, f64)], period: Option<f64>) -> Self {
        let n = keys.len();
        let secant = |from: usize| -> Option<f64> {
            let (a, b) = (keys.get(from)?, keys.get(from + 1));
            let (time, value) = match (b, period) {
                (Some(b), _) => *b,
                (None, Some(period)) => (keys[0].0 + period, keys[0].1),
                (None, None) => return None,
            };
            Some((value - a.1) / (time - a.0))
        };
        let slope = |at: usize| {
            let before = match (at, period) {
                (0, None) => None,
                (0, Some(_)) => secant(n - 1),
                _ => secant(at - 1),
            };
            match (before, secant(at)) {
                (Some(a), Some(b)) if a * b > 0.0 => 2.0 * a * b / (a + b),
                _ => 0.0,
            }
        };
        Self { keys: (0..n).map(|at| [keys[at].0, keys[at].1, slope(at)]).collect(), period }
    }

    /// Returns the value at a time (s). Before the first and after the last key of a curve without period: theirs.
    pub fn at(&self, time: f64) -> f64 {
        let (first, last) = (self.keys[0], self.keys[self.keys.len() - 1]);
        let mut time = time;
        if let Some(period) = self.period {
            time = first[0] + (time - first[0]).rem_euclid(period);
        }
        let next = self.keys.partition_point(|key| key[0] <= time);
        let (a, b) = match (next, self.period) {
            (0, _) => return first[1],
            (at, None) if at == self.keys.len() => return last[1],
            (at, Some(period)) if at == self.keys.len() => (last, [first[0] + period, first[1], first[2]]),
            (at, _) => (self.keys[at - 1], self.keys[at]),
        };
        let width = b[0] - a[0];
        let s = (time - a[0]) / width;
        let (s3, rise) = (s * s * s, b[1] - a[1]);
        // Quintic Hermite with zero second derivatives at both ends.
        let blend = s3 * (10.0 - 15.0 * s + 6.0 * s * s);
        let start = s - s3 * (6.0 - 8.0 * s + 3.0 * s * s);
        let end = -s3 * (4.0 - 7.0 * s + 3.0 * s * s);
        a[1] + rise * blend + width * (a[2] * start + b[2] * end)
    }
}

/// Returns the minimum-jerk way from 0 to 1, for a share of the time in `[0, 1]`.
pub(crate) fn minimum_jerk(s: f64) -> f64 {
    let s = s.clamp(0.0, 1.0);
    s * s * s * (10.0 - 15.0 * s + 6.0 * s * s)
}

/// Returns a bump from 0 over 1 (in the middle) to 0, with velocity and acceleration zero at both ends.
pub(super) fn bump(s: f64) -> f64 {
    let s = s.clamp(0.0, 1.0);
    64.0 * (s * (1.0 - s)).powi(3)
}

/// Returns a bump from 0 over 1 (in the middle) to 0 that leaves and meets zero at rest, but quickly.
pub(super) fn quick_bump(s: f64) -> f64 {
    let s = s.clamp(0.0, 1.0);
    16.0 * (s * (1.0 - s)).powi(2)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn it_passes_through_its_keys_and_holds_equal_ones() {
        let curve = Curve::new(&[(0.5, 1.0), (1.0, 3.0), (2.0, 3.0), (2.5, -1.0)], None);
        for (time, value) in [(0.0, 1.0), (0.5, 1.0), (1.0, 3.0), (1.37, 3.0), (2.0, 3.0), (2.5, -1.0), (9.0, -1.0)] {
            assert!((curve.at(time) - value).abs() < 1e-12, "{time}: {}", curve.at(time));
        }
        // Half-way between two keys at rest the minimum-jerk way is half-way.
        assert!((curve.at(2.25) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn slope_and_acceleration_are_continuous() {
        let curve = Curve::new(&[(0.0, 0.0), (1.0, 1.0), (1.5, 3.0), (2.5, 3.5)], None);
        let h = 1e-4;
        for key in [1.0, 1.5] {
            let slope = |t: f64| (curve.at(t + h) - curve.at(t - h)) / (2.0 * h);
            assert!((slope(key - 2.0 * h) - slope(key + 2.0 * h)).abs() < 1e-4);
            let bend = |t: f64| (curve.at(t + h) - 2.0 * curve.at(t) + curve.at(t - h)) / (h * h);
            // Zero at the key from both sides (to first order in the distance from it: the jerk is below 500).
            assert!(bend(key - 2.0 * h).abs() < 0.2 && bend(key + 2.0 * h).abs() < 0.2, "{}", bend(key + 2.0 * h));
        }
        // Harmonic mean of the secants 1 and 4.
        assert!(((curve.at(1.0 + h) - curve.at(1.0 - h)) / (2.0 * h) - 1.6).abs() < 1e-4);
    }

    #[test]
    fn a_cycle_closes_smoothly() {
        let curve = Curve::new(&[(0.0, 0.0), (1.0, 2.0), (2.0, 1.0)], Some(3.0));
        let h = 1e-5;
        assert!((curve.at(3.0 - h) - curve.at(h)).abs() < 1e-3);
        assert!((curve.at(4.2) - curve.at(1.2)).abs() < 1e-12);
        let slope = |t: f64| (curve.at(t + h) - curve.at(t - h)) / (2.0 * h);
        assert!((slope(3.0 - 2.0 * h) - slope(2.0 * h)).abs() < 1e-3);
    }

    proptest! {
        #[test]
        fn it_never_leaves_the_range_of_its_two_keys(
            keys in prop::collection::vec((0.01..2.0f64, -100.0..100.0f64), 2..12),
            share in 0.0..1.0f64,
        ) {
            let mut time = 0.0;
            let keys: Vec<(f64, f64)> = keys.iter().map(|(step, v)| { time += step; (time, *v) }).collect();
            let curve = Curve::new(&keys, None);
            for pair in keys.windows(2) {
                let value = curve.at(pair[0].0 + share * (pair[1].0 - pair[0].0));
                let (low, high) = (pair[0].1.min(pair[1].1), pair[0].1.max(pair[1].1));
                prop_assert!(value >= low - 1e-9 && value <= high + 1e-9, "{value} outside {low}..{high}");
            }
        }
    }
}
