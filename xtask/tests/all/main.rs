//! Tests of xtask at its public interface: one program, so that it is linked once.

#![allow(clippy::unwrap_used, clippy::expect_used)]

mod architecture;
mod documentation;
mod headline;
mod modules;
mod sources;
