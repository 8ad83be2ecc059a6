//! Tests of character at its public interface: one program, so that it is linked once.

#![allow(clippy::unwrap_used, clippy::expect_used)]

mod never_panics;
mod reading_mjcf;
mod reading_urdf;
mod unusual_files;
