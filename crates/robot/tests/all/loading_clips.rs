//! Clips of a robot by file and folder: what is of use is loaded, what is not is named with the reason.
use std::path::{Path, PathBuf};

use lifelike_motion::{MotionClip, container};
use lifelike_robot::clips::{self, SPEED_SHARE};
use lifelike_robot::{Robot, RobotError};

const BROKEN: &str = "HIERARCHY\nROOT Hips\n{\n  OFFSET 0 0 zero\n";

/// A folder with two of our clips, one of them twice, a broken file, a clip of another robot, one that is too short and one whose
/// rate is a frame time.
fn folder(robot: &Robot) -> (tempfile::TempDir, Vec<MotionClip>) {
    let own = clips::builtin(robot).clips;
    let root = tempfile::tempdir().unwrap();
    let write = |file: &str, clip: &MotionClip| container::write(&root.path().join(file), clip).unwrap();
    write("a/z.motion.safetensors", &own[0]);
    write("b/first.motion.safetensors", &own[0]);
    write("b/second.motion.safetensors", &own[1]);
    std::fs::write(root.path().join("b/broken.bvh"), BROKEN).unwrap();
    let mut foreign = own[2].clone();
    foreign.joint_names[3] = "tail".into();
    write("foreign.motion.safetensors", &foreign);
    let n = own[3].joint_names.len();
    let mut short = own[3].clone();
    short.joints.truncate(2 * n);
    short.root_position.truncate(2);
    short.root_orientation.truncate(2);
    short.contacts = None;
    write("short.motion.safetensors", &short);
    write("slow.motion.safetensors", &MotionClip { fps: 0.02, ..own[3].clone() });
    (root, own)
}

#[test]
fn what_is_no_use_is_left_out_with_the_reason() {
    let robot = Robot::load("lima").unwrap();
    let (root, own) = folder(&robot);
    let loaded = clips::load(&[root.path().to_path_buf()], &robot).unwrap();
    assert_eq!(loaded.clips, own[..2], "sorted by name, the others untouched");
    assert_eq!(loaded.files[0], root.path().join("a/z.motion.safetensors"), "the first of two is kept");
    let expected = [
        ("b/broken.bvh", "broken.bvh:4"),
        ("b/first.motion.safetensors", "a/z.motion.safetensors"),
        ("foreign.motion.safetensors", "tail"),
        ("short.motion.safetensors", "3 frames"),
        ("slow.motion.safetensors", "makes it 50.000 frames per second"),
    ];
    assert_eq!(loaded.left_out.len(), expected.len(), "{:?}", loaded.left_out);
    for (left, (file, reason)) in loaded.left_out.iter().zip(expected) {
        assert_eq!(left.file, root.path().join(file));
        assert!(left.reason.contains(file) && left.reason.contains(reason), "{}", left.reason);
    }
    let strict = loaded.all().unwrap_err().to_string();
    assert!(expected.iter().all(|(file, _)| strict.contains(file)), "{strict}");

    let by_file = clips::load_files(&[root.path().to_path_buf()], None, &robot).unwrap();
    assert_eq!((by_file.clips.len(), by_file.left_out.len()), (3, 4), "with files, names may repeat");
}

#[test]
fn nothing_of_use_is_an_error_with_the_reasons() {
    let robot = Robot::load("lima").unwrap();
    let (root, _) = folder(&robot);
    let load = |file: &str| clips::load(&[root.path().join(file)], &robot).unwrap_err();
    let error = load("b/broken.bvh");
    assert!(matches!(error, RobotError::Clips { .. }) && error.to_string().contains("broken.bvh:4"), "{error}");
    let both = ["foreign.motion.safetensors", "short.motion.safetensors"].map(|file| root.path().join(file));
    let error = clips::load(&both, &robot).unwrap_err().to_string();
    assert!(error.contains("tail") && error.contains("3 frames"), "{error}");
    assert!(load("none").to_string().contains("no such file"));
    let empty = tempfile::tempdir().unwrap();
    let error = clips::load(&[empty.path().to_path_buf()], &robot).unwrap_err().to_string();
    assert!(error.contains(".bvh") && error.contains(".motion.safetensors"), "lists what is read: {error}");
}

#[test]
fn one_clip_is_one_clip() {
    let robot = Robot::load("lima").unwrap();
    let (root, own) = folder(&robot);
    let second: &Path = &root.path().join("b/second.motion.safetensors");
    assert_eq!(clips::load_one(second, &robot).unwrap(), own[1]);
    assert!(clips::load_one(&root.path().join("b"), &robot).is_err(), "nothing is left out behind one's back");
    let pattern: PathBuf = root.path().join("b/*.motion.safetensors");
    assert!(clips::load_one(&pattern, &robot).unwrap_err().to_string().contains("got 2"));
}

#[test]
fn our_own_clips_are_loaded_by_name() {
    let robot = Robot::load("lima").unwrap();
    let load = |words: &[&str]| clips::load(&words.iter().map(PathBuf::from).collect::<Vec<_>>(), &robot);
    assert_eq!(load(&["builtin"]).unwrap().clips, clips::builtin(&robot).clips);
    let all = load(&["builtin:all"]).unwrap().clips;
    assert!(all.len() > 60 && clips::builtin(&robot).clips.iter().all(|clip| all.contains(clip)), "{}", all.len());
    let two = load(&["builtin:wave", "builtin:nod"]).unwrap();
    assert_eq!(two.files, ["builtin:nod", "builtin:wave"].map(PathBuf::from));
    let unknown = load(&["builtin:dance"]).unwrap_err().to_string();
    assert!(unknown.contains("got builtin:dance") && unknown.contains("builtin:walk"), "{unknown}");
}

#[test]
fn our_own_clips_suit_our_own_robots() {
    for name in lifelike_robot::load::NAMES {
        let robot = Robot::load(name).unwrap();
        let own = clips::load(&["builtin:all".into()], &robot).unwrap();
        assert!(own.left_out.is_empty(), "{name}: {:?}", own.left_out);
        assert!(own.clips.len() > 60, "{name}: {}", own.clips.len());
        let slow = own.clips.iter().all(|c| {
            let n = c.joint_names.len();
            let limits = robot.actuators.parameters.iter().map(|p| SPEED_SHARE * p.velocity_max);
            limits.enumerate().all(|(j, limit)| {
                let column = c.joints.iter().skip(j).step_by(n).collect::<Vec<_>>();
                column.windows(2).all(|w| (w[1] - w[0]).abs() * c.fps <= limit * (1.0 + 1e-9))
            })
        });
        assert!(slow, "{name}: no joint is faster than its actuator lets the policy correct");
    }
}
