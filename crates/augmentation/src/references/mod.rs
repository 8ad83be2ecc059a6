//! Reference motions r(t) that a robot's actuators are excited with, and tested on (thesis 2.3.3).
//!
//! [`random`] draws them: end effectors along random B-splines, joints by [`inverse`] kinematics; [`coverage`] says what of the joints'
//! range and speed they reach. [`authored`] reads what a person wrote as poses at times. Both come as a [`Trace`] that has references
//! and nothing else, which [`crate::replay`] runs in simulations.

pub mod authored;
mod bspline;
pub mod coverage;
pub mod inverse;
pub mod random;

use lifelike_character::Character;
use lifelike_character::rotation::Vec3;
use lifelike_robot::Robot;
use lifelike_sim::trace::{BlockTrace, Columns, Trace};

use crate::{AugmentationError, FromInput};
use inverse::{Goal, Inverse};

/// An angle of one radian counts like a distance of 0.1 m.
const TURN: f64 = 0.1;
/// Weight of what holds loops closed and feet in place beside a goal of the motion.
const HELD: f64 = 50.0;
/// Steps of the inverse kinematics for the first row, which comes from the default pose.
const FIRST: usize = 60;

/// Class of the actuators that the profile does not name.
const UNNAMED: &str = "servo";

/// Returns the references of a robot's joints as a trace, from rows of targets (rad). Classes are the profile's groups of actuators: one
/// network serves a group, on any robot that has it.
fn commands(name: &str, source: String, robot: &Robot, rows: &[Vec<f64>]) -> Trace {
    let block = |(joint, name): (usize, &String)| BlockTrace {
        name: name.clone(),
        class: robot.actuator_group(name).unwrap_or(UNNAMED).into(),
        reference: Columns::new(&[("position", &rows.iter().map(|row| row[joint]).collect::<Vec<_>>())]),
        ..BlockTrace::default()
    };
    let blocks = robot.layout.joints.iter().enumerate().map(block).collect();
    Trace { name: name.into(), source, rate: robot.control_hz, blocks }
}

/// Goals that keep what closes loops through the ground where it is in a robot's default pose.
///
/// # Errors
/// [`AugmentationError::Input`] for a robot that is not fixed to the world, and a loop that does not go through the ground.
fn held(robot: &Robot) -> Result<Vec<Goal>, AugmentationError> {
    let character: &Character = &robot.character;
    if let Some(root) = character.root_joint() {
        let what = format!("reference motions of '{}'", robot.name);
        let got = format!("the free joint '{}'", root.name);
        return Err(AugmentationError::mismatch(what, "a robot that is fixed to the world", got));
    }
    let default = Inverse::new(character, &robot.default_pose);
    let mut goals = Vec::new();
    for equality in character.equalities.iter().filter(|equality| equality.active) {
        let body = match equality.bodies {
            [0, body] | [body, 0] => body,
            [a, b] => {
                let name = |body: usize| &character.bodies[body].name;
                let got = format!("'{}' between '{}' and '{}'", equality.name, name(a), name(b));
                return Err(AugmentationError::mismatch("loops of a robot", "loops through the ground", got));
            }
        };
        let kinematics = default.kinematics();
        let (target, turn) = (kinematics.body_position[body], kinematics.body_orientation[body]);
        goals.push(Goal::Place { body, point: Vec3::zeros(), target, weight: HELD });
        goals.push(Goal::Turn { body, target: turn, weight: HELD * TURN });
    }
    Ok(goals)
}
