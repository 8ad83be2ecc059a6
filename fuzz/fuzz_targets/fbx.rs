#![no_main]

use std::path::Path;

use lifelike_motion::formats::{ReadOptions, fbx};

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let _ = fbx::parse(bytes, Path::new("fuzz.fbx"), &ReadOptions::default());
});
