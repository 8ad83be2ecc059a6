//! Training of a sequence autoencoder: the whole algorithm in [`SequenceTrainer::step`].

use lifelike_checkpoint::Checkpoint;
use lifelike_nn::adam::Descent;
use lifelike_nn::rows;
use lifelike_nn::transformer::passes::Weights;
use lifelike_nn::transformer::{Sampling, SplineAutoencoder};
use lifelike_train::supervised::{StepMetrics, SupervisedCore};
use rayon::prelude::*;

use super::passes;
use super::plan::SequencePlan;
use super::sequences::{HeldOut, Sequences};
use super::spread;
use crate::{FromInput, RepresentationError};

/// Held-out sequences that are in memory at a time.
const BLOCK: usize = 512;

/// Reconstruction errors of held-out sequences.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct SequenceErrors {
    /// Mean loss over all numbers of all sequences: their mean squared error, where the source has no other loss.
    pub mse: f64,
    /// That of each sequence.
    pub each: Vec<f64>,
    /// Root mean square distance of control points from the mean of their own sequence's. Near 0 all control points of
    /// a sequence are the same point: the collapse of thesis 3.3.5. Always 0 for one control point.
    pub spread: f64,
}

/// A training run of a sequence autoencoder.
#[derive(Debug)]
pub struct SequenceTrainer<S> {
    plan: SequencePlan,
    data: S,
    network: SplineAutoencoder,
    core: SupervisedCore,
}

impl<S: Sequences> SequenceTrainer<S> {
    /// A run that has not begun. Methods of one seed begin with the same weights wherever these have the same shape.
    ///
    /// # Errors
    /// A plan out of range.
    pub fn new(plan: SequencePlan, data: S) -> Result<Self, RepresentationError> {
        plan.check()?;
        let network = plan.network(data.width()).init(plan.seed, "spline_transformer")?;
        let core = SupervisedCore::new(plan.adam(), network.parameters().len());
        Ok(Self { plan, data, network, core })
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
        self.core.iteration()
    }

    /// Returns whether the plan's iterations are done.
    pub fn is_done(&self) -> bool {
        self.core.iteration() >= self.plan.iterations
    }

    /// Parameters of the network.
    pub fn parameters(&self) -> usize {
        self.network.parameters().len()
    }

    /// One iteration: a batch through the network in parts, and one step against the mean of their gradients.
    ///
    /// # Errors
    /// Numbers that are not whole sequences.
    pub fn step(&mut self) -> Result<StepMetrics, RepresentationError> {
        let (plan, i) = (&self.plan, self.core.iteration());
        let x = self.data.batch(i, plan.batch);
        let (loss, gradient) = self.gradient(&x)?;
        let learning_rate = plan.learning_rate_at(i);
        let max_norm = plan.max_gradient_norm.unwrap_or(f64::INFINITY);
        let descent = Descent { gradient: &gradient, max_norm, rate: learning_rate };
        Ok(self.core.step_of(self.network.parameters_mut(), loss, descent))
    }

    /// A batch's loss and its gradients. Sums are in the parts' order, whichever core had which, so the number of cores changes
    /// no bit.
    fn gradient(&self, x: &[f32]) -> Result<(f64, Vec<f32>), RepresentationError> {
        let weights = self.network.weights();
        let (plan, data) = (&self.plan, &self.data);
        // A core for each part: whole passes side by side wait for each other less than every product's rows would.
        let parts: Vec<&[f32]> = self.parts(x).collect();
        let part = |part| part_gradient(plan, data, &weights, part, x.len());
        let parts: Vec<(f64, Vec<f32>)> = parts.into_par_iter().map(part).collect::<Result<_, _>>()?;
        let total = parts.into_iter().reduce(|(loss, mut sums), (own, part)| {
            rows::add(&mut sums, &part);
            (loss + own, sums)
        });
        Ok(total.unwrap_or_default())
    }

