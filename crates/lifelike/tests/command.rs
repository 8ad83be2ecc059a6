//! The command as people and scripts meet it: arguments in, text or JSON and exit codes out.

#![allow(clippy::unwrap_used, clippy::expect_used)]

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use serde_json::Value;

fn lifelike(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_lifelike")).args(arguments).current_dir(root()).output().unwrap()
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn out(output: &Output) -> String {
    String::from_utf8(output.stdout.clone()).unwrap()
}

fn err(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).unwrap()
}

fn json(arguments: &[&str]) -> Value {
    let output = lifelike(&[&["--json"], arguments].concat());
    assert!(output.status.success(), "{arguments:?}: {}", err(&output));
    serde_json::from_str(&out(&output)).unwrap()
}

/// Our own clips on Lima, in a folder of the test's.
fn retargeted(folder: &Path) -> Value {
    json(&["motion", "retarget", "motions/wave.keys.toml", "motions/nod.keys.toml", "-o", folder.to_str().unwrap()])
}

#[test]
fn every_command_teaches_by_example() {
    let commands: [&[&str]; 25] = [
        &["robots"],
        &["inspect"],
        &["motion", "retarget"],
        &["motion", "convert"],
        &["motion", "search"],
        &["motion", "interpolate"],
        &["bench", "curves"],
        &["bench", "latent"],
        &["bench", "tracking"],
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
    refused(&["motion", "convert", &wave, &wave], "another file than the input");
    refused(&["motion", "convert", &at("wave.csv"), "--to", "gmr", "-o", &all], "--layout lafan1 or --layout kimodo");
    refused(&["motion", "retarget", &at("wave.csv"), "--layout", "lafan1", "-o", &all], "every clip was refused");

    // From one robot to another.
    let other = ["motion", "retarget", &wave, "--source-robot", "lima", "--robot", "humanoid", "-o", &all, "fps=25"];
    let report = json(&other);
    assert_eq!(report["summary"]["converted"], 1, "{report}");
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
fn latent_spaces_are_compared() {
    let folder = tempfile::tempdir().unwrap();
    let (prior, motions) = small_prior(folder.path());
    let to = folder.path().join("latent");
    let arguments = ["bench", "latent", "--prior", &prior, &prior, "--motions", &motions];
    let unseen = ["--unseen", "motions/bow.keys.toml", "-o", to.to_str().unwrap()];
    let value = json(&[&arguments[..], &unseen].concat());
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

    let text = out(&lifelike(&arguments));
    assert!(text.contains("CALM") && text.contains("0.687") && text.contains("joints (deg)"), "{text}");
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
    let spaces = json(&["bench", "latent", "--prior", &prior, "--motions", &motions]);
    assert_eq!(spaces["table"][0]["dimension"], 12);
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
    let policy = path("SM/tracker.policy.safetensors");
    let eval =
        ["eval", "--policy", &policy, "--motions", "motions/nod.keys.toml", "-o", &path("report"), "--starts", "2"];
    let evaluation = json(&[&eval[..], &["--prior", &prior]].concat());
    assert_eq!(evaluation["overall"]["episodes"], 2);
    assert!(evaluation["overall"]["joint_error_deg"].as_f64().unwrap() > 0.0);

    // In its run's folder a policy's prior is found by the plan beside it; elsewhere it has to be named.
    assert!(lifelike(&eval).status.success());
    let alone = path("alone.policy.safetensors");
    std::fs::copy(&policy, &alone).unwrap();
    let eval =
        ["eval", "--policy", &alone, "--motions", "motions/nod.keys.toml", "-o", &path("report"), "--starts", "2"];
    let without = lifelike(&eval);
    let digest = json(&["inspect", &policy])["header"]["prior"].as_str().unwrap().to_owned();
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

#[cfg(not(feature = "mujoco"))]
#[test]
fn without_mujoco_the_command_says_what_to_do() {
    let eval = ["eval", "--engine", "mujoco", "--policy", "p", "--motions", "m", "-o", "o"];
    let train = ["train", "tracker", "--engine", "mujoco", "--plan", "experiments/track.toml"];
    for arguments in [&eval[..], &train, &["demo", "--engine", "mujoco"]] {
        let output = lifelike(arguments);
        assert_eq!(output.status.code(), Some(4), "{arguments:?}");
        assert!(err(&output).contains("cargo xtask"), "{}", err(&output));
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
    for file in ["metrics.jsonl", "tracker.policy.safetensors"] {
        assert_eq!(read("whole", file), read("parts", file), "{file}: resumed and threaded, yet the same bytes");
    }
    assert!(!read("whole", "report.html").is_empty());

    let policy = path("whole/tracker.policy.safetensors");
    let seen = json(&["inspect", &policy]);
    assert_eq!((&seen["kind"], &seen["header"]["robot"]), (&"policy".into(), &"lima".into()));
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
    let bench = ["--json", "bench", "tracking", "--study", &study, "-o", &to, "--threads", "1"];
    let name = |run: &Value| format!("{} {}", run["variant"].as_str().unwrap(), run["stage"].as_str().unwrap());
    let trained = |only: &str| -> Vec<String> {
        let done = lifelike(&[&bench[..], &["--only", only]].concat());
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
    let other = lifelike(&[&bench[..], &["--only", "B", "--seeds", "2"]].concat());
    let runs: Value = serde_json::from_slice(&other.stdout).unwrap();
    let told: Vec<_> =
        runs["runs"].as_array().unwrap().iter().map(|run| (name(run), run["seed"].as_u64().unwrap())).collect();
    assert_eq!(told, [("B first".to_owned(), 2), ("B second".to_owned(), 2)]);
    // Both protocols of the same policy, and a curve of each metric and stage over the seeds that are there.
    let run = &runs["runs"][1];
    assert_eq!((&run["thesis"][0]["frames"], run["deviation"].as_f64()), (&Value::from(40), Some(0.3)), "{run}");
    assert!(run["scores"][0]["joint_error_deg"].as_f64().unwrap() > 0.0);
    let curve =
        runs["curves"].as_array().unwrap().iter().find(|c| c["metric"] == "joint error in training [deg]").unwrap();
    assert_eq!((&curve["variant"], &curve["seeds"]), (&Value::from("B"), &serde_json::json!([2])), "{curve}");
    assert!(curve["mean"][0].as_f64().unwrap() > 0.0 && curve["mean"] == curve["low"], "{curve}");
    assert!(std::fs::read_to_string(folder.path().join("runs/report.html")).unwrap().contains("class=\"band c0\""));
    let twice = lifelike(&[&bench[..], &["--seeds", "2,2"]].concat());
    assert!(err(&twice).contains("expected every seed once, got 2 twice"), "{}", err(&twice));
}

const TINY: &str = r#"
robot = "lima"
clips = ["motions/nod.keys.toml"]
checkpoint_every = 1
[budget]
steps = 128
[network]
actor = [8]
critic = [8]
[ppo]
environments = 4
steps = 8
minibatch = 16
epochs = 1
"#;
