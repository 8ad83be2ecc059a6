//! Proximal policy optimization (Schulman et al. 2017), whole: [`Learner::iterate`] is the algorithm.
//!
//! As in the thesis (4.3.1): a Gaussian policy, GAE, the clipped surrogate, a learning rate steered by the KL divergence,
//! a bound on the gradient's norm. Policy and value function share nothing, so they learn on two threads at once.

use std::time::Instant;

use burn::module::Module;
use lifelike_nn::adam::{Adam, AdamConfig};
use lifelike_nn::backprop::{backward, forward};
use lifelike_nn::checkpoint::Checkpoint;
use lifelike_nn::gradients::Gradients;
use lifelike_nn::normalizer::RunningNormalizer;
use lifelike_nn::{device, rng::stream};
use rand::seq::SliceRandom;
use rand_distr::{Distribution, StandardNormal};

use super::environment::{Environment, Outcome};
use super::gae::{Discounts, advantages};
use super::gaussian::{divergence, entropy, log_probability_of_noise};
use super::losses::{squared_error, surrogate};
use super::networks::{Actor, ActorSize, Critic, column, numbers, rows, unreadable};
use super::plan::{PpoSpec, TrackerPlan};
use super::policy::Policy;
use crate::error::LearnError;

/// Rows on which the KL divergence is measured after each epoch.
const DIVERGENCE_ROWS: usize = 2048;
/// An iteration's epochs end early when the divergence exceeds the target this many times.
const STOP: f64 = 4.0;

/// Both networks with everything that learning changes.
pub struct Learner {
    spec: PpoSpec,
    seed: u64,
    actor: Actor,
    critic: Critic,
    actor_adam: Adam,
    critic_adam: Adam,
    rate: f64,
    /// In force during a rollout.
    actor_normalizer: RunningNormalizer,
    critic_normalizer: RunningNormalizer,
}

/// What an iteration gave.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Iteration {
    /// Clipped surrogate objective, mean over the minibatches.
    pub surrogate: f64,
    /// Half the mean squared error of the value function, in its own units.
    pub value_loss: f64,
    /// KL(old ‖ new) after the last epoch.
    pub divergence: f64,
    /// Share of the returns' variance that the value function explains.
    pub explained_variance: f64,
    /// Mean standard deviation of the policy.
    pub std: f64,
    /// Mean entropy of the policy.
    pub entropy: f64,
    /// Mean norm of the policy's gradient before clipping.
    pub gradient_norm: f64,
    /// Learning rate of the next iteration.
    pub rate: f64,
    /// Gradient steps left out because a gradient was not finite.
    pub skipped: u64,
    /// Mean reward per step.
    pub reward: f64,
    /// Wall time spent collecting (s).
    pub collecting: f64,
    /// Of which in the environment (s).
    pub stepping: f64,
    /// Wall time spent learning (s).
    pub learning: f64,
}

/// One rollout, `[steps · environments]` rows, observations normalised.
#[derive(Default)]
struct Rollout {
    actor_rows: Vec<f32>,
    critic_rows: Vec<f32>,
    /// Rows of the value function for states that were reached but left by a cut, with the step they belong to.
    final_rows: Vec<f32>,
    final_steps: Vec<usize>,
    actions: Vec<f32>,
    means: Vec<f32>,
    log_probabilities: Vec<f32>,
    rewards: Vec<f32>,
    terminated: Vec<bool>,
    truncated: Vec<bool>,
}

impl Learner {
    /// Fresh networks for an environment.
    pub fn new(plan: &TrackerPlan, environment: &Environment, joints: usize) -> Self {
        let device = device::inference();
        let (o, p) = (environment.actor_size(), environment.critic_size());
        let size = ActorSize {
            inputs: o,
            window: environment.observation().window_size(),
            encoder: &plan.network.encoder,
            code: plan.network.code,
            hidden: &plan.network.actor,
            outputs: joints,
        };
        let mut learner = Self {
            spec: plan.ppo,
            seed: plan.seed,
            actor: Actor::init(size, plan.ppo.initial_std, plan.seed, &device),
            critic: Critic::init(p, &plan.network.critic, plan.seed, &device),
            actor_adam: Adam::new(AdamConfig::adam()),
            critic_adam: Adam::new(AdamConfig::adam()),
            rate: plan.ppo.learning_rate,
            actor_normalizer: RunningNormalizer::new(o),
            critic_normalizer: RunningNormalizer::new(p),
        };
        // The first rollout needs some scale: that of the states in which episodes begin.
        learner.actor_normalizer.update(environment.actor_rows());
        learner.critic_normalizer.update(environment.critic_rows());
        learner
    }

