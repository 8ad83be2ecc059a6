//! The algorithm: [`GeneratorTrainer::step`].

use lifelike_checkpoint::Checkpoint;
use lifelike_nn::adam::{AdamConfig, Descent};
use lifelike_nn::rows::{Layout, add};
use lifelike_robot::Robot;
use lifelike_robot::controller::RobotDescription;
use lifelike_train::supervised::{Decay, StepMetrics, SupervisedCore};
use rayon::prelude::*;

use super::batch::{Draw, draw};
use super::data::Sample;
use super::{GeneratorPlan, TrainingData};
use crate::align::Alignment;
use crate::denoiser::{Denoiser, DenoiserInput, DenoiserSizes, TextInput};
use crate::diffusion::Schedule;
use crate::generator::{Generator, GeneratorHeader};
use crate::{FromInput, GenerationError};

/// Validation motions that the loss is measured on.
const WATCHED: usize = 256;

/// Metrics of one iteration. All of it is determined by plan and data.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct GeneratorMetrics {
    /// Those of every training. The loss is eq. 5.6: squared error of the clean motion in standard deviations, mean over
    /// each motion and the batch; that of control points with the joints' velocities
    /// ([`GeneratorPlan::velocity_weight`]).
    #[serde(flatten)]
    pub step: StepMetrics,
    /// Mean value of the surrogate over the rows of the predicted clean motions, where there is one.
    pub realism: Option<f64>,
}

/// A training run of a generator.
#[derive(Debug)]
pub struct GeneratorTrainer {
    plan: GeneratorPlan,
    data: TrainingData,
    robot: (String, String),
    sizes: DenoiserSizes,
    layout: Layout,
    schedule: Schedule,
    values: Vec<f32>,
    core: SupervisedCore,
    alignment: Option<Alignment>,
}

impl GeneratorTrainer {
    /// A run that has not begun.
    ///
    /// # Errors
    /// A plan out of range.
    pub fn new(plan: GeneratorPlan, robot: &Robot, data: TrainingData) -> Result<Self, GenerationError> {
        plan.check()?;
        let text = TextInput { pieces: data.pieces.len() };
        let sizes =
            DenoiserSizes { encoder: plan.encoder(), motion: data.space.width(), text, duration: plan.duration };
        let layout = sizes.layout()?;
        let values = layout.init(plan.seed, "generator");
        Ok(Self {
            robot: (robot.name.clone(), RobotDescription::of(robot).digest),
            schedule: Schedule::cosine(plan.diffusion_steps),
            core: Self::core(&plan, &values),
            plan,
            data,
            sizes,
            layout,
            values,
            alignment: None,
        })
    }

    fn core(plan: &GeneratorPlan, values: &[f32]) -> SupervisedCore {
        SupervisedCore::new(AdamConfig::adam(), values.len()).with_average(plan.ema, values.to_vec())
    }

    /// Returns the averaged weights.
    fn averaged(&self) -> &[f32] {
        self.core.average().unwrap_or(&self.values)
    }

    /// Begins with a trained generator's weights instead, and aligns them with a surrogate beside the loss (eq. 5.7).
    ///
    /// # Errors
    /// A generator of other sizes than the plan's.
    pub fn aligned(mut self, generator: &Generator, alignment: Alignment) -> Result<Self, GenerationError> {
        let (own, other) = (self.sizes, generator.header().sizes);
        if own != other {
            return Err(GenerationError::mismatch("sizes of the generator", format!("{own:?}"), format!("{other:?}")));
        }
        self.values = generator.values().to_vec();
        self.core = Self::core(&self.plan, &self.values);
        self.alignment = Some(alignment);
        Ok(self)
    }

    /// The plan.
    pub fn plan(&self) -> &GeneratorPlan {
        &self.plan
    }

    /// Captioned motion that it learns from.
    pub fn data(&self) -> &TrainingData {
        &self.data
    }

    /// Iterations done.
    pub fn iteration(&self) -> u64 {
        self.core.iteration()
    }

