//! Metrics of text-to-motion methods (Guo et al. 2022): pure functions of any encoder's embeddings.
//!
//! | metric | function | good |
//! | --- | --- | --- |
//! | R-precision | [`Retrieval::of`] over [`pools`] | higher |
//! | MM-dist | [`Retrieval::of`] | lower |
//! | FID | [`frechet_distance`] | lower |
//! | diversity | [`diversity`] | near the data's |
//! | multimodality | [`multimodality`] | higher |
//!
//! [`Scores`] are all of them. Each is measured several times with other draws; [`Interval`] is its mean and 95% confidence interval.

mod embeddings;
mod frechet;
mod interval;
mod retrieval;
mod scores;
mod variety;

pub use embeddings::Embeddings;
pub use frechet::{Gaussian, frechet_distance};
pub use interval::Interval;
pub use retrieval::{POOL, Retrieval, TOP, pools};
pub use scores::{HEAD, Sample, Scores};
pub use variety::{DIVERSITY_PAIRS, MULTIMODALITY_PAIRS, diversity, multimodality};
