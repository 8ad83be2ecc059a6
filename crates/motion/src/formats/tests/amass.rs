//! AMASS: against SciPy's kinematics, in every layout that NumPy writes, and everything that can be wrong with a file.

use std::io::{Cursor, Write};

use lifelike_checkpoint::InputError;
use proptest::prelude::*;
use zip::CompressionMethod;
use zip::write::{SimpleFileOptions, ZipWriter};

use super::super::amass::{parse, recording};
use super::*;

/// An array as NumPy would write it.
struct Array {
    name: &'static str,
    descr: &'static str,
    fortran: bool,
    shape: Vec<usize>,
    values: Vec<f64>,
}

fn array(name: &'static str, shape: &[usize], values: Vec<f64>) -> Array {
    Array { name, descr: "<f8", fortran: false, shape: shape.to_vec(), values }
}

impl Array {
    fn bytes(&self) -> Vec<u8> {
        let shape: String = self.shape.iter().map(|n| format!("{n}, ")).collect();
        let order = if self.fortran { "True" } else { "False" };
        let mut header = format!("{{'descr': '{}', 'fortran_order': {order}, 'shape': ({shape}), }}", self.descr);
        header.push_str(&" ".repeat(63 - (header.len() + 10) % 64));
        header.push('\n');
        let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
        bytes.extend((header.len() as u16).to_le_bytes());
        bytes.extend(header.bytes());
        let width = self.shape.get(1).copied().unwrap_or(1);
        let rows = self.values.len() / width.max(1);
        for at in 0..self.values.len() {
            let place = if self.fortran { at % rows * width + at / rows } else { at };
            let value = self.values[place];
            match self.descr {
                "<f8" => bytes.extend(value.to_le_bytes()),
                ">f8" => bytes.extend(value.to_be_bytes()),
                "<f4" => bytes.extend((value as f32).to_le_bytes()),
                "<i8" => bytes.extend((value as i64).to_le_bytes()),
                _ => bytes.extend((value as i32).to_le_bytes()),
            }
        }
        bytes
    }
}

fn npz(arrays: &[Array], method: CompressionMethod) -> Vec<u8> {
    zipped(arrays.iter().map(|array| (array.name, array.bytes())), method)
}

