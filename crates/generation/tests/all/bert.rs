//! The frozen text encoder against PyTorch (`fixtures/bert/make.py`).
use std::path::{Path, PathBuf};

use lifelike_generation::text::minilm::MiniLm;

#[derive(serde::Deserialize)]
struct Fixture {
    every: usize,
    cases: Vec<Case>,
}

#[derive(serde::Deserialize)]
struct Case {
    text: String,
    ids: Vec<u32>,
    hidden: Vec<f32>,
    embedding: Vec<f32>,
}

fn fixtures() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures/bert")
}

/// PyTorch computed in double precision; ours is single, some ten layers of sums of at most 1536 terms.
const TOLERANCE: f32 = 1e-5;

fn agrees(model: &MiniLm, fixture: &str) {
    let fixture: Fixture = serde_json::from_slice(&std::fs::read(fixtures().join(fixture)).unwrap()).unwrap();
    let mut worst = 0.0_f32;
    for case in fixture.cases {
        let sentence = model.read(&case.text).unwrap();
        assert_eq!(sentence.ids, case.ids, "{}", case.text);
        let hidden: Vec<f32> = sentence.hidden.iter().copied().step_by(fixture.every).collect();
        for (got, expected) in [(hidden, case.hidden), (sentence.embedding(), case.embedding)] {
            assert_eq!(got.len(), expected.len());
            worst = got.iter().zip(&expected).map(|(a, b)| (a - b).abs()).fold(worst, f32::max);
        }
    }
    println!("largest difference: {worst:e}");
    assert!(worst < TOLERANCE, "{worst:e}");
}

#[test]
fn a_tiny_random_network_gives_pytorchs_numbers() {
    agrees(&MiniLm::load(&fixtures().join("tiny")).unwrap(), "tiny.json");
}

#[test]
#[ignore = "needs `cargo xtask fetch minilm`"]
fn minilm_gives_pytorchs_numbers() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../third_party/minilm");
    agrees(&MiniLm::load(&folder).unwrap(), "minilm.json");
}

#[test]
fn what_is_no_model_is_refused_with_its_file() {
    let folder = tempfile::tempdir().unwrap();
    let told = || MiniLm::load(folder.path()).unwrap_err().to_string();
    assert!(told().contains("vocab.txt") && told().contains("cargo xtask fetch minilm"), "{}", told());
    for file in ["vocab.txt", "config.json", "model.safetensors"] {
        std::fs::copy(fixtures().join("tiny").join(file), folder.path().join(file)).unwrap();
    }
    assert!(MiniLm::load(folder.path()).is_ok());
    let config = std::fs::read_to_string(folder.path().join("config.json")).unwrap();
    std::fs::write(
        folder.path().join("config.json"),
        config.replace("\"intermediate_size\": 24", "\"intermediate_size\": 25"),
    )
    .unwrap();
    assert!(told().contains("intermediate.dense.weight: expected 25 rows, got 24"), "{}", told());
    std::fs::write(folder.path().join("config.json"), config).unwrap();
    std::fs::write(folder.path().join("vocab.txt"), "[CLS]\n[SEP]\n[UNK]\n").unwrap();
    assert!(told().contains("word pieces: expected") && told().contains("got 3"), "{}", told());
    let model = MiniLm::load(&fixtures().join("tiny")).unwrap();
    assert!(model.read("").is_err() && model.read("a\u{1}").is_err());
}
