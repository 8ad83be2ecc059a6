//! The command as people and scripts meet it: arguments in, text or JSON and exit codes out.

#![allow(clippy::unwrap_used, clippy::expect_used)]

use std::path::Path;
use std::process::Command;

use crate::in_checkout::{TINY, err, json, lifelike, out, retargeted, root};
use serde_json::Value;

#[test]
fn every_command_teaches_by_example() {
    let commands: [&[&str]; 22] = [
        &["robots"],
        &["inspect"],
        &["motion", "retarget"],
        &["motion", "convert"],
        &["motion", "search"],
        &["motion", "interpolate"],
        &["bench", "learning"],
        &["motion", "sequence"],
        &["motion", "compose"],
        &["motion", "blend"],
        &["motion", "warp"],
        &["motion", "place"],
        &["motion", "stylize"],
        &["motion", "mirror"],
        &["motion", "trim"],
        &["motion", "check"],
        &["motion", "lint"],
        &["bench", "robustness"],
        &["train", "prior"],
        &["train", "tracker"],
        &["eval"],
        &["demo"],
    ];
    for command in commands {
        let help = lifelike(&[command, &["--help"]].concat());
        assert_eq!(help.status.code(), Some(0));
        let text = out(&help);
        assert!(text.contains("Examples:") && text.contains("lifelike "), "{command:?}: {text}");
    }
    assert!(out(&lifelike(&["--help"])).contains("Exit codes"));
}

#[test]
fn exit_codes_tell_usage_from_input() {
    assert_eq!(lifelike(&["dance"]).status.code(), Some(2));
    assert_eq!(lifelike(&["train", "tracker"]).status.code(), Some(2), "nothing to train");
    let unknown = lifelike(&["inspect", "no_such_robot"]);
    assert_eq!(unknown.status.code(), Some(3));
    assert!(err(&unknown).contains("lima"), "names what there is: {}", err(&unknown));
    let as_json = lifelike(&["--json", "inspect", "no_such_robot"]);
    let error: Value = serde_json::from_str(err(&as_json).trim()).unwrap();
    assert_eq!(error["code"], 3);
}

#[test]
fn the_robots_of_the_thesis_are_there() {
    let robots = json(&["robots"]);
    let dof = |name: &str| robots.as_array().unwrap().iter().find(|r| r["name"] == name).map(|r| r["dof"].clone());
    // Thesis 4.3.1: Lima has 20 degrees of freedom and 16.2 kg, the humanoid 36.
    assert_eq!(dof("lima"), Some(20.into()));
    assert_eq!(dof("humanoid"), Some(36.into()));
    let lima = json(&["inspect", "lima"]);
    assert!((lima["mass_kg"].as_f64().unwrap() - 16.2).abs() < 0.05);
    assert_eq!(lima["actuators"].as_array().unwrap().len(), 20);
    // A ball of 0.46 kg and 4.5 cm: 2/5 m r².
    let humanoid = json(&["inspect", "humanoid"]);
    let hand = humanoid["bodies"].as_array().unwrap().iter().find(|b| b["name"] == "left_hand").unwrap();
    for (axis, expected) in [0.4 * 0.46 * 0.045 * 0.045; 3].into_iter().chain([0.0; 3]).enumerate() {
        assert!((hand["inertia_kg_m2"][axis].as_f64().unwrap() - expected).abs() < 1e-12, "{hand}");
    }
    let wide = out(&lifelike(&["inspect", "humanoid", "--wide"]));
    assert!(wide.contains("axis in the body") && wide.contains("0.0003726 0.0003726 0.0003726 0 0 0"), "{wide}");
    assert!(!out(&lifelike(&["inspect", "humanoid"])).contains("axis in the body"));
    // The same robot by its file.
    assert_eq!(json(&["inspect", "robots/lima.xml"])["joints"], lima["joints"]);
}

