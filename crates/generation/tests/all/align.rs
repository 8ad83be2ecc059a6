//! An alignment raises what the critic promises, keeps its guard, and goes on bit for bit.

use std::path::PathBuf;

use lifelike_generation::GenerationError;
use lifelike_generation::align::{AlignPlan, AlignTrainer, JudgePlan, PhysicsJudge, PhysicsMarks};
use lifelike_generation::critic::{Critic, CriticData, CriticPlan, CriticTrainer, RewardRecords, StepEnd};
use lifelike_generation::data::CaptionedMotion;
use lifelike_generation::generator::{Generator, SampleOptions};
use lifelike_generation::representation::{RepresentationSpec, Standardizer};
use lifelike_generation::training::{GeneratorPlan, GeneratorTrainer, TrainingData};
use lifelike_robot::Robot;
use lifelike_train::TrainingTask;

fn clips() -> Vec<PathBuf> {
    vec![PathBuf::from("builtin")]
}

fn motions(robot: &Robot) -> Vec<CaptionedMotion> {
    CaptionedMotion::load(&clips(), robot, 3.0).unwrap()
}

fn generator(robot: &Robot, duration: bool) -> Generator {
    let plan = GeneratorPlan {
        clips: clips(),
        max_seconds: 3.0,
        width: 32,
        layers: 1,
        heads: 2,
        inner: 64,
        pieces: 200,
        batch: 8,
        iterations: 60,
        warmup: 5,
        learning_rate: 3e-3,
        diffusion_steps: 20,
        duration,
        ..GeneratorPlan::default()
    };
    let data = TrainingData::new(&plan, robot, &motions(robot)).unwrap();
    let mut trainer = GeneratorTrainer::new(plan, robot, data).unwrap();
    for _ in 0..60 {
        trainer.step().unwrap();
    }
    trainer.generator()
}

/// A critic that likes slow joints: the reward falls with their mean speed.
fn critic(robot: &Robot) -> Critic {
    let spec = RepresentationSpec::of(&robot.layout);
    let rows: Vec<_> = motions(robot).into_iter().map(|motion| motion.rows).collect();
    let names = (0..rows.len()).map(|i| format!("{i}")).collect();
    let mut records = RewardRecords::new(names, spec.fps, 1);
    for (m, motion) in rows.iter().enumerate() {
        for t in 0..motion.n - 1 {
            let speeds = &motion.row(t)[spec.velocities()];
            records.sequence.push(m as u32);
            records.frame.push(t as u32);
            records.reward.push(1.0 - speeds.iter().map(|v| v.abs()).sum::<f32>() / speeds.len() as f32);
            records.end.push(if t + 2 == motion.n { StepEnd::Truncated } else { StepEnd::Continues });
        }
    }
    let (robot, controller) = (robot.name.clone(), String::new());
    let data = CriticData { robot, controller, representation: spec, motions: rows, others: Vec::new(), records };
    let plan = CriticPlan { window: 0.1, hidden: vec![32], learning_rate: 3e-3, minibatch: 128, ..Default::default() };
    let mut trainer = CriticTrainer::new(&plan, 1, data).unwrap();
    for _ in 0..40 {
        trainer.epoch_once();
    }
    trainer.critic()
}

fn plan() -> AlignPlan {
    AlignPlan {
        robot: "lima".into(),
        generator: PathBuf::new(),
        critic: PathBuf::new(),
        clips: clips(),
        seed: 3,
        beta: 0.01,
        batch: 8,
        part: 3,
        iterations: 40,
        minutes: None,
        learning_rate: 1e-3,
        warmup: 0,
        max_gradient_norm: 1.0,
        ema: 0.9,
        condition_dropout: 0.1,
        validate_every: 10,
        tolerance: 10.0,
        prompts: 4,
        policy: None,
        judge: JudgePlan::default(),
    }
}

