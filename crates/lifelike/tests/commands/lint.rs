//! `lifelike motion lint` and `motion check`: motion of a robot in another convention than ours.

#![allow(clippy::unwrap_used)]

use std::path::Path;

use crate::in_checkout::{json, lifelike};
use lifelike_character::rotation::{from_wxyz, to_wxyz};
use lifelike_motion::{MotionClip, container};

fn text(output: &[u8]) -> String {
    String::from_utf8_lossy(output).into_owned()
}

/// Our walk on Lima, and a folder with a changed one.
fn changed(folder: &Path, change: impl Fn(&mut MotionClip)) -> MotionClip {
    let good = folder.join("good");
    json(&["motion", "retarget", "motions/walk.keys.toml", "-o", good.to_str().unwrap()]);
    let good = container::read(&good.join("walk.motion.safetensors")).unwrap();
    let mut bad = good.clone();
    change(&mut bad);
    container::write(&folder.join("bad/walk.motion.safetensors"), &bad).unwrap();
    good
}

#[test]
fn orders_of_quaternions_are_told_apart_and_repaired() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_string();
    // Written as xyzw and read as wxyz a walk goes backwards.
    let good = changed(folder.path(), |clip| {
        for turn in &mut clip.root_orientation {
            let [w, x, y, z] = to_wxyz(turn);
            *turn = from_wxyz([x, y, z, w]).unwrap();
        }
    });
    assert!(text(&lifelike(&["motion", "check", &at("bad")]).stdout).contains("root orientations are xyzw, not wxyz"));
    assert_eq!(text(&lifelike(&["motion", "check", &at("bad"), "--list-trackable"]).stdout).trim(), "");

    let found = lifelike(&["motion", "lint", &at("bad")]);
    assert_eq!(found.status.code(), Some(3), "{}", text(&found.stdout));
    assert!(text(&found.stderr).contains("--fix -o FOLDER"), "{}", text(&found.stderr));
    let fixed = json(&["motion", "lint", &at("bad"), "--fix", "-o", &at("fixed")]);
    assert_eq!(fixed[0]["mistakes"][0]["mistake"], "quaternion_order");
    let read = container::read(&folder.path().join("fixed/walk.motion.safetensors")).unwrap();
    let apart = read.root_orientation.iter().zip(&good.root_orientation).map(|(a, b)| a.angle_to(b));
    assert!(apart.fold(0.0, f64::max) < 1e-7);
    assert_eq!(lifelike(&["motion", "lint", &at("fixed")]).status.code(), Some(0));
}

#[test]
fn a_frame_time_in_the_place_of_a_rate_is_refused_and_repaired() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_string();
    let good = changed(folder.path(), |clip| clip.fps = 0.02);
    let refused = lifelike(&["motion", "check", &at("bad")]);
    assert_eq!(refused.status.code(), Some(3));
    assert!(text(&refused.stderr).contains("makes it 50.000 frames per second"), "{}", text(&refused.stderr));
    json(&["motion", "lint", &at("bad"), "--fix", "-o", &at("fixed")]);
    let read = container::read(&folder.path().join("fixed/walk.motion.safetensors")).unwrap();
    assert_eq!(read, good);
}

#[test]
fn an_elbow_beyond_its_range_is_no_trackable_clip() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path().join("bad").to_str().unwrap().to_string();
    changed(folder.path(), |clip| {
        let width = clip.joint_names.len();
        let elbow = clip.joint_names.iter().position(|name| name == "left_elbow").unwrap();
        clip.joints.iter_mut().skip(elbow).step_by(width).for_each(|angle| *angle = -3.5);
    });
    let checked = json(&["motion", "check", &at]);
    let finding = &checked[0]["feasibility"]["findings"][0];
    assert_eq!((&finding["kind"], &finding["part"]), (&"beyond_range".into(), &"left_elbow".into()));
    assert!(text(&lifelike(&["motion", "check", &at]).stdout).contains("left elbow"));
}

#[test]
fn a_conversion_says_what_lint_would_find() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_string();
    changed(folder.path(), |clip| clip.joints.iter_mut().for_each(|angle| *angle = angle.to_degrees()));
    let [bad, table, back] = ["bad/walk.motion.safetensors", "walk.csv", "back.motion.safetensors"].map(at);
    assert!(lifelike(&["motion", "convert", &bad, &table, "--to", "csv"]).status.success());
    let done = lifelike(&["motion", "convert", &table, &back, "--robot", "lima"]);
    let said = text(&done.stdout);
    assert!(done.status.success() && said.contains("warning: joint angles are in degrees, not radians"), "{said}");
    // A motion is no policy, and no text.
    let refused = lifelike(&["eval", "--policy", &bad, "--motions", &bad, "-o", &at("report")]);
    assert!(text(&refused.stderr).contains("a motion, where a network is expected"), "{}", text(&refused.stderr));
    let refused = lifelike(&["play", &bad]);
    assert!(text(&refused.stderr).contains("expected text in UTF-8, got another kind of file"));
}