#[test]
fn clips_are_converted_or_refused_with_a_reason() {
    let folder = tempfile::tempdir().unwrap();
    let bad = folder.path().join("bad.bvh");
    std::fs::write(&bad, "HIERARCHY\nROOT Hips\n{\n  OFFSET 0 0 zero\n").unwrap();
    let to = folder.path().join("lima");
    let arguments = ["motion", "retarget", "motions/wave.keys.toml", bad.to_str().unwrap(), "-o", to.to_str().unwrap()];
    let result = json(&arguments);
    assert_eq!((&result["summary"]["converted"], &result["summary"]["refused"]), (&1.into(), &1.into()));
    let clips = result["clips"].as_array().unwrap();
    let refused = clips.iter().find_map(|c| c["refused"].as_str()).unwrap();
    assert!(refused.contains("bad.bvh:4"), "file and line: {refused}");
    assert!(to.join("retarget.json").is_file());
    let wave = json(&["inspect", to.join("wave.motion.safetensors").to_str().unwrap()]);
    assert_eq!(wave["joints"].as_array().unwrap().len(), 20);
    assert_eq!(wave["fps"], 50.0);

    assert_eq!(lifelike(&[&arguments[..], &["--strict"]].concat()).status.code(), Some(3));
    let only_bad = lifelike(&["motion", "retarget", bad.to_str().unwrap(), "-o", to.to_str().unwrap()]);
    assert_eq!(only_bad.status.code(), Some(3), "nothing converted is bad input");
}

#[test]
fn options_of_retargeting_change_it_and_unknown_ones_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let to = folder.path().to_str().unwrap();
    let slow = json(&["motion", "retarget", "motions/nod.keys.toml", "-o", to, "fps=25"]);
    let frames = slow["summary"]["frames"].as_f64().unwrap();
    let seconds = slow["summary"]["seconds"].as_f64().unwrap();
    assert!((frames - 1.0 - 25.0 * seconds).abs() < 1e-6, "{frames} frames in {seconds} s at 25 Hz");
    let wrong = lifelike(&["motion", "retarget", "motions/nod.keys.toml", "-o", to, "spf=25"]);
    assert_eq!(wrong.status.code(), Some(3));
    assert!(err(&wrong).contains("spf") && err(&wrong).contains("smoothing"), "{}", err(&wrong));
}

#[test]
fn motion_becomes_a_table() {
    let folder = tempfile::tempdir().unwrap();
    retargeted(folder.path());
    let tables = folder.path().join("tables");
    let arguments = ["motion", "convert", folder.path().to_str().unwrap(), "--to", "csv", "--fps", "10", "-o"];
    json(&[&arguments[..], &[tables.to_str().unwrap()]].concat());
    let text = std::fs::read_to_string(tables.join("wave.csv")).unwrap();
    let columns = text.lines().next().unwrap().split(',').count();
    assert_eq!(columns, 8 + 20);
    // wave.keys.toml lasts 5 s: frames at 0.0, 0.1, ... 5.0 s.
    assert_eq!(text.lines().count(), 1 + 51);
}

