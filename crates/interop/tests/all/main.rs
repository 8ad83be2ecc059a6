//! Tests of interop at its public interface: one program, so that it is linked once.

#![allow(clippy::unwrap_used, clippy::expect_used)]

mod contract_interop;
mod contract_lint;
mod shuffles;
