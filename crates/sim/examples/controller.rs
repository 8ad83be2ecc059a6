//! A shipped controller in physics, without the training framework:
//! `cargo run --release -p lifelike-sim --example controller -- ROBOT CONTROLLER [CLIP]`, such as
//! `-- lima assets/lima-path.controller.safetensors walk.motion.safetensors`. Without a clip the robot stands.

use std::path::Path;
use std::sync::Arc;

use lifelike_robot::reference::standing_clip;
use lifelike_robot::{ClipPlayer, Controller, ControllerState, ReferenceLibrary, ReferenceStream, Robot};
use lifelike_sim::{Drive, SimulationSpec};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [robot, controller, clip @ ..] = &arguments[..] else { return Err("usage: ROBOT CONTROLLER [CLIP]".into()) };
    let robot = Arc::new(Robot::load(robot)?);
    let controller = Controller::load(Path::new(controller), Arc::clone(&robot))?;
    let clip = match clip.first() {
        Some(path) => lifelike_motion::container::read(Path::new(path))?,
        None => standing_clip(&robot, 5.0),
    };
    let library = Arc::new(ReferenceLibrary::new(&robot, &[clip], None)?);

    let mut simulation = SimulationSpec::new(1).build(Arc::clone(&robot))?;
    let (mut q, mut v) = (vec![0.0; robot.character.nq], vec![0.0; robot.character.nv]);
    library.write_state(0, &robot, [0.0, 0.0], 0.0, &mut q, &mut v);
    simulation.reset(&[0], &q, &v)?;

    let (mut state, mut player) = (ControllerState::new(&controller), ClipPlayer::new(library, 0));
    let mut targets = vec![0.0; robot.joints()];
    while !player.is_over() {
        let measured = simulation.state().measured(0, robot.effectors.len());
        controller.step(&mut state, &measured, &mut player, &mut targets)?;
        simulation.step(Drive::Targets(&targets))?;
    }
    let (height, asked) = (simulation.state().root_position[2], player.present_root().position[2]);
    println!("after {} steps the root is {height:.3} m high; the clip ends at {asked:.3} m", player.frame());
    Ok(())
}
