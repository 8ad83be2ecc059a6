//! Tests of augmentation at its public interface: one program, so that it is linked once.

#![allow(clippy::unwrap_used, clippy::expect_used)]

mod bench_logs;
mod correction;
mod frame;
mod network;
