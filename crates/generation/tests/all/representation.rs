//! A clip → rows → a clip, on our own keyframed clips.

use lifelike_character::rotation::heading_angle;
use lifelike_character::{Quat, Vec3};
use lifelike_generation::GenerationError;
use lifelike_generation::representation::{FeatureMatrix, RepresentationSpec, Standardizer};
use lifelike_motion::MotionClip;
use lifelike_motion::resample::resample;
use lifelike_robot::{Robot, clips};

fn lima() -> (Robot, Vec<MotionClip>) {
    let robot = Robot::load("lima").unwrap();
    let clips = clips::builtin(&robot).all().unwrap();
    (robot, clips)
}

/// Places, relative to the first frame's heading frame.
fn path(clip: &MotionClip) -> Vec<Vec3> {
    let turn = Quat::from_axis_angle(&Vec3::z_axis(), -heading_angle(&clip.root_orientation[0]));
    let start = Vec3::new(clip.root_position[0].x, clip.root_position[0].y, 0.0);
    clip.root_position.iter().map(|p| turn * (p - start)).collect()
}

fn turns(clip: &MotionClip) -> Vec<Quat> {
    let turn = Quat::from_axis_angle(&Vec3::z_axis(), -heading_angle(&clip.root_orientation[0]));
    clip.root_orientation.iter().map(|q| turn * q).collect()
}

/// Largest differences of root (m), orientation (rad) and joints (rad).
fn differences(a: &MotionClip, b: &MotionClip) -> [f64; 3] {
    let frames = a.len().min(b.len());
    assert!(a.len().abs_diff(b.len()) <= 2, "{} {}", a.len(), b.len());
    let largest = |values: &mut dyn Iterator<Item = f64>| values.fold(0.0, f64::max);
    [
        largest(&mut path(a).iter().zip(path(b)).map(|(a, b)| (a - b).norm())),
        largest(&mut turns(a).iter().zip(turns(b)).map(|(a, b)| a.angle_to(&b))),
        largest(&mut (0..frames).flat_map(|t| a.joints_at(t).iter().zip(b.joints_at(t)).map(|(a, b)| (a - b).abs()))),
    ]
}

#[test]
fn rows_at_their_own_rate_bring_the_clip_back() {
    let (robot, clips) = lima();
    let spec = RepresentationSpec::of(&robot.layout);
    assert_eq!(spec.width(), 7 + 2 * robot.joints());
    for clip in clips {
        let clip = resample(&clip, spec.fps).unwrap();
        let rows = FeatureMatrix::from_clip(&clip, &spec).unwrap();
        assert_eq!((rows.n, rows.rows.len()), (clip.len(), clip.len() * spec.width()));
        let back = rows.to_clip(&spec, "back", spec.fps).unwrap();
        // Single precision: half a unit in the last place of up to 10 m/s, summed over 20 rows a second.
        let [root, orientation, joints] = differences(&clip, &back);
        assert!(root < 1e-4 && orientation < 1e-4 && joints < 1e-6, "{}: {root} {orientation} {joints}", clip.name);
    }
}

#[test]
fn a_clip_of_fifty_hertz_comes_back_smoothly() {
    let (robot, clips) = lima();
    let spec = RepresentationSpec::of(&robot.layout);
    for clip in clips {
        let rows = FeatureMatrix::from_clip(&clip, &spec).unwrap();
        let back = rows.to_clip(&spec, "back", clip.fps).unwrap();
        let [root, orientation, joints] = differences(&clip, &back);
        // What moves faster than 10 Hz is lost; keyframed clips have corners in acceleration.
        assert!(root < 0.02 && orientation < 0.03 && joints < 0.12, "{}: {root} {orientation} {joints}", clip.name);
    }
}

