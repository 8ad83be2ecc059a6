//! The two encoders.
//!
//! ```text
//! rows  [B, T, F] -> Down, ReLU, Down, ReLU -> residual blocks -> mean and maximum -> linear   [B, width]
//! words [B, L]    -> learned table          -> residual blocks -> mean and maximum -> linear   [B, width]
//! ```

use std::ops::Range;

use lifelike_checkpoint::rng::stream;
use lifelike_nn::conv_resnet::{Down, add_down, relu, through_relu};
use lifelike_nn::init;
use lifelike_nn::parameters::{ParameterList, Parameters};
use lifelike_nn::rows::add;
use rayon::prelude::*;

use super::encoder::{PooledEncoder, PooledPass, add_encoder, clear_padding};
use super::plan::EvaluatorPlan;

/// Rows that become one step.
const STEP: usize = 4;
/// Sequences that a core takes at a time.
const PART: usize = 16;

/// Encoders of motions and of sentences.
#[derive(Debug, Clone)]
pub struct EvaluatorNetwork {
    features: usize,
    channels: usize,
    /// Channels, residual blocks and width of the embedding.
    motion: [usize; 3],
    text: [usize; 3],
    parameters: Parameters,
}

impl EvaluatorNetwork {
    /// Returns networks for rows of `features` numbers and a vocabulary of `pieces`, with weights from the plan's seed.
    pub fn new(plan: &EvaluatorPlan, features: usize, pieces: usize) -> Self {
        let EvaluatorPlan { seed, channels: c, width, .. } = *plan;
        let (motion, text) = ([c, plan.motion_blocks, width], [c, plan.text_blocks, width]);
        let mut list = ParameterList::default();
        add_down(&mut list, "motion_in", [features, c], seed, "evaluator.motion_in");
        add_down(&mut list, "motion_down", [c, c], seed, "evaluator.motion_down");
        add_encoder(&mut list, "motion", motion, seed, "evaluator.motion");
        let table = init::normal(&mut stream(seed, "evaluator.table", 0, 0), pieces * c, 1.0);
        list.add("table", &[pieces, c], table);
        add_encoder(&mut list, "text", text, seed, "evaluator.text");
        Self { features, channels: c, motion, text, parameters: list.finish() }
    }

    /// Returns the parameters of both encoders.
    pub fn parameters(&self) -> &Parameters {
        &self.parameters
    }

    pub(super) fn parameters_mut(&mut self) -> &mut Parameters {
        &mut self.parameters
    }

    /// Returns the embeddings of standardized motions, each `[n_i, F]`, as `[B, width]`. A core for each part.
    pub fn motions(&self, motions: &[Vec<f32>]) -> Vec<f32> {
        let weights = self.weights();
        motions.par_chunks(PART).map(|part| weights.motions(part).0).collect::<Vec<_>>().concat()
    }

    /// Returns the embeddings of sentences as `[B, width]`.
    pub fn sentences(&self, sentences: &[Vec<u32>]) -> Vec<f32> {
        let weights = self.weights();
        sentences.par_chunks(PART).map(|part| weights.sentences(part).0).collect::<Vec<_>>().concat()
    }

    /// Returns the gradient of a loss of the embeddings of motions and sentences, whose gradients `loss` returns with its value.
    ///
    /// Sums are in the parts' order, whichever core had which, so the number of cores changes no bit.
    pub(super) fn gradient(
        &self,
        motions: &[Vec<f32>],
        sentences: &[Vec<u32>],
        loss: impl FnOnce(&[f32], &[f32]) -> ContrastiveLoss,
    ) -> (f64, Vec<f32>) {
        let (weights, width) = (self.weights(), self.motion[2]);
        let seen: Vec<_> = motions.par_chunks(PART).map(|part| weights.motions(part)).collect();
        let read: Vec<_> = sentences.par_chunks(PART).map(|part| weights.sentences(part)).collect();
        let text: Vec<f32> = read.iter().flat_map(|(rows, _)| rows).copied().collect();
        let motion: Vec<f32> = seen.iter().flat_map(|(rows, _)| rows).copied().collect();
        let ContrastiveLoss { value, by_text, by_motion } = loss(&text, &motion);
        let by_motions = seen.into_par_iter().zip(by_motion.par_chunks(PART * width)).map(|((_, pass), by)| {
            let mut sums = vec![0.0; self.parameters.len()];
            weights.motions_backward(pass, by, &mut sums);
            sums
        });
        let by_sentences = read.into_par_iter().zip(by_text.par_chunks(PART * width)).map(|((_, pass), by)| {
            let mut sums = vec![0.0; self.parameters.len()];
            weights.sentences_backward(pass, by, &mut sums);
            sums
        });
        let parts: Vec<Vec<f32>> = by_motions.chain(by_sentences).collect();
        let mut total = vec![0.0; self.parameters.len()];
        parts.iter().for_each(|sums| add(&mut total, sums));
        (value, total)
    }

