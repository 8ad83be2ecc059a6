//! What PPO itself takes, without an environment: `cargo run --release -p lifelike-train --example ppo_throughput`.
//!
//! Networks, environments and minibatches of `experiments/track-all.toml`; the environments return noise at once.

use std::sync::Arc;
use std::time::Instant;

use lifelike_train::collective::Alone;
use lifelike_train::ppo::{Learner, NetworkSpec, PpoSpec};
use lifelike_train::{StepOutcome, TrainError, VectorEnvironment};

const ENVIRONMENTS: usize = 1024;
const INPUTS: [usize; 2] = [160, 190];
const JOINTS: usize = 23;

/// Rows of noise, one step after the other.
struct Noise {
    rows: Vec<f32>,
    step: usize,
}

impl Noise {
    fn new() -> Self {
        let count = 2 * ENVIRONMENTS * INPUTS[1];
        let rows =
            (0..count).map(|i| ((i as u32).wrapping_mul(2_654_435_761) >> 8) as f32 / 8_388_608.0 - 1.0).collect();
        Self { rows, step: 0 }
    }

    fn at(&self, width: usize) -> &[f32] {
        &self.rows[self.step * 37 % (ENVIRONMENTS * INPUTS[1])..][..ENVIRONMENTS * width]
    }
}

impl VectorEnvironment for Noise {
    type Error = TrainError;
    fn environments(&self) -> usize {
        ENVIRONMENTS
    }
    fn observation_size(&self) -> usize {
        INPUTS[0]
    }
    fn critic_observation_size(&self) -> usize {
        INPUTS[1]
    }
    fn action_size(&self) -> usize {
        JOINTS
    }
    fn observations(&self) -> &[f32] {
        self.at(INPUTS[0])
    }
    fn critic_observations(&self) -> &[f32] {
        self.at(INPUTS[1])
    }
    fn step(&mut self, actions: &[f32], outcome: &mut StepOutcome) -> Result<(), TrainError> {
        self.step += 1;
        outcome.clear();
        outcome.rewards.extend(actions.chunks_exact(JOINTS).map(|a| -a[0].abs()));
        outcome.terminated.extend((0..ENVIRONMENTS).map(|i| (i + self.step).is_multiple_of(300)));
        outcome.truncated.resize(ENVIRONMENTS, false);
        Ok(())
    }
}

fn main() -> Result<(), TrainError> {
    let mut environment = Noise::new();
    let spec = PpoSpec { environments: ENVIRONMENTS, steps: 6, epochs: 1, minibatch: 768, ..PpoSpec::default() };
    let layers = vec![512, 256, 128];
    let network = NetworkSpec { actor: layers.clone(), critic: layers.clone(), ..NetworkSpec::default() };
    let mut learner = Learner::new(&spec, &network, 1, &environment, Arc::new(Alone));
    let weights = |inputs: usize, outputs: usize| inputs * 512 + 512 * 256 + 256 * 128 + 128 * outputs;
    // A multiplication and an addition for each weight, once to act or to value, three times to learn (twice in a first layer).
    let flop =
        2.0 * (4 * weights(INPUTS[0], JOINTS) + 4 * weights(INPUTS[1], 1) - 512 * (INPUTS[0] + INPUTS[1])) as f64;
    learner.iterate(&mut environment, 0)?;
    let mut best = [f64::INFINITY; 3];
    for round in 1..6 {
        let (began, mut acting, mut learning) = (Instant::now(), 0.0, 0.0);
        for i in 0..10 {
            let report = learner.iterate(&mut environment, 10 * round + i)?;
            acting += report.collecting - report.stepping;
            learning += report.learning;
        }
        for (best, now) in best.iter_mut().zip([began.elapsed().as_secs_f64(), acting, learning]) {
            *best = best.min(now);
        }
    }
    let samples = (10 * ENVIRONMENTS * spec.steps) as f64;
    println!(
        "{:.0} steps/s ({:.0} Gflop/s); acting {:.1} us, learning {:.1} us a step",
        samples / best[0],
        1e-9 * flop * samples / best[0],
        1e6 * best[1] / samples,
        1e6 * best[2] / samples
    );
    Ok(())
}
