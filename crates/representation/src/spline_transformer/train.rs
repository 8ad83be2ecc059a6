//! Training of a sequence autoencoder: the whole algorithm in [`SequenceTrainer::step`].

use burn::module::Module;
use burn::tensor::{Tensor, TensorData};
use lifelike_checkpoint::Checkpoint;
use lifelike_nn::ModuleCheckpoint;
use lifelike_nn::adam::Adam;
use lifelike_nn::device::{self, Device};
use lifelike_nn::gradients::Gradients;
use lifelike_nn::numbers::read;
use lifelike_nn::rows;
use lifelike_nn::transformer::backprop::{PassError, Weights};
use lifelike_nn::transformer::{Sampling, SplineAutoencoder};
use rayon::prelude::*;

use super::passes;
use super::plan::SequencePlan;
use super::sequences::{HeldOut, Sequences};
use super::spread;
use crate::RepresentationError;

/// Held-out sequences that are in memory at a time.
const BLOCK: usize = 512;

/// Metrics of one iteration. All of it is determined by plan and data.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct SequenceMetrics {
    /// Iterations done, this one included.
    pub iteration: u64,
    /// Mean squared error over all numbers of the batch, before the step.
    pub loss: f64,
    /// Learning rate of this iteration.
    pub learning_rate: f64,
    /// Norm of the gradient before clipping.
    pub gradient_norm: f64,
    /// Iterations so far whose gradient was not finite and was thrown away.
    pub skipped: u64,
}

/// Reconstruction errors of held-out sequences.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct SequenceErrors {
    /// Mean loss over all numbers of all sequences: their mean squared error, where the source has no other loss.
    pub mse: f64,
    /// That of each sequence.
    pub each: Vec<f64>,
    /// Root mean square distance of control points from the mean of their own sequence's. Where it nears 0 all control
    /// points of a sequence are the same point: the collapse of thesis 3.3.5. Always 0 for one control point.
    pub spread: f64,
}

/// A training run of a sequence autoencoder.
#[derive(Debug)]
pub struct SequenceTrainer<S> {
    plan: SequencePlan,
    data: S,
    network: SplineAutoencoder,
    optimizer: Adam,
    device: Device,
    iteration: u64,
    skipped: u64,
}

impl<S: Sequences> SequenceTrainer<S> {
    /// A run that has not begun. Methods of one seed begin with the same weights wherever these have the same shape.
    ///
    /// # Errors
    /// A plan out of range.
    pub fn new(plan: SequencePlan, data: S) -> Result<Self, RepresentationError> {
        plan.check()?;
        let device = device::training();
        let network = plan.network(data.width()).init(plan.seed, "spline_transformer", &device)?;
        let optimizer = Adam::new(plan.adam());
        Ok(Self { plan, data, network, optimizer, device, iteration: 0, skipped: 0 })
    }

    /// With its network on another device.
    #[must_use]
    pub fn to_device(mut self, device: &Device) -> Self {
        self.device = device.clone().autodiff();
        self.network = self.network.fork(&self.device);
        self.optimizer = self.optimizer.to_device(device);
        self
    }

    /// The plan.
    pub fn plan(&self) -> &SequencePlan {
        &self.plan
    }

    /// Sequences that it learns from.
    pub fn data(&self) -> &S {
        &self.data
    }

    /// The network as it stands.
    pub fn network(&self) -> &SplineAutoencoder {
        &self.network
    }

    /// Iterations done.
    pub fn iteration(&self) -> u64 {
        self.iteration
    }

    /// Returns whether the plan's iterations are done.
    pub fn is_done(&self) -> bool {
        self.iteration >= self.plan.iterations
    }

    /// Parameters of the network.
    pub fn parameters(&self) -> usize {
        self.network.num_params()
    }

