//! A prompt as a network takes it.

use crate::GenerationError;

/// A frozen encoder of text.
pub trait TextEncoder {
    /// Returns the prompt's tokens, at most [`super::MAX_TOKENS`].
    ///
    /// # Errors
    /// [`GenerationError::Prompt`] for a text that is no sentence.
    fn encode(&self, text: &str) -> Result<TextTokens, GenerationError>;

    /// Returns the numbers of one token.
    fn width(&self) -> usize;
}

/// Embedded tokens of a prompt, `[tokens, width]`, row-major.
#[derive(Debug, Clone, PartialEq)]
pub struct TextTokens {
    /// Numbers of one token.
    pub width: usize,
    /// The numbers, token after token.
    pub numbers: Vec<f32>,
}

impl TextTokens {
    /// Returns the number of tokens.
    pub fn len(&self) -> usize {
        self.numbers.len() / self.width.max(1)
    }

    /// Returns whether there is no token.
    pub fn is_empty(&self) -> bool {
        self.numbers.is_empty()
    }
}

/// A prompt in the form that a text-conditioned network takes.
#[derive(Debug, Clone, PartialEq)]
pub enum Condition {
    /// Tokens of a frozen encoder.
    Embedded(TextTokens),
    /// Ids of [`super::pieces::WordPieces`], whose embedding table belongs to the network.
    Pieces(Vec<u32>),
}

impl Condition {
    /// Returns the number of tokens.
    pub fn len(&self) -> usize {
        match self {
            Self::Embedded(tokens) => tokens.len(),
            Self::Pieces(ids) => ids.len(),
        }
    }

    /// Returns whether there is no token.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}
