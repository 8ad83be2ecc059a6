//! Bodies whose needs can be calculated by hand.

#![allow(clippy::unwrap_used)]

use lifelike_character::{Anatomy, Character, Kinematics, Quat, Vec3};

use super::*;
use crate::clip::Provenance;
use crate::fixtures;

const FPS: f64 = 50.0;

fn cube() -> (Character, Anatomy) {
    (fixtures::cube(), Anatomy { places: Default::default(), soles: Default::default() })
}

/// Returns a second in which the root moves and turns as the closures say.
fn clip(position: impl Fn(f64) -> Vec3, pitch: impl Fn(f64) -> f64, hinge: impl Fn(f64) -> f64) -> MotionClip {
    let times = || (0..=50).map(|i| f64::from(i) / FPS);
    MotionClip {
        name: "c".into(),
        fps: FPS,
        joint_names: vec!["hinge".into(), "slide".into()],
        root_position: times().map(&position).collect(),
        root_orientation: times().map(|t| Quat::from_euler_angles(0.0, pitch(t), 0.0)).collect(),
        joints: times().flat_map(|t| [hinge(t), 0.0]).collect(),
        contacts: None,
        cyclic: false,
        provenance: Provenance::default(),
    }
}

fn found(clip: &MotionClip) -> Feasibility {
    let (character, anatomy) = cube();
    check(clip, &character, &anatomy, &[10.0, 10.0]).unwrap()
}

/// Returns the findings besides that a cube has no soles.
fn kinds(clip: &MotionClip) -> Vec<Kind> {
    found(clip).findings.iter().map(|f| f.kind).filter(|k| *k != Kind::OtherParts).collect()
}

#[test]
fn a_box_on_a_table_needs_what_it_has() {
    let still = clip(|_| Vec3::new(3.0, 1.0, 0.1), |_| 0.0, |_| 0.0);
    assert_eq!(kinds(&still), []);
    let lying = found(&still);
    assert_eq!((lying.findings[0].kind, lying.findings[0].part.as_str()), (Kind::OtherParts, "root"));
    assert!(!lying.trackable, "what lies on something else than soles is left to others");
}

#[test]
fn a_box_that_hovers_is_held_up_by_nothing_and_one_that_falls_needs_nothing() {
    let f = found(&clip(|_| Vec3::z(), |_| 0.0, |_| 0.0));
    assert_eq!(f.findings.len(), 1);
    let finding = &f.findings[0];
    assert_eq!((finding.kind, f.trackable), (Kind::Unsupported, false));
    assert!((finding.worst - 9.81).abs() < 1e-9, "{}", finding.worst);
    // 51 frames, of which five at either end are not judged.
    assert!((finding.from - 0.1).abs() < 1e-9 && (finding.seconds - 41.0 / FPS).abs() < 1e-9, "{finding:?}");
    assert!(f.around(0.5, 0.1).count() == 1 && f.around(2.0, 0.5).count() == 0);

    let falling = clip(|t| Vec3::new(t, 0.0, 6.0 - 0.5 * 9.81 * t * t), |t| 3.0 * t, |_| 0.0);
    assert!(found(&falling).trackable, "turning as it goes: {:?}", found(&falling).findings);
}

#[test]
fn pushing_off_sideways_moves_the_needed_support_and_asks_for_friction() {
    // Speeding up by a = 4 m/s² at a height of 0.1 m: the force acts a h / g = 0.041 m behind the centre, within the foot of
    // 0.1 m, and the friction needed is a / g.
    let speeding = |a: f64| clip(move |t| Vec3::new(0.5 * a * t * t, 0.0, 0.1), |_| 0.0, |_| 0.0);
    let (character, _) = cube();
    let at = |clip: &MotionClip| {
        let columns = clip.columns_for(&character).unwrap();
        let mut q = character.reference_position();
        let poses: Vec<Kinematics> = (0..clip.len())
            .map(|frame| {
                clip.write_position(&character, &columns, frame, &mut q);
                let mut pose = Kinematics::new(&character);
                pose.update(&character, &q);
                pose
            })
            .collect();
        momentum(&character, &poses, FPS)[25].clone().unwrap()
    };
    let m = at(&speeding(4.0));
    let point = m.zero_moment_point.unwrap();
    assert!((point.x - (m.centre.x - 4.0 * 0.1 / 9.81)).abs() < 1e-9 && point.y.abs() < 1e-12, "{point}");
    assert!((m.friction().unwrap() - 4.0 / 9.81).abs() < 1e-9);
    assert_eq!(kinds(&speeding(4.0)), []);
    // 20 m/s²: 0.204 m behind, 0.104 m outside; friction 2.04.
    let far = found(&speeding(20.0));
    let of = |kind: Kind| far.findings.iter().find(|f| f.kind == kind).unwrap().worst;
    assert!((of(Kind::Unbalanced) - (20.0 * 0.1 / 9.81 - 0.1)).abs() < 1e-9);
    assert!((of(Kind::Slipping) - 20.0 / 9.81).abs() < 1e-9);
}

#[test]
fn spinning_up_needs_support_elsewhere() {
    // A cube that stands still and turns ever faster forwards about y: L̇ = I α moves the point by −I α / (m g). The corners
    // leave the ground, so the point itself is looked at.
    let (character, _) = cube();
    let alpha = 40.0;
    let clip = clip(|_| Vec3::new(0.0, 0.0, 0.1), |t| 0.5 * alpha * (t - 0.5) * (t - 0.5), |_| 0.0);
    let columns = clip.columns_for(&character).unwrap();
    let mut q = character.reference_position();
    let mut poses = Vec::new();
    for frame in 0..clip.len() {
        clip.write_position(&character, &columns, frame, &mut q);
        let mut pose = Kinematics::new(&character);
        pose.update(&character, &q);
        poses.push(pose);
    }
    let point = momentum(&character, &poses, FPS)[25].clone().unwrap().zero_moment_point.unwrap();
    assert!((point.x + 0.01 * alpha / 9.81).abs() < 1e-6, "{point}");
}

