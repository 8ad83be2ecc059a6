#![no_main]

use std::path::Path;

use lifelike_motion::keyframes;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let _ = keyframes::parse(bytes, Path::new("fuzz.keys.toml"));
});
