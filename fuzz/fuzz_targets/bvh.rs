#![no_main]

use std::path::Path;

use lifelike_motion::formats::{ReadOptions, bvh};

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let _ = bvh::parse(bytes, Path::new("fuzz.bvh"), &ReadOptions::default());
});
