//! Experience: what the policy did in all environments over some steps.

use std::time::Instant;

use lifelike_checkpoint::Checkpoint;
use lifelike_checkpoint::rng::stream;
use lifelike_nn::normalizer::RunningNormalizer;
use rand_distr::{Distribution, StandardNormal};

use crate::TrainError;
use crate::environment::{StepOutcome, VectorEnvironment};
use crate::gaussian::log_probability_of_noise;
use crate::networks::Actor;

/// One rollout, `[steps · environments]` rows, observations normalised.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Rollout {
    pub environments: usize,
    pub actor_rows: Vec<f32>,
    /// One step more than the others: what the last step led to.
    pub critic_rows: Vec<f32>,
    /// Rows of the value function for states that were reached but left by a cut, with the step they belong to.
    pub final_rows: Vec<f32>,
    pub final_steps: Vec<usize>,
    pub actions: Vec<f32>,
    pub means: Vec<f32>,
    /// Actions of a teacher; empty without one.
    pub taught: Vec<f32>,
    pub log_probabilities: Vec<f32>,
    /// Of the policy that acted, `[J]`.
    pub log_std: Vec<f32>,
    pub rewards: Vec<f32>,
    pub terminated: Vec<bool>,
    pub truncated: Vec<bool>,
}

/// Moments of the observations met while a rollout was collected, and the time that the environments took (s).
pub struct ObservationStatistics {
    pub actor: RunningNormalizer,
    pub critic: RunningNormalizer,
    pub stepping: f64,
}

/// The policy that acts while a rollout is collected; nothing of it changes meanwhile.
#[derive(Debug, Clone)]
pub struct RolloutCollector {
    pub actor: Actor,
    pub actor_normalizer: RunningNormalizer,
    pub critic_normalizer: RunningNormalizer,
    pub seed: u64,
    pub steps: usize,
}

impl RolloutCollector {
    /// Lets the policy act. Normalizers stay as they are; the statistics are for later ones.
    pub fn collect<E: VectorEnvironment>(
        &self,
        environment: &mut E,
        iteration: u64,
    ) -> Result<(Rollout, ObservationStatistics), E::Error> {
        let n = environment.environments();
        let (log_std, policy) = (self.actor.log_std(), self.actor.fixed());
        let std: Vec<f32> = log_std.iter().map(|l| l.exp()).collect();
        let address = |i| environment.address(i);
        let mut streams: Vec<_> = (0..n).map(|i| stream(self.seed, "action", address(i), iteration)).collect();
        let mut seen = ObservationStatistics {
            actor: RunningNormalizer::new(environment.observation_size()),
            critic: RunningNormalizer::new(environment.critic_observation_size()),
            stepping: 0.0,
        };
        let sizes = [environment.observation_size(), environment.critic_observation_size(), std.len()];
        let mut rollout = Rollout::with_capacity(n, self.steps, sizes, log_std);
        let mut outcome = StepOutcome::default();
        let mut noise = vec![0.0_f32; n * std.len()];
        for _ in 0..self.steps {
            seen.actor.update(environment.observations());
            seen.critic.update(environment.critic_observations());
            let start = rollout.actor_rows.len();
            self.actor_normalizer.append_normalized(environment.observations(), &mut rollout.actor_rows);
            self.put_critic_rows(environment, &mut rollout);
            let means = policy.means(&rollout.actor_rows[start..]);
            for (stream, noise) in streams.iter_mut().zip(noise.chunks_exact_mut(std.len())) {
                noise.iter_mut().for_each(|z| *z = StandardNormal.sample(stream));
                rollout.log_probabilities.push(log_probability_of_noise(noise, log_std));
            }
            let std = std.iter().cycle();
            let actions: Vec<f32> = means.iter().zip(&noise).zip(std).map(|((m, z), s)| m + z * s).collect();
            environment.teach(&mut rollout.taught)?;
            let stepping = Instant::now();
            environment.step(&actions, &mut outcome)?;
            seen.stepping += stepping.elapsed().as_secs_f64();
            let first = rollout.rewards.len();
            rollout
                .final_steps
                .extend(outcome.truncated.iter().enumerate().filter(|(_, t)| **t).map(|(i, _)| first + i));
            self.critic_normalizer.append_normalized(&outcome.final_critic_observations, &mut rollout.final_rows);
            rollout.means.extend(means);
            rollout.actions.extend(actions);
            rollout.rewards.extend_from_slice(&outcome.rewards);
            rollout.terminated.extend_from_slice(&outcome.terminated);
            rollout.truncated.extend_from_slice(&outcome.truncated);
        }
        self.put_critic_rows(environment, &mut rollout);
        Ok((rollout, seen))
    }

