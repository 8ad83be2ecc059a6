//! The commands that direct motion, as an animator meets them.

#![allow(clippy::unwrap_used, clippy::expect_used)]

use std::path::{Path, PathBuf};

use crate::in_checkout::{json, lifelike};
use serde_json::Value;

/// `lifelike motion ARGUMENTS -o FOLDER`, as JSON.
fn motion(folder: &Path, arguments: &[&str]) -> Value {
    json(&[&["motion"], arguments, &["-o", folder.to_str().unwrap()]].concat())
}

/// Its exit code and what it says.
fn refused(folder: &Path, arguments: &[&str]) -> (i32, String) {
    crate::in_checkout::refused(&[&["motion"], arguments, &["-o", folder.to_str().unwrap()]].concat())
}

fn inspect(file: &Value) -> Value {
    let output = lifelike(&["--json", "inspect", file.as_str().unwrap()]);
    serde_json::from_slice(&output.stdout).unwrap()
}

#[test]
fn a_reference_is_put_together_made_precise_and_styled() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(format!("{name}.motion.safetensors")).to_string_lossy().into_owned();
    // Thesis fig. 4.7: start, precision, stylization.
    let parts = ["sequence", "motions/turn_in_place.keys.toml", "motions/point.keys.toml@0.5..", "--fade", "0.4"];
    let start = motion(folder.path(), &[&parts[..], &["--name", "start"]].concat());
    assert_eq!(start["clip"], "start");
    let seen = inspect(&start["file"]);
    assert_eq!(seen["provenance"]["character"], "lima");
    assert!(seen["provenance"]["source"].as_str().unwrap().contains("cross-faded over 0.4 s"));

    let time = (start["seconds"].as_f64().unwrap() - 1.5).to_string();
    let key = format!("right_hand@{time}+=0.02,0.01,0.03");
    let precise = motion(folder.path(), &["place", &path("start"), "--key", &key, "--name", "precise"]);
    let placed = &precise["placed"];
    assert!(placed["keys"][0]["residual"].as_f64().unwrap() < 0.01, "{placed}");
    assert!(placed["feet_moved"].as_f64().unwrap() < 1e-3, "{placed}");

    let style = ["stylize", &path("precise"), "--joints", "head,left_arm", "--gain", "1.3", "--name", "styled"];
    let styled = motion(folder.path(), &style);
    assert_eq!(styled[0]["frames"], start["frames"]);
    assert!(PathBuf::from(styled[0]["file"].as_str().unwrap()).is_file());
}

#[test]
fn every_operation_writes_a_clip_under_its_name() {
    let folder = tempfile::tempdir().unwrap();
    let (walk, wave) = ("motions/walk.keys.toml", "motions/wave.keys.toml");
    let seconds = |value: &Value| value["seconds"].as_f64().unwrap();
    let composed = motion(folder.path(), &["compose", walk, wave, "--joints", "right_arm,head"]);
    assert_eq!((composed["clip"].as_str(), seconds(&composed)), (Some("walk+wave"), 7.8));
    let blended = motion(folder.path(), &["blend", walk, "motions/march.keys.toml", "--weight", "0.3"]);
    assert_eq!(blended["clip"], "walk~march");
    let warped = &motion(folder.path(), &["warp", wave, "--key", "1.3=2", "--key", "2.9=3.2"])[0];
    assert!(warped["clip"] == "wave-warped" && (seconds(warped) - 5.3).abs() < 0.021, "{warped}");
    let trimmed = &motion(folder.path(), &["trim", walk, "--start", "2.5", "--end", "4.5"])[0];
    assert!((seconds(trimmed) - 2.0).abs() < 1e-9);
    let mirrored = motion(folder.path(), &["mirror", wave, walk]);
    let names: Vec<&str> = mirrored.as_array().unwrap().iter().map(|m| m["clip"].as_str().unwrap()).collect();
    assert_eq!(names, ["walk-mirrored", "wave-mirrored"]);
    // An abrupt switch is told as what it is: too fast, for one step.
    let parts = ["sequence", "motions/squat.keys.toml@..1.4", wave, "--fade", "0", "--name", "abrupt"];
    let abrupt = motion(folder.path(), &parts);
    let fast = abrupt["too_fast"].as_array().unwrap();
    assert!(!fast.is_empty() && fast.iter().all(|f| f["frames"] == 1), "{fast:?}");
}

#[test]
fn what_is_wrong_is_said_precisely() {
    let folder = tempfile::tempdir().unwrap();
    let (to, wave) = (folder.path(), "motions/wave.keys.toml");
    let cases: [(&[&str], i32, &str); 10] = [
        (&["warp", wave, "--key", "2=3", "--key", "3=2.5"], 3, "2 s -> 3 s before 3 s -> 2.5 s"),
        (&["warp", wave], 2, "--speed"),
        (&["warp", wave, "--key", "2"], 2, "IN=OUT"),
        (&["place", wave, "--key", "tail@1=0,0,0"], 3, "right_hand"),
        (&["place", wave, "--key", "right_hand@1=0,0"], 2, "BODY@SECONDS"),
        (&["compose", wave, wave, "--joints", "wing"], 3, "left_arm"),
        (&["compose", "motions/walk.keys.toml", wave, "--joints", "arms", "--length", "loop"], 3, "cyclic"),
        (&["trim", wave, "--start", "9"], 3, "5.000 s"),
        (&["mirror", "motions", "--name", "one"], 2, "--name"),
        (&["sequence", "motions"], 3, "expected one clip"),
    ];
    for (arguments, code, told) in cases {
        let (got, message) = refused(to, arguments);
        assert_eq!(got, code, "{arguments:?}: {message}");
        assert!(message.contains(told), "{arguments:?}: {message}");
    }
    // A clip of one robot is not taken for another's.
    let trimmed = motion(to, &["trim", wave, "--name", "of_lima"]);
    let (code, message) = refused(to, &["mirror", trimmed[0]["file"].as_str().unwrap(), "--robot", "humanoid"]);
    assert!(code == 3 && message.contains("does not fit character 'humanoid'"), "{message}");
}
