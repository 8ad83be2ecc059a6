//! Exact numbers: hand arithmetic, or scipy 1.x's `Rotation` (intrinsic `from_euler` orders) with the file's channels.

use lifelike_character::rotation;
use lifelike_checkpoint::InputError;

use super::*;

/// World positions of `small.bvh` in its second frame, by forward kinematics in scipy, as z up, x forward, y left (m).
const SCIPY: [(&str, [f64; 3]); 14] = [
    ("Hips", [0.082300000, 0.483500000, -0.817000000]),
    ("Spine", [0.048555705, 0.422343138, -0.629326984]),
    ("LeftArm", [-0.219448962, 0.210099618, -0.554988658]),
    ("LeftForeArm", [-0.318181812, 0.218577387, -0.308250028]),
    ("LeftHand", [-0.309247539, -0.033385110, -0.319872361]),
    ("RightArm", [0.059644200, 0.094423477, -0.750759027]),
    ("RightForeArm", [0.044801822, 0.310298819, -0.905282620]),
    ("RightHand", [-0.053211349, 0.516237154, -0.797195522]),
    ("LeftUpLeg", [0.019150889, 0.554436880, -0.857989618]),
    ("LeftLeg", [0.289018637, 0.845165999, -0.914096460]),
    ("LeftFoot", [0.569116015, 1.156827789, -0.955477465]),
    ("RightUpLeg", [0.174100443, 0.462857918, -0.859971887]),
    ("RightLeg", [0.538449118, 0.420374438, -1.021047015]),
    ("RightFoot", [0.684208442, 0.813325597, -0.980505608]),
];

#[test]
fn bvh_has_the_positions_that_scipy_finds_whatever_the_rest_pose() {
    for t_pose in [false, true] {
        let options = ReadOptions { t_pose, ..ReadOptions::default() };
        let clip = bvh::parse(BVH.as_bytes(), Path::new("small.bvh"), &options).unwrap();
        assert_eq!((clip.len(), clip.fps, clip.name.as_str()), (2, 120.0, "small"));
        for (name, want) in SCIPY {
            let off = place(&clip, 1, name) - Vec3::from(want);
            assert!(off.norm() < 1e-8, "{name} is off by {off}");
        }
        let hips = rotation::to_wxyz(&turn(&clip, 1, "Hips"));
        let want = [0.851257079, 0.104618704, -0.172474316, 0.484426386];
        let off = hips.iter().zip(want).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(off < 1e-8, "{hips:?}");
    }
}

#[test]
fn the_rest_pose_is_a_t_pose() {
    let clip = bvh(BVH.as_bytes()).unwrap();
    let offset = |name: &str| clip.skeleton.offsets[joint(&clip, name)];
    let along = |name: &str, to: Vec3| (offset(name).normalize() - to).norm();
    for side in ["Left", "Right"] {
        let aside = if side == "Left" { Vec3::y() } else { -Vec3::y() };
        assert!(along(&format!("{side}Leg"), -Vec3::z()) < 1e-12);
        assert!(along(&format!("{side}Foot"), -Vec3::z()) < 1e-12);
        assert!(along(&format!("{side}ForeArm"), aside) < 1e-12);
        assert!(along(&format!("{side}Hand"), aside) < 1e-12);
    }
    // A leg that the file draws bent by 6.0 degrees at the knee still has its length.
    assert!((offset("LeftFoot").norm() - (0.42_f64.powi(2) + 0.03_f64.powi(2)).sqrt()).abs() < 1e-12);
}

#[test]
fn a_bvh_that_stands_along_z_is_not_turned_over() {
    // The same skeleton with y and z exchanged by hand: up is z, forward is -y.
    let mut text = String::new();
    for line in BVH.lines() {
        let mut words: Vec<&str> = line.split_whitespace().collect();
        if words.first() == Some(&"OFFSET") {
            let y = words[2].parse::<f64>().unwrap();
            let turned = format!("OFFSET {} {} {y}", words[1], -words[3].parse::<f64>().unwrap());
            text.push_str(&turned);
        } else if words.len() > 40 {
            words.fill("0");
            text.push_str(&words.join(" "));
        } else {
            text.push_str(line);
        }
        text.push('\n');
    }
    let clip = bvh(text.as_bytes()).unwrap();
    assert!((place(&clip, 0, "Spine") - Vec3::new(0.01, 0.0, 0.20)).norm() < 1e-12, "{}", place(&clip, 0, "Spine"));
    assert!((place(&clip, 0, "LeftUpLeg") - Vec3::new(0.01, 0.09, -0.05)).norm() < 1e-12);
}

