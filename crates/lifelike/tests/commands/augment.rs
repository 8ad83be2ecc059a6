//! From logs of a test bench to traces, a report, fitted parameters and a trained augmentation.

#![allow(clippy::unwrap_used)]

use std::path::Path;
use std::process::{Command, Output};

use serde_json::{Value, json};

fn lifelike(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_lifelike")).args(arguments).output().unwrap()
}

/// As JSON; it must have worked.
fn result(arguments: &[&str]) -> Value {
    let output = lifelike(&[&["--json"], arguments].concat());
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

/// A log of a servo that follows its commands late and never quite.
fn write_log(path: &Path, frequency: f64) {
    let goal = |t: f64| 0.6 * (frequency * t).sin();
    let entry = |i: i32| {
        let t = 0.005 * f64::from(i);
        let position = 0.8 * goal(t - 0.03);
        let speed = 0.8 * 0.6 * frequency * (frequency * (t - 0.03)).cos();
        // As a servo tells its duty: 16 bits without a sign.
        let load = (200.0 * (goal(t) - position)).round().rem_euclid(65536.0);
        json!({ "timestamp": t, "goal_position": goal(t), "position": position, "speed": speed, "load": load,
                "input_volts": 7.4, "torque_enable": true })
    };
    let log = json!({ "mass": 0.3, "length": 0.1, "kp": 400.0, "vin": 7.4, "motor": "servo", "trajectory": "sine",
                      "entries": (0..400).map(entry).collect::<Vec<_>>() });
    std::fs::write(path, log.to_string()).unwrap();
}

#[test]
fn logs_become_traces_parameters_and_a_correction() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    std::fs::create_dir(at("logs")).unwrap();
    for (name, frequency) in [("a", 3.0), ("b", 5.0)] {
        write_log(&folder.path().join(format!("logs/{name}.json")), frequency);
    }
    let made = result(&["augment", "simulate", &at("logs"), "--servo", "xl330", "-o", &at("traces")]);
    assert_eq!(made["files"].as_array().unwrap().len(), 2);
    let plain = made["gap"][0]["mae"][0].as_f64().unwrap();

    let nameless = lifelike(&["augment", "simulate", &at("logs"), "-o", &at("nowhere")]);
    let said = String::from_utf8_lossy(&nameless.stderr).into_owned();
    assert!(!nameless.status.success() && said.contains("'servo'") && said.contains("xl330"), "{said}");
    let search = ["--servo", "xl330", "--friction", "m1", "--starts", "1", "-o", &at("s.toml")];
    let fitted = result(&[&["augment", "identify", &at("logs")], &search[..]].concat());
    let errors = fitted["errors"].as_array().unwrap();
    assert!(errors.iter().all(|own| own["mae_deg"].as_f64().unwrap() < plain.to_degrees()), "{errors:?}");
    result(&["augment", "simulate", &at("logs"), "--servo", &at("s.toml"), "-o", &at("fitted")]);

    let plan = format!("traces = ['{}']\n[augmentation]\nstretch = 100\niterations = 40\nbatch = 8\n", at("traces"));
    std::fs::write(at("plan.toml"), plan + "[augmentation.model]\nwidth = 8\nheads = 2\nhistory = 32\n").unwrap();
    let trained = result(&["train", "augmentation", "--plan", &at("plan.toml"), "-o", &at("run")]);
    let file = trained["augmentation"].as_str().unwrap();
    assert!(file.ends_with("servo.augmentation.safetensors"));
    let again = result(&["train", "augmentation", "--resume", "-o", &at("run")]);
    assert_eq!(again["iterations"], trained["iterations"], "what is done is left alone");

    let report = result(&["augment", "report", &at("traces"), "--augmentation", file, "-o", &at("report")]);
    let mae = |which: usize| report["summary"][which]["columns"][0]["mae"][0].as_f64().unwrap();
    assert!(mae(1) < mae(0), "{} of {}", mae(1), mae(0));
    assert!(folder.path().join("report/report.html").is_file() && folder.path().join("report/gap.json").is_file());
    let applied = result(&["augment", "apply", &at("traces"), "--augmentation", file, "-o", &at("corrected")]);
    let corrected = result(&["augment", "report", &at("corrected")]);
    assert_eq!(corrected["summary"][0]["columns"], report["summary"][1]["columns"]);
    assert_eq!(applied["files"].as_array().unwrap().len(), 2);
}

