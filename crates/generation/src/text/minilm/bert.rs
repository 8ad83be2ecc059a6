//! BERT's encoder (Devlin et al. 2019), normalised after each sum, for one sentence at a time.

use std::path::Path;

use lifelike_nn::rows::activated;
use serde::Deserialize;

use super::elementary::{Linear, Norm, softmax};
use super::weights::{Weights, read};
use crate::GenerationError;

/// Numbers of `config.json` that the arrays' shapes do not say.
#[derive(Debug, Clone, Deserialize)]
struct Config {
    hidden_size: usize,
    intermediate_size: usize,
    num_attention_heads: usize,
    num_hidden_layers: usize,
    layer_norm_eps: f32,
    hidden_act: String,
}

/// A frozen BERT.
#[derive(Debug, Clone)]
pub struct Bert {
    width: usize,
    heads: usize,
    epsilon: f32,
    /// `[pieces, width]`.
    words: Vec<f32>,
    /// `[positions, width]`, with the embedding of the first segment added.
    positions: Vec<f32>,
    first: Norm,
    blocks: Vec<Block>,
}

/// One layer of it.
#[derive(Debug, Clone)]
struct Block {
    query: Linear,
    key: Linear,
    value: Linear,
    output: Linear,
    attended: Norm,
    wider: Linear,
    narrower: Linear,
    done: Norm,
}

impl Bert {
    /// Reads weights in the names of `transformers`, and the numbers of their `config.json`.
    ///
    /// # Errors
    /// [`GenerationError::TextModel`] for a file that cannot be read, an array that is missing or of another shape.
    pub fn load(weights: &Path, config: &Path) -> Result<Self, GenerationError> {
        let text = read(config)?;
        let sizes: Config = serde_json::from_slice(&text).map_err(|e| GenerationError::text_model(config, e))?;
        let (width, heads) = (sizes.hidden_size, sizes.num_attention_heads);
        if width == 0 || heads == 0 || !width.is_multiple_of(heads) || sizes.hidden_act != "gelu" {
            let why = format!(
                "expected gelu and heads that divide the width, got {}, {heads} heads and width {width}",
                sizes.hidden_act
            );
            return Err(GenerationError::text_model(config, why));
        }
        let bytes = read(weights)?;
        let arrays = Weights::new(weights, &bytes)?;
        let norm = |name: &str| -> Result<Norm, GenerationError> {
            let vector = |part: &str| arrays.vector(&format!("{name}.LayerNorm.{part}"), width);
            Ok(Norm { gain: vector("weight")?, bias: vector("bias")? })
        };
        let linear = |name: &str, inputs: usize, outputs: usize| -> Result<Linear, GenerationError> {
            let weight = arrays.transposed(&format!("{name}.weight"), inputs, outputs)?;
            Ok(Linear { weight, bias: arrays.vector(&format!("{name}.bias"), outputs)? })
        };
        let (words, _) = arrays.rows("embeddings.word_embeddings.weight", width)?;
        let (mut positions, _) = arrays.rows("embeddings.position_embeddings.weight", width)?;
        let (segments, _) = arrays.rows("embeddings.token_type_embeddings.weight", width)?;
        for position in positions.chunks_exact_mut(width) {
            position.iter_mut().zip(&segments).for_each(|(x, segment)| *x += segment);
        }
        let wide = sizes.intermediate_size;
        let block = |layer: usize| -> Result<Block, GenerationError> {
            let at = format!("encoder.layer.{layer}");
            Ok(Block {
                query: linear(&format!("{at}.attention.self.query"), width, width)?,
                key: linear(&format!("{at}.attention.self.key"), width, width)?,
                value: linear(&format!("{at}.attention.self.value"), width, width)?,
                output: linear(&format!("{at}.attention.output.dense"), width, width)?,
                attended: norm(&format!("{at}.attention.output"))?,
                wider: linear(&format!("{at}.intermediate.dense"), width, wide)?,
                narrower: linear(&format!("{at}.output.dense"), wide, width)?,
                done: norm(&format!("{at}.output"))?,
            })
        };
        let blocks = (0..sizes.num_hidden_layers).map(block).collect::<Result<_, _>>()?;
        let first = norm("embeddings")?;
        Ok(Self { width, heads, epsilon: sizes.layer_norm_eps, words, positions, first, blocks })
    }

    /// Returns the numbers of one token.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Returns the number of word pieces.
    pub fn vocabulary(&self) -> usize {
        self.words.len() / self.width
    }

    /// Returns the most tokens of a sentence.
    pub fn max_tokens(&self) -> usize {
        self.positions.len() / self.width
    }

    /// Returns the last hidden states of a sentence, `[ids, width]`. Ids that are no piece, and tokens beyond
    /// [`Self::max_tokens`], are left out.
    pub fn hidden_states(&self, ids: &[u32]) -> Vec<f32> {
        let words = ids.iter().filter_map(|id| self.words.get(*id as usize * self.width..)?.get(..self.width));
        let mut rows: Vec<f32> = Vec::with_capacity(ids.len() * self.width);
        for (word, position) in words.zip(self.positions.chunks_exact(self.width)) {
            rows.extend(word.iter().zip(position).map(|(w, p)| w + p));
        }
        self.first.apply(&mut rows, self.epsilon);
        for block in &self.blocks {
            block.apply(&mut rows, self.heads, self.epsilon);
        }
        rows
    }
}

impl Block {
    fn apply(&self, rows: &mut [f32], heads: usize, epsilon: f32) {
        let (q, k, v) = (self.query.apply(rows), self.key.apply(rows), self.value.apply(rows));
        let width = self.query.bias.len();
        add(rows, &self.output.apply(&attention(&q, &k, &v, width, heads)));
        self.attended.apply(rows, epsilon);
        add(rows, &self.narrower.apply(&activated(&self.wider.apply(rows))));
        self.done.apply(rows, epsilon);
    }
}

/// Returns softmax(Q Kᵀ / √d) V of every head, `[n, width]`.
fn attention(q: &[f32], k: &[f32], v: &[f32], width: usize, heads: usize) -> Vec<f32> {
    let (n, d) = (q.len() / width, width / heads);
    let mut out = vec![0.0_f32; n * width];
    let mut scores = vec![0.0_f32; n];
    let scale = 1.0 / (d as f32).sqrt();
    for (i, from) in (0..n).flat_map(|i| (0..heads).map(move |head| (i, head * d))) {
        let own = &q[i * width + from..][..d];
        for (j, score) in scores.iter_mut().enumerate() {
            let other = &k[j * width + from..][..d];
            *score = scale * own.iter().zip(other).map(|(a, b)| a * b).sum::<f32>();
        }
        softmax(&mut scores, n);
        let out = &mut out[i * width + from..][..d];
        for (j, score) in scores.iter().enumerate() {
            let value = &v[j * width + from..][..d];
            out.iter_mut().zip(value).for_each(|(sum, x)| *sum += score * x);
        }
    }
    out
}

fn add(rows: &mut [f32], other: &[f32]) {
    rows.iter_mut().zip(other).for_each(|(x, y)| *x += y);
}
