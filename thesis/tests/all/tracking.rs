//! `lifelike-thesis tracking`: stages, variants one by one, both protocols.

use crate::programs::{err, root, run};
use serde_json::Value;

const TINY: &str = include_str!("../../../crates/lifelike/tests/commands/in_checkout/tiny.toml");

/// A study with stages may be trained variant by variant, on several machines or cores.
#[test]
fn variants_of_a_study_are_trained_one_by_one_whatever_the_others_have_not_begun() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    std::fs::write(path("plan.toml"), TINY).unwrap();
    let study = "plan = 'plan.toml'\nstarts = 1\nseconds = 0.4\nthesis = { episodes = 2, seconds = 0.4 }\n\
                 [[stage]]\nname = 'first'\n[[stage]]\nname = 'second'\n\
                 [[variant]]\nname = 'A'\nseeds = [1]\n[[variant]]\nname = 'B'\nseeds = [1]\n\
                 [[variant]]\nname = 'C'\nseeds = [1]\n[[class]]\nname = 'nod'\nclips = ['motions/nod.keys.toml']";
    std::fs::write(path("study.toml"), study).unwrap();
    let (study, to) = (path("study.toml"), path("runs"));
    let bench = ["--json", "tracking", "--study", &study, "-o", &to, "--threads", "1"];
    let name = |run: &Value| format!("{} {}", run["variant"].as_str().unwrap(), run["stage"].as_str().unwrap());
    let trained = |only: &str| -> Vec<String> {
        let done = run(&root(), &[&bench[..], &["--only", only]].concat());
        let told = err(&done);
        let first = told.lines().find(|line| line.contains(" with seed ")).unwrap_or_default();
        assert!(first.contains(&format!("{only} with seed 1")), "what is asked for comes first: {told}");
        let runs: Value = serde_json::from_slice(&done.stdout).unwrap();
        runs["runs"].as_array().unwrap().iter().map(name).collect()
    };
    // A comes first in the file, and its second stage has nothing to begin with yet.
    assert_eq!(trained("B"), ["B first", "B second"]);
    assert_eq!(trained("C"), ["B first", "B second", "C first", "C second"]);
    assert_eq!(trained("A"), ["A first", "A second", "B first", "B second", "C first", "C second"]);

    // Another seed of one variant, beside it what is there of that seed: nothing.
    let other = run(&root(), &[&bench[..], &["--only", "B", "--seeds", "2"]].concat());
    let runs: Value = serde_json::from_slice(&other.stdout).unwrap();
    let told: Vec<_> =
        runs["runs"].as_array().unwrap().iter().map(|run| (name(run), run["seed"].as_u64().unwrap())).collect();
    assert_eq!(told, [("B first".to_owned(), 2), ("B second".to_owned(), 2)]);
    // Both protocols of the same policy, and a curve of each metric and stage over the seeds that are there.
    let one = &runs["runs"][1];
    assert_eq!((&one["thesis"][0]["frames"], one["deviation"].as_f64()), (&Value::from(40), Some(0.3)), "{one}");
    assert!(one["scores"][0]["joint_error_deg"].as_f64().unwrap() > 0.0);
    let curve =
        runs["curves"].as_array().unwrap().iter().find(|c| c["metric"] == "joint error in training [deg]").unwrap();
    assert_eq!((&curve["variant"], &curve["seeds"]), (&Value::from("B"), &serde_json::json!([2])), "{curve}");
    assert!(curve["mean"][0].as_f64().unwrap() > 0.0 && curve["mean"] == curve["low"], "{curve}");
    assert!(std::fs::read_to_string(folder.path().join("runs/report.html")).unwrap().contains("class=\"band c0\""));
    let twice = run(&root(), &[&bench[..], &["--seeds", "2,2"]].concat());
    assert!(err(&twice).contains("expected every seed once, got 2 twice"), "{}", err(&twice));
}
