#![no_main]

use lifelike_character::Character;

libfuzzer_sys::fuzz_target!(|text: &str| {
    let _ = Character::from_mjcf(text, "fuzz.xml", None);
});
