#![no_main]

use std::path::Path;

use lifelike_checkpoint::Checkpoint;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let _ = Checkpoint::from_bytes(bytes, Path::new("fuzz.safetensors"));
});