#[test]
fn heading_and_place_do_not_matter_and_names_do() {
    let (robot, mut clips) = lima();
    let spec = RepresentationSpec::of(&robot.layout);
    let clip = clips.remove(0);
    let rows = FeatureMatrix::from_clip(&clip, &spec).unwrap();
    let mut moved = clip.clone();
    let turn = Quat::from_axis_angle(&Vec3::z_axis(), 2.1);
    moved.root_position.iter_mut().for_each(|p| *p = turn * *p + Vec3::new(5.0, -3.0, 0.0));
    moved.root_orientation.iter_mut().for_each(|q| *q = turn * *q);
    // Columns in another order are the same joints.
    moved.joint_names.reverse();
    moved.joints = (0..clip.len()).flat_map(|t| clip.joints_at(t).iter().rev().copied().collect::<Vec<_>>()).collect();
    let other = FeatureMatrix::from_clip(&moved, &spec).unwrap();
    assert!(rows.rows.iter().zip(&other.rows).all(|(a, b)| (a - b).abs() < 1e-4));

    moved.joint_names[0] = "tail".into();
    let error = FeatureMatrix::from_clip(&moved, &spec).unwrap_err().to_string();
    assert!(error.contains("tail") && error.contains("missing"), "{error}");
}

#[test]
fn numbers_are_those_of_hand_arithmetic() {
    // A metre a second sideways while looking along y, and a turn of 0.5 rad/s; one joint at 2 rad/s.
    let frames = 51;
    let time = |i: usize| i as f64 / 50.0;
    let clip = MotionClip {
        name: "hand".into(),
        fps: 50.0,
        joint_names: vec!["a".into()],
        root_position: (0..frames).map(|i| Vec3::new(time(i), 0.0, 0.7)).collect(),
        root_orientation: (0..frames)
            .map(|i| Quat::from_euler_angles(0.0, 0.0, std::f64::consts::FRAC_PI_2 + 0.5 * time(i)))
            .collect(),
        joints: (0..frames).map(|i| 2.0 * time(i)).collect(),
        contacts: None,
        cyclic: false,
        provenance: lifelike_motion::Provenance::default(),
    };
    let rows = FeatureMatrix::from_clip(&clip, &RepresentationSpec::new(vec!["a".into()])).unwrap();
    assert_eq!((rows.n, rows.width), (21, 9));
    let expected = [0.7, 0.0, -1.0, 0.5, 0.0, 0.0, 1.0, 0.0, 2.0];
    for (got, expected) in rows.row(0).iter().zip(expected) {
        assert!((got - expected).abs() < 1e-5, "{:?}", rows.row(0));
    }
    assert!((rows.row(10)[7] - 1.0).abs() < 1e-6);
}

#[test]
fn what_cannot_be_a_motion_is_refused() {
    let spec = RepresentationSpec::new(vec!["a".into()]);
    let refused = |rows: Vec<f32>, fps: f64| {
        let rows = FeatureMatrix { n: rows.len() / 9, width: 9, rows };
        matches!(rows.to_clip(&spec, "x", fps), Err(GenerationError::Input(_)))
    };
    assert!(refused(vec![], 50.0), "no row");
    assert!(refused(vec![f32::NAN; 9], 50.0));
    assert!(refused(vec![0.0; 9], f64::NAN) && refused(vec![0.0; 9], 0.0));
    assert!(!refused(vec![0.0; 9], 50.0), "one row is a clip of one frame");
    assert!(FeatureMatrix::new(vec![0.0; 10], 9).is_err());
    assert!(RepresentationSpec::new(vec!["a".into(), "a".into()]).check().is_err());
}

#[test]
fn standardized_rows_have_mean_0_and_std_1_and_come_back() {
    let (robot, clips) = lima();
    let spec = RepresentationSpec::of(&robot.layout);
    let motions: Vec<_> = clips.iter().map(|clip| FeatureMatrix::from_clip(clip, &spec).unwrap()).collect();
    let standardizer = Standardizer::of(&motions, Standardizer::FLOOR).unwrap();
    let mut rows: Vec<f32> = motions.iter().flat_map(|m| m.rows.clone()).collect();
    let before = rows.clone();
    standardizer.standardize(&mut rows);
    let n = (rows.len() / spec.width()) as f64;
    for c in 0..spec.width() {
        let column = || rows.iter().skip(c).step_by(spec.width()).map(|x| f64::from(*x));
        let (mean, square) = (column().sum::<f64>() / n, column().map(|x| x * x).sum::<f64>() / n);
        assert!(mean.abs() < 1e-3 && square < 1.001, "{c}: {mean} {square}");
        assert!(square > 0.999 || f64::from(standardizer.std[c]) <= Standardizer::FLOOR + 1e-9, "{c}: {square}");
    }
    standardizer.restore(&mut rows);
    assert!(rows.iter().zip(&before).all(|(a, b)| (a - b).abs() < 1e-5));
    assert!(Standardizer::of(&[], 0.1).is_err());
}