/// Through Unitree's layout and back; what is read is said, what is in doubt is refused.
#[test]
fn motion_goes_through_the_layouts_of_others() {
    let folder = tempfile::tempdir().unwrap();
    retargeted(folder.path());
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_string();
    let wave = at("wave.motion.safetensors");
    let csv = json(&["motion", "convert", &wave, &at("wave.csv"), "--to", "lafan1", "--robot", "lima"]);
    assert_eq!(csv[0]["fps"], 30.0);
    assert_eq!(csv[0]["layout"], "lafan1");
    let notes = csv[0]["notes"].to_string();
    assert!(notes.contains("resampled from 50 to 30") && notes.contains("names of joints"), "{notes}");

    let back = lifelike(&[
        "motion",
        "convert",
        &at("wave.csv"),
        &at("back.motion.safetensors"),
        "--layout",
        "lafan1",
        "--robot",
        "lima",
    ]);
    assert!(back.status.success(), "{}", err(&back));
    let said = "Unitree LAFAN1 CSV: 27 columns, quaternion x y z w, 30 frames per second";
    assert!(String::from_utf8_lossy(&back.stdout).contains(said));
    let [slow, back] = ["wave", "back"]
        .map(|name| lifelike_motion::container::read(at(&format!("{name}.motion.safetensors")).as_ref()).unwrap());
    let slow = lifelike_motion::resample::resample(&slow, 30.0).unwrap();
    assert_eq!((slow.len(), &slow.joint_names), (back.len(), &back.joint_names));
    assert!(slow.joints.iter().zip(&back.joints).all(|(a, b)| (a - b).abs() < 1e-12));
    assert!(slow.root_position.iter().zip(&back.root_position).all(|(a, b)| (a - b).norm() < 1e-12));

    let refused = |arguments: &[&str], cure: &str| {
        let output = lifelike(arguments);
        assert_eq!(output.status.code(), Some(3), "{arguments:?}");
        assert!(err(&output).contains(cure), "{}", err(&output));
    };
    let all = at("all");
    refused(&["motion", "convert", &at("wave.csv"), &at("a.csv")], "expected --to NAME");
    refused(&["motion", "convert", &wave, &at("a.npz"), "--to", "csv"], "ends in .csv");
    refused(&["motion", "convert", &wave, "-", "--to", "csv"], "not printed");
    refused(&["motion", "convert", &wave, &wave], "another file than the input");
    refused(&["motion", "convert", &at("wave.csv"), "--to", "gmr", "-o", &all], "--robot ROBOT names the joints");
    refused(&["motion", "retarget", &at("wave.csv"), "--layout", "lafan1", "-o", &all], "every clip was refused");

    // A table that lacks a joint of the robot, and two clips of one name: nothing is written.
    json(&["motion", "convert", &wave, &at("lima.csv"), "--to", "csv"]);
    let lacking = std::fs::read_to_string(at("lima.csv")).unwrap().replacen("right_elbow", "foo", 1);
    std::fs::write(at("lacking.csv"), lacking).unwrap();
    let to = at("o.motion.safetensors");
    refused(&["motion", "convert", &at("lacking.csv"), &to, "--robot", "lima"], "such as 'right_elbow'");
    for name in ["one", "two"] {
        std::fs::create_dir(at(name)).unwrap();
        std::fs::copy(at("wave.motion.safetensors"), at(&format!("{name}/a.motion.safetensors"))).unwrap();
    }
    let [one, two, none] = ["one", "two", "none"].map(at);
    let both = lifelike(&["motion", "convert", &one, &two, "-o", &none]);
    let said = err(&both);
    assert_eq!(both.status.code(), Some(3), "{said}");
    let files = ["one", "two"].map(|name| at(&format!("{name}/a.motion.safetensors")));
    assert!(said.contains(&format!("{} and {}: both clips are named 'wave'", files[0], files[1])), "{said}");
    assert!(!Path::new(&none).exists() && !Path::new(&to).exists());

    // From one robot to another.
    let other = ["motion", "retarget", &wave, "--source-robot", "lima", "--robot", "humanoid", "-o", &all, "fps=25"];
    let report = json(&other);
    assert_eq!(report["summary"]["converted"], 1, "{report}");
    let human = json(&["motion", "retarget", "motions/nod.keys.toml", "--layout", "lafan1", "-o", &all]);
    assert!(human["clips"][0]["report"]["notes"].to_string().contains("were ignored"), "{human}");
}

