//! An alignment as the one loop sees it, and its guard.

use std::sync::Arc;

use lifelike_checkpoint::Checkpoint;
use lifelike_report::ReportBuilder;
use lifelike_report::run::RunFolder;
use lifelike_robot::Robot;
use lifelike_train::{Budget, Scalar, Schedule, TrainingTask, Validation};

use super::{AlignPlan, Alignment};
use crate::GenerationError;
use crate::critic::Critic;
use crate::data::CaptionedMotion;
use crate::generator::{FILE, Generator, SampleOptions};
use crate::training::{GeneratorMetrics, GeneratorTrainer, TrainingData};

/// Denoising steps of the motions that Realism is measured on.
const STEPS: usize = 10;

/// Loss and Realism of the averaged weights.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Marks {
    loss: f64,
    realism: f64,
}

/// A generator on its way to what the critic promises well of.
#[derive(Debug)]
pub struct AlignTrainer {
    plan: AlignPlan,
    trainer: GeneratorTrainer,
    critic: Arc<Critic>,
    prompts: Vec<String>,
    /// Marks of the generator as it was.
    before: Marks,
    /// The most realistic weights whose loss is within the tolerance.
    best: (Marks, Generator),
    /// The last validation was beyond the tolerance.
    stopped: bool,
}

impl AlignTrainer {
    /// Returns an alignment that has not begun.
    ///
    /// # Errors
    /// A plan out of range; generator, critic, robot or motion that do not fit each other.
    pub fn new(
        plan: &AlignPlan,
        robot: &Robot,
        generator: Generator,
        critic: Critic,
        motions: &[CaptionedMotion],
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
        let before = Marks { loss: trainer.validation_loss()?, realism };
        Ok(Self { plan: plan.clone(), trainer, critic, prompts, before, best: (before, generator), stopped: false })
    }

    /// Returns loss and Realism before, and of the best weights.
    pub fn marks(&self) -> [[f64; 2]; 2] {
        [self.before, self.best.0].map(|marks| [marks.loss, marks.realism])
    }

    /// Returns whether the guard ended it.
    pub fn stopped(&self) -> bool {
        self.stopped
    }

    fn within(&self, loss: f64) -> bool {
        loss <= self.before.loss * (1.0 + self.plan.tolerance)
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

impl TrainingTask for AlignTrainer {
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
        let marks = Marks { loss: self.trainer.validation_loss()?, realism };
        let within = self.within(marks.loss);
        self.stopped = !within;
        if within && marks.realism > self.best.0.realism {
            self.best = (marks, generator);
        }
        let scalars = [
            ("Validation/loss", marks.loss),
            ("Validation/realism", marks.realism),
            ("Validation/within_tolerance", f64::from(u8::from(within))),
        ];
        let scalars = scalars.map(|(name, value)| (name.to_string(), value)).to_vec();
        Ok(Some(Validation { scalars, score: within.then_some(marks.realism) }))
    }

    fn checkpoint(&self) -> Result<Checkpoint, GenerationError> {
        let mut checkpoint = self.trainer.checkpoint()?;
        checkpoint.set_meta("align.plan", &AlignPlan { minutes: None, ..self.plan.clone() })?;
        let (best, generator) = &self.best;
        checkpoint.put_f64("align.best.marks", &[2], vec![best.loss, best.realism])?;
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
        self.best = (Marks { loss: marks[0], realism: marks[1] }, self.best.1.clone().with(values, iterations));
        Ok(())
    }

    fn finish(&mut self, folder: &RunFolder) -> Result<(), GenerationError> {
        self.best.1.save(&folder.path().join(FILE))
    }

    fn report(&self, report: ReportBuilder) -> ReportBuilder {
        let [before, best] = self.marks().map(|[loss, realism]| format!("loss {loss:.4}, Realism {realism:.3}"));
        report.fact("before", before).fact("best within the tolerance", best)
    }
}
