//! Proximal policy optimization (Schulman et al. 2017), whole: [`Learner::iterate`] is the algorithm.
//!
//! As in the thesis (4.3.1): a Gaussian policy, GAE, the clipped surrogate, a learning rate steered by the KL divergence,
//! a bound on the gradient's norm. Policy and value function share nothing, so they learn on two threads at once.
//!
//! With `ppo.overlap` the next rollout is collected while the last one is learned from: what acts is one update behind, which
//! the surrogate's ratio accounts for, and the numbers do not depend on which of the two is faster.

mod improve;
mod rollout;
mod statistics;

use std::sync::Arc;
use std::time::Instant;

use burn::module::Module;
use burn::tensor::Device;
use lifelike_checkpoint::Checkpoint;
use lifelike_nn::ModuleCheckpoint;
use lifelike_nn::adam::{Adam, AdamConfig};
use lifelike_nn::device;
use lifelike_nn::normalizer::RunningNormalizer;
use lifelike_nn::numbers::read;

use self::improve::Job;
use self::rollout::{Acting, Rollout, Seen};
use self::statistics::{explained_variance, mean, standardised};
use super::environment::Environment;
use super::plan::{PpoSpec, TrackerPlan};
use super::policy::Policy;
use crate::TrackerError;
use lifelike_train::collective::Collective;
use lifelike_train::gae::{Discounts, advantages};
use lifelike_train::gaussian::entropy;
use lifelike_train::networks::{Actor, ActorSize, Critic, column};

/// Both networks with everything that learning changes.
pub struct Learner {
    spec: PpoSpec,
    seed: u64,
    all: Arc<dyn Collective>,
    actor: Actor,
    critic: Critic,
    actor_adam: Adam,
    critic_adam: Adam,
    rate: f64,
    /// In force during a rollout.
    actor_normalizer: RunningNormalizer,
    critic_normalizer: RunningNormalizer,
    /// Collected and not yet learned from, and its iteration.
    pending: Option<(Rollout, u64)>,
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

impl Learner {
    /// Fresh networks for an environment.
    pub fn new(plan: &TrackerPlan, environment: &Environment, joints: usize, all: Arc<dyn Collective>) -> Self {
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
            all,
            actor: Actor::init(size, plan.ppo.initial_std, plan.seed, &device),
            critic: Critic::init(p, &plan.network.critic, plan.seed, &device),
            actor_adam: Adam::new(AdamConfig::adam()),
            critic_adam: Adam::new(AdamConfig::adam()),
            rate: plan.ppo.learning_rate,
            actor_normalizer: RunningNormalizer::new(o),
            critic_normalizer: RunningNormalizer::new(p),
            pending: None,
        };
        // The first rollout needs some scale: that of the states in which episodes begin.
        let (mut actor, mut critic) = (RunningNormalizer::new(o), RunningNormalizer::new(p));
        actor.update(environment.actor_rows());
        critic.update(environment.critic_rows());
        learner.remember(&Seen { actor, critic, stepping: 0.0 });
        learner
    }

