//! An alignment as the one loop sees it, and its guard.

use std::sync::Arc;

use lifelike_checkpoint::Checkpoint;
use lifelike_report::ReportBuilder;
use lifelike_report::run::RunFolder;
use lifelike_robot::Robot;
use lifelike_train::{Budget, Scalar, Schedule, TrainingTask, Validation};

use super::{AlignPlan, Alignment, PhysicsJudge, PhysicsMarks};
use crate::critic::Critic;
use crate::data::CaptionedMotion;
use crate::generator::{FILE, Generator, SampleOptions};
use crate::training::{GeneratorMetrics, GeneratorTrainer, TrainingData};
use crate::{FromInput, GenerationError};

/// Denoising steps of the motions that Realism is measured on.
const STEPS: usize = 10;

/// Marks of the averaged weights.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AlignMarks {
    /// The generator's own loss on motion that it is not trained on.
    pub loss: f64,
    /// The critic's mean value.
    pub realism: f64,
    /// The judge's marks, where there is one.
    pub physics: Option<PhysicsMarks>,
}

impl AlignMarks {
    /// Returns what the guard compares, higher is better: by physics relative to `before`, else Realism.
    fn score(&self, before: &Self) -> f64 {
        match (&self.physics, &before.physics) {
            (Some(physics), Some(before)) => -physics.relative_to(before),
            _ => self.realism,
        }
    }

    /// Returns loss, Realism and share of falls in a few words.
    pub fn words(&self) -> String {
        let falls = self.physics.map_or(String::new(), |physics| format!(", falls {:.1}%", 100.0 * physics.falls));
        format!("loss {:.4}, Realism {:.3}{falls}", self.loss, self.realism)
    }

    /// Returns true for a loss within a tolerance of `before`, and a better score than the best so far.
    fn improves(&self, best: &Self, before: &Self, tolerance: f64) -> bool {
        self.loss <= before.loss * (1.0 + tolerance) && self.score(before) > best.score(before)
    }
}

/// A generator on its way to what the critic promises well of.
#[derive(Debug)]
pub struct AlignTrainer<'a> {
    plan: AlignPlan,
    trainer: GeneratorTrainer,
    critic: Arc<Critic>,
    judge: Option<Box<dyn PhysicsJudge + 'a>>,
    prompts: Vec<String>,
    /// Marks of the generator as it was.
    before: AlignMarks,
    /// The best weights whose loss is within the tolerance.
    best: (AlignMarks, Generator),
    /// The last validation was beyond the tolerance.
    stopped: bool,
}

impl<'a> AlignTrainer<'a> {
    /// Returns an alignment that has not begun. The judge chooses the best weights; without one the critic does.
    ///
    /// # Errors
    /// A plan out of range; the judge fails; generator, critic, robot or motion that do not fit each other.
    pub fn new(
        plan: &AlignPlan,
        robot: &Robot,
        generator: Generator,
        critic: Critic,
        motions: &[CaptionedMotion],
        judge: Option<Box<dyn PhysicsJudge + 'a>>,
    ) -> Result<Self, GenerationError> {
        critic.check(&generator.header().spec)?;
        let training = plan.training(generator.header())?;
        let data = TrainingData::of_generator(&generator, robot, motions)?;
        let stride = data.captions.len().div_ceil(plan.prompts).max(1);
        let prompts: Vec<String> = data.captions.iter().step_by(stride).cloned().collect();
        let critic = Arc::new(critic);
        let alignment = Alignment { surrogate: critic.clone(), beta: plan.beta };
        let trainer = GeneratorTrainer::new(training, robot, data)?.aligned(&generator, alignment)?;
        let realism = realism(&generator, &critic, &prompts, plan.seed)?;
        let physics = judge.as_ref().map(|judge| judge.judge(&generator)).transpose()?;
        let before = AlignMarks { loss: trainer.validation_loss()?, realism, physics };
        let best = (before, generator);
        Ok(Self { plan: plan.clone(), trainer, critic, judge, prompts, before, best, stopped: false })
    }

    /// Returns the marks before, and those of the best weights.
    pub fn marks(&self) -> [AlignMarks; 2] {
        [self.before, self.best.0]
    }

    /// Returns whether the guard ended it.
    pub fn stopped(&self) -> bool {
        self.stopped
    }
}

/// Returns the mean value over the rows of motions of prompts, by few steps without added noise.
fn realism(generator: &Generator, critic: &Critic, prompts: &[String], seed: u64) -> Result<f64, GenerationError> {
    let steps = Some(STEPS.min(generator.header().diffusion_steps));
    let options = SampleOptions { seed, steps, eta: 0.0, ..SampleOptions::default() };
    let mut sum = 0.0;
    for prompt in prompts {
        for motion in generator.sample(prompt, &options)? {
            sum += critic.realism(&motion.rows)?;
        }
    }
    Ok(sum / prompts.len() as f64)
}

