//! Tests of motion at its public interface: one program, so that it is linked once.

#![allow(clippy::unwrap_used, clippy::expect_used)]

mod captured;
mod contract_edit;
mod contract_judgement;
mod contract_repair;
mod contract_retarget;
mod layouts;
