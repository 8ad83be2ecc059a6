//! `lifelike train generator` and `lifelike generate`: a tiny training, its file, motion from it, and what is refused.

#![allow(clippy::unwrap_used)]

use std::path::Path;

use crate::in_folder::{json, refused, run};
use lifelike_motion::container;
use lifelike_robot::{Robot, clips};

const TINY: [&str; 12] = [
    "width=16",
    "layers=1",
    "heads=2",
    "inner=16",
    "pieces=150",
    "batch=4",
    "iterations=6",
    "diffusion_steps=8",
    "max_seconds=3.0",
    "warmup=0",
    "validate_every=3",
    "clips=[\"builtin\"]",
];

#[test]
fn a_sentence_becomes_a_clip_and_what_is_none_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let plan = ["train", "generator", "--plan", "generator", "-o", "run"];
    let trained = json(at, &[&plan[..], &TINY].concat());
    assert_eq!(trained["iterations"], 6);
    let generator = "run/motion.generator.safetensors";

    let words = ["generate", "a person walks", "--as-is", "--generator", generator, "--seconds", "1"];
    let make = |more: &[&str]| json(at, &[&words[..], more].concat());
    let made = make(&["-o", "walk.motion.safetensors", "--seed", "3"]);
    assert_eq!(made["motions"][0]["files"], serde_json::json!(["walk.motion.safetensors"]));
    let clip = container::read(&at.join("walk.motion.safetensors")).unwrap();
    assert_eq!((clip.name.as_str(), clip.len(), clip.fps), ("walk", 51, 50.0));
    assert_eq!(clip.provenance.captions[0].text, "a person walks");
    assert!(clip.provenance.source.contains("of seed 3; "), "{}", clip.provenance.source);
    make(&["-o", "again.motion.safetensors", "--seed", "3"]);
    assert_eq!(container::read(&at.join("again.motion.safetensors")).unwrap().joints, clip.joints);
    let unknown =
        ["generate", "a person cartwheels", "--as-is", "--generator", generator, "-o", "no.motion.safetensors"];
    let said = String::from_utf8(run(at, &unknown).stdout).unwrap();
    assert!(said.contains(", but 'cartwheels' was not understood"), "{said}");
    json(at, &["motion", "check", "walk.motion.safetensors", "--robot", "lima"]);
    the_best_comes_first(at, generator);
    parts_follow_each_other(at, generator);
    limbs_are_kept(at, generator);
    poses_are_passed_through(at, generator);
    lines_become_clips(at, generator);
    physics_is_played(at, generator);

    let with = |prompt: &str, more: &[&str]| {
        let words = ["generate", prompt, "--as-is", "--generator", generator, "-o", "x.motion.safetensors"];
        refused(at, &[&words[..], more].concat())
    };
    assert!(with("", &[]).contains("prompt"));
    assert!(with("walk\u{7}", &[]).contains("prompt"));
    assert!(with(&"walk ".repeat(5000), &[]).contains("prompt"));
    assert!(with("走る", &[]).contains("Latin letter"));
    assert!(with("a person walks", &["--then", "walk\u{7}"]).contains("prompt"));
    assert!(with("a person walks", &["--seconds", "60"]).contains("0.5 to 3"));
    assert!(with("a person walks", &["--steps", "9"]).contains("1 to 8"));
    assert!(with("a person walks", &["--robot", "humanoid"]).contains("train one for it"));
    assert!(!at.join("x.motion.safetensors").exists());
    let none = ["generate", "a person walks", "--generator", "walk.motion.safetensors", "-o", "x.motion.safetensors"];
    assert!(refused(at, &none).contains("walk.motion.safetensors"));
}

/// Of several candidates the best is written, and all of them by rank where that is asked for.
fn the_best_comes_first(at: &Path, generator: &str) {
    let words = ["generate", "a person walks", "--as-is", "--generator", generator, "--seconds", "1", "--steps", "3"];
    let make = |more: &[&str]| json(at, &[&words[..], &["--candidates", "3"], more].concat());
    let one = make(&["-o", "one.motion.safetensors"]);
    assert_eq!(one["motions"][0]["files"].as_array().unwrap().len(), 1);
    assert!(!at.join("one-2.motion.safetensors").exists());
    let all = make(&["-o", "many.motion.safetensors", "--keep-all"]);
    let motion = &all["motions"][0];
    assert_eq!(motion["files"][2], "many-3.motion.safetensors");
    let bad: Vec<f64> = (0..3).map(|i| motion["verdicts"][i]["bad_seconds"].as_f64().unwrap()).collect();
    assert!(bad[0] <= bad[1] && bad[1] <= bad[2], "{bad:?}");
    let read = |file: &str| container::read(&at.join(file)).unwrap();
    assert_eq!(read("one.motion.safetensors").joints, read("many.motion.safetensors").joints);
    let verdict = read("many-3.motion.safetensors").provenance.source;
    assert!(verdict.contains("feasible"), "{verdict}");
}

