//! The training of a critic: targets anew, then gradient steps on them, epoch by epoch (thesis Algorithm 1, lines 14 to 19).

use std::collections::BTreeSet;

use lifelike_checkpoint::Checkpoint;
use lifelike_checkpoint::rng::stream;
use lifelike_dense::{AdamStep, Channel, ROWS, Slices, norm};
use lifelike_nn::adam::AdamConfig;
use lifelike_simd::InstructionSet;
use rand::seq::SliceRandom;
use rayon::prelude::*;

use super::data::CriticData;
use super::file::{Critic, CriticHeader};
use super::network::{Bounds, CriticNetwork};
use super::plan::CriticPlan;
use super::windows::PaddedRows;
use crate::GenerationError;
use crate::representation::Standardizer;

/// Numbers of one epoch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CriticMetrics {
    /// Mean squared difference to the targets over the epoch, before each step (eq. 5.5).
    pub loss: f64,
    /// Mean target.
    pub target: f64,
    /// Mean norm of the gradient.
    pub gradient_norm: f64,
}

/// A window with what its records say.
#[derive(Debug, Clone, Copy)]
struct Sample {
    motion: usize,
    row: usize,
    target: f32,
    /// Records of this window.
    weight: f32,
}

/// Network, optimizer and records of one plan, between two epochs.
pub struct CriticTrainer {
    plan: CriticPlan,
    seed: u64,
    pub(super) data: CriticData,
    standardizer: Standardizer,
    motions: Vec<PaddedRows>,
    /// Motions that are not learned from.
    held_out: Vec<bool>,
    /// Measured returns with their motion and row, of motions held out.
    measured: Vec<(usize, usize, f32)>,
    network: CriticNetwork,
    moments: [Vec<f32>; 2],
    steps: u64,
    epoch: u64,
    /// The best network on what was held out, with its score.
    best: Option<(f64, Vec<f32>)>,
    memory: Vec<Channel>,
}

impl CriticTrainer {
    /// Returns a fresh critic and what it learns from.
    ///
    /// # Errors
    /// A value of the plan is out of its range, or [`CriticData::check`].
    pub fn new(plan: &CriticPlan, seed: u64, data: CriticData) -> Result<Self, GenerationError> {
        plan.check()?;
        data.check()?;
        let held_out = held_out(&data.records.names, plan.validation, seed);
        let learned = data.motions.iter().zip(&held_out).filter(|(_, out)| !**out).map(|(motion, _)| motion);
        let standardizer = Standardizer::of(learned, Standardizer::FLOOR)?;
        let radius = plan.radius(&data.representation);
        let padded = data.motions.iter().map(|motion| PaddedRows::new(motion, &standardizer, radius));
        let motions = padded.collect::<Result<Vec<_>, _>>()?;
        let mean = data.records.reward.iter().map(|r| f64::from(*r)).sum::<f64>() / data.records.len() as f64;
        let sizes = CriticNetwork::sizes((2 * radius + 1) * data.representation.width(), &plan.hidden);
        let bounds = Bounds::of_rewards(&data.records.reward, plan.gamma);
        let network = CriticNetwork::init(sizes, seed, (mean / (1.0 - plan.gamma)) as f32, bounds);
        let zeros = vec![0.0; network.parameters().len()];
        // The rest of a return beyond this is less than 1% of it.
        let horizon = (0.01_f64.ln() / plan.gamma.max(1e-9).ln()).ceil().max(1.0) as usize;
        let measured = measured(&data, &held_out, plan.gamma, horizon);
        let moments = [zeros.clone(), zeros];
        let (plan, memory) = (plan.clone(), Vec::new());
        Ok(Self {
            plan,
            seed,
            data,
            standardizer,
            motions,
            held_out,
            measured,
            network,
            moments,
            steps: 0,
            epoch: 0,
            best: None,
            memory,
        })
    }

    /// Returns the plan.
    pub fn plan(&self) -> &CriticPlan {
        &self.plan
    }

    /// Returns the epochs done.
    pub fn epoch(&self) -> u64 {
        self.epoch
    }

    /// Takes one epoch.
    pub fn epoch_once(&mut self) -> CriticMetrics {
        let mut samples = self.samples();
        samples.shuffle(&mut stream(self.seed, "critic epoch", 0, self.epoch));
        let (mut loss, mut weight, mut target, mut norms, mut steps) = (0.0, 0.0, 0.0, 0.0, 0_u32);
        for batch in samples.chunks(self.plan.minibatch) {
            let (error, norm) = self.improve(batch);
            loss += error;
            weight += batch.iter().map(|s| f64::from(s.weight)).sum::<f64>();
            target += batch.iter().map(|s| f64::from(s.weight * s.target)).sum::<f64>();
            norms += norm;
            steps += 1;
        }
        self.epoch += 1;
        CriticMetrics { loss: loss / weight, target: target / weight, gradient_norm: norms / f64::from(steps) }
    }