    /// With networks and optimizers on another device. Physics, rollouts and losses stay where they are.
    #[must_use]
    pub fn to_device(mut self, device: &Device) -> Self {
        (self.actor, self.critic) = (self.actor.fork(device), self.critic.fork(device));
        self.actor_adam = self.actor_adam.to_device(device);
        self.critic_adam = self.critic_adam.to_device(device);
        self
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
    pub fn iterate(&mut self, environment: &mut Environment, iteration: u64) -> Result<Iteration, TrackerError> {
        let mut report = Iteration::default();
        let acting = Acting {
            actor: self.actor.clone(),
            actor_normalizer: self.actor_normalizer.clone(),
            critic_normalizer: self.critic_normalizer.clone(),
            seed: self.seed,
            steps: self.spec.steps,
        };
        let collect = |environment: &mut Environment| {
            let began = Instant::now();
            let collected = acting.collect(environment, iteration);
            collected.map(|(rollout, seen)| (rollout, seen, began.elapsed().as_secs_f64()))
        };
        let (rollout, seen, seconds) = if self.spec.overlap {
            let pending = self.pending.take();
            let (collected, learned) = rayon::join(
                || collect(environment),
                || pending.map_or(Ok(()), |(rollout, of)| self.learn(&rollout, of, &mut report)),
            );
            learned?;
            collected?
        } else {
            let collected = collect(environment)?;
            self.learn(&collected.0, iteration, &mut report)?;
            collected
        };
        self.remember(&seen);
        report.reward = mean(&rollout.rewards);
        (report.collecting, report.stepping) = (seconds, seen.stepping);
        if self.spec.overlap {
            self.pending = Some((rollout, iteration));
        }
        let log_std = self.actor.log_std()?;
        report.rate = self.rate;
        report.std = log_std.iter().map(|l| f64::from(l.exp())).sum::<f64>() / log_std.len() as f64;
        report.entropy = read(entropy(column(log_std, &device::inference())))?.first().map_or(0.0, |e| f64::from(*e));
        Ok(report)
    }

    /// Takes what was seen, in all processes, into the normalizers.
    fn remember(&mut self, seen: &Seen) {
        for (normalizer, seen) in
            [(&mut self.actor_normalizer, &seen.actor), (&mut self.critic_normalizer, &seen.critic)]
        {
            let mut moments = seen.moments();
            self.all.sum_wide(&mut moments);
            normalizer.merge(&moments);
        }
    }

    /// Values, advantages, and the gradient steps.
    fn learn(&mut self, rollout: &Rollout, iteration: u64, report: &mut Iteration) -> Result<(), TrackerError> {
        let began = Instant::now();
        let (values, next_values) = self.value(rollout)?;
        let discounts = Discounts { gamma: self.spec.gamma, lambda: self.spec.lambda };
        let Rollout { rewards, terminated, truncated, .. } = rollout;
        let gains = advantages(discounts, rollout.environments, rewards, &values, &next_values, terminated, truncated);
        let returns: Vec<f32> = gains.iter().zip(&values).map(|(a, v)| a + v).collect();
        report.explained_variance = explained_variance(&returns, &values);
        let gains = standardised(gains, self.all.as_ref());
        let scale = self.value_scale();
        let targets: Vec<f32> = returns.iter().map(|r| r / scale).collect();
        let Self { spec, seed, all, actor, critic, actor_adam, critic_adam, .. } = self;
        let (seed, rate) = (*seed, self.rate);
        let job = Job { spec, rollout, all: all.as_ref(), seed, iteration };
        let (mut new_actor, mut new_critic) = (actor.clone(), critic.clone());
        let improve = || job.improve_policy(&mut new_actor, actor_adam, rate, &gains);
        let fit = || job.fit_value(&mut new_critic, critic_adam, &targets);
        // Processes must add up the same things in the same order: not on two threads.
        let (policy, value) = if job.all.size() > 1 {
            let (mut improve, mut fit) = (improve, fit);
            (improve(), fit())
        } else {
            rayon::join(improve, fit)
        };
        let policy = policy?;
        (report.value_loss, report.skipped) = value?;
        (self.actor, self.critic, self.rate) = (new_actor, new_critic, policy.rate);
        report.surrogate = policy.surrogate;
        report.divergence = policy.divergence;
        report.gradient_norm = policy.gradient_norm;
        report.skipped += policy.skipped;
        report.learning = began.elapsed().as_secs_f64();
        Ok(())
    }

    /// V(s_t) and V(s_{t+1}) of every step.
    fn value(&self, rollout: &Rollout) -> Result<(Vec<f32>, Vec<f32>), TrackerError> {
        let (n, width) = (rollout.environments, rollout.critic_width());
        let scale = self.value_scale();
        let evaluate = |values: &[f32]| -> Result<Vec<f32>, TrackerError> {
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
        values.truncate(rollout.len());
        Ok((values, next_values))
    }

    fn value_scale(&self) -> f32 {
        1.0 / (1.0 - self.spec.gamma).max(1e-3)
    }

    /// Takes over the networks of another run, and what their inputs are normalised with.
    ///
    /// # Errors
    /// They are of other sizes.
    pub fn adopt(&mut self, checkpoint: &Checkpoint, prefix: &str) -> Result<(), TrackerError> {
        self.actor = checkpoint.load_module(&format!("{prefix}.actor"), self.actor.clone())?;
        self.critic = checkpoint.load_module(&format!("{prefix}.critic"), self.critic.clone())?;
        let normalizer = |name: &str, size| RunningNormalizer::load_from(checkpoint, &format!("{prefix}.{name}"), size);
        self.actor_normalizer = normalizer("actor_normalizer", self.actor_normalizer.size())?;
        self.critic_normalizer = normalizer("critic_normalizer", self.critic_normalizer.size())?;
        Ok(())
    }

    /// Takes over a policy; the value function stays fresh.
    pub fn adopt_policy(&mut self, policy: &Policy) {
        self.actor = policy.actor().clone().fork(&self.actor.device());
        self.actor_normalizer = policy.normalizer().clone();
        self.actor_normalizer.set_frozen(false);
    }

    /// Writes networks, optimizers, learning rate and normalizers.
    ///
    /// # Errors
    /// The device does not hand out its numbers.
    pub fn save_into(&self, checkpoint: &mut Checkpoint, prefix: &str) -> Result<(), TrackerError> {
        checkpoint.put_module(&format!("{prefix}.actor"), &self.actor)?;
        checkpoint.put_module(&format!("{prefix}.critic"), &self.critic)?;
        self.actor_adam.save_into(checkpoint, &format!("{prefix}.actor_adam"))?;
        self.critic_adam.save_into(checkpoint, &format!("{prefix}.critic_adam"))?;
        self.actor_normalizer.save_into(checkpoint, &format!("{prefix}.actor_normalizer"))?;
        self.critic_normalizer.save_into(checkpoint, &format!("{prefix}.critic_normalizer"))?;
        checkpoint.put_f64(&format!("{prefix}.rate"), &[1], vec![self.rate])?;
        match &self.pending {
            Some((rollout, iteration)) => {
                checkpoint.put_u64(&format!("{prefix}.pending_iteration"), &[1], vec![*iteration])?;
                rollout.save_into(checkpoint, &format!("{prefix}.pending"))
            }
            None => Ok(()),
        }
    }

    /// Goes on from a checkpoint.
    ///
    /// # Errors
    /// The checkpoint is of networks of other sizes.
    pub fn load(&mut self, checkpoint: &Checkpoint, prefix: &str) -> Result<(), TrackerError> {
        self.adopt(checkpoint, prefix)?;
        let adam = AdamConfig::adam();
        self.actor_adam = Adam::load_from(adam, checkpoint, &format!("{prefix}.actor_adam"), &self.actor)?;
        self.critic_adam = Adam::load_from(adam, checkpoint, &format!("{prefix}.critic_adam"), &self.critic)?;
        self.rate = checkpoint.f64s(&format!("{prefix}.rate"), &[1])?[0];
        let pending = Rollout::load(checkpoint, &format!("{prefix}.pending"))?;
        let iteration = || checkpoint.u64s(&format!("{prefix}.pending_iteration"), &[1]);
        self.pending = pending.map(|rollout| Ok::<_, TrackerError>((rollout, iteration()?[0]))).transpose()?;
        Ok(())
    }
}
