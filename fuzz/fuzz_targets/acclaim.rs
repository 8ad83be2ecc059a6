#![no_main]

use std::path::Path;

use lifelike_motion::formats::{ReadOptions, amc, asf};

// A skeleton, a line `---`, a motion.
libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let cut = bytes.windows(5).position(|w| w == b"\n---\n").unwrap_or(bytes.len());
    let (skeleton, motion) = (&bytes[..cut], bytes.get(cut + 5..).unwrap_or_default());
    if let Ok(skeleton) = asf::parse(skeleton, Path::new("fuzz.asf")) {
        let _ = amc::parse(motion, Path::new("fuzz.amc"), &skeleton, &ReadOptions::default());
    }
});
