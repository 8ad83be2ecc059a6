//! Pushes at random moments.

use lifelike_checkpoint::rng::stream;
use lifelike_robot::Robot;
use lifelike_sim::randomization::Push;
use rand::Rng;

use super::disturbance::Part;
use crate::{Episode, TimedPush};

/// Time in which there is one push (s).
const EVERY: f64 = 2.0;
/// Least and greatest length of a push (s).
const LASTS: [f64; 2] = [0.1, 0.2];

// Punches are those of `rhoyn/teleop-walking-benchmark` (README and `schedule_make` in `main.cpp`).
/// Time between two punches (s).
const PUNCH_EVERY: f64 = 5.0;
/// Time of the first punch (s).
const PUNCH_FIRST: f64 = 0.1;
/// Length of a punch (s).
const PUNCH_LASTS: f64 = 0.08;
/// Share of the largest force at the beginning.
const RAMP_FLOOR: f64 = 1.0 / 3.0;
/// Time until all of the largest force (s).
const RAMP: f64 = 60.0;
/// Least share of the largest force in one punch.
const PUNCH_LEAST: f64 = 0.5;

/// The pushes of an episode: one in every [`EVERY`] seconds, from a random horizontal direction on one of the part's
/// bodies. An episode shorter than twice that has one in its first half, so that none ends before it was pushed.
/// `force` is in units of the robot's weight; moments, bodies and directions do not depend on it.
pub(super) fn pushes(robot: &Robot, part: Part, force: f64, episode: &Episode, seed: u64) -> Vec<TimedPush> {
    let bodies = part.bodies(robot);
    let weight = robot.character.mass() * robot.character.gravity.norm();
    let slot = ((EVERY * robot.control_hz).round() as usize).min(episode.planned / 2).max(1);
    let mut rng = stream(seed, "robustness push", episode.number as u64, 0);
    let mut all = Vec::new();
    for begin in (1..episode.planned).step_by(slot) {
        let steps = (rng.random_range(LASTS[0]..=LASTS[1]) * robot.control_hz).round().max(1.0) as usize;
        let from = begin + rng.random_range(0..slot.saturating_sub(steps).max(1));
        let direction: f64 = rng.random_range(0.0..std::f64::consts::TAU);
        let body = rng.random_range(0..bodies.len().max(1));
        let newtons = |share: f64| (force * weight * share) as f32;
        let force_w = [newtons(direction.cos()), newtons(direction.sin()), 0.0];
        let Some(&body) = bodies.get(body) else { continue };
        all.push(TimedPush { from, until: from + steps, push: Push { body, force_w, torque_w: [0.0; 3] } });
    }
    all
}

/// The punches of an episode: one in every [`PUNCH_EVERY`] seconds at the centre of mass of a random joint's body. `force` is the
/// largest at the end of the ramp, in units of the robot's weight; moments, bodies and directions do not depend on it.
pub(super) fn punches(robot: &Robot, force: f64, episode: &Episode, seed: u64) -> Vec<TimedPush> {
    let bodies: Vec<usize> = robot.character.scalar_joints().map(|joint| joint.body).collect();
    let weight = robot.character.mass() * robot.character.gravity.norm();
    let steps = |seconds: f64| (seconds * robot.control_hz).round() as usize;
    let mut rng = stream(seed, "robustness punch", episode.number as u64, 0);
    let mut all = Vec::new();
    for i in 0.. {
        let after = PUNCH_EVERY * f64::from(i);
        let from = steps(PUNCH_FIRST + after).max(1);
        if from >= episode.planned {
            break;
        }
        let Some(&body) = bodies.get(rng.random_range(0..bodies.len().max(1))) else { break };
        // Uniform on the sphere.
        let (up, bearing) = (rng.random_range(-1.0..=1.0_f64), rng.random_range(0.0..std::f64::consts::TAU));
        let across = (1.0 - up * up).sqrt();
        let largest = force * weight * (RAMP_FLOOR + (1.0 - RAMP_FLOOR) * (after / RAMP).min(1.0));
        let newtons = largest * rng.random_range(PUNCH_LEAST..=1.0);
        let force_w = [across * bearing.cos(), across * bearing.sin(), up].map(|share| (newtons * share) as f32);
        let until = from + steps(PUNCH_LASTS).max(1);
        all.push(TimedPush { from, until, push: Push { body, force_w, torque_w: [0.0; 3] } });
    }
    all
}
