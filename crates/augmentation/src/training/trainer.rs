//! Stretches of traces, their gradients, and steps of Adam.

use lifelike_checkpoint::Checkpoint;
use lifelike_checkpoint::rng::stream;
use lifelike_nn::adam::{AdamConfig, Descent};
use lifelike_nn::rows::Layout;
use lifelike_sim::trace::{BlockTrace, Trace};
use lifelike_train::supervised::{Decay, StepMetrics, SupervisedCore};
use rand::Rng;
use rayon::prelude::*;
use sha2::{Digest, Sha256};

use super::plan::AugmentationPlan;
use crate::augmentation::{Augmentation, AugmentationHeader};
use crate::loss::Loss;
use crate::model::{Inputs, Network, SatSizes, Scales, Sequence};
use crate::{AugmentationError, FromInput};

/// Validation sequences that run side by side.
const SIDE_BY_SIDE: usize = 12;

/// Errors that the encoder sees in a stretch.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Told {
    Nothing,
    Measured,
    Predicted,
}

/// A stretch of a sequence.
#[derive(Debug, Clone, Copy)]
pub(super) struct Stretch {
    sequence: usize,
    first: usize,
    pub(super) told: Told,
}

/// Network, optimizer and traces of one plan, between two iterations.
pub struct AugmentationTrainer {
    pub(super) plan: AugmentationPlan,
    pub(super) inputs: Inputs,
    scales: Scales,
    pub(super) sizes: SatSizes,
    layout: Layout,
    loss: Loss,
    sequences: Vec<Sequence>,
    validation: Vec<Sequence>,
    values: Vec<f32>,
    /// Moments, and the best weights on the validation traces.
    pub(super) core: SupervisedCore,
    digest: String,
}

