//! Tests of interop at its public interface: one program, so that it is linked once.

mod contract_interop;
mod contract_lint;
mod shuffles;
