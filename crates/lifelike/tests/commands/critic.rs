//! A critic from rollouts of a frozen controller to the motion that it aligns.

#![allow(clippy::unwrap_used)]

use std::path::Path;

use crate::in_checkout::{json, refused};
use serde_json::Value;

const CRITIC: &str = "robot = 'lima'\ncontroller = 'lima'\nenvironment = 'track-long'\n\
    clips = ['motions/wa[lv][ke].keys.toml', 'motions/weight_shift.keys.toml', 'motions/march.keys.toml']\n\
    [rollouts]\nenvironments = 8\nsteps = 150\n\
    [critic]\nhidden = [16]\nepochs = 4\nminibatch = 64\nvalidation = 0.25\n";

const GENERATOR: &str = "robot = 'lima'\nclips = ['builtin']\nmax_seconds = 2.0\nwidth = 16\nlayers = 1\nheads = 2\ninner = 32\n\
    pieces = 150\nbatch = 8\niterations = 10\nwarmup = 2\ndiffusion_steps = 10\nvalidate_every = 5\n";

#[test]
fn a_critic_is_trained_and_aligns_a_generator() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    std::fs::write(at("critic.toml"), CRITIC).unwrap();
    let run = at("run");
    let trained = json(&["train", "critic", "--plan", &at("critic.toml"), "-o", &run]);
    assert_eq!((&trained["epochs"], &trained["control_steps"]), (&Value::from(4), &Value::from(1200)));
    let again = json(&["train", "critic", "--resume", "-o", &run]);
    assert_eq!(again["explained_variance"], trained["explained_variance"], "what is done is left alone");
    let critic = trained["critic"].as_str().unwrap();

    std::fs::write(at("generator.toml"), GENERATOR).unwrap();
    let made = json(&["train", "generator", "--plan", &at("generator.toml"), "-o", &at("generator")]);
    let generator = made["generator"].as_str().unwrap();
    let aligned = at("aligned");
    let judge = ["judge.sentences=3", "judge.split=train", "judge.episodes=6", "judge.seconds=1"];
    let small = ["iterations=6", "batch=8", "validate_every=3", "prompts=2", "warmup=0", "tolerance=5"];
    let small = [&small[..], &judge].concat();
    let align = ["align", "--generator", generator, "--critic", critic, "-o", &aligned];
    let first = json(&[&align[..], &small].concat());
    assert_eq!(first["iterations"], 6);
    let falls: Vec<f64> = (0..2).map(|i| first["physics"][i]["falls"].as_f64().unwrap()).collect();
    assert!(falls.iter().all(|falls| (0.0..=1.0).contains(falls)), "{first}");
    let resumed = json(&["align", "--resume", "-o", &aligned]);
    assert_eq!((&resumed["realism"], &resumed["physics"]), (&first["realism"], &first["physics"]));
    let motion = at("a.motion.safetensors");
    let network = first["generator"].as_str().unwrap();
    let words = ["generate", "a person walks", "--seconds", "1.5", "-o", &motion, "--generator", network];
    let free = json(&[&words[..], &["--critic", critic, "--critic-strength", "0"]].concat());
    let opinion = &free["motions"][0]["verdicts"][0]["critic"];
    assert!(opinion["lowest"].as_f64().unwrap() <= opinion["realism"].as_f64().unwrap(), "{free}");

    let best = |by: &str| {
        json(&[&words[..], &["--critic", critic, "--critic-strength", "0", "--best-of", "3", "--by", by]].concat())
    };
    let (praised, followed) = (best("critic"), best("physics"));
    assert_eq!((&praised["motions"][0]["candidates"], &followed["motions"][0]["candidates"]), (&3.into(), &3.into()));
    let realism = |made: &Value| made["motions"][0]["verdicts"][0]["critic"]["realism"].as_f64().unwrap();
    assert!(realism(&praised) >= realism(&followed) && realism(&praised) >= realism(&free), "{praised}");
    let (code, error) = refused(&[&words[..], &["--policy", "assets/lima-path.controller.safetensors"]].concat());
    assert!(code == 2 && error.contains("--by physics"), "{code} {error}");

    let (code, error) = refused(&["train", "critic", "--plan", &at("critic.toml"), "-o", &at("no"), "critic.gamma=1"]);
    assert!(code == 3 && error.contains("critic.gamma"), "{code} {error}");
    let none = at("none.controller.safetensors");
    let (code, error) =
        refused(&["train", "critic", "--plan", &at("critic.toml"), "-o", &at("no"), "--controller", &none]);
    assert!(code == 3 && error.contains("controller"), "{code} {error}");
    let (code, error) = refused(&[&words[..], &["--critic", generator]].concat());
    assert!(code == 3 && error.contains("critic"), "{code} {error}");
}

#[test]
fn a_controller_carries_the_environment_that_it_was_trained_in() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    std::fs::write(at("critic.toml"), CRITIC).unwrap();
    let (plan, out) = (at("critic.toml"), at("out"));
    let critic = ["train", "critic", "--plan", &plan, "environment=", "-o", &out, "--controller"];
    let (code, error) = refused(&[&critic[..], &["assets/lima-blind.controller.safetensors"]].concat());
    assert!(
        code == 3 && error.contains("environment=PLAN") && error.contains("lima-blind.controller"),
        "{code} {error}"
    );

    let own = at("own.controller.safetensors");
    let policy = "assets/lima-path.controller.safetensors";
    let exported = json(&["export", policy, "--environment", "track-long", "-o", &own]);
    let environment = exported["header"]["environment"].as_str().unwrap();
    assert!(environment.contains("switch_clips = true") && environment.contains("clips = []"), "{environment}");
    assert_eq!(json(&["inspect", &own])["header"]["environment"], exported["header"]["environment"]);
    let trained = json(&[&critic[..], &[&own]].concat());
    // The same environment by name: the same rewards.
    let named = json(&["train", "critic", "--plan", &at("critic.toml"), "-o", &at("named")]);
    assert_eq!((&trained["mean_reward"], &trained["failures"]), (&named["mean_reward"], &named["failures"]));
}

