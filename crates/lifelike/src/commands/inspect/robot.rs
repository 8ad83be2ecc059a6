//! A robot: its bodies, joints, actuators, and what its policies will see.

use std::path::Path;

use lifelike_character::{Body, Character, Coupling, EqualityKind, Inertial, JointKind, Mat3};
use lifelike_robot::robot::role_name;
use lifelike_robot::{Readiness, Robot, RobotError, Shapes};
use lifelike_sim::engine::{self_contacts, unsupported};
use serde_json::{Value, json};

use super::next_steps;
use crate::error::CliError;
use crate::next;
use crate::output::{Output, shows_all_columns, table};

/// Prints a robot by name or path, with the page that was written of it.
pub fn inspect(name: &str, page: Option<&Path>, output: &Output) -> Result<(), CliError> {
    match Robot::load(name) {
        Ok(robot) => {
            let readiness = robot.readiness(Shapes::Primitives);
            let mut value = character(&robot.character);
            value["page"] = json!(page);
            value["verdict"] = json!(readiness.verdict());
            value["problems"] = json!(readiness.problems);
            value["control_hz"] = json!(robot.control_hz);
            value["physics_hz"] = json!(robot.control_hz * robot.substeps as f64);
            value["leg_length_m"] = json!(robot.leg_length());
            value["end_effectors"] = json!(robot.layout.end_effectors);
            value["key_bodies"] = json!(robot.profile.key_bodies);
            value["feature_size"] = json!(robot.layout.size());
            value["guessed"] = json!(robot.notes);
            value["self_contacts"] = json!(self_contacts(&robot));
            value["not_simulated"] = json!(unsupported(&robot));
            value["default_pose"] = json!(robot.default_pose);
            let actuators = robot.actuators.joints.iter().zip(&robot.actuators.parameters);
            let drive = |joint: &str| robot.character.drive(robot.character.joint(joint).ok()?);
            let actuator = |(joint, p): (&String, _)| json!({ "joint": joint, "parameters": p, "model": drive(joint) });
            value["actuators"] = actuators.map(actuator).collect();
            let roles = robot.anatomy.places.iter();
            value["anatomy"] = roles
                .map(|(role, place)| json!({ "role": role, "body": robot.character.bodies[place.body].name }))
                .collect();
            let steps = if readiness.can_train() { next_steps::of_robot(name) } else { Vec::new() };
            value["next"] = json!(next::texts(&steps));
            output.result(&value, || {
                seen(page)
                    + &judged(&robot.name, &readiness)
                    + &text(&robot.character)
                    + &control(&robot)
                    + &next::lines(&steps)
            })?;
            if readiness.can_train() {
                return Ok(());
            }
            Err(RobotError::Unfit { robot: robot.name.clone(), message: readiness.verdict() }.into())
        }
        // A character that cannot be controlled (ball joints, no joints) can still be looked at.
        Err(error @ RobotError::Unknown { .. }) => Err(error.into()),
        Err(error) => match Character::load(name) {
            Ok(found) => {
                let verdict = format!("cannot be trained: {error}");
                let mut value = character(&found);
                value["verdict"] = json!(verdict);
                value["not_a_robot"] = json!(error.to_string());
                value["page"] = json!(page);
                output.result(&value, || seen(page) + &format!("{}: {verdict}\n\n", found.name) + &text(&found))?;
                Err(error.into())
            }
            Err(_) => Err(error.into()),
        },
    }
}

/// Returns a line with the page, if one was written.
fn seen(page: Option<&Path>) -> String {
    page.map_or_else(String::new, |page| format!("open this in a browser: {}\n\n", page.display()))
}

/// The verdict in one line, then the problems, a line each.
fn judged(name: &str, readiness: &Readiness) -> String {
    let mut text = format!("{name}: {}\n", readiness.verdict());
    for p in readiness.problems.iter().skip(usize::from(!readiness.can_train())) {
        let remedy = if p.remedy.is_empty() { String::new() } else { format!("; {}", p.remedy) };
        text += &format!("  {}{remedy}\n", p.problem);
    }
    text + "\n"
}

fn kind(kind: JointKind) -> &'static str {
    match kind {
        JointKind::Free => "free",
        JointKind::Ball => "ball",
        JointKind::Slide => "slide",
        JointKind::Hinge => "hinge",
    }
}