    /// The policy's network.
    pub fn actor(&self) -> &Actor {
        &self.actor
    }

    /// What the policy's observations are normalised with.
    pub fn normalizer(&self) -> &RunningNormalizer {
        &self.actor_normalizer
    }

    /// One iteration: collect, value, estimate advantages, learn.
    ///
    /// # Errors
    /// The simulation fails as a whole.
    pub fn iterate(&mut self, environment: &mut Environment, iteration: u64) -> Result<Iteration, LearnError> {
        let mut report = Iteration::default();
        let began = Instant::now();
        let log_std = self.actor.log_std()?;
        let rollout = self.collect(environment, iteration, &log_std, &mut report)?;
        let (values, next_values) = self.value(environment, &rollout)?;
        let discounts = Discounts { gamma: self.spec.gamma, lambda: self.spec.lambda };
        let n = environment.len();
        let Rollout { rewards, terminated, truncated, .. } = &rollout;
        let gains = advantages(discounts, n, rewards, &values, &next_values, terminated, truncated);
        let returns: Vec<f32> = gains.iter().zip(&values).map(|(a, v)| a + v).collect();
        report.explained_variance = explained_variance(&returns, &values);
        report.reward = mean(rewards);
        report.collecting = began.elapsed().as_secs_f64();

        let began = Instant::now();
        let gains = standardised(gains);
        let scale = self.value_scale();
        let targets: Vec<f32> = returns.iter().map(|r| r / scale).collect();
        let (spec, seed) = (self.spec, self.seed);
        let order = |epoch: usize| shuffled(rollout.rewards.len(), seed, iteration, epoch);
        let Self { actor, critic, actor_adam, critic_adam, .. } = self;
        let (mut new_actor, mut new_critic) = (actor.clone(), critic.clone());
        let first_rate = self.rate;
        let (policy, value) = rayon::join(
            || improve_policy(&spec, &mut new_actor, actor_adam, first_rate, &rollout, &gains, &log_std, order),
            || fit_value(&spec, &mut new_critic, critic_adam, &rollout, &targets, order),
        );
        let policy = policy?;
        (report.value_loss, report.skipped) = value?;
        (self.actor, self.critic) = (new_actor, new_critic);
        self.rate = policy.rate;
        report.surrogate = policy.surrogate;
        report.divergence = policy.divergence;
        report.gradient_norm = policy.gradient_norm;
        report.rate = policy.rate;
        report.skipped += policy.skipped;
        let log_std = self.actor.log_std()?;
        report.std = log_std.iter().map(|l| f64::from(l.exp())).sum::<f64>() / log_std.len() as f64;
        report.entropy =
            numbers(entropy(column(log_std, &device::inference())))?.first().map_or(0.0, |e| f64::from(*e));
        report.learning = began.elapsed().as_secs_f64();
        Ok(report)
    }