/// A continuation has a caption of its own and goes on where the first part was: no step is larger than elsewhere.
fn parts_follow_each_other(at: &Path, generator: &str) {
    let words = ["generate", "a person walks", "--then", "a person waves", "--then", "a person nods"];
    json(
        at,
        &[&words[..], &["--as-is", "--generator", generator, "--seconds", "2", "-o", "then.motion.safetensors"]]
            .concat(),
    );
    let clip = container::read(&at.join("then.motion.safetensors")).unwrap();
    let captions: Vec<&str> = clip.provenance.captions.iter().map(|c| c.text.as_str()).collect();
    assert_eq!(captions, ["a person walks", "a person waves", "a person nods"]);
    // Rows of 20 Hz: two seconds, and two more of each part that goes on.
    assert!((clip.seconds() - 6.1).abs() < 0.11, "{}", clip.seconds());
    assert!((clip.provenance.captions[1].start - 2.0).abs() < 1e-9);
    let step = |t: usize| {
        let pairs = clip.joints_at(t).iter().zip(clip.joints_at(t + 1));
        pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    };
    let seam = (95..105).map(step).fold(0.0, f64::max);
    let most = (0..95).map(step).fold(0.0, f64::max);
    assert!(seam <= 2.0 * most, "{seam} at the seam, {most} before");
}

/// Legs that are kept are those of the clip, and its length is taken.
fn limbs_are_kept(at: &Path, generator: &str) {
    let words = ["generate", "a person waves", "--as-is", "--generator", generator];
    json(at, &[&words[..], &["--keep-arms", "builtin:wave", "-o", "arms.motion.safetensors"]].concat());
    let own = clips::load_one(Path::new("builtin:wave"), &Robot::load("lima").unwrap()).unwrap();
    let made = container::read(&at.join("arms.motion.safetensors")).unwrap();
    assert!((made.seconds() - own.seconds().min(3.0)).abs() < 0.051, "{} of {}", made.seconds(), own.seconds());
    assert!(made.provenance.source.contains("with the arms of 'wave'"), "{}", made.provenance.source);
    let column =
        |clip: &lifelike_motion::MotionClip, name: &str| clip.joint_names.iter().position(|n| n == name).unwrap();
    let error = |name: &str| {
        let of = |t: usize| (made.joints_at(t)[column(&made, name)] - own.joints_at(t)[column(&own, name)]).abs();
        (0..made.len().min(own.len())).map(of).fold(0.0, f64::max)
    };
    // Every row is the clip's; between two of them, 0.05 s apart, lies a cubic.
    assert!(
        error("left_elbow") < 0.05 && error("right_elbow") < 0.05,
        "{} {}",
        error("left_elbow"),
        error("right_elbow")
    );
    json(at, &[&words[..], &["--keep-legs", "builtin:wave", "-o", "legs.motion.safetensors"]].concat());
    let both = [&words[..], &["--keep-legs", "own", "--keep-arms", "own", "-o", "x.motion.safetensors"]].concat();
    assert_eq!(run(at, &both).status.code(), Some(2));
    let long =
        [&words[..], &["--keep-legs", "walk.motion.safetensors", "--seconds", "2.5", "-o", "x.motion.safetensors"]];
    assert!(refused(at, &long.concat()).contains("length asked for"));
}

