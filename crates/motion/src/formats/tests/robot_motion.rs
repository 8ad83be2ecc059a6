//! Layouts of robot motion: against files that NumPy, pickle, PyTorch and MuJoCo wrote (`peers/motion/layouts.py`),
//! round trips, detection, and files that are hostile.

use std::fmt::Write as _;
use std::sync::Arc;

use lifelike_character::{Anatomy, Character};
use proptest::prelude::*;

use super::super::robot_motion::{LAYOUTS, Layout, Rate, Reading, by_name, lost, read, write};
use super::*;
use crate::clip::{Contacts, MotionClip};
use crate::keyframes;
use crate::resample::resample;
use crate::retarget::{RetargetOptions, retarget};

macro_rules! fixture {
    ($layout:literal, $file:literal) => {
        ($layout, $file, include_bytes!(concat!("robot_motion/", $file)) as &[u8])
    };
}

/// Layout, file, content: one motion of lima.
const FIXTURES: [(&str, &str, &[u8]); 12] = [
    fixture!("lafan1", "lafan1.csv"),
    fixture!("kimodo", "kimodo.csv"),
    fixture!("bones-seed", "bones.csv"),
    fixture!("mjlab", "mjlab.npz"),
    fixture!("beyondmimic", "beyondmimic.npz"),
    fixture!("wbc", "wbc.npz"),
    fixture!("holosoma", "holosoma.npz"),
    fixture!("gmr", "gmr2.pkl"),
    fixture!("gmr", "gmr4.pkl"),
    fixture!("gmr", "gmr5.pkl"),
    fixture!("gmr", "gmr_fortran.pkl"),
    fixture!("protomotions", "protomotions.motion"),
];

pub(super) fn lima() -> Arc<Character> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../robots/lima.xml");
    Arc::new(Character::load(&path).unwrap())
}

fn options(robot: Option<Arc<Character>>, layout: Option<&str>) -> ReadOptions {
    let layout = layout.map(|name| by_name(name).unwrap());
    ReadOptions { robot, layout, ..ReadOptions::default() }
}

fn open(bytes: &[u8], file: &str, options: &ReadOptions) -> Result<Reading, MotionError> {
    read(bytes, Path::new(file), options)
}

/// Returns the largest differences of root positions (m), orientations (rad) and joints by name (rad).
fn differences(a: &MotionClip, b: &MotionClip) -> [f64; 3] {
    assert_eq!((a.len(), a.joint_names.len()), (b.len(), b.joint_names.len()));
    let max = |values: &mut dyn Iterator<Item = f64>| values.fold(0.0, f64::max);
    let columns: Vec<usize> =
        a.joint_names.iter().map(|name| b.joint_names.iter().position(|n| n == name).unwrap()).collect();
    [
        max(&mut a.root_position.iter().zip(&b.root_position).map(|(a, b)| (a - b).norm())),
        max(&mut a.root_orientation.iter().zip(&b.root_orientation).map(|(a, b)| a.angle_to(b))),
        max(&mut (0..a.len()).flat_map(|frame| {
            let (a, b) = (a.joints_at(frame), b.joints_at(frame));
            columns.iter().zip(a).map(|(column, a)| (a - b[*column]).abs()).collect::<Vec<_>>()
        })),
    ]
}

/// Asserts that clips are equal to what 32-bit numbers hold: 1e-7 of a metre or radian, and nine decimals of text.
fn assert_equal(a: &MotionClip, b: &MotionClip, what: &str) {
    let [position, orientation, joints] = differences(a, b);
    assert!(position < 1e-6 && orientation < 2e-6 && joints < 1e-6, "{what}: {position:e} {orientation:e} {joints:e}");
}