#[test]
fn what_is_deep_fast_or_short_is_told_and_judged_by_its_length() {
    let deep = clip(|_| Vec3::new(0.0, 0.0, 0.05), |_| 0.0, |_| 0.0);
    let finding = found(&deep).findings.into_iter().find(|f| f.kind == Kind::Underground).unwrap();
    assert!((finding.worst - 0.05).abs() < 1e-12 && finding.rules_out());
    // One step of half a radian: 25 rad/s in one frame, of 10 allowed.
    let fast = clip(|_| Vec3::new(0.0, 0.0, 0.1), |_| 0.0, |t| if t > 0.5 { 0.5 } else { 0.0 });
    let finding = found(&fast).findings.into_iter().find(|f| f.kind == Kind::TooFast).unwrap();
    assert_eq!((finding.part.as_str(), finding.rules_out()), ("hinge", false));
    assert!((finding.worst - 2.5).abs() < 1e-9 && (finding.seconds - 0.02).abs() < 1e-12);
    assert_eq!(finding.words(), "faster than the actuator (hinge) for 0.02 s from 0.52 s: 2.5 times its largest speed");
}

#[test]
fn distances_from_an_outline() {
    let square = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(|(x, y)| Vec3::new(x, y, 0.0));
    let from = |points: &[Vec3], x: f64, y: f64| touch::outside(points, &Vec3::new(x, y, 0.0));
    assert_eq!(from(&square, 0.5, 0.9), Some(0.0));
    assert_eq!(from(&square, 4.0, 5.0), Some(5.0));
    assert_eq!(from(&square, 0.5, -0.25), Some(0.25));
    assert_eq!(from(&square[..2], 0.5, 2.0), Some(2.0), "an edge");
    assert_eq!(from(&square[..1], 3.0, 4.0), Some(5.0), "a point");
    assert_eq!(from(&[], 0.0, 0.0), None);
}

#[test]
fn other_characters_and_other_numbers_of_speeds_are_refused() {
    let (character, anatomy) = cube();
    let still = clip(|_| Vec3::z(), |_| 0.0, |_| 0.0);
    assert!(matches!(check(&still, &character, &anatomy, &[1.0]), Err(MotionError::Unfit { .. })));
    let mut other = still;
    other.joint_names[0] = "knee".into();
    assert!(matches!(check(&other, &character, &anatomy, &[1.0; 2]), Err(MotionError::Mismatch { .. })));
}

#[test]
fn a_wrapped_angle_and_one_out_of_range_rule_a_clip_out() {
    let (mut character, anatomy) = cube();
    let turn = 2.0 * std::f64::consts::PI;
    let on_ground = |_: f64| Vec3::new(0.0, 0.0, 0.1);
    let wrapped = clip(on_ground, |_| 0.0, |t| if t > 0.5 { turn } else { 0.0 });
    let finding = found(&wrapped).findings.into_iter().find(|f| f.kind == Kind::Jump).unwrap();
    assert_eq!((finding.part.as_str(), finding.rules_out()), ("hinge", true));
    assert!((finding.worst - turn).abs() < 1e-12, "{}", finding.worst);

    let hinge = character.joints.iter().position(|joint| joint.name == "hinge").unwrap();
    character.joints[hinge].range = Some((-1.0, 1.0));
    let beyond = |angle: f64| {
        let found = check(&clip(on_ground, |_| 0.0, |_| angle), &character, &anatomy, &[10.0; 2]).unwrap();
        found.findings.into_iter().find(|f| f.kind == Kind::BeyondRange)
    };
    assert_eq!(beyond(1.05), None);
    let finding = beyond(-3.5).unwrap();
    assert!((finding.worst - 2.5).abs() < 1e-12 && finding.rules_out());
    assert_eq!(finding.words(), "beyond the range (hinge) for 1.02 s from 0.00 s: by 2.50 rad");
}

#[test]
fn an_angle_that_leaves_its_path_for_one_frame_is_a_spike() {
    let swing = |t: f64| 0.5 * (3.0 * t).sin();
    let spikes = |change: &dyn Fn(f64) -> f64| {
        let all = found(&clip(|_| Vec3::new(0.0, 0.0, 0.1), |_| 0.0, |t| swing(t) + change(t))).findings;
        all.into_iter().filter(|f| f.kind == Kind::Spike).collect::<Vec<_>>()
    };
    assert_eq!(spikes(&|_| 0.0), []);
    // A step, and motion that shakes, are no spikes; the swing itself bends by less than 1e-3 rad a frame.
    assert_eq!(spikes(&|t| if t > 0.5 { 0.3 } else { 0.0 }), []);
    assert_eq!(spikes(&|t| 0.2 * (60.0 * t).sin()), []);
    let [spike] = spikes(&|t| if (0.49..0.51).contains(&t) { 0.3 } else { 0.0 }).try_into().unwrap();
    assert!((spike.worst - 0.3).abs() < 1e-3 && spike.rules_out(), "{spike:?}");
    assert_eq!(
        (spike.part.as_str(), spike.words().starts_with("leaves its path for one frame (hinge)")),
        ("hinge", true)
    );
}