#[test]
fn what_no_option_can_be_is_refused_before_the_work() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    let (to, page, scene, servo) = (at("to"), at("a.gif"), at("a.scene.toml"), at("servo.toml"));
    let nod = "motions/nod.keys.toml";
    let commands: [(&str, &[&str]); 6] = [
        ("--fps", &["motion", "retarget", nod, "-o", &to]),
        ("--fps", &["motion", "convert", nod, "-o", &to]),
        ("--input-fps", &["motion", "convert", nod, "-o", &to]),
        ("--fps", &["render", "builtin:nod", "-o", &page]),
        ("--rate", &["augment", "identify", nod, "-o", &servo]),
        ("--port", &["studio", &scene, "--no-browser"]),
    ];
    for (option, line) in commands {
        for value in ["0", "-1", "nan", "99999999"].iter().filter(|value| (option, **value) != ("--port", "0")) {
            let output = lifelike(&[line, &[option, value]].concat());
            let said = format!("{option}: expected ");
            assert_eq!(output.status.code(), Some(3), "{line:?} {value}: {}", err(&output));
            assert!(err(&output).contains(&said) && err(&output).to_lowercase().contains(value), "{}", err(&output));
        }
    }
    let printed: [&[&str]; 7] = [
        &["motion", "retarget", nod],
        &["motion", "convert", nod, "--to", "csv"],
        &["generate", "a person waves"],
        &["eval", "--policy", "lima", "--motions", "builtin:nod"],
        &["render", "builtin:nod"],
        &["augment", "excite", "--robot", "lima"],
        &["augment", "identify", nod],
    ];
    for line in printed {
        let output = lifelike(&[line, &["-o", "-"]].concat());
        assert!(output.status.code() == Some(2) && err(&output).contains("'-'"), "{line:?}: {}", err(&output));
    }
    let lost = lifelike(&["render", "builtin:nod", "-o", &at("none/a.gif")]);
    assert!(lost.status.code() == Some(2) && err(&lost).contains("for the file, got none"), "{}", err(&lost));
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}

/// Our own clips can be executed; one that is lifted off the ground cannot.
#[test]
fn clips_are_checked_before_anybody_trains_on_them() {
    let folder = tempfile::tempdir().unwrap();
    retargeted(folder.path());
    let file = folder.path().join("wave.motion.safetensors");
    let mut lifted = lifelike_motion::container::read(&file).unwrap();
    lifted.name = "lifted".into();
    lifted.root_position.iter_mut().for_each(|p| p.z += 0.3);
    let bad = folder.path().join("lifted.motion.safetensors");
    lifelike_motion::container::write(&bad, &lifted).unwrap();
    let at = folder.path().to_str().unwrap();
    let checked = json(&["motion", "check", at]);
    let verdicts: Vec<(&Value, &Value)> = checked
        .as_array()
        .unwrap()
        .iter()
        .map(|c| (&c["feasibility"]["clip"], &c["feasibility"]["trackable"]))
        .collect();
    let expected = [("lifted", false), ("nod", true), ("wave", true)].map(|(n, t)| (Value::from(n), Value::from(t)));
    assert_eq!(verdicts, expected.iter().map(|(n, t)| (n, t)).collect::<Vec<_>>());
    assert!(out(&lifelike(&["motion", "check", at])).contains("held up by nothing"));
    let list = out(&lifelike(&["motion", "check", at, "--list-trackable"]));
    assert_eq!(list.lines().count(), 2, "{list}");
    let paths = folder.path().join("list.txt");
    std::fs::write(&paths, list).unwrap();
    let again = json(&["motion", "check", &format!("@{}", paths.display())]);
    assert_eq!(again.as_array().unwrap().len(), 2, "the list can be read back");
}

#[test]
fn a_wrong_plan_is_refused_before_anything_starts() {
    let folder = tempfile::tempdir().unwrap();
    let plan = folder.path().join("plan.toml");
    std::fs::write(&plan, "robot = \"lima\"\nclips = []\n").unwrap();
    let to = folder.path().join("run");
    let train = |change: &str| {
        lifelike(&["train", "tracker", "--plan", plan.to_str().unwrap(), "-o", to.to_str().unwrap(), change])
    };
    for (change, told) in [("ppo.gama=0.9", "gamma"), ("ppo.gamma=1.5", "ppo.gamma"), ("pop.gamma=1", "ppo")] {
        let output = train(change);
        assert_eq!(output.status.code(), Some(3), "{change}");
        assert!(err(&output).contains(told), "{change}: {}", err(&output));
    }
    assert!(!to.exists());
}