    fn weights(&self) -> Weights<'_> {
        let (p, c) = (&self.parameters, self.channels);
        Weights {
            features: self.features,
            channels: c,
            motion_in: Down::new("motion_in", [self.features, c], p),
            motion_down: Down::new("motion_down", [c, c], p),
            motion: PooledEncoder::new("motion", self.motion, p),
            table: p.get("table"),
            place_of_table: p.range("table"),
            text: PooledEncoder::new("text", self.text, p),
        }
    }
}

/// Value of the loss, and its gradients by the embeddings.
pub(super) struct ContrastiveLoss {
    pub(super) value: f64,
    /// `[B, width]`.
    pub(super) by_text: Vec<f32>,
    /// `[B, width]`.
    pub(super) by_motion: Vec<f32>,
}

/// The networks with their parameters packed. A pass is one thread's work.
struct Weights<'a> {
    features: usize,
    channels: usize,
    motion_in: Down,
    motion_down: Down,
    motion: PooledEncoder,
    table: &'a [f32],
    place_of_table: Range<usize>,
    text: PooledEncoder,
}

/// Numbers that the backward pass of motions needs.
struct MotionPass {
    x: Vec<f32>,
    halves: Vec<usize>,
    first: Vec<f32>,
    second: Vec<f32>,
    pooled: PooledPass,
}

impl Weights<'_> {
    fn motions(&self, motions: &[Vec<f32>]) -> (Vec<f32>, MotionPass) {
        let lengths: Vec<usize> = motions.iter().map(|rows| rows.len() / self.features).collect();
        let steps = longest(&lengths).next_multiple_of(STEP);
        let x = self.padded(motions, steps);
        let shortened = |factor: usize| -> Vec<usize> { lengths.iter().map(|n| n.div_ceil(factor)).collect() };
        let halves = shortened(2);
        let mut first = relu(self.motion_in.forward(&x, steps));
        clear_padding(&mut first, &halves, self.channels);
        let mut second = relu(self.motion_down.forward(&first, steps / 2));
        let quarters = shortened(4);
        clear_padding(&mut second, &quarters, self.channels);
        let (rows, pooled) = self.motion.forward(second.clone(), &quarters);
        (rows, MotionPass { x, halves, first, second, pooled })
    }

    /// Motions as `[T, B, F]`, zeros beyond the end of each.
    fn padded(&self, motions: &[Vec<f32>], steps: usize) -> Vec<f32> {
        let (batch, width) = (motions.len(), self.features);
        let mut out = vec![0.0; steps * batch * width];
        for (b, rows) in motions.iter().enumerate() {
            for (step, row) in rows.chunks_exact(width).enumerate() {
                out[(step * batch + b) * width..][..width].copy_from_slice(row);
            }
        }
        out
    }

    fn motions_backward(&self, pass: MotionPass, by_rows: &[f32], sums: &mut [f32]) {
        let MotionPass { x, halves, first, second, pooled } = pass;
        let steps = x.len() / (halves.len() * self.features);
        // What is padding came out as zero, so the rectifier lets nothing through there.
        let by_second = through_relu(self.motion.backward(pooled, by_rows, sums), &second);
        let by_first = through_relu(self.motion_down.backward(&first, &by_second, steps / 2, sums), &first);
        self.motion_in.backward(&x, &by_first, steps, sums);
    }

    fn sentences(&self, sentences: &[Vec<u32>]) -> (Vec<f32>, (Vec<Vec<u32>>, PooledPass)) {
        let (batch, c) = (sentences.len(), self.channels);
        let lengths: Vec<usize> = sentences.iter().map(Vec::len).collect();
        let mut x = vec![0.0; longest(&lengths) * batch * c];
        for (b, ids) in sentences.iter().enumerate() {
            for (step, id) in ids.iter().enumerate() {
                x[(step * batch + b) * c..][..c].copy_from_slice(&self.table[*id as usize * c..][..c]);
            }
        }
        let (rows, pass) = self.text.forward(x, &lengths);
        (rows, (sentences.to_vec(), pass))
    }

    fn sentences_backward(&self, (sentences, pass): (Vec<Vec<u32>>, PooledPass), by_rows: &[f32], sums: &mut [f32]) {
        let (batch, c) = (sentences.len(), self.channels);
        let by_x = self.text.backward(pass, by_rows, sums);
        let table = &mut sums[self.place_of_table.clone()];
        for (b, ids) in sentences.iter().enumerate() {
            for (step, id) in ids.iter().enumerate() {
                add(&mut table[*id as usize * c..][..c], &by_x[(step * batch + b) * c..][..c]);
            }
        }
    }
}

