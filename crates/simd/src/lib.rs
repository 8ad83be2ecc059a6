//! Floor 0: choice of the machine's vector instructions, and numbers that are scalars or vectors.
//!
//! A program for every x86-64 machine may use SSE2 only. Vector code is therefore compiled once for each
//! [`InstructionSet`] (a [`Task`]), and the program chooses one at start. Vectors are `fearless_simd`'s. Results that
//! must be the same on every machine use its `mul_add_precise`, which is rounded once.

mod instruction_set;
mod number;

pub use fearless_simd::{Simd, prelude};
pub use instruction_set::{InstructionSet, Task, Unavailable, VARIABLE, vectorize};
pub use number::Number;

/// The vector types.
pub mod vectors {
    pub use fearless_simd::{f32x4, f32x8, f32x16, f64x2, f64x4, f64x8};
}

/// The README's example is a test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