#[test]
fn a_static_joint_above_the_hips_is_merged_into_them() {
    let text = "HIERARCHY
ROOT Base
{
  OFFSET 0 0 0
  CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation
  JOINT Hip
  {
    OFFSET 0 90 0
    CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation
    JOINT Leg
    {
      OFFSET 0 -120 0
      CHANNELS 3 Zrotation Xrotation Yrotation
      End Site
      {
        OFFSET 0 0 10
      }
    }
  }
}
MOTION
Frames: 1
Frame Time: 0.04
10 0 0 0 0 90 0 90 5 0 0 90 0 90 0
";
    let clip = bvh(text.as_bytes()).unwrap();
    assert_eq!((clip.skeleton.names.as_slice(), clip.fps), (["Hip".to_owned(), "Leg".to_owned()].as_slice(), 25.0));
    // The base is 10 cm to the left (file x) and turned left by 90 degrees: 5 cm along its z is along the file's x.
    assert!((place(&clip, 0, "Hip") - Vec3::new(0.0, 0.15, 0.90)).norm() < 1e-12, "{}", place(&clip, 0, "Hip"));
    // Turned by 90 degrees twice, the body looks backward.
    assert!((turn(&clip, 0, "Hip") * Vec3::x() + Vec3::x()).norm() < 1e-12);
    // Then the leg turns by 90 degrees about its own x, its thigh goes from down to what was its front: backward.
    assert!((turn(&clip, 0, "Leg") * -Vec3::z() - Vec3::x()).norm() < 1e-12, "{}", turn(&clip, 0, "Leg") * -Vec3::z());
}

#[test]
fn acclaim_has_the_positions_that_scipy_finds() {
    let clip = acclaim(ASF.as_bytes(), AMC.as_bytes()).unwrap();
    assert_eq!((clip.len(), clip.fps), (2, 120.0));
    let knee = place(&clip, 0, "lfoot");
    assert!((knee - Vec3::new(-0.284415948, 0.430422248, 1.014413414)).norm() < 1e-8, "{knee}");
    let (end_of, offset) = clip.skeleton.ends[0];
    let (places, turns) = clip.pose(0);
    let toe = places[end_of] + turns[end_of] * offset;
    assert!((toe - Vec3::new(-0.270953680, 0.493935170, 0.922062034)).norm() < 1e-8, "{toe}");
    // A unit of length is an inch over 0.45.
    assert!((clip.root_position[0] - Vec3::new(-3.0, 1.0, 17.0) * 0.0254 / 0.45).norm() < 1e-12);
}

#[test]
fn deepmimic_has_the_positions_that_scipy_finds() {
    let clip = deepmimic(CHARACTER.as_bytes(), DEEPMIMIC.as_bytes()).unwrap();
    assert_eq!((clip.len(), clip.fps, clip.cyclic), (2, 30.0, true));
    for (name, want) in [
        ("right_hip", [1.034210526, 0.330263158, 0.794210526]),
        ("right_knee", [1.190194332, 0.628627530, 0.543117409]),
        ("right_ankle", [1.090505662, 0.837209117, 0.204508652]),
    ] {
        assert!((place(&clip, 0, name) - Vec3::from(want)).norm() < 1e-8, "{name}: {}", place(&clip, 0, name));
    }
    // Position (x, y, z) becomes (x, -z, y), a quaternion (w, x, -z, y), a hinge turns about -y.
    assert!((clip.root_position[0] - Vec3::new(1.0, 0.4, 0.9)).norm() < 1e-12);
    let root = rotation::from_wxyz([0.9, 0.1, -0.3, -0.2]).unwrap();
    assert!(turn(&clip, 0, "root").angle_to(&root) < 1e-7);
    let knee = turn(&clip, 0, "right_hip").inverse() * turn(&clip, 0, "right_knee");
    assert!((knee.scaled_axis() - Vec3::new(0.0, 0.7, 0.0)).norm() < 1e-9, "a flexed knee turns about +y: {knee}");
}

#[test]
fn frames_of_unequal_duration_are_resampled() {
    let text = DEEPMIMIC
        .replace("[0.0, 0, 0, 0,", "[0.0666666, 0, 0, 0,")
        .replace("]\n]}", "],\n[0.0, 2, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 0]\n]}");
    let clip = deepmimic(CHARACTER.as_bytes(), text.as_bytes()).unwrap();
    // The second frame lasts twice as long, so half-way through it there is a new one.
    let x: Vec<f64> = clip.root_position.iter().map(|p| p.x).collect();
    assert_eq!(x.len(), 4);
    for (got, want) in x.iter().zip([1.0, 0.0, 1.0, 2.0]) {
        assert!((got - want).abs() < 1e-5, "{x:?}");
    }
}

