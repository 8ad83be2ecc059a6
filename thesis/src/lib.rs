//! The thesis' tables on the public API of the crates: one command for each kind of table, and the data of chapter 3.
//!
//! A command trains or loads its networks with the crates, measures them, and prints our numbers beside the published
//! ones. Only this package knows a number of the thesis.

mod autoencoders;
mod cli;
mod critic;
mod generation;
mod latent;
mod seeds;
pub mod sequences;
mod tracking;

pub use cli::Cli;