fn longest(lengths: &[usize]) -> usize {
    lengths.iter().copied().max().unwrap_or(0).max(1)
}

#[cfg(test)]
mod tests {
    use super::super::contrastive::contrastive_loss;
    use super::*;

    fn network() -> EvaluatorNetwork {
        let plan =
            EvaluatorPlan { channels: 8, motion_blocks: 2, text_blocks: 1, width: 6, seed: 3, ..Default::default() };
        EvaluatorNetwork::new(&plan, 5, 11)
    }

    fn motion(rows: usize, seed: usize) -> Vec<f32> {
        (0..rows * 5).map(|i| ((i * 7 + seed) as f32 * 0.31).sin()).collect()
    }

    /// Along the gradient of each parameter the loss changes as fast as the gradient is long.
    #[test]
    fn the_gradient_is_that_of_finite_differences() {
        let network = network();
        let motions: Vec<Vec<f32>> = [9, 4, 17, 12].iter().enumerate().map(|(i, n)| motion(*n, i)).collect();
        let sentences = vec![vec![1, 2, 3], vec![4], vec![5, 6, 7, 8, 9], vec![1, 2, 10]];
        let loss = |network: &EvaluatorNetwork| {
            network.gradient(&motions, &sentences, |text, motion| contrastive_loss(text, motion, &[0, 1, 2, 3]))
        };
        let (_, gradient) = loss(&network);
        for entry in network.parameters.layout().entries() {
            let along = &gradient[network.parameters.range(&entry.name)];
            let size = along.iter().map(|x| f64::from(*x).powi(2)).sum::<f64>().sqrt();
            let moved = |by: f64| {
                let mut network = network.clone();
                let values = network.parameters.get_mut(&entry.name).iter_mut();
                values.zip(along).for_each(|(x, along)| *x += (by * f64::from(*along) / size) as f32);
                loss(&network).0
            };
            let slope = (moved(2e-3) - moved(-2e-3)) / 4e-3;
            assert!((slope - size).abs() < 0.03 * size + 1e-4, "{}: {slope}, not {size}", entry.name);
        }
    }

    #[test]
    fn an_embedding_does_not_depend_on_its_neighbours_in_a_batch() {
        let network = network();
        let [short, long] = [motion(6, 1), motion(31, 2)];
        let both = network.motions(&[short.clone(), long.clone()]);
        assert_eq!(both, [network.motions(&[short]), network.motions(&[long])].concat());
        let both = network.sentences(&[vec![3], vec![1, 2, 3, 4, 5]]);
        assert_eq!(both, [network.sentences(&[vec![3]]), network.sentences(&[vec![1, 2, 3, 4, 5]])].concat());
    }
}
