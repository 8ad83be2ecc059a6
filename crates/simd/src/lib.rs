//! Floor 0: which vector instructions this machine has, chosen once, and numbers that are scalars or vectors.
//!
//! A program made for every x86-64 machine may use SSE2 only. So whatever is worth vectors is compiled once for each
//! [`InstructionSet`] (a [`Task`]) and the one to run is chosen when the program starts. Vectors are `fearless_simd`'s; where
//! results must be the same on every machine, multiply-adds are its `mul_add_precise`, rounded once everywhere.

mod instruction_set;
mod number;

pub use fearless_simd::{Simd, prelude};
pub use instruction_set::{InstructionSet, Task, Unavailable, VARIABLE, vectorize};
pub use number::{Number, tanh_ratio};

/// The vector types.
pub mod vectors {
    pub use fearless_simd::{f32x4, f32x8, f32x16, f64x2, f64x4, f64x8};
}

/// The README's example is a test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
