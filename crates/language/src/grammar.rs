//! Our own motion grammar, free of other people's data: sentences, the motion that they describe, and the facts that
//! can be checked.
//!
//! The main path: [`Grammar`] (an extensible text) → [`Generator::draw`] → `score` (the modified keyframed text) →
//! retargeting → [`lifelike_motion::edit`] (mirror, sequence, compose, trim) → [`crate::checks`] → captions. A draw
//! combines verb, side, direction, count, speed, size and mood, or two such actions.

mod distances;
mod draw;
mod generator;
mod perform;
mod postures;
mod score;
mod spans;
mod speak;
mod table;
mod vocabulary;
pub mod words;
mod write;

pub use draw::{Draw, PartDraw};
pub use generator::{Generator, Made};
pub use perform::{FADE, Performed};
pub use score::{Cycle, Score};
pub use table::{Acts, CountRule, Grammar, Limb, Show, Synth, Tempo, Verb};
pub use vocabulary::words_of;
pub use write::{Options, Summary, write};
