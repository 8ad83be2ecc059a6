//! The gradient steps: epochs of minibatches over one rollout, for the policy and for the value function.

use lifelike_checkpoint::rng::stream;
use lifelike_dense::Channel;
use lifelike_nn::adam::Adam;
use rand::seq::SliceRandom;

use super::config::PpoSpec;
use super::rollout::Rollout;
use super::steps::{LearningPolicy, LearningValue, gather};
use crate::collective::Collective;
use crate::gaussian::divergence;
use crate::networks::{Actor, Critic};

/// Rows on which the KL divergence is measured after each epoch. If rows spread by as much as their mean, the mean of
/// 768 has a standard error of 4%. The learning rate is changed when it is off by half.
const DIVERGENCE_ROWS: usize = 768;
/// An iteration's epochs end early when the divergence exceeds the target this many times.
const STOP: f64 = 4.0;

/// The common part of both: settings, experience, and the addresses of the order of samples.
#[derive(Clone, Copy)]
pub struct Job<'a> {
    pub spec: &'a PpoSpec,
    pub rollout: &'a Rollout,
    pub collective: &'a dyn Collective,
    pub seed: u64,
    pub iteration: u64,
}

/// Result of the epochs of the policy.
pub struct PolicyReport {
    pub objective: f64,
    pub divergence: f64,
    pub gradient_norm: f64,
    pub learning_rate: f64,
    pub skipped: u64,
}

impl Job<'_> {
    /// The epochs of the policy.
    pub fn improve_policy(
        &self,
        actor: &mut Actor,
        adam: &mut Adam,
        memory: &mut Vec<Channel>,
        mut learning_rate: f64,
        advantages: &[f32],
    ) -> PolicyReport {
        let spec = self.spec;
        let mut policy = LearningPolicy::new(actor, adam, memory);
        let samples = advantages.len();
        let probe: Vec<usize> = (0..samples).step_by(samples.div_ceil(DIVERGENCE_ROWS)).collect();
        let mut report =
            PolicyReport { objective: 0.0, divergence: 0.0, gradient_norm: 0.0, learning_rate, skipped: 0 };
        let mut batches = 0.0;
        for epoch in 0..spec.epochs {
            for batch in self.order(epoch).chunks(spec.minibatch) {
                let step = policy.step(self, batch, advantages, learning_rate);
                report.objective += step.objective;
                batches += 1.0;
                match step.norm {
                    Some(norm) => report.gradient_norm += norm,
                    None => report.skipped += 1,
                }
            }
            report.divergence = self.collective.mean(self.measure(&policy, &probe));
            // A teacher is right however far the policy moves: no trust region.
            if self.rollout.is_taught() {
                continue;
            }
            let last = epoch + 1 == spec.epochs;
            if report.divergence > 2.0 * spec.target_divergence {
                learning_rate = (learning_rate / 1.5).max(spec.learning_rate_bounds[0]);
            } else if last && report.divergence < 0.5 * spec.target_divergence {
                learning_rate = (learning_rate * 1.5).min(spec.learning_rate_bounds[1]);
            }
            if report.divergence > STOP * spec.target_divergence {
                break;
            }
        }
        report.objective = self.collective.mean(report.objective / batches);
        report.gradient_norm /= batches;
        report.learning_rate = learning_rate;
        report
    }

    /// KL(old ‖ new) on some rows of the rollout.
    fn measure(&self, policy: &LearningPolicy<'_>, probe: &[usize]) -> f64 {
        let rollout = self.rollout;
        let (joints, width) = (rollout.log_std.len(), rollout.actor_rows.len() / rollout.len());
        let means = policy.means(&gather(&rollout.actor_rows, width, probe));
        let old_means = gather(&rollout.means, joints, probe);
        let divergences = divergence((&old_means, &rollout.log_std), (&means, policy.log_std()));
        divergences.iter().sum::<f64>() / divergences.len().max(1) as f64
    }

    /// The epochs of the value function: its mean loss, and the steps that were left out.
    pub fn fit_value(
        &self,
        critic: &mut Critic,
        adam: &mut Adam,
        memory: &mut Vec<Channel>,
        targets: &[f32],
    ) -> (f64, u64) {
        let spec = self.spec;
        let mut value = LearningValue::new(critic, adam, memory);
        let (mut sum, mut batches, mut skipped) = (0.0, 0.0, 0);
        for epoch in 0..spec.epochs {
            for batch in self.order(epoch).chunks(spec.minibatch) {
                let step = value.step(self, batch, targets, spec.critic_learning_rate);
                sum += step.objective;
                batches += 1.0;
                skipped += u64::from(step.norm.is_none());
            }
        }
        (self.collective.mean(sum / batches), skipped)
    }

    /// The samples of an epoch in the order in which they are taken.
    fn order(&self, epoch: usize) -> Vec<usize> {
        shuffled(self.rollout.len(), self.seed, self.iteration, epoch)
    }
}

fn shuffled(n: usize, seed: u64, iteration: u64, epoch: usize) -> Vec<usize> {
    let mut order: Vec<usize> = (0..n).collect();
    order.shuffle(&mut stream(seed, "shuffle", epoch as u64, iteration));
    order
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shuffles_are_permutations_addressed_by_iteration_and_epoch() {
        let a = shuffled(100, 1, 2, 3);
        let mut sorted = a.clone();
        sorted.sort_unstable();
        assert_eq!(sorted, (0..100).collect::<Vec<_>>());
        assert_eq!(a, shuffled(100, 1, 2, 3));
        assert_ne!(a, shuffled(100, 1, 2, 4));
        assert_ne!(a, shuffled(100, 1, 3, 3));
    }
}
