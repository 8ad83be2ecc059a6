//! Blocks of the Temporal Fusion Transformer (Lim et al. 2021), which thesis chapter 2's State Augmentation Transformer is made
//! of, written out by hand on [`crate::rows`].
//!
//! From small to large: [`GateAddNorm`] → [`GatedResidual`] → [`VariableSelection`] (which input matters now), [`Lstm`] (what
//! was just before), [`HistoryAttention`] (which of the last K steps matters). Sequences of a batch have one length and lie
//! step by step: row `t · sequences + s` is step t of sequence s.
//!
//! Every block is held against PyTorch, forward and backward (`tests/all/fusion.rs`).

mod attention;
mod elementary;
mod gate;
mod gated_residual;
mod lstm;
mod variable_selection;

pub use attention::{AttentionPass, HistoryAttention, HistorySizes, KeyValue};
pub use gate::{GateAddNorm, GatePass};
pub use gated_residual::{GatedResidual, GatedResidualPass, GatedResidualSizes};
pub use lstm::{Lstm, LstmPass, LstmState};
pub use variable_selection::{Selected, SelectionPass, SelectionSizes, VariableSelection};
