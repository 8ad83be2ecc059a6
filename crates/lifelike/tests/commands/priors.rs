//! Priors at the command: trained, resumed, searched in, interpolated with, and seen by a policy.

#![allow(clippy::unwrap_used, clippy::expect_used)]

use std::path::Path;

use crate::in_checkout::{TINY, err, json, lifelike, out, retargeted};
use serde_json::Value;

#[test]
fn a_prior_is_trained_and_a_resumed_run_is_the_run_it_would_have_been() {
    let folder = tempfile::tempdir().unwrap();
    retargeted(folder.path());
    let plan = folder.path().join("small.toml");
    let text = format!(
        "robot = \"lima\"\nclips = [{:?}]\n[prior]\nchannels = 4\nblocks = 1\nlatent = 3\nbatch = 4\niterations = 6\n",
        folder.path()
    );
    std::fs::write(&plan, text).unwrap();
    let run = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    let plan = plan.to_str().unwrap();
    let done = json(&["train", "prior", "--plan", plan, "-o", &run("whole")]);
    assert_eq!(done["iterations"], 6);
    assert!(done["reconstruction"]["window"]["joints_deg"].as_f64().unwrap() > 0.0);
    let again = lifelike(&["train", "prior", "--plan", plan, "-o", &run("whole")]);
    assert_eq!(again.status.code(), Some(3), "a run is never overwritten");

    let resumed = json(&["train", "prior", "-o", &run("whole"), "--resume"]);
    assert_eq!(resumed["iterations"], 6, "there was nothing left to do");
    json(&["train", "prior", "--plan", plan, "-o", &run("same")]);
    let metrics = |name: &str| std::fs::read(Path::new(&run(name)).join("metrics.jsonl")).unwrap();
    assert_eq!(metrics("whole"), metrics("same"));
    let prior = json(&["inspect", &format!("{}/motion.prior.safetensors", run("whole"))]);
    assert_eq!(prior["kind"], "motion prior");
    assert_eq!(json(&["inspect", &run("whole")])["iterations"], 6);
}

/// A prior that has hardly learnt anything, of two clips in the folder's `lima`.
fn small_prior(folder: &Path) -> (String, String) {
    prior_by(folder, "[prior]\nchannels = 4\nblocks = 1\nlatent = 3\nbatch = 4\niterations = 6\n")
}

/// As [`small_prior`], its code of 12 numbers by a Spline-based Transformer.
fn small_spline_prior(folder: &Path) -> (String, String) {
    prior_by(
        folder,
        "[spline.training]\nlatent = 3\nlayers = 1\nheads = 2\nwidth = 8\nbatch = 4\npart = 2\niterations = 6\n",
    )
}

fn prior_by(folder: &Path, encoder: &str) -> (String, String) {
    let motions = folder.join("lima");
    retargeted(&motions);
    let plan = folder.join("small.toml");
    std::fs::write(&plan, format!("robot = \"lima\"\nclips = [{motions:?}]\n{encoder}")).unwrap();
    let run = folder.join("prior");
    json(&["train", "prior", "--plan", plan.to_str().unwrap(), "-o", run.to_str().unwrap()]);
    let prior = run.join("motion.prior.safetensors").to_string_lossy().into_owned();
    (prior, motions.to_string_lossy().into_owned())
}