impl TrainingTask for AlignTrainer<'_> {
    type Metrics = GeneratorMetrics;
    type Error = GenerationError;

    fn iteration(&self) -> u64 {
        self.trainer.iteration()
    }

    fn budget(&self) -> Budget {
        let budget = TrainingTask::budget(&self.trainer);
        if self.stopped { Budget { total: budget.done, ..budget } } else { budget }
    }

    fn schedule(&self) -> Schedule {
        TrainingTask::schedule(&self.trainer)
    }

    fn identity(&self) -> Vec<(&'static str, String)> {
        let header = self.critic.header();
        let critic = format!("of controller {}, {} control steps", header.controller, header.steps);
        [TrainingTask::identity(&self.trainer), vec![("critic", critic)]].concat()
    }

    fn step(&mut self) -> Result<GeneratorMetrics, GenerationError> {
        self.trainer.step()
    }

    fn scalars(&self, metrics: &GeneratorMetrics) -> Vec<Scalar> {
        self.trainer.scalars(metrics)
    }

    fn validate(&mut self) -> Result<Option<Validation>, GenerationError> {
        let generator = self.trainer.generator();
        let realism = realism(&generator, &self.critic, &self.prompts, self.plan.seed)?;
        let physics = self.judge.as_ref().map(|judge| judge.judge(&generator)).transpose()?;
        let marks = AlignMarks { loss: self.trainer.validation_loss()?, realism, physics };
        let within = marks.loss <= self.before.loss * (1.0 + self.plan.tolerance);
        self.stopped = !within;
        if marks.improves(&self.best.0, &self.before, self.plan.tolerance) {
            self.best = (marks, generator);
        }
        let mut scalars = vec![
            ("Validation/loss", marks.loss),
            ("Validation/realism", marks.realism),
            ("Validation/within_tolerance", f64::from(u8::from(within))),
        ];
        if let Some(PhysicsMarks { falls, errors: [linear, angular, rotation, upper, lower] }) = marks.physics {
            scalars.extend([
                ("Validation/falls", falls),
                ("Validation/root_velocity_error", linear),
                ("Validation/root_angular_velocity_error", angular),
                ("Validation/root_rotation_error_deg", rotation),
                ("Validation/upper_joint_error_deg", upper),
                ("Validation/lower_joint_error_deg", lower),
            ]);
        }
        // Errors of what falls at once are no numbers.
        let scalars = scalars.into_iter().filter(|(_, value)| value.is_finite());
        let scalars = scalars.map(|(name, value)| (name.to_string(), value)).collect();
        let score = marks.score(&self.before);
        Ok(Some(Validation { scalars, score: (within && score.is_finite()).then_some(score) }))
    }

    fn checkpoint(&self) -> Result<Checkpoint, GenerationError> {
        let mut checkpoint = self.trainer.checkpoint()?;
        checkpoint.set_meta("align.plan", &AlignPlan { minutes: None, ..self.plan.clone() })?;
        let (best, generator) = &self.best;
        checkpoint.put_f64("align.best.marks", &[2], vec![best.loss, best.realism])?;
        if let Some(physics) = &best.physics {
            checkpoint.put_f64("align.best.physics", &[6], physics.row().to_vec())?;
        }
        checkpoint.put_u64("align.best.iterations", &[1], vec![generator.header().iterations])?;
        checkpoint.put_u8("align.stopped", &[1], vec![u8::from(self.stopped)])?;
        checkpoint.put_f32("align.best.network", &[generator.values().len()], generator.values().to_vec())?;
        Ok(checkpoint)
    }

    fn restore(&mut self, checkpoint: &Checkpoint) -> Result<(), GenerationError> {
        let plan: AlignPlan = checkpoint.meta("align.plan")?;
        if plan != (AlignPlan { minutes: None, ..self.plan.clone() }) {
            let what = format!("{}: plan", checkpoint.origin());
            return Err(GenerationError::mismatch(what, "the plan of this run", "another"));
        }
        self.trainer.restore(checkpoint)?;
        let marks = checkpoint.f64s("align.best.marks", &[2])?;
        let iterations = checkpoint.u64s("align.best.iterations", &[1])?[0];
        let values = checkpoint.f32s("align.best.network", &[self.best.1.values().len()])?;
        self.stopped = checkpoint.u8s("align.stopped", &[1])?[0] != 0;
        let physics = match checkpoint.contains("align.best.physics") {
            true => <[f64; 6]>::try_from(checkpoint.f64s("align.best.physics", &[6])?).ok().map(PhysicsMarks::of_row),
            false => None,
        };
        let marks = AlignMarks { loss: marks[0], realism: marks[1], physics };
        self.best = (marks, self.best.1.clone().with(values, iterations));
        Ok(())
    }

    fn finish(&mut self, folder: &RunFolder) -> Result<(), GenerationError> {
        self.best.1.save(&folder.path().join(FILE))
    }

    fn report(&self, report: ReportBuilder) -> ReportBuilder {
        let [before, best] = self.marks().map(|marks| marks.words());
        report.fact("before", before).fact("best within the tolerance", best)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn physics_chooses_within_the_tolerance_and_realism_only_without_it() {
        let marks = |loss, realism, falls: Option<f64>| {
            let physics = falls.map(|falls| PhysicsMarks { falls, errors: [1.0; 5] });
            AlignMarks { loss, realism, physics }
        };
        let before = marks(1.0, 30.0, Some(0.7));
        let praised = marks(1.05, 37.0, Some(0.8));
        let calmer = marks(1.05, 31.0, Some(0.4));
        assert!(!praised.improves(&before, &before, 0.1) && calmer.improves(&before, &before, 0.1));
        assert!(!marks(1.11, 31.0, Some(0.1)).improves(&before, &before, 0.1), "beyond the tolerance of the loss");
        assert!(!before.improves(&before, &before, 0.1));
        // (0.4 / 0.7 + 1) / 2 = 0.786.
        assert!((calmer.score(&before) + 0.785_714).abs() < 1e-6);
        let before = marks(1.0, 30.0, None);
        assert!(marks(1.05, 37.0, None).improves(&before, &before, 0.1));
    }
}
