//! Everything measured of one method.

use std::collections::BTreeMap;

use lifelike_evaluation::ThesisErrors;
use lifelike_generation::critic::Critic;
use lifelike_generation::evaluator::{Evaluator, caption_kinds};
use lifelike_generation::metrics::{Embeddings, Gaussian, Interval, Sample, Scores};
use lifelike_generation::representation::{FeatureMatrix, RepresentationSpec};
use lifelike_language::Entry;
use lifelike_language::checks::{Finding, Tracks, check};
use lifelike_language::facts::HeldOut;
use lifelike_language::grammar::Grammar;
use lifelike_motion::MotionClip;
use lifelike_motion::plausibility::Plausibility;
use lifelike_robot::Robot;
use serde::Serialize;

use super::language::Checks;
use super::task::Task;
use lifelike::CliError;

/// One motion, and what of it can be told without the others.
pub struct Motion {
    /// The motion itself, where a tracker is to follow it.
    pub clip: Option<MotionClip>,
    rows: FeatureMatrix,
    realism: Option<f64>,
    findings: Vec<Finding>,
    plausibility: Plausibility,
}

/// A motion that does not show what its sentence promises.
#[derive(Debug, Serialize)]
pub struct Failure {
    file: String,
    prompt: String,
    repetition: usize,
    findings: Vec<Finding>,
}

/// One method's numbers.
#[derive(Debug, Serialize)]
pub struct Measured {
    /// Name.
    pub name: String,
    /// Motions of each sentence: the data set has one, methods one in each repetition.
    pub motions_of_each: usize,
    /// Metrics of the evaluator; none without one, or where all sentences are the same.
    pub scores: Option<Scores>,
    /// The critic's mean value.
    pub realism: Option<Interval>,
    /// The same of every motion.
    pub realism_of_each: Vec<f64>,
    /// Exact checks.
    pub checks: Checks,
    /// The same of what entries are held out for, where they are.
    pub checks_of_held_out: BTreeMap<&'static str, Checks>,
    /// Errors of the tracker that follows the motions, by the thesis' protocol (Table 5.3).
    pub tracking: Option<ThesisErrors>,
    /// Plausibility, weighted by duration.
    pub plausibility: Option<Plausibility>,
    /// Time to make all motions and measure each (s).
    pub seconds: Option<f64>,
    /// Checks that failed.
    pub failed: Vec<Failure>,
}

/// Measures motions.
pub struct Ruler<'a> {
    /// The robot.
    pub robot: &'a Robot,
    /// Layout of the rows.
    pub spec: &'a RepresentationSpec,
    /// Embeds.
    pub evaluator: Option<&'a Evaluator>,
    /// Tells Realism.
    pub critic: Option<&'a Critic>,
    /// Meaning of verbs.
    pub grammar: Grammar,
    /// Embeddings of the whole split, for the FID.
    pub reference: Option<Gaussian>,
    /// Flag: motions keep their clips, for a tracker.
    pub keep_clips: bool,
    /// Key of pools and pairs.
    pub seed: u64,
    /// Number of repetitions.
    pub repetitions: u64,
}

impl Ruler<'_> {
    /// Measures one motion of an entry's sentence.
    pub fn motion(&self, clip: &MotionClip, entry: &Entry) -> Result<Motion, CliError> {
        let (character, anatomy) = (&self.robot.character, &self.robot.anatomy);
        let rows = FeatureMatrix::from_clip(clip, self.spec)?;
        let findings = match &entry.facts {
            Some(facts) => check(&Tracks::of(clip, character, anatomy)?, &self.grammar, facts)?,
            None => Vec::new(),
        };
        Ok(Motion {
            realism: self.critic.map(|critic| critic.realism(&rows)).transpose()?,
            clip: self.keep_clips.then(|| clip.clone()),
            findings,
            plausibility: Plausibility::of(clip, character, anatomy, &self.robot.speeds())?,
            rows,
        })
    }

    /// Measures motions of all tasks, repetition after repetition, or one repetition that stands for all.
    pub fn measure(
        &self,
        name: &str,
        tasks: &[Task],
        motions: &[Motion],
        seconds: Option<f64>,
    ) -> Result<Measured, CliError> {
        let (mut checks, mut of_held_out, mut failed) = (Checks::default(), BTreeMap::new(), Vec::new());
        for (i, motion) in motions.iter().enumerate() {
            let (task, repetition) = (&tasks[i % tasks.len()], i / tasks.len());
            checks.add(&motion.findings);
            if let Some(held_out) = task.entry.facts.as_ref().and_then(|facts| facts.held_out) {
                let name = match held_out {
                    HeldOut::Combination => "unseen combinations",
                    HeldOut::Words => "unseen words",
                };
                of_held_out.entry(name).or_insert_with(Checks::default).add(&motion.findings);
            }
            let findings: Vec<Finding> = motion.findings.iter().filter(|finding| !finding.passed).cloned().collect();
            if !findings.is_empty() {
                let (file, prompt) = (task.entry.file.clone(), task.prompt().to_string());
                failed.push(Failure { file, prompt, repetition, findings });
            }
        }
        let plausibility: Vec<Plausibility> = motions.iter().map(|motion| motion.plausibility.clone()).collect();
        let realism_of_each: Vec<f64> = motions.iter().filter_map(|motion| motion.realism).collect();
        let means = realism_of_each.chunks(tasks.len().max(1)).map(|all| all.iter().sum::<f64>() / all.len() as f64);
        let means: Vec<f64> = means.collect();
        Ok(Measured {
            name: name.into(),
            motions_of_each: motions.len() / tasks.len().max(1),
            scores: match self.evaluator {
                Some(evaluator) if !tasks.is_empty() => self.scores(evaluator, tasks, motions)?,
                _ => None,
            },
            realism: (!means.is_empty()).then(|| Interval::of(&means)),
            realism_of_each,
            checks,
            checks_of_held_out: of_held_out,
            tracking: None,
            plausibility: Plausibility::mean(&plausibility),
            seconds,
            failed,
        })
    }

    /// Returns the evaluator's metrics. The motions of a sentence in all repetitions are those of its multimodality.
    fn scores(&self, evaluator: &Evaluator, tasks: &[Task], motions: &[Motion]) -> Result<Option<Scores>, CliError> {
        let prompts: Vec<&str> = tasks.iter().map(Task::prompt).collect();
        let rows: Vec<FeatureMatrix> = motions.iter().map(|motion| motion.rows.clone()).collect();
        let (text, all) = (evaluator.sentences(&prompts)?, evaluator.motions(&rows)?);
        let each = motions.len() / tasks.len();
        let of = |which: &mut dyn Iterator<Item = usize>| {
            Embeddings::new(which.flat_map(|i| all.row(i).to_vec()).collect(), all.width())
        };
        let by_sentence = &mut (0..tasks.len()).flat_map(|task| (0..each).map(move |r| r * tasks.len() + task));
        let repeated = if each > 1 { Some((of(by_sentence)?, each)) } else { None };
        let kinds = caption_kinds(prompts);
        Ok(Scores::of(self.reference.as_ref(), self.repetitions, self.seed, |repetition| {
            let first = repetition as usize % each * tasks.len();
            let motion = of(&mut (first..first + tasks.len()))?;
            Ok(Sample { text: text.clone(), motion, kinds: kinds.clone(), repeated: repeated.clone() })
        })?)
    }
}
