//! Contracts of learning on a card. A build with `--features wgpu` or `cuda` needs one; Mesa's lavapipe is one for wgpu on any machine.

use lifelike_nn::device::{Device, Processor};

use super::*;

fn devices() -> impl Iterator<Item = Device> {
    Processor::built().into_iter().map(|processor| processor.open().unwrap())
}

#[test]
fn every_device_learns_what_the_cpu_learns() {
    let (expected, _) = iterations(trainer(&restless()), 3);
    for card in devices() {
        let (got, _) = iterations(trainer(&restless()).to_device(&card), 3);
        for (k, (cpu, card)) in expected.iter().zip(&got).enumerate() {
            for (what, a, b) in [
                ("surrogate", cpu.surrogate, card.surrogate),
                ("value loss", cpu.value_loss, card.value_loss),
                ("divergence", cpu.divergence, card.divergence),
                ("gradient", cpu.gradient_norm, card.gradient_norm),
                ("std", cpu.std, card.std),
                ("reward", cpu.reward, card.reward),
            ] {
                assert!(
                    (a - b).abs() <= 1e-4 * a.abs() + 1e-5,
                    "iteration {k}, {what}: {a} on the CPU, {b} on the card"
                );
            }
        }
    }
}

#[test]
fn a_run_goes_on_on_another_device() {
    let mut cpu = trainer(&restless());
    cpu.iterate().unwrap();
    let checkpoint = cpu.checkpoint().unwrap();
    let bytes = |checkpoint: &Checkpoint| checkpoint.to_bytes().unwrap();
    for card in devices() {
        let mut there = trainer(&restless()).to_device(&card);
        there.restore(&checkpoint).unwrap();
        assert!(bytes(&there.checkpoint().unwrap()) == bytes(&checkpoint), "every bit arrives, and comes back");
        there.iterate().unwrap();
    }
}
