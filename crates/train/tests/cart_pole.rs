//! PPO learns in an environment that is not ours to track with.

#![allow(clippy::unwrap_used)]

use std::sync::Arc;

use lifelike_checkpoint::Checkpoint;
use lifelike_train::cart_pole::CartPole;
use lifelike_train::collective::Alone;
use lifelike_train::ppo::{Learner, NetworkSpec, PpoSpec};
use lifelike_train::{StepOutcome, VectorEnvironment};

fn learner(environment: &CartPole) -> Learner {
    let spec = PpoSpec { environments: 32, steps: 32, minibatch: 256, gamma: 0.99, ..PpoSpec::default() };
    let network = NetworkSpec { actor: vec![32, 32], critic: vec![32, 32], ..NetworkSpec::default() };
    Learner::new(&spec, &network, 1, environment, Arc::new(Alone))
}

/// Falls of the policy without noise in 32 episodes of 500 steps.
fn falls(learner: &Learner) -> usize {
    let mut test = CartPole::new(32, 500, 2);
    let mut outcome = StepOutcome::default();
    (0..500)
        .map(|_| {
            let mut observations = test.observations().to_vec();
            learner.normalizer().normalize(&mut observations);
            let actions = learner.actor().means(&observations);
            test.step(&actions, &mut outcome).unwrap();
            outcome.terminated.iter().filter(|fell| **fell).count()
        })
        .sum()
}

#[test]
fn ppo_balances_the_pole_within_sixty_thousand_steps() {
    let mut environment = CartPole::new(32, 500, 1);
    let mut learner = learner(&environment);
    let before = falls(&learner);
    // 60 iterations of 32 times 32 steps: 61,440.
    for i in 0..60 {
        learner.iterate(&mut environment, i).unwrap();
    }
    let after = falls(&learner);
    assert!(before > 200, "a fresh policy falls all the time: {before}");
    assert_eq!(after, 0, "{before} falls before");
}

#[test]
fn a_learner_goes_on_from_its_checkpoint_bit_for_bit() {
    let mut environment = CartPole::new(32, 500, 1);
    let mut whole = learner(&environment);
    for i in 0..2 {
        whole.iterate(&mut environment, i).unwrap();
    }
    let saved = |learner: &Learner| {
        let mut checkpoint = Checkpoint::new();
        learner.save_into(&mut checkpoint, "learner").unwrap();
        checkpoint
    };
    let mut again = environment.clone();
    let mut resumed = learner(&again);
    resumed.load(&saved(&whole), "learner").unwrap();
    whole.iterate(&mut environment, 2).unwrap();
    resumed.iterate(&mut again, 2).unwrap();
    assert!(saved(&whole).to_bytes().unwrap() == saved(&resumed).to_bytes().unwrap());
}
