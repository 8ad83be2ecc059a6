//! A Unitree G1 that follows our keyframed walk in physics, from a controller file.
//!
//! ```text
//! cargo xtask fetch unitree_g1
//! cargo run --release --manifest-path examples/g1/Cargo.toml -- \
//!     third_party/robots/unitree_g1/g1.xml assets/g1.controller.safetensors walk
//! ```

use std::error::Error;
use std::sync::Arc;

use lifelike_robot::reference::{ClipPlayer, ReferenceLibrary};
use lifelike_robot::{Controller, ControllerState, Robot, clips};
use lifelike_sim::{Drive, SimulationSpec};

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [robot, controller, motion] = arguments.as_slice() else { return Err("usage: g1 ROBOT.xml CONTROLLER CLIP".into()) };
    let robot = Arc::new(Robot::load(robot)?);
    // Refused unless joints, order, rate, gains and limits are those of training.
    let controller = Controller::load(controller.as_ref(), None, robot.clone())?;
    let clip = clips::load_one(format!("builtin:{motion}").as_ref(), &robot)?;
    let library = ReferenceLibrary::new(&robot, &[clip], None)?;
    let mut simulation = SimulationSpec::new(1).build(robot.clone())?;

    let (mut position, mut velocity) = (robot.default_position(), vec![0.0; robot.character.nv]);
    library.write_state(0, &robot, [0.0, 0.0], 0.0, &mut position, &mut velocity);
    simulation.reset(&[0], &position, &velocity)?;
    let (mut state, mut player) = (ControllerState::new(&controller), ClipPlayer::new(&library, 0));
    let mut targets = vec![0.0; robot.joints()];
    while !player.is_over() {
        let measured = simulation.state().measured(0, robot.effectors.len());
        controller.step(&mut state, &measured, &mut player, &mut targets)?;
        simulation.step(Drive::Targets(&targets))?;
    }
    let (seconds, root) = (player.frame() as f64 / robot.control_hz, &simulation.state().root_position);
    println!("after {seconds:.1} s the root is {:.2} m high and {:.2} m from where it began", root[2], root[0].hypot(root[1]));
    Ok(())
}