    /// The policy acts. Normalizers stay as they are until the rollout is over, and then take in all that was seen.
    fn collect(
        &mut self,
        environment: &mut Environment,
        iteration: u64,
        log_std: &[f32],
        report: &mut Iteration,
    ) -> Result<Rollout, LearnError> {
        let n = environment.len();
        let std: Vec<f32> = log_std.iter().map(|l| l.exp()).collect();
        let mut streams: Vec<_> = (0..n).map(|i| stream(self.seed, "action", i as u64, iteration)).collect();
        let (mut seen_by_actor, mut seen_by_critic) = (self.actor_normalizer.clone(), self.critic_normalizer.clone());
        let mut rollout = Rollout::default();
        let mut outcome = Outcome::default();
        let mut noise = vec![0.0_f32; n * std.len()];
        for _ in 0..self.spec.steps {
            seen_by_actor.update(environment.actor_rows());
            seen_by_critic.update(environment.critic_rows());
            let mut observations = environment.actor_rows().to_vec();
            self.actor_normalizer.normalize(&mut observations);
            let start = rollout.critic_rows.len();
            rollout.critic_rows.extend_from_slice(environment.critic_rows());
            self.critic_normalizer.normalize(&mut rollout.critic_rows[start..]);
            rollout.actor_rows.extend_from_slice(&observations);
            let means = self.actor.means(observations)?;
            for (stream, noise) in streams.iter_mut().zip(noise.chunks_exact_mut(std.len())) {
                noise.iter_mut().for_each(|z| *z = StandardNormal.sample(stream));
                rollout.log_probabilities.push(log_probability_of_noise(noise, log_std));
            }
            let spread = std.iter().cycle();
            let actions: Vec<f32> = means.iter().zip(&noise).zip(spread).map(|((m, z), s)| m + z * s).collect();
            let stepping = Instant::now();
            environment.step(&actions, &mut outcome)?;
            report.stepping += stepping.elapsed().as_secs_f64();
            let first = rollout.rewards.len();
            rollout
                .final_steps
                .extend(outcome.truncated.iter().enumerate().filter(|(_, t)| **t).map(|(i, _)| first + i));
            let start = rollout.final_rows.len();
            rollout.final_rows.extend_from_slice(&outcome.final_critic_rows);
            self.critic_normalizer.normalize(&mut rollout.final_rows[start..]);
            rollout.means.extend(means);
            rollout.actions.extend(actions);
            rollout.rewards.extend_from_slice(&outcome.rewards);
            rollout.terminated.extend_from_slice(&outcome.terminated);
            rollout.truncated.extend_from_slice(&outcome.truncated);
        }
        // What the last step led to closes the critic's rows.
        let start = rollout.critic_rows.len();
        rollout.critic_rows.extend_from_slice(environment.critic_rows());
        self.critic_normalizer.normalize(&mut rollout.critic_rows[start..]);
        (self.actor_normalizer, self.critic_normalizer) = (seen_by_actor, seen_by_critic);
        Ok(rollout)
    }

    /// V(s_t) and V(s_{t+1}) of every step.
    fn value(&self, environment: &Environment, rollout: &Rollout) -> Result<(Vec<f32>, Vec<f32>), LearnError> {
        let (n, width) = (environment.len(), environment.critic_size());
        let scale = self.value_scale();
        let evaluate = |values: &[f32]| -> Result<Vec<f32>, LearnError> {
            let mut out = Vec::with_capacity(values.len() / width);
            for part in values.chunks(4096 * width) {
                out.extend(self.critic.values(part.to_vec())?);
            }
            out.iter_mut().for_each(|v| *v *= scale);
            Ok(out)
        };
        let mut values = evaluate(&rollout.critic_rows)?;
        let mut next_values = values[n..].to_vec();
        for (step, value) in rollout.final_steps.iter().zip(evaluate(&rollout.final_rows)?) {
            next_values[*step] = value;
        }
        values.truncate(rollout.rewards.len());
        Ok((values, next_values))
    }

    fn value_scale(&self) -> f32 {
        1.0 / (1.0 - self.spec.gamma).max(1e-3)
    }

    /// Takes over the networks of another run, and what their inputs are normalised with.
    ///
    /// # Errors
    /// They are of other sizes.
    pub fn adopt(&mut self, checkpoint: &Checkpoint, prefix: &str) -> Result<(), LearnError> {
        self.actor = checkpoint.load_module(&format!("{prefix}.actor"), self.actor.clone())?;
        self.critic = checkpoint.load_module(&format!("{prefix}.critic"), self.critic.clone())?;
        let normalizer = |name: &str, size| RunningNormalizer::load_from(checkpoint, &format!("{prefix}.{name}"), size);
        self.actor_normalizer = normalizer("actor_normalizer", self.actor_normalizer.size())?;
        self.critic_normalizer = normalizer("critic_normalizer", self.critic_normalizer.size())?;
        Ok(())
    }

    /// Takes over a policy; the value function stays fresh.
    pub fn adopt_policy(&mut self, policy: &Policy) {
        self.actor = policy.actor().clone();
        self.actor_normalizer = policy.normalizer().clone();
        self.actor_normalizer.set_frozen(false);
    }

