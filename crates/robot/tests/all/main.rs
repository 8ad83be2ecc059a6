//! Tests of robot at its public interface: one program, so that it is linked once.

#![allow(clippy::unwrap_used, clippy::expect_used)]

mod actuators;
mod contract_observation;
mod contract_robot;
mod loading_clips;
mod our_characters;
mod readiness;
