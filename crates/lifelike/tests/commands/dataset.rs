//! `lifelike dataset ...` as people meet it: captioned sets made, checked, and refused with the reason.
#![allow(clippy::unwrap_used)]

use std::path::{Path, PathBuf};

use crate::in_checkout::{err, json, lifelike};
use serde_json::Value;

/// Message of what must be refused, with its exit code.
fn refused(arguments: &[&str], code: i32) -> String {
    let output = lifelike(arguments);
    assert_eq!(output.status.code(), Some(code), "{arguments:?}: {}", err(&output));
    err(&output)
}

/// Lines of a data set's index.
fn index(folder: &Path) -> Vec<Value> {
    let text = std::fs::read_to_string(folder.join("dataset.jsonl")).unwrap();
    text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

/// Our wave and nod on Lima, under the names of recordings.
fn recordings(folder: &Path, names: [&str; 2]) -> PathBuf {
    let sources = folder.join("sources");
    std::fs::create_dir_all(&sources).unwrap();
    for (name, ours) in names.iter().zip(["wave", "nod"]) {
        let from = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../../motions/{ours}.keys.toml"));
        std::fs::copy(from, sources.join(format!("{name}.keys.toml"))).unwrap();
    }
    let clips = folder.join("clips");
    let (from, to) = (sources.to_str().unwrap(), clips.to_str().unwrap());
    assert_eq!(json(&["motion", "retarget", from, "-o", to])["summary"]["converted"], 2);
    clips
}

#[test]
fn a_grammars_set_is_true_and_its_mirror_image_is_not() {
    let root = tempfile::tempdir().unwrap();
    let folder = root.path().join("set");
    let to = folder.to_str().unwrap();
    let made = json(&["dataset", "grammar", "-o", to, "--hours", "0.02", "--seed", "5"]);
    let clips = index(&folder);
    assert_eq!(made["summary"]["clips"], clips.len());
    assert!(made["summary"]["hours"].as_f64().unwrap() >= 0.02 && clips.len() >= 8);
    assert!(made["true_share"].as_f64().unwrap() > 0.9);
    assert!(clips.iter().all(|line| folder.join(line["file"].as_str().unwrap()).is_file()));
    let files = |split: &str| std::fs::read_dir(folder.join(split)).unwrap().count();
    let written: usize = ["train", "validation", "test", "held_out"].into_iter().map(files).sum();
    assert_eq!(written, clips.len(), "no file that is not in the index");

    let checked = json(&["dataset", "check", to]);
    assert_eq!(checked["failed"].as_array().unwrap().len(), 0);
    assert!(checked["clips"].as_array().unwrap().iter().all(|split| split["rate"] == 1.0));
    let images = json(&["dataset", "check", to, "--mirrored"]);
    let failed: Vec<&str> = images["failed"].as_array().unwrap().iter().map(|f| f["file"].as_str().unwrap()).collect();
    let sided = |line: &&Value| {
        let first = &line["facts"]["actions"][0];
        line["facts"]["relation"] == "single" && (first["side"] == "left" || first["side"] == "right")
    };
    let sided: Vec<&Value> = clips.iter().filter(sided).collect();
    assert!(!sided.is_empty() && sided.iter().all(|line| failed.contains(&line["file"].as_str().unwrap())));
    assert!(images["clips"].as_array().unwrap().iter().all(|split| split["rate"] == 0.0), "no image passes");

    let message = refused(&["dataset", "grammar", "-o", to, "--hours", "0.01"], 3);
    assert!(message.contains("expected a new or empty folder"), "{message}");
    let message = refused(&["dataset", "check", to, "--split", "exam"], 2);
    assert!(message.contains("held_out") && message.contains("'exam'"), "{message}");
    std::fs::write(folder.join("dataset.jsonl"), "{}\n").unwrap();
    let message = refused(&["dataset", "check", to], 3);
    assert!(message.contains("dataset.jsonl:1: expected an entry"), "{message}");
}

#[test]
fn what_cannot_be_made_is_told() {
    let root = tempfile::tempdir().unwrap();
    let to = root.path().join("set");
    let to = to.to_str().unwrap();
    let message = refused(&["dataset", "grammar", "--robot", "no_such_robot", "-o", to], 3);
    assert!(message.contains("no_such_robot") && message.contains("lima"), "{message}");
    assert!(refused(&["dataset", "grammar", "--hours", "0", "-o", to], 2).contains("more than 0"));
    let grammar = root.path().join("mine.toml");
    std::fs::write(&grammar, "subjects = 3\n").unwrap();
    let message = refused(&["dataset", "grammar", "--grammar", grammar.to_str().unwrap(), "-o", to], 3);
    assert!(message.contains("mine.toml") && message.contains("grammar"), "{message}");
    assert!(!Path::new(to).exists(), "nothing is begun that cannot be done");
}

#[test]
fn captures_are_cut_mirrored_and_split_by_subject() {
    let root = tempfile::tempdir().unwrap();
    let clips = recordings(root.path(), ["02_01", "16_03"]);
    let table = root.path().join("captions.tsv");
    let rows = "02_01\twave with the right hand\t[]\n16_03\tnod\t[[0.0, 2.5, \"someone nods\"]]\n";
    std::fs::write(&table, format!("trial\ttrial_description\tkitml_captions\n{rows}")).unwrap();
    let folder = root.path().join("set");
    let (clips, table, to) = (clips.to_str().unwrap(), table.to_str().unwrap(), folder.to_str().unwrap());
    let made = json(&["dataset", "captures", clips, "--captions", table, "-o", to]);
    assert_eq!((&made["splits"]["test"]["clips"], &made["splits"]["train"]["clips"]), (&2.into(), &2.into()));
    let lines = index(&folder);
    let said = |name: &str| {
        let line = lines.iter().find(|line| line["file"].as_str().unwrap().contains(name)).unwrap();
        line["captions"].to_string()
    };
    assert!(said("02_01_00000.").contains("right hand") && said("02_01_00000_mirror").contains("left hand"));
    assert!(said("16_03").contains("someone nods"));
    assert_eq!(json(&["dataset", "check", to])["splits"]["test"]["clips"], 2);

    let message = refused(&["dataset", "captures", clips, "--captions", table, "-o", to], 3);
    assert!(message.contains("expected a new or empty folder"), "{message}");
    std::fs::write(root.path().join("captions.tsv"), "clip\twords\n02_01\twave\n").unwrap();
    let message = refused(&["dataset", "captures", clips, "--captions", table, "-o", &format!("{to}2")], 3);
    assert!(message.contains("captions.tsv") && message.contains("expected columns"), "{message}");
    let own = json(&["dataset", "captures", clips, "-o", &format!("{to}3"), "--no-mirror"]);
    assert_eq!(own["splits"]["test"]["clips"], 1, "without a table, the clips' own words");
}

#[test]
fn motion_that_is_not_free_is_asked_for() {
    let root = tempfile::tempdir().unwrap();
    let clips = recordings(root.path(), ["dataset-1_bye_normal_001", "dataset-1_respond_sad_001"]);
    let folder = root.path().join("set");
    let (clips, to) = (clips.to_str().unwrap(), folder.to_str().unwrap());
    let message = refused(&["dataset", "captures", clips, "-o", to], 3);
    assert!(message.contains("got none of 2") && message.contains("for non-commercial use only"), "{message}");
    let made = json(&["dataset", "captures", clips, "-o", &format!("{to}2"), "--non-commercial"]);
    assert_eq!(made["non_commercial"], 4);
    let lines = index(&root.path().join("set2"));
    assert!(lines.iter().all(|line| line["licence"].as_str().unwrap().contains("non-commercial")));
}

#[test]
fn humanml3d_is_read_or_refused_with_file_and_line() {
    let root = tempfile::tempdir().unwrap();
    let clips = recordings(root.path(), ["80_63", "80_64"]);
    let published = root.path().join("HumanML3D");
    std::fs::create_dir_all(published.join("texts")).unwrap();
    let write = |name: &str, text: &str| std::fs::write(published.join(name), text).unwrap();
    let head = "source_path,start_frame,end_frame,new_name\n";
    let rows = "./pose_data/CMU/80/80_63_poses.npy,0,50,000004.npy\n./pose_data/KIT/3/x_poses.npy,0,50,000005.npy\n";
    write("index.csv", &format!("{head}{rows}"));
    write("train.txt", "000004\nM000004\n");
    write("val.txt", "000005\n");
    write("test.txt", "");
    write("texts/000004.txt", "a man waves his right hand.#a/DET man/NOUN wave/VERB#0.0#0.0\n");
    let folder = root.path().join("set");
    let (published, clips, to) = (published.to_str().unwrap(), clips.to_str().unwrap(), folder.to_str().unwrap());
    let made = json(&["dataset", "humanml3d", published, clips, "-o", to]);
    assert_eq!((&made["splits"]["train"]["clips"], &made["without_motion"]), (&2.into(), &1.into()));
    let said: Vec<String> = index(&folder).iter().map(|line| line["captions"][0].to_string()).collect();
    assert!(said.iter().any(|text| text.contains("right hand")) && said.iter().any(|text| text.contains("left hand")));

    write("index.csv", &format!("{head}{rows}./pose_data/CMU/80/80_64_poses.npy,0,fifty,000006.npy\n"));
    let message = refused(&["dataset", "humanml3d", published, clips, "-o", &format!("{to}2")], 3);
    assert!(message.contains("index.csv:4: expected a frame number, got 'fifty'"), "{message}");
}