/// At a moment the robot is in the pose that was given, whatever the network makes of the rest.
fn poses_are_passed_through(at: &Path, generator: &str) {
    let words = ["generate", "a person waves", "--generator", generator, "--seconds", "3"];
    let posed = ["--pose", "builtin:wave:1.0@1", "--pose", "builtin:bow:1.2@2.5", "-o", "posed.motion.safetensors"];
    json(at, &[&words[..], &posed].concat());
    let made = container::read(&at.join("posed.motion.safetensors")).unwrap();
    assert!(made.provenance.source.contains("with poses of 'builtin:wave' at 1 s"), "{}", made.provenance.source);
    let robot = Robot::load("lima").unwrap();
    for (name, then, now) in [("builtin:wave", 1.0, 1.0), ("builtin:bow", 1.2, 2.5)] {
        let own = clips::load_one(Path::new(name), &robot).unwrap();
        let frame =
            |clip: &lifelike_motion::MotionClip, t: f64| clip.joints_at((t * clip.fps).round() as usize).to_vec();
        let (expected, got) = (frame(&own, then), frame(&made, now));
        for (j, joint) in made.joint_names.iter().enumerate().filter(|(_, joint)| joint.contains("shoulder")) {
            assert!((expected[j] - got[j]).abs() < 0.03, "{name}, {joint}: {} for {}", got[j], expected[j]);
        }
    }
    let late = [&words[..], &["--pose", "builtin:bow@9", "-o", "x.motion.safetensors"]].concat();
    assert!(refused(at, &late).contains("time of a pose"));
    let beyond = [&words[..], &["--pose", "builtin:bow:99@1", "-o", "x.motion.safetensors"]].concat();
    assert!(refused(at, &beyond).contains("expected a time of 'bow'"));
}

/// A file of prompts becomes a folder of clips; a bad line is named before anything is written.
fn lines_become_clips(at: &Path, generator: &str) {
    std::fs::write(at.join("prompts.txt"), "# ours\na person walks\n\na person qwertys\n").unwrap();
    let words =
        ["generate", "--prompts", "prompts.txt", "--as-is", "--generator", generator, "--seconds", "1", "-o", "batch"];
    let output = run(at, &words);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(String::from_utf8_lossy(&output.stderr).contains("'qwertys' is in no caption"));
    let clip = container::read(&at.join("batch/002-a-person-qwertys.motion.safetensors")).unwrap();
    assert_eq!(clip.provenance.captions[0].text, "a person qwertys");
    std::fs::write(at.join("prompts.txt"), "a person walks\n走る\n").unwrap();
    assert!(refused(at, &[&words[..9], &["none"]].concat()).contains("prompts.txt:2: "));
    assert!(!at.join("none").exists());
    assert_eq!(run(at, &["generate", "-o", "x.motion.safetensors"]).status.code(), Some(2));
}

/// The shipped controller plays what was made, and ends in a page.
fn physics_is_played(at: &Path, generator: &str) {
    let words = [
        "generate",
        "a person walks",
        "--as-is",
        "--generator",
        generator,
        "--seconds",
        "1",
        "-o",
        "p.motion.safetensors",
    ];
    let played = json(at, &[&words[..], &["--physics"]].concat());
    let line = played["physics"]["lines"][0].as_str().unwrap();
    assert!(line.starts_with("in physics: ") && line.contains("joint error"), "{line}");
    assert!(std::fs::read_to_string(at.join("p-physics/report.html")).unwrap().contains("a person walks"));
    let none = [&words[..], &["--physics", "--policy", "none.controller.safetensors"]].concat();
    assert!(refused(at, &none).contains("none.controller"));
    assert_eq!(run(at, &[&words[..], &["--policy", "x"]].concat()).status.code(), Some(2));
}

#[test]
fn a_robot_without_networks_is_told_how_to_get_them() {
    let folder = tempfile::tempdir().unwrap();
    // Networks are found by joints: nothing ships for a robot with other ones, whatever ships for ours.
    let ours = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../robots");
    let model = std::fs::read_to_string(ours.join("lima.xml")).unwrap();
    std::fs::write(folder.path().join("own.xml"), model.replace("neck_yaw", "neck_turn")).unwrap();
    std::fs::copy(ours.join("lima.toml"), folder.path().join("own.toml")).unwrap();
    let words = ["generate", "a person walks", "--robot", "own.xml", "-o", "x.motion.safetensors"];
    let error = refused(folder.path(), &[&words[..], &["--as-is"]].concat());
    assert!(error.contains("lifelike train generator --plan generator --robot own.xml"), "{error}");
    // The grammar's rules need no network.
    let made = json(folder.path(), &words);
    assert_eq!(made["motions"][0]["parts"][0]["by"], "rules");
    let error = refused(folder.path(), &["demo", "--robot", "own.xml"]);
    assert!(error.contains("lifelike train tracker --plan track --robot own.xml"), "{error}");
}

