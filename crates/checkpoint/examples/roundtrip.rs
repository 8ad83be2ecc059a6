//! Saves a checkpoint, loads it, and shows what a damaged file is refused with: `roundtrip [FILE]`.

use std::path::PathBuf;

use lifelike_checkpoint::{Checkpoint, rng};
use rand::Rng;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let path =
        std::env::args().nth(1).map_or_else(|| std::env::temp_dir().join("roundtrip.safetensors"), PathBuf::from);
    let mut random = rng::stream(1, "example.weights", 0, 0);
    let weights: Vec<f32> = (0..6).map(|_| random.random()).collect();

    let mut checkpoint = Checkpoint::new();
    checkpoint.put_f32("layer.weight", &[2, 3], weights.clone())?;
    checkpoint.put_u64("progress", &[1], vec![7])?;
    checkpoint.set_meta("note", &"an example")?;
    checkpoint.save(&path)?;

    let loaded = Checkpoint::load(&path)?;
    assert_eq!(loaded.f32s("layer.weight", &[2, 3])?, weights);
    println!("{}: {} arrays, note {:?}", path.display(), loaded.entries().len(), loaded.meta::<String>("note")?);
    if let Err(error) = loaded.f32s("layer.weight", &[3, 3]) {
        println!("another shape: {error}");
    }
    let mut bytes = std::fs::read(&path)?;
    if let Some(last) = bytes.last_mut() {
        *last ^= 1;
    }
    if let Err(error) = Checkpoint::from_bytes(&bytes, &path) {
        println!("one bit changed: {error}");
    }
    Ok(())
}