#[test]
fn alignment_raises_realism_within_the_tolerance_and_guidance_does_without_training() {
    let robot = Robot::load("lima").unwrap();
    let (generator, critic) = (generator(&robot, true), critic(&robot));
    let new = |plan: &AlignPlan| {
        AlignTrainer::new(plan, &robot, generator.clone(), critic.clone(), &motions(&robot), None).unwrap()
    };
    let steps = |trainer: &mut AlignTrainer<'_>, count: u64| {
        for _ in 0..count {
            trainer.step().unwrap();
            if trainer.iteration().is_multiple_of(10) {
                trainer.validate().unwrap();
            }
        }
    };
    let mut whole = new(&plan());
    steps(&mut whole, 40);
    let [before, after] = whole.marks();
    assert!(after.realism > before.realism + 0.1, "Realism {before:?} → {after:?}");

    let mut first = new(&plan());
    steps(&mut first, 20);
    let mut second = new(&plan());
    second.restore(&first.checkpoint().unwrap()).unwrap();
    steps(&mut second, 20);
    let bytes = |trainer: &AlignTrainer<'_>| trainer.checkpoint().unwrap().to_bytes().unwrap();
    assert!(bytes(&whole) == bytes(&second));

    // Only the critic, a large step, and no rise of the loss allowed: the guard ends it and the weights stay as they were.
    let mut guarded = new(&AlignPlan { beta: 10.0, learning_rate: 0.05, tolerance: 0.0, ..plan() });
    steps(&mut guarded, 10);
    assert!(guarded.stopped() && guarded.budget().is_spent(0.0));
    assert_eq!(guarded.marks()[0], guarded.marks()[1]);

    let options = SampleOptions { seconds: Some(2.0), candidates: 3, steps: Some(10), ..SampleOptions::default() };
    let realism = |strength: f64| {
        let motions = generator.sample_towards("a person walks", &options, Some((&critic, strength))).unwrap();
        motions.iter().map(|motion| critic.realism(&motion.rows).unwrap()).sum::<f64>()
    };
    assert!(realism(0.02) > realism(0.0) + 0.1, "{} {}", realism(0.02), realism(0.0));
    let free = generator.sample("a person walks", &options).unwrap();
    let unguided = generator.sample_towards("a person walks", &options, Some((&critic, 0.0))).unwrap();
    assert_eq!(free, unguided);
}

/// Falls less the further the weights are from where they began, up to a number of iterations.
#[derive(Debug)]
struct Turning(u64);

impl PhysicsJudge for Turning {
    fn judge(&self, generator: &Generator) -> Result<PhysicsMarks, GenerationError> {
        let off = generator.header().iterations.abs_diff(self.0) as f64;
        Ok(PhysicsMarks { falls: 0.1 + 0.01 * off, errors: [1.0; 5] })
    }
}

#[test]
fn the_weights_that_fall_least_are_kept_and_not_those_that_the_critic_praises_most() {
    let robot = Robot::load("lima").unwrap();
    let generator = generator(&robot, true);
    let judge = Some(Box::new(Turning(20)) as Box<dyn PhysicsJudge>);
    let motions = motions(&robot);
    let mut trainer = AlignTrainer::new(&plan(), &robot, generator, critic(&robot), &motions, judge).unwrap();
    for _ in 0..40 {
        trainer.step().unwrap();
        if trainer.iteration().is_multiple_of(10) {
            trainer.validate().unwrap();
        }
    }
    let [_, best] = trainer.marks();
    assert!((best.physics.unwrap().falls - 0.1).abs() < 1e-12, "{best:?}");
    let checkpoint = trainer.checkpoint().unwrap();
    assert_eq!(checkpoint.u64s("align.best.iterations", &[1]).unwrap(), [20]);
}

/// Generators of before there was that token.
#[test]
fn one_that_is_not_told_the_duration_is_aligned_too() {
    let robot = Robot::load("lima").unwrap();
    let generator = generator(&robot, false);
    assert!(!generator.header().sizes.duration);
    let mut trainer = AlignTrainer::new(&plan(), &robot, generator, critic(&robot), &motions(&robot), None).unwrap();
    assert!(trainer.step().unwrap().step.loss.is_finite());
}

#[test]
fn a_critic_of_another_robot_is_refused() {
    let robot = Robot::load("lima").unwrap();
    let other = CriticData {
        robot: "post".into(),
        controller: String::new(),
        representation: RepresentationSpec::new(vec!["knee".into()]),
        motions: vec![lifelike_generation::representation::FeatureMatrix::new(vec![0.5; 90], 9).unwrap()],
        others: Vec::new(),
        records: RewardRecords {
            sequence: vec![0],
            frame: vec![0],
            reward: vec![1.0],
            end: vec![StepEnd::Continues],
            ..RewardRecords::new(vec!["a".into()], 50.0, 1)
        },
    };
    let critic = CriticTrainer::new(&CriticPlan::default(), 1, other).unwrap().critic();
    assert_eq!(critic.header().standardizer.std, vec![Standardizer::FLOOR as f32; 9]);
    let error = AlignTrainer::new(&plan(), &robot, generator(&robot, true), critic, &motions(&robot), None)
        .unwrap_err()
        .to_string();
    assert!(error.contains("rows for the critic") && error.contains("knee"), "{error}");
}