    /// One iteration: a batch through the network in parts, and one step against the mean of their gradients.
    ///
    /// # Errors
    /// Tensor data that cannot be read from the device.
    pub fn step(&mut self) -> Result<SequenceMetrics, RepresentationError> {
        let (plan, i) = (&self.plan, self.iteration);
        let x = self.data.batch(i, plan.batch);
        let (loss, mut gradients) = if self.is_analytic() { self.analytic(&x) } else { self.recorded(&x) }?;
        let gradient_norm = match plan.max_gradient_norm {
            Some(norm) => gradients.clip_norm(norm)?,
            None => gradients.norm()?,
        };
        let learning_rate = plan.learning_rate_at(i);
        if gradient_norm.is_finite() {
            self.network = self.optimizer.step(self.network.clone(), gradients, learning_rate);
        } else {
            self.skipped += 1;
        }
        self.iteration += 1;
        let (iteration, skipped) = (self.iteration, self.skipped);
        Ok(SequenceMetrics { iteration, loss, learning_rate, gradient_norm, skipped })
    }

    /// A batch's loss and its gradients. Sums are in the parts' order, whichever core had which, so the number of cores changes
    /// no bit.
    fn analytic(&self, x: &[f32]) -> Result<(f64, Gradients), RepresentationError> {
        let weights = Weights::of(&self.network)?;
        let (plan, data) = (&self.plan, &self.data);
        // A core for each part: whole passes side by side wait for each other less than every product's rows would.
        let parts: Vec<&[f32]> = self.parts(x).collect();
        let part = |part| analytic(plan, data, &weights, part, x.len());
        let parts: Vec<(f64, Vec<f32>)> = parts.into_par_iter().map(part).collect::<Result<_, _>>()?;
        let total = parts.into_iter().reduce(|(loss, mut sums), (own, part)| {
            rows::add(&mut sums, &part);
            (loss + own, sums)
        });
        let (loss, sums) = total.unwrap_or_default();
        Ok((loss, weights.named(&sums)))
    }

    /// As [`Self::analytic`], by automatic differentiation.
    fn recorded(&self, x: &[f32]) -> Result<(f64, Gradients), RepresentationError> {
        let mut total = (0.0, Gradients::default());
        for part in self.parts(x) {
            let (loss, gradients) = self.recorded_part(part, x.len())?;
            total = (total.0 + loss, sum(total.1, gradients));
        }
        Ok(total)
    }

