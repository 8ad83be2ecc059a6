//! The lint's confusion table: which mistakes about an observation it finds in a policy of another stack.
//!
//! `cargo run --release --example shuffles -- g1 policy.onnx ...`

#[path = "../tests/all/shuffles/mod.rs"]
mod shuffles;

use lifelike_robot::Robot;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let robot = Robot::load(&arguments.next().ok_or("expected a robot and policies")?)?;
    for path in arguments {
        let imported = lifelike_interop::import(&std::fs::read(&path)?, &path, &robot, None)?;
        println!("{path}");
        for (mistake, found) in shuffles::found(&imported.controller, &shuffles::breadth_first(&robot), 1.0) {
            let first = found.first().map_or_else(|| "nothing".to_string(), ToString::to_string);
            println!("  {mistake}: {first}");
        }
    }
    Ok(())
}
