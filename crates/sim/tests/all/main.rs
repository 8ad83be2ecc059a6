//! Tests of sim at its public interface: one program, so that it is linked once.

#![allow(clippy::unwrap_used, clippy::expect_used)]

mod contract_augmented;
mod contract_closure;
mod contract_engines;
mod contract_kickbot;
mod contract_robots;
mod contract_twin;
mod contract_vectors;
mod oracle_bench;
mod oracle_character;
mod oracle_closure;
mod oracle_constraint_wrenches;
mod oracle_contact;
mod oracle_coupling;
mod oracle_engine;
mod oracle_friction;
mod oracle_mujoco;
mod world;