    /// What goes through the network at a time.
    fn parts<'a>(&self, x: &'a [f32]) -> impl Iterator<Item = &'a [f32]> {
        x.chunks(self.plan.part * self.data.tokens() * self.data.width())
    }

    fn recorded_part(&self, x: &[f32], numbers: usize) -> Result<(f64, Gradients), RepresentationError> {
        let points = self.network.encode(self.tensor(x, &self.device));
        let sampling = Sampling::each(self.data.tokens());
        let y = self.network.decode(points.clone(), &sampling).map_err(PassError::from)?;
        // Products whose derivatives are the gradients that are known.
        let known = |of: &Tensor<3>, gradient: Vec<f32>| {
            (of.clone() * Tensor::from_data(TensorData::new(gradient, of.dims()), &of.device())).sum()
        };
        let (sum, by_sequence) = mean_loss(&self.data, x, &read(y.clone().inner())?, numbers);
        let mut loss = known(&y, by_sequence);
        if let Some(apart) = penalty(&self.plan, &read(points.clone().inner())?) {
            loss = loss + known(&points, apart);
        }
        Ok((sum / numbers as f64, Gradients::of(&self.network, loss.backward())))
    }

    /// Returns whether the analytic gradient is used: it is for the CPU.
    fn is_analytic(&self) -> bool {
        self.device.clone().inner() == device::inference()
    }

    fn tensor(&self, x: &[f32], device: &Device) -> Tensor<3> {
        let (tokens, width) = (self.data.tokens(), self.data.width());
        let shape = [x.len() / (tokens * width), tokens, width];
        Tensor::from_data(TensorData::new(x.to_vec(), shape), device)
    }

    /// Control points and reconstruction of whole sequences.
    ///
    /// # Shapes
    /// `[B, tokens, width]` to `[B, control points, d]` and `[B, tokens, width]`.
    ///
    /// # Errors
    /// `x` does not hold whole sequences.
    pub fn reconstruct(&self, x: &[f32]) -> Result<(Vec<f32>, Vec<f32>), RepresentationError> {
        let parts = if self.is_analytic() { self.passes_by_rows(x)? } else { self.passes_by_tensors(x)? };
        let (mut points, mut sequences) = (Vec::new(), Vec::with_capacity(x.len()));
        for [own, sequence] in parts {
            points.extend(own);
            sequences.extend(sequence);
        }
        Ok((points, sequences))
    }

    /// Decodes control points, on the CPU.
    ///
    /// # Shapes
    /// `[B, control points, d]` to `[B, tokens, width]`.
    ///
    /// # Errors
    /// Tensor data that cannot be read from the device.
    pub fn decode(&self, points: &[f32]) -> Result<Vec<f32>, RepresentationError> {
        let network = self.network.valid().fork(&device::inference());
        passes::sequences(&network, points, self.plan.latent, &Sampling::each(self.data.tokens()))
    }

    /// Control points and reconstruction of each part, a core for each.
    fn passes_by_rows(&self, x: &[f32]) -> Result<Vec<[Vec<f32>; 2]>, RepresentationError> {
        let weights = Weights::of(&self.network)?;
        let parts: Vec<&[f32]> = self.parts(x).collect();
        let pass = |part: &[f32]| -> Result<_, RepresentationError> {
            let (y, _) = weights.forward(part.to_vec(), self.data.tokens())?;
            Ok([y.control_points, y.sequence])
        };
        parts.into_par_iter().map(pass).collect()
    }

    /// As [`Self::passes_by_rows`], on the network's device.
    fn passes_by_tensors(&self, x: &[f32]) -> Result<Vec<[Vec<f32>; 2]>, RepresentationError> {
        // Records nothing: the memory of a record of which no gradient is asked does not come back.
        let network = self.network.valid();
        let device = self.device.clone().inner();
        let sampling = Sampling::each(self.data.tokens());
        let pass = |part: &[f32]| -> Result<_, RepresentationError> {
            let points = network.encode(self.tensor(part, &device));
            let y = network.decode(points.clone(), &sampling).map_err(PassError::from)?;
            Ok([read(points)?, read(y)?])
        };
        self.parts(x).map(pass).collect()
    }

    /// Errors of a held-out set.
    ///
    /// # Errors
    /// Tensor data that cannot be read from the device.
    pub fn errors(&self, set: HeldOut) -> Result<SequenceErrors, RepresentationError> {
        let unit = self.data.tokens() * self.data.width();
        let (count, latent) = (self.data.held_out_len(set), self.plan.latent);
        let (mut each, mut apart, mut points) = (Vec::with_capacity(count), 0.0, 0);
        for first in (0..count).step_by(BLOCK) {
            let x = self.data.held_out(set, first..(first + BLOCK).min(count));
            let (control_points, y) = self.reconstruct(&x)?;
            let mut unused = vec![0.0; unit];
            let loss = |(x, y)| self.data.loss(x, y, &mut unused) / unit as f64;
            each.extend(x.chunks(unit).zip(y.chunks(unit)).map(loss));
            let per_sequence = self.plan.method.tokens().control_points();
            points += control_points.len() / latent;
            apart += control_points.chunks(per_sequence * latent).map(|p| deviation(p, latent)).sum::<f64>();
        }
        let mse = each.iter().sum::<f64>() / count.max(1) as f64;
        Ok(SequenceErrors { mse, each, spread: (apart / points.max(1) as f64).sqrt() })
    }

    /// Everything needed to continue bit for bit.
    ///
    /// # Errors
    /// Tensor data that cannot be read from the device.
    pub fn checkpoint(&self) -> Result<Checkpoint, RepresentationError> {
        let mut checkpoint = Checkpoint::new();
        checkpoint.set_meta("plan", &self.plan)?;
        checkpoint.set_meta("data", &self.data.describe())?;
        checkpoint.put_u64("progress", &[2], vec![self.iteration, self.skipped])?;
        checkpoint.put_module("network", &self.network)?;
        self.optimizer.save_into(&mut checkpoint, "optimizer")?;
        Ok(checkpoint)
    }

    /// Continues from a checkpoint of a training by the same plan.
    ///
    /// # Errors
    /// A checkpoint of something else, or other data than the run began with.
    pub fn restore(&mut self, checkpoint: &Checkpoint) -> Result<(), RepresentationError> {
        let (expected, got): (String, _) = (checkpoint.meta("data")?, self.data.describe());
        if expected != got {
            return Err(RepresentationError::Mismatch { what: "training sequences".into(), expected, got });
        }
        if checkpoint.meta::<SequencePlan>("plan")? != self.plan {
            return Err(RepresentationError::Mismatch {
                what: format!("{}: plan", checkpoint.origin()),
                expected: "the plan of this run".into(),
                got: "another".into(),
            });
        }
        self.network = checkpoint.load_module("network", self.network.clone())?;
        self.optimizer = Adam::load_from(self.optimizer.config(), checkpoint, "optimizer", &self.network)?;
        let progress = checkpoint.u64s("progress", &[2])?;
        (self.iteration, self.skipped) = (progress[0], progress[1]);
        Ok(())
    }
}

