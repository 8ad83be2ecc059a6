//! Time of one training step (16 stretches of 256 steps), and of a running correction: `cargo run --release -p lifelike-augmentation
//! --example sat_step`. `peers/augmentation/step.py` is PyTorch's training step of the same network.

use std::error::Error;
use std::time::Instant;

use lifelike_augmentation::model::SatSizes;
use lifelike_augmentation::training::{AugmentationPlan, AugmentationTrainer, FeedbackShares, LossKind};
use lifelike_augmentation::{Augmentation, Feedback};
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
        ..BlockTrace::default()
    };
    block.selection = block.by_name();
    let trace = Trace { name: "waves".into(), source: "waves".into(), rate: 250.0, blocks: vec![block] };
    // As PyTorch's: one pass, L1 alone.
    let feedback = FeedbackShares { measured: 0.0, predicted: 0.0, ramp: 0.0 };
    let model = SatSizes { embedding: 8, width: 32, ..SatSizes::default() };
    let plan = AugmentationPlan {
        loss: LossKind::L1,
        feedback,
        noise: 0.0,
        hysteresis: Vec::new(),
        model,
        ..AugmentationPlan::default()
    };
    let mut trainer = AugmentationTrainer::new(&plan, std::slice::from_ref(&trace), &[])?;
    let seconds = |trainer: &mut AugmentationTrainer| {
        let began = Instant::now();
        trainer.iterate();
        began.elapsed().as_secs_f64()
    };
    let best = (0..7).map(|_| seconds(&mut trainer)).fold(f64::INFINITY, f64::min);
    println!("{} parameters, best of 7: {:.1} ms", trainer.parameters(), 1e3 * best);

    for (name, width, embedding, history) in
        [("as in Table 2.1", 16, 4, 128), ("a shorter history", 16, 4, 32), ("as compared with PyTorch", 32, 8, 128)]
    {
        let model = SatSizes { width, embedding, history, ..SatSizes::default() };
        let plan = AugmentationPlan { model, ..AugmentationPlan::default() };
        let augmentation = AugmentationTrainer::new(&plan, std::slice::from_ref(&trace), &[])?.augmentation();
        let one_core = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
        let each = one_core.install(|| step(&augmentation));
        println!(
            "{name}: width {width}, history {history}: {:.1} us a joint and step on one core, {:.0} joints at 250 Hz",
            1e6 * each,
            1.0 / (250.0 * each)
        );
    }
    Ok(())
}

/// Returns the time of a step of one joint (s), of many at once on one core; the first steps, whose history is short, are not counted.
fn step(augmentation: &Augmentation) -> f64 {
    let stream = augmentation.stream();
    let (width, inputs) = (stream.record_width(), augmentation.header().inputs.fields.len());
    let rows: Vec<f32> = (0..JOINTS * inputs).map(|i| (i as f32 * 0.37).sin()).collect();
    let mut history: Vec<Vec<f32>> = Vec::new();
    let mut best = f64::INFINITY;
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
    best / JOINTS as f64
}
