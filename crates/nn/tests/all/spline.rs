//! Properties of B-splines and of the Bézier curve (thesis 3.2.1), and what is refused.

use lifelike_nn::spline::{BSpline, CubicBezier, SplineError, uniform};

/// Curves of every degree to 5 with their degrees and knots.
fn curves() -> Vec<(BSpline, usize, Vec<f64>)> {
    let mut out = Vec::new();
    for degree in 0..=5 {
        for spans in [1, 2, 3, 6, 11, 40] {
            let knots = (0..spans + 2 * degree + 1).map(|i| (i as f64 - degree as f64) / spans as f64).collect();
            out.push((BSpline::new(degree, spans + degree).unwrap(), degree, knots));
        }
    }
    out
}

/// Parameters all over the domain, knots and both ends among them.
fn places(knots: &[f64]) -> Vec<f64> {
    let inside = knots.iter().copied().filter(|k| (0.0..=1.0).contains(k));
    uniform(23).into_iter().chain(inside).collect()
}

#[test]
fn weights_are_a_partition_of_unity_and_derivatives_of_zero() {
    for (curve, degree, knots) in curves() {
        for t in places(&knots) {
            let weights = curve.weights(t, 0).unwrap();
            assert!(weights.iter().all(|w| *w >= 0.0), "{curve:?} at {t}: {weights:?}");
            assert!((weights.iter().sum::<f64>() - 1.0).abs() < 1e-14, "{curve:?} at {t}");
            for derivative in 1..=degree + 1 {
                let weights = curve.weights(t, derivative).unwrap();
                let scale = weights.iter().fold(1.0_f64, |m, w| m.max(w.abs()));
                assert!(weights.iter().sum::<f64>().abs() < 1e-12 * scale, "{curve:?} at {t}: {weights:?}");
            }
        }
    }
}

#[test]
fn a_control_point_reaches_over_degree_plus_one_spans_and_no_further() {
    for (curve, p, knots) in curves() {
        for t in places(&knots) {
            let weights = curve.weights(t, 0).unwrap();
            assert!(weights.iter().filter(|w| **w != 0.0).count() <= p + 1);
            for (i, weight) in weights.iter().enumerate() {
                let reached = knots[i] < t && t < knots[i + p + 1];
                // Inside of its reach the weight is above zero, but for rounding at its edge.
                assert!(*weight == 0.0 || (knots[i] <= t && t <= knots[i + p + 1]), "{curve:?} at {t}: {i}");
                assert!(*weight > 0.0 || !reached, "{curve:?} at {t}: {i}");
            }
        }
    }
}

#[test]
fn a_knot_leaves_degree_minus_one_derivatives() {
    let mut jumps = 0;
    for (curve, degree, knots) in curves() {
        for knot in knots.into_iter().filter(|knot| 0.0 < *knot && *knot < 1.0) {
            // k − m − 1 of the thesis, k = degree + 1 and m = 1; −1 is a jump.
            let smooth = degree as isize - 1;
            for derivative in 0..=degree {
                let after = curve.weights(knot, derivative).unwrap();
                // The limit from before: a polynomial's value a hair earlier.
                let hair = 1e-9;
                let before = curve.weights(knot - hair, derivative).unwrap();
                let slope = curve.weights(knot - hair, derivative + 1).unwrap();
                let gap = (0..after.len()).fold(0.0_f64, |m, i| m.max((after[i] - before[i] - hair * slope[i]).abs()));
                let scale = after.iter().chain(&before).fold(1.0_f64, |m, w| m.max(w.abs()));
                if derivative as isize <= smooth {
                    assert!(gap < 1e-6 * scale, "{curve:?} at {knot}: derivative {derivative} jumps by {gap}");
                } else if derivative as isize == smooth + 1 {
                    assert!(gap > 1e-3, "{curve:?} at {knot}: derivative {derivative} does not jump");
                    jumps += 1;
                }
            }
        }
    }
    assert!(jumps > 100, "{jumps}");
}

#[test]
fn derivatives_are_those_of_finite_differences_from_one_side() {
    for (curve, degree, knots) in curves() {
        for t in places(&knots).into_iter().filter(|t| (0.0..1.0).contains(t)) {
            let step = 1e-6;
            if knots.iter().any(|k| *k > t && *k <= t + 2.0 * step) {
                continue;
            }
            for derivative in 0..degree {
                let at = |s: f64, d: usize| curve.weights(t + s, d).unwrap();
                let (w0, w1, w2, slope) =
                    (at(0.0, derivative), at(step, derivative), at(2.0 * step, derivative), at(0.0, derivative + 1));
                let scale = w0.iter().chain(&slope).fold(1.0_f64, |m, w| m.max(w.abs()));
                for i in 0..w0.len() {
                    let difference = (-3.0 * w0[i] + 4.0 * w1[i] - w2[i]) / (2.0 * step);
                    assert!((difference - slope[i]).abs() < 1e-6 * scale, "{curve:?} at {t}, {derivative}, {i}");
                }
            }
        }
    }
}

#[test]
fn finer_samples_contain_the_coarse_ones() {
    for (samples, factor) in [(256, 2), (256, 4), (61, 3), (2, 7), (1, 4)] {
        let (coarse, fine) = (uniform(samples), uniform((samples - 1) * factor + 1));
        assert!(coarse.iter().enumerate().all(|(i, u)| fine[i * factor] == *u));
    }
    assert_eq!((uniform(0).len(), uniform(1)[0], uniform(9)[8]), (0, 0.0, 1.0));
}

#[test]
fn what_is_wrong_is_said() {
    let said = |error: SplineError| error.to_string();
    for (error, words) in [
        (BSpline::new(3, 3).unwrap_err(), "degree 3 needs at least 4 control points, got 3"),
        (BSpline::new(1, 0).unwrap_err(), "got 0"),
        (BSpline::new(2, 4).unwrap().weights(1.1, 0).unwrap_err(), "t = 1.1 is outside of the domain 0 to 1"),
        (BSpline::new(2, 4).unwrap().weights(f64::NAN, 0).unwrap_err(), "t = NaN"),
        (CubicBezier.weights(-0.1).unwrap_err(), "t = -0.1"),
        (CubicBezier.evaluate(&[0.0; 8], 2, &[0.5, 2.0]).unwrap_err(), "t = 2"),
        (CubicBezier.evaluate(&[0.0; 10], 2, &uniform(3)).unwrap_err(), "expected 4 control points, got 5"),
    ] {
        assert!(said(error.clone()).contains(words), "'{}' lacks '{words}'", said(error));
    }
}

#[test]
fn files_are_read_as_they_are_written_and_checked() {
    let text = serde_json::to_string(&CubicBezier).unwrap();
    assert_eq!(text, r#"{"bezier":{"segments":1,"joints":"separate"}}"#);
    for own in [text.as_str(), r#"{"bezier":{"segments":1}}"#] {
        assert_eq!(serde_json::from_str::<CubicBezier>(own).unwrap(), CubicBezier);
    }
    for wrong in
        [r#"{"bezier":{"segments":2}}"#, r#"{"bezier":{"segments":1,"joints":"shared"}}"#, r#"{"b_spline":{}}"#]
    {
        assert!(serde_json::from_str::<CubicBezier>(wrong).is_err(), "{wrong}");
    }
}