#[test]
fn alike_motion_is_found_but_not_the_query_itself() {
    let folder = tempfile::tempdir().unwrap();
    let (prior, motions) = small_prior(folder.path());
    let wave = format!("{motions}/wave.motion.safetensors");
    let search = |at: &str, among: &str, more: &[&str]| {
        let arguments = ["motion", "search", &wave, "--at", at, "--prior", &prior, "--motions", among];
        json(&[&arguments[..], more].concat())
    };
    let found = search("2.5", &motions, &["-k", "4"]);
    assert_eq!(found["query"]["among_the_motions"], true);
    let hits = found["hits"].as_array().unwrap();
    assert_eq!(hits.len(), 4);
    let places: Vec<(&str, f64)> =
        hits.iter().map(|h| (h["clip"].as_str().unwrap(), h["time"].as_f64().unwrap())).collect();
    for (i, (clip, time)) in places.iter().enumerate() {
        assert!(*clip != "wave" || (time - 2.5).abs() > 1.0 - 1e-9, "overlaps the query: {places:?}");
        let near = places[..i].iter().any(|(other, t)| other == clip && (t - time).abs() < 0.5 - 1e-9);
        assert!(!near, "half a second apart: {places:?}");
    }
    assert!(hits.windows(2).all(|w| w[0]["similarity"].as_f64() >= w[1]["similarity"].as_f64()));
    // A query from elsewhere finds the very window.
    let copy = folder.path().join("copy");
    let slower = ["motion", "retarget", "motions/wave.keys.toml", "-o", copy.to_str().unwrap(), "fps=25"];
    json(&slower);
    let among_others = search("2.5", copy.to_str().unwrap(), &["-k", "1"]);
    assert_eq!(among_others["query"]["among_the_motions"], false);
    assert!((among_others["hits"][0]["time"].as_f64().unwrap() - 2.5).abs() < 0.05, "{among_others}");
    assert!(among_others["hits"][0]["similarity"].as_f64().unwrap() > 0.999, "{among_others}");

    let late = lifelike(&["motion", "search", &wave, "--at", "99", "--prior", &prior, "--motions", &motions]);
    assert_eq!(late.status.code(), Some(2));
    assert!(err(&late).contains("0 to 5.00 s"), "{}", err(&late));
}

#[test]
fn a_motion_between_two_is_a_motion() {
    let folder = tempfile::tempdir().unwrap();
    let (prior, motions) = small_prior(folder.path());
    let clip = |name: &str| format!("{motions}/{name}.motion.safetensors");
    let to = folder.path().join("between").to_string_lossy().into_owned();
    let (wave, nod) = (clip("wave"), clip("nod"));
    let arguments = ["motion", "interpolate", &wave, &nod, "--prior", &prior, "-o", &to];
    let seconds = |value: &Value, row: usize| value["motions"][row]["seconds"].as_f64().unwrap();
    for (change, share) in [(&["--weight", "0.25"][..], 0.25), (&["--ramp", "--look"], 0.5)] {
        let made = json(&[&arguments[..], change].concat());
        let expected = seconds(&made, 0) + share * (seconds(&made, 2) - seconds(&made, 0));
        assert!((seconds(&made, 4) - expected).abs() < 0.02, "{made}");
        let clip = json(&["inspect", made["file"].as_str().unwrap()]);
        assert_eq!(clip["name"], made["clip"]);
        let robot = json(&["inspect", "lima"]);
        let ranges = robot["joints"].as_array().unwrap();
        for joint in clip["joints"].as_array().unwrap() {
            let range = &ranges.iter().find(|r| r["name"] == joint["name"]).unwrap()["range"];
            let number = |value: &Value| value.as_f64().unwrap();
            let inside = number(&joint["min"]) >= number(&range[0]) && number(&joint["max"]) <= number(&range[1]);
            assert!(inside, "{joint} {range}");
        }
    }
    assert!(Path::new(&to).join("report.html").is_file());
    for wrong in [&["--weight", "2"][..], &["--weight", "0.5", "--ramp"]] {
        assert_eq!(lifelike(&[&arguments[..], wrong].concat()).status.code(), Some(2), "{wrong:?}");
    }
    let other = lifelike(&[&arguments[..], &["--robot", "humanoid"]].concat());
    assert_eq!(other.status.code(), Some(3), "another robot's prior is refused: {}", err(&other));
}

