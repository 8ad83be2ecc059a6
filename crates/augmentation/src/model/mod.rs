//! The State Augmentation Transformer (thesis 2.4, Fig. 2.3) and its baselines (Table 2.1).
//!
//! The main path: [`BlockTrace`](lifelike_sim::trace::BlockTrace) → [`Inputs`] (rows of numbers) → [`Network`] or
//! [`Stream`] → Δs. [`Network`] computes all steps at once, for training and traces; [`Stream`] goes step by step, for
//! a running simulation.

mod frame;
mod inputs;
mod merged;
mod network;
mod sizes;
mod stream;

pub use frame::{Frame, in_parents};
pub use inputs::{Field, Inputs, Scales, Sequence, drag};
pub use merged::{merged, split};
pub use network::{Network, NetworkPass};
pub use sizes::{Backbone, SatSizes};
pub use stream::{ClosedLoop, Stream, closed_loop};
