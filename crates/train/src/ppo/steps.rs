//! One gradient step of a network, on the CPU in our own kernels and on a card in tensors.

use burn::module::Module;
use lifelike_dense::{Channel, ROWS};
use lifelike_nn::adam::Adam;
use lifelike_nn::backprop::{backward, forward};
use lifelike_nn::flat::Flat;
use lifelike_nn::gradients::Gradients;
use rayon::prelude::*;

use super::improve::Job;
use crate::TrainError;
use crate::kernels::{ActorKernels, CriticKernels};
use crate::losses::{Objective, imitation, squared_error, surrogate};
use crate::networks::{Actor, Critic, column};

/// Result of a step.
pub struct Step {
    /// What was to be improved, before the step: mean over the minibatch.
    pub objective: f64,
    /// Norm of the gradient; `None` when it was not finite and nothing was changed.
    pub norm: Option<f64>,
}

/// A policy that learns.
pub trait LearningPolicy {
    /// Takes a gradient step on the objective of these samples.
    fn step(&mut self, job: &Job<'_>, batch: &[usize], advantages: &[f32], rate: f64) -> Result<Step, TrainError>;
    /// Means of observations, as it is now.
    fn means(&self, observations: Vec<f32>) -> Result<Vec<f32>, TrainError>;
    /// Logarithms of the standard deviations, as it is now.
    fn log_std(&self) -> Result<Vec<f32>, TrainError>;
}

/// A value function that learns.
pub trait LearningValue {
    /// Takes a gradient step on the squared error of these samples.
    fn step(&mut self, job: &Job<'_>, batch: &[usize], targets: &[f32], rate: f64) -> Result<Step, TrainError>;
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

/// A policy in the kernels. A minibatch is learned from in panels of rows on all threads; what comes out does not depend on how
/// many there are.
pub struct PolicyInKernels<'a> {
    actor: &'a Actor,
    adam: &'a mut Adam,
    flat: Flat,
    kernels: ActorKernels,
    memory: &'a mut Vec<Channel>,
}

impl<'a> PolicyInKernels<'a> {
    /// Takes the numbers out of the network and its optimizer, and memory for passes of the same network.
    pub fn new(actor: &'a Actor, adam: &'a mut Adam, memory: &'a mut Vec<Channel>) -> Result<Self, TrainError> {
        let flat = Flat::of(actor, adam)?;
        let kernels = actor.kernels(&flat);
        Ok(Self { actor, adam, flat, kernels, memory })
    }

    /// Returns the network that was learned; its optimizer has what goes with it.
    pub fn finish(self) -> Actor {
        self.flat.into_module(self.actor.clone(), self.adam)
    }
}

impl LearningPolicy for PolicyInKernels<'_> {
    fn step(&mut self, job: &Job<'_>, batch: &[usize], advantages: &[f32], rate: f64) -> Result<Step, TrainError> {
        let width = job.rollout.actor_rows.len() / job.rollout.len();
        let log_std = self.log_std()?;
        let kernels = &self.kernels;
        let (panels, channels) = panels(self.memory, batch.len(), kernels.channels());
        let parts: Vec<Objective> = panels
            .par_chunks_mut(channels)
            .zip(batch.par_chunks(ROWS))
            .with_max_len(1)
            .map(|(panel, samples)| {
                let rows = samples.iter().map(|i| &job.rollout.actor_rows[i * width..(i + 1) * width]);
                let means = kernels.forward(panel, rows);
                let part = objective(job, &means, &log_std, samples, advantages, batch.len());
                kernels.backward(panel, &part.by_mean);
                part
            })
            .collect();
        kernels.gradient(panels, &mut self.flat.gradient);
        let range = self.flat.range("log_std");
        // The entropy of a Gaussian grows by one with each log standard deviation.
        let by_log_std = &mut self.flat.gradient[range.clone()];
        by_log_std.fill(-job.spec.entropy as f32);
        for part in &parts {
            by_log_std.iter_mut().zip(&part.by_log_std).for_each(|(sum, x)| *sum += x);
        }
        let norm = descend(job, &mut self.flat, self.adam, rate);
        let [low, high] = job.spec.std_bounds.map(|std| std.ln() as f32);
        self.flat.values_mut()[range].iter_mut().for_each(|log_std| *log_std = log_std.clamp(low, high));
        self.kernels.set(self.flat.values());
        Ok(Step { objective: parts.iter().map(|part| part.value).sum(), norm })
    }

    fn means(&self, observations: Vec<f32>) -> Result<Vec<f32>, TrainError> {
        Ok(self.kernels.means(&observations))
    }

    fn log_std(&self) -> Result<Vec<f32>, TrainError> {
        Ok(self.flat.values()[self.flat.range("log_std")].to_vec())
    }
}

/// A value function in the kernels, as [`PolicyInKernels`].
pub struct ValueInKernels<'a> {
    critic: &'a Critic,
    adam: &'a mut Adam,
    flat: Flat,
    kernels: CriticKernels,
    memory: &'a mut Vec<Channel>,
}

