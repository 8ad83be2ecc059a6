//! Commands of logs and reference motions in simulations of the whole robot.

use std::sync::Arc;

use lifelike_checkpoint::rng::stream;
use lifelike_robot::Robot;
use lifelike_sim::trace::{BODY, Columns, Recorder, Selected, Trace};
use lifelike_sim::twin::{Twin, TwinSpec, nominal_torque_constant};
use lifelike_sim::{Drive, Simulation, SimulationSpec};
use rand::Rng;
use rand_distr::StandardNormal;

use crate::{AugmentationError, FromInput};

/// Runs a log's commands in the first environment of a simulation, and returns the log with simulated states and loads. Blocks are joints
/// of the robot by name; joints that the log does not command keep their default pose. The run begins at the log's first measured
/// positions (at the commanded ones where nothing was measured), at rest. With a class for them, the robot's bodies are blocks too.
///
/// # Errors
/// [`AugmentationError::Input`] for a block that is no joint, one without a commanded position, and for another rate than the
/// robot's control rate.
pub fn replayed(
    log: &Trace,
    simulation: &mut impl Simulation,
    bodies: Option<&str>,
) -> Result<Trace, AugmentationError> {
    let robot = simulation.robot().clone();
    let commands = Commands::of(log, &robot)?;
    let mut recorder = Recorder::new(simulation, 0);
    play(std::slice::from_ref(&commands), simulation, 0, |simulation, targets| {
        let wrenches = simulation.constraint_wrenches(Drive::Targets(targets))?;
        recorder.write(simulation.state(), &wrenches, targets);
        Ok(())
    })?;
    let simulated = recorder.trace(&log.name, "");
    let mut out = log.clone();
    out.source = format!("{}; {}", simulated.source, log.source);
    for (block, joint) in out.blocks.iter_mut().zip(&commands.joints) {
        block.simulated = simulated.blocks[*joint].simulated.clone();
        block.force = simulated.blocks[*joint].force.clone();
    }
    if let Some(class) = bodies {
        out.blocks.extend(recorder.bodies(&log.name, class).blocks);
    }
    out.check()?;
    Ok(out)
}

/// Settings of measuring a twin.
#[derive(Debug, Clone, PartialEq)]
pub struct Measuring {
    /// Key of the markers' noise.
    pub seed: u64,
    /// First commands are held so long before anything is written down (s).
    pub settle: f64,
    /// Standard deviations of a body's place (m) and of its orientation (rad), as markers tell them.
    pub markers: [f64; 2],
    /// Class of the bodies; none: no bodies.
    pub bodies: Option<String>,
    /// Runs side by side.
    pub environments: usize,
}

impl Default for Measuring {
    fn default() -> Self {
        Self { seed: 0, settle: 1.0, markers: [2e-4, 3e-3], bodies: Some("body".into()), environments: 16 }
    }
}

