#![no_main]

use std::path::Path;

use lifelike_motion::formats::{ReadOptions, amass};

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let _ = amass::parse(bytes, Path::new("fuzz.npz"), &ReadOptions::default());
});
