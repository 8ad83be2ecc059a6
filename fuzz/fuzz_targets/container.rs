#![no_main]

use std::path::Path;

use lifelike_motion::container;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let _ = container::from_bytes(bytes, Path::new("fuzz.motion.safetensors"));
});
