//! The gradient steps: epochs of minibatches over one rollout, for the policy and for the value function.

use burn::module::Module;
use lifelike_checkpoint::rng::stream;
use lifelike_nn::adam::Adam;
use lifelike_nn::backprop::{backward, forward};
use lifelike_nn::device;
use lifelike_nn::gradients::Gradients;
use lifelike_nn::numbers::read;
use rand::seq::SliceRandom;

use super::config::PpoSpec;
use super::rollout::Rollout;
use super::statistics::mean;
use crate::TrainError;
use crate::collective::Collective;
use crate::gaussian::divergence;
use crate::losses::{squared_error, surrogate};
use crate::networks::{Actor, Critic, column, rows};

/// Rows on which the KL divergence is measured after each epoch.
const DIVERGENCE_ROWS: usize = 2048;
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
    pub surrogate: f64,
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
        mut learning_rate: f64,
        advantages: &[f32],
    ) -> Result<PolicyReport, TrainError> {
        let (spec, rollout, device) = (self.spec, self.rollout, actor.device());
        let samples = advantages.len();
        let (width, joints) = (rollout.actor_rows.len() / samples, rollout.log_std.len());
        let probe: Vec<usize> = (0..samples).step_by(samples.div_ceil(DIVERGENCE_ROWS)).collect();
        let mut report =
            PolicyReport { surrogate: 0.0, divergence: 0.0, gradient_norm: 0.0, learning_rate, skipped: 0 };
        let mut batches = 0.0;
        for epoch in 0..spec.epochs {
            for batch in self.order(epoch).chunks(spec.minibatch) {
                let (means, pass) = actor.forward(gather(&rollout.actor_rows, width, batch))?;
                let mut objective = surrogate(
                    &means,
                    &actor.log_std()?,
                    &gather(&rollout.actions, joints, batch),
                    &gather(&rollout.log_probabilities, 1, batch),
                    &gather(advantages, 1, batch),
                    spec.clip as f32,
                );
                // The entropy of a Gaussian grows by one with each log standard deviation.
                objective.by_log_std.iter_mut().for_each(|gradient| *gradient -= spec.entropy as f32);
                let mut gradients = actor.backward(pass, objective.by_mean)?;
                gradients.insert("log_std".into(), column(objective.by_log_std, &device));
                report.surrogate += objective.value;
                batches += 1.0;
                match self.descend(actor, adam, gradients, learning_rate)? {
                    Some(norm) => report.gradient_norm += norm,
                    None => report.skipped += 1,
                }
                *actor = actor.clone().bounded(spec.std_bounds);
            }
            report.divergence = self.collective.mean(self.measure(actor, &probe, width)?);
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
        report.surrogate = self.collective.mean(report.surrogate / batches);
        report.gradient_norm /= batches;
        report.learning_rate = learning_rate;
        Ok(report)
    }

    /// KL(old ‖ new) on some rows of the rollout.
    fn measure(&self, actor: &Actor, probe: &[usize], width: usize) -> Result<f64, TrainError> {
        let (rollout, device) = (self.rollout, device::inference());
        let joints = rollout.log_std.len();
        let means = rows(actor.means(gather(&rollout.actor_rows, width, probe))?, joints, &device);
        let old_means = rows(gather(&rollout.means, joints, probe), joints, &device);
        let old_log_std = column(rollout.log_std.clone(), &device);
        let divergence = divergence(old_means, old_log_std, means, column(actor.log_std()?, &device));
        Ok(mean(&read(divergence)?))
    }

    /// The epochs of the value function: its mean loss, and the steps that were left out.
    pub fn fit_value(&self, critic: &mut Critic, adam: &mut Adam, targets: &[f32]) -> Result<(f64, u64), TrainError> {
        let spec = self.spec;
        let width = self.rollout.critic_width();
        let (mut sum, mut batches, mut skipped) = (0.0, 0.0, 0);
        for epoch in 0..spec.epochs {
            for batch in self.order(epoch).chunks(spec.minibatch) {
                let rows = gather(&self.rollout.critic_rows, width, batch);
                let (values, pass) = forward(critic.network(), rows)?;
                let (loss, gradient) = squared_error(&values, &gather(targets, 1, batch));
                let gradients = backward(critic.network(), pass, gradient, "value")?;
                sum += loss;
                batches += 1.0;
                if self.descend(critic, adam, gradients, spec.critic_learning_rate)?.is_none() {
                    skipped += 1;
                }
            }
        }
        Ok((self.collective.mean(sum / batches), skipped))
    }

    /// One gradient step; the norm of the gradient, or `None` when it was not finite and nothing was changed.
    fn descend<M: Module>(
        &self,
        module: &mut M,
        adam: &mut Adam,
        mut gradients: Gradients,
        learning_rate: f64,
    ) -> Result<Option<f64>, TrainError> {
        let processes = self.collective.size();
        if processes > 1 {
            let share = 1.0 / processes as f32;
            gradients.rewrite(|values| {
                self.collective.sum(values);
                values.iter_mut().for_each(|x| *x *= share);
            })?;
        }
        let norm = gradients.clip_norm(self.spec.gradient_norm)?;
        if !norm.is_finite() {
            return Ok(None);
        }
        *module = adam.step(module.clone(), gradients, learning_rate);
        Ok(Some(norm))
    }

    /// The samples of an epoch in the order in which they are taken.
    fn order(&self, epoch: usize) -> Vec<usize> {
        shuffled(self.rollout.len(), self.seed, self.iteration, epoch)
    }
}

/// The rows of a minibatch.
fn gather(values: &[f32], width: usize, batch: &[usize]) -> Vec<f32> {
    let mut out = Vec::with_capacity(batch.len() * width);
    for i in batch {
        out.extend_from_slice(&values[i * width..(i + 1) * width]);
    }
    out
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
