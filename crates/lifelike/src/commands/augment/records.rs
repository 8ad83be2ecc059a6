//! Records of `lifelike run` as traces: what was measured beside what the simulation predicts.

use std::path::Path;
use std::sync::Arc;

use lifelike_character::{JointKind, Kinematics};
use lifelike_robot::Robot;
use lifelike_runtime::record::{CommandMessage, Entry, MeasuredMessage, Record};
use lifelike_runtime::{Mode, Phase};
use lifelike_sim::trace::{BlockTrace, Columns, Trace};
use lifelike_sim::{Drive, SimulationSpec};

use crate::commands::replay;
use crate::error::CliError;
use crate::simulated_robot::stepwise;

/// Time after which the simulation is put back to what was measured (s).
const HORIZON: f64 = 0.1;

/// Reads a record as a trace with a block for each joint.
///
/// Every 0.1 s the simulation starts from the measured joints and the measured orientation, with the lowest sole on the
/// ground. The columns compare what it predicts from the recorded commands with what was measured.
pub fn trace(path: &Path) -> Result<Trace, CliError> {
    let record = Record::read(path)?;
    let loaded = replay::prepared(&record, None, None)?.loaded;
    let robot = loaded.controller.robot();
    let fine = Arc::new(stepwise(robot)?);
    let step = fine.timestep();
    let rows = rows(&record, step);
    if rows.len() < 3 {
        return Err(CliError::Input(format!(
            "{}: expected a record in which the policy drives, got {} steps of it",
            path.display(),
            rows.len()
        )));
    }
    let mut simulation = SimulationSpec::new(1).build(Arc::clone(&fine))?;
    let joints = robot.joints();
    let window = (HORIZON / step).round().max(1.0) as usize;
    let mut columns = vec![[(); 7].map(|()| Vec::with_capacity(rows.len())); joints];
    for (i, (measured, command)) in rows.iter().enumerate() {
        if i % window == 0 {
            let (q, v) = state(&fine, measured);
            simulation.reset(&[0], &q, &v)?;
        }
        let simulated = simulation.state();
        for (j, columns) in columns.iter_mut().enumerate() {
            let values = [
                simulated.joint_position[j],
                simulated.joint_velocity[j],
                simulated.torque[j],
                command.position[j],
                measured.position[j].unwrap_or_default(),
                measured.velocity[j].unwrap_or_default(),
                measured.torque[j].unwrap_or_default(),
            ];
            columns.iter_mut().zip(values).for_each(|(column, x)| column.push(f64::from(x)));
        }
        simulation.step(Drive::Targets(&command.position))?;
    }
    let blocks = columns.iter().enumerate().map(|(j, [q, v, torque, target, own_q, own_v, _])| {
        let mut block = BlockTrace {
            name: robot.layout.joints[j].clone(),
            class: robot.actuator_group(&robot.layout.joints[j]).unwrap_or("joint").into(),
            simulated: Columns::new(&[("position", q), ("velocity", v)]),
            force: Columns::new(&[("load", torque)]),
            reference: Columns::new(&[("position", target)]),
            measured: Columns::new(&[("position", own_q), ("velocity", own_v)]),
            ..BlockTrace::default()
        };
        block.selection = block.by_name();
        block
    });
    let name = path.file_stem().map_or("record".into(), |name| name.to_string_lossy().into_owned());
    let source = format!("{}, predicted {HORIZON} s ahead", path.display());
    let trace = Trace { name, source, rate: 1.0 / step, blocks: blocks.collect() };
    trace.check()?;
    Ok(trace)
}

/// Returns the newest packet and the command at equal steps, while the policy drives.
fn rows(record: &Record, step: f64) -> Vec<(&MeasuredMessage, &CommandMessage)> {
    let (mut newest, mut rows, mut next) = (None, Vec::new(), None);
    for entry in &record.entries {
        match entry {
            Entry::Measured(message) => {
                let is_whole = message.position.iter().chain(&message.velocity).all(Option::is_some);
                newest = if is_whole { Some(message) } else { newest };
            }
            Entry::Command(command) if command.phase == Phase::Run && command.mode == Mode::Position => {
                let time = command.time_ns as f64 * 1e-9;
                if let Some(measured) = newest.filter(|_| next.is_none_or(|next| time >= next - 1e-6)) {
                    next = Some(next.unwrap_or(time) + step);
                    rows.push((measured, command));
                }
            }
            _ => {}
        }
    }
    rows
}

/// Returns position and velocity of a robot as it was measured. The root is at rest if nothing outside measures it,
/// with the lowest sole on the ground.
fn state(robot: &Robot, measured: &MeasuredMessage) -> (Vec<f64>, Vec<f64>) {
    let character = &robot.character;
    let (mut q, mut v) = (robot.default_position(), vec![0.0; character.nv]);
    let number = |x: Option<f32>| f64::from(x.unwrap_or_default());
    let mut scalar = 0;
    let mut root = None;
    for joint in &character.joints {
        if joint.kind == JointKind::Free {
            let at = joint.q_index;
            q[at + 3..at + 7].iter_mut().zip(measured.orientation).for_each(|(q, x)| *q = number(x));
            v[joint.v_index + 3..joint.v_index + 6]
                .iter_mut()
                .zip(measured.gyroscope)
                .for_each(|(v, x)| *v = number(x));
            if let Some(outside) = measured.external {
                q[at..at + 3].iter_mut().zip(outside).for_each(|(q, x)| *q = number(x));
                let velocity = outside.iter().skip(3).copied();
                v[joint.v_index..joint.v_index + 3].iter_mut().zip(velocity).for_each(|(v, x)| *v = number(x));
            }
            root = Some(at);
        } else if joint.is_scalar() {
            q[joint.q_index] = number(measured.position[scalar]);
            v[joint.v_index] = number(measured.velocity[scalar]);
            scalar += 1;
        }
    }
    character.follow(&mut q, &mut v);
    if let (Some(at), None) = (root, measured.external) {
        let mut kinematics = Kinematics::new(character);
        kinematics.update(character, &q);
        let soles = robot.anatomy.soles.values();
        let corners = soles.flat_map(|sole| sole.corners.iter().map(|corner| kinematics.point(sole.body, corner).z));
        let lowest = corners.fold(f64::INFINITY, f64::min);
        q[at + 2] -= if lowest.is_finite() { lowest } else { 0.0 };
    }
    (q, v)
}
