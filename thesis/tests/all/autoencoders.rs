//! `lifelike-thesis images`, `strands` and `reconstruction` with the smallest budget; tests of `curves` are on the frame.

use std::path::Path;
use std::process::{Command, Output};

use serde_json::Value;

fn bench(arguments: &[&str], output: &Path) -> Output {
    let fixed = ["--quiet"];
    let rest = ["--budget", "smoke", "-o", output.to_str().unwrap(), "--json"];
    Command::new(env!("CARGO_BIN_EXE_lifelike-thesis")).args(fixed).args(arguments).args(rest).output().unwrap()
}

fn json(arguments: &[&str], output: &Path) -> Value {
    let done = bench(arguments, output);
    assert!(done.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&done.stderr));
    serde_json::from_slice(&done.stdout).unwrap()
}

#[track_caller]
fn refused(arguments: &[&str], output: &Path, code: i32, says: &str) {
    let done = bench(arguments, output);
    let text = String::from_utf8(done.stderr).unwrap();
    assert_eq!(done.status.code(), Some(code), "{arguments:?}: {text}");
    assert!(text.contains(says), "{arguments:?}: {text}");
}

#[test]
fn strands_are_measured_once_and_printed_beside_the_thesis() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let first = json(&["strands", "--latents", "8,12"], at);
    assert_eq!((&first["thesis"]["spline"]["8d"], &first["thesis"]["spline"]["12d"]), (&1.09e-3.into(), &Value::Null));
    let runs = first["runs"].as_array().unwrap();
    assert_eq!(runs.len(), 6);
    for run in runs {
        assert_eq!((&run["iterations"], &run["tokens"], &run["test"]), (&40.into(), &16.into(), &80.into()));
    }
    let page = std::fs::read_to_string(at.join("report.html")).unwrap();
    assert!(page.contains("Table 3.5") && page.contains("12D: test strands"));
    // What was measured is not measured again: the command believes the run's folder.
    let kept = at.join("8d-spline-0/measured.toml");
    let text = std::fs::read_to_string(&kept).unwrap();
    let line = text.lines().find(|line| line.starts_with("mse = ")).unwrap();
    std::fs::write(&kept, text.replace(line, "mse = 7.0")).unwrap();
    let again = json(&["strands", "--latents", "8", "--methods", "spline"], at);
    assert_eq!(again["runs"][0]["mse"], 7.0);
}

#[test]
fn plain_baselines_say_how_many_numbers_they_keep_and_need_no_network() {
    let folder = tempfile::tempdir().unwrap();
    let found = json(&["strands", "--latents", "8", "--plain"], folder.path());
    let told = |row: &Value| (row["name"].as_str().unwrap().to_owned(), row["numbers"].as_u64().unwrap());
    let plain = found["plain"].as_array().unwrap();
    let rows: Vec<_> = plain.iter().map(told).collect();
    assert_eq!(rows, [("mean", 0), ("cubic", 12), ("PCA", 8), ("PCA", 32)].map(|(name, n)| (name.to_owned(), n)));
    let mse: Vec<f64> = plain.iter().map(|row| row["mse"].as_f64().unwrap()).collect();
    assert!(mse[0] > mse[2] && mse[2] > mse[3] && mse[3] < 1e-5, "in m², strands of some decimetres: {mse:?}");
    assert!(found["runs"].as_array().unwrap().is_empty() && !folder.path().join("8d-spline-0").exists());
    refused(&["strands", "--plain", "--methods", "spline"], folder.path(), 2, "--plain");
}

#[test]
fn any_folder_of_images_will_do_and_a_bad_one_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let (at, images) = (folder.path().join("runs"), folder.path().join("images"));
    let dir = images.to_str().unwrap();
    let jpeg = include_bytes!("../fixtures/two-colours.jpg");
    for (part, count) in [("train/a", 6), ("test", 3)] {
        std::fs::create_dir_all(images.join(part)).unwrap();
        (0..count).for_each(|i| std::fs::write(images.join(part).join(format!("{i}.jpg")), jpeg).unwrap());
    }
    let found = json(&["images", dir, "--latents", "32", "--methods", "spline", "validation=2"], &at);
    let run = &found["runs"][0];
    // 24 x 16 pixels in patches of 4.
    assert_eq!((&run["tokens"], &run["test"]), (&24.into(), &3.into()));
    let page = std::fs::read_to_string(at.join("report.html")).unwrap();
    assert_eq!(page.matches("data:image/png;base64,").count(), 6, "three images and what came back");
    refused(&["images", dir, "validation=6"], &at, 3, "fewer than the 6 images of train/");
    refused(&["images", dir, "validation=2", "patch=5"], &at, 3, "plan: patch");
    std::fs::write(images.join("test/9.png"), "hello").unwrap();
    refused(&["images", dir], &at, 3, "9.png: expected an image as PNG or JPEG, got something else");
    refused(&["images", "none"], &at, 3, "none: expected a folder with the folders train and test");
    refused(&["images", dir, "patsch=4"], &at, 3, "patsch");
}

#[test]
fn motion_is_split_by_the_groups_that_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let (at, clips) = (folder.path().join("runs"), folder.path().join("clips"));
    let dir = clips.to_str().unwrap();
    std::fs::create_dir_all(&clips).unwrap();
    let motions = Path::new(env!("CARGO_MANIFEST_DIR")).join("../motions");
    for (from, to) in [("walk", "anna_walk"), ("wave", "ben_wave"), ("walk", "carl_walk"), ("wave", "carl_wave")] {
        let (from, to) = (format!("{from}.keys.toml"), format!("{to}.keys.toml"));
        std::fs::copy(motions.join(from), clips.join(to)).unwrap();
    }
    let groups = ["test=[\"anna\"]", "validation=[\"ben\"]"];
    let found = json(&[&["reconstruction", dir], &groups[..], &["--latents", "16"]].concat(), &at);
    for run in found["runs"].as_array().unwrap() {
        let (mse, angle) = (run["mse"].as_f64().unwrap(), run["also"]["mean joint error [deg]"].as_f64().unwrap());
        assert!(mse > 1.0 && angle > 0.5 && angle < 180.0, "{mse} deg², {angle} deg");
    }
    refused(&["reconstruction", dir], &at, 3, "got none of those that there are: anna, ben, carl");
    refused(&["reconstruction", groups[0]], &at, 2, "expected clips");
    refused(&["reconstruction", "none.bvh"], &at, 3, "none.bvh");
}
