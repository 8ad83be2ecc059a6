//! Reference motion: the frames that episodes follow, and the frames in which they begin.

pub mod rsi;

pub use self::rsi::{Coverage, RsiSampler, RsiSpec};
