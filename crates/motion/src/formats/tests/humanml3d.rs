//! HumanML3D: features made from known positions by the data set's rules give the positions back.

use super::super::amass::body::JOINTS;
use super::super::humanml3d::{FORMAT, parse};
use super::super::raw::from_y_up_z_forward;
use super::*;

const FRAMES: usize = 12;

/// Half of the heading at a frame (rad): any course will do that begins with 0.
fn half_heading(frame: usize) -> f64 {
    0.02 * (frame * frame) as f64
}

fn heading(frame: usize) -> Quat {
    Quat::from_axis_angle(&Vec3::y_axis(), -2.0 * half_heading(frame))
}

/// Returns positions of SMPL's mean body that bends everywhere (m, y up).
fn places(frame: usize) -> Vec<Vec3> {
    let t = frame as f64 / 20.0;
    let mut turns: Vec<Quat> = Vec::new();
    let mut places: Vec<Vec3> = Vec::new();
    for (joint, (_, parent, offset)) in JOINTS.iter().enumerate() {
        let bend = Vec3::new((3.0 * t + joint as f64).sin(), (2.0 * t).cos(), (t + 2.0 * joint as f64).sin()) * 0.3;
        let (place, turn) = match parent {
            None => (Vec3::new(0.7 * t, 0.95, 0.4 * t * t), Quat::identity()),
            Some(parent) => (places[*parent] + turns[*parent] * Vec3::from(*offset), turns[*parent]),
        };
        places.push(place);
        turns.push(turn * Quat::from_scaled_axis(bend));
    }
    places
}

/// Returns the data set's features: turn and velocity to the next frame, height, and joints beside the root in its heading.
fn features(frame: usize) -> Vec<f64> {
    let root = |frame: usize| Vec3::new(places(frame)[0].x, 0.0, places(frame)[0].z);
    let velocity = heading(frame + 1).inverse() * (root(frame + 1) - root(frame));
    let mut features = vec![half_heading(frame + 1) - half_heading(frame), velocity.x, velocity.z, places(frame)[0].y];
    for place in &places(frame)[1..] {
        features.extend((heading(frame).inverse() * (place - root(frame))).iter());
    }
    features.resize(263, 0.0);
    features
}

fn npy(shape: &str, values: impl Iterator<Item = f64>) -> Vec<u8> {
    let header = format!("{{'descr': '<f4', 'fortran_order': False, 'shape': {shape}, }}\n");
    let length = (header.len() as u16).to_le_bytes();
    let values: Vec<u8> = values.flat_map(|value| (value as f32).to_le_bytes()).collect();
    [b"\x93NUMPY\x01\x00", &length[..], header.as_bytes(), &values].concat()
}

fn read_back(bytes: &[u8]) -> SourceClip {
    let options = ReadOptions { t_pose: false, ..ReadOptions::default() };
    parse(bytes, Path::new("000021.npy"), &options).unwrap()
}

#[test]
fn positions_come_back() {
    let vectors = npy(&format!("({FRAMES}, 263)"), (0..FRAMES).flat_map(features));
    let joints = (0..FRAMES).flat_map(|frame| places(frame).iter().flat_map(|p| [p.x, p.y, p.z]).collect::<Vec<_>>());
    let joints = npy(&format!("({FRAMES}, 22, 3)"), joints);
    for bytes in [vectors, joints] {
        let clip = read_back(&bytes);
        assert_eq!((clip.len(), clip.fps, clip.skeleton.names.len()), (FRAMES, 20.0, 22));
        for frame in 0..FRAMES {
            for (got, expected) in clip.pose(frame).0.iter().zip(places(frame)) {
                let error = (got - from_y_up_z_forward() * expected).norm();
                assert!(error < 1e-5, "frame {frame}: {error}");
            }
        }
        let (folder, path) = (tempfile::tempdir().unwrap(), "000021.npy");
        std::fs::write(folder.path().join(path), &bytes).unwrap();
        assert_eq!(of_found(&folder.path().join(path)).unwrap().name, FORMAT.name);
    }
}

#[test]
fn other_arrays_are_refused() {
    let error = |shape: &str, count: usize| {
        let bytes = npy(shape, std::iter::repeat_n(0.5, count));
        parse(&bytes, Path::new("a.npy"), &ReadOptions::default()).unwrap_err().to_string()
    };
    assert!(error("(2, 251)", 502).contains("[frames, 263] or [frames, 22, 3]"), "{}", error("(2, 251)", 502));
    assert!(error("(2, 263)", 500).contains("the end after 500 of 526 numbers"));
    assert!(error("(99999999999, 263)", 1).contains("expected"));
}
