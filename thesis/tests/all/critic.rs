//! `lifelike-thesis critic`: a critic from rollouts of a frozen controller, measured.

use crate::programs::{at, json, keys, lifelike, root};
use serde_json::Value;

const CRITIC: &str = "[rollouts]\nenvironments = 8\nsteps = 150\n\
    [critic]\nhidden = [16]\nepochs = 4\nminibatch = 64\nvalidation = 0.25\n";

#[test]
fn a_critic_is_measured_on_motion_that_it_did_not_learn_from() {
    let folder = tempfile::tempdir().unwrap();
    let (plan, run, out) = (at(folder.path(), "critic.toml"), at(folder.path(), "run"), at(folder.path(), "out"));
    let clips = [keys("wa[lv][ke]"), keys("weight_shift"), keys("march")];
    let head = format!("robot = 'lima'\ncontroller = 'lima'\nenvironment = 'track-long'\nclips = {clips:?}\n");
    std::fs::write(&plan, head + CRITIC).unwrap();
    lifelike(&["train", "critic", "--plan", &plan, "-o", &run]);
    let few = ["--environments", "8", "--steps", "120", "--seconds", "1", "--repeats", "2"];
    let table = ["critic", "--run", &run, "--motions", "motions/nod.keys.toml", "motions/walk.keys.toml", "-o", &out];
    let measured = json(&root(), &[&table[..], &few].concat());
    assert_eq!((&measured["clips"], &measured["starts"]), (&Value::from(2), &Value::from(4)));
    assert!(measured["windows"].as_u64().unwrap() > 20, "{measured}");
    let page = std::fs::read_to_string(folder.path().join("out/report.html")).unwrap();
    assert!(page.contains("Predicted and measured"));
}