/// A table of a robot's joints beside its simulation, learned from, and the policy in the corrected simulation.
#[test]
fn a_robots_table_becomes_a_correction_that_a_policy_is_evaluated_with() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    let joint = "left_elbow";
    let row = |i: i32| {
        let t = 0.02 * f64::from(i);
        let goal = 20.0 * (3.0 * t).sin();
        format!("{t},{goal},{}\n", 0.9 * 20.0 * (3.0 * (t - 0.04)).sin())
    };
    std::fs::write(at("log.csv"), format!("t,goal,angle\n{}", (0..200).map(row).collect::<String>())).unwrap();
    let map = format!(
        "time = 't'\nrate = 50.0\n[block.{joint}]\nclass = 'neck'\n\
         reference.position = {{ column = 'goal', unit = 'deg' }}\nmeasured.position = {{ column = 'angle', unit = 'deg' }}\n"
    );
    std::fs::write(at("map.toml"), &map).unwrap();
    let simulate = ["augment", "simulate", &at("log.csv"), "--robot", "lima", "--map", &at("map.toml"), "-o", &at("t")];
    let made = result(&simulate);
    assert_eq!(made["gap"][0]["column"], "position");
    let plan = format!("traces = ['{}']\n[augmentation]\nstretch = 100\niterations = 20\nbatch = 8\n", at("t"));
    std::fs::write(at("plan.toml"), plan + "[augmentation.model]\nwidth = 8\nheads = 2\nhistory = 16\n").unwrap();
    let trained = result(&["train", "augmentation", "--plan", &at("plan.toml"), "-o", &at("run")]);
    let file = trained["augmentation"].as_str().unwrap();
    let policy = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets/lima-path.controller.safetensors");
    let policy = policy.to_str().unwrap();
    let eval = |more: &[&str]| {
        let clip = ["eval", "--policy", policy, "--motions", "builtin:wave", "--starts", "1", "-o", &at("eval")];
        result(&[&clip, more].concat()).to_string()
    };
    assert_ne!(eval(&[]), eval(&["--augment", file]), "another simulation is another result");

    // What does not fit is refused: the rate of the table, a joint that there is not.
    for (from, to, part) in [("rate = 50.0", "rate = 100.0", "100 Hz"), (joint, "left_wing", "'left_wing'")] {
        std::fs::write(at("map.toml"), map.replace(from, to)).unwrap();
        let output = lifelike(&simulate);
        let error = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(3), "{error}");
        assert!(error.contains(part), "{error}");
    }
}

#[test]
fn logs_that_cannot_be_right_are_refused_with_their_place() {
    let folder = tempfile::tempdir().unwrap();
    let log = folder.path().join("log.json");
    let refused = |change: &dyn Fn(&mut Value), part: &str| {
        write_log(&log, 3.0);
        let mut value: Value = serde_json::from_str(&std::fs::read_to_string(&log).unwrap()).unwrap();
        change(&mut value);
        std::fs::write(&log, value.to_string()).unwrap();
        let out = folder.path().join("out");
        let output = lifelike(&["augment", "simulate", log.to_str().unwrap(), "-o", out.to_str().unwrap()]);
        let error = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(3), "{error}");
        assert!(error.contains(part), "{error}");
    };
    refused(&|log| log["entries"][7]["position"] = json!(35.0), "entry 7, position: expected radians");
    refused(&|log| log["entries"][9]["timestamp"] = json!(0.01), "entry 9, timestamp: expected a time after");
    let gap = |log: &mut Value| {
        for i in 200..400 {
            log["entries"][i]["timestamp"] = json!(0.005 * i as f64 + 0.3);
        }
    };
    refused(&gap, "entry 200, timestamp: expected no gap");
    refused(&|log| log["mass"] = json!(0.0), "mass: expected a number above 0");
    refused(&|log| drop(log["entries"][3].as_object_mut().unwrap().remove("speed")), "missing field `speed`");
}

