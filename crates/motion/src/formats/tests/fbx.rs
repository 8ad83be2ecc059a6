//! `small.bvh` as Blender writes it as FBX (`peers/motion/fbx.py`): the same motion in every axis and unit.

use super::*;

const Y_CM: &[u8] = include_bytes!("fbx/y_cm.fbx.zst");
const Y_M_FREE: &[u8] = include_bytes!("fbx/y_m_free.fbx.zst");
const Z_M_TAKES: &[u8] = include_bytes!("fbx/z_m_takes.fbx.zst");
const Y_CM_MIRRORED: &[u8] = include_bytes!("fbx/y_cm_mirrored.fbx.zst");
const STILL: &[u8] = include_bytes!("fbx/still.fbx.zst");

fn unpacked(bytes: &[u8]) -> Vec<u8> {
    zstd::decode_all(bytes).unwrap()
}

fn parse(bytes: &[u8], options: &ReadOptions) -> Result<SourceClip, MotionError> {
    super::super::fbx::parse(bytes, Path::new("small.fbx"), options)
}

/// Returns the largest distance (m) and angle (rad) of the joints of two clips over all frames.
fn apart(clip: &SourceClip, other: &SourceClip) -> (f64, f64) {
    let (mut way, mut angle) = (0.0_f64, 0.0_f64);
    for t in 0..other.len() {
        let ((places, turns), (want, want_turns)) = (clip.pose(t), other.pose(t));
        for (at, name) in other.skeleton.names.iter().enumerate() {
            let joint = joint(clip, name);
            way = way.max((places[joint] - want[at]).norm());
            angle = angle.max(turns[joint].angle_to(&want_turns[at]));
        }
    }
    (way, angle)
}

#[test]
fn a_file_with_a_bind_pose_is_the_bvh_in_every_axis_and_unit() {
    let options = ReadOptions::default();
    let plain = bvh(BVH.as_bytes()).unwrap();
    // Ends of limbs may have a scale of -1 in all directions.
    for packed in [Y_CM, Z_M_TAKES, Y_CM_MIRRORED] {
        let clip = parse(&unpacked(packed), &options).unwrap();
        assert_eq!((clip.len(), clip.fps, &clip.skeleton.names), (plain.len(), 120.0, &plain.skeleton.names));
        assert_eq!(clip.skeleton.ends.len(), plain.skeleton.ends.len());
        let (way, angle) = apart(&clip, &plain);
        assert!(way < 1e-4 && angle < 0.01_f64.to_radians(), "{way} m, {angle} rad");
    }
}

#[test]
fn without_a_bind_pose_the_places_are_the_same_and_it_is_said() {
    let options = ReadOptions { up: "y".parse().ok(), forward: "z".parse().ok(), ..ReadOptions::default() };
    let clip = parse(&unpacked(Y_M_FREE), &options).unwrap();
    let plain = bvh(BVH.as_bytes()).unwrap();
    assert!(apart(&clip, &plain).0 < 1e-4, "{}", apart(&clip, &plain).0);
    assert!(clip.notes.iter().any(|note| note.contains("no bind pose")), "{:?}", clip.notes);
}

#[test]
fn one_take_is_read_and_the_others_are_named() {
    let clip = parse(&unpacked(Z_M_TAKES), &ReadOptions::default()).unwrap();
    assert!(clip.notes.iter().any(|note| note.contains("more were not: ")), "{:?}", clip.notes);
    assert!(parse(&unpacked(Y_CM), &ReadOptions::default()).unwrap().notes.is_empty());
}

#[test]
fn a_rate_may_be_stated() {
    let options = ReadOptions { fps: Some(480.0), ..ReadOptions::default() };
    let clip = parse(&unpacked(Y_CM), &options).unwrap();
    assert_eq!((clip.len(), clip.fps), (5, 480.0));
}

#[test]
fn what_is_missing_is_named() {
    let refusal = |bytes: &[u8], options: &ReadOptions| parse(bytes, options).unwrap_err().to_string();
    let options = ReadOptions::default();
    let still = refusal(&unpacked(STILL), &options);
    assert!(still.contains("expected a take that moves bones"), "{still}");
    let empty = b"; FBX 7.4.0 project file\nFBXHeaderExtension:  {\n\tFBXVersion: 7400\n}\nObjects:  {\n}\nConnections:  {\n}\n";
    let empty = refusal(empty, &options);
    assert!(empty.contains("expected bones of a skeleton"), "{empty}");
    let text = "; FBX 7.4.0 {\nObjects:  {\n\tModel: 1, \"a{;\" {\n\t}\n}\nConnections:  {\n}\n";
    for (end, part) in [
        ("\n\t}", "ends in line 3, within 'Model' of line 3 (cut off?)"),
        ("\n}", "ends in line 4, within 'Objects' of line 2 (cut off?)"),
        ("Connections", "6 lines without 'Connections' (cut off?)"),
    ] {
        let cut = refusal(&text.as_bytes()[..text.find(end).unwrap()], &options);
        assert!(cut.contains("small.fbx: expected a whole FBX file") && cut.contains(part), "{cut}");
    }
    assert!(!refusal(text.as_bytes(), &options).contains("cut off"));
    let fast = ReadOptions { fps: Some(1e9), ..ReadOptions::default() };
    assert!(refusal(&unpacked(Y_CM), &fast).contains("--fps"));
    let scaled = ReadOptions { scale: Some(0.01), ..ReadOptions::default() };
    assert!(refusal(&unpacked(Y_CM), &scaled).contains("--scale"));
}

#[test]
fn spoilt_files_end_in_an_error_or_a_clip() {
    let whole = unpacked(Y_CM);
    let mut refused = 0;
    for at in 0..400 {
        let mut spoilt = whole.clone();
        let place = at * 7919 % whole.len();
        spoilt[place] ^= 1 << (at % 8);
        let cut = &whole[..place];
        for bytes in [&spoilt[..], cut] {
            match parse(bytes, &ReadOptions::default()) {
                Ok(clip) => assert!(clip.check().is_ok() || clip.len() < 30),
                Err(MotionError::Input(_) | MotionError::Unfit { .. }) => refused += 1,
                Err(other) => panic!("{other}"),
            }
        }
    }
    assert!(refused >= 400, "{refused}");
}
