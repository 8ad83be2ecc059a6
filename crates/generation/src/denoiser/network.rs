//! The network forward and backward.

use std::ops::Range;

use lifelike_nn::rows::{Layout, Linear, add};
use lifelike_nn::transformer::encoder::{Encoder, EncoderPass};

use super::position;
use super::sizes::DenoiserSizes;
use crate::text::MAX_TOKENS;
use crate::{FromInput, GenerationError};

/// One motion to be denoised.
#[derive(Debug, Clone, Copy)]
pub struct DenoiserInput<'a> {
    /// Standardized noisy tokens, `[tokens, motion]`, at least one.
    pub motion: &'a [f32],
    /// The diffusion step.
    pub step: usize,
    /// Ids of the prompt's pieces ([`crate::text::pieces::WordPieces`]); none for the unconditional motion of classifier-free
    /// guidance.
    pub condition: Option<&'a [u32]>,
}

/// A denoiser with its weights packed for passes.
#[derive(Debug, Clone)]
pub struct Denoiser {
    sizes: DenoiserSizes,
    input: Linear,
    table: Vec<f32>,
    none: Vec<f32>,
    hidden: Linear,
    step: Linear,
    duration: Option<Linear>,
    encoder: Encoder,
    output: Linear,
}

/// Numbers that the backward pass needs.
#[derive(Debug, Clone)]
pub struct DenoiserPass {
    motion: Vec<f32>,
    texts: Vec<Vec<usize>>,
    places: Vec<Place>,
    steps: Vec<f32>,
    durations: Vec<f32>,
    hidden: Vec<f32>,
    encoder: EncoderPass,
    encoded: Vec<f32>,
}

/// Rows of one motion among the tokens of all: text, then one of the step, then the motion.
#[derive(Debug, Clone)]
struct Place {
    text: Range<usize>,
    motion: Range<usize>,
}

impl Place {
    fn step(&self) -> usize {
        self.text.end
    }
}

impl Denoiser {
    /// Packs parameters that stand as `layout` ([`DenoiserSizes::layout`]) says.
    pub fn new(sizes: DenoiserSizes, layout: &Layout, values: &[f32]) -> Self {
        let c = sizes.encoder.width;
        Self {
            input: Linear::new("input", [sizes.motion, c], layout, values),
            table: values[layout.range("text.table")].to_vec(),
            none: values[layout.range("text.none")].to_vec(),
            hidden: Linear::new("step.hidden", [c, c], layout, values),
            step: Linear::new("step.output", [c, c], layout, values),
            duration: sizes.duration.then(|| Linear::new("duration", [c, c], layout, values)),
            encoder: Encoder::new(sizes.encoder, layout, "encoder", values),
            output: Linear::new("output", [c, sizes.motion], layout, values),
            sizes,
        }
    }