#[test]
fn files_of_other_programs_hold_the_same_motion() {
    let robot = lima();
    let truth = &open(FIXTURES[0].2, "lafan1.csv", &options(Some(robot.clone()), Some("lafan1"))).unwrap().clips[0];
    assert!((truth.root_position[1].x - 0.016).abs() < 1e-9 && (truth.joints_at(0)[1] - 0.252_441_295).abs() < 1e-12);
    for (layout, file, bytes) in FIXTURES {
        let reading = open(bytes, file, &options(Some(robot.clone()), None)).unwrap();
        assert_eq!(reading.layout.name, layout, "{file}");
        let own = match reading.layout.rate {
            Rate::Fixed(rate) => rate,
            Rate::Usual(_) | Rate::Stated => 50.0,
        };
        assert_eq!(reading.clips[0].fps, own, "{file}");
        assert_equal(&reading.clips[0], truth, file);
        assert_eq!(reading.clips[0].provenance.character, "lima", "{file}");
    }
}

/// Columns are found by name: the same motion, whatever their order.
#[test]
fn columns_of_our_table_are_found_by_name() {
    let robot = lima();
    let truth = &open(FIXTURES[0].2, "lafan1.csv", &options(Some(robot), Some("lafan1"))).unwrap().clips[0];
    let csv = String::from_utf8(write(truth, by_name("csv").unwrap(), None).unwrap()).unwrap();
    let backwards = |line: &str| line.split(',').rev().collect::<Vec<_>>().join(",") + "\n";
    let turned: String = csv.lines().map(backwards).collect();
    let mut read = open(turned.as_bytes(), "turned.csv", &options(None, None)).unwrap().clips.remove(0);
    assert_eq!(read.joint_names.iter().rev().collect::<Vec<_>>(), truth.joint_names.iter().collect::<Vec<_>>());
    let width = read.joint_names.len();
    read.joint_names.reverse();
    read.joints.chunks_mut(width).for_each(<[f64]>::reverse);
    assert_equal(&read, truth, "turned.csv");
    let without = csv.replacen("root_qy", "qy", 1);
    assert!(
        open(without.as_bytes(), "x.csv", &options(None, Some("csv"))).unwrap_err().to_string().contains("root_qy")
    );
}

#[test]
fn the_layout_is_said() {
    let said = |at: usize| {
        let (_, file, bytes) = FIXTURES[at];
        open(bytes, file, &options(Some(lima()), None)).unwrap().said
    };
    assert_eq!(said(0), "Unitree LAFAN1 CSV: 27 columns, quaternion x y z w, 30 frames per second (the layout's own)");
    assert_eq!(
        said(4),
        "BeyondMimic motion.npz: 20 joints, 21 bodies, quaternion w x y z, bodies and joints breadth-first (Isaac Lab), 50 \
         frames per second"
    );
    assert!(said(5).contains("2 clips"), "{}", said(5));
    let rate = ReadOptions { fps: Some(60.0), ..options(Some(lima()), None) };
    let reading = open(FIXTURES[0].2, "a.csv", &rate).unwrap();
    assert_eq!(reading.clips[0].fps, 60.0);
    assert!(
        reading.said.ends_with("60 frames per second (as given)")
            && reading.clips[0].provenance.source.contains("LAFAN1")
    );
}

#[test]
fn a_bundle_has_its_clips_and_other_files_their_contacts() {
    let robot = lima();
    let reading = open(FIXTURES[5].2, "wbc.npz", &options(None, None)).unwrap();
    let names: Vec<(&str, usize)> = reading.clips.iter().map(|clip| (clip.name.as_str(), clip.len())).collect();
    assert_eq!(names, [("turn", 5), ("part", 3)]);
    assert_eq!(reading.clips[1].joints_at(2), reading.clips[0].joints_at(2));
    let (folder, path) = (tempfile::tempdir().unwrap(), "bundle.npz");
    std::fs::write(folder.path().join(path), FIXTURES[5].2).unwrap();
    let error = super::super::read(&folder.path().join(path), &ReadOptions::default()).unwrap_err().to_string();
    assert!(error.contains("a bundle of 2") && error.contains("motion convert"), "{error}");
    let contacts = open(FIXTURES[11].2, "a.motion", &options(Some(robot), None)).unwrap().clips[0].contacts.clone();
    let flags = vec![true, true, false, false, false];
    assert_eq!(contacts, Some(Contacts { names: vec!["left_foot".into()], flags }));
}