/// [`spread::penalty_gradient`], where the plan wants them.
fn penalty(plan: &SequencePlan, control_points: &[f32]) -> Option<Vec<f32>> {
    let points = plan.method.tokens().control_points();
    let spread = plan.spread.filter(|_| points > 1)?;
    Some(spread::penalty_gradient(spread, control_points, points, plan.latent, plan.batch))
}

/// Returns the sum of the loss, and the gradient of its mean over `numbers` by the sequences that came back.
fn mean_loss(data: &impl Sequences, x: &[f32], y: &[f32], numbers: usize) -> (f64, Vec<f32>) {
    let mut gradient = vec![0.0; y.len()];
    let sum = data.loss(x, y, &mut gradient);
    let scale = 1.0 / numbers as f32;
    gradient.iter_mut().for_each(|g| *g *= scale);
    (sum, gradient)
}

/// One part's share of the loss, and of its gradients.
fn analytic(
    plan: &SequencePlan,
    data: &impl Sequences,
    weights: &Weights,
    x: &[f32],
    numbers: usize,
) -> Result<(f64, Vec<f32>), RepresentationError> {
    let (y, pass) = weights.forward(x.to_vec(), data.tokens())?;
    let (sum, by_sequence) = mean_loss(data, x, &y.sequence, numbers);
    let apart = penalty(plan, &y.control_points);
    Ok((sum / numbers as f64, weights.backward(pass, &by_sequence, apart.as_deref())?))
}

/// Sum of squared distances of points of `latent` numbers from their mean.
fn deviation(points: &[f32], latent: usize) -> f64 {
    let count = (points.len() / latent).max(1) as f64;
    let mean = |k: usize| points.iter().skip(k).step_by(latent).map(|p| f64::from(*p)).sum::<f64>() / count;
    let of = |k: usize, mean: f64| -> f64 {
        points.iter().skip(k).step_by(latent).map(|p| (f64::from(*p) - mean).powi(2)).sum()
    };
    (0..latent).map(|k| of(k, mean(k))).sum()
}

