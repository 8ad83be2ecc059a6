//! Tests of language at its public interface: one program, so that it is linked once.

#![allow(clippy::unwrap_used, clippy::expect_used)]

mod free_words;
mod grammar;
mod humanml3d;
mod said;