/// Reads an array of an `.npz` of ours or NumPy's.
fn array(bytes: &[u8], name: &str) -> Vec<f64> {
    let mut archive = super::super::npz::Archive::open(bytes, Path::new("a.npz")).unwrap();
    archive.array(name).unwrap().select(|_, _| true).unwrap()
}

#[test]
fn poses_and_velocities_are_those_of_mujoco() {
    let robot = lima();
    let options = options(Some(robot.clone()), Some("lafan1"));
    let clip = &open(FIXTURES[0].2, "lafan1.csv", &ReadOptions { fps: Some(50.0), ..options }).unwrap().clips[0];
    for (layout, _, theirs) in &FIXTURES[3..7] {
        if *layout == "wbc" {
            continue;
        }
        let ours = write(clip, by_name(layout).unwrap(), Some(&robot)).unwrap();
        for name in ["joint_pos", "joint_vel", "body_pos_w", "body_lin_vel_w", "body_ang_vel_w", "fps"] {
            let (ours, theirs) = (array(&ours, name), array(theirs, name));
            assert_eq!(ours.len(), theirs.len(), "{layout} {name}");
            let worst = ours.iter().zip(&theirs).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            // Speeds up to 15: 32-bit numbers, and nine decimals times 25 per second.
            assert!(worst < 5e-6, "{layout} {name}: {worst:e}");
        }
        let turns = [array(&ours, "body_quat_w"), array(theirs, "body_quat_w")];
        let dots = turns[0].chunks_exact(4).zip(turns[1].chunks_exact(4));
        let dots = dots.map(|(a, b)| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>().abs());
        assert!(dots.fold(f64::INFINITY, f64::min) > 1.0 - 1e-6, "{layout}");
    }
}

/// Returns some of our keyframed clips on lima, at 50 frames per second.
pub(super) fn clips(robot: &Character, names: &[&str]) -> Vec<MotionClip> {
    let anatomy = Anatomy::guess(robot, &lifelike_character::anatomy::Overrides::default()).unwrap();
    let options = RetargetOptions { fps: 50.0, ..RetargetOptions::default() };
    let made = keyframes::builtin().filter(|(name, _)| names.contains(name)).map(|(name, text)| {
        let source = keyframes::parse(text.as_bytes(), Path::new(name)).unwrap();
        retarget(&source, robot, &anatomy, &options).unwrap().0
    });
    made.collect()
}

#[test]
fn what_is_written_is_read_again() {
    let robot = lima();
    let clip = &clips(&robot, &["walk"])[0];
    for layout in LAYOUTS.iter().filter(|layout| !matches!(layout.name, "bvh" | "glb")) {
        for fps in [50.0, 30.0] {
            let clip = resample(clip, fps).unwrap();
            let bytes = write(&clip, layout, Some(&robot)).unwrap();
            let options = ReadOptions { fps: Some(fps), ..options(Some(robot.clone()), None) };
            let reading = open(&bytes, "walk", &options).unwrap();
            assert_eq!(reading.layout.name, layout.name);
            let [back] = reading.clips.as_slice() else { panic!("{}", layout.name) };
            assert_eq!(back.fps, fps);
            assert_equal(&clip, back, layout.name);
            let holds = layout.holds.contains(&super::super::robot_motion::Part::Contacts);
            assert_eq!(back.contacts.is_some(), holds && clip.contacts.is_some(), "{}", layout.name);
        }
    }
    // Rates by slerp: the frames of a file are those of the clip at that rate, between its own frames.
    let slow = resample(clip, 30.0).unwrap();
    let bytes = write(&slow, by_name("lafan1").unwrap(), Some(&robot)).unwrap();
    let read = &open(&bytes, "a.csv", &options(Some(robot.clone()), None)).unwrap().clips[0];
    let between = crate::resample::slerp(&clip.root_orientation[1], &clip.root_orientation[2], 50.0 / 30.0 - 1.0);
    assert!(read.root_orientation[1].angle_to(&between) < 1e-6);
}