/// Gradients of two parts together.
fn sum(mut total: Gradients, part: Gradients) -> Gradients {
    let names: Vec<String> = part.names().map(str::to_owned).collect();
    for name in names {
        let both = match (total.get(&name), part.get(&name)) {
            (Some(a), Some(b)) => a.clone().add(b.clone()),
            (Some(one), None) | (None, Some(one)) => one.clone(),
            (None, None) => continue,
        };
        total.insert(name, both);
    }
    total
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use lifelike_nn::adam::Rule;
    use lifelike_nn::device::Processor;

    use super::super::{Method, Recording, RecordingWindows, Split, Spread};
    use super::*;

    const TOKENS: usize = 6;

    fn trainer(method: Method) -> SequenceTrainer<RecordingWindows> {
        let wave = |name: &str, frequency: f32| {
            let rows = (0..90).map(|i| (i as f32 * frequency).sin()).collect();
            vec![Recording { name: name.into(), rows }]
        };
        let split =
            Split { training: wave("training", 0.37), validation: wave("validation", 0.29), test: wave("test", 0.53) };
        let data = RecordingWindows::new("waves", 3, TOKENS, 1, split).unwrap();
        let sizes = SequencePlan { method, latent: 4, layers: 1, heads: 2, width: 8, ..SequencePlan::default() };
        let spread = Some(Spread { weight: 0.1, floor: 2.0 });
        let plan = SequencePlan { batch: 5, part: 2, iterations: 8, optimizer: Rule::Muon, spread, ..sizes };
        SequenceTrainer::new(plan, data).unwrap()
    }

    fn largest(numbers: &[f32]) -> f32 {
        numbers.iter().fold(0.0, |largest: f32, x| largest.max(x.abs()))
    }

    /// Rounding apart, by the largest number that there is.
    fn near(a: &[f32], b: &[f32], largest: f32) -> bool {
        a.len() == b.len() && a.iter().zip(b).all(|(a, b)| (a - b).abs() <= 1e-5 * largest)
    }

    /// What a card computes, on the CPU: the gradient by automatic differentiation, and passes by tensors.
    #[test]
    fn tensors_give_what_rows_give() {
        for method in Method::ALL {
            let trainer = trainer(method);
            let x = trainer.data.batch(0, trainer.plan.batch);
            let ((loss, rows), (recorded_loss, tensors)) =
                (trainer.analytic(&x).unwrap(), trainer.recorded(&x).unwrap());
            assert!((loss - recorded_loss).abs() <= 1e-5 * loss, "{method}: {loss} {recorded_loss}");
            let names: Vec<&str> = rows.names().collect();
            assert!(names.iter().copied().eq(tensors.names()), "{method}");
            let all = |of: &Gradients| -> Vec<f32> {
                names.iter().flat_map(|name| read(of.get(name).unwrap().clone()).unwrap()).collect()
            };
            let (rows, tensors) = (all(&rows), all(&tensors));
            assert!(near(&rows, &tensors, largest(&rows)), "{method}: {rows:?} {tensors:?}");
            let (rows, tensors) = (trainer.passes_by_rows(&x).unwrap(), trainer.passes_by_tensors(&x).unwrap());
            assert_eq!((rows.len(), tensors.len()), (3, 3));
            for (rows, tensors) in rows.iter().flatten().zip(tensors.iter().flatten()) {
                assert!(near(rows, tensors, largest(rows)), "{method}: {rows:?} {tensors:?}");
            }
        }
    }

    #[test]
    fn every_device_learns_what_the_cpu_learns() {
        let run = |mut trainer: SequenceTrainer<RecordingWindows>| -> Vec<f64> {
            let losses: Vec<f64> = (0..6).map(|_| trainer.step().unwrap().loss).collect();
            let ends = [HeldOut::Validation, HeldOut::Test].map(|set| trainer.errors(set).unwrap().mse);
            [losses, ends.to_vec()].concat()
        };
        let expected = run(trainer(Method::Spline));
        for processor in Processor::built() {
            let got = run(trainer(Method::Spline).to_device(&processor.open().unwrap()));
            for (cpu, card) in expected.iter().zip(&got) {
                assert!((cpu - card).abs() <= 1e-3 * cpu, "{processor}: {expected:?} {got:?}");
            }
        }
    }
}