#[test]
fn plans_name_what_is_wrong() {
    let folder = tempfile::tempdir().unwrap();
    let plan =
        |change: &str| refused(folder.path(), &["train", "generator", "--plan", "generator", "-o", "run", change]);
    assert!(plan("batch=0").contains("batch: expected 1 to 65536, got 0"));
    assert!(plan("heads=3").contains("heads"));
    assert!(plan("clips=[\"nowhere\"]").contains("nowhere"));
    assert!(plan("space.kind=\"bezier\"").contains("bezier"));
}

#[test]
fn a_sentence_in_free_words_is_done_as_said_and_checked() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let sentence = "take exactly three steps, turn 135 degrees left, then bow twice";
    let made = json(at, &["generate", sentence, "--physics", "--strict", "-o", "a.motion.safetensors"]);
    let motion = &made["motions"][0];
    let verbs: Vec<&str> = motion["script"]["clause"]
        .as_array()
        .unwrap()
        .iter()
        .map(|clause| clause["action"][0]["verb"].as_str().unwrap())
        .collect();
    assert_eq!(verbs, ["step_forward", "turn", "bow"]);
    for part in motion["parts"].as_array().unwrap() {
        for finding in part["findings"].as_array().unwrap() {
            assert_eq!(finding["passed"], true, "{finding}");
        }
    }
    let lines = made["physics"]["lines"].to_string();
    assert!(lines.contains("facts hold"), "{lines}");
    // The script is a file that can be changed and done again.
    let script = std::fs::read_to_string(at.join("a.script.toml")).unwrap();
    std::fs::write(at.join("b.toml"), script.replace("degrees = 135", "degrees = 60")).unwrap();
    let again = json(at, &["generate", "--script", "b.toml", "-o", "b.motion.safetensors"]);
    let turn = &again["motions"][0]["parts"][1]["findings"];
    let degrees = turn.as_array().unwrap().iter().find(|f| f["fact"] == "degrees").unwrap();
    let got: f64 = degrees["got"].as_str().unwrap().parse().unwrap();
    assert!((got - 60.0).abs() < 10.0, "{got}");
    // Seeds differ, the same seed does not.
    let made = |seed: &str, file: &str| {
        json(at, &["generate", "a man waves", "--seed", seed, "--made-by", "rules", "-o", file]);
        container::read(&at.join(file)).unwrap().joints
    };
    assert_eq!(made("1", "1.motion.safetensors"), made("1", "2.motion.safetensors"));
    assert_ne!(made("1", "1.motion.safetensors"), made("2", "3.motion.safetensors"));
}

#[test]
fn what_cannot_be_done_is_refused_with_the_nearest() {
    let folder = tempfile::tempdir().unwrap();
    let with = |words: &[&str]| {
        let all = [&["generate"], words, &["-o", "x.motion.safetensors"]].concat();
        refused(folder.path(), &all)
    };
    let error = with(&["swim across the pool"]);
    assert!(error.contains("there is no water"), "{error}");
    let error = with(&["lie down"]);
    assert!(error.contains("the nearest is 'crouch': --nearest"), "{error}");
    assert!(with(&["defenestrate"]).contains("understood none"));
    std::fs::write(folder.path().join("s.toml"), "[[clause]]\n[[clause.action]]\nverb = \"swim\"\n").unwrap();
    assert!(with(&["--script", "s.toml"]).contains("s.toml:3: "));
    assert!(!folder.path().join("x.motion.safetensors").exists());
    let made = json(folder.path(), &["generate", "lie down", "--nearest", "-o", "x.motion.safetensors"]);
    assert_eq!(made["motions"][0]["script"]["clause"][0]["action"][0]["verb"], "crouch");
    let listed = json(folder.path(), &["generate", "--verbs"]);
    let grammar = lifelike_language::grammar::Grammar::builtin().unwrap();
    assert_eq!(listed.as_array().unwrap().len(), grammar.verbs.len());
}

