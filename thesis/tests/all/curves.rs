//! `lifelike-thesis curves` with the smallest budget: tables, files, going on, and what is refused.

use std::path::Path;
use std::process::{Command, Output};

use serde_json::Value;

fn bench(folder: &Path, arguments: &[&str]) -> Output {
    let fixed = ["--quiet", "curves", "--budget", "smoke", "-o", folder.to_str().unwrap()];
    Command::new(env!("CARGO_BIN_EXE_lifelike-thesis")).args(fixed).args(arguments).output().unwrap()
}

fn json(folder: &Path, arguments: &[&str]) -> Value {
    let output = bench(folder, &[arguments, &["--json"]].concat());
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

#[test]
fn a_comparison_is_made_once_and_printed_beside_the_thesis() {
    let folder = tempfile::tempdir().unwrap();
    let families = ["--families", "bezier-2,lissajous"];
    let first = json(folder.path(), &families);
    let runs = first["runs"].as_array().unwrap();
    assert_eq!(runs.len(), 6);
    for run in runs {
        assert_eq!((&run["iterations"], &run["of"], &run["test"]), (&40.into(), &40.into(), &64.into()));
        assert!(run["mse"].as_f64().unwrap() > 0.0);
        assert_eq!(run["looks"].as_array().unwrap().len(), 4);
    }
    assert_eq!(first["thesis"]["spline"]["bezier-2"], 2e-6);
    let page = std::fs::read_to_string(folder.path().join("report.html")).unwrap();
    assert!(page.contains("Table 3.1") && page.contains("<svg viewBox") && page.contains("log10"));
    let saved: Value = serde_json::from_slice(&std::fs::read(folder.path().join("curves.json")).unwrap()).unwrap();
    assert_eq!(saved, first);
    // What is done is not trained again: even the clock stands where it stood.
    assert_eq!(json(folder.path(), &families), first);
    let text = String::from_utf8(bench(folder.path(), &families).stdout).unwrap();
    assert!(text.contains("thesis: ALiBi-Cat") && text.contains("Bézier (2D)") && text.contains("2.00e-6"), "{text}");
    assert!(!text.contains("Hypotrochoids"), "{text}");
}

#[test]
fn rates_are_swept_with_each_warm_up() {
    let folder = tempfile::tempdir().unwrap();
    let one = ["--families", "lissajous", "--methods", "spline", "--iterations", "6"];
    let sweep = json(folder.path(), &[&one[..], &["--rates", "1e-4,1e-2", "--warmup", "0,3"]].concat());
    let runs = sweep["runs"].as_array().unwrap();
    let setting = |run: &Value| (run["learning_rate"].as_f64().unwrap(), run["warmup"].as_u64().unwrap());
    assert_eq!(runs.iter().map(setting).collect::<Vec<_>>(), [(1e-4, 0), (1e-4, 3), (1e-2, 0), (1e-2, 3)]);
    // Rates are chosen by it, so it must not have seen the test set.
    assert!(runs.iter().all(|run| run.get("mse").is_none() && run["looks"][0]["mse"].as_f64().unwrap() > 0.0));
    assert!(!folder.path().join("lissajous-spline-rate-1e-4-0/measured.toml").exists());
    let text = String::from_utf8(bench(folder.path(), &[&one[..], &["--rates", "1e-4"]].concat()).stdout).unwrap();
    assert!(text.contains("spread") && text.contains("1e-4") && !text.contains("test curves"), "{text}");
    let refused = bench(folder.path(), &[&one[..], &["--warmup", "0,3"]].concat());
    let text = String::from_utf8(refused.stderr).unwrap();
    assert!(!refused.status.success() && text.contains("--warmup: expected one without --rates, got 2"), "{text}");
}

#[test]
fn the_table_has_the_mean_of_several_seeds_and_half_their_range() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = ["--families", "bezier-2", "--methods", "spline", "--iterations", "3", "--seed", "1,5"];
    let found = json(folder.path(), &arguments);
    let of = |i: usize| (found["runs"][i]["seed"].as_u64().unwrap(), found["runs"][i]["mse"].as_f64().unwrap());
    let [(first, a), (second, b)] = [of(0), of(1)];
    assert!((first, second) == (1, 5) && a != b, "{a} {b}");
    let text = String::from_utf8(bench(folder.path(), &arguments).stdout).unwrap();
    let expected = format!("{:.2e} ± {:.1e} [8]", 0.5 * (a + b), 0.5 * (a - b).abs());
    assert!(text.contains(&expected), "{expected}: {text}");
}

#[test]
fn each_method_may_have_its_own_rate() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = ["--families", "lissajous", "--iterations", "2", "--rate", "spline=0.02,alibi=0.003"];
    let found = json(folder.path(), &arguments);
    let rates = found["runs"].as_array().unwrap().iter().map(|run| run["learning_rate"].as_f64().unwrap());
    assert_eq!(rates.collect::<Vec<_>>(), [0.003, 1e-3, 0.02], "ALiBi-Cat has the thesis'");
    assert!(found["runs"][2]["mse"].as_f64().unwrap() > 0.0);
}

#[test]
fn what_makes_no_sense_is_refused_before_anything_is_trained() {
    let folder = tempfile::tempdir().unwrap();
    let refused = |arguments: &[&str], code: i32, says: &str| {
        let output = bench(folder.path(), arguments);
        let text = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(code), "{arguments:?}: {text}");
        assert!(text.contains(says), "{arguments:?}: {text}");
    };
    refused(&["--families", "spirals"], 2, "hypotrochoids");
    refused(&["--methods", "sine"], 2, "alibi-cat");
    refused(&["--minutes", "0"], 2, "--minutes");
    refused(&["--rates", "-1"], 2, "");
    refused(&["--rate", "0.1"], 2, "METHOD=RATE");
    refused(&["--rate", "sine=0.1"], 2, "alibi-cat");
    refused(&["--rate", "spline=fast"], 2, "'fast'");
    refused(&["--rate", "spline=0.1", "--rates", "0.1"], 2, "cannot be used with");
    refused(&["--iterations", "0"], 3, "plan: iterations: expected 1 to");
    refused(&["--seed", "3310"], 3, "the test curves'");
    refused(&["training.widht=3"], 3, "widht");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}
