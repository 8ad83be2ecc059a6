#![no_main]

use lifelike_character::Character;

libfuzzer_sys::fuzz_target!(|text: &str| {
    let _ = Character::from_urdf(text, "fuzz.urdf", None);
});