fn zipped(files: impl Iterator<Item = (&'static str, Vec<u8>)>, method: CompressionMethod) -> Vec<u8> {
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    for (name, bytes) in files {
        zip.start_file(format!("{name}.npy"), SimpleFileOptions::default().compression_method(method)).unwrap();
        zip.write_all(&bytes).unwrap();
    }
    zip.finish().unwrap().into_inner()
}

/// A figure that stands on the spot, upright, and faces the world's y axis; the last frame's left knee is bent by 1 rad.
fn standing(frames: usize, width: usize) -> Vec<Array> {
    let half = std::f64::consts::FRAC_PI_2;
    let mut poses = vec![0.0; frames * width];
    for row in poses.chunks_mut(width) {
        // From y up, z forward to z up, forward -y, by a quarter turn about x; then half a turn about z: one turn about
        // the axis between y and z.
        row[1] = half * 2.0 / 2.0_f64.sqrt();
        row[2] = half * 2.0 / 2.0_f64.sqrt();
        row[3 * 22..].fill(0.7);
    }
    if let Some(row) = poses.chunks_mut(width).last() {
        row[3 * 4] = 1.0;
    }
    let places = [1.0, 2.0, 0.92].repeat(frames);
    vec![
        array("trans", &[frames, 3], places),
        array("mocap_framerate", &[], vec![120.0]),
        array("betas", &[16], vec![0.3; 16]),
        array("poses", &[frames, width], poses),
    ]
}

fn read_bytes(bytes: &[u8]) -> Result<SourceClip, MotionError> {
    parse(bytes, Path::new("a_poses.npz"), &ReadOptions::default())
}

fn read_arrays(arrays: &[Array]) -> Result<SourceClip, MotionError> {
    read_bytes(&npz(arrays, CompressionMethod::Stored))
}

/// Returns the standing figure with one array replaced.
fn with(array: Array) -> Vec<Array> {
    let mut arrays: Vec<Array> = standing(3, 156).into_iter().filter(|a| a.name != array.name).collect();
    arrays.push(array);
    arrays
}

/// Made by `make_amass.py`: NumPy wrote the file, SciPy computed where its joints are. With the file's rest pose a
/// joint's rotation is what it made since SMPL's rest pose, stood up. Positions are the same whatever the rest pose.
#[test]
fn joints_are_where_scipy_says() {
    #[derive(serde::Deserialize)]
    struct Oracle {
        positions: Vec<Vec<[f64; 3]>>,
        rotations_wxyz: Vec<Vec<[f64; 4]>>,
    }
    let oracle: Oracle = serde_json::from_str(include_str!("amass.json")).unwrap();
    let bytes = include_bytes!("amass.npz");
    let stood = raw::from_y_up_z_forward();
    for t_pose in [false, true] {
        let options = ReadOptions { t_pose, ..ReadOptions::default() };
        let clip = parse(bytes, Path::new("amass.npz"), &options).unwrap();
        assert_eq!((clip.len(), clip.fps, clip.skeleton.names.len()), (3, 120.0, 22));
        for frame in 0..3 {
            let (positions, rotations) = clip.pose(frame);
            for joint in 0..22 {
                let off = (positions[joint] - Vec3::from(oracle.positions[frame][joint])).norm();
                // The oracle has twelve digits after the point.
                assert!(off < 1e-10, "frame {frame} {}: {off} m", clip.skeleton.names[joint]);
                let turn = lifelike_character::rotation::from_wxyz(oracle.rotations_wxyz[frame][joint]).unwrap();
                let off = rotations[joint].angle_to(&(turn * stood.inverse()));
                assert!(t_pose || off < 1e-7, "frame {frame} {}: {off} rad", clip.skeleton.names[joint]);
            }
        }
    }
}

#[test]
fn a_standing_figure_stands_up_and_faces_as_it_was_captured() {
    let clip = read_arrays(&standing(25, 156)).unwrap();
    assert!((clip.seconds() - 0.2).abs() < 1e-12 && clip.check().is_ok());
    let at = |name: &str| place(&clip, 0, name);
    // The mean body is some 1.7 m tall: its head joint is 20 cm below the crown, its ball joints 2 cm above the soles.
    let height = at("head").z - at("left_foot").z;
    assert!((1.40..1.55).contains(&height), "{height} m from the balls of the feet to the head joint");
    assert!((0.0..0.05).contains(&at("left_foot").z), "the ball of a foot is {} m above the ground", at("left_foot").z);
    assert!(at("left_wrist").x < at("right_wrist").x - 1.2, "facing y, left is -x");
    assert!(at("left_foot").y > at("left_ankle").y + 0.1, "toes point along y");
    for name in ["pelvis", "spine3", "head"] {
        let turn = turn(&clip, 0, name);
        assert!((turn * Vec3::x() - Vec3::y()).norm() < 1e-9 && (turn * Vec3::z() - Vec3::z()).norm() < 1e-9, "{name}");
    }
    // SMPL bends a knee by a positive turn about x, which takes the shin backwards.
    let shin = place(&clip, 24, "left_ankle") - place(&clip, 24, "left_knee");
    assert!(shin.y < -0.25 && shin.z < -0.1, "{shin:?}");
}

/// Left and right of the table are a mirror image but for the millimetres by which the scans differ. The rest pose
/// that is made of it is every format's.
#[test]
fn the_mean_body_is_symmetric_and_rests_as_all_do() {
    let skeleton = read_arrays(&standing(2, 72)).unwrap().skeleton;
    let find = |name: &str| skeleton.names.iter().position(|n| n == name).unwrap();
    let plain = parse(
        &npz(&standing(2, 72), CompressionMethod::Stored),
        Path::new("x"),
        &ReadOptions { t_pose: false, ..ReadOptions::default() },
    );
    let plain = plain.unwrap().skeleton;
    for name in ["hip", "knee", "ankle", "foot", "collar", "shoulder", "elbow", "wrist"] {
        let [left, right] = ["left", "right"].map(|side| plain.offsets[find(&format!("{side}_{name}"))]);
        let off = Vec3::new(left.x - right.x, left.y + right.y, left.z - right.z).norm();
        assert!(off < 0.015, "{name}: {off} m");
    }
    let places = skeleton.rest_positions();
    for (side, aside) in [("left", Vec3::y()), ("right", -Vec3::y())] {
        let bone = |from: &str, to: &str| {
            (places[find(&format!("{side}_{to}"))] - places[find(&format!("{side}_{from}"))]).normalize()
        };
        for (from, to, along) in [
            ("hip", "knee", -Vec3::z()),
            ("knee", "ankle", -Vec3::z()),
            ("shoulder", "elbow", aside),
            ("elbow", "wrist", aside),
        ] {
            assert!((bone(from, to) - along).norm() < 1e-9, "{side} {from}");
        }
        assert!(bone("ankle", "foot").x > 0.8, "{side} foot");
    }
}

#[test]
fn every_layout_of_the_same_numbers_is_the_same_clip() {
    let plain = read_arrays(&standing(4, 156)).unwrap();
    let same = |arrays: &[Array], tolerance: f64, what: &str| {
        for method in [CompressionMethod::Stored, CompressionMethod::Deflated] {
            let clip = read_bytes(&npz(arrays, method)).unwrap();
            assert_eq!((clip.len(), clip.fps), (4, 120.0), "{what}");
            for frame in 0..4 {
                for (a, b) in clip.pose(frame).0.iter().zip(plain.pose(frame).0) {
                    assert!((a - b).norm() <= tolerance, "{what}: {}", (a - b).norm());
                }
            }
        }
    };
    for width in [72, 156, 165] {
        same(&standing(4, width), 0.0, "width");
    }
    for (descr, fortran, tolerance) in
        [("<f4", false, 1e-6), (">f8", false, 0.0), ("<f8", true, 0.0), ("<f4", true, 1e-6)]
    {
        let mut arrays = standing(4, 165);
        for array in arrays.iter_mut().filter(|a| a.name != "mocap_framerate") {
            (array.descr, array.fortran) = (descr, fortran);
        }
        same(&arrays, tolerance, descr);
    }
    for (name, descr, shape) in
        [("mocap_frame_rate", "<f8", vec![]), ("mocap_framerate", "<i8", vec![]), ("mocap_frame_rate", "<i4", vec![1])]
    {
        let mut arrays = standing(4, 156);
        arrays[1] = Array { name, descr, fortran: false, shape, values: vec![120.0] };
        same(&arrays, 0.0, name);
    }
}

#[test]
fn python_2_wrote_long_integers() {
    let files = standing(3, 72).into_iter().map(|array| {
        let mut bytes = array.bytes();
        if let Some(at) = bytes.windows(9).position(|w| w == b"(3, 72, )") {
            bytes[at..at + 9].copy_from_slice(b"(3L,72L,)");
        }
        (array.name, bytes)
    });
    let long = read_bytes(&zipped(files, CompressionMethod::Stored)).unwrap();
    assert_eq!(long, read_arrays(&standing(3, 72)).unwrap());
}

#[test]
fn what_is_wrong_is_told_with_file_and_array() {
    let without = |name: &str| standing(3, 156).into_iter().filter(|a| a.name != name).collect::<Vec<_>>();
    let spoilt = |value: f64| {
        let mut arrays = standing(3, 156);
        arrays[3].values[156 + 7] = value;
        arrays
    };
    let rate = |value: f64| with(array("mocap_framerate", &[], vec![value]));
    let object = Array { descr: "|O", ..array("poses", &[3, 156], vec![0.0; 468]) };
    for (arrays, part) in [
        (
            without("poses"),
            "expected array 'poses' of AMASS (or 'root_orient' and 'pose_body', or 'global_orient' and 'body_pose'), got arrays betas, mocap_framerate, trans",
        ),
        (without("trans"), "expected array 'trans' of AMASS (or 'transl'), got arrays betas, mocap_framerate, poses"),
        (without("mocap_framerate"), "expected array 'mocap_framerate' or 'mocap_frame_rate'"),
        (
            vec![array("arr_0", &[2, 22, 3], vec![0.0; 132])],
            "expected array 'poses' of AMASS (or 'root_orient' and 'pose_body', or 'global_orient' and 'body_pose'), got array arr_0",
        ),
        (vec![], "got no array"),
        (
            vec![array("gender", &[1], vec![0.0]), array("betas", &[16], vec![0.0; 16])],
            "got the shape of a person (arrays betas, gender), which AMASS keeps beside the motions",
        ),
        (
            standing(3, 156 + 3),
            "array 'poses' of rotation vectors: [frames, 66], [frames, 72], [frames, 156] or [frames, 165], got [3, 159]",
        ),
        (with(array("poses", &[3, 53, 3], vec![0.0; 477])), "got [3, 53, 3]"),
        (with(array("poses", &[156], vec![0.0; 156])), "got [156]"),
        (with(array("poses", &[0, 156], vec![])), "array 'poses' of 1 to 432000 frames, got [0, 156]"),
        (with(array("poses", &[usize::MAX / 8, 156], vec![])), "array 'poses' of 1 to 432000 frames"),
        (with(array("poses", &[400_000, 156], vec![0.0; 156])), "got the end after 156 of 62400000 numbers"),
        (
            with(array("poses", &[2, 156], vec![0.0; 312])),
            "array 'trans' of shape [2, 3], as there are 2 frames of poses",
        ),
        (with(array("trans", &[3, 4], vec![0.0; 12])), "array 'trans' of shape [3, 3]"),
        (with(array("trans", &[3, 3], vec![0.0; 12])), "array 'trans' of shape [3, 3], got more than 9 numbers"),
        (with(array("trans", &[3, 3], vec![2e6; 9])), "below a million, got 2000000 in row 0, column 0"),
        (spoilt(f64::NAN), "array 'poses' of finite numbers below a million, got NaN in row 1, column 7"),
        (spoilt(f64::NEG_INFINITY), "got -inf in row 1, column 7"),
        (
            vec![object].into_iter().chain(without("poses")).collect(),
            "values of type '|O', not f2, f4, f8, i1 to i8 or u1 to u8",
        ),
        (rate(0.0), "1 to 1000 frames per second in array 'mocap_framerate', or --fps RATE, got 0"),
        (rate(f64::NAN), "got NaN"),
        (with(array("mocap_framerate", &[2], vec![120.0; 2])), "of one number (frames per second), got [2]"),
    ] {
        let message = read_arrays(&arrays).unwrap_err().to_string();
        assert!(message.starts_with("a_poses.npz: expected ") && message.contains(part), "'{part}': {message}");
    }
    let whole = npz(&standing(3, 156), CompressionMethod::Stored);
    let npy = array("a", &[2], vec![0.0; 2]).bytes();
    for (bytes, part) in [
        (&b""[..], "a zip of arrays (.npz)"),
        (b"HIERARCHY", "a zip of arrays (.npz)"),
        (&whole[..whole.len() / 2], "a zip of arrays (.npz)"),
        (&npy, "one array (.npy) of shape [2]; HumanML3D's are [frames, 263]"),
    ] {
        let message = read_bytes(bytes).unwrap_err().to_string();
        assert!(message.contains(part), "'{part}': {message}");
    }
    let mut flipped = whole.clone();
    let at = flipped.windows(5).rposition(|w| w == b"poses").unwrap();
    let middle = at / 2;
    flipped[middle] ^= 1;
    assert!(read_bytes(&flipped).unwrap_err().to_string().to_lowercase().contains("checksum"));
}

#[test]
fn a_recording_has_one_name_in_all_editions() {
    for (path, name) in [
        ("amass/CMU/80/80_63_poses.npz", Some("CMU_80_80_63")),
        ("./pose_data/CMU/80/80_63_poses.npy", Some("CMU_80_80_63")),
        ("BMLrub/rub001/0005_walking1_stageii.npz", Some("BMLrub_rub001_0005_walking1")),
        ("/d/BioMotionLab_NTroje/rub001/0005_walking1_poses.npz", Some("BMLrub_rub001_0005_walking1")),
        (
            "ACCAD/Male1Walking_c3d/Walk B10 - Walk turn left 45_poses.npz",
            Some("ACCAD_Male1Walking_c3d_Walk_B10_-_Walk_turn_left_45"),
        ),
        (
            "ACCAD/Male1Walking_c3d/Walk_B10_-_Walk_turn_left_45_stageii.npz",
            Some("ACCAD_Male1Walking_c3d_Walk_B10_-_Walk_turn_left_45"),
        ),
        (
            "EyesJapanDataset/Eyes_Japan_Dataset/aita/walk-01-poses_poses.npz",
            Some("EyesJapanDataset_aita_walk-01-poses"),
        ),
        ("./pose_data/humanact12/humanact12/P01G01.npy", None),
        ("80_63_poses.npz", None),
        ("", None),
    ] {
        assert_eq!(recording(Path::new(path)).as_deref(), name, "{path}");
    }
    assert_eq!(clip_name(Path::new("amass/KIT/3/walk 01_poses.npz")), "KIT_3_walk_01");
    assert_eq!(clip_name(Path::new("mine/walk 01_poses.npz")), "walk 01_poses");
    assert_eq!(clip_name(Path::new("KIT/3/walk.bvh")), "walk");
}

/// A person's shape is refused in words where it is named, and passed over where it lies among motions.
#[test]
fn shapes_lie_among_motions() {
    let folder = tempfile::tempdir().unwrap();
    let person = folder.path().join("KIT/3");
    std::fs::create_dir_all(&person).unwrap();
    let write = |name: &str, arrays: &[Array]| {
        std::fs::write(person.join(name), npz(arrays, CompressionMethod::Stored)).unwrap();
    };
    write("walk 01_poses.npz", &standing(3, 156));
    write("shape.npz", &[array("gender", &[1], vec![0.0]), array("betas", &[16], vec![0.0; 16])]);
    let found = crate::dataset::find_motion(&[folder.path().to_path_buf()], Format::is_source).unwrap();
    assert_eq!(found, [person.join("walk 01_poses.npz")]);
    assert_eq!(read_source(&found[0], &ReadOptions::default()).unwrap().name, "KIT_3_walk_01");
    let message = read(&person.join("shape.npz"), &ReadOptions::default()).unwrap_err().to_string();
    assert!(message.contains("shape.npz: expected a motion") && message.contains("shape of a person"), "{message}");
}

proptest! {
    /// Whatever is changed, a reader answers with a clip of the numbers that are there or an error, and never panics.
    #[test]
    fn spoilt_archives(
        spots in prop::collection::vec((0.0..1.0f64, any::<u8>()), 1..5),
        deflated in any::<bool>(),
        keep in 0.5..1.5f64,
    ) {
        let method = if deflated { CompressionMethod::Deflated } else { CompressionMethod::Stored };
        let mut bytes = npz(&standing(2, 72), method);
        for (place, value) in spots {
            let at = (place * bytes.len() as f64) as usize;
            bytes[at] = value;
        }
        bytes.truncate((keep * bytes.len() as f64) as usize);
        match read_bytes(&bytes) {
            Ok(clip) => {
                prop_assert!(clip.len() == 2 && clip.fps > 0.0);
                prop_assert!(clip.rotations.iter().flatten().all(|q| q.coords.iter().all(|c| c.is_finite())));
            }
            Err(MotionError::Input(InputError::Format { expected, got, .. })) => prop_assert!(expected.len() < 300 && got.len() < 1500),
            Err(other) => prop_assert!(false, "{other}"),
        }
    }
}

/// The bytes of a small file, for the tests of all formats.
pub(super) fn sample() -> Vec<u8> {
    npz(&standing(3, 156), CompressionMethod::Stored)
}

/// SMPL-X' code, GVHMR and GMR keep the root and the body apart.
#[test]
fn parts_of_poses_are_read_as_the_whole() {
    let whole = standing(3, 156);
    let poses = whole.iter().find(|a| a.name == "poses").unwrap().values.clone();
    let part = |from: usize, to: usize| poses.chunks(156).flat_map(|row| row[from..to].to_vec()).collect::<Vec<f64>>();
    let mut parts: Vec<Array> = standing(3, 156).into_iter().filter(|a| a.name != "poses").collect();
    parts.push(array("root_orient", &[3, 3], part(0, 3)));
    parts.push(array("pose_body", &[3, 63], part(3, 66)));
    assert_eq!(read_arrays(&parts).unwrap(), read_arrays(&whole).unwrap());
    parts.pop();
    parts.push(array("pose_body", &[2, 63], vec![0.0; 126]));
    let message = read_arrays(&parts).unwrap_err().to_string();
    assert!(message.contains("'pose_body' of shape [3, 63]"), "{message}");
}

/// Numbers of IEEE 754's tables and of two's complement.
#[test]
fn every_kind_of_number_is_read_as_numpy_writes_it() {
    use super::super::npz::Kind;
    let value = |letters: &str, bytes: &[u8]| {
        let kind = Kind::of(letters).unwrap();
        assert_eq!(kind.size(), bytes.len(), "{letters}");
        let reversed: Vec<u8> = bytes.iter().rev().copied().collect();
        assert_eq!(kind.value(bytes, true).to_bits(), kind.value(&reversed, false).to_bits(), "{letters}");
        kind.value(bytes, true)
    };
    for (bits, number) in [
        (0x3c00_u16, 1.0),
        (0xc000, -2.0),
        (0x7bff, 65504.0),
        (0x0400, 2f64.powi(-14)),
        (0x0001, 2f64.powi(-24)),
        (0x3555, 0.333_251_953_125),
        (0x7c00, f64::INFINITY),
        (0x8000, 0.0),
    ] {
        assert_eq!(value("f2", &bits.to_be_bytes()), number, "{bits:x}");
    }
    assert!(value("f2", &[0x7e, 0]).is_nan());
    for (letters, bytes, number) in [
        ("i1", &[0xff][..], -1.0),
        ("i2", &[0xff, 0xfe], -2.0),
        ("i2", &[0x7f, 0xff], 32767.0),
        ("i4", &[0x80, 0, 0, 0], -2_147_483_648.0),
        ("i8", &[0xff; 8], -1.0),
        ("u1", &[0xff], 255.0),
        ("u2", &[0xff, 0xff], 65535.0),
        ("u4", &[0xff; 4], 4_294_967_295.0),
        ("u8", &[0, 0, 0, 0, 0, 0, 1, 0], 256.0),
    ] {
        assert_eq!(value(letters, bytes), number, "{letters} {bytes:?}");
    }
}

#[test]
fn other_names_and_shapes_of_the_same_rotations_are_the_same_clip() {
    let plain = read_arrays(&standing(4, 156)).unwrap();
    let rows: Vec<f64> = standing(4, 156).remove(3).values;
    let part =
        |from: usize, to: usize| -> Vec<f64> { rows.chunks(156).flat_map(|row| row[from..to].to_vec()).collect() };
    let places = || standing(4, 156).remove(0).values;
    let rate = || array("fps", &[], vec![120.0]);
    let body = |poses: Array| vec![array("trans", &[4, 3], places()), rate(), poses];
    let parts = |root: &[usize], body: &[usize], last: usize| {
        let (root, body) = (array("global_orient", root, part(0, 3)), array("body_pose", body, part(3, last)));
        vec![array("transl", &[4, 3], places()), rate(), root, body]
    };
    for (what, arrays) in [
        ("66 columns", body(array("poses", &[4, 66], part(0, 66)))),
        ("22 joints", body(array("poses", &[4, 22, 3], part(0, 66)))),
        ("52 joints", body(array("poses", &[4, 52, 3], rows.clone()))),
        ("names of the SMPL-X code", parts(&[4, 3], &[4, 63], 66)),
        ("SMPL's hands", parts(&[4, 1, 3], &[4, 23, 3], 72)),
    ] {
        let clip = read_arrays(&arrays).unwrap();
        assert_eq!((clip.len(), clip.fps), (4, 120.0), "{what}");
        for frame in 0..4 {
            assert_eq!(clip.pose(frame).0, plain.pose(frame).0, "{what}");
        }
    }
    let error = read_arrays(&body(array("poses", &[4, 23], part(0, 23)))).unwrap_err().to_string();
    assert!(error.contains("of rotation vectors: [frames, 66]") && error.contains("[4, 23]"), "{error}");
}

#[test]
fn motion_of_a_robot_is_not_called_human() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("walk.npz");
    let open = |arrays: &[Array]| {
        std::fs::write(&path, npz(arrays, CompressionMethod::Stored)).unwrap();
        super::super::robot_motion::open(&path, &ReadOptions::default()).unwrap_err().to_string()
    };
    let error = open(&[array("qpos", &[2, 36], vec![0.0; 72])]);
    assert!(!error.contains("human motion") && error.contains("qpos"), "{error}");
    assert!(open(&standing(2, 72)).contains("got human motion"));
}
