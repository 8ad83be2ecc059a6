//! A controller on our own clips:
//! `cargo run --release -p lifelike-evaluation --example evaluate -- lima assets/lima-path.controller.safetensors`.

use std::path::Path;
use std::sync::Arc;

use lifelike_evaluation::{EvaluationOptions, EvaluationSetup};
use lifelike_robot::{Controller, Robot, clips};
use lifelike_sim::SimulationSpec;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [robot, controller] = &arguments[..] else { return Err("usage: ROBOT CONTROLLER".into()) };
    let robot = Arc::new(Robot::load(robot)?);
    let controller = Controller::load(Path::new(controller), Arc::clone(&robot))?;
    let simulate = |terrain, environments| {
        SimulationSpec { terrain, ..SimulationSpec::new(environments) }.build(Arc::clone(&robot))
    };
    let setup = EvaluationSetup { controller: &controller, encoder: None, simulate: &simulate, environments: 128 };
    let evaluation = setup.evaluate(&clips::builtin(&robot).clips, &EvaluationOptions::default(), |_, _| {})?;
    for table in evaluation.tables() {
        println!("{}", table.to_text());
    }
    Ok(())
}
