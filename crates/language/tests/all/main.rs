//! Tests of language at its public interface: one program, so that it is linked once.

mod grammar;
mod humanml3d;
mod said;