#[test]
fn what_a_layout_does_not_hold_is_listed() {
    let mut clip = clips(&lima(), &["walk"]).remove(0);
    clip.cyclic = true;
    clip.contacts = Some(Contacts { names: vec!["left_foot".into()], flags: vec![true; clip.len()] });
    clip.provenance.captions.clear();
    let of = |name: &str| lost(&clip, by_name(name).unwrap());
    let provenance = "source and licence";
    assert_eq!(of("lafan1"), ["names of joints", "contacts", "rate", "flag of a cycle", provenance]);
    assert_eq!(of("protomotions"), ["names of joints", "flag of a cycle", provenance]);
    assert_eq!(of("csv"), ["contacts", "flag of a cycle", provenance]);
    let error = write(&clip, by_name("mjlab").unwrap(), None).unwrap_err().to_string();
    assert!(error.contains("--robot"), "{error}");
    let error = write(&clip, by_name("lafan1").unwrap(), None).unwrap_err().to_string();
    assert!(error.contains("--robot"), "{error}");
}

#[test]
fn a_bvh_has_the_robots_bodies_where_its_kinematics_puts_them() {
    let robot = lima();
    let clip = &clips(&robot, &["walk"])[0];
    let bytes = write(clip, by_name("bvh").unwrap(), Some(&robot)).unwrap();
    let options = ReadOptions { scale: Some(0.01), skip_frames: Some(0), t_pose: false, ..ReadOptions::default() };
    let source = super::super::bvh::parse(&bytes, Path::new("walk.bvh"), &options).unwrap();
    assert_eq!((source.len(), source.fps), (clip.len(), 50.0));
    let mut kinematics = lifelike_character::Kinematics::new(&robot);
    let (columns, mut q) = (clip.columns_for(&robot).unwrap(), robot.reference_position());
    for frame in (0..clip.len()).step_by(20) {
        clip.write_position(&robot, &columns, frame, &mut q);
        kinematics.update(&robot, &q);
        let (places, _) = source.pose(frame);
        for (body, place) in robot.bodies.iter().zip(&kinematics.body_position).skip(1) {
            // The reader adds hands at ends.
            let joint = source.skeleton.names.iter().position(|name| *name == body.name).unwrap();
            assert!((places[joint] - place).norm() < 1e-6, "{} in frame {frame}", body.name);
        }
    }
}

/// Outcome of a detection.
#[derive(Default)]
struct Count {
    right: usize,
    refused: usize,
    wrong: usize,
}

/// Turns a clip about the vertical.
fn turned(clip: &MotionClip, angle: f64) -> MotionClip {
    let turn = Quat::from_axis_angle(&Vec3::z_axis(), angle);
    let mut clip = clip.clone();
    clip.root_position.iter_mut().for_each(|place| *place = turn * *place);
    clip.root_orientation.iter_mut().for_each(|orientation| *orientation = turn * *orientation);
    clip
}

fn detect(clip: &MotionClip, layout: &Layout, writer: &Character, reader: Option<Arc<Character>>, count: &mut Count) {
    let bytes = write(clip, layout, Some(writer)).unwrap();
    match open(&bytes, "clip", &options(reader, None)) {
        Ok(reading) if reading.layout.name == layout.name => count.right += 1,
        Ok(_) => count.wrong += 1,
        Err(error) => {
            let error = error.to_string();
            assert!(error.contains("--layout") || error.contains("--robot"), "{}: {error}", layout.name);
            count.refused += 1;
        }
    }
}

#[test]
fn no_layout_is_taken_for_another() {
    let robot = lima();
    let names =
        ["walk", "walk_backward", "walk_curve", "turn_around_180", "side_bend", "squat", "idle_breathing", "wave"];
    let clips: Vec<MotionClip> = clips(&robot, &names);
    assert_eq!(clips.len(), names.len());
    let mut table = String::from("layout, then with and without the robot: right, refused, wrong\n");
    for layout in LAYOUTS.iter().filter(|layout| !matches!(layout.name, "bvh" | "glb")) {
        let [mut with, mut without] = [Count::default(), Count::default()];
        for clip in &clips {
            for turn in [0.0, 0.5, 1.0, 1.5].map(|turn| turn * std::f64::consts::PI) {
                let clip = turned(clip, turn);
                detect(&clip, layout, &robot, Some(robot.clone()), &mut with);
                detect(&clip, layout, &robot, None, &mut without);
            }
        }
        let words = |count: &Count| format!("{} {} {}", count.right, count.refused, count.wrong);
        writeln!(table, "{:14} {:12} {}", layout.name, words(&with), words(&without)).unwrap();
        assert_eq!((with.wrong, without.wrong), (0, 0), "{table}");
        let is_told = !["lafan1", "kimodo"].contains(&layout.name);
        assert!(!is_told || with.refused == 0, "{table}");
    }
    println!("{table}");
}

