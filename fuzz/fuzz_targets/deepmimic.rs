#![no_main]

use std::path::Path;

use lifelike_motion::formats::{ReadOptions, deepmimic};

// A character, a line `---`, a motion.
libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let cut = bytes.windows(5).position(|w| w == b"\n---\n").unwrap_or(bytes.len());
    let (character, motion) = (&bytes[..cut], bytes.get(cut + 5..).unwrap_or_default());
    if let Ok(character) = deepmimic::parse_character(character, Path::new("fuzz.txt")) {
        let _ = deepmimic::parse(motion, Path::new("fuzz.txt"), &character, &ReadOptions::default());
    }
});