/// Which generator was played by which tracker.
fn pairs(done: &Value) -> Vec<[u64; 2]> {
    let number = |pair: &Value, key: &str| pair[key].as_u64().unwrap();
    done["measured"].as_array().unwrap().iter().map(|p| [number(p, "generator"), number(p, "tracker")]).collect()
}

#[test]
fn generator_tracker_and_critic_are_trained_in_turn() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    let (set, run) = (at("set"), at("run"));
    json(&["dataset", "grammar", "-o", &set, "--hours", "0.02", "--seed", "5"]);
    std::fs::write(at("generator.toml"), GENERATOR).unwrap();
    std::fs::write(at("critic.toml"), CRITIC).unwrap();
    let made = json(&["train", "generator", "--plan", &at("generator.toml"), "-o", &at("generator")]);
    let plan = format!(
        "robot = 'lima'\ngenerator = {}\ninit = 'assets/lima-path.controller.safetensors'\ndataset = '{set}'\n\
         clips = ['motions/walk.keys.toml']\nseed = 1\nrounds = 1\nprompts = 3\nmeasured = 2\nsplit = 'train'\n\
         judge = {{ sentences = 2, split = 'train', episodes = 4, seconds = 1.0 }}\n\
         [tracker]\nplan = 'track-long'\nkeys = ['budget.steps=500', 'ppo.environments=16', 'ppo.minibatch=32']\n\
         [critic]\nplan = '{}'\n\
         [align]\nplan = 'align'\nkeys = ['iterations=2', 'batch=4', 'prompts=2', 'tolerance=100.0']\n",
        made["generator"],
        at("critic.toml")
    );
    std::fs::write(at("cotrain.toml"), &plan).unwrap();
    let done = json(&["cotrain", "--plan", &at("cotrain.toml"), "-o", &run]);
    assert_eq!(pairs(&done), [[0, 0], [0, 1], [1, 0], [1, 1]]);
    let best = match done["best_round"].as_u64().unwrap() {
        0 => Path::new(made["generator"].as_str().unwrap()).to_path_buf(),
        round => folder.path().join(format!("run/round-{round}/aligned/motion.generator.safetensors")),
    };
    let bytes = |file: &Path| std::fs::read(file).unwrap();
    assert!(bytes(Path::new(done["generator"].as_str().unwrap())) == bytes(&best), "{done}");
    assert!(
        done["measured"][0]["physics"]["falls"].is_number()
            && !folder.path().join("run/round-1/critic/records.safetensors").exists()
    );
    assert!(folder.path().join("run/round-1/motions/generated.rows.safetensors").exists());
    let critic = std::fs::read_to_string(folder.path().join("run/round-1/critic/plan.toml")).unwrap();
    assert!(
        critic.contains("round-1/tracker/plan.toml"),
        "a policy trained here is judged in its own environment: {critic}"
    );

    // As if it had been stopped in the middle of the alignment: only that is done again, by its own run's --resume.
    let record = folder.path().join("run/cotrain.json");
    let mut value: Value = serde_json::from_str(&std::fs::read_to_string(&record).unwrap()).unwrap();
    value["stages"].as_array_mut().unwrap().retain(|stage| stage != "round-1/aligned");
    std::fs::write(&record, value.to_string()).unwrap();
    let tracker = std::fs::metadata(folder.path().join("run/round-1/tracker/tracker.controller.safetensors")).unwrap();
    let again = json(&["cotrain", "--resume", "-o", &run]);
    assert_eq!(again["measured"], done["measured"]);
    let after = std::fs::metadata(folder.path().join("run/round-1/tracker/tracker.controller.safetensors")).unwrap();
    assert_eq!(tracker.modified().unwrap(), after.modified().unwrap());

    // Without a training of its own the tracker stays; the second critic learns from the motion of both rounds.
    let tracker = plan.lines().position(|line| line == "[tracker]").unwrap();
    let frozen: Vec<&str> =
        plan.lines().enumerate().filter(|(i, _)| !(tracker..tracker + 3).contains(i)).map(|(_, line)| line).collect();
    std::fs::write(at("frozen.toml"), frozen.join("\n").replace("rounds = 1", "rounds = 2")).unwrap();
    let done = json(&["cotrain", "--plan", &at("frozen.toml"), "-o", &at("frozen")]);
    assert_eq!(pairs(&done), [[0, 0], [1, 0], [2, 0]]);
    assert!(!folder.path().join("frozen/round-1/tracker").exists());
    let critic = std::fs::read_to_string(folder.path().join("frozen/round-2/critic/plan.toml")).unwrap();
    assert!(critic.contains("round-1/motions") && critic.contains("round-2/motions"), "{critic}");

    std::fs::write(at("other.toml"), plan.replace("split = 'train'", "split = 'held_out'")).unwrap();
    std::fs::write(folder.path().join("set/dataset.jsonl"), "").unwrap();
    let (code, error) = refused(&["cotrain", "--plan", &at("other.toml"), "-o", &at("other")]);
    assert!(code != 0 && error.contains("held_out") || error.contains("dataset.jsonl"), "{error}");
}