fn closure(kind: EqualityKind) -> &'static str {
    match kind {
        EqualityKind::Connect => "ball joint",
        EqualityKind::Weld { .. } => "weld",
    }
}

/// Returns the inertia about the centre of mass along the axes of the body (kg m²): xx, yy, zz, xy, xz, yz.
fn inertia(inertial: &Inertial) -> [f64; 6] {
    let turn = inertial.orientation.to_rotation_matrix().into_inner();
    let i = turn * Mat3::from_diagonal(&inertial.diagonal) * turn.transpose();
    [i[(0, 0)], i[(1, 1)], i[(2, 2)], i[(0, 1)], i[(0, 2)], i[(1, 2)]]
}

fn character(c: &Character) -> Value {
    let bodies = c.bodies.iter().skip(1).map(|b| {
        json!({ "name": b.name, "parent": c.bodies[b.parent].name, "mass_kg": b.inertial.mass,
                "com_m": b.inertial.com.as_slice(), "inertia_kg_m2": inertia(&b.inertial) })
    });
    let joints = c.joints.iter().map(|j| {
        json!({ "name": j.name, "body": c.bodies[j.body].name, "kind": kind(j.kind), "axis": j.axis.as_slice(),
                "range": j.range, "armature": j.armature })
    });
    let equalities = c.equalities.iter().map(|e| {
        let [first, second] = e.bodies.map(|b| &c.bodies[b].name);
        json!({ "name": e.name, "kind": closure(e.kind), "bodies": [first, second], "active": e.active })
    });
    let couplings = c.couplings.iter().map(|coupling| {
        let follower = &c.joints[coupling.follower];
        json!({ "follower": follower.name, "leader": coupling.leader.map(|leader| &c.joints[leader].name),
                "polynomial": coupling.polynomial, "moves_by_itself": follower.coupling.is_none() })
    });
    json!({
        "kind": "robot", "name": c.name, "mass_kg": c.mass(), "nq": c.nq, "nv": c.nv, "timestep_s": c.timestep,
        "bodies": bodies.collect::<Vec<_>>(), "joints": joints.collect::<Vec<_>>(),
        "equalities": equalities.collect::<Vec<_>>(), "couplings": couplings.collect::<Vec<_>>(),
        "geoms": c.geoms.len(), "sites": c.sites.iter().map(|s| &s.name).collect::<Vec<_>>(), "notes": c.notes, "warnings": c.warnings,
    })
}

fn text(c: &Character) -> String {
    let (scalar, wide) = (c.scalar_joints().count(), shows_all_columns());
    let mut text = format!(
        "{}: a robot of {:.3} kg, {} bodies, {scalar} scalar joints, {} geoms, {} sites\n\n",
        c.name,
        c.mass(),
        c.bodies.len() - 1,
        c.geoms.len(),
        c.sites.len()
    );
    let rows: Vec<Vec<String>> = c
        .joints
        .iter()
        .map(|j| {
            let range = match j.range {
                Some((low, high)) if j.kind == JointKind::Hinge => {
                    format!("{:.0} .. {:.0} deg", low.to_degrees(), high.to_degrees())
                }
                Some((low, high)) => format!("{low:.3} .. {high:.3}"),
                None => "unlimited".into(),
            };
            let mut row = vec![j.name.clone(), c.bodies[j.body].name.clone(), kind(j.kind).into(), range];
            if wide {
                row.push(numbers(j.axis.as_slice()));
            }
            row
        })
        .collect();
    let head = ["joint", "body", "kind", "range", "axis in the body"];
    text += &table(&head[..if wide { 5 } else { 4 }], &rows);
    if wide {
        text += "\n";
        text += &masses(c);
    }
    for e in &c.equalities {
        let [first, second] = e.bodies.map(|b| &c.bodies[b].name);
        let inactive = if e.active { "" } else { " (inactive)" };
        text += &format!("closes a loop: {} '{}' of {first} and {second}{inactive}\n", closure(e.kind), e.name);
    }
    for Coupling { follower, leader, polynomial, .. } in &c.couplings {
        let follower = &c.joints[*follower].name;
        text += &match leader {
            Some(leader) => format!("follows: {follower} = {} of {}\n", terms(polynomial), c.joints[*leader].name),
            None => format!("held: {follower} at {}\n", polynomial[0]),
        };
    }
    for note in &c.notes {
        text += &format!("not simulated: {note}\n");
    }
    text
}

