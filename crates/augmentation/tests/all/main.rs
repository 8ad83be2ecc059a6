//! Tests of augmentation at its public interface: one program, so that it is linked once.

mod bench_logs;
mod correction;
mod frame;
mod network;