    /// Parameters of the network.
    pub fn parameters(&self) -> usize {
        self.layout.len()
    }

    /// One iteration: a batch through the network in parts, a step of Adam, and the weights' average.
    ///
    /// # Errors
    /// Motion and network do not fit.
    pub fn step(&mut self) -> Result<GeneratorMetrics, GenerationError> {
        let (plan, i) = (&self.plan, self.core.iteration());
        let draws: Vec<Draw<'_>> = (0..plan.batch as u64)
            .into_par_iter()
            .map(|place| {
                let address = (plan.seed, "generator.batch", place, i);
                draw(&self.data.training, None, &self.schedule, plan.condition_dropout, address)
            })
            .collect();
        let denoiser = Denoiser::new(self.sizes, &self.layout, &self.values);
        let parts: Vec<_> = draws
            .par_chunks(plan.part)
            .map(|part| self.part(&denoiser, part, draws.len()))
            .collect::<Result<_, _>>()?;
        // Summed in the parts' order, whichever core had which, so the number of cores changes no bit.
        let (mut gradient, mut loss, mut realism) = (vec![0.0; self.layout.len()], 0.0, 0.0);
        for (own, value, sums) in parts {
            loss += own;
            realism += value;
            add(&mut gradient, &sums);
        }
        let realism = self.alignment.as_ref().map(|_| realism);
        let learning_rate = plan.learning_rate_at(i);
        let descent = Descent { gradient: &gradient, max_norm: plan.max_gradient_norm, rate: learning_rate };
        let step = self.core.step(&self.layout, &mut self.values, loss, descent, Decay::NONE);
        Ok(GeneratorMetrics { step, realism })
    }

