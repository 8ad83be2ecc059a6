//! A motion spline from its training to edited clips, as an animator meets it.

#![allow(clippy::unwrap_used)]

use crate::in_checkout::{json, refused};
use serde_json::Value;

/// A plan for seconds: keyframed clips, a tiny network.
const PLAN: &str = "robot = 'lima'\nclips = ['motions/wa[lv][ke].keys.toml', 'motions/weight_shift.keys.toml']\n\
    test = ['motions/march.keys.toml']\nframes = 20\n\
    [training]\nlatent = 6\nlayers = 1\nheads = 2\nwidth = 16\nbatch = 16\npart = 8\niterations = 12\nvalidate_every = 6\n\
    optimizer = 'adam'\n";

#[test]
fn a_spline_is_trained_and_edits_motion() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    std::fs::write(at("plan.toml"), PLAN).unwrap();
    let run = at("run");
    let trained = json(&["train", "spline", "--plan", &at("plan.toml"), "-o", &run]);
    assert_eq!((&trained["iterations"], &trained["clips"][0]["clip"]), (&Value::from(12), &Value::from("march")));
    let again = json(&["train", "spline", "--resume", "-o", &run]);
    assert_eq!(again["mean"], trained["mean"], "what is done is left alone");

    let (plan, twice) = (at("plan.toml"), at("twice"));
    let mirrored = json(&["train", "spline", "--plan", &plan, "-o", &twice, "mirror=true", "training.iterations=1"]);
    let count = |value: &Value, key: &str| value[key].as_u64().unwrap();
    for key in ["training_clips", "training_windows"] {
        assert_eq!(count(&mirrored, key), 2 * count(&trained, key), "{key}");
    }

    let (spline, out) = (trained["model"].as_str().unwrap(), at("out"));
    let edit = |arguments: &[&str]| {
        json(&[&["motion", "edit", "motions/wave.keys.toml", "--spline", spline, "-o", &out], arguments].concat())
    };
    let points = at("points.json");
    let same = edit(&["--name", "same", "--save-points", &points]);
    assert!(same["motions"][2]["change_deg"] == 0.0, "{same}");
    assert!(same["motions"][1]["change_deg"].as_f64().unwrap() > 1.0, "twelve iterations teach little: {same}");
    let large = edit(&["--gain", "3", "--name", "large", "--look"]);
    assert!(large["motions"][2]["change_deg"].as_f64().unwrap() > 1e-3, "{large}");
    assert!(std::fs::read_to_string(folder.path().join("out/report.html")).unwrap().contains("Latent curves"));
    let fine = edit(&["--sample", "2", "--speed", "0.5", "--name", "fine"]);
    assert_eq!((&fine["made"]["fps"], &fine["made"]["clip"]), (&Value::from(100.0), &Value::from("fine")));
    let seconds = |value: &Value| value["made"]["seconds"].as_f64().unwrap();
    assert!((seconds(&fine) - 2.0 * seconds(&same)).abs() < 0.02);
    let blended = edit(&["--blend", "motions/walk.keys.toml", "--weight", "1", "--bare", "--name", "other"]);
    assert_eq!(seconds(&blended), seconds(&same));

    // Control points that somebody else has changed.
    let text = std::fs::read_to_string(&points).unwrap();
    let mut file: Value = serde_json::from_str(&text).unwrap();
    file["segments"][0]["control_points"][1][2] = 4.0.into();
    std::fs::write(&points, file.to_string()).unwrap();
    let moved = edit(&["--points", &points, "--name", "moved"]);
    assert!(moved["motions"][2]["change_deg"].as_f64().unwrap() > 1e-3, "{moved}");
    file["segments"][0]["control_points"][1] = Value::from(vec![1.0]);
    std::fs::write(&points, file.to_string()).unwrap();
    let wave = ["motion", "edit", "motions/wave.keys.toml", "--spline", spline, "-o", &out];
    let (code, text) = refused(&[&wave[..], &["--points", &points]].concat());
    assert!(
        code == 3
            && text.contains("points.json")
            && text.contains("segment 0: expected [6, 6, 6, 6], got [6, 1, 6, 6]"),
        "{code} {text}"
    );
}

#[test]
fn what_cannot_be_is_said() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    let both = PLAN.replace("march", "walk");
    std::fs::write(at("plan.toml"), both).unwrap();
    let (code, text) = refused(&["train", "spline", "--plan", &at("plan.toml"), "-o", &at("run")]);
    assert!(code != 0 && text.contains("clip 'walk' is also among the clips to train on"), "{text}");
    let (code, text) = refused(&["train", "spline", "-o", &at("run")]);
    assert!(code != 0 && text.contains("--plan FILE"), "{text}");
    // A policy is no motion spline.
    let wave = ["motion", "edit", "motions/wave.keys.toml", "-o", &at("out"), "--spline"];
    let (code, text) = refused(&[&wave[..], &["assets/lima.prior.safetensors"]].concat());
    assert!(code != 0 && text.contains("expected a motion spline, got motion prior"), "{text}");
    let (code, text) = refused(&[&wave[..], &["x", "--move", "1:2"]].concat());
    assert!(code != 0 && text.contains("POINT:NUMBER=BY"), "{text}");
}
