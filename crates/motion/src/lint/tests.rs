//! Clips that are known, each broken in a way that is known.

#![allow(clippy::unwrap_used)]

use std::collections::BTreeMap;
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::path::Path;

use lifelike_character::rotation::to_wxyz;
use lifelike_character::{Anatomy, Character, Quat, Vec3};

use super::columns::JointOrder;
use super::*;
use crate::keyframes;
use crate::retarget::{RetargetOptions, retarget};

fn robot(name: &str) -> (Character, Anatomy) {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../../robots/{name}.xml"));
    let character = Character::load(file).unwrap();
    let anatomy = Anatomy::guess(&character, &Default::default()).unwrap();
    (character, anatomy)
}

fn own(name: &str, text: &str, (character, anatomy): &(Character, Anatomy)) -> MotionClip {
    let source = keyframes::parse(text.as_bytes(), Path::new(name)).unwrap();
    retarget(&source, character, anatomy, &RetargetOptions::default()).unwrap().0
}

/// Names of columns that hold the joints in another order.
fn permuted(clip: &MotionClip, order: &[usize]) -> MotionClip {
    let width = order.len();
    let joints = clip.joints.chunks_exact(width).flat_map(|row| order.iter().map(|&joint| row[joint])).collect();
    MotionClip { joints, ..clip.clone() }
}

/// The joints level after level, by hand for Lima: yaw of every limb first.
const LIMA_LEVELS: [&str; 20] = [
    "left_hip_yaw",
    "right_hip_yaw",
    "neck_yaw",
    "left_shoulder_pitch",
    "right_shoulder_pitch",
    "left_hip_roll",
    "right_hip_roll",
    "neck_pitch",
    "left_shoulder_roll",
    "right_shoulder_roll",
    "left_hip_pitch",
    "right_hip_pitch",
    "left_shoulder_yaw",
    "right_shoulder_yaw",
    "left_knee",
    "right_knee",
    "left_elbow",
    "right_elbow",
    "left_ankle_pitch",
    "right_ankle_pitch",
];