    /// Loss, surrogate and gradient of some motions of a batch of `count`.
    fn part(&self, denoiser: &Denoiser, part: &[Draw<'_>], count: usize) -> Result<Part, GenerationError> {
        let (mut gradient, pass) = denoiser.forward(&inputs(part))?;
        let predicted = if self.alignment.is_some() { gradient.clone() } else { Vec::new() };
        let loss = self.against(&mut gradient, part, count);
        let mut realism = 0.0;
        if let Some(alignment) = &self.alignment {
            let lengths = part.iter().map(|draw| (draw.clean.len(), draw.rows));
            let data = &self.data;
            realism = alignment.add(&data.space, &data.standardizer, &predicted, lengths, count, &mut gradient)?;
        }
        let mut sums = vec![0.0; self.layout.len()];
        denoiser.backward(pass, &gradient, &self.layout, &mut sums);
        Ok((loss, realism, sums))
    }

    /// Turns predictions into the loss' gradient by them; returns the loss: mean squares of each motion by the batch's
    /// size.
    fn against(&self, predicted: &mut [f32], part: &[Draw<'_>], count: usize) -> f64 {
        let (mut at, mut loss, width) = (0, 0.0, self.sizes.motion);
        for draw in part {
            let own = &mut predicted[at..at + draw.clean.len()];
            own.iter_mut().zip(draw.clean).for_each(|(y, clean)| *y -= clean);
            let errors = own.to_vec();
            let share = 1.0 / (draw.clean.len() * count) as f64;
            for (gradient, error) in own.iter_mut().zip(&errors) {
                loss += f64::from(error * error) * share;
                *gradient = 2.0 * share as f32 * error;
            }
            let share = self.plan.velocity_weight * share;
            for token in 1..errors.len() / width {
                for (i, scale) in self.data.rate_scales.iter().enumerate() {
                    let here = token * width + i;
                    let error = errors[here] - errors[here - width];
                    loss += f64::from(error * error * scale) * share;
                    let by = 2.0 * share as f32 * scale * error;
                    own[here] += by;
                    own[here - width] -= by;
                }
            }
            at += draw.clean.len();
        }
        loss
    }

    /// Returns the loss of the averaged weights on motion that is not trained on, or on training motion if there is no
    /// other. Every motion has its caption, at steps and noise that are always the same.
    ///
    /// # Errors
    /// Motion and network do not fit.
    pub fn validation_loss(&self) -> Result<f64, GenerationError> {
        let own = &self.data.validation;
        let samples: &[Sample] = if own.is_empty() { &self.data.training } else { own };
        let count = samples.len().min(WATCHED);
        let address = |place: usize| (self.plan.seed, "generator.validation", place as u64, 0);
        let draws: Vec<Draw<'_>> = (0..count)
            .map(|i| draw(samples, Some(i * samples.len() / count), &self.schedule, 0.0, address(i)))
            .collect();
        let denoiser = Denoiser::new(self.sizes, &self.layout, self.averaged());
        let loss = |part: &[Draw<'_>]| {
            let (mut clean, _) = denoiser.forward(&inputs(part))?;
            Ok(self.against(&mut clean, part, count))
        };
        let losses: Vec<f64> = draws.par_chunks(self.plan.part).map(loss).collect::<Result<_, GenerationError>>()?;
        Ok(losses.into_iter().sum())
    }

    /// Returns the generator with the averaged weights.
    pub fn generator(&self) -> Generator {
        let header = GeneratorHeader::new(&self.plan, &self.data, self.sizes, &self.robot, self.core.iteration());
        Generator::new(header, self.data.standardizer.clone(), self.layout.clone(), self.averaged().to_vec())
    }

    /// Everything needed to continue bit for bit.
    ///
    /// # Errors
    /// A number that cannot be saved.
    pub fn checkpoint(&self) -> Result<Checkpoint, GenerationError> {
        let mut checkpoint = Checkpoint::new();
        checkpoint.set_meta("plan", &self.plan)?;
        checkpoint.set_meta("data", &self.data.describe())?;
        self.layout.save_into(&mut checkpoint, "network", &self.values)?;
        self.core.save_into(&self.layout, &mut checkpoint, "training")?;
        Ok(checkpoint)
    }

    /// Continues from a checkpoint of a training by the same plan.
    ///
    /// # Errors
    /// A checkpoint of something else, or other data than the run began with.
    pub fn restore(&mut self, checkpoint: &Checkpoint) -> Result<(), GenerationError> {
        let (expected, got): (String, _) = (checkpoint.meta("data")?, self.data.describe());
        if expected != got {
            return Err(GenerationError::mismatch("captioned motion", expected, got));
        }
        // How long it may take does not change what it does.
        let saved = GeneratorPlan { minutes: self.plan.minutes, ..checkpoint.meta("plan")? };
        if saved != self.plan {
            let what = format!("{}: plan", checkpoint.origin());
            return Err(GenerationError::mismatch(what, "the plan of this run", "another"));
        }
        self.values = self.layout.load_from(checkpoint, "network")?;
        Ok(self.core.load_from(&self.layout, checkpoint, "training")?)
    }
}

/// Loss, mean value of the surrogate, and gradient of some motions of a batch.
type Part = (f64, f64, Vec<f32>);

fn inputs<'a>(part: &'a [Draw<'_>]) -> Vec<DenoiserInput<'a>> {
    let input = |draw: &'a Draw<'_>| DenoiserInput { motion: &draw.noisy, step: draw.step, condition: draw.condition };
    part.iter().map(input).collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use lifelike_language::Split;

    use super::*;
    use crate::data::CaptionedMotion;
    use crate::representation::{FeatureMatrix, RepresentationSpec};

    fn trainer(velocity_weight: f64) -> GeneratorTrainer {
        let robot = Robot::load("lima").unwrap();
        let spec = RepresentationSpec::of(&robot.layout);
        let motion = |i: usize| {
            let (n, width) = (41, spec.width());
            let rows = (0..n * width).map(|k| ((k / width) as f32 * 0.3 + (k % width + i) as f32).sin()).collect();
            let (name, captions) = (format!("{i}"), vec!["a person walks".to_string()]);
            let rows = FeatureMatrix::new(rows, width).unwrap();
            CaptionedMotion { name, split: Split::Train, rows, captions, licence: String::new() }
        };
        let plan =
            GeneratorPlan { width: 8, layers: 1, heads: 2, inner: 8, velocity_weight, ..GeneratorPlan::default() };
        let data = TrainingData::new(&plan, &robot, &[motion(0), motion(1)]).unwrap();
        GeneratorTrainer::new(plan, &robot, data).unwrap()
    }

    /// Loss and gradient where every number is off by `error(token, number)`.
    fn off_by(trainer: &GeneratorTrainer, error: impl Fn(usize, usize) -> f32) -> (f64, Vec<f32>) {
        let (clean, width) = (&trainer.data.training[0].tokens, trainer.sizes.motion);
        let draw = Draw { clean, rows: 41, noisy: Vec::new(), step: 0, condition: None };
        let mut numbers: Vec<f32> = clean.iter().enumerate().map(|(i, x)| x + error(i / width, i % width)).collect();
        let loss = trainer.against(&mut numbers, &[draw], 1);
        (loss, numbers)
    }

    #[test]
    fn the_velocity_term_sees_what_changes_and_its_gradient_is_its_derivative() {
        let (plain, with) = (trainer(0.0), trainer(2.0));
        // Wrong everywhere by the same: no velocity is wrong.
        assert!((off_by(&plain, |_, _| 1.0).0 - 1.0).abs() < 1e-5);
        assert!((off_by(&with, |_, _| 1.0).0 - 1.0).abs() < 1e-5);
        // Wrong by turns: every difference is 2. Only joints count.
        let by_turns = |token: usize, _: usize| if token.is_multiple_of(2) { 1.0 } else { -1.0 };
        let (tokens, width) = (with.data.training[0].tokens.len() / with.sizes.motion, with.sizes.motion);
        let scales: f64 = with.data.rate_scales.iter().map(|x| f64::from(*x)).sum();
        let expected = 1.0 + 2.0 * 4.0 * scales * (tokens - 1) as f64 / (tokens * width) as f64;
        assert!((off_by(&with, by_turns).0 - expected).abs() < 1e-4 * expected);
        assert!(with.data.rate_scales[..7].iter().all(|x| *x == 0.0) && scales > 0.0);

        let error = |token: usize, i: usize| ((token * 7 + i * 3) % 11) as f32 * 0.1 - 0.5;
        let (_, gradient) = off_by(&with, error);
        for at in [7, width + 9, 3 * width + 20, (tokens - 1) * width + 12, 2 * width + 3] {
            let moved =
                |by: f32| off_by(&with, |token, i| error(token, i) + if token * width + i == at { by } else { 0.0 }).0;
            let slope = (moved(0.05) - moved(-0.05)) / 0.1;
            assert!(
                (slope - f64::from(gradient[at])).abs() < 1e-3 * (1e-3 + slope.abs()),
                "{at}: {slope} {}",
                gradient[at]
            );
        }
    }

    #[test]
    fn a_gradient_that_is_not_finite_is_skipped_and_counted() {
        let mut trainer = trainer(0.0);
        trainer.step().unwrap();
        let (values, average) = (trainer.values.clone(), trainer.averaged().to_vec());
        let good: Vec<Vec<f32>> = trainer.data.training.iter().map(|sample| sample.tokens.clone()).collect();
        trainer.data.training.iter_mut().for_each(|sample| sample.tokens[5] = f32::NAN);
        assert_eq!(trainer.step().unwrap().step.skipped, 1);
        assert_eq!((&trainer.values, trainer.averaged()), (&values, average.as_slice()));
        trainer.data.training.iter_mut().zip(good).for_each(|(sample, tokens)| sample.tokens = tokens);
        let next = trainer.step().unwrap().step;
        assert!(next.skipped == 1 && next.loss.is_finite() && trainer.values != values);
    }
}
