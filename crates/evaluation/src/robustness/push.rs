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
