//! A smooth curve that only rises: times in, times out.

/// Through these points (x, y), both strictly rising, at least two: piecewise cubic with the slopes of Fritsch and
/// Butland (*A method for constructing local monotone piecewise cubic interpolants*, 1984), monotone, with a continuous
/// first derivative. Beyond its ends it goes on straight.
#[derive(Debug, Clone)]
pub(super) struct Monotone {
    /// x, y, slope.
    knots: Vec<[f64; 3]>,
}

impl Monotone {
    /// Returns the curve through these points.
    pub fn new(points: &[(f64, f64)]) -> Self {
        let n = points.len();
        let width = |i: usize| points[i + 1].0 - points[i].0;
        let secant = |i: usize| (points[i + 1].1 - points[i].1) / width(i);
        let slope = |i: usize| {
            if n < 3 || i == 0 || i == n - 1 {
                // At the ends as fast as on the whole piece, so one piece is a straight line.
                return secant(i.min(n - 2));
            }
            let (h0, h1) = (width(i - 1), width(i));
            let (w0, w1) = (2.0 * h1 + h0, h1 + 2.0 * h0);
            (w0 + w1) / (w0 / secant(i - 1) + w1 / secant(i))
        };
        Self { knots: (0..n).map(|i| [points[i].0, points[i].1, slope(i)]).collect() }
    }

    /// Returns the value at `x`.
    pub fn at(&self, x: f64) -> f64 {
        let next = self.knots.partition_point(|k| k[0] <= x);
        let (a, b) = match next {
            0 => return self.knots[0][1] + (x - self.knots[0][0]) * self.knots[0][2],
            n if n == self.knots.len() => {
                let end = self.knots[n - 1];
                return end[1] + (x - end[0]) * end[2];
            }
            n => (self.knots[n - 1], self.knots[n]),
        };
        let h = b[0] - a[0];
        let s = (x - a[0]) / h;
        let (s2, s3) = (s * s, s * s * s);
        a[1] + (b[1] - a[1]) * (3.0 * s2 - 2.0 * s3) + h * (a[2] * (s - 2.0 * s2 + s3) + b[2] * (s3 - s2))
    }

    /// Returns the `x` at which the value is `y`.
    pub fn inverse(&self, y: f64) -> f64 {
        let (first, last) = (self.knots[0], self.knots[self.knots.len() - 1]);
        if y <= first[1] {
            return first[0] + (y - first[1]) / first[2];
        }
        if y >= last[1] {
            return last[0] + (y - last[1]) / last[2];
        }
        let (mut low, mut high) = (first[0], last[0]);
        // Halving 60 times is as exact as numbers are.
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            *(if self.at(middle) < y { &mut low } else { &mut high }) = middle;
        }
        0.5 * (low + high)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn slopes_by_hand() {
        // Secants 2 and 0.5 on widths 1 and 2: weights 2*2+1 = 5 and 2+2*1 = 4, slope 9 / (5/2 + 4/0.5) = 6/7.
        let curve = Monotone::new(&[(0.0, 0.0), (1.0, 2.0), (3.0, 3.0)]);
        let d = (curve.at(1.0 + 1e-6) - curve.at(1.0 - 1e-6)) / 2e-6;
        assert!((d - 6.0 / 7.0).abs() < 1e-6, "{d}");
        // Middle of the first piece: 1 + (2 - 6/7) / 8.
        assert!((curve.at(0.5) - (1.0 + (2.0 - 6.0 / 7.0) / 8.0)).abs() < 1e-12);
        let line = Monotone::new(&[(0.0, 1.0), (2.0, 5.0)]);
        assert!((line.at(0.7) - 2.4).abs() < 1e-12 && (line.at(3.0) - 7.0).abs() < 1e-12);
    }

    proptest! {
        #[test]
        fn it_rises_through_its_points_and_back(steps in prop::collection::vec((0.01_f64..2.0, 0.01_f64..2.0), 2..8)) {
            let mut points = vec![(0.0, 0.0)];
            for (dx, dy) in steps {
                let (x, y) = points[points.len() - 1];
                points.push((x + dx, y + dy));
            }
            let curve = Monotone::new(&points);
            for (x, y) in &points {
                prop_assert!((curve.at(*x) - y).abs() < 1e-9);
                prop_assert!((curve.inverse(*y) - x).abs() < 1e-6);
            }
            let end = points[points.len() - 1].0;
            let values: Vec<f64> = (0..=400).map(|i| curve.at(end * f64::from(i) / 400.0)).collect();
            prop_assert!(values.windows(2).all(|w| w[1] > w[0] - 1e-12));
        }
    }
}
