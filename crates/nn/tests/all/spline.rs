//! Properties of B-splines (thesis 3.2.1) on many knot vectors, and what is refused.

use lifelike_checkpoint::rng;
use lifelike_nn::spline::{BSpline, CubicBezier, Joints, Spline, SplineError, uniform};
use rand::Rng;

/// Curves of every degree to 5 on random knots, some of them repeated, some of them at the ends.
fn curves() -> Vec<BSpline> {
    let mut rng = rng::stream(3, "spline", 0, 0);
    let mut out = Vec::new();
    for degree in 0..=5 {
        for control_points in [degree + 1, degree + 2, degree + 6] {
            out.push(BSpline::clamped(degree, control_points).unwrap());
            out.push(BSpline::unclamped(degree, control_points).unwrap());
        }
        for _ in 0..40 {
            // Whole and half numbers in a small range repeat often; too often is refused, and then another is drawn.
            let count = degree + 1 + rng.random_range(degree + 1..degree + 9);
            let mut knots: Vec<f64> = (0..count).map(|_| f64::from(rng.random_range(-6..=6)) / 2.0).collect();
            knots.sort_by(f64::total_cmp);
            out.extend(BSpline::new(degree, knots));
        }
    }
    assert!(out.len() > 150, "{}", out.len());
    out
}

/// Parameters all over the domain, knots and both ends among them.
fn places(curve: &BSpline) -> Vec<f64> {
    let (from, to) = curve.domain();
    let inside = curve.knots().iter().copied().filter(|k| (from..=to).contains(k));
    uniform(23).into_iter().map(|u| from + u * (to - from)).chain(inside).collect()
}

#[test]
fn weights_are_a_partition_of_unity_and_derivatives_of_zero() {
    for curve in curves() {
        for t in places(&curve) {
            let weights = curve.weights(t, 0).unwrap();
            assert!(weights.iter().all(|w| *w >= 0.0), "{curve:?} at {t}: {weights:?}");
            assert!((weights.iter().sum::<f64>() - 1.0).abs() < 1e-14, "{curve:?} at {t}");
            for derivative in 1..=curve.degree() + 1 {
                let weights = curve.weights(t, derivative).unwrap();
                let scale = weights.iter().fold(1.0_f64, |m, w| m.max(w.abs()));
                assert!(weights.iter().sum::<f64>().abs() < 1e-12 * scale, "{curve:?} at {t}: {weights:?}");
            }
        }
    }
}