/// Returns a polynomial as text, such as `0.1 - 2 x`.
fn terms(polynomial: &[f64; 5]) -> String {
    let mut text = String::new();
    for (power, &coefficient) in polynomial.iter().enumerate().filter(|(_, c)| **c != 0.0) {
        let size = numbers(&[coefficient.abs()]);
        let sign = match (text.is_empty(), coefficient < 0.0) {
            (true, false) => "",
            (true, true) => "-",
            (false, false) => " + ",
            (false, true) => " - ",
        };
        let variable = ["", " x", " x^2", " x^3", " x^4"][power];
        text += &format!("{sign}{size}{variable}");
    }
    if text.is_empty() { "0".into() } else { text }
}

/// Returns a table of what each body weighs, and where.
fn masses(c: &Character) -> String {
    let row = |b: &Body| {
        let place = numbers(b.inertial.com.as_slice());
        vec![b.name.clone(), format!("{:.4}", b.inertial.mass), place, numbers(&inertia(&b.inertial))]
    };
    let rows: Vec<Vec<String>> = c.bodies.iter().skip(1).map(row).collect();
    table(&["body", "mass (kg)", "centre of mass (m)", "inertia xx yy zz xy xz yz (kg m2)"], &rows)
}

/// Returns numbers with four digits that count; what is a billionth of the largest is zero.
fn numbers(values: &[f64]) -> String {
    let largest = values.iter().fold(0.0_f64, |largest, value| largest.max(value.abs()));
    let short = |value: &f64| {
        let value = if value.abs() <= 1e-9 * largest { 0.0 } else { *value };
        format!("{value:.3e}").parse().unwrap_or(value).to_string()
    };
    values.iter().map(short).collect::<Vec<_>>().join(" ")
}

fn control(robot: &Robot) -> String {
    let leg = robot.leg_length().map_or("no leg found: numbers of plans are not scaled to it".into(), |leg| {
        format!(
            "leg of {leg:.3} m, hip to ankle: numbers of plans go with it, with the weight and the number of joints"
        )
    });
    let mut text = format!(
        "\n{leg}\npolicy at {} Hz, physics at {} Hz\nend effectors: {}\nkey bodies: {}\nfeatures of one frame (eq. 4.1): {}\n\n",
        robot.control_hz,
        robot.control_hz * robot.substeps as f64,
        robot.layout.end_effectors.join(", "),
        robot.profile.key_bodies.join(", "),
        robot.layout.size()
    );
    let rows: Vec<Vec<String>> = robot
        .actuators
        .joints
        .iter()
        .zip(&robot.actuators.parameters)
        .zip(&robot.default_pose)
        .map(|((joint, p), pose)| {
            let numbers = [p.kp, p.kd, p.torque_max, p.velocity_max, pose.to_degrees()];
            std::iter::once(joint.clone()).chain(numbers.iter().map(|n| format!("{n:.2}"))).collect()
        })
        .collect();
    let head = ["actuator", "kp (N m/rad)", "kd (N m s/rad)", "torque (N m)", "speed (rad/s)", "default (deg)"];
    text += &table(&head, &rows);
    let actuators = robot.actuators.joints.iter().zip(&robot.actuators.parameters);
    let loaded: Vec<&str> =
        actuators.filter(|(_, p)| p.extended_friction.is_some()).map(|(joint, _)| joint.as_str()).collect();
    if !loaded.is_empty() {
        text += &format!("friction under load: {}\n", loaded.join(", "));
    }
    let roles: Vec<Vec<String>> = robot
        .anatomy
        .places
        .iter()
        .map(|(role, place)| vec![role_name(*role), robot.character.bodies[place.body].name.clone()])
        .collect();
    text += "\n";
    text += &table(&["role", "body"], &roles);
    match self_contacts(robot) {
        0 => text += "its own parts pass through each other\n",
        pairs => text += &format!("{pairs} pairs of its own parts can touch\n"),
    }
    for line in unsupported(robot) {
        text += &format!("not simulated by our engine: {line}\n");
    }
    for note in &robot.notes {
        text += &format!("guessed: {note}\n");
    }
    text
}
