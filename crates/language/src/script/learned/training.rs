//! Training of the reader: marked sentences, put together and with words left out.

use std::collections::BTreeMap;

use lifelike_checkpoint::rng::stream;
use lifelike_nn::adam::{AdamConfig, Descent};
use lifelike_nn::schedules::cosine;
use lifelike_train::supervised::{Decay, SupervisedCore};
use rand::Rng;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use super::network::{MOST_WORDS, Network, Noise, most_likely};
use super::sentences::Sentence;
use crate::error::LanguageError;

/// Numbers of a training.
#[derive(Debug, Clone, Copy)]
pub struct ReaderPlan {
    /// Passes over the sentences.
    pub epochs: usize,
    /// Seed of weights and of what is left out.
    pub seed: u64,
}

const BATCH: usize = 128;
/// Sentences of one task of a batch.
const PART: usize = 64;
const RATE: f64 = 2e-3;
const DECAY: f64 = 0.02;
const SMOOTHING: f32 = 0.1;
/// Share of sentences that others follow.
const JOINED: f64 = 0.3;
/// Share of these that begin with "before", "while" or the like.
const LED: f64 = 0.15;
/// Times that a sentence with several actions is read in an epoch: they are few.
const SEVERAL: usize = 3;
/// Share of words whose own numbers are left out, and of those without anything.
const NOT_OWN: f32 = 0.2;
const NOTHING: f32 = 0.05;
/// Share of numbers behind the first layer that are left out.
const DROPPED: f32 = 0.3;
/// Times that a word occurs to have numbers of its own.
const OFTEN: usize = 3;
/// Rate of the averaged weights.
const AVERAGE: f64 = 0.997;

/// Marked sentences and actions that a network reads rightly.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ReaderScore {
    /// Sentences.
    pub sentences: usize,
    /// Sentences whose actions are those marked, in their order.
    pub right: usize,
    /// Actions that are marked, and those that get the right name when their words are given.
    pub named: [usize; 2],
}

/// Returns words that occur often enough.
fn vocabulary(sentences: &[Sentence]) -> Vec<String> {
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    for word in sentences.iter().flat_map(|one| &one.words) {
        *counts.entry(word).or_default() += 1;
    }
    counts.into_iter().filter(|(_, n)| *n >= OFTEN).map(|(word, _)| word.to_string()).collect()
}

/// Trains a network on marked sentences. `report` gets the epoch, its mean loss and the averaged network.
pub(super) fn trained(
    sentences: &[Sentence],
    labels: Vec<String>,
    plan: ReaderPlan,
    mut report: impl FnMut(usize, f64, &Network),
) -> Result<Network, LanguageError> {
    let mut network = Network::new(vocabulary(sentences), labels, plan.seed)?;
    let config = AdamConfig { beta_2: 0.98, ..AdamConfig::adam() };
    let values = network.parameters.values().to_vec();
    let mut core = SupervisedCore::new(config, values.len()).with_average(AVERAGE, values);
    let ranges = network.decaying();
    let layout = std::sync::Arc::clone(network.parameters.layout());
    let times = |i: usize| if sentences[i].spans.len() > 1 { SEVERAL } else { 1 };
    let order: Vec<usize> = (0..sentences.len()).flat_map(|i| std::iter::repeat_n(i, times(i))).collect();
    let steps = (order.len().div_ceil(BATCH) * plan.epochs) as u64;
    for epoch in 0..plan.epochs {
        let mut rng = stream(plan.seed, "reader.epoch", epoch as u64, 0);
        let mut order = order.clone();
        (1..order.len()).rev().for_each(|i| order.swap(i, rng.random_range(0..=i)));
        let mut total = 0.0;
        for (number, batch) in order.chunks(BATCH).enumerate() {
            let batch: Vec<Sentence> = batch.iter().map(|&i| drawn(sentences, i, &mut rng)).collect();
            let packed = network.packed();
            let parts: Vec<_> = batch
                .par_chunks(PART)
                .enumerate()
                .map(|(part, some)| {
                    let rng = stream(plan.seed, "reader.words", (epoch << 20 | number) as u64, part as u64);
                    let mut noise = Noise { rng, own: NOT_OWN, words: NOTHING, numbers: DROPPED };
                    let learned = network.learn(&packed, some, Some(&mut noise), SMOOTHING);
                    (learned, some.len() as f32 / batch.len() as f32)
                })
                .collect();
            let mut gradient = vec![0.0_f32; network.parameters.len()];
            let mut loss = 0.0;
            for (part, share) in &parts {
                loss += part.loss * f64::from(*share);
                gradient.iter_mut().zip(&part.gradient).for_each(|(sum, g)| *sum += g * share);
            }
            total += loss;
            let warm = ((core.iteration() + 1) as f64 / 150.0).min(1.0);
            let rate = RATE * warm * cosine(core.iteration(), steps, 0.02);
            let descent = Descent { gradient: &gradient, max_norm: 5.0, rate };
            let decay = Decay { weight: DECAY, ranges: &ranges };
            core.step(&layout, network.parameters.values_mut(), loss, descent, decay);
        }
        let mut averaged = network.clone();
        if let Some(average) = core.average() {
            averaged.parameters.values_mut().copy_from_slice(average);
        }
        report(epoch, total / order.len().div_ceil(BATCH) as f64, &averaged);
    }
    if let Some(average) = core.average() {
        network.parameters.values_mut().copy_from_slice(average);
    }
    Ok(network)
}

/// Returns a sentence, perhaps with others after it.
fn drawn(sentences: &[Sentence], first: usize, rng: &mut ChaCha8Rng) -> Sentence {
    let mut own = sentences[first].clone();
    while own.words.len() < MOST_WORDS / 3 && rng.random_bool(JOINED) {
        let next = &sentences[rng.random_range(0..sentences.len())];
        if rng.random_bool(LED) { own.lead(next, rng) } else { own.join(next, rng) }
    }
    own.words.truncate(MOST_WORDS);
    let length = own.words.len();
    own.spans.retain(|(range, _)| range.end <= length);
    own
}

/// Counts what a network reads rightly.
pub(super) fn score(network: &Network, sentences: &[Sentence]) -> ReaderScore {
    let packed = network.packed();
    let mut score = ReaderScore { sentences: sentences.len(), ..ReaderScore::default() };
    for one in sentences {
        let spans = network.spans(&packed, &one.words);
        let found: Vec<usize> = spans.iter().map(|span| most_likely(&span.labels)).collect();
        let wanted: Vec<usize> = one.spans.iter().map(|(_, label)| *label).collect();
        score.right += usize::from(found == wanted);
        score.named[0] += wanted.len();
        let named = network.named(&packed, one);
        score.named[1] += named.iter().zip(&wanted).filter(|(a, b)| a == b).count();
    }
    score
}
