//! Prompts as numbers. A prompt is checked ([`prompt`]), then read by the built-in [`pieces`], whose ids a network embeds
//! itself. [`familiarity`] says how well a prompt is read, [`duration`] how long its motion is.

pub mod duration;
pub mod familiarity;
pub mod pieces;
pub mod prompt;

/// Most tokens of a prompt; later ones are not read.
pub const MAX_TOKENS: usize = 32;