/// Runs reference motions in the nominal simulation of a robot and on its twin, and returns traces that have both side by side: of
/// actuators position, velocity and current; of bodies, where they are asked for, place and orientation by markers.
///
/// `nominal` is the robot as simulated, `robot` what the twin is drawn from; they are the same but in experiments about wrong models.
///
/// # Errors
/// As [`replayed`], [`Twin::new`] and [`SimulationSpec::build`].
pub fn on_twin(
    references: &[Trace],
    nominal: &Arc<Robot>,
    robot: &Arc<Robot>,
    spec: &TwinSpec,
    measuring: &Measuring,
) -> Result<Vec<Trace>, AugmentationError> {
    let mut traces = Vec::with_capacity(references.len());
    for references in references.chunks(measuring.environments.max(1)) {
        let engine = SimulationSpec::new(references.len());
        let commands = references.iter().map(|run| Commands::of(run, nominal)).collect::<Result<Vec<_>, _>>()?;
        let settle = (measuring.settle * robot.control_hz).round() as usize;
        let mut simulation = engine.build(nominal.clone())?;
        let recorders = || (0..references.len()).map(|id| Recorder::new(&simulation, id)).collect::<Vec<_>>();
        let (mut simulated, mut real) = (recorders(), recorders());
        play(&commands, &mut simulation, settle, |simulation, targets| {
            let wrenches = simulation.constraint_wrenches(Drive::Targets(targets))?;
            simulated.iter_mut().for_each(|own| own.write(simulation.state(), &wrenches, targets));
            Ok(())
        })?;
        let mut twin = Twin::new(robot, spec, &engine)?;
        let none =
            lifelike_sim::ConstraintWrenches::zeros(references.len(), robot.character.bodies.len(), robot.joints());
        let mut currents: Vec<Vec<f32>> = vec![Vec::new(); references.len()];
        play(&commands, &mut twin, settle, |twin, targets| {
            real.iter_mut().for_each(|own| own.write(twin.state(), &none, targets));
            for (currents, electric) in currents.iter_mut().zip(twin.electric().chunks_exact(robot.joints())) {
                currents.extend(electric.iter().map(|own| own.current));
            }
            Ok(())
        })?;
        for (id, run) in references.iter().enumerate() {
            let mut trace = simulated[id].trace(&run.name, "");
            for (own, j) in run.blocks.iter().zip(&commands[id].joints) {
                trace.blocks[*j].class.clone_from(&own.class);
            }
            trace.source = format!("{}, measured on {}; {}", trace.source, twin.engine(), run.source);
            let told = real[id].trace(&run.name, "");
            for (j, (block, told)) in trace.blocks.iter_mut().zip(&told.blocks).enumerate() {
                let column = |name: &str| told.simulated.column(name).map(|x| x.map(f64::from).collect::<Vec<_>>());
                let [position, velocity] = ["position", "velocity"].map(|name| column(name).unwrap_or_default());
                let current = currents[id].iter().skip(j).step_by(robot.joints()).map(|x| f64::from(*x));
                block.measured = Columns::new(&[
                    ("position", &position),
                    ("velocity", &velocity),
                    ("current", &current.collect::<Vec<_>>()),
                ]);
                block.selection = block.by_name();
                let constant = nominal_torque_constant(&nominal.actuators.parameters[j]);
                block.selection[2] =
                    Selected { measured: "current".into(), state: vec![("torque".into(), 1.0 / constant as f32)] };
            }
            if let Some(class) = &measuring.bodies {
                let mut bodies = simulated[id].bodies(&run.name, class).blocks;
                let told = real[id].bodies(&run.name, class).blocks;
                for (block, told) in bodies.iter_mut().zip(&told) {
                    block.measured = markers(&told.simulated, measuring, &format!("{}/{}", run.name, told.name));
                    block.selection = block.by_name();
                }
                trace.blocks.extend(bodies);
            }
            let length = run.len();
            trace.blocks.iter_mut().for_each(|block| shorten(block, length));
            trace.check()?;
            traces.push(trace);
        }
    }
    Ok(traces)
}

/// Cuts off what was played only because another run was longer.
fn shorten(block: &mut lifelike_sim::trace::BlockTrace, rows: usize) {
    for columns in [&mut block.simulated, &mut block.force, &mut block.reference, &mut block.measured] {
        columns.values.truncate(rows * columns.names.len());
    }
}

/// Place and orientation of a body as markers tell them.
fn markers(state: &Columns, measuring: &Measuring, key: &str) -> Columns {
    let mut draw = stream(measuring.seed, &format!("markers {key}"), 0, 0);
    let [place, turn] = measuring.markers;
    let mut values = Vec::with_capacity(state.rows().len() * 9);
    for row in state.rows() {
        let mut normal = || draw.sample::<f64, _>(StandardNormal);
        values.extend(row[..3].iter().map(|x| x + (place * normal()) as f32));
        // A small turn moves both columns of the matrix across themselves.
        let noise = lifelike_character::Vec3::new(turn * normal(), turn * normal(), turn * normal());
        for column in [&row[3..6], &row[6..9]] {
            let column = lifelike_character::Vec3::new(column[0].into(), column[1].into(), column[2].into());
            values.extend((column + noise.cross(&column)).iter().map(|x| *x as f32));
        }
    }
    Columns { names: BODY[..9].iter().map(|name| (*name).to_string()).collect(), values }
}

