//! Physics steps per core-second, and where the time of one goes. The command's `bench engine` says more, but needs everything
//! that trains.
//!
//! `cargo run --release -p lifelike-sim --example throughput -- lima,humanoid 64,1024 1`

use std::sync::Arc;

use lifelike_character::Character;
use lifelike_robot::Robot;
use lifelike_sim::engine::profile::costs;
use lifelike_sim::engine::self_contacts;
use lifelike_sim::throughput::measure;
use lifelike_sim::{LifelikeSimulation, SimError};
use lifelike_simd::InstructionSet;

/// A robot whose parts touch each other.
fn load(name: &str) -> Result<Robot, Box<dyn std::error::Error>> {
    let mut robot = Robot::load(name)?;
    if self_contacts(&robot) == 0 {
        let text = robot.character.mjcf.clone().unwrap_or_default();
        let text = text.replace(r#"contype="0" conaffinity="1""#, r#"contype="1" conaffinity="1""#);
        robot.character = Character::from_mjcf(&text, name, robot.character.folder.as_deref())?.into();
    }
    Ok(robot)
}

fn rate(robot: &Arc<Robot>, environments: usize, threads: usize) -> Result<(), SimError> {
    let mut simulation = LifelikeSimulation::new(robot.clone(), environments, threads)?;
    let rate = measure(&mut simulation, &robot.default_position(), threads, 0.7)?;
    println!("{environments:6} environments: {:7.0} steps per core-second, {:7.0} per second", rate.core, rate.wall);
    Ok(())
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let names = arguments.next().unwrap_or_else(|| "lima".into());
    let environments = arguments.next().unwrap_or_else(|| "64,1024".into());
    let threads = arguments.next().map_or(Ok(1), |threads| threads.parse())?;
    for name in names.split(',') {
        let robot = Arc::new(load(name)?);
        println!("{name} with {} threads and {} instructions", threads, InstructionSet::chosen());
        for environments in environments.split(',') {
            rate(&robot, environments.parse()?, threads)?;
        }
        let costs = costs(&robot, None, &robot.default_position(), 1000)?;
        for cost in &costs {
            let (us, rate) = (1e6 * cost.seconds, 1e-9 * cost.operations / cost.seconds);
            println!("{:18} {us:6.3} us {:6.0} operations {rate:6.1} Gflop/s", cost.stage.name(), cost.operations);
        }
        let (seconds, operations) =
            costs.iter().fold((0.0, 0.0), |(s, o), cost| (s + cost.seconds, o + cost.operations));
        println!(
            "{:18} {:6.3} us {operations:6.0} operations {:6.1} Gflop/s",
            "all",
            1e6 * seconds,
            1e-9 * operations / seconds
        );
    }
    Ok(())
}