    /// Returns the windows that are learned from. Records of one window are one sample, their mean target weighted by
    /// their number: the gradient of eq. 5.5 is the same.
    fn samples(&self) -> Vec<Sample> {
        let values: Vec<Vec<f32>> = self.motions.iter().map(|motion| self.network.values(motion)).collect();
        let value = |sequence: u32, frame: u32| values[sequence as usize][self.data.row(sequence, frame)];
        let records = &self.data.records;
        let targets = records.targets(self.plan.discounts(), self.plan.across_jumps, value);
        let mut sums: Vec<Vec<(f64, f32)>> = values.iter().map(|values| vec![(0.0, 0.0); values.len()]).collect();
        for ((sequence, frame), target) in records.sequence.iter().zip(&records.frame).zip(&targets) {
            let (sum, count) = &mut sums[*sequence as usize][self.data.row(*sequence, *frame)];
            *sum += f64::from(*target);
            *count += 1.0;
        }
        let learned = sums.iter().enumerate().filter(|(motion, _)| !self.held_out[*motion]);
        let rows = learned.flat_map(|(motion, rows)| rows.iter().enumerate().map(move |(row, sum)| (motion, row, sum)));
        let sample = |(motion, row, &(sum, weight)): (usize, usize, &(f64, f32))| Sample {
            motion,
            row,
            target: (sum / f64::from(weight)) as f32,
            weight,
        };
        rows.filter(|(_, _, sum)| sum.1 > 0.0).map(sample).collect()
    }

    /// Takes one gradient step; returns the weighted sum of squared errors before it, and the gradient's norm.
    fn improve(&mut self, batch: &[Sample]) -> (f64, f64) {
        let (network, motions) = (&self.network, &self.motions);
        let total: f32 = batch.iter().map(|s| s.weight).sum();
        let channels = network.channels();
        let all = batch.len().div_ceil(ROWS) * channels;
        if self.memory.len() < all {
            self.memory.resize(all, Channel::ZERO);
        }
        let panels = &mut self.memory[..all];
        let losses: Vec<f64> = panels
            .par_chunks_mut(channels)
            .zip(batch.par_chunks(ROWS))
            .with_max_len(1)
            .map(|(panel, samples)| {
                let mut values = vec![0.0; samples.len()];
                network.forward(panel, samples.iter().map(|s| motions[s.motion].window(s.row)), &mut values);
                let errors = || values.iter().zip(samples).map(|(v, s)| (v - s.target, s.weight));
                let by: Vec<f32> = errors().map(|(error, weight)| 2.0 * error * weight / total).collect();
                let loss = errors().map(|(error, weight)| f64::from(error).powi(2) * f64::from(weight)).sum();
                network.backward(panel, &values, &by, false);
                loss
            })
            .collect();
        let mut gradient = vec![0.0; network.parameters().len()];
        network.by_parameters(panels, &mut gradient);
        let set = InstructionSet::chosen();
        self.steps += 1;
        let AdamConfig { beta_1, beta_2, epsilon, .. } = AdamConfig::adam();
        let (rate, decay) = (self.plan.learning_rate, self.plan.learning_rate * self.plan.weight_decay);
        let step = AdamStep { beta_1, beta_2, epsilon, step: self.steps, rate, scale: 1.0 };
        let [first, second] = &mut self.moments;
        let weights: Vec<_> = network.layers().layers().iter().map(|layer| layer.weight()).collect();
        let norm = norm(set, &gradient);
        self.network.update(|values| {
            for range in weights {
                values[range].iter_mut().for_each(|w| *w *= 1.0 - decay as f32);
            }
            step.take(set, Slices { values, gradient: &gradient, first, second });
        });
        (losses.iter().sum(), norm)
    }

