//! Proximal policy optimization (Schulman et al. 2017), whole: [`Learner::iterate`] is the algorithm.
//!
//! As in the thesis (4.3.1): a Gaussian policy, GAE, the clipped surrogate, a learning rate controlled by the KL
//! divergence, a bound on the gradient's norm. Policy and value function share no parameters, so they learn on two
//! threads at once.
//!
//! If the environment has a teacher, the policy imitates it instead (DAgger); the value function learns as usual.
//!
//! With `ppo.overlap` the next rollout is collected during the update. The acting policy is one update behind, which
//! the surrogate's ratio accounts for. The numbers do not depend on which of the two is faster.

mod adopt;
mod average;
mod config;
mod improve;
mod rollout;
mod statistics;
mod steps;

use std::sync::Arc;
use std::time::Instant;

use lifelike_checkpoint::Checkpoint;
use lifelike_dense::Channel;
use lifelike_nn::adam::{Adam, AdamConfig};
use lifelike_nn::normalizer::RunningNormalizer;

pub use self::adopt::{Inputs, SavedNetworks};
use self::average::PolicyAverage;
pub use self::config::{NetworkSpec, PpoSpec};
use self::improve::Job;
use self::rollout::{ObservationStatistics, Rollout, RolloutCollector};
use self::statistics::{explained_variance, mean, standardised};
use crate::TrainError;
use crate::collective::Collective;
use crate::environment::VectorEnvironment;
use crate::gae::{Discounts, advantages};
use crate::gaussian::entropy;
use crate::networks::{Actor, Critic};

/// Both networks with everything that learning changes.
pub struct Learner {
    spec: PpoSpec,
    seed: u64,
    collective: Arc<dyn Collective>,
    actor: Actor,
    critic: Critic,
    actor_adam: Adam,
    critic_adam: Adam,
    learning_rate: f64,
    /// In force during a rollout.
    actor_normalizer: RunningNormalizer,
    critic_normalizer: RunningNormalizer,
    average: PolicyAverage,
    /// Collected and not yet learned from, and its iteration.
    pending: Option<(Rollout, u64)>,
    /// For the passes of policy and value function, kept from iteration to iteration.
    memory: [Vec<Channel>; 2],
}

