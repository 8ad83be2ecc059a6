//! `lifelike motion repair`: by kinematics, and by a policy in physics.

#![allow(clippy::unwrap_used)]

use crate::in_checkout::{json, lifelike};
use serde_json::Value;

#[test]
fn motion_comes_back_as_physics_makes_it() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    json(&[
        "motion",
        "retarget",
        "motions/wave.keys.toml",
        "motions/march.keys.toml",
        "--feasible",
        "-o",
        &at("clips"),
    ]);
    let policy = ["--policy", "assets/lima-path.controller.safetensors", "--particles", "24"];
    let run = |out: &str| json(&[&["motion", "repair", &at("clips"), "-o", &at(out)], &policy[..]].concat());
    let made = run("executed");
    assert_eq!(made["written"], 2);
    for clip in made["clips"].as_array().unwrap() {
        assert_eq!(clip["reached"], 1.0);
        let number = |key: &str, which: &str| clip["change"][key][which].as_f64().unwrap();
        // Physics follows, and is not the reference itself.
        assert!(number("root", "mean") < 0.1 && number("legs", "mean").to_degrees() < 8.0, "{clip}");
        assert!(number("legs", "max") > 1e-3 && number("root", "max") < 0.25, "{clip}");
    }
    assert_eq!(run("again")["clips"], made["clips"], "the same seed, the same motion");
    // As it is, without a policy.
    let kept = json(&["motion", "repair", &at("clips"), "-o", &at("kept")]);
    let same = |clip: &Value| clip["change"]["root"]["max"] == 0.0;
    assert!(kept["written"] == 2 && kept["clips"].as_array().unwrap().iter().all(same), "{kept}");
    for (option, value) in [("--noise", "nan"), ("--particles", "0"), ("--cutoff", "0")] {
        let refused =
            lifelike(&[&["motion", "repair", &at("clips"), "-o", &at("x"), option, value], &policy[..2]].concat());
        let said = String::from_utf8_lossy(&refused.stderr).into_owned();
        assert!(
            !refused.status.success() && (said.contains("expected") || said.contains("invalid")),
            "{option}: {said}"
        );
    }
    let noise = lifelike(&["motion", "repair", &at("clips"), "--noise", "0.1", "-o", &at("x")]);
    assert!(!noise.status.success() && String::from_utf8_lossy(&noise.stderr).contains("--policy"));
}