impl<'a> ValueInKernels<'a> {
    /// As [`PolicyInKernels::new`].
    pub fn new(critic: &'a Critic, adam: &'a mut Adam, memory: &'a mut Vec<Channel>) -> Result<Self, TrainError> {
        let flat = Flat::of(critic, adam)?;
        let kernels = critic.kernels(&flat);
        Ok(Self { critic, adam, flat, kernels, memory })
    }

    /// As [`PolicyInKernels::finish`].
    pub fn finish(self) -> Critic {
        self.flat.into_module(self.critic.clone(), self.adam)
    }
}

impl LearningValue for ValueInKernels<'_> {
    fn step(&mut self, job: &Job<'_>, batch: &[usize], targets: &[f32], rate: f64) -> Result<Step, TrainError> {
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
        kernels.gradient(panels, &mut self.flat.gradient);
        let norm = descend(job, &mut self.flat, self.adam, rate);
        self.kernels.set(self.flat.values());
        Ok(Step { objective: losses.iter().sum(), norm })
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
fn descend(job: &Job<'_>, flat: &mut Flat, adam: &Adam, rate: f64) -> Option<f64> {
    let processes = job.collective.size();
    if processes > 1 {
        let share = 1.0 / processes as f32;
        job.collective.sum(&mut flat.gradient);
        flat.gradient.iter_mut().for_each(|x| *x *= share);
    }
    flat.step(adam, job.spec.gradient_norm, rate)
}

/// A policy in tensors: on a card.
pub struct PolicyInTensors<'a> {
    pub actor: Actor,
    pub adam: &'a mut Adam,
}

impl LearningPolicy for PolicyInTensors<'_> {
    fn step(&mut self, job: &Job<'_>, batch: &[usize], advantages: &[f32], rate: f64) -> Result<Step, TrainError> {
        let width = job.rollout.actor_rows.len() / job.rollout.len();
        let (means, pass) = self.actor.forward(gather(&job.rollout.actor_rows, width, batch))?;
        let mut part = objective(job, &means, &self.actor.log_std()?, batch, advantages, batch.len());
        // As in the kernels.
        part.by_log_std.iter_mut().for_each(|gradient| *gradient -= job.spec.entropy as f32);
        let mut gradients = self.actor.backward(pass, part.by_mean)?;
        gradients.insert("log_std".into(), column(part.by_log_std, &self.actor.device()));
        let norm = descend_in_tensors(job, &mut self.actor, self.adam, gradients, rate)?;
        self.actor = self.actor.clone().bounded(job.spec.std_bounds);
        Ok(Step { objective: part.value, norm })
    }

    fn means(&self, observations: Vec<f32>) -> Result<Vec<f32>, TrainError> {
        self.actor.means(observations)
    }

    fn log_std(&self) -> Result<Vec<f32>, TrainError> {
        self.actor.log_std()
    }
}

/// A value function in tensors: on a card.
pub struct ValueInTensors<'a> {
    pub critic: Critic,
    pub adam: &'a mut Adam,
}

impl LearningValue for ValueInTensors<'_> {
    fn step(&mut self, job: &Job<'_>, batch: &[usize], targets: &[f32], rate: f64) -> Result<Step, TrainError> {
        let rows = gather(&job.rollout.critic_rows, job.rollout.critic_width(), batch);
        let (values, pass) = forward(self.critic.network(), rows)?;
        let (objective, gradient) = squared_error(&values, &gather(targets, 1, batch), batch.len());
        let gradients = backward(self.critic.network(), pass, gradient, "value")?;
        let norm = descend_in_tensors(job, &mut self.critic, self.adam, gradients, rate)?;
        Ok(Step { objective, norm })
    }
}

fn descend_in_tensors<M: Module>(
    job: &Job<'_>,
    module: &mut M,
    adam: &mut Adam,
    mut gradients: Gradients,
    rate: f64,
) -> Result<Option<f64>, TrainError> {
    let processes = job.collective.size();
    if processes > 1 {
        let share = 1.0 / processes as f32;
        gradients.rewrite(|values| {
            job.collective.sum(values);
            values.iter_mut().for_each(|x| *x *= share);
        })?;
    }
    let norm = gradients.clip_norm(job.spec.gradient_norm)?;
    if !norm.is_finite() {
        return Ok(None);
    }
    *module = adam.step(module.clone(), gradients, rate);
    Ok(Some(norm))
}

/// The rows of some samples.
pub fn gather(values: &[f32], width: usize, samples: &[usize]) -> Vec<f32> {
    let mut out = Vec::with_capacity(samples.len() * width);
    for i in samples {
        out.extend_from_slice(&values[i * width..(i + 1) * width]);
    }
    out
}
