//! Inputs of a controller, in their order and with the sensor of each:
//! `cargo run --release -p lifelike-robot --example layout -- assets/lima-path.controller.safetensors`.

use std::path::Path;

use lifelike_robot::ControllerFile;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let path = std::env::args().nth(1).ok_or("usage: CONTROLLER")?;
    let file = ControllerFile::read(Path::new(&path))?;
    let header = file.header();
    println!("'{}' at {} Hz, {} joints", header.robot, header.control_hz, header.observation.joints.len());
    for part in header.observation.parts() {
        println!("{:>4}..{:<4} {:24} {:?}", part.range.start, part.range.end, part.name, part.source);
    }
    Ok(())
}
