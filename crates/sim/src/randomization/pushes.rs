//! Random pushes: their sizes and their schedule.

use lifelike_character::Role;
use lifelike_robot::Robot;
use rand::Rng;

use crate::error::SimError;
use crate::simulation::Simulation;

/// Random pushes "on the root, head, hands, and feet" (thesis 4.2.2; the numbers are ours).
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct PushSpec {
    /// Parts of the body that are pushed; those that a robot lacks are left out.
    pub roles: Vec<Role>,
    /// Largest force of a push, by the robot's weight.
    #[schemars(extend("unit" = "weight"), range(min = 0.0))]
    pub force: f64,
    /// Largest torque of a push, by the robot's weight times one metre.
    #[schemars(extend("unit" = "weight · m"), range(min = 0.0))]
    pub torque: f64,
    /// Least and greatest duration of a push (s).
    #[schemars(extend("unit" = "s"), inner(range(min = 0.0)))]
    pub duration: [f64; 2],
    /// Least and greatest pause between pushes (s).
    #[schemars(extend("unit" = "s"), inner(range(min = 0.0)))]
    pub interval: [f64; 2],
}

impl Default for PushSpec {
    fn default() -> Self {
        use Role::{Head, LeftFoot, LeftHand, Pelvis, RightFoot, RightHand};
        Self {
            roles: vec![Pelvis, Head, LeftHand, RightHand, LeftFoot, RightFoot],
            force: 0.15,
            torque: 0.02,
            duration: [0.05, 0.2],
            interval: [1.0, 4.0],
        }
    }
}

/// One push.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Push {
    /// Index of the body.
    pub body: usize,
    /// Force at its centre of mass (N, world).
    pub force_w: [f32; 3],
    /// Torque (N m, world).
    pub torque_w: [f32; 3],
}

/// Schedule of one environment's pushes, a part of checkpoints.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PushSchedule {
    /// Policy steps until the push begins, or, while it lasts, until it ends.
    pub steps: u32,
    /// The push that lasts now.
    pub active: Option<Push>,
}

impl PushSchedule {
    /// A schedule whose first push comes after a pause.
    pub fn new(spec: &PushSpec, control_hz: f64, rng: &mut impl Rng) -> Self {
        Self { steps: steps(spec.interval, control_hz, rng), active: None }
    }

    /// Counts one policy step, to be called before the simulation's. Returns false when a push begins or ends in it, which is
    /// [`Self::change`]'s to do.
    #[inline]
    pub fn waits(&mut self) -> bool {
        let waits = self.steps > 0;
        self.steps -= u32::from(waits);
        waits
    }

    /// Sets or ends the push of environment `id`. `rng` must be keyed by the step: steps that wait draw nothing.
    ///
    /// # Errors
    /// As [`Simulation::push`].
    pub fn change(
        &mut self,
        spec: &PushSpec,
        simulation: &mut dyn Simulation,
        id: usize,
        rng: &mut impl Rng,
    ) -> Result<(), SimError> {
        let control_hz = simulation.robot().control_hz;
        if self.active.take().is_some() {
            simulation.clear_pushes(id);
            self.steps = steps(spec.interval, control_hz, rng);
            return Ok(());
        }
        self.steps = steps(spec.duration, control_hz, rng);
        if let Some(push) = draw(spec, simulation.robot(), rng) {
            simulation.push(id, push.body, push.force_w, push.torque_w)?;
            self.active = Some(push);
        }
        Ok(())
    }
}

fn steps([low, high]: [f64; 2], control_hz: f64, rng: &mut impl Rng) -> u32 {
    // Of the steps that `waits` counts, the one that acts is the last.
    (rng.random_range(low..=high) * control_hz).round().max(1.0) as u32 - 1
}

/// A push on one of the parts, in any direction, of any strength up to the largest.
fn draw(spec: &PushSpec, robot: &Robot, rng: &mut impl Rng) -> Option<Push> {
    let bodies: Vec<usize> =
        spec.roles.iter().filter_map(|role| robot.anatomy.places.get(role)).map(|place| place.body).collect();
    if bodies.is_empty() {
        return None;
    }
    let weight = robot.character.mass() * robot.character.gravity.norm();
    let body = bodies[rng.random_range(0..bodies.len())];
    let mut vector = |largest: f64| {
        let direction =
            nalgebra::Vector3::from(rand_distr::Distribution::<[f64; 3]>::sample(&rand_distr::UnitSphere, rng));
        let vector = direction * (largest * weight * rng.random_range(0.0..=1.0));
        [vector.x as f32, vector.y as f32, vector.z as f32]
    };
    Some(Push { body, force_w: vector(spec.force), torque_w: vector(spec.torque) })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    #[test]
    fn the_same_stream_gives_the_same_push() {
        let robot = Robot::load("lima").unwrap();
        let push = |seed| draw(&PushSpec::default(), &robot, &mut ChaCha8Rng::seed_from_u64(seed));
        assert_eq!(push(1), push(1));
        assert_ne!(push(1), push(2));
        let weight = robot.character.mass() * 9.81;
        for seed in 0..50 {
            let push = push(seed).unwrap();
            let force = nalgebra::Vector3::from(push.force_w).norm();
            assert!(f64::from(force) <= 0.15 * weight * 1.0001, "{force}");
            assert!(push.body > 0);
        }
    }
}
