//! Policies of other stacks at the command: out, looked at, and in again.

#![allow(clippy::unwrap_used, clippy::expect_used)]

use std::path::Path;

use crate::in_checkout::{TINY, err, json, lifelike, out};

/// The 154 inputs that a robot has by itself, for Lima.
const TERMS: &str = r#"
[inputs]
frame = false
terms = [
    "reference_joint_position",
    "reference_joint_velocity",
    "anchor_orientation_b",
    "root_angular_velocity_b",
    "joint_position",
    "joint_velocity",
    "last_action",
]
anchor_body = "head"
[action]
base = "unclamped"
scale = 0.5
"#;

/// A policy that has hardly learnt anything, in a run's folder.
fn trained(folder: &Path) -> String {
    let plan = folder.join("terms.toml");
    std::fs::write(&plan, format!("{}{TERMS}", TINY.replace("steps = 128", "steps = 4096"))).unwrap();
    let run = folder.join("run").display().to_string();
    json(&["train", "tracker", "--plan", plan.to_str().unwrap(), "-o", &run]);
    run
}

#[test]
fn a_policy_goes_out_to_a_stack_and_comes_in_as_a_controller_that_runs() {
    let folder = tempfile::tempdir().unwrap();
    let run = trained(folder.path());
    let file = |name: &str| folder.path().join(name).display().to_string();
    let clip = file("nod.motion.safetensors");
    json(&["motion", "retarget", "motions/nod.keys.toml", "-o", folder.path().to_str().unwrap()]);
    for (stack, policy) in [("mjlab", "policy.onnx"), ("holosoma", "policy.onnx"), ("unitree", "exported/policy.onnx")]
    {
        let made = json(&["export", &run, "--for", stack, "--motions", &clip, "-o", &file(stack)]);
        let first = made["files"][0].as_str().unwrap();
        assert!(first.ends_with(policy) && Path::new(first).is_file(), "{made}");
        let terms: Vec<&str> = made["observation"].as_array().unwrap().iter().map(|t| t[0].as_str().unwrap()).collect();
        let is_alphabetical = terms.is_sorted();
        assert_eq!(is_alphabetical, stack == "holosoma", "the order is the stack's: {terms:?}");
    }
    let onnx = file("holosoma/policy.onnx");
    let looked = out(&lifelike(&["inspect", &onnx]));
    assert!(looked.contains("a policy of holosoma") && looked.contains("anchor_orientation_b"), "{looked}");
    let controller = file("back.controller.safetensors");
    // It falls wherever it is, which its normalizer has seen.
    let imported = json(&["import", &onnx, "--force", "-o", &controller]);
    assert_eq!(imported["robot"], "lima");
    let motion = imported["motion"].as_str().unwrap();
    let evaluated = json(&["eval", "--policy", &controller, "--motions", motion, "-o", &file("report")]);
    let own = json(&["eval", "--policy", &run, "--motions", &clip, "-o", &file("own")]);
    let error = |report: &serde_json::Value| report["overall"]["joint_error_deg"].as_f64();
    let (a, b) = (error(&own).unwrap(), error(&evaluated).unwrap());
    assert!((a - b).abs() < 0.5, "the same policy on the same clip: {a} and {b} deg");
}

#[test]
fn a_layout_that_the_policy_contradicts_is_refused_with_the_option_that_cures_it() {
    let folder = tempfile::tempdir().unwrap();
    let run = trained(folder.path());
    let file = |name: &str| folder.path().join(name).display().to_string();
    let clip = file("nod.motion.safetensors");
    json(&["motion", "retarget", "motions/nod.keys.toml", "-o", folder.path().to_str().unwrap()]);
    json(&["export", &run, "--for", "mjlab", "--motions", &clip, "-o", &file("mjlab")]);
    let onnx = file("mjlab/policy.onnx");
    let right = "command,motion_anchor_ori_b,base_ang_vel,joint_pos,joint_vel,actions";
    let controller = file("x.controller.safetensors");
    let wrong = right.replace("command,motion_anchor_ori_b", "motion_anchor_ori_b,command");
    let refused = lifelike(&["import", &onnx, "--terms", &wrong, "-o", &controller]);
    assert_eq!(refused.status.code(), Some(3));
    let said = err(&refused);
    assert!(said.contains("anchor_orientation_b") && said.contains("--terms") && said.contains("--force"), "{said}");
    assert!(!Path::new(&controller).exists(), "nothing is written");
    let forced = lifelike(&["import", &onnx, "--terms", right, "--force", "-o", &controller]);
    assert!(forced.status.success() && !err(&forced).contains("anchor_orientation_b"), "{}", err(&forced));
}

#[test]
fn what_a_stack_cannot_feed_and_what_is_no_policy_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name).display().to_string();
    let refused = lifelike(&["export", "lima", "--for", "mjlab", "-o", &file("x")]);
    assert_eq!(refused.status.code(), Some(3));
    assert!(err(&refused).contains("track-beyondmimic"), "{}", err(&refused));
    assert!(!Path::new(&file("x")).exists());
    let plain = lifelike(&["export", "lima", "--for", "onnx", "-o", &file("plain")]);
    assert!(plain.status.success() && out(&plain).contains("policy.onnx"), "{}", err(&plain));
    let looked = lifelike(&["inspect", &file("plain/policy.onnx")]);
    assert_eq!(looked.status.code(), Some(3), "ours, but of no stack that has a contract");
    std::fs::write(file("broken.onnx"), b"not a network").unwrap();
    let refused = lifelike(&["import", &file("broken.onnx")]);
    assert_eq!(refused.status.code(), Some(3));
    assert!(err(&refused).contains("an ONNX file"), "{}", err(&refused));
}