/// Commands of a run to a robot.
struct Commands {
    /// Its joints among the robot's, in the order of the run's blocks.
    joints: Vec<usize>,
    /// Angles that the run begins with, of all joints (rad).
    start: Vec<f64>,
    /// Targets of all joints, row by row (rad).
    rows: Vec<Vec<f32>>,
}

impl Commands {
    fn of(log: &Trace, robot: &Robot) -> Result<Self, AugmentationError> {
        if (log.rate - robot.control_hz).abs() > 1e-6 * robot.control_hz {
            let (what, got) = (format!("rate of log '{}'", log.name), format!("{} Hz", log.rate));
            let expected = format!("the robot's control rate, {} Hz", robot.control_hz);
            return Err(AugmentationError::mismatch(what, expected, got));
        }
        let joints = log.blocks.iter().map(|block| joint(robot, &block.name)).collect::<Result<Vec<_>, _>>()?;
        let mut start = robot.default_pose.clone();
        let mut rows = vec![robot.default_pose.iter().map(|q| *q as f32).collect::<Vec<_>>(); log.len()];
        for (block, joint) in log.blocks.iter().zip(&joints) {
            let Some(command) = block.reference.column("position") else {
                let got = format!("{:?}", block.reference.names);
                return Err(AugmentationError::mismatch(format!("references of '{}'", block.name), "a position", got));
            };
            command.zip(&mut rows).for_each(|(target, row)| row[*joint] = target);
            let measured = block.measured.column("position").and_then(|mut column| column.next());
            if let Some(first) = measured.or(rows.first().map(|row| row[*joint])) {
                start[*joint] = f64::from(first);
            }
        }
        Ok(Self { joints, start, rows })
    }
}

/// Plays runs side by side, each in its environment, and shows each step; the first commands are held for `settle` steps that are
/// not shown. A run that has ended keeps its last command, environments without a run do as the last.
fn play<S: Simulation>(
    runs: &[Commands],
    simulation: &mut S,
    settle: usize,
    mut each: impl FnMut(&mut S, &[f32]) -> Result<(), AugmentationError>,
) -> Result<(), AugmentationError> {
    let robot = simulation.robot().clone();
    let Some(last) = runs.last() else { return Ok(()) };
    let of = |id: usize| runs.get(id).unwrap_or(last);
    for id in 0..simulation.len() {
        let mut position = robot.default_position();
        for (joint, angle) in robot.character.scalar_joints().zip(&of(id).start) {
            position[joint.q_index] = *angle;
        }
        let mut velocity = vec![0.0; robot.character.nv];
        robot.character.follow(&mut position, &mut velocity);
        simulation.reset(&[id], &position, &velocity)?;
    }
    let longest = runs.iter().map(|run| run.rows.len()).max().unwrap_or(0);
    for step in 0..if longest > 0 { settle + longest } else { 0 } {
        let row = step.saturating_sub(settle);
        let target = |id: usize| {
            let rows = &of(id).rows;
            &rows[row.min(rows.len() - 1)]
        };
        let targets: Vec<f32> = (0..simulation.len()).flat_map(target).copied().collect();
        simulation.step(Drive::Targets(&targets))?;
        if step >= settle {
            each(simulation, &targets)?;
        }
    }
    Ok(())
}

fn joint(robot: &Robot, name: &str) -> Result<usize, AugmentationError> {
    let found = robot.layout.joints.iter().position(|own| own == name);
    found.ok_or_else(|| {
        let what = format!("blocks of a log of '{}'", robot.name);
        AugmentationError::mismatch(what, format!("joints: {:?}", robot.layout.joints), format!("'{name}'"))
    })
}