#[test]
fn a_control_point_reaches_over_degree_plus_one_spans_and_no_further() {
    for curve in curves() {
        let (p, knots) = (curve.degree(), curve.knots());
        for t in places(&curve) {
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
fn a_knot_that_stands_m_times_leaves_degree_minus_m_derivatives() {
    let mut jumps = 0;
    for curve in curves() {
        let (from, to) = curve.domain();
        for same in curve.knots().chunk_by(|a, b| a == b).filter(|same| from < same[0] && same[0] < to) {
            // k − m − 1 of the thesis, k = degree + 1; −1 is a jump.
            let smooth = curve.degree() as isize - same.len() as isize;
            for derivative in 0..=curve.degree() {
                let after = curve.weights(same[0], derivative).unwrap();
                // The limit from before: a polynomial's value a hair earlier.
                let hair = 1e-9;
                let before = curve.weights(same[0] - hair, derivative).unwrap();
                let slope = curve.weights(same[0] - hair, derivative + 1).unwrap();
                let gap = (0..after.len()).fold(0.0_f64, |m, i| m.max((after[i] - before[i] - hair * slope[i]).abs()));
                let scale = after.iter().chain(&before).fold(1.0_f64, |m, w| m.max(w.abs()));
                if derivative as isize <= smooth {
                    assert!(gap < 1e-6 * scale, "{curve:?} at {}: derivative {derivative} jumps by {gap}", same[0]);
                } else if derivative as isize == smooth + 1 {
                    assert!(gap > 1e-3, "{curve:?} at {}: derivative {derivative} does not jump", same[0]);
                    jumps += 1;
                }
            }
        }
    }
    assert!(jumps > 100, "{jumps}");
}

#[test]
fn derivatives_are_those_of_finite_differences_from_one_side() {
    for curve in curves() {
        let (from, to) = curve.domain();
        for t in places(&curve).into_iter().filter(|t| (from..to).contains(t)) {
            let step = 1e-6;
            if curve.knots().iter().any(|k| *k > t && *k <= t + 2.0 * step) {
                continue;
            }
            for derivative in 0..curve.degree() {
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
fn a_knot_that_stands_degree_times_puts_a_control_point_on_the_curve() {
    let curve = BSpline::new(3, vec![-1.0, -0.5, 0.0, 0.0, 1.0, 2.0, 2.0, 2.0, 3.0, 4.0, 5.0, 6.0]).unwrap();
    let weights = curve.weights(2.0, 0).unwrap();
    assert_eq!(weights, [0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]);
    for degree in 1..6 {
        let clamped = BSpline::clamped(degree, degree + 3).unwrap();
        let (first, last) = (clamped.weights(0.0, 0).unwrap(), clamped.weights(1.0, 0).unwrap());
        assert_eq!((first[0], last[degree + 2]), (1.0, 1.0));
        let free = BSpline::unclamped(degree, degree + 3).unwrap();
        assert!(degree == 1 || free.weights(0.0, 0).unwrap()[0] < 1.0);
        assert_eq!(free.domain(), (0.0, 1.0));
    }
}

#[test]
fn a_bezier_segment_is_the_b_spline_with_four_knots_at_either_end() {
    let bezier = CubicBezier::default();
    let spline = BSpline::clamped(3, 4).unwrap();
    let joined = CubicBezier::new(3, Joints::Shared).unwrap();
    let knots = [0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 2.0, 2.0, 2.0, 3.0, 3.0, 3.0, 3.0];
    let chain = Spline::BSpline(BSpline::new(3, knots.to_vec()).unwrap());
    for u in uniform(41) {
        for derivative in 0..6 {
            let pairs = [
                (bezier.weights(u, derivative).unwrap(), spline.weights(u, derivative).unwrap()),
                (joined.weights(u, derivative).unwrap(), chain.weights(&[u], derivative).unwrap()),
            ];
            for (a, b) in pairs {
                assert_eq!(a.len(), b.len());
                for (a, b) in a.iter().zip(&b) {
                    // 162 is the largest third derivative of a segment a third as long, times 3.
                    assert!((a - b).abs() < 1e-11 * 500.0, "u = {u}, derivative {derivative}: {a} {b}");
                }
            }
        }
    }
}

#[test]
fn segments_meet_where_they_share_a_point_and_stand_alone_where_not() {
    let (shared, alone) =
        (CubicBezier::new(2, Joints::Shared).unwrap(), CubicBezier::new(2, Joints::Separate).unwrap());
    assert_eq!((shared.control_points(), alone.control_points()), (7, 8));
    assert_eq!(shared.control_points_of(1), 3..7);
    assert_eq!(alone.control_points_of(1), 4..8);
    assert_eq!(shared.weights(0.5, 0).unwrap(), [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]);
    assert_eq!(alone.weights(0.5, 0).unwrap(), [0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]);
    assert_eq!(alone.weights(1.0, 0).unwrap()[7], 1.0);
    let end_of_first = alone.weights(0.5_f64.next_down(), 0).unwrap();
    assert!((end_of_first[3] - 1.0).abs() < 1e-12 && end_of_first[4..] == [0.0; 4]);
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
        (BSpline::new(3, vec![0.0; 7]).unwrap_err(), "degree 3 needs at least 4 control points, got 3"),
        (BSpline::clamped(3, 3).unwrap_err(), "degree 3 needs at least 4 control points, got 3"),
        (BSpline::unclamped(1, 0).unwrap_err(), "got 0"),
        (BSpline::clamped(99, 200).unwrap_err(), "at most 64, got 99"),
        (BSpline::new(usize::MAX, vec![]).unwrap_err(), "at most 64"),
        (BSpline::new(1, vec![0.0, 1.0, 0.5, 2.0]).unwrap_err(), "knot 2 is 0.5 after 1"),
        (BSpline::new(1, vec![0.0, 1.0, f64::NAN, 2.0]).unwrap_err(), "knot 2 is NaN"),
        (BSpline::new(1, vec![0.0, 1.0, 1.0, 1.0, 2.0]).unwrap_err(), "knot 1 stands 3 times, at most 2"),
        (BSpline::new(1, vec![0.0, 1.0, 1.0, 2.0]).unwrap_err(), "begins and ends at knot 1"),
        (BSpline::clamped(2, 4).unwrap().weights(1.1, 0).unwrap_err(), "t = 1.1 is outside of the domain 0 to 1"),
        (BSpline::clamped(2, 4).unwrap().weights(f64::NAN, 0).unwrap_err(), "t = NaN"),
        (CubicBezier::default().weights(-0.1, 0).unwrap_err(), "t = -0.1"),
        (CubicBezier::new(0, Joints::Shared).unwrap_err(), "at least one segment"),
        (Spline::default().weights(&[0.5, 2.0], 0).unwrap_err(), "t = 2"),
    ] {
        assert!(said(error.clone()).contains(words), "'{}' lacks '{words}'", said(error));
    }
    let error = Spline::default().evaluate(&[0.0; 10], 2, 3).unwrap_err();
    assert!(said(error).contains("expected 4 control points, got 5"));
}

#[test]
fn files_are_read_as_they_are_written_and_checked() {
    for spline in [
        Spline::default(),
        Spline::Bezier(CubicBezier::new(3, Joints::Shared).unwrap()),
        Spline::BSpline(BSpline::clamped(2, 5).unwrap()),
    ] {
        let text = serde_json::to_string(&spline).unwrap();
        assert_eq!(serde_json::from_str::<Spline>(&text).unwrap(), spline, "{text}");
    }
    for wrong in [r#"{"bezier":{"segments":0}}"#, r#"{"b_spline":{"degree":1,"knots":[0,2,1,3]}}"#] {
        assert!(serde_json::from_str::<Spline>(wrong).is_err(), "{wrong}");
    }
}
