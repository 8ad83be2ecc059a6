//! Time of one training step (16 stretches of 256 steps), and of a running correction: `cargo run --release -p lifelike-augmentation
//! --example sat_step`. `peers/augmentation/step.py` is PyTorch's training step of the same network.

use std::error::Error;
use std::time::Instant;

use lifelike_augmentation::Feedback;
use lifelike_augmentation::training::{AugmentationPlan, AugmentationTrainer, FeedbackShares, LossKind};
use lifelike_sim::trace::{BlockTrace, Columns, Trace};

/// Joints of the running correction.
const JOINTS: usize = 512;

fn main() -> Result<(), Box<dyn Error>> {
    let wave = |key: f64| -> Vec<f64> { (0..2000).map(|i| (f64::from(i) * key).sin()).collect() };
    let mut block = BlockTrace {
        name: "joint".into(),
        class: "servo".into(),
        simulated: Columns::new(&[
            ("position", &wave(0.01)),
            ("velocity", &wave(0.02)),
            ("current", &wave(0.03)),
            ("voltage", &wave(0.04)),
        ]),
        force: Columns::new(&[("load", &wave(0.05))]),
        reference: Columns::new(&[("position", &wave(0.06)), ("enabled", &wave(0.07))]),
        measured: Columns::new(&[("position", &wave(0.08)), ("velocity", &wave(0.09))]),
        selection: Vec::new(),
    };
    block.selection = block.by_name();
    let trace = Trace { name: "waves".into(), source: "waves".into(), rate: 250.0, blocks: vec![block] };
    // As PyTorch's: one pass, L1 alone.
    let feedback = FeedbackShares { measured: 0.0, predicted: 0.0 };
    let plan = AugmentationPlan { loss: LossKind::L1, feedback, noise: 0.0, ..AugmentationPlan::default() };
    let mut trainer = AugmentationTrainer::new(&plan, &[trace], &[])?;
    let seconds = |trainer: &mut AugmentationTrainer| {
        let began = Instant::now();
        trainer.iterate();
        began.elapsed().as_secs_f64()
    };
    let best = (0..7).map(|_| seconds(&mut trainer)).fold(f64::INFINITY, f64::min);
    println!("{} parameters, best of 7: {:.1} ms", trainer.parameters(), 1e3 * best);

    let augmentation = trainer.augmentation();
    let stream = augmentation.stream();
    let (width, inputs) = (stream.record_width(), augmentation.header().inputs.fields.len());
    let rows: Vec<f32> = (0..JOINTS * inputs).map(|i| (i as f32 * 0.37).sin()).collect();
    let mut history: Vec<Vec<f32>> = Vec::new();
    let mut best = f64::INFINITY;
    // On one core; the first steps, whose history is short, are not counted.
    for step in 0..stream.history() + 20 {
        let began = Instant::now();
        let mut records = vec![0.0; JOINTS * width];
        let latest = &history[history.len().saturating_sub(stream.history())..];
        let past = |row: usize| latest.iter().map(move |records| &records[row * width..(row + 1) * width]);
        augmentation.step(&stream, &rows, Feedback::Predicted, past, &mut records);
        if step >= stream.history() {
            best = best.min(began.elapsed().as_secs_f64());
        }
        history.push(records);
    }
    let each = best / JOINTS as f64;
    println!("{:.1} us a joint and step on one core: {:.0} joints at 250 Hz", 1e6 * each, 1.0 / (250.0 * each));
    Ok(())
}
