//! Promises of repairs, on Lima: motion that is wrong in one way that is known becomes motion that can be tracked.
use std::path::Path;

use lifelike_character::{Anatomy, Character, Kinematics, Quat, Vec3};
use lifelike_motion::edit::{Repaired, compare, repair};
use lifelike_motion::feasibility::Kind;
use lifelike_motion::retarget::{RetargetOptions, retarget};
use lifelike_motion::{MotionClip, keyframes};

struct Lima {
    character: Character,
    anatomy: Anatomy,
    options: RetargetOptions,
    speeds: Vec<f64>,
}

impl Lima {
    fn new() -> Self {
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../robots/lima.xml");
        let character = Character::load(file).unwrap();
        let anatomy = Anatomy::guess(&character, &Default::default()).unwrap();
        let speeds = vec![15.0; character.scalar_joints().count()];
        Self { character, anatomy, options: RetargetOptions::default(), speeds }
    }

    fn own(&self, name: &str) -> MotionClip {
        let (_, text) = keyframes::builtin().find(|(n, _)| *n == name).unwrap();
        let source = keyframes::parse(text.as_bytes(), Path::new(name)).unwrap();
        retarget(&source, &self.character, &self.anatomy, &self.options).unwrap().0
    }

    /// Two seconds of standing still.
    fn still(&self) -> MotionClip {
        let mut clip = self.own("wave");
        let (frames, width) = (101, clip.joint_names.len());
        let pose = clip.joints_at(0).to_vec();
        clip.root_position = vec![clip.root_position[0]; frames];
        clip.root_orientation = vec![clip.root_orientation[0]; frames];
        clip.joints = pose.repeat(frames);
        let contacts = clip.contacts.as_mut().unwrap();
        contacts.flags = vec![true; frames * contacts.names.len()];
        assert_eq!(clip.joints.len(), frames * width);
        clip
    }

    fn repaired(&self, clip: &MotionClip) -> (MotionClip, Repaired) {
        repair(clip, &self.character, &self.anatomy, &self.speeds, &self.options).unwrap()
    }
}

fn reasons(told: &lifelike_motion::feasibility::Feasibility) -> Vec<Kind> {
    told.reasons().map(|reason| reason.kind).collect()
}

#[test]
fn what_can_be_tracked_stays_to_the_bit() {
    let lima = Lima::new();
    let clip = lima.own("walk");
    let (out, told) = lima.repaired(&clip);
    assert_eq!(out, clip);
    assert!(told.before.trackable && told.change.root.max == 0.0 && told.change.longer == 0.0, "{told:?}");
}

#[test]
fn a_body_that_leans_too_far_leans_less_above_the_same_feet() {
    let lima = Lima::new();
    let mut clip = lima.still();
    // For a second it leans on its ankles, its feet flat, further than they reach.
    let columns = clip.columns_for(&lima.character).unwrap();
    let (mut q, mut pose) = (lima.character.reference_position(), Kinematics::new(&lima.character));
    clip.write_position(&lima.character, &columns, 0, &mut q);
    pose.update(&lima.character, &q);
    let feet: Vec<Vec3> = lima.anatomy.soles.values().map(|sole| pose.body_position[sole.body]).collect();
    let ankle = (feet[0] + feet[1]) / 2.0;
    let width = clip.joint_names.len();
    let pitches: Vec<usize> = (0..width).filter(|i| clip.joint_names[*i].ends_with("ankle_pitch")).collect();
    for t in 25..75 {
        let angle = 0.4 * (4.0 * (std::f64::consts::PI * (t - 25) as f64 / 50.0).sin()).min(1.0);
        let lean = Quat::from_axis_angle(&Vec3::y_axis(), angle);
        clip.root_position[t] = ankle + lean * (clip.root_position[t] - ankle);
        clip.root_orientation[t] = lean * clip.root_orientation[t];
        pitches.iter().for_each(|i| clip.joints[t * width + i] -= angle);
    }
    let (out, told) = lima.repaired(&clip);
    assert_eq!(reasons(&told.before).first(), Some(&Kind::Unbalanced));
    assert!(told.after.trackable, "{:?}", told.after);
    assert!(told.change.feet.mean < 5e-3 && told.change.feet.max < 0.02, "{:?}", told.change);
    assert!(told.change.root.max > 0.05 && told.change.root.max < 0.2, "{:?}", told.change);
    assert!(told.change.others.max == 0.0 && told.change.longer == 0.0 && out.len() == clip.len());
    assert!(out.provenance.source.contains("made feasible"));
    let same = compare(&clip, &out, &lima.character, &lima.anatomy, &lima.speeds, &lima.options).unwrap();
    assert_eq!((&same.after, same.change), (&told.after, told.change), "measured again from outside");
}

#[test]
fn a_jump_at_half_of_gravity_becomes_faster_and_keeps_its_poses() {
    let lima = Lima::new();
    let mut clip = lima.still();
    let (from, length) = (40, 20);
    for t in from..from + length {
        let share = (t - from) as f64 / length as f64;
        let seconds = length as f64 / 50.0;
        clip.root_position[t].z += 0.5 * 9.81 * seconds * seconds / 2.0 * share * (1.0 - share);
        clip.contacts.as_mut().unwrap().flags[2 * t..2 * t + 2].fill(false);
    }
    let (out, told) = lima.repaired(&clip);
    assert_eq!(reasons(&told.before), [Kind::Unsupported]);
    assert!(told.after.trackable, "{:?}", told.after);
    // √2 times as fast for 0.4 s, and a little around it.
    assert!(told.change.longer < -0.1 && told.change.longer > -0.3, "{:?}", told.change);
    assert!((clip.seconds() + told.change.longer - out.seconds()).abs() < 1e-9);
    assert!(told.change.legs.max < 0.02 && told.change.root.max < 0.03, "{:?}", told.change);
}

#[test]
fn what_hovers_comes_down() {
    let lima = Lima::new();
    let mut clip = lima.still();
    for t in 30..70 {
        clip.root_position[t].z += 0.04 * (std::f64::consts::PI * (t - 30) as f64 / 40.0).sin().powi(2);
    }
    // Slowly up and down again: nothing holds it, and it does not fall.
    let (_, told) = lima.repaired(&clip);
    assert_eq!(reasons(&told.before), [Kind::Unsupported]);
    assert!(told.after.trackable, "{:?}", told.after);
    assert!(told.change.root.max > 0.02 && told.change.root.max < 0.06, "{:?}", told.change);
}

#[test]
fn a_joint_that_is_too_fast_gets_more_time() {
    let lima = Lima::new();
    let mut clip = lima.still();
    let width = clip.joint_names.len();
    let elbow = clip.joint_names.iter().position(|name| name == "left_elbow").unwrap();
    let start = clip.joints[elbow];
    for t in 0..clip.len() {
        // 20 rad/s for five frames, of 15.
        clip.joints[t * width + elbow] = start - 0.4 * (t.clamp(50, 55) - 50) as f64 * 0.4;
    }
    let slow = Lima { speeds: vec![5.0; lima.speeds.len()], ..lima };
    let (_, told) = slow.repaired(&clip);
    assert_eq!(reasons(&told.before), [Kind::TooFast]);
    assert!(told.after.trackable && told.change.longer > 0.03, "{told:?}");
}

#[test]
fn what_lies_is_told_and_left() {
    let lima = Lima::new();
    let mut clip = lima.still();
    clip.root_position.iter_mut().for_each(|place| place.z -= 0.2);
    let (_, told) = lima.repaired(&clip);
    assert!(!told.after.trackable && reasons(&told.before).contains(&Kind::OtherParts), "{told:?}");
}
