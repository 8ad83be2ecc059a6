//! The command, by what it does: one program for all of these tests, which links once.

#![allow(clippy::unwrap_used, clippy::expect_used)]

mod augment;
mod command;
mod critic;
mod dataset;
mod direct;
mod generate;
mod in_checkout;
mod in_folder;
mod interop;
mod lint;
mod machine;
mod priors;
mod repair;
mod robots_and_clips;
mod spline;