    /// Splits sequences into the parts that go through the network at a time.
    fn parts<'a>(&self, x: &'a [f32]) -> impl Iterator<Item = &'a [f32]> {
        x.chunks(self.plan.part * self.data.tokens() * self.data.width())
    }

    /// Control points and reconstruction of whole sequences.
    ///
    /// # Shapes
    /// `[B, tokens, width]` to `[B, control points, d]` and `[B, tokens, width]`.
    ///
    /// # Errors
    /// `x` does not hold whole sequences.
    pub fn reconstruct(&self, x: &[f32]) -> Result<(Vec<f32>, Vec<f32>), RepresentationError> {
        let parts = self.passes(x)?;
        let (mut points, mut sequences) = (Vec::new(), Vec::with_capacity(x.len()));
        for [own, sequence] in parts {
            points.extend(own);
            sequences.extend(sequence);
        }
        Ok((points, sequences))
    }

    /// Decodes control points.
    ///
    /// # Shapes
    /// `[B, control points, d]` to `[B, tokens, width]`.
    ///
    /// # Errors
    /// Numbers that are not whole sequences.
    pub fn decode(&self, points: &[f32]) -> Result<Vec<f32>, RepresentationError> {
        passes::sequences(&self.network, points, &Sampling::each(self.data.tokens()))
    }

    /// Control points and reconstruction of each part, a core for each.
    fn passes(&self, x: &[f32]) -> Result<Vec<[Vec<f32>; 2]>, RepresentationError> {
        let weights = self.network.weights();
        let parts: Vec<&[f32]> = self.parts(x).collect();
        let pass = |part: &[f32]| -> Result<_, RepresentationError> {
            let (y, _) = weights.forward(part.to_vec(), self.data.tokens())?;
            Ok([y.control_points, y.sequence])
        };
        parts.into_par_iter().map(pass).collect()
    }

    /// Errors of a held-out set.
    ///
    /// # Errors
    /// Numbers that are not whole sequences.
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
    /// Numbers that are not whole sequences.
    pub fn checkpoint(&self) -> Result<Checkpoint, RepresentationError> {
        let mut checkpoint = Checkpoint::new();
        checkpoint.set_meta("plan", &self.plan)?;
        checkpoint.set_meta("data", &self.data.describe())?;
        let parameters = self.network.parameters();
        parameters.save_into(&mut checkpoint, "network")?;
        self.core.save_into(parameters.layout(), &mut checkpoint, "training")?;
        Ok(checkpoint)
    }

    /// Continues from a checkpoint of a training by the same plan.
    ///
    /// # Errors
    /// A checkpoint of something else, or other data than the run began with.
    pub fn restore(&mut self, checkpoint: &Checkpoint) -> Result<(), RepresentationError> {
        let (expected, got): (String, _) = (checkpoint.meta("data")?, self.data.describe());
        if expected != got {
            return Err(RepresentationError::mismatch("training sequences", expected, got));
        }
        if checkpoint.meta::<SequencePlan>("plan")? != self.plan {
            let expected = "the plan of this run";
            return Err(RepresentationError::mismatch(format!("{}: plan", checkpoint.origin()), expected, "another"));
        }
        let parameters = self.network.parameters().load_from(checkpoint, "network")?;
        self.core.load_from(parameters.layout(), checkpoint, "training")?;
        *self.network.parameters_mut() = parameters;
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
fn part_gradient(
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

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use lifelike_nn::adam::Rule;

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

    /// Along the gradient of each parameter the loss changes as fast as the gradient is long.
    #[test]
    fn the_gradient_is_that_of_finite_differences() {
        for method in Method::ALL {
            let mut trainer = trainer(method);
            // The penalty has no part in the loss that is reported; its own gradient is held in `spread`.
            trainer.plan.spread = None;
            let x = trainer.data.batch(0, trainer.plan.batch);
            let (_, gradient) = trainer.gradient(&x).unwrap();
            let parameters = trainer.network.parameters();
            let loss = |network: SplineAutoencoder| {
                let moved = SequenceTrainer { network, ..self::tests::trainer(method) };
                moved.gradient(&x).unwrap().0
            };
            let mut compared = 0;
            for entry in parameters.layout().entries() {
                let along = &gradient[parameters.range(&entry.name)];
                let size = along.iter().map(|x| f64::from(*x).powi(2)).sum::<f64>().sqrt();
                if size < 1e-3 {
                    continue;
                }
                let moved = |by: f64| {
                    let mut network = trainer.network.clone();
                    let values = network.parameters_mut().get_mut(&entry.name).iter_mut();
                    values.zip(along).for_each(|(x, along)| *x += (by * f64::from(*along) / size) as f32);
                    loss(network)
                };
                let slope = (moved(4e-3) - moved(-4e-3)) / 8e-3;
                assert!((slope - size).abs() < 0.02 * size, "{method} {}: {slope}, not {size}", entry.name);
                compared += 1;
            }
            assert!(compared > 8, "{method}: {compared}");
        }
    }

    #[test]
    fn a_run_that_is_resumed_in_the_middle_ends_in_the_same_bits() {
        let (mut whole, mut half) = (trainer(Method::Spline), trainer(Method::Spline));
        (0..6).for_each(|_| assert!(whole.step().unwrap().loss > 0.0));
        (0..3).for_each(|_| assert!(half.step().unwrap().loss > 0.0));
        let mut resumed = trainer(Method::Spline);
        resumed.restore(&half.checkpoint().unwrap()).unwrap();
        (0..3).for_each(|_| assert!(resumed.step().unwrap().loss > 0.0));
        assert_eq!(resumed.network.parameters().values(), whole.network.parameters().values());
        assert_eq!(resumed.checkpoint().unwrap().to_bytes().unwrap(), whole.checkpoint().unwrap().to_bytes().unwrap());
    }

    /// Sequences whose second batch is broken.
    struct Broken(RecordingWindows);

    impl Sequences for Broken {
        fn describe(&self) -> String {
            self.0.describe()
        }

        fn width(&self) -> usize {
            self.0.width()
        }

        fn tokens(&self) -> usize {
            self.0.tokens()
        }

        fn batch(&self, iteration: u64, count: usize) -> Vec<f32> {
            let mut batch = self.0.batch(iteration, count);
            if iteration == 1 {
                batch[3] = f32::NAN;
            }
            batch
        }

        fn held_out_len(&self, set: HeldOut) -> usize {
            self.0.held_out_len(set)
        }

        fn held_out(&self, set: HeldOut, range: std::ops::Range<usize>) -> Vec<f32> {
            self.0.held_out(set, range)
        }
    }

    #[test]
    fn a_gradient_that_is_not_finite_is_skipped_and_counted() {
        let SequenceTrainer { plan, data, .. } = trainer(Method::Spline);
        let mut trainer = SequenceTrainer::new(plan, Broken(data)).unwrap();
        trainer.step().unwrap();
        let before = trainer.network.parameters().values().to_vec();
        assert_eq!(trainer.step().unwrap().skipped, 1);
        assert_eq!(trainer.network.parameters().values(), before);
        let next = trainer.step().unwrap();
        assert!(next.skipped == 1 && next.loss.is_finite() && trainer.network.parameters().values() != before);
    }
}