#[test]
fn physics_is_measured() {
    let bench = ["bench", "engine", "lima", "--ground", "flat,hills", "--environments", "8,16", "--seconds", "0.02"];
    let report = json(&[&bench[..], &["--engine", "lifelike"]].concat());
    assert_eq!(report["rates"].as_array().unwrap().len(), 4);
    assert!(report["rates"][0]["throughput"]["core"].as_f64().unwrap() > 100.0);
    let stages = report["breakdowns"][0]["stages"].as_array().unwrap();
    assert!(stages.iter().all(|s| s["operations"].as_f64().unwrap() > 10.0));
    for wrong in [["--seconds", "0"], ["--environments", "0"], ["--engine", "warp"]] {
        assert_eq!(lifelike(&[&bench[..3], &wrong].concat()).status.code(), Some(2), "{wrong:?}");
    }
}

#[test]
fn without_mujoco_the_command_says_what_to_do() {
    let empty = tempfile::tempdir().unwrap();
    let eval = ["eval", "--engine", "mujoco", "--policy", "p", "--motions", "m", "-o", "o"];
    let train = ["train", "tracker", "--engine", "mujoco", "--plan", "experiments/track.toml"];
    let robot = ["simulate-robot", "lima", "--engine", "mujoco"];
    for arguments in
        [&eval[..], &train, &["demo", "--engine", "mujoco"], &robot, &["bench", "runtime", "--engine", "mujoco"]]
    {
        let output = Command::new(env!("CARGO_BIN_EXE_lifelike"))
            .args(arguments)
            .env("LIFELIKE_MUJOCO", empty.path())
            .current_dir(root())
            .output()
            .unwrap();
        assert_eq!(output.status.code(), Some(4), "{arguments:?}");
        assert!(err(&output).contains("then run once: lifelike fetch mujoco"), "{}", err(&output));
    }
}

