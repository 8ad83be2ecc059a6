//! Tests of runtime at its public interface: one program, so that it is linked once.

mod common;
mod contract_gate;
mod faults;
mod refusals;
