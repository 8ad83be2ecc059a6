//! `lifelike-thesis generation`: tiny networks from data set to tables, and what is refused.

use std::path::Path;

use crate::programs::{at as path, json, lifelike, run};
use lifelike_generation::critic::{CriticData, CriticPlan, CriticTrainer, RewardRecords, StepEnd};
use lifelike_generation::data::CaptionedMotion;
use lifelike_generation::representation::RepresentationSpec;
use lifelike_language::facts::{Action, Facts, HeldOut, Relation, Side};
use lifelike_language::{CaptionedSet, Entry, Split};
use lifelike_motion::container;
use lifelike_robot::{Robot, clips};
use serde_json::{Value, json};

const GENERATOR: [&str; 11] = [
    "width=16",
    "layers=1",
    "heads=2",
    "inner=16",
    "pieces=150",
    "batch=4",
    "iterations=4",
    "diffusion_steps=4",
    "max_seconds=20.0",
    "warmup=0",
    "validate_every=4",
];
const EVALUATOR: [&str; 7] = [
    "evaluator.width=8",
    "evaluator.channels=8",
    "evaluator.motion_blocks=0",
    "evaluator.text_blocks=0",
    "evaluator.pieces=150",
    "evaluator.iterations=4",
    "evaluator.warmup=0",
];

#[track_caller]
fn refused(folder: &Path, arguments: &[&str], code: i32, says: &str) {
    let output = run(folder, arguments);
    let text = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.code() == Some(code) && text.contains(says), "{arguments:?}: {text}");
}

/// Every built-in clip to train on, and the first three to test on; the first test entry promises a wave.
fn data_set(folder: &Path, robot: &Robot) -> CaptionedSet {
    let folder = folder.join("set");
    std::fs::create_dir_all(&folder).unwrap();
    let mut entries = Vec::new();
    for (i, clip) in clips::builtin(robot).all().unwrap().iter().enumerate() {
        for split in if i < 3 { &[Split::Train, Split::Test][..] } else { &[Split::Train] } {
            let file = format!("{}-{i}.motion.safetensors", split.name());
            container::write(&folder.join(&file), clip).unwrap();
            let wave = Action { side: Some(Side::Right), ..Action::of("wave") };
            let facts = Facts { relation: Relation::Single, actions: vec![wave], held_out: Some(HeldOut::Words) };
            entries.push(Entry {
                file,
                split: *split,
                seconds: clip.seconds(),
                captions: vec![format!("a person does {}", clip.name.replace('_', " "))],
                source: "own".into(),
                licence: "CC0".into(),
                facts: (i == 0).then_some(facts),
            });
        }
    }
    let set = CaptionedSet { folder, entries };
    set.write().unwrap();
    set
}

/// A critic that has seen one motion.
fn critic(set: &CaptionedSet, robot: &Robot, file: &Path) {
    let representation = RepresentationSpec::of(&robot.layout);
    let motions = CaptionedMotion::read(set, &set.entries[..1], &representation).unwrap();
    let motions = motions.into_iter().map(|motion| motion.rows).collect();
    let records = RewardRecords {
        sequence: vec![0; 2],
        frame: vec![0, 1],
        reward: vec![1.0, 0.5],
        end: vec![StepEnd::Continues, StepEnd::Truncated],
        ..RewardRecords::new(vec!["a".into()], 20.0, 1)
    };
    let (robot, controller) = (robot.name.clone(), String::new());
    let data = CriticData { robot, controller, representation, motions, others: Vec::new(), records };
    let plan = CriticPlan { hidden: vec![8], ..CriticPlan::default() };
    CriticTrainer::new(&plan, 1, data).unwrap().critic().save(file).unwrap();
}

