//! HumanML3D over AMASS, from files in the published layouts to captioned clips of a robot: index and texts, `.npz` of two
//! persons whose files have the same name, retargeting, pieces.

use std::collections::BTreeMap;
use std::io::{Cursor, Write};
use std::path::Path;

use lifelike_character::anatomy::Overrides;
use lifelike_character::{Anatomy, Character};
use lifelike_language::dataset::Split;
use lifelike_language::humanml3d::{pieces, read};
use lifelike_motion::MotionClip;
use lifelike_motion::dataset::find_motion;
use lifelike_motion::formats::{Format, ReadOptions, read_source};
use lifelike_motion::retarget::{RetargetOptions, retarget};

const HZ: usize = 120;
const SECONDS: usize = 6;
/// SMPL's shoulders in the order of joints: left, right.
const SHOULDERS: [usize; 2] = [16, 17];

fn array(shape: &[usize], values: &[f64]) -> Vec<u8> {
    let shape: String = shape.iter().map(|n| format!("{n}, ")).collect();
    let header = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': ({shape}), }}\n");
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.bytes());
    bytes.extend(values.iter().flat_map(|v| v.to_le_bytes()));
    bytes
}

/// Someone who stands with hanging arms, and raises one of them to the side from the second second to the fourth.
fn raises(side: usize) -> Vec<u8> {
    let frames = SECONDS * HZ + 1;
    let mut poses = Vec::new();
    for frame in 0..frames {
        let time = frame as f64 / HZ as f64;
        let up = if (2.0..4.0).contains(&time) { (std::f64::consts::PI * (time - 2.0) / 2.0).sin() } else { 0.0 };
        let mut row = vec![0.0; 156];
        // From y up to z up: a quarter turn about x.
        row[0] = std::f64::consts::FRAC_PI_2;
        for (at, (joint, down)) in SHOULDERS.into_iter().zip([-1.2, 1.2]).enumerate() {
            row[3 * joint + 2] = if at == side { down * (1.0 - 1.8 * up) } else { down };
        }
        poses.extend(row);
    }
    let mut zip = zip::ZipWriter::new(Cursor::new(Vec::new()));
    for (name, bytes) in [
        ("trans.npy", array(&[frames, 3], &[0.3, -0.2, 0.92].repeat(frames))),
        ("mocap_framerate.npy", array(&[], &[HZ as f64])),
        ("poses.npy", array(&[frames, 156], &poses)),
    ] {
        zip.start_file(name, zip::write::SimpleFileOptions::default()).unwrap();
        zip.write_all(&bytes).unwrap();
    }
    zip.finish().unwrap().into_inner()
}

/// Returns by how much an arm's joints move (rad).
fn arm_moves(clip: &MotionClip, side: &str) -> f64 {
    let column = |name: &str| clip.joint_names.iter().position(|n| n == name).unwrap();
    let of = ["shoulder_pitch", "shoulder_roll"].map(|part| column(&format!("{side}_{part}")));
    let spread = |at: usize| {
        let values = (0..clip.len()).map(|t| clip.joints_at(t)[at]);
        values.clone().fold(f64::MIN, f64::max) - values.fold(f64::MAX, f64::min)
    };
    of.into_iter().map(spread).fold(0.0, f64::max)
}

#[test]
fn sentences_come_to_the_motion_of_their_person() {
    let root = tempfile::tempdir().unwrap();
    let write = |name: &str, bytes: &[u8]| {
        let path = root.path().join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, bytes).unwrap();
    };
    // The index is of the older edition, one person's folder of the newer: other ending, underscores for spaces.
    write("AMASS/MPI_mosh/00008/raise arm_poses.npz", &raises(0));
    write("AMASS/MoSh/50002/raise_arm_stageii.npz", &raises(1));
    let rows = "./pose_data/MPI_mosh/00008/raise arm_poses.npy,0,120,000001.npy\n\
                ./pose_data/MPI_mosh/50002/raise arm_poses.npy,20,100,000002.npy\n\
                ./pose_data/MPI_mosh/50004/raise arm_poses.npy,0,120,000003.npy\n";
    write("HumanML3D/index.csv", format!("source_path,start_frame,end_frame,new_name\n{rows}").as_bytes());
    write("HumanML3D/train.txt", b"000001\n000003\n");
    write("HumanML3D/val.txt", b"");
    write("HumanML3D/test.txt", b"000002\n");
    write(
        "HumanML3D/texts/000001.txt",
        b"someone raises the left arm.#a/X#0.0#0.0\nthe left arm comes up#a/X#2.0#4.0\n",
    );
    write("HumanML3D/texts/000002.txt", b"someone raises the right arm.#a/X#nan#nan\n");
    write("HumanML3D/texts/000003.txt", b"nobody's motion#a/X#0.0#0.0\n");

    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../robots/lima.xml");
    let lima = Character::from_mjcf(&std::fs::read_to_string(file).unwrap(), "lima.xml", None).unwrap();
    let anatomy = Anatomy::guess(&lima, &Overrides::new()).unwrap();
    let mut clips: BTreeMap<String, MotionClip> = BTreeMap::new();
    for file in find_motion(&[root.path().join("AMASS")], Format::is_source).unwrap() {
        let source = read_source(&file, &ReadOptions::default()).unwrap();
        let (clip, report) = retarget(&source, &lima, &anatomy, &RetargetOptions::default()).unwrap();
        assert!((clip.seconds() - SECONDS as f64).abs() < 0.03, "{} s", clip.seconds());
        assert!(report.contact_share > 0.99 && report.foot_skate.mean < 0.01, "{report:?}");
        assert!(clip.provenance.licence.contains("non-commercial") && clip.provenance.licence.contains("betas"));
        clips.insert(clip.name.clone(), clip);
    }
    assert_eq!(clips.keys().collect::<Vec<_>>(), ["MoSh_00008_raise_arm", "MoSh_50002_raise_arm"]);

    let items = read(&root.path().join("HumanML3D")).unwrap();
    let found = items.iter().map(|item| item.clip_names().iter().find_map(|name| clips.get(name))).collect::<Vec<_>>();
    assert!(found[2].is_none(), "another person's file of the same name is another motion");
    let first = pieces(&items[0], found[0].unwrap(), &lima).unwrap();
    let second = pieces(&items[1], found[1].unwrap(), &lima).unwrap();
    let names = |made: &[(MotionClip, lifelike_language::Entry)]| -> Vec<String> {
        made.iter().map(|(clip, _)| clip.name.clone()).collect()
    };
    assert_eq!(names(&first), ["000001", "M000001", "000001_2000", "M000001_2000"]);
    assert_eq!(names(&second), ["000002", "M000002"]);
    for (clip, entry) in first.iter().chain(&second) {
        // Captions of mirror images say the other side, and so the moving arm is the one that the sentence names.
        let [moves, rests] = if entry.captions[0].contains("left") { ["left", "right"] } else { ["right", "left"] };
        let (moving, resting) = (arm_moves(clip, moves), arm_moves(clip, rests));
        assert!(moving > 1.0 && resting < 0.2, "{} '{}': {moving} {resting}", clip.name, entry.captions[0]);
        let seconds = if clip.name.contains("_2000") {
            2.0
        } else if clip.name.ends_with("1") {
            6.0
        } else {
            4.0
        };
        assert!((clip.seconds() - seconds).abs() < 0.03, "{}: {} s", clip.name, clip.seconds());
        assert!(entry.licence.contains("AMASS"));
    }
    assert_eq!((first[0].1.split, second[0].1.split), (Split::Train, Split::Test));
}
