//! Sentences by a frozen BERT of the MiniLM kind (all-MiniLM-L6-v2, Apache-2.0; `cargo xtask fetch minilm`), 384 numbers a
//! token, inference only.

mod bert;
mod elementary;
mod tokenizer;
mod weights;

use std::path::Path;

use super::prompt;
use crate::GenerationError;

pub use bert::Bert;
pub use tokenizer::BertTokenizer;

/// Files of a folder that holds such a model.
pub const FILES: [&str; 3] = ["model.safetensors", "vocab.txt", "config.json"];

/// A frozen sentence encoder: tokenizer and network.
#[derive(Debug, Clone)]
pub struct MiniLm {
    tokenizer: BertTokenizer,
    network: Bert,
}

/// A sentence read by [`MiniLm`].
#[derive(Debug, Clone, PartialEq)]
pub struct Sentence {
    /// Ids of the tokens, `[CLS]` and `[SEP]` included.
    pub ids: Vec<u32>,
    /// Last hidden states, `[ids, width]`.
    pub hidden: Vec<f32>,
}

impl MiniLm {
    /// Reads a folder with [`FILES`].
    ///
    /// # Errors
    /// [`GenerationError::TextModel`] with the file that is missing or is no BERT's, and how to fetch it.
    pub fn load(folder: &Path) -> Result<Self, GenerationError> {
        let [weights, vocabulary, config] = FILES.map(|file| folder.join(file));
        let tokenizer = BertTokenizer::load(&vocabulary)?;
        let network = Bert::load(&weights, &config)?;
        if tokenizer.len() != network.vocabulary() {
            let what = format!("{}: word pieces", vocabulary.display());
            return Err(GenerationError::mismatch(what, network.vocabulary(), tokenizer.len()));
        }
        Ok(Self { tokenizer, network })
    }

    /// Reads a sentence.
    ///
    /// # Errors
    /// [`GenerationError::Prompt`] for a text that is no sentence.
    pub fn read(&self, text: &str) -> Result<Sentence, GenerationError> {
        let ids = self.tokenizer.encode(prompt::check(text)?, self.network.max_tokens());
        let hidden = self.network.hidden_states(&ids);
        Ok(Sentence { ids, hidden })
    }
}

impl Sentence {
    /// Returns the mean of the hidden states, `[width]`.
    pub fn mean(&self) -> Vec<f32> {
        let width = self.hidden.len() / self.ids.len().max(1);
        let mut mean = vec![0.0_f32; width];
        for token in self.hidden.chunks_exact(width.max(1)) {
            mean.iter_mut().zip(token).for_each(|(sum, x)| *sum += x);
        }
        mean.iter_mut().for_each(|x| *x /= self.ids.len().max(1) as f32);
        mean
    }

    /// Returns the mean of the hidden states at unit norm, `[width]`: what sentence-transformers calls the embedding.
    pub fn embedding(&self) -> Vec<f32> {
        let mut mean = self.mean();
        let norm = mean.iter().map(|x| x * x).sum::<f32>().sqrt().max(1e-12);
        mean.iter_mut().for_each(|x| *x /= norm);
        mean
    }
}