type Broken = (&'static str, Mistake, MotionClip);

fn broken(clip: &MotionClip) -> Vec<Broken> {
    let with = |change: &dyn Fn(&mut MotionClip)| {
        let mut out = clip.clone();
        change(&mut out);
        out
    };
    let width = clip.joint_names.len();
    let column = |name: &str| clip.joint_names.iter().position(|n| n == name).unwrap();
    let levels: Vec<usize> = LIMA_LEVELS.iter().map(|name| column(name)).collect();
    let other = |name: &String| {
        if name.contains("left") { name.replace("left", "right") } else { name.replace("right", "left") }
    };
    let sides: Vec<usize> = clip.joint_names.iter().map(|name| column(&other(name))).collect();
    let elbow = column("left_elbow");
    let scaled = |factor: f64| with(&|c| c.root_position.iter_mut().for_each(|p| *p *= factor));
    let raised = |metres: f64| with(&|c| c.root_position.iter_mut().for_each(|p| p.z += metres));
    let laid = |angle: f64| {
        with(&|c| {
            let lay = Quat::from_axis_angle(&Vec3::x_axis(), angle);
            c.root_position.iter_mut().for_each(|p| *p = lay * *p);
            c.root_orientation.iter_mut().for_each(|q| *q = lay * *q);
        })
    };
    vec![
        ("y down", Mistake::YDown, laid(FRAC_PI_2)),
        ("z down", Mistake::ZDown, laid(PI)),
        ("feet", Mistake::Units { metres: 0.3048 }, scaled(1.0 / 0.3048)),
        ("other signs", Mistake::Negated, with(&|c| c.joints.iter_mut().for_each(|a| *a = -*a))),
        (
            "depth first",
            Mistake::Columns(JointOrder::DepthFirst),
            with(&|c| c.joint_names = LIMA_LEVELS.iter().map(|name| (*name).to_owned()).collect()),
        ),
        (
            "xyzw",
            Mistake::QuaternionOrder,
            with(&|c| {
                for q in &mut c.root_orientation {
                    let [w, x, y, z] = to_wxyz(q);
                    *q = Quat::new_normalize(nalgebra::Quaternion::new(x, y, z, w));
                }
            }),
        ),
        (
            "y up",
            Mistake::YUp,
            with(&|c| {
                let lay = Quat::from_axis_angle(&Vec3::x_axis(), -FRAC_PI_2);
                c.root_position.iter_mut().for_each(|p| *p = Vec3::new(p.x, p.z, -p.y));
                c.root_orientation.iter_mut().for_each(|q| *q = lay * *q);
            }),
        ),
        ("centimetres", Mistake::Units { metres: 0.01 }, scaled(100.0)),
        ("millimetres", Mistake::Units { metres: 0.001 }, scaled(1000.0)),
        ("inches", Mistake::Units { metres: 0.0254 }, scaled(1.0 / 0.0254)),
        ("degrees", Mistake::Degrees, with(&|c| c.joints.iter_mut().for_each(|a| *a = a.to_degrees()))),
        ("frame time", Mistake::FrameTime, with(&|c| c.fps = 0.02)),
        (
            "turn now and then",
            Mistake::WholeTurns,
            with(&|c| c.joints.iter_mut().skip(5).step_by(7).for_each(|a| *a += TAU)),
        ),
        (
            "turn of a joint",
            Mistake::WholeTurns,
            with(&|c| c.joints.iter_mut().skip(elbow).step_by(width).for_each(|a| *a -= TAU)),
        ),
        ("exchanged sides", Mistake::Columns(JointOrder::OtherSide), permuted(clip, &sides)),
        ("breadth first", Mistake::Columns(JointOrder::BreadthFirst), permuted(clip, &levels)),
        ("reversed", Mistake::Columns(JointOrder::Reversed), permuted(clip, &(0..width).rev().collect::<Vec<_>>())),
        ("floats", Mistake::Height { metres: -0.05 }, raised(0.05)),
        ("sunk", Mistake::Height { metres: 0.05 }, raised(-0.05)),
        (
            "sign flips",
            Mistake::SignFlips,
            with(&|c| c.root_orientation.iter_mut().step_by(3).for_each(|q| *q = Quat::new_unchecked(-q.into_inner()))),
        ),
    ]
}

/// Returns whether the two are the same mistake; heights differ by what the clip itself floats.
fn same(a: Mistake, b: Mistake) -> bool {
    match (a, b) {
        (Mistake::Height { metres: a }, Mistake::Height { metres: b }) => (a - b).abs() < 0.02,
        (a, b) => a == b,
    }
}

/// Every third clip stands for the rest where each is tried in many ways: 90 of each mistake are left.
const SAMPLE: usize = 3;

#[test]
fn own_clips_have_no_mistakes() {
    for (name, every) in [("lima", 1), ("humanoid", SAMPLE)] {
        let robot = robot(name);
        for (title, text) in keyframes::builtin().step_by(every) {
            let clip = own(title, text, &robot);
            let (out, flaws) = lint(&clip, &robot.0, &robot.1).unwrap();
            assert_eq!(flaws, [], "{title} on {name}");
            assert_eq!(out, clip, "a clip without mistakes stays to the bit");
        }
    }
}

#[test]
fn broken_clips_are_named_and_repaired() {
    let robot = robot("lima");
    let mut found: BTreeMap<&str, (usize, usize)> = BTreeMap::new();
    let mut wrong = Vec::new();
    for (title, text) in keyframes::builtin().step_by(SAMPLE) {
        let clip = own(title, text, &robot);
        for (how, mistake, broken) in broken(&clip) {
            let (repaired, flaws) = lint(&broken, &robot.0, &robot.1).unwrap();
            let right = matches!(flaws.as_slice(), [flaw] if same(flaw.mistake, mistake));
            let (rights, all) = found.entry(how).or_default();
            (*rights, *all) = (*rights + usize::from(right), *all + 1);
            if !right {
                wrong.push(format!("{how} {title}: {:?}", flaws.iter().map(Flaw::words).collect::<Vec<_>>()));
                continue;
            }
            // A float of millimetres is the clip's own.
            let far = repaired.root_position.iter().zip(&clip.root_position).map(|(a, b)| (a - b).norm());
            assert!(far.fold(0.0, f64::max) < 0.02, "{how} {title}");
            let (width, names) = (clip.joint_names.len(), &clip.joint_names);
            let places: Vec<usize> =
                names.iter().map(|name| repaired.joint_names.iter().position(|n| n == name).unwrap()).collect();
            for (row, want) in repaired.joints.chunks_exact(width).zip(clip.joints.chunks_exact(width)) {
                let is_same = places.iter().zip(want).all(|(place, angle)| (row[*place] - angle).abs() < 1e-9);
                assert!(is_same, "{how} {title}");
            }
        }
    }
    println!("{found:?}");
    // A body is nearly its own mirror image: exchanged sides show in the slip of soles only, and not where both move alike.
    let missed = found.iter().filter(|(how, (rights, all))| **how != "exchanged sides" && 100 * rights < 95 * all);
    assert_eq!(missed.count(), 0, "{found:?}\n{}", wrong.join("\n"));
}