/// Results of one iteration.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Iteration {
    /// Clipped surrogate objective, mean over the minibatches; 0 with a teacher.
    pub surrogate: f64,
    /// KL(teacher ‖ policy), mean over the minibatches; `None` without a teacher.
    pub imitation: Option<f64>,
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
    pub learning_rate: f64,
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
    /// Creates networks for environments.
    pub fn new<E: VectorEnvironment>(
        spec: &PpoSpec,
        network: &NetworkSpec,
        seed: u64,
        environment: &E,
        collective: Arc<dyn Collective>,
    ) -> Self {
        let (o, p) = (environment.observation_size(), environment.critic_observation_size());
        let actor = Actor::init(network.actor_of(environment), spec.initial_std, seed);
        let critic = Critic::init(p, &network.critic, seed);
        let mut learner = Self {
            spec: *spec,
            seed,
            collective,
            average: PolicyAverage::new(&actor),
            actor_adam: Adam::new(AdamConfig::adam(), actor.parameters().len()),
            critic_adam: Adam::new(AdamConfig::adam(), critic.parameters().len()),
            actor,
            critic,
            learning_rate: spec.learning_rate,
            actor_normalizer: RunningNormalizer::new(o),
            critic_normalizer: RunningNormalizer::new(p),
            pending: None,
            memory: Default::default(),
        };
        // The first rollout needs some scale: that of the states in which episodes begin.
        let (mut actor, mut critic) = (RunningNormalizer::new(o), RunningNormalizer::new(p));
        actor.update(environment.observations());
        critic.update(environment.critic_observations());
        learner.remember(&ObservationStatistics { actor, critic, stepping: 0.0 });
        learner
    }

    /// Returns the policy's network, its parameters averaged over the last part of the training (`ppo.averaging`).
    pub fn actor(&self) -> &Actor {
        self.average.actor()
    }

    /// Returns the normalizer of the policy's observations.
    pub fn normalizer(&self) -> &RunningNormalizer {
        &self.actor_normalizer
    }

    /// Returns the value function's network, and the normalizer of its observations.
    pub fn value_function(&self) -> (&Critic, &RunningNormalizer) {
        (&self.critic, &self.critic_normalizer)
    }

    /// Takes one iteration: collect, value, estimate advantages, learn.
    ///
    /// # Errors
    /// The environments fail as a whole.
    pub fn iterate<E: VectorEnvironment>(
        &mut self,
        environment: &mut E,
        iteration: u64,
    ) -> Result<Iteration, E::Error> {
        let mut report = Iteration::default();
        let collector = RolloutCollector {
            actor: self.actor.clone(),
            actor_normalizer: self.actor_normalizer.clone(),
            critic_normalizer: self.critic_normalizer.clone(),
            seed: self.seed,
            steps: self.spec.steps,
        };
        let collect = |environment: &mut E| {
            let began = Instant::now();
            let collected = collector.collect(environment, iteration);
            collected.map(|(rollout, seen)| (rollout, seen, began.elapsed().as_secs_f64()))
        };
        let (rollout, seen, seconds) = if self.spec.overlap {
            let pending = self.pending.take();
            let learn = || {
                if let Some((rollout, of)) = pending {
                    self.learn(&rollout, of, &mut report);
                }
            };
            let (collected, ()) = rayon::join(|| collect(environment), learn);
            collected?
        } else {
            let collected = collect(environment)?;
            self.learn(&collected.0, iteration, &mut report);
            collected
        };
        self.remember(&seen);
        report.reward = mean(&rollout.rewards);
        (report.collecting, report.stepping) = (seconds, seen.stepping);
        if self.spec.overlap {
            self.pending = Some((rollout, iteration));
        }
        let log_std = self.actor.log_std();
        report.learning_rate = self.learning_rate;
        report.std = log_std.iter().map(|l| f64::from(l.exp())).sum::<f64>() / log_std.len() as f64;
        report.entropy = entropy(log_std);
        Ok(report)
    }

    /// Takes the observations of all processes into the normalizers.
    fn remember(&mut self, seen: &ObservationStatistics) {
        for (normalizer, seen) in
            [(&mut self.actor_normalizer, &seen.actor), (&mut self.critic_normalizer, &seen.critic)]
        {
            let mut moments = seen.moments();
            self.collective.sum_wide(&mut moments);
            normalizer.merge(&moments);
        }
    }

    /// Values, advantages, and the gradient steps.
    fn learn(&mut self, rollout: &Rollout, iteration: u64, report: &mut Iteration) {
        let began = Instant::now();
        let (values, next_values) = self.value(rollout);
        let discounts = Discounts { gamma: self.spec.gamma, lambda: self.spec.lambda };
        let Rollout { rewards, terminated, truncated, .. } = rollout;
        let advantages =
            advantages(discounts, rollout.environments, rewards, &values, &next_values, terminated, truncated);
        let returns: Vec<f32> = advantages.iter().zip(&values).map(|(a, v)| a + v).collect();
        report.explained_variance = explained_variance(&returns, &values);
        let advantages = standardised(advantages, self.collective.as_ref());
        let scale = self.value_scale();
        let targets: Vec<f32> = returns.iter().map(|r| r / scale).collect();
        let Self { spec, seed, collective, actor, critic, actor_adam, critic_adam, memory, .. } = self;
        let [of_actor, of_critic] = memory;
        let (seed, learning_rate) = (*seed, self.learning_rate);
        let job = Job { spec, rollout, collective: collective.as_ref(), seed, iteration };
        let improve = || job.improve_policy(actor, actor_adam, of_actor, learning_rate, &advantages);
        let fit = || job.fit_value(critic, critic_adam, of_critic, &targets);
        // Processes must add up the same things in the same order: not on two threads.
        let (policy, value) = if job.collective.size() > 1 {
            let (mut improve, mut fit) = (improve, fit);
            (improve(), fit())
        } else {
            rayon::join(improve, fit)
        };
        (report.value_loss, report.skipped) = value;
        self.learning_rate = policy.learning_rate;
        if rollout.is_taught() {
            report.imitation = Some(-policy.objective);
        } else {
            report.surrogate = policy.objective;
        }
        report.divergence = policy.divergence;
        report.gradient_norm = policy.gradient_norm;
        report.skipped += policy.skipped;
        self.average.follow(&self.actor, self.spec.averaging);
        report.learning = began.elapsed().as_secs_f64();
    }

    /// V(s_t) and V(s_{t+1}) of every step.
    fn value(&self, rollout: &Rollout) -> (Vec<f32>, Vec<f32>) {
        let (n, scale, critic) = (rollout.environments, self.value_scale(), self.critic.kernels());
        let evaluate = |rows: &[f32]| -> Vec<f32> {
            let mut out = critic.values(rows);
            out.iter_mut().for_each(|v| *v *= scale);
            out
        };
        let mut values = evaluate(&rollout.critic_rows);
        let mut next_values = values[n..].to_vec();
        for (step, value) in rollout.final_steps.iter().zip(evaluate(&rollout.final_rows)) {
            next_values[*step] = value;
        }
        values.truncate(rollout.len());
        (values, next_values)
    }

    fn value_scale(&self) -> f32 {
        1.0 / (1.0 - self.spec.gamma).max(1e-3)
    }

    /// Writes networks, optimizers, learning rate and normalizers.
    ///
    /// # Errors
    /// Two entries of one name.
    pub fn save_into(&self, checkpoint: &mut Checkpoint, prefix: &str) -> Result<(), TrainError> {
        self.actor.parameters().save_into(checkpoint, &format!("{prefix}.actor"))?;
        self.average.save_into(checkpoint, &average::of_run(prefix))?;
        self.critic.parameters().save_into(checkpoint, &format!("{prefix}.critic"))?;
        self.actor_adam.save_into(self.actor.parameters().layout(), checkpoint, &format!("{prefix}.actor_adam"))?;
        self.critic_adam.save_into(self.critic.parameters().layout(), checkpoint, &format!("{prefix}.critic_adam"))?;
        self.actor_normalizer.save_into(checkpoint, &format!("{prefix}.actor_normalizer"))?;
        self.critic_normalizer.save_into(checkpoint, &format!("{prefix}.critic_normalizer"))?;
        checkpoint.put_f64(&format!("{prefix}.rate"), &[1], vec![self.learning_rate])?;
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
    pub fn load(&mut self, checkpoint: &Checkpoint, prefix: &str) -> Result<(), TrainError> {
        let names = SavedNetworks::of_run(checkpoint, prefix);
        self.actor = self.actor.load_from(checkpoint, &format!("{prefix}.actor"))?;
        self.average = PolicyAverage::load(checkpoint, &average::of_run(prefix), &self.actor)?;
        self.critic = self.critic.load_from(checkpoint, &names.critic)?;
        let normalizer = |name: &str, size| RunningNormalizer::load_from(checkpoint, name, size);
        self.actor_normalizer = normalizer(&names.actor_normalizer, self.actor_normalizer.size())?;
        self.critic_normalizer = normalizer(&names.critic_normalizer, self.critic_normalizer.size())?;
        let adam = AdamConfig::adam();
        self.actor_adam =
            Adam::load_from(adam, self.actor.parameters().layout(), checkpoint, &format!("{prefix}.actor_adam"))?;
        self.critic_adam =
            Adam::load_from(adam, self.critic.parameters().layout(), checkpoint, &format!("{prefix}.critic_adam"))?;
        self.learning_rate = checkpoint.f64s(&format!("{prefix}.rate"), &[1])?[0];
        let pending = Rollout::load(checkpoint, &format!("{prefix}.pending"))?;
        let iteration = || checkpoint.u64s(&format!("{prefix}.pending_iteration"), &[1]);
        self.pending = pending.map(|rollout| Ok::<_, TrainError>((rollout, iteration()?[0]))).transpose()?;
        Ok(())
    }
}
