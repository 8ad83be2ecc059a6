//! The State Augmentation Transformer (thesis 2.4, Fig. 2.3) and what it is compared with (Table 2.1).
//!
//! A [`BlockTrace`](lifelike_sim::trace::BlockTrace) becomes rows of numbers ([`Inputs`]) → [`Network`] (all steps at once, for
//! training and for traces) or [`Stream`] (step by step, for a running simulation) → Δs.

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