#[test]
fn a_spline_prior_serves_wherever_a_prior_does() {
    let folder = tempfile::tempdir().unwrap();
    let (prior, motions) = small_spline_prior(folder.path());
    let path = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    let resumed = json(&["train", "prior", "-o", &path("prior"), "--resume"]);
    assert_eq!(resumed["iterations"], 6, "there was nothing left to do");
    assert!(resumed["reconstruction"]["window"]["joints_deg"].as_f64().unwrap() > 0.0);
    let seen = json(&["inspect", &prior]);
    assert_eq!((&seen["kind"], &seen["plan"]["training"]["latent"]), (&"spline motion prior".into(), &3.into()));
    let text = out(&lifelike(&["inspect", &prior]));
    assert!(text.contains("12 numbers (4 control points of 3") && text.contains("for 1 s of motion"), "{text}");

    let (wave, nod) = (format!("{motions}/wave.motion.safetensors"), format!("{motions}/nod.motion.safetensors"));
    let found = json(&["motion", "search", &wave, "--at", "2.5", "--prior", &prior, "--motions", &motions, "-k", "2"]);
    assert_eq!(found["hits"].as_array().unwrap().len(), 2);
    let between = ["motion", "interpolate", &wave, &nod, "--prior", &prior, "-o", &path("between")];
    assert!(Path::new(json(&between)["file"].as_str().unwrap()).is_file());
    let other = lifelike(&[&between[..], &["--robot", "humanoid"]].concat());
    assert_eq!(other.status.code(), Some(3), "another robot's prior is refused: {}", err(&other));
}

/// z_t alone, and z_t with the reference's frame beside it.
#[test]
fn a_policy_sees_the_codes_of_a_spline_prior() {
    let folder = tempfile::tempdir().unwrap();
    let (prior, _) = small_spline_prior(folder.path());
    let path = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    std::fs::write(folder.path().join("plan.toml"), TINY).unwrap();
    let with = format!("prior={prior}");
    let train = |to: &str, more: &[&str]| {
        let (plan, to) = (path("plan.toml"), path(to));
        lifelike(&[&["--json", "train", "tracker", "--plan", &plan, "-o", &to, &with][..], more].concat())
    };
    for (name, frame) in [("S", "false"), ("SM", "true")] {
        let done = train(name, &["inputs.latent=12", &format!("inputs.frame={frame}")]);
        assert!(done.status.success(), "{}", err(&done));
    }
    let policy = path("SM/tracker.controller.safetensors");
    let eval =
        ["eval", "--policy", &policy, "--motions", "motions/nod.keys.toml", "-o", &path("report"), "--starts", "2"];
    let evaluation = json(&[&eval[..], &["--prior", &prior]].concat());
    assert_eq!(evaluation["overall"]["episodes"], 2);
    assert!(evaluation["overall"]["joint_error_deg"].as_f64().unwrap() > 0.0);

    // In its run's folder a policy's prior is found by the plan beside it; elsewhere it has to be named.
    assert!(lifelike(&eval).status.success());
    let alone = path("alone.controller.safetensors");
    std::fs::copy(&policy, &alone).unwrap();
    let eval =
        ["eval", "--policy", &alone, "--motions", "motions/nod.keys.toml", "-o", &path("report"), "--starts", "2"];
    let without = lifelike(&eval);
    let digest = json(&["inspect", &policy])["header"]["provenance"]["prior"].as_str().unwrap().to_owned();
    assert_eq!(without.status.code(), Some(2));
    assert!(digest.len() == 64 && err(&without).contains(&digest), "{}", err(&without));
    let another = lifelike(&[&eval[..], &["--prior", "assets/lima.prior.safetensors"]].concat());
    assert_eq!(another.status.code(), Some(3));
    assert!(err(&another).contains("expected the prior that the policy was trained with"), "{}", err(&another));

    let short = train("short", &["inputs.latent=64"]);
    assert!(
        short.status.code() == Some(3) && err(&short).contains("64") && err(&short).contains("12"),
        "{}",
        err(&short)
    );
    let robot = train("robot", &["inputs.latent=12", "robot=humanoid"]);
    assert_eq!(robot.status.code(), Some(3));
    assert!(err(&robot).contains("expected a prior of 'humanoid'"), "{}", err(&robot));
}
