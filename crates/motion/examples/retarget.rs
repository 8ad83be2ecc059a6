//! Retargets human motion to a robot: `retarget [MOTION] [ROBOT] [OUT.motion.safetensors]`, by default a keyframed walk of
//! ours to a small biped.

use std::path::Path;

use lifelike_character::anatomy::Overrides;
use lifelike_character::{Anatomy, Character};
use lifelike_motion::formats::{ReadOptions, read_source};
use lifelike_motion::retarget::{RetargetOptions, retarget};
use lifelike_motion::{container, feasibility};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut arguments = std::env::args().skip(1);
    let motion = arguments.next().map_or_else(|| here.join("motions/walk.keys.toml"), Into::into);
    let robot = arguments.next().map_or_else(|| here.join("examples/biped.xml"), Into::into);

    let source = read_source(&motion, &ReadOptions::default())?;
    let character = Character::load(&robot)?;
    let anatomy = Anatomy::guess(&character, &Overrides::new())?;
    let (clip, report) = retarget(&source, &character, &anatomy, &RetargetOptions::default())?;
    println!("{}: {:.1} s, {} joints of {}", clip.name, clip.seconds(), clip.joint_names.len(), character.name);
    println!("{}", serde_json::to_string_pretty(&report)?);

    let speeds = vec![f64::INFINITY; clip.joint_names.len()];
    let found = feasibility::check(&clip, &character, &anatomy, &speeds)?;
    println!("can be tracked: {}", found.trackable);
    if let Some(out) = arguments.next() {
        container::write(Path::new(&out), &clip)?;
    }
    Ok(())
}