    /// Writes networks, optimizers, learning rate and normalizers.
    ///
    /// # Errors
    /// The device does not hand out its numbers.
    pub fn save_into(&self, checkpoint: &mut Checkpoint, prefix: &str) -> Result<(), LearnError> {
        checkpoint.put_module(&format!("{prefix}.actor"), &self.actor)?;
        checkpoint.put_module(&format!("{prefix}.critic"), &self.critic)?;
        self.actor_adam.save_into(checkpoint, &format!("{prefix}.actor_adam"))?;
        self.critic_adam.save_into(checkpoint, &format!("{prefix}.critic_adam"))?;
        self.actor_normalizer.save_into(checkpoint, &format!("{prefix}.actor_normalizer"))?;
        self.critic_normalizer.save_into(checkpoint, &format!("{prefix}.critic_normalizer"))?;
        checkpoint.put_f64(&format!("{prefix}.rate"), &[1], vec![self.rate])?;
        Ok(())
    }

    /// Goes on from a checkpoint.
    ///
    /// # Errors
    /// The checkpoint is of networks of other sizes.
    pub fn load(&mut self, checkpoint: &Checkpoint, prefix: &str) -> Result<(), LearnError> {
        self.adopt(checkpoint, prefix)?;
        let adam = AdamConfig::adam();
        self.actor_adam = Adam::load_from(adam, checkpoint, &format!("{prefix}.actor_adam"), &self.actor)?;
        self.critic_adam = Adam::load_from(adam, checkpoint, &format!("{prefix}.critic_adam"), &self.critic)?;
        self.rate = checkpoint.f64s(&format!("{prefix}.rate"), &[1])?[0];
        Ok(())
    }
}

/// What improving the policy gave.
struct PolicyReport {
    surrogate: f64,
    divergence: f64,
    gradient_norm: f64,
    rate: f64,
    skipped: u64,
}

/// The epochs of the policy.
#[allow(clippy::too_many_arguments)]
fn improve_policy(
    spec: &PpoSpec,
    actor: &mut Actor,
    adam: &mut Adam,
    mut rate: f64,
    rollout: &Rollout,
    gains: &[f32],
    old_log_std: &[f32],
    order: impl Fn(usize) -> Vec<usize>,
) -> Result<PolicyReport, LearnError> {
    let device = device::inference();
    let samples = gains.len();
    let (width, joints) = (rollout.actor_rows.len() / samples, old_log_std.len());
    let probe: Vec<usize> = (0..samples).step_by(samples.div_ceil(DIVERGENCE_ROWS)).collect();
    let mut report = PolicyReport { surrogate: 0.0, divergence: 0.0, gradient_norm: 0.0, rate, skipped: 0 };
    let mut batches = 0.0;
    for epoch in 0..spec.epochs {
        for batch in order(epoch).chunks(spec.minibatch) {
            let (means, pass) = actor.forward(gather(&rollout.actor_rows, width, batch))?;
            let mut objective = surrogate(
                &means,
                &actor.log_std()?,
                &gather(&rollout.actions, joints, batch),
                &gather(&rollout.log_probabilities, 1, batch),
                &gather(gains, 1, batch),
                spec.clip as f32,
            );
            // The entropy of a Gaussian grows by one with each log standard deviation.
            objective.by_log_std.iter_mut().for_each(|slope| *slope -= spec.entropy as f32);
            let mut gradients = actor.backward(pass, objective.by_mean)?;
            gradients.insert("log_std".into(), column(objective.by_log_std, &device));
            report.surrogate += objective.value;
            batches += 1.0;
            match descend(spec, actor, adam, gradients, rate) {
                Some(norm) => report.gradient_norm += norm,
                None => report.skipped += 1,
            }
            *actor = actor.clone().bounded(spec.std_bounds);
        }
        report.divergence = measure(actor, rollout, &probe, width, old_log_std)?;
        let last = epoch + 1 == spec.epochs;
        if report.divergence > 2.0 * spec.target_divergence {
            rate = (rate / 1.5).max(spec.learning_rate_bounds[0]);
        } else if last && report.divergence < 0.5 * spec.target_divergence {
            rate = (rate * 1.5).min(spec.learning_rate_bounds[1]);
        }
        if report.divergence > STOP * spec.target_divergence {
            break;
        }
    }
    report.surrogate /= batches;
    report.gradient_norm /= batches;
    report.rate = rate;
    Ok(report)
}

