//! A C and a C++ program step a controller as Rust does; the header is what the source says.
#![allow(clippy::unwrap_used, clippy::expect_used)]

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Arc;

// The library is built with the test.
use lifelike_c as _;
use lifelike_robot::reference::standing_clip;
use lifelike_robot::{ClipPlayer, Controller, ControllerState, MeasuredState, ReferenceLibrary, Robot};

fn here() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

/// The folder of the library: two above the test program's.
fn libraries() -> PathBuf {
    let program = std::env::current_exe().unwrap();
    program.ancestors().nth(1).unwrap().to_path_buf()
}

fn policy() -> PathBuf {
    here().join("../lifelike/assets/lima-path.controller.safetensors")
}

/// The targets of the same steps in Rust.
fn expected() -> Vec<f32> {
    let robot = Arc::new(Robot::load("lima").unwrap());
    let controller = Controller::load(&policy(), robot.clone()).unwrap();
    let mut clip = standing_clip(&robot, 1.0);
    let pose: Vec<f32> = robot.default_pose.iter().map(|q| *q as f32).collect();
    clip.root_position = vec![lifelike_character::Vec3::new(0.0, 0.0, f64::from(0.4_f32)); 50];
    clip.root_orientation = vec![lifelike_character::Quat::identity(); 50];
    clip.joints = pose.iter().map(|q| f64::from(*q)).collect::<Vec<_>>().repeat(50);
    clip.contacts = None;
    let library = Arc::new(ReferenceLibrary::new(&robot, &[clip], None).unwrap());
    let still = vec![0.0; robot.joints()];
    let measured = MeasuredState {
        joint_position: &pose,
        joint_velocity: &still,
        root_orientation: [1.0, 0.0, 0.0, 0.0],
        root_position: Some([0.0, 0.0, 0.4]),
        linear_velocity_w: Some([0.0; 3]),
        ..MeasuredState::default()
    };
    let (mut state, mut player) = (ControllerState::new(&controller), ClipPlayer::new(library, 0));
    let mut targets = vec![0.0; robot.joints()];
    for _ in 0..50 {
        controller.step(&mut state, &measured, &mut player, &mut targets).unwrap();
    }
    targets
}

/// Compiles the program with a compiler, links the library, runs it, and returns its targets by name.
fn targets(compiler: &str, arguments: &[&str], folder: &Path) -> Vec<(String, f32)> {
    let program = folder.join(compiler);
    let built = Command::new(compiler)
        .args(arguments)
        .arg(here().join("tests/step.c"))
        .args(["-Wall", "-Wextra", "-Werror", "-o"])
        .arg(&program)
        .arg("-I")
        .arg(here().join("include"))
        .arg("-L")
        .arg(libraries())
        .args(["-llifelike_c", "-lm", "-lpthread", "-ldl"])
        .output()
        .unwrap();
    assert!(built.status.success(), "{compiler}: {}", String::from_utf8_lossy(&built.stderr));
    let run = Command::new(&program).arg(policy()).arg("lima").env("LD_LIBRARY_PATH", libraries()).output().unwrap();
    let said = String::from_utf8_lossy(&run.stderr).into_owned();
    assert!(run.status.success(), "{compiler}: {said}");
    assert!(said.contains("nowhere.controller.safetensors"), "{said}");
    let line = |line: &str| line.split_once(' ').map(|(name, target)| (name.to_string(), target.parse().unwrap()));
    String::from_utf8(run.stdout).unwrap().lines().filter_map(line).collect()
}

#[test]
#[cfg(target_os = "linux")]
fn a_program_in_c_and_one_in_cpp_get_the_targets_that_rust_gets() {
    let (folder, robot) = (tempfile::tempdir().unwrap(), Robot::load("lima").unwrap());
    let expected: Vec<(String, f32)> = robot.layout.joints.iter().cloned().zip(expected()).collect();
    assert!(expected.iter().any(|(_, target)| target.abs() > 0.05));
    assert_eq!(targets("cc", &["-std=c11"], folder.path()), expected);
    assert_eq!(targets("c++", &["-x", "c++", "-std=c++17"], folder.path()), expected);
}

#[test]
fn the_header_is_generated_from_the_source() {
    let config = cbindgen::Config {
        language: cbindgen::Language::C,
        cpp_compat: true,
        include_guard: Some("LIFELIKE_H".into()),
        documentation_style: cbindgen::DocumentationStyle::C,
        line_length: 120,
        ..cbindgen::Config::default()
    };
    let mut made = Vec::new();
    cbindgen::Builder::new()
        .with_src(here().join("src/lib.rs"))
        .with_config(config)
        .generate()
        .unwrap()
        .write(&mut made);
    let (made, path) = (String::from_utf8(made).unwrap(), here().join("include/lifelike.h"));
    if std::env::var_os("LIFELIKE_WRITE_HEADER").is_some() {
        std::fs::write(&path, &made).unwrap();
    }
    assert_eq!(std::fs::read_to_string(&path).unwrap_or_default(), made, "LIFELIKE_WRITE_HEADER=1 writes it anew");
}