/// Sentences come while the robot moves; one that cannot be done is refused and forgotten.
#[test]
fn sentences_from_standard_input_are_done_in_physics() {
    use std::io::Write;
    let folder = tempfile::tempdir().unwrap();
    let mut child = std::process::Command::new(env!("CARGO_BIN_EXE_lifelike"))
        .args(["--json", "generate", "--live", "-o", "said"])
        .current_dir(folder.path())
        .stdin(std::process::Stdio::piped())
        .stdout(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    child.stdin.take().unwrap().write_all(b"wave with the left hand\nfly to the moon\n\nbow twice\n").unwrap();
    let done = child.wait_with_output().unwrap();
    assert!(done.status.success());
    let text = String::from_utf8(done.stdout).unwrap();
    let events: Vec<serde_json::Value> =
        serde_json::Deserializer::from_str(&text).into_iter().map(Result::unwrap).collect();
    let kinds: Vec<&str> = events.iter().map(|event| event["event"].as_str().unwrap()).collect();
    assert_eq!(kinds, ["said", "refused", "said", "end"], "{text}");
    assert!(events[1]["because"].as_str().unwrap().contains("cannot leave the ground"), "{text}");
    assert!(events[2]["understood"].as_str().unwrap().starts_with("bow, 2 times"), "{text}");
    assert_eq!(events[3]["falls"], 0);
    // The scene has the two that were done, and plays.
    let scene = std::fs::read_to_string(folder.path().join("said/live.scene.toml")).unwrap();
    assert!(scene.contains("wave with the left hand") && scene.contains("bow twice") && !scene.contains("moon"));
}

#[test]
fn one_command_makes_data_a_generator_and_its_test() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let words = ["train", "language", "-o", "words", "--hours", "0.02", "--minutes", "0.02", "--sentences", "2"];
    let planned = json(at, &[&words[..], &["--dry-run"]].concat());
    assert_eq!(planned["commands"].as_array().unwrap().len(), 3);
    assert!(!at.join("words").exists());
    let with = json(at, &[&words[..], &["--dry-run", "--policy", "lima"]].concat());
    let lines = with["commands"].as_array().unwrap();
    assert_eq!(lines.len(), 5);
    assert!(lines[3].as_str().unwrap().contains("--policy lima"), "{lines:?}");

    let made = json(at, &words);
    assert_eq!(made["steps"], serde_json::json!(["data", "generator", "test"]));
    assert!(at.join(made["generator"].as_str().unwrap()).is_file());
    let clips = || std::fs::read_dir(at.join("words/test")).unwrap().count();
    assert!(clips() > 0);
    // What is done stays done.
    std::fs::remove_dir_all(at.join("words/test")).unwrap();
    assert_eq!(json(at, &words)["steps"], made["steps"]);
    assert!(!at.join("words/test").exists());
    let other = run(at, &[&words[..], &["--seed", "2"]].concat());
    assert_eq!(other.status.code(), Some(2));
    assert!(String::from_utf8(other.stderr).unwrap().contains("other options"));
}

#[cfg(unix)]
#[test]
fn a_reader_is_asked_again_where_physics_fails_and_the_better_motion_stays() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    // Four steps of lima do not go so far; the second answer is what it can do.
    let far = r#"{"clause": [{"action": [{"verb": "walk", "count": 4, "metres": 4.0}]}]}"#;
    let near = r#"{"clause": [{"action": [{"verb": "walk", "count": 4}]}]}"#;
    let reader = format!(
        "cat > asked.txt; if grep -q 'this was measured' asked.txt; then cp asked.txt again.txt; echo '{near}'; else echo '{far}'; fi"
    );
    let words =
        ["generate", "walk far", "--made-by", "rules", "--physics", "--reader", &reader, "-o", "x.motion.safetensors"];
    let made = json(at, &words);
    let script = made["motions"][0]["script"].to_string();
    assert!(!script.contains("metres") && script.contains("read again after physics"), "{script}");
    let again = std::fs::read_to_string(at.join("again.txt")).unwrap();
    assert!(again.contains("distance: expected 4 m") && again.contains("in physics: "), "{again}");
    assert!(std::fs::read_to_string(at.join("x.script.toml")).unwrap().contains("count = 4"));
    let once = json(at, &[&words[..], &["--revise", "0"]].concat());
    assert!(once["motions"][0]["script"].to_string().contains("metres"));
    // A worse second answer changes nothing.
    let worse =
        format!("cat > asked.txt; if grep -q 'this was measured' asked.txt; then echo nothing; else echo '{far}'; fi");
    let kept = json(
        at,
        &["generate", "walk far", "--made-by", "rules", "--physics", "--reader", &worse, "-o", "y.motion.safetensors"],
    );
    assert!(kept["motions"][0]["script"].to_string().contains("metres"));
}