/// Returns a pickle of protocol 2 with this program.
fn pickle(program: &[u8]) -> Vec<u8> {
    [b"\x80\x02", program, b"."].concat()
}

#[test]
fn hostile_pickles_are_refused_and_nothing_is_executed() {
    let nested = [b"]".repeat(200_000), b"a".repeat(199_999)].concat();
    let text = |text: &str| [b"X", &(text.len() as u32).to_le_bytes()[..], text.as_bytes()].concat();
    let doubled = [b"]q\x00".to_vec(), b"h\x00h\x00\x86q\x00".repeat(1000)].concat();
    let many = [b"(".repeat(5_000_000), b"t".to_vec()].concat();
    let encoded =
        [text(&"a".repeat(1 << 20)), b"q\x00".to_vec(), b"0c_codecs\nencode\nh\x00\x85R".repeat(1000)].concat();
    let cases: [(&str, Vec<u8>, &str); 14] = [
        ("os.system", [b"cos\nsystem\n".to_vec(), text("touch hacked"), b"\x85R".to_vec()].concat(), "os.system"),
        ("eval", [b"c__builtin__\neval\n".to_vec(), text("1"), b"\x85R".to_vec()].concat(), "__builtin__.eval"),
        ("by stack", [text("posix"), text("system"), b"\x93".to_vec()].concat(), "posix.system"),
        ("attribute", [b"cnumpy\nndarray.tofile\n".to_vec()].concat(), "numpy.ndarray.tofile"),
        ("new object", b"cnumpy\nndarray\n)\x81".to_vec(), "0x81"),
        ("instance", b"(ios\nsystem\n".to_vec(), "0x69"),
        ("extension", b"\x82\x01".to_vec(), "0x82"),
        ("a class called", b"cnumpy\nndarray\n)R".to_vec(), "a call of Ndarray"),
        ("huge length", b"X\xff\xff\xff\xff".to_vec(), "the end of the file"),
        ("huge length of 8 bytes", [&[0x8e][..], &[0xff; 8]].concat(), "the end of the file"),
        ("deep nesting", nested, "no dict"),
        ("doubling memo", doubled, "no dict"),
        ("many operations", many, "more than 4000000 operations"),
        ("copies of a text", encoded, "a text is expected"),
    ];
    for (name, program, part) in cases {
        let error = open(&pickle(&program), "a.pkl", &options(None, None)).unwrap_err().to_string();
        assert!(error.contains(part) && error.len() < 1000, "{name}: {error}");
    }
    assert!(!Path::new("hacked").exists());
    let shape = b"cnumpy.core.multiarray\n_reconstruct\ncnumpy\nndarray\nK\x00\x85C\x01b\x87R(K\x01J\xff\xff\xff\x7fJ\xff\xff\xff\x7f\x86";
    let dtype =
        [b"cnumpy\ndtype\n".to_vec(), text("f8"), b"\x89\x88\x87R\x89C\x08".to_vec(), vec![0; 8], b"tb".to_vec()]
            .concat();
    let entry = |name: &str| [text(name), shape.to_vec(), dtype.clone()].concat();
    let huge = [b"}(".to_vec(), entry("root_pos"), entry("root_rot"), entry("dof_pos"), b"u".to_vec()].concat();
    let error = open(&pickle(&huge), "a.pkl", &options(None, Some("gmr"))).unwrap_err().to_string();
    assert!(error.contains("root_rot") && error.contains("2147483647"), "{error}");
}

