//! Rows → tokens → rows, on our own keyframed clips.

use lifelike_generation::representation::{FeatureMatrix, RepresentationSpec};
use lifelike_generation::space::{MotionSpace, SpaceKind};
use lifelike_robot::{Robot, clips};

fn motions() -> (RepresentationSpec, Vec<FeatureMatrix>) {
    let robot = Robot::load("lima").unwrap();
    let spec = RepresentationSpec::of(&robot.layout);
    let clips = clips::builtin(&robot).all().unwrap();
    let motions = clips.iter().map(|clip| FeatureMatrix::from_clip(clip, &spec).unwrap()).collect();
    (spec, motions)
}

fn spline(spec: &RepresentationSpec, knot_seconds: f64) -> MotionSpace {
    MotionSpace::new(spec.clone(), SpaceKind::Spline { knot_seconds })
}

#[test]
fn frames_are_the_rows() {
    let (spec, motions) = motions();
    let space = MotionSpace::new(spec.clone(), SpaceKind::Frames);
    assert_eq!((space.width(), space.tokens(41)), (spec.width(), 41));
    let tokens = space.encode(&motions[0]).unwrap();
    assert_eq!(space.decode(&tokens, motions[0].n).unwrap(), motions[0]);
}

#[test]
fn control_points_are_a_fourth_and_bring_curves_back() {
    let (spec, motions) = motions();
    let space = spline(&spec, 0.2);
    assert_eq!(space.width(), 7 + spec.joints());
    assert_eq!(space.tokens(201), 53, "10 s: 50 spans");
    let degrees = |knot_seconds: f64| {
        let space = spline(&spec, knot_seconds);
        let (mut squares, mut count) = (0.0, 0);
        for motion in &motions {
            let tokens = space.encode(motion).unwrap();
            let back = space.decode(&tokens, motion.n).unwrap();
            assert_eq!((back.n, back.width), (motion.n, motion.width));
            for (a, b) in motion.rows.chunks_exact(motion.width).zip(back.rows.chunks_exact(motion.width)) {
                squares += spec.angles().map(|c| f64::from(a[c] - b[c]).powi(2)).sum::<f64>();
                count += spec.joints();
            }
        }
        (f64::sqrt(squares / count as f64)).to_degrees()
    };
    // A cubic's error falls with the fourth power of the distance where the motion is smooth; steps and claps are not.
    let [fine, middle, coarse] = [0.1, 0.2, 0.4].map(degrees);
    assert!(2.0 * fine < middle && 2.0 * middle < coarse && middle < 1.0, "{fine} {middle} {coarse}");
}

/// A cubic polynomial is a spline: nothing is lost, and its velocity is the derivative.
#[test]
fn cubics_are_kept_exactly_with_their_derivatives() {
    let spec = RepresentationSpec::new(vec!["a".into()]);
    for rows in [2, 5, 30, 57] {
        let curve = |t: f64| 0.3 + t - 0.4 * t * t + 0.05 * t * t * t;
        let slope = |t: f64| 1.0 - 0.8 * t + 0.15 * t * t;
        let row = |i: usize| {
            let t = i as f64 / spec.fps;
            [0.7, 0.1, 0.2, 0.3, 0.0, 0.0, 1.0, curve(t) as f32, slope(t) as f32]
        };
        let motion = FeatureMatrix::new((0..rows).flat_map(row).collect(), 9).unwrap();
        let space = spline(&spec, 0.2);
        let back = space.decode(&space.encode(&motion).unwrap(), rows).unwrap();
        for i in 0..rows {
            assert!((back.row(i)[7] - motion.row(i)[7]).abs() < 1e-4, "{rows}, {i}");
            // Two rows fix a curve, not its slope.
            assert!(rows == 2 || (back.row(i)[8] - motion.row(i)[8]).abs() < 2e-2, "{rows}, {i}: {:?}", back.row(i));
        }
    }
}

/// ⟨decode(x), y⟩ = ⟨x, transposed(y)⟩.
#[test]
fn gradients_pass_by_the_transpose() {
    let spec = RepresentationSpec::new(vec!["a".into(), "b".into()]);
    for kind in [SpaceKind::Frames, SpaceKind::default()] {
        let space = MotionSpace::new(spec.clone(), kind);
        let rows = 23;
        let wave = |n: usize, pace: f32| (0..n).map(|i| (i as f32 * pace).sin()).collect::<Vec<_>>();
        let x = wave(space.tokens(rows) * space.width(), 0.37);
        let y = FeatureMatrix::new(wave(rows * spec.width(), 0.11), spec.width()).unwrap();
        let dot = |a: &[f32], b: &[f32]| a.iter().zip(b).map(|(a, b)| f64::from(a * b)).sum::<f64>();
        let (left, right) =
            (dot(&space.decode(&x, rows).unwrap().rows, &y.rows), dot(&x, &space.transposed(&y).unwrap()));
        assert!((left - right).abs() < 1e-3 * left.abs().max(1.0), "{left} {right}");
    }
}

#[test]
fn what_does_not_fit_is_refused() {
    let spec = RepresentationSpec::new(vec!["a".into()]);
    let space = spline(&spec, 0.2);
    assert!(space.decode(&[0.0; 7], 20).is_err() && space.decode(&[], 0).is_err());
    assert!(space.encode(&FeatureMatrix { rows: vec![], n: 0, width: 9 }).is_err());
    assert!(space.encode(&FeatureMatrix { rows: vec![0.0; 8], n: 1, width: 8 }).is_err());
}
