//! Tests of xtask at its public interface: one program, so that it is linked once.

mod architecture;
mod documentation;
mod modules;
mod sources;
