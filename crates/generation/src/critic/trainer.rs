//! The training of a critic: targets anew, then gradient steps on them, epoch by epoch (thesis Algorithm 1, lines 14 to 19).

use std::collections::BTreeSet;

use lifelike_checkpoint::Checkpoint;
use lifelike_checkpoint::rng::stream;
use lifelike_train::supervised::StepMetrics;
use rand::seq::SliceRandom;

use super::data::CriticData;
use super::file::{Critic, CriticHeader};
use super::member::{Member, Sample, bootstrap, original};
use super::network::{Bounds, CriticNetwork};
use super::plan::CriticPlan;
use super::windows::PaddedRows;
use crate::GenerationError;
use crate::representation::Standardizer;

/// Distance of the keys of two members' first weights.
const NEXT_MEMBER: u64 = 0x9E37_79B9_7F4A_7C15;

/// Metrics of one epoch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CriticMetrics {
    /// Those of every training, over all steps that were taken. The loss is the mean squared difference to the targets,
    /// before each step (eq. 5.5).
    pub step: StepMetrics,
    /// Mean target.
    pub target: f64,
}

/// Networks, optimizers and records of one plan, between two epochs.
pub struct CriticTrainer {
    plan: CriticPlan,
    seed: u64,
    pub(super) data: CriticData,
    standardizer: Standardizer,
    /// Rows of every sequence, then [`CriticData::others`].
    motions: Vec<PaddedRows>,
    /// Sequence of each of the motions.
    sequence_of: Vec<usize>,
    /// Sequences that are not learned from.
    held_out: Vec<bool>,
    /// Measured returns with their motion and row, of sequences held out.
    measured: Vec<(usize, usize, f32)>,
    members: Vec<Member>,
    epoch: u64,
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
        let sequence_of: Vec<usize> = (0..data.motions.len()).chain(data.others.iter().map(|o| o.sequence)).collect();
        let rows = || data.motions.iter().chain(data.others.iter().map(|other| &other.rows));
        let learned = rows().zip(&sequence_of).filter(|(_, sequence)| !held_out[**sequence]);
        let standardizer = Standardizer::of(learned.map(|(rows, _)| rows), Standardizer::FLOOR)?;
        let radius = plan.radius(&data.representation);
        let padded = rows().map(|motion| PaddedRows::new(motion, &standardizer, radius));
        let motions = padded.collect::<Result<Vec<_>, _>>()?;
        let mean = data.records.reward.iter().map(|r| f64::from(*r)).sum::<f64>() / data.records.len() as f64;
        let sizes = CriticNetwork::sizes((2 * radius + 1) * data.representation.width(), &plan.hidden);
        let bounds = Bounds::of_rewards(&data.records.reward, plan.gamma);
        let level = (mean / (1.0 - plan.gamma)) as f32;
        let member = |number: usize| {
            let own = seed.wrapping_add(NEXT_MEMBER.wrapping_mul(number as u64));
            let names = &data.records.names;
            let single = || held_out.iter().map(|out| u32::from(!out)).collect();
            let copies = if plan.members > 1 { bootstrap(names, &held_out, seed, number) } else { single() };
            Member::new(CriticNetwork::init(sizes.clone(), own, level, bounds), copies)
        };
        let members = (0..plan.members).map(member).collect();
        // The rest of a return beyond this is less than 1% of it.
        let horizon = (0.01_f64.ln() / plan.gamma.max(1e-9).ln()).ceil().max(1.0) as usize;
        let measured = measured(&data, &held_out, plan.gamma, horizon);
        let (plan, epoch) = (plan.clone(), 0);
        Ok(Self { plan, seed, data, standardizer, motions, sequence_of, held_out, measured, members, epoch })
    }

    /// Returns the plan.
    pub fn plan(&self) -> &CriticPlan {
        &self.plan
    }

    /// Returns the epochs done.
    pub fn epoch(&self) -> u64 {
        self.epoch
    }

    /// Takes one epoch of every member; returns the means over them.
    pub fn epoch_once(&mut self) -> CriticMetrics {
        let (mut loss, mut weight, mut target, mut all, mut norms, mut steps) = (0.0, 0.0, 0.0, 0.0, 0.0, 0_u32);
        for number in 0..self.members.len() {
            let mut samples = self.samples(&self.members[number]);
            samples.shuffle(&mut stream(self.seed, "critic epoch", number as u64, self.epoch));
            for batch in samples.chunks(self.plan.minibatch) {
                let step = self.members[number].improve(&self.plan, &self.motions, batch);
                let own: f64 = batch.iter().map(|s| f64::from(s.weight)).sum();
                all += own;
                target += batch.iter().map(|s| f64::from(s.weight * s.target)).sum::<f64>();
                if step.gradient_norm.is_finite() {
                    loss += step.loss;
                    weight += own;
                    norms += step.gradient_norm;
                    steps += 1;
                }
            }
        }
        self.epoch += 1;
        let step = StepMetrics {
            iteration: self.epoch,
            loss: loss / weight,
            learning_rate: self.plan.learning_rate,
            gradient_norm: norms / f64::from(steps),
            skipped: self.members.iter().map(|member| member.core.skipped()).sum(),
        };
        CriticMetrics { step, target: target / all }
    }

    /// Returns the windows that a member learns from. Records of one window are one sample, their mean target weighted by
    /// their number: the gradient of eq. 5.5 is the same. All rows of one sequence share its records evenly.
    fn samples(&self, member: &Member) -> Vec<Sample> {
        let sequences = &self.motions[..self.data.motions.len()];
        let values: Vec<Vec<f32>> = sequences.iter().map(|motion| member.network.values(motion)).collect();
        let value = |sequence: u32, frame: u32| values[sequence as usize][self.data.row(sequence, frame)];
        let records = &self.data.records;
        let targets = records.targets(self.plan.discounts(), self.plan.across_jumps, value);
        let mut sums: Vec<Vec<(f64, f32)>> = values.iter().map(|values| vec![(0.0, 0.0); values.len()]).collect();
        for ((sequence, frame), target) in records.sequence.iter().zip(&records.frame).zip(&targets) {
            let (sum, count) = &mut sums[*sequence as usize][self.data.row(*sequence, *frame)];
            *sum += f64::from(*target);
            *count += 1.0;
        }
        let mut kinds = vec![0_u32; sums.len()];
        self.sequence_of.iter().for_each(|sequence| kinds[*sequence] += 1);
        let mut samples = Vec::new();
        for (motion, &sequence) in self.sequence_of.iter().enumerate().filter(|(_, s)| !self.held_out[**s]) {
            let share = member.copies[sequence] as f32 / kinds[sequence] as f32;
            for (row, (sum, count)) in sums[sequence].iter().enumerate().take(self.motions[motion].len()) {
                if share * count > 0.0 {
                    let target = (sum / f64::from(*count)) as f32;
                    samples.push(Sample { motion, row, target, weight: share * count });
                }
            }
        }
        samples
    }

    /// Returns how much of the variance of the returns measured on motion held out the least of the members explains,
    /// and the mean of both. `None` where nothing is held out. The best network of each member is remembered.
    pub fn validate_once(&mut self) -> Option<[f64; 3]> {
        if self.measured.is_empty() {
            return None;
        }
        let returns: Vec<f64> = self.measured.iter().map(|(_, _, g)| f64::from(*g)).collect();
        let mut least = vec![f64::INFINITY; returns.len()];
        for member in &mut self.members {
            let value = |m: usize| match self.held_out[self.sequence_of[m]] {
                true => member.network.values(&self.motions[m]),
                false => Vec::new(),
            };
            let values: Vec<Vec<f32>> = (0..self.motions.len()).map(value).collect();
            let predicted: Vec<f64> = self.measured.iter().map(|(m, row, _)| f64::from(values[*m][*row])).collect();
            least.iter_mut().zip(&predicted).for_each(|(least, own)| *least = least.min(*own));
            let score = explained(&predicted, &returns);
            member.validated(score);
        }
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
        Some([explained(&least, &returns), mean(&least), mean(&returns)])
    }

    /// Returns the critic: of every member the best on motion held out, else the latest.
    pub fn critic(&self) -> Critic {
        let data = &self.data;
        let networks: Vec<CriticNetwork> = self.members.iter().map(Member::chosen).collect();
        let header = CriticHeader {
            robot: data.robot.clone(),
            controller: data.controller.clone(),
            representation: data.representation.clone(),
            standardizer: self.standardizer.clone(),
            radius: self.plan.radius(&data.representation),
            hidden: self.plan.hidden.clone(),
            bounds: self.members[0].network.bounds(),
            gamma: self.plan.gamma,
            control_hz: data.records.rate,
            steps: data.records.len() as u64,
            members: networks.len(),
        };
        Critic::new(header, networks)
    }

    pub(super) fn save(&self) -> Result<Checkpoint, GenerationError> {
        let mut checkpoint = Checkpoint::new();
        checkpoint.put_u64("progress", &[2], vec![self.epoch, self.members.len() as u64])?;
        let mut members = self.members.iter().enumerate();
        members.try_for_each(|(number, member)| member.save_into(&mut checkpoint, number))?;
        Ok(checkpoint)
    }

    pub(super) fn load(&mut self, checkpoint: &Checkpoint) -> Result<(), GenerationError> {
        let progress = checkpoint.u64s("progress", &[2])?;
        for (number, member) in self.members.iter_mut().enumerate() {
            member.load(checkpoint, number)?;
        }
        self.epoch = progress[0];
        Ok(())
    }
}

