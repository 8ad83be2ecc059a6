//! Time of one whole training step of a generator (drawing, noise, network forward and backward, clipping, Adam, average):
//! `cargo run --release -p lifelike-generation --example step -- [0 or 1: one of the sizes only]`. `peers/generator/step.py`
//! is PyTorch's.
//!
//! Sizes: those of `--plan generator` (splines), and the thesis' (rows) with a smaller batch. Motion is made up, of 48
//! to 192 rows; every sentence has the same number of word pieces.

use std::time::Instant;

use lifelike_generation::GenerationError;
use lifelike_generation::data::CaptionedMotion;
use lifelike_generation::representation::{FeatureMatrix, RepresentationSpec};
use lifelike_generation::space::SpaceKind;
use lifelike_generation::training::{GeneratorPlan, GeneratorTrainer, TrainingData};
use lifelike_language::Split;
use lifelike_nn::memory;
use lifelike_robot::Robot;

const MOTIONS: usize = 64;
const CAPTION: &str = "a person walks forward and waves with the right hand";

fn main() -> Result<(), GenerationError> {
    println!("allocator tuned: {}", memory::tune_allocator());
    let only: Option<usize> = std::env::args().nth(1).and_then(|text| text.parse().ok());
    let plans = [
        GeneratorPlan::default(),
        GeneratorPlan {
            space: SpaceKind::Frames,
            width: 512,
            layers: 8,
            inner: 1024,
            batch: 16,
            ..GeneratorPlan::default()
        },
    ];
    let robot = Robot::load("lima")?;
    let spec = RepresentationSpec::of(&robot.layout);
    let motions = (0..MOTIONS).map(|i| motion(i, &spec)).collect::<Result<Vec<_>, _>>()?;
    for (_, plan) in plans.into_iter().enumerate().filter(|(i, _)| only.is_none_or(|only| only == *i)) {
        let data = TrainingData::new(&plan, &robot, &motions)?;
        let name = format!(
            "{:?}, B {}, c {}, n {}, h {}, ff {}",
            plan.space, plan.batch, plan.width, plan.layers, plan.heads, plan.inner
        );
        let mut trainer = GeneratorTrainer::new(plan, &robot, data)?;
        trainer.step()?;
        let mut times = Vec::new();
        for _ in 0..12 {
            let began = Instant::now();
            trainer.step()?;
            times.push(1e3 * began.elapsed().as_secs_f64());
        }
        times.sort_by(f64::total_cmp);
        println!("{name}: median {:.1} ms, best {:.1} ms", times[times.len() / 2], times[0]);
    }
    Ok(())
}

/// Motion of 48 to 192 rows.
fn motion(i: usize, spec: &RepresentationSpec) -> Result<CaptionedMotion, GenerationError> {
    let (n, width) = (48 + i * 37 % 145, spec.width());
    let wave = |k: usize| ((k / width) as f32 * 0.1 + (k % width) as f32).sin() + i as f32 * 0.01;
    let rows = FeatureMatrix::new((0..n * width).map(wave).collect(), width)?;
    let (split, captions) = (Split::Train, vec![CAPTION.to_string()]);
    Ok(CaptionedMotion { name: format!("{i}"), split, rows, captions, licence: String::new() })
}
