//! PPO balances a pole on a cart: `cargo run --release -p lifelike-train --example cart_pole`.

use std::sync::Arc;

use lifelike_train::cart_pole::CartPole;
use lifelike_train::collective::Alone;
use lifelike_train::ppo::{Learner, NetworkSpec, PpoSpec};
use lifelike_train::{StepOutcome, TrainError, VectorEnvironment};

fn main() -> Result<(), TrainError> {
    // 32 carts; episodes of at most 500 steps (10 s).
    let mut environment = CartPole::new(32, 500, 1);
    let spec = PpoSpec { environments: 32, steps: 32, minibatch: 256, gamma: 0.99, ..PpoSpec::default() };
    let network = NetworkSpec { actor: vec![32, 32], critic: vec![32, 32], ..NetworkSpec::default() };
    let mut learner = Learner::new(&spec, &network, 1, &environment, Arc::new(Alone));
    for iteration in 0..60 {
        let report = learner.iterate(&mut environment, iteration)?;
        if iteration % 10 == 9 {
            println!("iteration {}: KL {:.4}, std {:.2}", iteration + 1, report.divergence, report.std);
        }
    }

    // The policy without noise, in carts that it has never seen.
    let mut test = CartPole::new(32, 500, 2);
    let mut outcome = StepOutcome::default();
    let mut falls = 0;
    for _ in 0..500 {
        let mut observations = test.observations().to_vec();
        learner.normalizer().normalize(&mut observations);
        let actions = learner.actor().means(&observations);
        test.step(&actions, &mut outcome)?;
        falls += outcome.terminated.iter().filter(|fell| **fell).count();
    }
    println!("{falls} falls in 32 episodes of 10 s");
    Ok(())
}