/// Returns the share of the variance of what was measured that predictions explain.
fn explained(predicted: &[f64], measured: &[f64]) -> f64 {
    let mean = measured.iter().sum::<f64>() / measured.len() as f64;
    let error: f64 = predicted.iter().zip(measured).map(|(v, g)| (v - g).powi(2)).sum();
    let variance: f64 = measured.iter().map(|g| (g - mean).powi(2)).sum();
    1.0 - error / variance.max(f64::MIN_POSITIVE)
}

/// Draws the motions that are not learned from, a clip always with its mirror image; at least one is learned from.
fn held_out(names: &[String], share: f64, seed: u64) -> Vec<bool> {
    let own = |name: &String| original(name).to_string();
    let mut clips: Vec<String> = names.iter().map(own).collect::<BTreeSet<_>>().into_iter().collect();
    clips.shuffle(&mut stream(seed, "critic validation", 0, 0));
    clips.truncate(((clips.len() as f64 * share).round() as usize).min(clips.len().saturating_sub(1)));
    names.iter().map(|name| clips.contains(&own(name))).collect()
}

/// Returns the returns measured on sequences held out, with motion and row: once for all rows of a sequence.
fn measured(data: &CriticData, held_out: &[bool], gamma: f64, horizon: usize) -> Vec<(usize, usize, f32)> {
    let records = &data.records;
    let mut rows_of: Vec<Vec<usize>> = (0..data.motions.len()).map(|sequence| vec![sequence]).collect();
    for (number, other) in data.others.iter().enumerate() {
        rows_of[other.sequence].push(data.motions.len() + number);
    }
    let mut all = Vec::new();
    for ((sequence, frame), g) in records.sequence.iter().zip(&records.frame).zip(records.returns(gamma, horizon)) {
        let number = *sequence as usize;
        if held_out[number] && !g.is_nan() {
            let row = data.row(*sequence, *frame);
            let last = |motion: &usize| data.rows_of(*motion) - 1;
            all.extend(rows_of[number].iter().map(|motion| (*motion, row.min(last(motion)), g)));
        }
    }
    all
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

    #[test]
    fn explained_variance_by_hand() {
        // Mean 2, variance sum 2; errors 0, 1, 0.
        assert_eq!(explained(&[1.0, 3.0, 3.0], &[1.0, 2.0, 3.0]), 0.5);
    }
}