/// KL(old ‖ new) on some rows of the rollout.
fn measure(
    actor: &Actor,
    rollout: &Rollout,
    probe: &[usize],
    width: usize,
    old_log_std: &[f32],
) -> Result<f64, LearnError> {
    let device = device::inference();
    let joints = old_log_std.len();
    let means = rows(actor.means(gather(&rollout.actor_rows, width, probe))?, joints, &device);
    let old_means = rows(gather(&rollout.means, joints, probe), joints, &device);
    let old_log_std = column(old_log_std.to_vec(), &device);
    let divergence = divergence(old_means, old_log_std, means, column(actor.log_std()?, &device));
    Ok(mean(&numbers(divergence)?))
}

/// The epochs of the value function: its mean loss, and the steps that were left out.
fn fit_value(
    spec: &PpoSpec,
    critic: &mut Critic,
    adam: &mut Adam,
    rollout: &Rollout,
    targets: &[f32],
    order: impl Fn(usize) -> Vec<usize>,
) -> Result<(f64, u64), LearnError> {
    let device = device::inference();
    let width = rollout.critic_rows.len() / (targets.len() + targets.len() / spec.steps);
    let (mut sum, mut batches, mut skipped) = (0.0, 0.0, 0);
    for epoch in 0..spec.epochs {
        for batch in order(epoch).chunks(spec.minibatch) {
            let (values, pass) =
                forward(critic.network(), gather(&rollout.critic_rows, width, batch), &device).map_err(unreadable)?;
            let (loss, slope) = squared_error(&values, &gather(targets, 1, batch));
            let gradients = backward(critic.network(), pass, slope, "value", &device).map_err(unreadable)?;
            sum += loss;
            batches += 1.0;
            if descend(spec, critic, adam, gradients, spec.critic_learning_rate).is_none() {
                skipped += 1;
            }
        }
    }
    Ok((sum / batches, skipped))
}

/// One gradient step; the norm of the gradient, or `None` when it was not finite and nothing was changed.
fn descend<M: Module>(
    spec: &PpoSpec,
    module: &mut M,
    adam: &mut Adam,
    mut gradients: Gradients,
    rate: f64,
) -> Option<f64> {
    let norm = gradients.clip_norm(spec.gradient_norm);
    if !norm.is_finite() {
        return None;
    }
    *module = adam.step(module.clone(), gradients, rate);
    Some(norm)
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

fn mean(values: &[f32]) -> f64 {
    values.iter().map(|x| f64::from(*x)).sum::<f64>() / values.len() as f64
}

fn variance(values: impl Iterator<Item = f64> + Clone) -> f64 {
    let n = values.clone().count() as f64;
    let mean = values.clone().sum::<f64>() / n;
    values.map(|x| (x - mean).powi(2)).sum::<f64>() / n
}

/// Mean zero, deviation one.
fn standardised(mut values: Vec<f32>) -> Vec<f32> {
    let centre = mean(&values) as f32;
    let deviation = variance(values.iter().map(|x| f64::from(*x))).sqrt() as f32 + 1e-8;
    values.iter_mut().for_each(|x| *x = (*x - centre) / deviation);
    values
}

/// 1 − Var(returns − values) / Var(returns).
fn explained_variance(returns: &[f32], values: &[f32]) -> f64 {
    let left = variance(returns.iter().zip(values).map(|(r, v)| f64::from(r - v)));
    1.0 - left / variance(returns.iter().map(|r| f64::from(*r))).max(1e-12)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn explained_variance_is_one_for_the_truth_and_zero_for_a_constant() {
        let returns = [1.0, 2.0, 4.0];
        assert_eq!(explained_variance(&returns, &returns), 1.0);
        assert!(explained_variance(&returns, &[7.0; 3]).abs() < 1e-12);
        assert!(explained_variance(&returns, &[4.0, 2.0, 1.0]) < -1.0);
    }

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

    #[test]
    fn standardised_values_have_mean_zero_and_deviation_one() {
        let x = standardised(vec![1.0, 2.0, 3.0, 6.0]);
        assert!(mean(&x).abs() < 1e-6 && (variance(x.iter().map(|x| f64::from(*x))) - 1.0).abs() < 1e-5);
    }
}
