//! Tests of character at its public interface: one program, so that it is linked once.

mod never_panics;
mod reading_mjcf;
mod reading_urdf;
mod unusual_files;