impl AugmentationTrainer {
    /// Returns a fresh network and what it learns from: all blocks of the plan's class, or of the first one's.
    ///
    /// # Errors
    /// A value of the plan out of its range. [`AugmentationError::Input`] for traces without measured blocks, with
    /// other columns or another rate, or shorter than a stretch.
    pub fn new(plan: &AugmentationPlan, traces: &[Trace], validation: &[Trace]) -> Result<Self, AugmentationError> {
        plan.check()?;
        let measured = |trace: &'_ Trace| -> Vec<(String, BlockTrace)> {
            let wanted = |block: &&BlockTrace| plan.class.is_empty() || block.class == plan.class;
            let blocks = trace.blocks.iter().filter(|block| !block.measured.names.is_empty()).filter(wanted);
            blocks.map(|block| (trace.name.clone(), block.clone())).collect()
        };
        let blocks: Vec<(String, BlockTrace)> = traces.iter().flat_map(measured).collect();
        let Some((_, first)) = blocks.first() else {
            let expected = match plan.class.as_str() {
                "" => "some with measured blocks".to_string(),
                class => format!("some with measured blocks of class '{class}'"),
            };
            return Err(AugmentationError::mismatch("traces to learn from", expected, traces.len()));
        };
        let rate = traces[0].rate;
        if let Some(other) = traces.iter().chain(validation).find(|trace| trace.rate != rate) {
            let what = format!("rate of trace '{}'", other.name);
            return Err(AugmentationError::mismatch(what, format!("{rate} Hz"), format!("{} Hz", other.rate)));
        }
        let mut inputs = Inputs::of(first, rate, &plan.outputs, &plan.hysteresis)?.in_frame(plan.frame)?;
        if let Some(name) = plan.leave_out.iter().find(|name| inputs.fields.iter().all(|field| field.name() != *name)) {
            let known: Vec<&str> = inputs.fields.iter().map(|field| field.name()).collect();
            return Err(AugmentationError::mismatch("leave_out", format!("some of {known:?}"), format!("'{name}'")));
        }
        inputs.fields.retain(|field| !plan.leave_out.iter().any(|name| name == field.name()));
        let own = |blocks: Vec<(String, BlockTrace)>| -> Vec<(String, BlockTrace)> {
            blocks.into_iter().filter(|(_, block)| block.class == inputs.class).collect()
        };
        let (blocks, validation) = (own(blocks), own(validation.iter().flat_map(measured).collect()));
        let scales = Scales::of(&inputs, &blocks.iter().map(|(_, block)| block).collect::<Vec<_>>())?;
        let sequences = |blocks: &[(String, BlockTrace)]| -> Result<Vec<Sequence>, AugmentationError> {
            blocks.iter().map(|(run, block)| inputs.sequence(run, block, &scales)).collect()
        };
        let (sequences, validation) = (sequences(&blocks)?, sequences(&validation)?);
        let (width, outputs) = (inputs.fields.len(), inputs.selection.len());
        if let Some(short) = sequences.iter().find(|own| own.rows.len() < plan.stretch * width) {
            let got = short.rows.len() / width;
            return Err(AugmentationError::mismatch(format!("steps of '{}'", short.name), plan.stretch, got));
        }
        let sizes = SatSizes { inputs: width, outputs, quantiles: plan.loss.quantiles(), ..plan.model };
        let layout = sizes.layout();
        let values = layout.init(plan.seed, "augmentation");
        let mut hash = Sha256::new();
        for own in sequences.iter().chain(&validation) {
            hash.update((own.name.len() as u64).to_le_bytes());
            hash.update(own.name.as_bytes());
            own.rows.iter().chain(&own.error).for_each(|x| hash.update(x.to_le_bytes()));
        }
        Ok(Self {
            loss: Loss::new(plan.loss, &inputs, &scales, plan.physics_weight),
            plan: plan.clone(),
            core: SupervisedCore::new(AdamConfig::adam(), values.len()),
            digest: hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect(),
            inputs,
            scales,
            sizes,
            layout,
            sequences,
            validation,
            values,
        })
    }

    /// Returns the plan.
    pub fn plan(&self) -> &AugmentationPlan {
        &self.plan
    }

    /// Returns the iterations done.
    pub fn iteration(&self) -> u64 {
        self.core.iteration()
    }

    /// Returns SHA-256 over all that is learned from, hexadecimal.
    pub fn digest(&self) -> &str {
        &self.digest
    }

    /// Returns the number of parameters.
    pub fn parameters(&self) -> usize {
        self.values.len()
    }

    /// Returns the building blocks learned from, and validated on.
    pub fn blocks(&self) -> [usize; 2] {
        [self.sequences.len(), self.validation.len()]
    }

    /// Takes one step.
    pub fn iterate(&mut self) -> StepMetrics {
        let stretches = self.draw();
        let network = Network::new(self.sizes, &self.layout, &self.values);
        let parts: Vec<(usize, &[Stretch])> = stretches.chunks(self.plan.part).enumerate().collect();
        let results: Vec<(f64, Vec<f32>)> =
            parts.into_par_iter().with_max_len(1).map(|(i, part)| self.part(&network, i, part)).collect();
        let count = (stretches.len() * self.plan.stretch * self.inputs.selection.len()) as f64;
        let mut gradient = vec![0.0_f32; self.values.len()];
        let mut loss = 0.0;
        for (own, sums) in results {
            loss += own;
            gradient.iter_mut().zip(sums).for_each(|(sum, x)| *sum += x / count as f32);
        }
        let rate = self.plan.learning_rate_at(self.iteration());
        let descent = Descent { gradient: &gradient, max_norm: self.plan.max_gradient_norm, rate };
        let whole = 0..self.values.len();
        let decay = Decay { weight: self.plan.weight_decay, ranges: &[whole] };
        self.core.step(&self.layout, &mut self.values, loss / count, descent, decay)
    }

    fn draw(&self) -> Vec<Stretch> {
        let mut rng = stream(self.plan.seed, "augmentation batch", 0, self.iteration());
        let width = self.inputs.fields.len();
        // Longer sequences are drawn more often: every place of every sequence alike.
        let places: Vec<usize> =
            self.sequences.iter().map(|own| own.rows.len() / width - self.plan.stretch + 1).collect();
        let total: usize = places.iter().sum();
        let feedback = self.plan.feedback;
        let mut one = || {
            let (mut sequence, mut first) = (0, rng.random_range(0..total));
            while first >= places[sequence] {
                first -= places[sequence];
                sequence += 1;
            }
            let share: f64 = rng.random();
            let told = match share {
                share if share < feedback.measured => Told::Measured,
                share if share < feedback.measured + feedback.predicted => Told::Predicted,
                _ => Told::Nothing,
            };
            Stretch { sequence, first, told }
        };
        (0..self.plan.batch).map(|_| one()).collect()
    }

    /// Loss and gradient of some stretches, as sums.
    fn part(&self, network: &Network, number: usize, stretches: &[Stretch]) -> (f64, Vec<f32>) {
        let (width, outputs, steps) = (self.inputs.fields.len(), self.inputs.selection.len(), self.plan.stretch);
        let gather = |of: fn(&Sequence) -> &Vec<f32>, width: usize| -> Vec<f32> {
            let row = |step: usize, own: &Stretch| {
                let first = (own.first + step) * width;
                of(&self.sequences[own.sequence])[first..first + width].to_vec()
            };
            (0..steps).flat_map(|step| stretches.iter().flat_map(move |own| row(step, own))).collect()
        };
        let (mut rows, error) = (gather(|own| &own.rows, width), gather(|own| &own.error, outputs));
        let mut rng = stream(self.plan.seed, "augmentation noise", number as u64, self.iteration());
        let noise = self.plan.noise as f32;
        // Uniform of that deviation: cheap, and bounded.
        rows.iter_mut().for_each(|x| *x += noise * 3.0_f32.sqrt() * (2.0 * rng.random::<f32>() - 1.0));
        let fed_back = self.fed_back(network, number, stretches, &rows, &error);
        let (out, pass) = network.forward(&rows, &fed_back, stretches.len());
        let (loss, gradient) = self.loss.of(&out, &error, stretches.len());
        let mut sums = vec![0.0; self.values.len()];
        network.backward(pass, &gradient, &mut sums);
        (loss, sums)
    }

    /// Returns the mean absolute error of each output on the validation traces, in units of the errors' scales; none
    /// without such traces. Feedback is the plan's ([`FeedbackShares::validated`](super::FeedbackShares::validated)).
    /// The best weights are remembered.
    pub fn validate_once(&mut self) -> Option<Vec<f64>> {
        if self.validation.is_empty() {
            return None;
        }
        let network = Network::new(self.sizes, &self.layout, &self.values);
        let outputs = self.inputs.selection.len();
        let chunk = |own: &[Sequence]| -> Vec<(Vec<f64>, f64)> {
            let errors = |(own, out): (&Sequence, Vec<f32>)| {
                let mut sums = vec![0.0; outputs];
                for (out, error) in out.chunks_exact(outputs).zip(own.error.chunks_exact(outputs)) {
                    out.iter().zip(error).zip(&mut sums).for_each(|((a, b), sum)| *sum += f64::from((a - b).abs()));
                }
                (sums, (own.error.len() / outputs) as f64)
            };
            own.iter().zip(self.validated(&network, own)).map(errors).collect()
        };
        let errors: Vec<(Vec<f64>, f64)> = self.validation.par_chunks(SIDE_BY_SIDE).flat_map_iter(chunk).collect();
        let steps: f64 = errors.iter().map(|(_, steps)| steps).sum();
        let means: Vec<f64> =
            (0..outputs).map(|i| errors.iter().map(|(sums, _)| sums[i]).sum::<f64>() / steps).collect();
        let score = -means.iter().sum::<f64>() / outputs as f64;
        self.core.validated(score, &self.values);
        Some(means)
    }

    /// Returns the augmentation: the best on the validation traces, else the latest.
    pub fn augmentation(&self) -> Augmentation {
        let values = self.core.best().unwrap_or(&self.values);
        let outputs = self.inputs.selection.len();
        let mut limit = vec![0.0_f32; outputs];
        for row in self.sequences.iter().flat_map(|own| own.error.chunks_exact(outputs)) {
            row.iter().zip(&mut limit).for_each(|(x, limit)| *limit = limit.max(x.abs()));
        }
        let header = AugmentationHeader {
            inputs: self.inputs.clone(),
            scales: self.scales.clone(),
            sizes: self.sizes,
            loss: self.plan.loss,
            limit,
            learned_from: self.digest.clone(),
        };
        Augmentation::new(header, values)
    }

    /// Returns the inputs' names.
    pub fn inputs(&self) -> &Inputs {
        &self.inputs
    }

    pub(super) fn save(&self) -> Result<Checkpoint, AugmentationError> {
        let mut file = Checkpoint::new();
        self.layout.save_into(&mut file, "network", &self.values)?;
        self.core.save_into(&self.layout, &mut file, "training")?;
        Ok(file)
    }

    pub(super) fn load(&mut self, file: &Checkpoint) -> Result<(), AugmentationError> {
        let values = self.layout.load_from(file, "network")?;
        self.core.load_from(&self.layout, file, "training")?;
        self.values = values;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use lifelike_sim::SimulationSpec;
    use lifelike_sim::trace::Recorder;

    use super::*;

    #[test]
    fn a_gradient_that_is_not_finite_is_skipped_and_counted() {
        let robot = std::sync::Arc::new(lifelike_robot::Robot::load("lima").unwrap());
        let mut simulation = SimulationSpec::new(1).build(robot.clone()).unwrap();
        let mut recorder = Recorder::new(&simulation, 0);
        for step in 0..40 {
            let targets: Vec<f32> =
                robot.default_pose.iter().map(|q| (q + 0.1 * (step as f64 * 0.1).sin()) as f32).collect();
            recorder.step(&mut simulation, &targets).unwrap();
        }
        let mut trace = recorder.trace("swing", "servo");
        for block in &mut trace.blocks {
            block.measured = block.simulated.clone();
            block.selection = block.by_name();
        }
        let model = SatSizes { width: 8, heads: 2, embedding: 4, history: 16, ..SatSizes::default() };
        let plan = AugmentationPlan { model, stretch: 20, batch: 4, ..AugmentationPlan::default() };
        let mut trainer = AugmentationTrainer::new(&plan, &[trace], &[]).unwrap();
        trainer.iterate();
        let before = trainer.values.clone();
        let good: Vec<Vec<f32>> = trainer.sequences.iter().map(|own| own.rows.clone()).collect();
        trainer.sequences.iter_mut().for_each(|own| own.rows.fill(f32::NAN));
        assert_eq!(trainer.iterate().skipped, 1);
        assert_eq!(trainer.values, before);
        trainer.sequences.iter_mut().zip(good).for_each(|(own, rows)| own.rows = rows);
        let next = trainer.iterate();
        assert!(next.skipped == 1 && next.loss.is_finite() && trainer.values != before);
    }
}
