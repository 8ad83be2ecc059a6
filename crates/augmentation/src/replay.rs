//! A log's commands in a simulation of the whole robot.

use lifelike_robot::Robot;
use lifelike_sim::Simulation;
use lifelike_sim::trace::{Recorder, Trace};

use crate::AugmentationError;

/// Runs a log's commands in the first environment of a simulation, and returns the log with simulated states and loads. Blocks are joints
/// of the robot by name; joints that the log does not command keep their default pose. The run begins at the log's first measured
/// positions (at the commanded ones where nothing was measured), at rest.
///
/// # Errors
/// [`AugmentationError::Mismatch`] for a block that is no joint, one without a commanded position, and for another rate than the
/// robot's control rate.
pub fn replayed(log: &Trace, simulation: &mut impl Simulation) -> Result<Trace, AugmentationError> {
    let robot = simulation.robot().clone();
    if (log.rate - robot.control_hz).abs() > 1e-6 * robot.control_hz {
        let (what, got) = (format!("rate of log '{}'", log.name), format!("{} Hz", log.rate));
        return Err(AugmentationError::mismatch(
            what,
            format!("the robot's control rate, {} Hz", robot.control_hz),
            got,
        ));
    }
    let joints = log.blocks.iter().map(|block| joint(&robot, &block.name)).collect::<Result<Vec<_>, _>>()?;
    let mut commands = Vec::with_capacity(joints.len());
    let mut start = robot.default_pose.clone();
    for (block, joint) in log.blocks.iter().zip(&joints) {
        let Some(command) = block.reference.column("position") else {
            let got = format!("{:?}", block.reference.names);
            return Err(AugmentationError::mismatch(format!("references of '{}'", block.name), "a position", got));
        };
        let command: Vec<f32> = command.collect();
        let measured = block.measured.column("position").and_then(|mut column| column.next());
        if let Some(first) = measured.or(command.first().copied()) {
            start[*joint] = f64::from(first);
        }
        commands.push(command);
    }
    let mut position = robot.default_position();
    for (joint, angle) in robot.character.scalar_joints().zip(&start) {
        position[joint.q_index] = *angle;
    }
    let velocity = vec![0.0; robot.character.nv];
    simulation.reset(&[0], &position, &velocity)?;
    let mut targets: Vec<f32> = robot.default_pose.iter().map(|q| *q as f32).collect();
    let mut recorder = Recorder::new(simulation);
    for row in 0..log.len() {
        for (command, joint) in commands.iter().zip(&joints) {
            targets[*joint] = command[row];
        }
        let all = targets.repeat(simulation.len());
        recorder.step(simulation, &all, 0)?;
    }
    let simulated = recorder.trace(&log.name, "");
    let mut out = log.clone();
    out.source = format!("{}; {}", simulated.source, log.source);
    for (block, joint) in out.blocks.iter_mut().zip(&joints) {
        block.simulated = simulated.blocks[*joint].simulated.clone();
        block.force = simulated.blocks[*joint].force.clone();
    }
    out.check()?;
    Ok(out)
}

fn joint(robot: &Robot, name: &str) -> Result<usize, AugmentationError> {
    let found = robot.layout.joints.iter().position(|own| own == name);
    found.ok_or_else(|| {
        let what = format!("blocks of a log of '{}'", robot.name);
        AugmentationError::mismatch(what, format!("joints: {:?}", robot.layout.joints), format!("'{name}'"))
    })
}
