//! Robots, motions, plans and numbers that all tables have in common.

use std::collections::BTreeMap;
use std::error::Error;
use std::fmt;
use std::path::PathBuf;
use std::sync::Arc;

use lifelike_augmentation::model::{Backbone, SatSizes};
use lifelike_augmentation::references::random::RandomSpec;
use lifelike_augmentation::references::{authored, random};
use lifelike_augmentation::replay::{Measuring, on_twin};
use lifelike_augmentation::training::{AugmentationPlan, AugmentationTrainer, FeedbackShares};
use lifelike_augmentation::{Augmentation, AugmentationError, Feedback, gap};
use lifelike_robot::Robot;
use lifelike_sim::trace::Trace;
use lifelike_sim::twin::TwinSpec;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::sheet::Cells;

pub const SERVO: &str = "xm430";
pub const BODY: &str = "body";
/// Columns of a body's place.
pub const PLACE: [&str; 3] = ["position_x", "position_y", "position_z"];
/// Length of a run (s), as in the thesis.
const SECONDS: f64 = 30.0;

pub type Outcome<T> = Result<T, Box<dyn Error>>;

/// Tests by name.
pub type Tests = Vec<(&'static str, Vec<Trace>)>;

/// Size of an experiment.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Settings {
    pub iterations: u64,
    pub seeds: u64,
    pub runs: usize,
}

/// Form of network and training.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Form {
    /// The thesis' inputs; its encoder always gets an error, measured or its own prediction in a closed loop.
    Thesis,
    /// The thesis' inputs; trained with measured errors alone.
    Forced,
    /// Play operators, the last measured error carried over, and stretches in which nothing is fed back.
    Ours,
}

impl Form {
    pub const ALL: [Self; 3] = [Self::Thesis, Self::Forced, Self::Ours];

    pub fn name(self) -> &'static str {
        match self {
            Self::Thesis => "thesis",
            Self::Forced => "teacher forcing",
            Self::Ours => "ours",
        }
    }

    /// A plan in this form.
    pub fn of(self, plan: AugmentationPlan) -> AugmentationPlan {
        let thesis = |feedback| AugmentationPlan {
            hysteresis: Vec::new(),
            model: SatSizes { carry: false, ..plan.model },
            feedback,
            ..plan.clone()
        };
        match self {
            Self::Thesis => thesis(FeedbackShares::THESIS),
            Self::Forced => thesis(FeedbackShares { measured: 1.0, predicted: 0.0, ramp: 0.0 }),
            Self::Ours => plan,
        }
    }

    /// Feedback in tests: the thesis feeds actuators measurements, bodies their own predictions or nothing.
    pub fn feedbacks(self, class: &str) -> Vec<Feedback> {
        match (self, class == BODY) {
            (Self::Ours, true) => vec![Feedback::None, Feedback::Predicted],
            (Self::Ours, false) => vec![Feedback::None, Feedback::Predicted, Feedback::Measured],
            (_, true) => vec![Feedback::Predicted],
            (_, false) => vec![Feedback::Predicted, Feedback::Measured],
        }
    }
}

/// Words of a feedback.
pub fn fed(feedback: Feedback) -> &'static str {
    match feedback {
        Feedback::None => "nothing fed back",
        Feedback::Predicted => "own predictions",
        Feedback::Measured => "measured",
    }
}

pub fn robot(name: &str) -> Outcome<Arc<Robot>> {
    let file = format!("{}/../robots/{name}.xml", env!("CARGO_MANIFEST_DIR"));
    Ok(Arc::new(Robot::load(&file)?))
}

/// The twin of a robot: KickBot is one robot wherever it is attached, DanceBot another.
fn twin(name: &str) -> TwinSpec {
    TwinSpec { seed: if name == "dancebot" { 2 } else { 1 }, ..TwinSpec::default() }
}

fn measuring(bodies: bool) -> Measuring {
    Measuring { bodies: bodies.then(|| BODY.into()), ..Measuring::default() }
}

/// Random motions of a robot.
pub fn random_runs(name: &str, runs: usize, seed: u64, bodies: bool) -> Outcome<Vec<Trace>> {
    let robot = robot(name)?;
    let spec = RandomSpec { seed, runs, seconds: SECONDS, ..RandomSpec::default() };
    Ok(on_twin(&random::draw(&robot, &spec)?, &robot, &robot, &twin(name), &measuring(bodies))?)
}

/// Motions for training and for choosing the best weights: random ones of KickBot, never the tests'.
pub fn training(settings: Settings, bodies: bool) -> Outcome<[Vec<Trace>; 2]> {
    Ok([random_runs("kickbot", settings.runs, 1, bodies)?, random_runs("kickbot", 5, 2, bodies)?])
}

/// Authored motions of a robot, in the nominal simulation of `nominal`.
pub fn authored_runs(name: &str, nominal: &Arc<Robot>, speed: f64, bodies: bool) -> Outcome<Vec<Trace>> {
    let robot = robot(name)?;
    let folder = format!("{}/../experiments/poses/{name}", env!("CARGO_MANIFEST_DIR"));
    let mut files: Vec<PathBuf> =
        std::fs::read_dir(folder)?.map(|entry| Ok(entry?.path())).collect::<Result<_, std::io::Error>>()?;
    files.sort();
    let load = |file: &PathBuf| authored::load(file, &robot, SECONDS, speed);
    let references = files.iter().map(load).collect::<Result<Vec<_>, _>>()?;
    Ok(on_twin(&references, nominal, &robot, &twin(name), &measuring(bodies))?)
}

