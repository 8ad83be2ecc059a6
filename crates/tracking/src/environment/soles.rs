//! Soles: which stand while they should swing, and which slide while they stand.

use lifelike_character::anatomy::Sole;
use lifelike_character::rotation::from_wxyz;
use lifelike_robot::{ReferenceLibrary, Robot};
use lifelike_sim::BatchState;
use nalgebra::Vector3;

/// A sole stands when it carries more than this share of the weight.
const STANDING: f32 = 0.02;

/// Places of the feet of all environments one step ago, and what they carried. It follows from the simulated state
/// before a step, so checkpoints need not have it.
pub(super) struct Soles {
    soles: Vec<Corners>,
    /// Least force of a sole that stands (N).
    standing: f32,
    control_hz: f32,
    /// Flags of the reference's soles on the ground, `[T, F]`.
    planned: Vec<bool>,
    /// `[N, F]`.
    before: Vec<Foot>,
}

struct Corners {
    body: usize,
    corners: Vec<Vector3<f32>>,
}

#[derive(Clone, Copy, Default)]
struct Foot {
    position: [f32; 3],
    orientation: [f32; 4],
    force: f32,
}

impl Soles {
    pub(super) fn new(robot: &Robot, library: &ReferenceLibrary) -> Self {
        let corners =
            |sole: &Sole| Corners { body: sole.body, corners: sole.corners.iter().map(|c| c.cast()).collect() };
        Self {
            soles: robot.anatomy.soles.values().map(corners).collect(),
            standing: STANDING * (robot.character.mass() * robot.character.gravity.norm()) as f32,
            control_hz: robot.control_hz as f32,
            planned: library.soles_down(robot),
            before: Vec::new(),
        }
    }

    /// Remembers the state before a step.
    pub(super) fn remember(&mut self, state: &BatchState) {
        let mut before = std::mem::take(&mut self.before);
        before.clear();
        let all = (0..state.diverged.len()).flat_map(|i| (0..self.soles.len()).map(move |foot| (i, foot)));
        before.extend(all.map(|(i, foot)| self.foot(state, i, foot)));
        self.before = before;
    }

    /// Returns the squared speed of the lowest corner over the ground, summed over standing soles (m²/s²). These are
    /// the soles of environment `i` that stood before the step and stand now.
    pub(super) fn slip_square(&self, state: &BatchState, i: usize) -> f32 {
        let slip = |(foot, sole): (usize, &Corners)| {
            let (now, before) = (self.foot(state, i, foot), self.before.get(i * self.soles.len() + foot)?);
            if now.force.min(before.force) <= self.standing {
                return None;
            }
            let (turn, turned) = (from_wxyz(now.orientation)?, from_wxyz(before.orientation)?);
            let lowest = sole.corners.iter().min_by(|a, b| (turn * **a).z.total_cmp(&(turn * **b).z))?;
            let at = |foot: &Foot, corner: Vector3<f32>| Vector3::from(foot.position) + corner;
            let moved = at(&now, turn * lowest) - at(before, turned * lowest);
            Some(moved.xy().norm_squared() * self.control_hz * self.control_hz)
        };
        self.soles.iter().enumerate().filter_map(slip).sum()
    }

    /// Returns the number of soles of environment `i` that carry weight while the reference's are off the ground in a frame.
    pub(super) fn missed_swings(&self, state: &BatchState, i: usize, frame: usize) -> f32 {
        let feet = self.soles.len();
        let planned = &self.planned[frame * feet..(frame + 1) * feet];
        let forces = &state.foot_force[i * feet..(i + 1) * feet];
        planned.iter().zip(forces).filter(|(planned, force)| !**planned && **force > self.standing).count() as f32
    }

    fn foot(&self, state: &BatchState, i: usize, foot: usize) -> Foot {
        let bodies = state.body_position.len() / (3 * state.diverged.len().max(1));
        let body = i * bodies + self.soles[foot].body;
        let (p, q) = (&state.body_position[3 * body..3 * body + 3], &state.body_orientation[4 * body..4 * body + 4]);
        Foot {
            position: [p[0], p[1], p[2]],
            orientation: [q[0], q[1], q[2], q[3]],
            force: state.foot_force[i * self.soles.len() + foot],
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    /// Two environments of lima whose feet are put where the test says.
    fn state(robot: &Robot, x: f32, yaw: f32, force: f32) -> BatchState {
        let bodies = robot.character.bodies.len();
        let turn = nalgebra::UnitQuaternion::from_euler_angles(0.0, 0.0, yaw);
        BatchState {
            body_position: (0..2 * bodies).flat_map(|_| [x, 0.0, 0.1]).collect(),
            body_orientation: (0..2 * bodies).flat_map(|_| [turn.w, turn.i, turn.j, turn.k]).collect(),
            foot_force: vec![0.0, 0.0, force, 0.0],
            diverged: vec![false; 2],
            ..BatchState::default()
        }
    }

    #[test]
    fn only_a_sole_that_stood_and_stands_slips_and_turning_on_the_spot_is_slip_of_its_corners() {
        let robot = Robot::load("lima").unwrap();
        let mut soles = Soles::new(&robot, &ReferenceLibrary::standing(&robot, 0.1).unwrap());
        let weight = 16.2 * 9.81;
        soles.remember(&state(&robot, 0.0, 0.0, weight));
        let slid = state(&robot, 0.01, 0.0, weight);
        // A centimetre in a fiftieth of a second.
        assert!((soles.slip_square(&slid, 1) - 0.25).abs() < 1e-4, "{}", soles.slip_square(&slid, 1));
        assert_eq!(soles.slip_square(&slid, 0), 0.0, "its feet carry nothing");
        assert_eq!(soles.slip_square(&state(&robot, 0.01, 0.0, 0.01 * weight), 1), 0.0, "lifted");
        assert!(soles.slip_square(&state(&robot, 0.0, 0.3, weight), 1) > 0.01);
        soles.remember(&state(&robot, 0.0, 0.0, 0.0));
        assert_eq!(soles.slip_square(&slid, 1), 0.0, "just put down");
        // The first environment stands on no foot, the second on one.
        soles.planned.fill(false);
        assert_eq!([0, 1].map(|i| soles.missed_swings(&slid, i, 2)), [0.0, 1.0]);
        soles.planned.fill(true);
        assert_eq!([0, 1].map(|i| soles.missed_swings(&slid, i, 2)), [0.0, 0.0]);
    }
}
