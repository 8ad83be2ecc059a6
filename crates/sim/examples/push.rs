//! Steps eight copies of lima that hold their default pose, pushes half of them, and prints how high their trunks are.
//!
//! `cargo run --release -p lifelike-sim --example push`

use std::sync::Arc;

use lifelike_robot::Robot;
use lifelike_sim::{Drive, EnvironmentParameters, Simulation, SimulationSpec};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let robot = Arc::new(Robot::load("lima")?);
    let n = 8;
    let mut simulation = SimulationSpec::new(n).build(robot.clone())?;
    // The odd ones stand on ice.
    for id in (1..n).step_by(2) {
        let ice = EnvironmentParameters { ground_friction: Some(0.1), ..EnvironmentParameters::default() };
        simulation.set_parameters(id, ice)?;
    }
    let pose: Vec<f32> = robot.default_pose.iter().map(|&q| q as f32).collect();
    let targets = pose.repeat(n);
    let trunk = robot.character.root_joint().map_or(1, |root| root.body);
    for step in 0..100 {
        // Half a second in, the last four get 40 N to the left for 0.2 s.
        match step {
            25 => (n / 2..n).try_for_each(|id| simulation.push(id, trunk, [0.0, 40.0, 0.0], [0.0; 3]))?,
            35 => (n / 2..n).for_each(|id| simulation.clear_pushes(id)),
            _ => {}
        }
        simulation.step(Drive::Targets(&targets))?;
        if step % 20 == 19 {
            let heights = simulation.state().root_position.chunks(3).map(|p| format!("{:.3}", p[2]));
            let time = f64::from(step + 1) / robot.control_hz;
            println!("{time:.1} s: {} m", heights.collect::<Vec<_>>().join(" "));
        }
    }
    Ok(())
}
