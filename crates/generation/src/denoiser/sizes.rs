//! Sizes and parameters of a denoiser.

use lifelike_nn::rows::{Entry, Init, Layout};
use lifelike_nn::transformer::encoder::EncoderSizes;

use crate::{FromInput, GenerationError};

/// Form of the prompts that a network takes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TextInput {
    /// Ids are below this number, embedded by a table of the network.
    pub pieces: usize,
}

/// Sizes of a denoiser.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DenoiserSizes {
    /// The transformer.
    pub encoder: EncoderSizes,
    /// Numbers of a motion token.
    pub motion: usize,
    /// Prompts.
    pub text: TextInput,
    /// True if the diffusion step's token also says how many tokens the motion has. Positions count from the start, so
    /// without it a token learns of the end only from the tokens there, which are noise at first.
    #[serde(default)]
    pub duration: bool,
}

impl DenoiserSizes {
    /// Returns the parameters.
    ///
    /// # Errors
    /// Sizes that make no network.
    pub fn layout(&self) -> Result<Layout, GenerationError> {
        let c = self.encoder.width;
        let table = |name: &str, rows: usize| Entry {
            name: name.to_string(),
            shape: vec![rows, c],
            init: Init::Normal(1.0 / (c as f64).sqrt()),
        };
        let mut entries = Vec::new();
        entries.extend(Entry::linear("input", self.motion, c));
        entries.push(table("text.table", self.text.pieces));
        // Takes the prompt's place where there is none.
        entries.push(table("text.none", 1));
        entries.extend(Entry::linear("step.hidden", c, c));
        entries.extend(Entry::linear("step.output", c, c));
        if self.duration {
            entries.extend(Entry::linear("duration", c, c));
        }
        entries
            .extend(self.encoder.entries("encoder").map_err(|e| GenerationError::mismatch("sizes", "a network", e))?);
        entries.extend(Entry::linear("output", c, self.motion));
        Ok(Layout::new(entries))
    }
}