#[test]
fn generators_are_measured_beside_the_data_set() {
    let folder = tempfile::tempdir().unwrap();
    let (at, robot) = (folder.path(), Robot::load("lima").unwrap());
    let set = data_set(at, &robot);
    critic(&set, &robot, &at.join("tiny.critic.safetensors"));
    let (generator, eval) = (path(at, "gen"), path(at, "eval"));
    let (clips, dataset) = (format!("clips=[{:?}]", path(at, "set")), format!("dataset={}", path(at, "set")));
    lifelike(&[&["train", "generator", "--plan", "generator", "-o", &generator, &clips], &GENERATOR[..]].concat());
    lifelike(&[&["train", "evaluator", "--plan", "evaluator", "-o", &eval, &dataset], &EVALUATOR[..]].concat());

    let evaluator = ["generation", "--data", "set", "--evaluator", "eval/motion.evaluator.safetensors"];
    let one = ["--generator", "MDM=gen/motion.generator.safetensors"];
    let guided = ["--guided", "guided=gen/motion.generator.safetensors@0.5", "--critic", "tiny.critic.safetensors"];
    let rest = ["--repetitions", "2", "--keep", "kept", "-o", "all.json"];
    let found = json(at, &[&evaluator[..], &one, &guided, &rest].concat());
    assert_eq!((&found["entries"], &found["of"], &found["left_out"]), (&json!(3), &json!(3), &json!(0)));
    let names: Vec<&str> = found["rows"].as_array().unwrap().iter().map(|row| row["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["data set", "MDM", "guided"]);
    let [own, mdm, towards] = [0, 1, 2].map(|i| &found["rows"][i]);
    assert!(own["scores"]["fid"]["mean"].as_f64().unwrap().abs() < 1e-3 && own["scores"]["multimodality"].is_null());
    assert!(mdm["scores"]["fid"]["mean"].as_f64().unwrap() > 0.0);
    assert!(mdm["scores"]["multimodality"]["mean"].as_f64().unwrap() > 0.0);
    assert_eq!((&own["checks"]["everything"]["asked"], &mdm["checks"]["everything"]["asked"]), (&json!(1), &json!(2)));
    assert_eq!(mdm["checks_of_held_out"]["unseen words"], mdm["checks"]);
    assert_ne!(mdm["realism_of_each"], towards["realism_of_each"], "the critic guides one and not the other");
    assert!(mdm["plausibility"]["seconds"].as_f64().unwrap() > own["plausibility"]["seconds"].as_f64().unwrap());
    let kept: Value = serde_json::from_str(&std::fs::read_to_string(at.join("all.json")).unwrap()).unwrap();
    assert_eq!(kept["rows"][1]["scores"], mdm["scores"]);
    let read = |folder: &str, name: &str| container::read(&at.join(folder).join(name)).unwrap();
    let clip = read("kept/MDM", "test-2-1.motion.safetensors");
    let entry = set.of(Split::Test).nth(2).unwrap();
    assert_eq!((clip.name.as_str(), &clip.provenance.captions[0].text), ("test-2-1", &entry.captions[0]));
    // The representation has 20 rows a second.
    assert!((clip.seconds() - entry.seconds).abs() <= 0.05, "{} {}", clip.seconds(), entry.seconds);

    // An entry's motion is the same whatever else is measured; few steps, and tables for people.
    let again = [&evaluator[..], &one, &["--limit", "1", "--repetitions", "1", "--keep", "again"]].concat();
    let text = String::from_utf8(run(at, &again).stdout).unwrap();
    for part in ["thesis, RobotMDM", "0.684 ± 0.007", "everything", "skate (mm/s)", "1 of 3 entries of set (test)"] {
        assert!(text.contains(part), "{part}: {text}");
    }
    let name = "test-0-0.motion.safetensors";
    assert_eq!(read("again/MDM", name).joints, read("kept/MDM", name).joints);

    // Without an evaluator its table is not there; what needs none is the same.
    let bare = json(at, &[&evaluator[..3], &one, &["--repetitions", "2"]].concat());
    assert!(bare["rows"][1]["scores"].is_null());
    assert_eq!((&bare["rows"][1]["checks"], &bare["rows"][1]["plausibility"]), (&mdm["checks"], &mdm["plausibility"]));
    let text = String::from_utf8(run(at, &[&evaluator[..3], &one, &["--limit", "1"]].concat()).stdout).unwrap();
    assert!(!text.contains("R-Prec") && text.contains("skate (mm/s)"), "{text}");

    // Thesis Table 5.3: a tracker follows every method's motions; every frame counts.
    let policy = concat!(env!("CARGO_MANIFEST_DIR"), "/../assets/lima-path.controller.safetensors");
    let tracker = ["--tracker", policy, "--episodes", "2", "--seconds", "1", "--repetitions", "1"];
    let found = json(at, &[&evaluator[..3], &one, &tracker].concat());
    assert_eq!(found["protocol"]["episodes"], 2);
    for row in found["rows"].as_array().unwrap() {
        assert_eq!(row["tracking"]["frames"], 100, "{}", row["name"]);
        assert!(row["tracking"]["root_tilt_error_deg"].as_f64().unwrap() > 0.0, "{}", row["tracking"]);
    }
    assert!(bare["rows"][1]["tracking"].is_null());

    let bench = |more: &[&'static str]| [&evaluator[..], more].concat();
    refused(at, &bench(&["--split", "exam"]), 2, "expected one of train, validation, test, held_out");
    refused(at, &bench(&["--split", "held_out"]), 3, "set: expected entries of the split held_out, got none");
    refused(at, &bench(&["--robot", "humanoid"]), 3, "rows for the evaluator: expected");
    refused(at, &bench(&["--guided", "a=gen/motion.generator.safetensors@1"]), 2, "--critic");
    refused(at, &bench(&["--generator", "../a=x"]), 2, "expected NAME=FILE");
    refused(at, &bench(&[&one[..], &one].concat()), 2, "expected every name once, got 'MDM' again");
    refused(at, &bench(&["--generator", "a=eval/motion.evaluator.safetensors"]), 3, "motion.evaluator.safetensors");
    refused(at, &bench(&[&one[..], &["--steps", "9"]].concat()), 3, "1 to 4");
    let other = ["generation", "--data", "set", "--evaluator", "gen/motion.generator.safetensors"];
    refused(at, &other, 3, "motion.generator.safetensors");
}
