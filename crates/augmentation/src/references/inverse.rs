//! Inverse kinematics of a robot that is fixed to the world: damped Gauss and Newton between the joints' limits.

use std::ops::AddAssign;

use lifelike_character::rotation::{Quat, Vec3};
use lifelike_character::{Character, Kinematics};
use nalgebra::{DMatrix, DVector};

/// Goal of a part of the robot.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Goal {
    /// A point of a body is at a place (m, world).
    Place {
        /// The body.
        body: usize,
        /// The point in its frame (m).
        point: Vec3,
        /// The place (m, world).
        target: Vec3,
        /// Factor on the distance.
        weight: f64,
    },
    /// A body is turned so.
    Turn {
        /// The body.
        body: usize,
        /// Its orientation.
        target: Quat,
        /// Factor on the angle (m/rad: what an angle counts beside a distance).
        weight: f64,
    },
}

/// A pose that is improved from frame to frame.
pub struct Inverse<'a> {
    character: &'a Character,
    kinematics: Kinematics,
    /// Generalised position.
    position: Vec<f64>,
    /// Position and velocity index, and bounds, of the scalar joints.
    joints: Vec<(usize, usize, [f64; 2])>,
}

/// Added to the squares of every joint's influence (m²): no step is far.
const DAMPING: f64 = 1e-5;

impl<'a> Inverse<'a> {
    /// Begins at a pose of the scalar joints (rad).
    pub fn new(character: &'a Character, pose: &[f64]) -> Self {
        let range = |range: Option<(f64, f64)>| range.map_or([-f64::MAX, f64::MAX], |(low, high)| [low, high]);
        let joints: Vec<_> =
            character.scalar_joints().map(|joint| (joint.q_index, joint.v_index, range(joint.range))).collect();
        let mut position = character.reference_position();
        for ((q, _, [low, high]), angle) in joints.iter().zip(pose) {
            position[*q] = angle.clamp(*low, *high);
        }
        let mut kinematics = Kinematics::new(character);
        kinematics.update(character, &position);
        Self { character, kinematics, position, joints }
    }

    /// Returns the poses of all bodies.
    pub fn kinematics(&self) -> &Kinematics {
        &self.kinematics
    }

    /// Returns the angles of the scalar joints (rad).
    pub fn pose(&self) -> Vec<f64> {
        self.joints.iter().map(|(q, ..)| self.position[*q]).collect()
    }

    /// Takes back what is farther than `most` (rad, for each joint) from an earlier pose: near a stretched leg, goals that hardly move can
    /// ask for leaps.
    pub fn stay_near(&mut self, before: &[f64], most: &[f64]) {
        for ((q, ..), (before, most)) in self.joints.iter().zip(before.iter().zip(most)) {
            self.position[*q] = self.position[*q].clamp(before - most, before + most);
        }
        self.kinematics.update(self.character, &self.position);
    }

    /// Takes steps towards the goals; what they leave open goes towards a wished pose, with a weight (m/rad).
    pub fn solve(&mut self, goals: &[Goal], wish: &[f64], weight: f64, steps: usize) {
        let n = self.joints.len();
        for _ in 0..steps {
            let mut hessian = DMatrix::<f64>::identity(n, n) * (DAMPING + weight * weight);
            let now = self.pose();
            let mut right = DVector::from_iterator(n, wish.iter().zip(&now).map(|(w, q)| weight * weight * (w - q)));
            for goal in goals {
                let (rows, off) = self.rows(goal);
                hessian += rows.transpose() * &rows;
                right += rows.transpose() * off;
            }
            let Some(step) = hessian.cholesky().map(|factor| factor.solve(&right)) else { return };
            for ((q, _, [low, high]), step) in self.joints.iter().zip(step.iter()) {
                self.position[*q] = (self.position[*q] + step.clamp(-0.5, 0.5)).clamp(*low, *high);
            }
            self.kinematics.update(self.character, &self.position);
        }
    }

    /// A goal's weighted Jacobian on the scalar joints, and how far it is off.
    fn rows(&self, goal: &Goal) -> (DMatrix<f64>, DVector<f64>) {
        let (body, place, off, linear, weight) = match *goal {
            Goal::Place { body, point, target, weight } => {
                let place = self.kinematics.point(body, &point);
                (body, place, target - place, true, weight)
            }
            Goal::Turn { body, target, weight } => {
                let turn = target * self.kinematics.body_orientation[body].inverse();
                (body, self.kinematics.body_position[body], turn.scaled_axis(), false, weight)
            }
        };
        let mut rows = DMatrix::zeros(3, self.joints.len());
        self.kinematics.for_each_column(self.character, body, &place, |column, by_place, by_turn| {
            if let Some(slot) = self.joints.iter().position(|(_, v, _)| *v == column) {
                rows.column_mut(slot).add_assign(&(if linear { by_place } else { by_turn } * weight));
            }
        });
        (rows, DVector::from_column_slice((off * weight).as_slice()))
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use lifelike_robot::Robot;

    use super::*;

    #[test]
    fn a_place_and_a_turn_that_can_be_reached_are() {
        let robot = Robot::load(concat!(env!("CARGO_MANIFEST_DIR"), "/../robot/robots/kickbot.xml")).unwrap();
        let character = &robot.character;
        let wanted: Vec<f64> = robot.default_pose.iter().enumerate().map(|(i, q)| q + 0.2 * (i as f64).cos()).collect();
        let there = Inverse::new(character, &wanted);
        let foot = character.bodies.iter().position(|body| body.name == "left_foot").unwrap();
        let (target, turn) = (there.kinematics().body_position[foot], there.kinematics().body_orientation[foot]);
        let goals = [
            Goal::Place { body: foot, point: Vec3::zeros(), target, weight: 1.0 },
            Goal::Turn { body: foot, target: turn, weight: 0.1 },
        ];
        let mut inverse = Inverse::new(character, &robot.default_pose);
        inverse.solve(&goals, &robot.default_pose, 1e-4, 30);
        let kinematics = inverse.kinematics();
        assert!((kinematics.body_position[foot] - target).norm() < 1e-4);
        assert!(kinematics.body_orientation[foot].angle_to(&turn) < 1e-2);
        // Joints that reach no goal do what is wished.
        let neck = robot.layout.joints.iter().position(|name| name == "neck_yaw").unwrap();
        assert!((inverse.pose()[neck] - robot.default_pose[neck]).abs() < 1e-6);
    }
}