    /// Returns how much of the variance of the returns measured on motion held out the network explains, and the mean of
    /// both; `None` where nothing is held out. The best network is remembered.
    pub fn validate_once(&mut self) -> Option<[f64; 3]> {
        if self.measured.is_empty() {
            return None;
        }
        let value = |m: usize| if self.held_out[m] { self.network.values(&self.motions[m]) } else { Vec::new() };
        let values: Vec<Vec<f32>> = (0..self.motions.len()).map(value).collect();
        let n = self.measured.len() as f64;
        let pairs = || self.measured.iter().map(|(m, row, g)| (f64::from(values[*m][*row]), f64::from(*g)));
        let (predicted, returned) = (pairs().map(|p| p.0).sum::<f64>() / n, pairs().map(|p| p.1).sum::<f64>() / n);
        let error: f64 = pairs().map(|(v, g)| (v - g).powi(2)).sum();
        let variance: f64 = pairs().map(|(_, g)| (g - returned).powi(2)).sum();
        let explained = 1.0 - error / variance.max(f64::MIN_POSITIVE);
        if self.best.as_ref().is_none_or(|(best, _)| explained > *best) {
            self.best = Some((explained, self.network.parameters().to_vec()));
        }
        Some([explained, predicted, returned])
    }

    /// Returns the critic: the best on motion held out, else the latest.
    pub fn critic(&self) -> Critic {
        let network = match &self.best {
            Some((_, parameters)) => {
                CriticNetwork::new(self.network.layers().clone(), parameters.clone(), self.network.bounds())
            }
            None => self.network.clone(),
        };
        let data = &self.data;
        let header = CriticHeader {
            robot: data.robot.clone(),
            controller: data.controller.clone(),
            representation: data.representation.clone(),
            standardizer: self.standardizer.clone(),
            radius: self.plan.radius(&data.representation),
            hidden: self.plan.hidden.clone(),
            bounds: self.network.bounds(),
            gamma: self.plan.gamma,
            control_hz: data.records.rate,
            steps: data.records.len() as u64,
        };
        Critic::new(header, network)
    }

    pub(super) fn save(&self) -> Result<Checkpoint, GenerationError> {
        let mut checkpoint = Checkpoint::new();
        let n = self.network.parameters().len();
        checkpoint.put_u64("progress", &[2], vec![self.epoch, self.steps])?;
        checkpoint.put_f32("network", &[n], self.network.parameters().to_vec())?;
        checkpoint.put_f32("adam.first", &[n], self.moments[0].clone())?;
        checkpoint.put_f32("adam.second", &[n], self.moments[1].clone())?;
        if let Some((score, parameters)) = &self.best {
            checkpoint.put_f64("best.score", &[1], vec![*score])?;
            checkpoint.put_f32("best.network", &[n], parameters.clone())?;
        }
        Ok(checkpoint)
    }

    pub(super) fn load(&mut self, checkpoint: &Checkpoint) -> Result<(), GenerationError> {
        let n = self.network.parameters().len();
        let progress = checkpoint.u64s("progress", &[2])?;
        let parameters = checkpoint.f32s("network", &[n])?;
        self.moments = [checkpoint.f32s("adam.first", &[n])?, checkpoint.f32s("adam.second", &[n])?];
        self.network.update(|values| values.copy_from_slice(&parameters));
        self.best = match checkpoint.contains("best.score") {
            true => Some((checkpoint.f64s("best.score", &[1])?[0], checkpoint.f32s("best.network", &[n])?)),
            false => None,
        };
        (self.epoch, self.steps) = (progress[0], progress[1]);
        Ok(())
    }
}

/// Draws the motions that are not learned from, a clip always with its mirror image; at least one is learned from.
fn held_out(names: &[String], share: f64, seed: u64) -> Vec<bool> {
    let original = |name: &String| name.trim_end_matches("+mirror").to_string();
    let mut clips: Vec<String> = names.iter().map(original).collect::<BTreeSet<_>>().into_iter().collect();
    clips.shuffle(&mut stream(seed, "critic validation", 0, 0));
    clips.truncate(((clips.len() as f64 * share).round() as usize).min(clips.len().saturating_sub(1)));
    names.iter().map(|name| clips.contains(&original(name))).collect()
}

fn measured(data: &CriticData, held_out: &[bool], gamma: f64, horizon: usize) -> Vec<(usize, usize, f32)> {
    let records = &data.records;
    let places = records.sequence.iter().zip(&records.frame).zip(records.returns(gamma, horizon));
    let out = places.filter(|((sequence, _), g)| held_out[**sequence as usize] && !g.is_nan());
    out.map(|((sequence, frame), g)| (*sequence as usize, data.row(*sequence, *frame), g)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_clip_is_held_out_with_its_mirror_image() {
        let names: Vec<String> = (0..20).flat_map(|i| [format!("clip {i}"), format!("clip {i}+mirror")]).collect();
        let out = held_out(&names, 0.2, 4);
        assert_eq!(out.iter().filter(|out| **out).count(), 8);
        assert!(out.chunks(2).all(|pair| pair[0] == pair[1]));
        assert_eq!(held_out(&names[..1], 0.9, 4), [false]);
    }
}
