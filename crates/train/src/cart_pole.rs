//! Cart-pole with a continuous force (Barto, Sutton and Anderson 1983): a small environment for tests, examples and as a pattern.

use lifelike_checkpoint::rng::stream;
use rand::Rng;

use crate::environment::{StepOutcome, VectorEnvironment};
use crate::{FromInput, TrainError};

const GRAVITY: f64 = 9.8;
const CART_MASS: f64 = 1.0;
const POLE_MASS: f64 = 0.1;
/// Half of the pole (m).
const HALF_LENGTH: f64 = 0.5;
/// Force of an action of one (N).
const FORCE: f64 = 10.0;
/// Time step (s).
const STEP: f64 = 0.02;
/// Largest position (m) and angle (rad) before an episode has failed.
const LIMITS: [f64; 2] = [2.4, 12.0 * std::f64::consts::PI / 180.0];

/// Carts with a pole that is to be kept upright by pushing the cart. Each step gives a reward of one; a pole that falls, or a
/// cart that leaves the track, terminates the episode.
#[derive(Debug, Clone)]
pub struct CartPole {
    seed: u64,
    /// Steps after which an episode is truncated.
    limit: u64,
    /// Position, velocity, angle and angular velocity of each.
    states: Vec<[f64; 4]>,
    ages: Vec<u64>,
    /// Episodes begun in each: part of the address of the next one's randomness.
    episodes: Vec<u64>,
    observations: Vec<f32>,
}

impl CartPole {
    /// Creates environments whose episodes last `limit` steps at most.
    pub fn new(environments: usize, limit: u64, seed: u64) -> Self {
        let mut new = Self {
            seed,
            limit,
            states: vec![[0.0; 4]; environments],
            ages: vec![0; environments],
            episodes: vec![0; environments],
            observations: vec![0.0; 4 * environments],
        };
        (0..environments).for_each(|i| new.reset(i));
        new.observe();
        new
    }

    /// Begins another episode near the upright pole.
    fn reset(&mut self, i: usize) {
        let mut rng = stream(self.seed, "cart_pole.reset", i as u64, self.episodes[i]);
        self.states[i] = std::array::from_fn(|_| rng.random_range(-0.05..0.05));
        self.ages[i] = 0;
        self.episodes[i] += 1;
    }

    fn observe(&mut self) {
        for (row, state) in self.observations.chunks_exact_mut(4).zip(&self.states) {
            row.iter_mut().zip(state).for_each(|(x, s)| *x = *s as f32);
        }
    }
}

/// Returns the state one step later under a force (N).
fn advance([x, velocity, angle, rate]: [f64; 4], force: f64) -> [f64; 4] {
    let (sin, cos) = angle.sin_cos();
    let mass = CART_MASS + POLE_MASS;
    let common = (force + POLE_MASS * HALF_LENGTH * rate * rate * sin) / mass;
    let inertia = HALF_LENGTH * (4.0 / 3.0 - POLE_MASS * cos * cos / mass);
    let angular = (GRAVITY * sin - cos * common) / inertia;
    let linear = common - POLE_MASS * HALF_LENGTH * angular * cos / mass;
    [x + STEP * velocity, velocity + STEP * linear, angle + STEP * rate, rate + STEP * angular]
}

impl VectorEnvironment for CartPole {
    type Error = TrainError;

    fn environments(&self) -> usize {
        self.states.len()
    }

    fn observation_size(&self) -> usize {
        4
    }

    fn action_size(&self) -> usize {
        1
    }

    fn observations(&self) -> &[f32] {
        &self.observations
    }

    fn step(&mut self, actions: &[f32], outcome: &mut StepOutcome) -> Result<(), TrainError> {
        if actions.len() != self.states.len() {
            return Err(TrainError::mismatch("actions", self.states.len(), actions.len()));
        }
        outcome.clear();
        for (i, action) in actions.iter().enumerate() {
            self.states[i] = advance(self.states[i], FORCE * f64::from(action.clamp(-1.0, 1.0)));
            self.ages[i] += 1;
            let [x, _, angle, _] = self.states[i];
            // Also true of a state that is not finite.
            let terminated = !(x.abs() <= LIMITS[0] && angle.abs() <= LIMITS[1]);
            let truncated = !terminated && self.ages[i] >= self.limit;
            outcome.rewards.push(1.0);
            outcome.terminated.push(terminated);
            outcome.truncated.push(truncated);
            if truncated {
                outcome.final_critic_observations.extend(self.states[i].map(|s| s as f32));
            }
            if terminated || truncated {
                self.reset(i);
            }
        }
        self.observe();
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn a_pole_that_nobody_holds_falls_and_a_cut_episode_tells_its_last_state() {
        let mut alone = CartPole::new(1, 1000, 3);
        let mut outcome = StepOutcome::default();
        let mut steps = 0;
        while !outcome.terminated.first().is_some_and(|t| *t) {
            alone.step(&[0.0], &mut outcome).unwrap();
            steps += 1;
        }
        assert!((20..300).contains(&steps), "{steps}");
        assert!(alone.observations().iter().all(|x| x.abs() <= 0.05), "another episode has begun");

        let mut cut = CartPole::new(2, 1, 3);
        let before = cut.clone();
        cut.step(&[1.0, 0.0], &mut outcome).unwrap();
        assert_eq!((&outcome.terminated, &outcome.truncated), (&vec![false; 2], &vec![true; 2]));
        let last: Vec<f32> =
            [(0, FORCE), (1, 0.0)].iter().flat_map(|(i, f)| advance(before.states[*i], *f)).map(|s| s as f32).collect();
        assert_eq!(outcome.final_critic_observations, last);
        assert!(cut.step(&[0.0], &mut outcome).unwrap_err().to_string().contains("expected 2, got 1"));
    }

    #[test]
    fn the_dynamics_by_hand() {
        // Upright and at rest, 10 N for one step: pole -10/1.1 / (0.5 (4/3 - 0.1/1.1)) rad/s², cart (10 + 0.05 * 14.634)/1.1 m/s².
        let [x, v, a, w] = advance([0.0; 4], 10.0);
        assert_eq!((x, a), (0.0, 0.0));
        assert!((w + 0.02 * 14.634_146).abs() < 1e-7 && (v - 0.02 * 9.756_097_6).abs() < 1e-7, "{v} {w}");
    }
}
