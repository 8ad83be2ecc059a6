//! The evaluator on made-up motions: it learns, is saved, and goes on bit for bit.
use lifelike_checkpoint::Checkpoint;
use lifelike_checkpoint::rng::stream;
use lifelike_generation::data::CaptionedMotion;
use lifelike_generation::evaluator::{Evaluator, EvaluatorData, EvaluatorPlan, EvaluatorTrainer, caption_kinds};
use lifelike_generation::metrics::{Retrieval, pools};
use lifelike_generation::representation::{FeatureMatrix, RepresentationSpec};
use lifelike_language::Split;
use lifelike_train::TrainingTask;
use rand::Rng;

const JOINTS: usize = 2;
const SPEEDS: [(&str, f32); 3] = [("slowly", 0.1), ("at a walk", 0.25), ("quickly", 0.6)];
const JOINT: [&str; 3] = ["the left hand", "the right hand", "both hands"];

/// A joint swings at a speed, by a sentence that says so; rows, phase and height vary.
fn made_up(seed: u64, count: usize) -> Vec<CaptionedMotion> {
    let item = |i: u64| {
        let mut rng = stream(seed, "test", i, 0);
        let (kind, speed) = (rng.random_range(0..3), rng.random_range(0..3));
        let (n, phase, height) = (rng.random_range(20..50), rng.random_range(0.0..6.0_f32), rng.random_range(0.4..0.6));
        let width = 7 + 2 * JOINTS;
        let mut rows = vec![0.0_f32; n * width];
        for (t, row) in rows.chunks_exact_mut(width).enumerate() {
            row[0] = height;
            let angle = SPEEDS[speed].1 * t as f32 + phase;
            for joint in (0..JOINTS).filter(|joint| kind == 2 || kind == *joint) {
                row[7 + joint] = angle.sin();
                row[7 + JOINTS + joint] = 20.0 * SPEEDS[speed].1 * angle.cos();
            }
        }
        let begin = ["a person waves", "someone is waving"][rng.random_range(0..2)];
        let caption = format!("{begin} with {} {}", JOINT[kind], SPEEDS[speed].0);
        let (rows, captions) = (FeatureMatrix::new(rows, width).unwrap(), vec![caption]);
        CaptionedMotion { name: i.to_string(), split: Split::Train, rows, captions, licence: String::new() }
    };
    (0..count as u64).map(item).collect()
}

fn trainer(iterations: u64) -> EvaluatorTrainer {
    let plan = EvaluatorPlan {
        width: 16,
        channels: 16,
        motion_blocks: 1,
        text_blocks: 2,
        pieces: 150,
        max_rows: 40,
        batch: 32,
        iterations,
        learning_rate: 5e-3,
        warmup: 10,
        validate_every: 50,
        ..EvaluatorPlan::default()
    };
    let spec = RepresentationSpec::new(vec!["left".into(), "right".into()]);
    let data = EvaluatorData { training: made_up(1, 200), validation: made_up(2, 60) };
    EvaluatorTrainer::new(plan, spec, data).unwrap()
}

#[test]
fn sentences_find_motions_never_seen() {
    let mut trainer = trainer(300);
    while trainer.iteration() < 300 {
        trainer.step().unwrap();
        if trainer.iteration().is_multiple_of(50) {
            trainer.validate().unwrap();
        }
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("motion.evaluator.safetensors");
    trainer.evaluator().save(&path).unwrap();
    let evaluator = Evaluator::load(&path).unwrap();
    let test = made_up(3, 200);
    let captions: Vec<&str> = test.iter().map(|item| item.captions[0].as_str()).collect();
    let motions: Vec<FeatureMatrix> = test.iter().map(|item| item.rows.clone()).collect();
    let (text, motion) = (evaluator.sentences(&captions).unwrap(), evaluator.motions(&motions).unwrap());
    assert_eq!(trainer.evaluator().motions(&motions).unwrap(), motion, "the file is what was trained");
    // 18 sentences of 9 meanings: two of a pool of 9 mean the same, at worst.
    let pools = pools(&caption_kinds(captions.iter().copied()), 9, &mut stream(4, "test", 0, 0));
    let found = Retrieval::of(&text, &motion, &pools).unwrap().precision;
    assert!(found[2] > 0.9, "{found:?}");
}

#[test]
fn an_embedding_depends_on_its_own_rows_and_words_only() {
    let evaluator = trainer(10).evaluator();
    let mut motions: Vec<FeatureMatrix> = made_up(5, 6).into_iter().map(|item| item.rows).collect();
    let alone = evaluator.motions(&motions[..1]).unwrap();
    motions.sort_by_key(|motion| motion.n);
    let together = evaluator.motions(&motions).unwrap();
    let near = |row: &[f32]| row.iter().zip(alone.row(0)).all(|(a, b)| (a - b).abs() < 1e-5);
    assert!(together.rows().any(near));
    let sentences = ["a person waves", "someone is waving with the left hand slowly"];
    let (one, both) = (evaluator.sentences(&sentences[..1]).unwrap(), evaluator.sentences(&sentences).unwrap());
    assert!(one.row(0).iter().zip(both.row(0)).all(|(a, b)| (a - b).abs() < 1e-5));
}

#[test]
fn a_resumed_run_is_the_run_it_would_have_been() {
    let run = |trainer: &mut EvaluatorTrainer, until: u64| {
        while trainer.iteration() < until {
            trainer.step().unwrap();
            if trainer.iteration() == 3 {
                trainer.validate().unwrap();
            }
        }
        trainer.checkpoint().unwrap().to_bytes().unwrap()
    };
    let mut whole = trainer(50);
    let expected = run(&mut whole, 6);
    let mut first = trainer(50);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("half.safetensors");
    run(&mut first, 4);
    first.checkpoint().unwrap().save(&path).unwrap();
    let mut second = trainer(50);
    second.restore(&Checkpoint::load(&path).unwrap()).unwrap();
    assert!(run(&mut second, 6) == expected, "other bytes");
    let told = trainer(51).restore(&Checkpoint::load(&path).unwrap()).unwrap_err().to_string();
    assert!(told.contains("expected those of this run, got others"), "{told}");
}

#[test]
fn data_that_cannot_be_learned_from_is_refused() {
    let spec = RepresentationSpec::new(vec!["left".into(), "right".into()]);
    let told = |change: fn(&mut EvaluatorData)| {
        let mut data = EvaluatorData { training: made_up(1, 3), validation: made_up(2, 2) };
        change(&mut data);
        EvaluatorTrainer::new(EvaluatorPlan::default(), spec.clone(), data).unwrap_err().to_string()
    };
    assert!(told(|data| data.training.truncate(1)).contains("expected two or more, got 1"));
    assert!(told(|data| data.training[1].captions.clear()).contains("0 sentences"));
    assert!(told(|data| data.training[1].captions[0] = "\u{1}x".into()).contains("control character"));
    assert!(told(|data| data.validation[0].rows.width = 10).contains("expected 11, got 10"));
    let evaluator = trainer(10).evaluator();
    let wide = FeatureMatrix::new(vec![0.0; 12], 12).unwrap();
    assert!(evaluator.motions(&[wide]).is_err() && evaluator.sentences(&[""]).is_err());
}