pub fn tests(bodies: bool) -> Outcome<Tests> {
    let own = |name: &'static str| Ok((name, authored_runs(name, &robot(name)?, 1.0, bodies)?));
    match bodies {
        true => ["kickbot", "kickbot_foot"].into_iter().map(own).collect(),
        false => ["kickbot", "kickbot_foot", "dancebot"].into_iter().map(own).collect(),
    }
}

/// The four architectures of Table 2.1.
pub fn architectures() -> [(&'static str, SatSizes); 4] {
    let own = |backbone, attention| SatSizes { backbone, attention, ..SatSizes::default() };
    [
        ("LSTM", own(Backbone::Lstm, false)),
        ("attention", own(Backbone::None, true)),
        ("attention + dense", own(Backbone::Dense, true)),
        ("SAT", own(Backbone::Lstm, true)),
    ]
}

pub fn plan(class: &str, outputs: &[&str], settings: Settings, seed: u64) -> AugmentationPlan {
    AugmentationPlan {
        seed,
        class: class.into(),
        outputs: outputs.iter().map(|name| (*name).to_string()).collect(),
        iterations: settings.iterations,
        validate_every: (settings.iterations / 5).max(1),
        ..AugmentationPlan::default()
    }
}

pub fn train(plan: &AugmentationPlan, [learn, validation]: &[Vec<Trace>; 2]) -> Outcome<Augmentation> {
    let mut trainer = AugmentationTrainer::new(plan, learn, validation)?;
    for _ in 0..plan.iterations {
        trainer.iterate();
        if trainer.iteration().is_multiple_of(plan.validate_every) {
            trainer.validate_once();
        }
    }
    Ok(trainer.augmentation())
}

pub fn corrected(own: &Augmentation, traces: &[Trace], feedback: Feedback) -> Result<Vec<Trace>, AugmentationError> {
    traces.par_iter().map(|trace| own.corrected(trace, feedback)).collect()
}

/// MAE and largest error of a column, with standard deviations over blocks and runs, or over seeds; concordance correlation.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Numbers {
    pub mae: [f64; 2],
    pub max: [f64; 2],
    pub ccc: f64,
}

impl fmt::Display for Numbers {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { mae, max, ccc } = self;
        write!(f, "{:.3} ±{:.3} max {:.3} ±{:.3} CCC {ccc:.3}", mae[0], mae[1], max[0], max[1])
    }
}

/// Numbers of a column in degrees, millimetres or amperes.
pub fn numbers(traces: &[Trace], class: &str, column: &str) -> Outcome<Numbers> {
    let gaps: Vec<gap::Gap> = traces.iter().flat_map(gap::gaps).filter(|gap| gap.class == class).collect();
    let summary = gap::summary(&gaps);
    let factor = match column {
        gap::PLACE => 1e3,
        "current" => 1.0,
        _ => 1_f64.to_degrees(),
    };
    let own = summary.iter().find(|own| own.column == column);
    let own = own.ok_or_else(|| format!("expected a measured column '{column}' of class '{class}', got none"))?;
    Ok(Numbers { mae: own.mae.map(|x| factor * x), max: own.max.map(|x| factor * x), ccc: own.ccc[0] })
}

pub fn over_seeds(all: &[Numbers]) -> Numbers {
    let spread = |of: fn(&Numbers) -> f64| {
        let mean = all.iter().map(of).sum::<f64>() / all.len() as f64;
        [mean, (all.iter().map(|n| (of(n) - mean).powi(2)).sum::<f64>() / all.len() as f64).sqrt()]
    };
    let ccc = all.iter().map(|n| n.ccc).sum::<f64>() / all.len() as f64;
    Numbers { mae: spread(|n| n.mae[0]), max: spread(|n| n.max[0]), ccc }
}

/// Numbers of the plain simulation.
pub fn simulation(tests: &Tests, class: &str, column: &str) -> Outcome<Cells> {
    tests.iter().map(|(name, traces)| Ok(((*name).to_string(), numbers(traces, class, column)?))).collect()
}

/// Numbers of some networks, one a seed, with one feedback.
pub fn tested(
    networks: &[Augmentation],
    tests: &Tests,
    feedback: Feedback,
    class: &str,
    column: &str,
) -> Outcome<Cells> {
    let mut cells = BTreeMap::new();
    for (test, traces) in tests {
        let of = |own: &Augmentation| numbers(&corrected(own, traces, feedback)?, class, column);
        let all = networks.iter().map(of).collect::<Outcome<Vec<_>>>()?;
        cells.insert((*test).to_string(), over_seeds(&all));
    }
    Ok(cells)
}

/// Trains a form with every seed.
pub fn trained(
    form: Form,
    settings: Settings,
    data: &[Vec<Trace>; 2],
    one: impl Fn(u64) -> AugmentationPlan,
) -> Outcome<Vec<Augmentation>> {
    (0..settings.seeds).map(|seed| train(&form.of(one(seed)), data)).collect()
}