    fn put_critic_rows<E: VectorEnvironment>(&self, environment: &E, rollout: &mut Rollout) {
        self.critic_normalizer.append_normalized(environment.critic_observations(), &mut rollout.critic_rows);
    }
}

impl Rollout {
    /// Returns an empty one that `steps` of `environments` fit in; sizes are those of the policy's rows, the value function's
    /// and actions. Growing step by step would copy all that is there each time the memory is full.
    fn with_capacity(environments: usize, steps: usize, [actor, critic, actions]: [usize; 3], log_std: &[f32]) -> Self {
        let samples = environments * steps;
        Self {
            environments,
            actor_rows: Vec::with_capacity(samples * actor),
            critic_rows: Vec::with_capacity((samples + environments) * critic),
            actions: Vec::with_capacity(samples * actions),
            means: Vec::with_capacity(samples * actions),
            log_probabilities: Vec::with_capacity(samples),
            log_std: log_std.to_vec(),
            rewards: Vec::with_capacity(samples),
            terminated: Vec::with_capacity(samples),
            truncated: Vec::with_capacity(samples),
            ..Self::default()
        }
    }

    /// Number of samples.
    pub fn len(&self) -> usize {
        self.rewards.len()
    }

    /// Returns whether a teacher said its action.
    pub fn is_taught(&self) -> bool {
        !self.taught.is_empty()
    }

    /// Numbers of a row of the value function.
    pub fn critic_width(&self) -> usize {
        self.critic_rows.len() / (self.len() + self.environments).max(1)
    }

    /// Writes it: a run that overlaps collecting and learning stands between the two.
    ///
    /// # Errors
    /// Two entries of one name.
    pub fn save_into(&self, checkpoint: &mut Checkpoint, prefix: &str) -> Result<(), TrainError> {
        let flags = |values: &[bool]| values.iter().map(|b| u64::from(*b)).collect::<Vec<_>>();
        let whole = [
            ("environments", vec![self.environments as u64]),
            ("final_steps", self.final_steps.iter().map(|s| *s as u64).collect()),
            ("terminated", flags(&self.terminated)),
            ("truncated", flags(&self.truncated)),
        ];
        for (name, values) in whole {
            checkpoint.put_u64(&format!("{prefix}.{name}"), &[values.len()], values)?;
        }
        for (name, values) in [
            ("actor_rows", &self.actor_rows),
            ("critic_rows", &self.critic_rows),
            ("final_rows", &self.final_rows),
            ("actions", &self.actions),
            ("means", &self.means),
            ("taught", &self.taught),
            ("log_probabilities", &self.log_probabilities),
            ("log_std", &self.log_std),
            ("rewards", &self.rewards),
        ] {
            checkpoint.put_f32(&format!("{prefix}.{name}"), &[values.len()], values.clone())?;
        }
        Ok(())
    }

    /// Reads it back; `None` where the checkpoint has none.
    ///
    /// # Errors
    /// Only parts of it are there.
    pub fn load(checkpoint: &Checkpoint, prefix: &str) -> Result<Option<Self>, TrainError> {
        let key = |name: &str| format!("{prefix}.{name}");
        if !checkpoint.contains(&key("environments")) {
            return Ok(None);
        }
        let numbers = |name: &str| -> Result<Vec<f32>, TrainError> {
            let shape = checkpoint.entry(&key(name))?.shape().to_vec();
            Ok(checkpoint.f32s(&key(name), &shape)?)
        };
        let whole = |name: &str| -> Result<Vec<u64>, TrainError> {
            let shape = checkpoint.entry(&key(name))?.shape().to_vec();
            Ok(checkpoint.u64s(&key(name), &shape)?)
        };
        Ok(Some(Self {
            environments: whole("environments")?.first().map_or(0, |n| *n as usize),
            actor_rows: numbers("actor_rows")?,
            critic_rows: numbers("critic_rows")?,
            final_rows: numbers("final_rows")?,
            final_steps: whole("final_steps")?.into_iter().map(|s| s as usize).collect(),
            actions: numbers("actions")?,
            means: numbers("means")?,
            taught: numbers("taught")?,
            log_probabilities: numbers("log_probabilities")?,
            log_std: numbers("log_std")?,
            rewards: numbers("rewards")?,
            terminated: whole("terminated")?.into_iter().map(|b| b != 0).collect(),
            truncated: whole("truncated")?.into_iter().map(|b| b != 0).collect(),
        }))
    }
}