#[test]
fn a_robot_that_is_fixed_is_excited_stood_in_for_by_a_twin_and_learned_from() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    let robot = concat!(env!("CARGO_MANIFEST_DIR"), "/../robot/robots/kickbot.xml");
    let excited =
        result(&["augment", "excite", "--robot", robot, "--runs", "5", "--seconds", "2", "-o", &at("references")]);
    assert_eq!(excited["coverage"].as_array().unwrap().len(), 12);
    let made = result(&["augment", "twin", &at("references"), "--robot", robot, "--seed", "3", "-o", &at("traces")]);
    let columns: Vec<&str> =
        made["gap"].as_array().unwrap().iter().map(|own| own["column"].as_str().unwrap()).collect();
    for column in ["position", "velocity", "current", "position_xyz", "orientation"] {
        assert!(columns.contains(&column), "{columns:?}");
    }
    let plan = |class: &str, output: &str| {
        let model = "[augmentation.model]\nwidth = 8\nheads = 2\nhistory = 32\n";
        let plan = format!("traces = ['{}']\n[augmentation]\nclass = '{class}'\noutputs = [{output}]\n", at("traces"));
        std::fs::write(at("plan.toml"), plan + "stretch = 100\niterations = 150\nbatch = 8\n" + model).unwrap();
        result(&["train", "augmentation", "--plan", &at("plan.toml"), "-o", &at(class)])["blocks"].clone()
    };
    assert_eq!(plan("xm430", "'position', 'velocity'"), 5 * 12);
    assert_eq!(plan("body", "'position_x', 'position_y', 'position_z'"), 5 * 12);
    let report =
        result(&["augment", "report", &at("traces"), "--augmentation", &at("xm430/xm430.augmentation.safetensors")]);
    let mae = |which: usize| report["summary"][which]["columns"][0]["mae"][0].as_f64().unwrap();
    assert!(mae(1) < mae(0), "{} of {}", mae(1), mae(0));

    let estimated = result(&[
        "augment",
        "estimate",
        &at("traces/random_001.trace.safetensors"),
        "--robot",
        robot,
        "--augmentation",
        &at("xm430/xm430.augmentation.safetensors"),
        "--augmentation",
        &at("body/body.augmentation.safetensors"),
        "-o",
        &at("estimated"),
    ]);
    let of = |what: &str, column: &str| {
        let columns = estimated[what].as_array().unwrap();
        columns.iter().find(|own| own["column"] == column).unwrap()["mae"][0].as_f64().unwrap()
    };
    assert!(of("estimate", "position") < 0.7 * of("simulation", "position"), "{estimated}");
    assert!(of("estimate", "position_xyz") < of("simulation", "position_xyz"), "{estimated}");

    let poses = "seconds = 2.0\n[[pose]]\ntime = 0.5\njoints = { tail = 3 }\n";
    std::fs::write(at("wag.poses.toml"), poses).unwrap();
    let output = lifelike(&["augment", "excite", "--robot", robot, "--poses", &at("wag.poses.toml"), "-o", &at("wag")]);
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(
        !output.status.success() && text.contains("wag.poses.toml: pose 1: expected joints of 'kickbot'"),
        "{text}"
    );
    let output = lifelike(&["augment", "excite", "--robot", "lima", "-o", &at("lima")]);
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(!output.status.success() && text.contains("a robot that is fixed to the world"), "{text}");
}
