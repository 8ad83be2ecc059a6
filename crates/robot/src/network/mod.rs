//! Frozen networks: trained weights in plain arrays, without a training framework.
//!
//! [`Mlp`] is the policy, and the encoder of its own window. [`Gru`] reads its history, [`Stack`] is a policy of another stack.
//! [`ConvEncoder`] and [`ComponentEncoder`] are the motion prior's. A [`Normalizer`] comes before. A pass works in a [`Workspace`]
//! that the caller keeps, so passes of the same size allocate nothing of ours after the first.

mod components;
mod conv;
mod gru;
mod mlp;
mod normalizer;
mod stack;
mod weights;
mod workspace;

pub use components::ComponentEncoder;
pub use conv::ConvEncoder;
pub(crate) use conv::ConvSizes;
pub use gru::Gru;
pub use mlp::Mlp;
pub use normalizer::Normalizer;
pub use stack::{Layer, Stack};
pub use workspace::Workspace;

pub(crate) use weights::Weights;
