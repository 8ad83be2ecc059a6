//! Robots for tests.

#![allow(clippy::unwrap_used)]

use std::path::Path;

use lifelike_character::anatomy::Overrides;
use lifelike_character::{Anatomy, Character};

/// Returns `lima` and its anatomy.
pub fn lima() -> (Character, Anatomy) {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../robots/lima.xml");
    let lima = Character::from_mjcf(&std::fs::read_to_string(file).unwrap(), "lima.xml", None).unwrap();
    let anatomy = Anatomy::guess(&lima, &Overrides::new()).unwrap();
    (lima, anatomy)
}