#[test]
fn other_contents_are_refused_with_a_cure() {
    let message =
        |bytes: &[u8], layout: Option<&str>| open(bytes, "a.csv", &options(None, layout)).unwrap_err().to_string();
    let rows = |row: &str| format!("{row}\n{row}\n");
    let zeros = ",0".repeat(19);
    assert!(message(rows(&format!("0,0,1,0,0,0,1{zeros}")).as_bytes(), Some("lafan1")).contains("--robot ROBOT"));
    assert!(message(rows("0,0,1,0,0,0,2,0").as_bytes(), None).contains("no unit quaternion"));
    assert!(message(rows("0,0,1,0,0,0,nan,0").as_bytes(), None).starts_with("a.csv:1: expected a number, got nan"));
    assert!(message(b"0,0,1,0,0,0,1,0\n0,0,1\n", None).starts_with("a.csv:2: expected 8 columns"));
    assert!(message(b"a,b,c,d,e,f,g,h\n1,2,3,4,5,6,7,8\n", None).contains("8 columns: a b c"));
    assert!(message(b"", None).contains("rows of numbers"));
    let error = message(FIXTURES[3].2, None);
    assert!(
        error.contains("29 joints of the G1; --robot ROBOT names the joints of another, got 20 joints without names"),
        "{error}"
    );
    // Another robot's kinematics.
    let mut other = (*lima()).clone();
    other.bodies.iter_mut().skip(2).for_each(|body| body.position *= 1.5);
    let error = open(FIXTURES[3].2, "a.npz", &options(Some(Arc::new(other)), None)).unwrap_err().to_string();
    assert!(error.contains("m from where the joints of lima put them"), "{error}");
    assert!(by_name("lafan").unwrap_err().contains("lafan1, kimodo, bones-seed"));
}

