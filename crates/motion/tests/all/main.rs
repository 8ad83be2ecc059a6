//! Tests of motion at its public interface: one program, so that it is linked once.

mod captured;
mod contract_edit;
mod contract_judgement;
mod contract_repair;
mod contract_retarget;
mod layouts;