/// A tiny policy through its whole life: trained, stopped and resumed, inspected, evaluated, shown.
#[test]
fn a_policy_is_trained_resumed_inspected_and_evaluated() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    std::fs::write(folder.path().join("plan.toml"), TINY).unwrap();
    let train = |to: &str, more: &[&str]| {
        let (plan, to) = (path("plan.toml"), path(to));
        json(&[&["train", "tracker", "--plan", &plan, "-o", &to][..], more].concat())
    };
    let whole = train("whole", &["--threads", "1"]);
    assert_eq!(whole["steps"], 4 * 8 * 4);
    train("parts", &["--threads", "2", "budget.steps=64"]);
    train("parts", &["--resume", "budget.steps=128"]);
    let read = |run: &str, file: &str| std::fs::read(folder.path().join(run).join(file)).unwrap();
    for file in ["metrics.jsonl", "tracker.controller.safetensors"] {
        assert_eq!(read("whole", file), read("parts", file), "{file}: resumed and threaded, yet the same bytes");
    }
    assert!(!read("whole", "report.html").is_empty());

    let policy = path("whole/tracker.controller.safetensors");
    let seen = json(&["inspect", &policy]);
    assert_eq!((&seen["kind"], &seen["header"]["robot"]), (&"controller".into(), &"lima".into()));
    let last = seen["observation"].as_array().unwrap().last().unwrap()["end"].clone();
    let first: u64 = seen["observation"]
        .as_array()
        .unwrap()
        .iter()
        .map(|p| p["end"].as_u64().unwrap() - p["start"].as_u64().unwrap())
        .sum();
    assert_eq!(last, first, "parts lie side by side");

    let report = path("report");
    let eval = ["eval", "--policy", &policy, "--motions", "motions/nod.keys.toml", "-o", &report, "--starts", "2"];
    let evaluation = json(&eval);
    assert_eq!(evaluation["overall"]["episodes"], 2);
    assert!(evaluation["overall"]["joint_error_deg"].as_f64().unwrap() > 0.0);
    let page = std::fs::read_to_string(folder.path().join("report/report.html")).unwrap();
    assert!(page.contains("nod"));
    for network in ["src=\"http", "href=\"http", "@import", "fetch(", "XMLHttpRequest"] {
        assert!(!page.contains(network), "a report needs no network: {network}");
    }
    let mended = path("mended");
    // The thesis' protocol beside it: every frame of every episode counts, whether the robot is on its feet or not.
    let thesis =
        ["eval", "--policy", &policy, "--motions", "motions/nod.keys.toml", "motions/bow.keys.toml", "-o", &report];
    let by_thesis =
        [&thesis[..], &["--protocol", "thesis", "--episodes", "3", "--seconds", "2", "--patience", "0.5"]].concat();
    let found = json(&by_thesis);
    assert_eq!((found["frames"].as_u64(), found["clips"].as_u64()), (Some(300), Some(2)), "{found}");
    assert_eq!(
        (found["protocol"]["distance"].as_f64(), found["protocol"]["patience"].as_f64()),
        (Some(0.3), Some(0.5))
    );
    let [rotation, tilt] = ["root_rotation_error_deg", "root_tilt_error_deg"].map(|key| found[key].as_f64().unwrap());
    assert!(rotation >= tilt && tilt > 0.0, "{found}");
    let wide = lifelike(&by_thesis);
    assert!(
        out(&wide)
            .lines()
            .all(|line| line.chars().count() <= 100 || ["report:", "  lifelike "].iter().any(|p| line.starts_with(p))),
        "{}",
        out(&wide)
    );
    let lone = lifelike(&[&thesis[..], &["--episodes", "3"]].concat());
    assert!(lone.status.code() == Some(2) && err(&lone).contains("expected --protocol thesis"), "{}", err(&lone));
    std::fs::write(path("families.txt"), "Ground *bow*\nDaily *\n").unwrap();
    let families = json(&[&thesis[..], &["--starts", "1", "--families", &path("families.txt")]].concat());
    let names: Vec<_> = families["groups"].as_array().unwrap().iter().map(|g| g["clip"].as_str().unwrap()).collect();
    assert!(names.ends_with(&["Ground", "Daily"]), "{names:?}");
    assert!(families["overall"]["heat"].as_f64().unwrap() > 0.0, "{}", families["overall"]);
    assert!(families["overall"]["human_tracker_success"].is_number() && families["overall"]["r_mpkpe_m"].is_number());

    let told = json(&[&eval[..], &["--explain", "--apply", &mended]].concat());
    assert_eq!(told["overall"], evaluation["overall"], "explaining changes no score");
    let explanations = told["explanations"].as_array().unwrap();
    let fell = told["clips"].as_array().unwrap().iter().filter(|c| c["survival"].as_f64().unwrap() < 1.0).count();
    assert_eq!(explanations.len(), fell);
    let helped = explanations.iter().filter(|e| !e["remedy"].is_null()).count();
    assert_eq!(std::fs::read_dir(&mended).map_or(0, Iterator::count), helped);

    let bears = path("bears");
    let bench =
        ["bench", "robustness", "--policy", &policy, "--motions", "motions/nod.keys.toml", "-o", &bears, "--quick"];
    let bench = [&bench[..], &["--seconds", "0.5", "--only", "push root", "--only", "hills"]].concat();
    let found = json(&[&bench[..], &["--threads", "1"]].concat());
    assert_eq!(found["curves"].as_array().unwrap().len(), 2);
    assert_eq!(found["curves"][1]["points"][0]["size"], 0.0);
    assert_eq!(found, json(&[&bench[..], &["--threads", "2"]].concat()), "threads change nothing");
    let page = std::fs::read_to_string(folder.path().join("bears/report.html")).unwrap();
    assert!(page.contains("push root") && folder.path().join("bears/robustness.json").is_file());
    let unknown = lifelike(&[&bench[..], &["--only", "wind"]].concat());
    assert_eq!(unknown.status.code(), Some(2), "{}", err(&unknown));

    let demo = path("demo");
    let shown = json(&["demo", "--policy", &policy, "motions/nod.keys.toml", "-o", &demo]);
    assert!(Path::new(shown["report"].as_str().unwrap()).is_file());
    let other = lifelike(&["eval", "--robot", "humanoid", "--policy", &policy, "--motions", "motions", "-o", &report]);
    assert_eq!(other.status.code(), Some(3), "another robot's policy is refused: {}", err(&other));
}