#[test]
fn a_file_that_is_cut_off_is_refused() {
    for (layout, file, bytes) in &FIXTURES[3..] {
        for end in (0..bytes.len()).step_by(97) {
            let result = open(&bytes[..end], file, &options(Some(lima()), Some(layout)));
            assert!(result.is_err(), "{file} cut at {end}");
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn damaged_files_never_panic(which in 0..FIXTURES.len(), spots in prop::collection::vec((0.0..1.0_f64, any::<u8>()), 1..6)) {
        let (_, file, bytes) = FIXTURES[which];
        let mut bytes = bytes.to_vec();
        for (place, byte) in spots {
            let at = (place * bytes.len() as f64) as usize;
            bytes[at] = byte;
        }
        let _ = open(&bytes, file, &options(None, None));
    }

    #[test]
    fn random_pickles_never_panic(program in prop::collection::vec(prop::sample::select(b"(01N\x88\x89JKMG])t\x85\x86\x87}aesuhqcR bBQX.\x00\x01\x02".to_vec()), 0..200)) {
        let _ = open(&pickle(&program), "a.pkl", &options(None, None));
    }
}

#[test]
fn tables_of_other_programs_are_the_same_table() {
    let text = std::str::from_utf8(FIXTURES[0].2).unwrap();
    let opened = |text: &str| {
        let options = options(Some(lima()), Some("lafan1"));
        open(text.as_bytes(), "walk.csv", &options).map(|mut reading| reading.clips.remove(0))
    };
    let plain = opened(text).unwrap();
    let columns = text.lines().next().unwrap().split(',').count();
    let numbers: Vec<String> = (0..columns).map(|column| column.to_string()).collect();
    for (what, other) in [
        ("semicolons", text.replace(',', ";")),
        ("tabs", text.replace(',', "\t")),
        ("spaces of NumPy", text.replace(',', " ")),
        ("a comment of NumPy", format!("# x,y,z\n{text}")),
        ("decimal commas", text.replace(',', ";").replace('.', ",")),
        ("names of pandas", format!("{}\n{text}", numbers.join(","))),
        ("a byte order mark", format!("\u{feff}{text}")),
    ] {
        let clip = opened(&other).unwrap_or_else(|error| panic!("{what}: {error}"));
        let same = clip.root_position == plain.root_position && clip.root_orientation == plain.root_orientation;
        assert!(same && clip.joints == plain.joints, "{what}");
    }
    let error = opened(&text.replacen('\n', ",\n", 1)).unwrap_err().to_string();
    assert!(error.contains("walk.csv:1") || error.contains("walk.csv:2"), "{error}");
    let error = open(&[0x1f, 0x8b, 8, 0], "walk.csv.gz", &ReadOptions::default()).unwrap_err().to_string();
    assert!(error.contains("a compressed file"), "{error}");
    let error = open(&[0x80, 2, 0x8a, 10, 0], "walk.motion", &ReadOptions::default()).unwrap_err().to_string();
    assert!(error.contains("PyTorch before 1.6"), "{error}");
    for older in [&b"(dp0\nVfps\n"[..], b"}q\x00(U\x03fps"] {
        let error = open(older, "walk.pkl", &ReadOptions::default()).unwrap_err().to_string();
        assert!(error.contains("a pickle of protocol 2 or later"), "{error}");
    }
}

/// Returns a motion of lima in a layout, as text.
fn table_of(layout: &str) -> String {
    let clip = &open(FIXTURES[0].2, "a.csv", &options(Some(lima()), Some("lafan1"))).unwrap().clips[0];
    String::from_utf8(write(clip, by_name(layout).unwrap(), Some(&lima())).unwrap()).unwrap()
}

#[test]
fn a_table_that_contradicts_itself_is_refused_by_its_row() {
    let refused = |text: String, part: &str| {
        let error = open(text.as_bytes(), "a.csv", &options(Some(lima()), None)).unwrap_err().to_string();
        assert!(error.contains(part), "{error}");
    };
    let without = |text: &str, row: usize| {
        let lines: Vec<&str> = text.lines().enumerate().filter(|(at, _)| *at != row).map(|(_, line)| line).collect();
        lines.join("\n")
    };
    let (bones, ours, rows) = (table_of("bones-seed"), table_of("csv"), table_of("lafan1"));
    // The rows of a head of names begin with the second line.
    refused(without(&bones, 3), "a column 'Frame' that rises evenly, got 3 after 1 in row 3");
    refused(without(&ours, 3), "rise evenly, got 0.1 s after 0.03333333333333333 s in row 3");
    let second = rows.lines().nth(1).unwrap();
    let cells: Vec<&str> = second.split(',').collect();
    let zero = [&cells[..3], &["0"; 4], &cells[7..]].concat().join(",");
    refused(rows.replace(second, &zero), "no unit quaternion in columns 4 to 7 of row 2");
    // Every second row of 120 a second.
    let half = [0, 1, 3, 5].map(|row| bones.lines().nth(row).unwrap()).join("\n");
    let reading = open(half.as_bytes(), "a.csv", &options(None, None)).unwrap();
    assert_eq!((reading.clips[0].fps, reading.clips[0].len()), (60.0, 3));
    let more = bones.lines().map(|line| format!("{line},{}", if line.starts_with("Frame") { "gait" } else { "1" }));
    let reading = open(more.collect::<Vec<_>>().join("\n").as_bytes(), "a.csv", &options(None, None)).unwrap();
    assert_eq!(reading.left_out, ["gait"]);
}

#[test]
fn bodies_that_contradict_the_joints_are_refused() {
    let robot = lima();
    let clip = open(FIXTURES[0].2, "a.csv", &options(Some(robot.clone()), Some("lafan1"))).unwrap().clips.remove(0);
    for layout in ["wbc", "holosoma", "protomotions"] {
        let layout = by_name(layout).unwrap();
        let bytes = write(&clip, layout, Some(&robot)).unwrap();
        assert!(open(&bytes, "a", &options(Some(robot.clone()), None)).is_ok(), "{}", layout.name);
        // A robot whose limbs hang elsewhere reads the same joints.
        let mut other = (*robot).clone();
        other.bodies.iter_mut().skip(2).for_each(|body| body.position *= 2.0);
        let other = Arc::new(other);
        let error = open(&bytes, "a", &options(Some(other.clone()), None)).unwrap_err().to_string();
        let cure = format!("--layout {} to read it nevertheless", layout.name);
        assert!(error.contains("m from where the joints of lima put them") && error.contains(&cure), "{error}");
        let reading = open(&bytes, "a", &options(Some(other), Some(layout.name))).unwrap();
        assert!(reading.said.contains("; but it has bodies that are"), "{}", reading.said);
    }
}