    /// Returns the clean motions, one after the other, `[all motion tokens, motion]`.
    ///
    /// # Errors
    /// [`GenerationError::Input`] for a motion without whole tokens, or a prompt of other pieces than the network's.
    pub fn forward(&self, inputs: &[DenoiserInput<'_>]) -> Result<(Vec<f32>, DenoiserPass), GenerationError> {
        let (c, f) = (self.sizes.encoder.width, self.sizes.motion);
        let mut motion = Vec::new();
        let (mut texts, mut places, mut at) = (Vec::new(), Vec::new(), 0);
        let [mut steps, mut durations] = [0, 1].map(|_| vec![0.0; inputs.len() * c]);
        let numbers = steps.chunks_exact_mut(c).zip(durations.chunks_exact_mut(c));
        for (input, (step, duration)) in inputs.iter().zip(numbers) {
            if input.motion.is_empty() || !input.motion.len().is_multiple_of(f) {
                let expected = format!("tokens of {f} numbers");
                return Err(GenerationError::mismatch("motion to denoise", expected, input.motion.len()));
            }
            motion.extend_from_slice(input.motion);
            position::add(input.step, step);
            position::add(input.motion.len() / f, duration);
            let text = self.text(input.condition)?;
            let end = at + text.len().max(1);
            let last = end + 1 + input.motion.len() / f;
            places.push(Place { text: at..end, motion: end + 1..last });
            texts.push(text);
            at = last;
        }
        let embedded = self.input.forward(&motion);
        let hidden = self.hidden.forward(&steps);
        let mut step_tokens = self.step.forward(&hidden.iter().map(|x| silu(*x)).collect::<Vec<_>>());
        if let Some(duration) = &self.duration {
            add(&mut step_tokens, &duration.forward(&durations));
        }
        let mut tokens = vec![0.0; at * c];
        let mut embedded = embedded.chunks_exact(c);
        for (i, (place, text)) in places.iter().zip(&texts).enumerate() {
            self.embed(text, &mut tokens[place.text.start * c..place.text.end * c]);
            tokens[place.step() * c..][..c].copy_from_slice(&step_tokens[i * c..][..c]);
            for (row, embedded) in place.motion.clone().zip(&mut embedded) {
                tokens[row * c..][..c].copy_from_slice(embedded);
            }
            // Places do not depend on how long the prompt is.
            let text = place.text.clone().enumerate();
            let rest = (place.step()..place.motion.end).enumerate().map(|(i, row)| (MAX_TOKENS + i, row));
            text.chain(rest).for_each(|(p, row)| position::add(p, &mut tokens[row * c..][..c]));
        }
        let lengths: Vec<usize> = places.iter().map(|place| place.motion.end - place.text.start).collect();
        let (all, encoder) = self.encoder.forward(tokens, &lengths);
        let encoded: Vec<f32> =
            places.iter().flat_map(|p| &all[p.motion.start * c..p.motion.end * c]).copied().collect();
        let clean = self.output.forward(&encoded);
        Ok((clean, DenoiserPass { motion, texts, places, steps, durations, hidden, encoder, encoded }))
    }

    /// Adds the gradients of all parameters to `sums`, from the one by what [`Self::forward`] returned.
    pub fn backward(&self, pass: DenoiserPass, gradient: &[f32], layout: &Layout, sums: &mut [f32]) {
        let c = self.sizes.encoder.width;
        let DenoiserPass { motion, texts, places, steps, durations, hidden, encoder, encoded } = pass;
        self.output.learn(&encoded, gradient, sums);
        let by_encoded = self.output.by_input(gradient);
        let mut by_all = vec![0.0; places.last().map_or(0, |place| place.motion.end) * c];
        let mut from = 0;
        for place in &places {
            let count = place.motion.len() * c;
            by_all[place.motion.start * c..][..count].copy_from_slice(&by_encoded[from..from + count]);
            from += count;
        }
        let by_tokens = self.encoder.backward(encoder, by_all, sums);
        let rows = |rows: Range<usize>| &by_tokens[rows.start * c..rows.end * c];
        let by_motion: Vec<f32> = places.iter().flat_map(|place| rows(place.motion.clone())).copied().collect();
        self.input.learn(&motion, &by_motion, sums);
        let by_steps: Vec<f32> =
            places.iter().flat_map(|place| rows(place.step()..place.step() + 1)).copied().collect();
        self.step.learn(&hidden.iter().map(|x| silu(*x)).collect::<Vec<_>>(), &by_steps, sums);
        if let Some(duration) = &self.duration {
            duration.learn(&durations, &by_steps, sums);
        }
        let mut by_hidden = self.step.by_input(&by_steps);
        by_hidden.iter_mut().zip(&hidden).for_each(|(gradient, x)| *gradient *= silu_gradient(*x));
        self.hidden.learn(&steps, &by_hidden, sums);
        for (place, text) in places.iter().zip(&texts) {
            let gradient = rows(place.text.clone());
            if text.is_empty() {
                add(&mut sums[layout.range("text.none")], gradient);
            }
            let table = &mut sums[layout.range("text.table")];
            for (id, gradient) in text.iter().zip(gradient.chunks_exact(c)) {
                add(&mut table[id * c..][..c], gradient);
            }
        }
    }

    /// Returns the ids of a prompt's tokens; none without one.
    fn text(&self, condition: Option<&[u32]>) -> Result<Vec<usize>, GenerationError> {
        let count = self.sizes.text.pieces;
        let ids: Vec<usize> = condition.unwrap_or_default().iter().take(MAX_TOKENS).map(|id| *id as usize).collect();
        match ids.iter().find(|id| **id >= count) {
            Some(id) => Err(GenerationError::mismatch("id of a word piece", format!("below {count}"), id)),
            None => Ok(ids),
        }
    }

    fn embed(&self, text: &[usize], out: &mut [f32]) {
        let c = self.sizes.encoder.width;
        if text.is_empty() {
            out.copy_from_slice(&self.none);
        }
        for (id, out) in text.iter().zip(out.chunks_exact_mut(c)) {
            out.copy_from_slice(&self.table[id * c..][..c]);
        }
    }
}

/// x / (1 + e⁻ˣ).
fn silu(x: f32) -> f32 {
    x / (1.0 + (-x).exp())
}

fn silu_gradient(x: f32) -> f32 {
    let share = 1.0 / (1.0 + (-x).exp());
    share * (1.0 + x * (1.0 - share))
}
