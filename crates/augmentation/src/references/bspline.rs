//! Uniform B-splines of any order.

/// Returns the weights of the control points `i` to `i + order` at the share `t` (0 to 1) of the piece between them.
/// They follow from the recursion of Cox and de Boor on equal knots. Order 0 jumps from point to point, 1 is a line
/// between them, 3 the usual cubic.
pub fn weights(order: usize, t: f64) -> Vec<f64> {
    let mut weights = vec![1.0];
    for k in 1..=order {
        let mut next = vec![0.0; k + 1];
        for (i, weight) in weights.iter().enumerate() {
            // Each basis function of the order below lends to two of this one.
            let share = (t + (k - 1 - i) as f64) / k as f64;
            next[i] += weight * (1.0 - share);
            next[i + 1] += weight * share;
        }
        weights = next;
    }
    weights
}

/// Returns the curve's point at `time`, in units of the knots' distance, through rows of `width` numbers. Beyond the last piece it stays.
pub fn at(points: &[f64], width: usize, order: usize, time: f64) -> Vec<f64> {
    let last = (points.len() / width).saturating_sub(order + 1);
    let piece = (time.max(0.0).floor() as usize).min(last);
    let weights = weights(order, (time - piece as f64).clamp(0.0, 1.0));
    let rows = points[piece * width..].chunks_exact(width);
    let mut out = vec![0.0; width];
    for (row, weight) in rows.zip(weights) {
        row.iter().zip(&mut out).for_each(|(x, out)| *out += weight * x);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_are_the_known_polynomials() {
        let close = |a: &[f64], b: &[f64]| a.iter().zip(b).all(|(x, y)| (x - y).abs() < 1e-12) && a.len() == b.len();
        let t = 0.3_f64;
        assert!(close(&weights(0, t), &[1.0]));
        assert!(close(&weights(1, t), &[0.7, 0.3]));
        assert!(close(&weights(2, t), &[0.49 / 2.0, (1.0 + 2.0 * t - 2.0 * t * t) / 2.0, 0.09 / 2.0]));
        let cubic = [
            (1.0 - t).powi(3),
            3.0 * t.powi(3) - 6.0 * t * t + 4.0,
            1.0 + 3.0 * t + 3.0 * t * t - 3.0 * t.powi(3),
            t.powi(3),
        ];
        assert!(close(&weights(3, t), &cubic.map(|x| x / 6.0)), "{:?}", weights(3, t));
        for order in 0..=4 {
            assert!((weights(order, t).iter().sum::<f64>() - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn pieces_join() {
        let points: Vec<f64> = (0..12).map(|i| (f64::from(i) * 1.7).sin()).collect();
        for order in 1..=4 {
            for knot in 1..3 {
                let [before, after] = [-1e-9, 1e-9].map(|e| at(&points, 2, order, f64::from(knot) + e));
                assert!(before.iter().zip(after).all(|(a, b)| (a - b).abs() < 1e-7), "order {order}");
            }
        }
        assert_eq!(at(&points, 2, 0, 1.5), points[2..4], "order 0 holds");
        assert_eq!(at(&points, 2, 0, 99.0), points[10..], "the end stays");
    }
}
