//! One network of a critic's ensemble: its weights, its optimizer, and what it learns from.

use std::collections::BTreeMap;

use lifelike_checkpoint::Checkpoint;
use lifelike_checkpoint::rng::stream;
use lifelike_dense::{Channel, ROWS};
use lifelike_nn::adam::{AdamConfig, Descent};
use lifelike_nn::rows::Layout;
use lifelike_robot::clips::MIRRORED;
use lifelike_train::supervised::{Decay, StepMetrics, SupervisedCore};
use rand::Rng;
use rayon::prelude::*;

use super::network::CriticNetwork;
use super::plan::CriticPlan;
use super::windows::PaddedRows;
use crate::GenerationError;

/// A window with what its records say.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sample {
    /// Motion whose window it is.
    pub(super) motion: usize,
    /// Row at its centre.
    pub(super) row: usize,
    /// Mean target of its records.
    pub(super) target: f32,
    /// Records of this window.
    pub(super) weight: f32,
}

/// One network, between two epochs.
pub(super) struct Member {
    pub(super) network: CriticNetwork,
    /// Copies of each sequence in its bootstrap sample; one of each where the critic is a single network.
    pub(super) copies: Vec<u32>,
    /// Moments, and the best network on what was held out.
    pub(super) core: SupervisedCore,
    layout: Layout,
    memory: Vec<Channel>,
}

impl Member {
    pub(super) fn new(network: CriticNetwork, copies: Vec<u32>) -> Self {
        let count = network.parameters().len();
        let layout = Layout::of_shapes(vec![("network".into(), vec![count])]);
        let core = SupervisedCore::new(AdamConfig::adam(), count);
        Self { network, copies, core, layout, memory: Vec::new() }
    }

    /// Takes one gradient step, whose loss is the weighted sum of squared errors before it.
    pub(super) fn improve(&mut self, plan: &CriticPlan, motions: &[PaddedRows], batch: &[Sample]) -> StepMetrics {
        let network = &self.network;
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
        let weights: Vec<_> = network.layers().layers().iter().map(|layer| layer.weight()).collect();
        let descent = Descent { gradient: &gradient, max_norm: f64::INFINITY, rate: plan.learning_rate };
        let decay = Decay { weight: plan.weight_decay, ranges: &weights };
        let (core, layout, loss) = (&mut self.core, &self.layout, losses.iter().sum());
        self.network.update(|values| core.step(layout, values, loss, descent, decay))
    }

    /// Remembers the network if none scored as high on what was held out.
    pub(super) fn validated(&mut self, score: f64) {
        self.core.validated(score, self.network.parameters());
    }

    /// Returns the best network on motion held out, else the latest.
    pub(super) fn chosen(&self) -> CriticNetwork {
        match self.core.best() {
            Some(parameters) => {
                CriticNetwork::new(self.network.layers().clone(), parameters.to_vec(), self.network.bounds())
            }
            None => self.network.clone(),
        }
    }

    /// Writes it.
    pub(super) fn save_into(&self, file: &mut Checkpoint, member: usize) -> Result<(), GenerationError> {
        self.layout.save_into(file, &format!("member.{member}.network"), self.network.parameters())?;
        Ok(self.core.save_into(&self.layout, file, &format!("member.{member}.training"))?)
    }

    /// Reads it back.
    pub(super) fn load(&mut self, file: &Checkpoint, member: usize) -> Result<(), GenerationError> {
        let parameters = self.layout.load_from(file, &format!("member.{member}.network"))?;
        self.core.load_from(&self.layout, file, &format!("member.{member}.training"))?;
        self.network.update(|values| values.copy_from_slice(&parameters));
        Ok(())
    }
}

/// Returns the name of a member's array in files: the first has no number.
pub(super) fn named(name: &str, member: usize) -> String {
    if member == 0 { name.into() } else { format!("{name}.{member}") }
}

/// Returns a clip's name without that of its mirror image.
pub(super) fn original(name: &str) -> &str {
    name.trim_end_matches(MIRRORED)
}

/// Draws as many clips as there are, with replacement, from those that are learned from; a mirror image goes with its
/// clip. Returns the copies of each sequence, 0 of those held out.
pub(super) fn bootstrap(names: &[String], held_out: &[bool], seed: u64, member: usize) -> Vec<u32> {
    let learned = names.iter().zip(held_out).filter(|(_, out)| !**out);
    let mut copies: BTreeMap<&str, u32> = learned.map(|(name, _)| (original(name), 0)).collect();
    let clips: Vec<&str> = copies.keys().copied().collect();
    let mut rng = stream(seed, "critic bootstrap", member as u64, 0);
    for _ in 0..clips.len() {
        let clip = clips[rng.random_range(0..clips.len())];
        *copies.entry(clip).or_default() += 1;
    }
    names.iter().map(|name| copies.get(original(name)).copied().unwrap_or(0)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bootstrap_has_as_many_clips_as_there_are_and_none_that_is_held_out() {
        let names: Vec<String> = (0..50).flat_map(|i| [format!("clip {i}"), format!("clip {i}+mirror")]).collect();
        let held_out: Vec<bool> = (0..100).map(|i| i < 20).collect();
        let copies = bootstrap(&names, &held_out, 1, 0);
        assert_eq!(copies.iter().sum::<u32>(), 80);
        assert!(copies[..20].iter().all(|count| *count == 0) && copies.chunks(2).all(|pair| pair[0] == pair[1]));
        // Of 40 draws from 40, a share of 1/e is never drawn: 15, with a standard deviation below 3.
        let none = copies[20..].iter().filter(|count| **count == 0).count() / 2;
        assert!((6..=24).contains(&none), "{none}");
        assert_ne!(copies, bootstrap(&names, &held_out, 1, 1));
    }
}
