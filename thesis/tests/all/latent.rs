//! `lifelike-thesis latent`: spaces of latent codes side by side.

use std::path::Path;

use crate::programs::{at, json, keys, lifelike, root, run};
use serde_json::Value;

/// A prior that has hardly learnt anything, of two clips in the folder's `lima`.
fn small_prior(folder: &Path, encoder: &str) -> (String, String) {
    let (motions, plan, run) = (at(folder, "lima"), at(folder, "small.toml"), at(folder, "prior"));
    lifelike(&["motion", "retarget", &keys("wave"), &keys("nod"), "-o", &motions]);
    std::fs::write(&plan, format!("robot = \"lima\"\nclips = [{motions:?}]\n{encoder}")).unwrap();
    lifelike(&["train", "prior", "--plan", &plan, "-o", &run]);
    (at(folder, "prior/motion.prior.safetensors"), motions)
}

#[test]
fn latent_spaces_are_compared() {
    let folder = tempfile::tempdir().unwrap();
    let (prior, motions) =
        small_prior(folder.path(), "[prior]\nchannels = 4\nblocks = 1\nlatent = 3\nbatch = 4\niterations = 6\n");
    let to = folder.path().join("latent");
    let arguments = ["latent", "--prior", &prior, &prior, "--motions", &motions];
    let unseen = ["--unseen", "motions/bow.keys.toml", "-o", to.to_str().unwrap()];
    let value = json(&root(), &[&arguments[..], &unseen].concat());
    // Two clips of 5 s have one class each: 0 to 2 s, and 4 to 6 s is not there.
    assert_eq!((&value["clips"], &value["table"][0]["lda"]["classes"]), (&2.into(), &2.into()));
    assert_eq!(value["table"][0]["lda"], value["table"][1]["lda"], "the same prior twice");
    let state = &value["table"][2];
    // Eq. 4.1 for 20 joints, two hands and two feet: 13 + 2 x 20 + 3 x 4. A feature knows most of itself.
    assert_eq!(state["dimension"], 65);
    assert!(state["information"]["best"].as_f64() > value["table"][0]["information"]["best"].as_f64());
    let information = &value["table"][0]["information"];
    assert!(information["mean"].as_f64().unwrap() > information["shuffled"].as_f64().unwrap(), "{information}");
    let sets: Vec<&Value> = value["reconstruction"].as_array().unwrap().iter().map(|r| &r["motions"]).collect();
    assert_eq!(sets, ["motions", "unseen", "motions", "unseen"]);
    assert_eq!(value["reconstruction"][1]["errors"]["clips"][0]["clip"], "bow");
    let file: Value = serde_json::from_slice(&std::fs::read(to.join("latent.json")).unwrap()).unwrap();
    assert_eq!(file, value);

    let text = String::from_utf8(run(&root(), &arguments).stdout).unwrap();
    assert!(text.contains("CALM") && text.contains("0.687") && text.contains("joints (deg)"), "{text}");
}

#[test]
fn codes_of_a_spline_prior_are_compared_too() {
    let folder = tempfile::tempdir().unwrap();
    let spline =
        "[spline.training]\nlatent = 3\nlayers = 1\nheads = 2\nwidth = 8\nbatch = 4\npart = 2\niterations = 6\n";
    let (prior, motions) = small_prior(folder.path(), spline);
    let spaces = json(&root(), &["latent", "--prior", &prior, "--motions", &motions]);
    assert_eq!(spaces["table"][0]["dimension"], 12);
}
