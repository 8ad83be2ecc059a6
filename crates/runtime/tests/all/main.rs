//! Tests of runtime at its public interface: one program, so that it is linked once.

#![allow(clippy::unwrap_used, clippy::expect_used)]

mod common;
mod contract_gate;
mod faults;
mod refusals;