#[test]
fn quaternions_do_not_jump_where_a_file_goes_around() {
    let turning: Vec<String> = (0..40).map(|i| format!("{}", (i * 30 + 180) % 360 - 180)).collect();
    let mut text: String = BVH.split("MOTION").next().unwrap().to_owned();
    text.push_str("MOTION\nFrames: 40\nFrame Time: 0.01\n");
    for angle in turning {
        text.push_str(&format!("0 0 0 0 {angle} 0{}\n", " 0".repeat(39)));
    }
    let clip = bvh(text.as_bytes()).unwrap();
    for pair in clip.rotations.windows(2) {
        assert!(pair[0][0].coords.dot(&pair[1][0].coords) > 0.9);
    }
}

#[test]
fn units_are_guessed_or_stated() {
    let scaled = |factor: f64| {
        let lines = BVH.lines().map(|line| match line.trim().strip_prefix("OFFSET ") {
            Some(rest) => {
                let values: Vec<String> =
                    rest.split_whitespace().map(|v| (v.parse::<f64>().unwrap() * factor).to_string()).collect();
                format!("OFFSET {}", values.join(" "))
            }
            None => line.to_owned(),
        });
        lines.collect::<Vec<_>>().join("\n")
    };
    let thigh = |clip: &SourceClip| clip.skeleton.offsets[joint(clip, "LeftLeg")].norm();
    let want = (40.0_f64.powi(2) + 4.0 + 1.0).sqrt() * 0.01;
    for factor in [1.0, 0.01, 10.0] {
        assert!((thigh(&bvh(scaled(factor).as_bytes()).unwrap()) - want).abs() < 1e-12, "times {factor}");
    }
    let inches = scaled(1.0 / 2.54);
    assert!(bvh(inches.as_bytes()).unwrap_err().to_string().contains("--scale 0.0254"));
    let options = ReadOptions { scale: Some(0.0254), ..ReadOptions::default() };
    assert!((thigh(&bvh::parse(inches.as_bytes(), Path::new("x.bvh"), &options).unwrap()) - want).abs() < 1e-12);
}

#[test]
fn a_clip_is_found_by_content_and_its_skeleton_beside_it() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        path
    };
    let options = ReadOptions::default();
    let amc = write("07_01.amc", AMC);
    let error = read(&amc, &options).unwrap_err().to_string();
    assert!(error.contains("07.asf") && error.contains("0 ASF files"), "{error}");
    write("other.asf", ASF);
    assert_eq!(read_source(&amc, &options).unwrap().name, "07_01");
    write("07.asf", ASF);
    assert!(read(&amc, &options).is_ok(), "the subject's own ASF among several");
    assert!(read(&write("motion.txt", BVH), &options).is_ok());
    let dance = write("humanoid3d_dance.txt", DEEPMIMIC);
    assert!(read(&dance, &options).unwrap_err().to_string().contains("humanoid3d.txt"));
    write("humanoid3d.txt", CHARACTER);
    assert!(read_source(&dance, &options).unwrap().cyclic);
    assert!(read(&write("note.txt", "hello"), &options).unwrap_err().to_string().contains("BVH"));
    assert!(matches!(read(&folder.path().join("none.bvh"), &options), Err(MotionError::Input(InputError::Io { .. }))));
}

#[test]
fn captions_are_found_by_name() {
    let table = "trial\tsubject_description\ttrial_description\tkitml_captions\n\
                 07_01\tsomeone\twalk\t\"[[0.5, 2.0, \"\"A person \\\"\"walks\\\"\".\"\"]]\"\n\
                 07_02\tsomeone\trun\t[]\n";
    let table = CaptionTable::parse(table.as_bytes(), Path::new("t.tsv")).unwrap();
    let found = table.find(Path::new("a/07_01.bvh"), 3.0);
    assert_eq!(found.len(), 2);
    assert_eq!((found[0].start, found[0].end, found[0].text.as_str()), (0.0, 3.0, "walk"));
    assert_eq!((found[1].start, found[1].end, found[1].text.as_str()), (0.5, 2.0, "A person \"walks\"."));
    assert!(table.find(Path::new("09_01.amc"), 1.0).is_empty());
    let styles = "file\tcontent\tstyle\tframes\nb/dataset-1_bow_angry_001.bvh\tbow\tangry\t90\n";
    let table = CaptionTable::parse(styles.as_bytes(), Path::new("t.tsv")).unwrap();
    assert_eq!(table.find(Path::new("dataset-1_bow_angry_001.bvh"), 3.0)[0].text, "bow, angry");
    let error = CaptionTable::parse(b"a\tb\n1\t2\n", Path::new("t.tsv")).unwrap_err().to_string();
    assert!(error.starts_with("t.tsv:2:"), "{error}");
}
