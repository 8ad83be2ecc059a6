#![no_main]

use std::path::Path;

use lifelike_motion::formats::{ReadOptions, robot_motion};

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let _ = robot_motion::read(bytes, Path::new("fuzz.npz"), &ReadOptions::default());
});
