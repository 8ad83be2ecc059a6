//! Draws of one iteration: motions, captions, diffusion steps and noise.

use lifelike_checkpoint::rng::stream;
use rand::Rng;
use rand_distr::{Distribution, StandardNormal};

use super::data::Sample;
use crate::diffusion::Schedule;

/// One motion of a batch.
#[derive(Debug, Clone)]
pub(super) struct Draw<'a> {
    pub(super) clean: &'a [f32],
    pub(super) rows: usize,
    pub(super) noisy: Vec<f32>,
    pub(super) step: usize,
    pub(super) condition: Option<&'a [u32]>,
}

/// Draws one motion at an address: (seed, purpose, place in the batch, iteration).
pub(super) fn draw<'a>(
    samples: &'a [Sample],
    which: Option<usize>,
    schedule: &Schedule,
    dropout: f64,
    (seed, purpose, place, iteration): (u64, &str, u64, u64),
) -> Draw<'a> {
    let mut rng = stream(seed, purpose, place, iteration);
    let any = rng.random_range(0..samples.len());
    let sample = &samples[which.unwrap_or(any)];
    let caption = &sample.captions[rng.random_range(0..sample.captions.len())];
    let condition = (rng.random::<f64>() >= dropout).then_some(caption.as_slice());
    let step = rng.random_range(0..schedule.len());
    let noise: Vec<f32> = sample.tokens.iter().map(|_| StandardNormal.sample(&mut rng)).collect();
    let noisy = schedule.add_noise(&sample.tokens, &noise, step);
    Draw { clean: &sample.tokens, rows: sample.rows, noisy, step, condition }
}
