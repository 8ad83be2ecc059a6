//! A cube with a sole, whose numbers can be calculated by hand.

#![allow(clippy::unwrap_used)]

use lifelike_character::anatomy::Role;
use lifelike_character::{Anatomy, Character, Quat, Vec3};

use super::*;
use crate::clip::Provenance;
use crate::fixtures;

const FPS: f64 = 50.0;

/// The cube, whose lower side is a sole.
fn cube() -> (Character, Anatomy) {
    let corners = [(0.1, 0.1), (-0.1, 0.1), (-0.1, -0.1), (0.1, -0.1)].map(|(x, y)| Vec3::new(x, y, -0.1)).to_vec();
    let sole = lifelike_character::anatomy::Sole { body: 1, corners };
    (fixtures::cube(), Anatomy { places: Default::default(), soles: [(Role::LeftFoot, sole)].into() })
}

/// Two seconds in which the root moves, and the hinge turns, as the closures say.
fn measured(position: impl Fn(f64) -> Vec3, hinge: impl Fn(f64) -> f64) -> Plausibility {
    let times = || (0..=100).map(|i| f64::from(i) / FPS);
    let clip = MotionClip {
        name: "c".into(),
        fps: FPS,
        joint_names: vec!["hinge".into(), "slide".into()],
        root_position: times().map(&position).collect(),
        root_orientation: times().map(|_| Quat::identity()).collect(),
        joints: times().flat_map(|t| [hinge(t), 0.0]).collect(),
        contacts: None,
        cyclic: false,
        provenance: Provenance::default(),
    };
    let (mut character, anatomy) = cube();
    for joint in character.joints.iter_mut().filter(|joint| joint.name == "hinge") {
        joint.range = Some((-0.5, 0.5));
    }
    Plausibility::of(&clip, &character, &anatomy, &[2.0, f64::INFINITY]).unwrap()
}

#[track_caller]
fn near(got: f64, expected: f64) {
    assert!((got - expected).abs() < 1e-9, "{got} instead of {expected}");
}

#[test]
fn what_stands_still_has_no_fault() {
    let found = measured(|_| Vec3::new(0.0, 0.0, 0.1), |_| 0.0);
    let expected = Plausibility {
        seconds: 2.0,
        skate: 0.0,
        skating: 0.0,
        penetration: 0.0,
        deepest: 0.0,
        floating: 0.0,
        self_collision: 0.0,
        angle_violations: 0.0,
        angle_excess: 0.0,
        speed_violations: 0.0,
        unexplained: 0.0,
    };
    assert!(found.floating < 1e-12 && found.penetration < 1e-12);
    assert_eq!(Plausibility { floating: 0.0, penetration: 0.0, deepest: 0.0, ..found }, expected);
}

#[test]
fn a_cube_that_slides_skates() {
    let slow = measured(|t| Vec3::new(0.2 * t, 0.0, 0.1), |_| 0.0);
    near(slow.skate, 0.2);
    near(slow.skating, 0.0);
    let fast = measured(|t| Vec3::new(0.3 * t, 0.0, 0.1), |_| 0.0);
    near(fast.skate, 0.3);
    near(fast.skating, 1.0);
    near(measured(|t| Vec3::new(t, 0.0, 0.2), |_| 0.0).skate, 0.0);
}

#[test]
fn heights_are_those_of_the_lowest_point() {
    let deep = measured(|_| Vec3::new(0.0, 0.0, 0.08), |_| 0.0);
    near(deep.penetration, 0.02);
    near(deep.deepest, 0.02);
    let high = measured(|_| Vec3::new(0.0, 0.0, 0.25), |_| 0.0);
    near(high.floating, 0.15);
    assert!(high.unexplained > 0.5, "held up by nothing: {}", high.unexplained);
}

#[test]
fn limits_are_counted_by_joint_and_frame() {
    // From 1 s on the hinge is beyond its 0.5 rad by 0.1 rad: 51 of 101 frames of one of two joints. It gets there by
    // steps of 0.6 rad/s, but for the step at 1 s: one of 100 steps of two joints.
    let found = measured(|_| Vec3::new(0.0, 0.0, 0.1), |t| if t > 0.999 { 0.6 } else { 0.3 * t });
    near(found.angle_violations, 51.0 / 202.0);
    near(found.angle_excess, 0.1);
    near(found.speed_violations, 1.0 / 200.0);
}

#[test]
fn means_are_weighted_by_time() {
    let of = |seconds: f64, skate: f64| Plausibility {
        seconds,
        skate,
        deepest: skate,
        ..measured(|_| Vec3::new(0.0, 0.0, 0.1), |_| 0.0)
    };
    let mean = Plausibility::mean(&[of(1.0, 0.1), of(3.0, 0.5)]).unwrap();
    near(mean.skate, 0.4);
    near(mean.deepest, 0.5);
    near(mean.seconds, 4.0);
    assert!(Plausibility::mean(&[]).is_none());
    assert_eq!(mean.cells().len(), HEAD.len());
}
