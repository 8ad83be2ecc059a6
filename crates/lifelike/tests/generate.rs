//! `lifelike train generator` and `lifelike generate`: a tiny training, its file, motion from it, and what is refused.

#![cfg(feature = "learning")]
#![allow(clippy::unwrap_used)]

use std::path::Path;
use std::process::{Command, Output};

use lifelike_motion::container;
use serde_json::Value;

const TINY: [&str; 12] = [
    "width=16",
    "layers=1",
    "heads=2",
    "inner=16",
    "pieces=150",
    "batch=4",
    "iterations=6",
    "diffusion_steps=8",
    "max_seconds=3.0",
    "warmup=0",
    "validate_every=3",
    "clips=[\"builtin\"]",
];

fn run(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_lifelike")).args(arguments).current_dir(folder).output().unwrap()
}

fn json(folder: &Path, arguments: &[&str]) -> Value {
    let output = run(folder, &[&["--json"], arguments].concat());
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

fn refused(folder: &Path, arguments: &[&str]) -> String {
    let output = run(folder, arguments);
    assert_eq!(output.status.code(), Some(3), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stderr).unwrap()
}

#[test]
fn a_sentence_becomes_a_clip_and_what_is_none_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let plan = ["train", "generator", "--plan", "generator", "-o", "run"];
    let trained = json(at, &[&plan[..], &TINY].concat());
    assert_eq!(trained["iterations"], 6);
    let generator = "run/motion.generator.safetensors";

    let words = ["generate", "a person walks", "--generator", generator, "--seconds", "1"];
    let make = |more: &[&str]| json(at, &[&words[..], more].concat());
    let made = make(&["-o", "walk.motion.safetensors", "--seed", "3"]);
    assert_eq!(made["files"], serde_json::json!(["walk.motion.safetensors"]));
    let clip = container::read(&at.join("walk.motion.safetensors")).unwrap();
    assert_eq!((clip.name.as_str(), clip.len(), clip.fps), ("walk", 51, 50.0));
    assert_eq!(clip.provenance.captions[0].text, "a person walks");
    make(&["-o", "again.motion.safetensors", "--seed", "3"]);
    assert_eq!(container::read(&at.join("again.motion.safetensors")).unwrap().joints, clip.joints);
    let many = make(&["-o", "many.motion.safetensors", "--candidates", "2", "--steps", "3"]);
    assert_eq!(many["files"][1], "many-1.motion.safetensors");
    json(at, &["motion", "check", "walk.motion.safetensors", "--robot", "lima"]);

    let with = |prompt: &str, more: &[&str]| {
        let words = ["generate", prompt, "--generator", generator, "-o", "x.motion.safetensors"];
        refused(at, &[&words[..], more].concat())
    };
    assert!(with("", &[]).contains("prompt"));
    assert!(with("walk\u{7}", &[]).contains("prompt"));
    assert!(with(&"walk ".repeat(5000), &[]).contains("prompt"));
    assert!(with("a person walks", &["--seconds", "60"]).contains("0.5 to 3"));
    assert!(with("a person walks", &["--steps", "9"]).contains("1 to 8"));
    assert!(with("a person walks", &["--robot", "humanoid"]).contains("train one for it"));
    assert!(!at.join("x.motion.safetensors").exists());
    let none = ["generate", "a person walks", "--generator", "walk.motion.safetensors", "-o", "x.motion.safetensors"];
    assert!(refused(at, &none).contains("walk.motion.safetensors"));
}

#[test]
fn plans_name_what_is_wrong() {
    let folder = tempfile::tempdir().unwrap();
    let plan =
        |change: &str| refused(folder.path(), &["train", "generator", "--plan", "generator", "-o", "run", change]);
    assert!(plan("batch=0").contains("batch: expected 1 to 65536, got 0"));
    assert!(plan("heads=3").contains("heads"));
    assert!(plan("clips=[\"nowhere\"]").contains("nowhere"));
    assert!(plan("space.kind=\"bezier\"").contains("bezier"));
}
