//! Promises of conversions about themselves: what is not the captured motion is refused, what follows nothing is named.
use std::path::Path;

use lifelike_character::{Anatomy, Character, Role};
use lifelike_motion::retarget::{Bounds, RetargetOptions, retarget};
use lifelike_motion::{SourceClip, keyframes};

fn humanoid() -> (Character, Anatomy) {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../robots/humanoid.xml");
    let character = Character::load(file).unwrap();
    let anatomy = Anatomy::guess(&character, &Default::default()).unwrap();
    (character, anatomy)
}

fn own(name: &str) -> SourceClip {
    let (_, text) = keyframes::builtin().find(|(n, _)| *n == name).unwrap();
    keyframes::parse(text.as_bytes(), Path::new(name)).unwrap()
}

/// Keeps the joints for which the predicate holds; their parents must be kept too.
fn keep(clip: &mut SourceClip, wanted: impl Fn(&str) -> bool) {
    let skeleton = &mut clip.skeleton;
    let kept: Vec<usize> = (0..skeleton.names.len()).filter(|&j| wanted(&skeleton.names[j])).collect();
    let new = |old: usize| kept.iter().position(|&j| j == old);
    skeleton.parents = kept.iter().map(|&j| skeleton.parents[j].map(|p| new(p).unwrap())).collect();
    skeleton.offsets = kept.iter().map(|&j| skeleton.offsets[j]).collect();
    skeleton.ends = skeleton.ends.iter().filter_map(|(j, offset)| Some((new(*j)?, *offset))).collect();
    for row in &mut clip.rotations {
        *row = kept.iter().map(|&j| row[j]).collect();
    }
    skeleton.names = kept.iter().map(|&j| skeleton.names[j].clone()).collect();
}

fn is_arm(name: &str) -> bool {
    let name = name.to_lowercase();
    ["arm", "elbow", "hand", "wrist", "shoulder", "clavicle", "collar"].iter().any(|word| name.contains(word))
}

#[test]
fn a_conversion_beyond_its_bounds_is_refused_with_the_options_that_accept_it() {
    let (character, anatomy) = humanoid();
    let convert = |bounds| {
        let options = RetargetOptions { bounds, ..Default::default() };
        retarget(&own("jog_in_place"), &character, &anatomy, &options)
            .map(|(_, report)| report)
            .map_err(|e| e.to_string())
    };
    let report = convert(Bounds::default()).unwrap();
    let measured = [report.mean_position_error() / 0.9, report.mean_orientation_error(), report.foot_skate.mean / 0.9];
    assert!(measured.iter().all(|error| *error > 0.0), "{measured:?}");
    let refused = convert(Bounds { position: 1e-9, angle: 1e-9, ..Bounds::default() }).unwrap_err();
    assert!(refused.contains("key bodies are off by") && refused.contains("orientations are off by"), "{refused}");
    assert!(!refused.contains("bounds.skate"), "only what is exceeded: {refused}");
    let offered = |key: &str| {
        let text = refused.split(&format!("bounds.{key}=")).nth(1).unwrap();
        text.split_whitespace().next().unwrap().parse::<f64>().unwrap()
    };
    convert(Bounds { position: offered("position"), angle: offered("angle"), ..Bounds::default() }).unwrap();
}

#[test]
fn every_own_clip_is_within_a_third_of_the_bounds() {
    let (character, anatomy) = humanoid();
    let third = Bounds { position: 0.05, angle: 8.4, skate: 0.067 };
    for (name, text) in keyframes::builtin() {
        let clip = keyframes::parse(text.as_bytes(), Path::new(name)).unwrap();
        let options = RetargetOptions { bounds: third, ..Default::default() };
        retarget(&clip, &character, &anatomy, &options).unwrap();
    }
}

#[test]
fn an_arm_that_only_one_of_the_two_has_is_named() {
    let (character, mut anatomy) = humanoid();
    let options = RetargetOptions::default();
    let whole = retarget(&own("wave"), &character, &anatomy, &options).unwrap().1;
    assert_eq!(whole.unfollowed, Vec::<String>::new());

    let mut armless = own("wave");
    keep(&mut armless, |name| !is_arm(name));
    let report = retarget(&armless, &character, &anatomy, &options).unwrap().1;
    for side in ["left", "right"] {
        let line = format!("correspondence.roles.{side}_hand=JOINT");
        assert!(report.unfollowed.iter().any(|limb| limb.contains(&line)), "{:?}", report.unfollowed);
    }

    for role in [Role::LeftUpperArm, Role::LeftForearm, Role::LeftHand, Role::RightHand] {
        anatomy.places.remove(&role);
    }
    let report = retarget(&own("wave"), &character, &anatomy, &options).unwrap().1;
    assert_eq!(report.unfollowed.len(), 2, "{:?}", report.unfollowed);
    assert!(report.unfollowed[0].starts_with("the capture's left arm"), "{:?}", report.unfollowed);
    // The waving arm's error enters the mean.
    let arm = |role| report.orientation_error[&role].mean;
    assert!(arm(Role::LeftForearm).max(arm(Role::RightForearm)) > 10.0, "{:?}", report.orientation_error);
    assert!(report.mean_orientation_error() > whole.mean_orientation_error());
}
