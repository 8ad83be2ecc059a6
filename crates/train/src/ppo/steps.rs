//! One gradient step of a network, in our own kernels.

use lifelike_dense::{Channel, ROWS};
use lifelike_nn::adam::{Adam, Descent};
use lifelike_nn::parameters::Parameters;
use rayon::prelude::*;

use super::improve::Job;
use crate::kernels::{ActorKernels, CriticKernels};
use crate::losses::{Objective, imitation, squared_error, surrogate};
use crate::networks::{Actor, Critic, LOG_STD};

/// Result of a step.
pub struct Step {
    /// Objective before the step: mean over the minibatch.
    pub objective: f64,
    /// Norm of the gradient; `None` when it was not finite and nothing was changed.
    pub norm: Option<f64>,
}

/// The objective of some samples of a minibatch of `batch`, with these means: the teacher's where there is one, else the clipped
/// surrogate.
fn objective(
    job: &Job<'_>,
    means: &[f32],
    log_std: &[f32],
    samples: &[usize],
    advantages: &[f32],
    batch: usize,
) -> Objective {
    let (rollout, joints) = (job.rollout, log_std.len());
    if rollout.is_taught() {
        return imitation(means, log_std, &gather(&rollout.taught, joints, samples), batch);
    }
    surrogate(
        means,
        log_std,
        &gather(&rollout.actions, joints, samples),
        &gather(&rollout.log_probabilities, 1, samples),
        &gather(advantages, 1, samples),
        job.spec.clip as f32,
        batch,
    )
}

/// A policy that learns. A minibatch is learned from in panels of rows on all threads; the result does not depend on how many there
/// are.
pub struct LearningPolicy<'a> {
    actor: &'a mut Actor,
    adam: &'a mut Adam,
    kernels: ActorKernels,
    gradient: Vec<f32>,
    memory: &'a mut Vec<Channel>,
}

impl<'a> LearningPolicy<'a> {
    /// Packs the network, with memory for its passes.
    pub fn new(actor: &'a mut Actor, adam: &'a mut Adam, memory: &'a mut Vec<Channel>) -> Self {
        let (kernels, gradient) = (actor.kernels(), vec![0.0; actor.parameters().len()]);
        Self { actor, adam, kernels, gradient, memory }
    }

    /// Takes a gradient step on the objective of these samples.
    pub fn step(&mut self, job: &Job<'_>, batch: &[usize], advantages: &[f32], rate: f64) -> Step {
        let width = job.rollout.actor_rows.len() / job.rollout.len();
        let (kernels, log_std) = (&self.kernels, self.actor.log_std());
        let (panels, channels) = panels(self.memory, batch.len(), kernels.channels());
        let parts: Vec<Objective> = panels
            .par_chunks_mut(channels)
            .zip(batch.par_chunks(ROWS))
            .with_max_len(1)
            .map(|(panel, samples)| {
                let rows = samples.iter().map(|i| &job.rollout.actor_rows[i * width..(i + 1) * width]);
                let means = kernels.forward(panel, rows);
                let part = objective(job, &means, log_std, samples, advantages, batch.len());
                kernels.backward(panel, &part.by_mean);
                part
            })
            .collect();
        kernels.gradient(panels, &mut self.gradient);
        let range = self.actor.parameters().range(LOG_STD);
        // The entropy of a Gaussian grows by one with each log standard deviation.
        let by_log_std = &mut self.gradient[range];
        by_log_std.fill(-job.spec.entropy as f32);
        for part in &parts {
            by_log_std.iter_mut().zip(&part.by_log_std).for_each(|(sum, x)| *sum += x);
        }
        let parameters = self.actor.parameters_mut();
        let norm = descend(job, parameters, &mut self.gradient, self.adam, rate);
        let [low, high] = job.spec.std_bounds.map(|std| std.ln() as f32);
        parameters.get_mut(LOG_STD).iter_mut().for_each(|log_std| *log_std = log_std.clamp(low, high));
        self.kernels.set(parameters.values());
        Step { objective: parts.iter().map(|part| part.value).sum(), norm }
    }

    /// Means of observations, as it is now.
    pub fn means(&self, observations: &[f32]) -> Vec<f32> {
        self.kernels.means(observations)
    }

    /// Logarithms of the standard deviations, as it is now.
    pub fn log_std(&self) -> &[f32] {
        self.actor.log_std()
    }
}

/// A value function that learns, as [`LearningPolicy`].
pub struct LearningValue<'a> {
    critic: &'a mut Critic,
    adam: &'a mut Adam,
    kernels: CriticKernels,
    gradient: Vec<f32>,
    memory: &'a mut Vec<Channel>,
}

impl<'a> LearningValue<'a> {
    /// As [`LearningPolicy::new`].
    pub fn new(critic: &'a mut Critic, adam: &'a mut Adam, memory: &'a mut Vec<Channel>) -> Self {
        let (kernels, gradient) = (critic.kernels(), vec![0.0; critic.parameters().len()]);
        Self { critic, adam, kernels, gradient, memory }
    }

    /// Takes a gradient step on the squared error of these samples.
    pub fn step(&mut self, job: &Job<'_>, batch: &[usize], targets: &[f32], rate: f64) -> Step {
        let width = job.rollout.critic_width();
        let kernels = &self.kernels;
        let (panels, channels) = panels(self.memory, batch.len(), kernels.channels());
        let losses: Vec<f64> = panels
            .par_chunks_mut(channels)
            .zip(batch.par_chunks(ROWS))
            .with_max_len(1)
            .map(|(panel, samples)| {
                let rows = samples.iter().map(|i| &job.rollout.critic_rows[i * width..(i + 1) * width]);
                let values = kernels.forward(panel, rows);
                let (loss, by_values) = squared_error(&values, &gather(targets, 1, samples), batch.len());
                kernels.backward(panel, &by_values);
                loss
            })
            .collect();
        kernels.gradient(panels, &mut self.gradient);
        let parameters = self.critic.parameters_mut();
        let norm = descend(job, parameters, &mut self.gradient, self.adam, rate);
        self.kernels.set(parameters.values());
        Step { objective: losses.iter().sum(), norm }
    }
}

/// Memory for the panels of a minibatch, and the channels of one.
fn panels(memory: &mut Vec<Channel>, rows: usize, channels: usize) -> (&mut [Channel], usize) {
    let all = rows.div_ceil(ROWS) * channels;
    if memory.len() < all {
        memory.resize(all, Channel::ZERO);
    }
    (&mut memory[..all], channels)
}

/// The step itself, with the mean gradient of all processes.
fn descend(
    job: &Job<'_>,
    parameters: &mut Parameters,
    gradient: &mut [f32],
    adam: &mut Adam,
    rate: f64,
) -> Option<f64> {
    let processes = job.collective.size();
    if processes > 1 {
        let share = 1.0 / processes as f32;
        job.collective.sum(gradient);
        gradient.iter_mut().for_each(|x| *x *= share);
    }
    let descent = Descent { gradient, max_norm: job.spec.gradient_norm, rate };
    let stepped = parameters.step(adam, descent);
    stepped.taken.then_some(stepped.norm)
}

/// The rows of some samples.
pub fn gather(values: &[f32], width: usize, samples: &[usize]) -> Vec<f32> {
    let mut out = Vec::with_capacity(samples.len() * width);
    for i in samples {
        out.extend_from_slice(&values[i * width..(i + 1) * width]);
    }
    out
}
