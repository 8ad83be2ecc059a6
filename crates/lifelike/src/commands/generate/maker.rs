//! Sentences to ranked candidates.

use std::path::Path;
use std::sync::Arc;

use lifelike_generation::critic::{Critic, RewardSurrogate};
use lifelike_generation::generator::{Generated, Generator, Given, SampleOptions, join};
use lifelike_generation::representation::FeatureMatrix;
use lifelike_motion::edit::joints_of;
use lifelike_motion::{Caption, MotionClip};
use lifelike_robot::Robot;

use super::softened::softened;
use super::spoken::PartReport;
use super::verdict::Verdict;
use crate::commands::clips;
use crate::error::CliError;

/// A continuation begins with the last seconds of what was before (s).
const OVERLAP: f64 = 0.6;
/// Distance of the seeds of two parts, of which the second goes on from the first.
const NEXT_SEED: u64 = 0x9E37_79B9_7F4A_7C15;

/// Networks and options that motions are made with.
pub struct Maker {
    /// The robot.
    pub robot: Arc<Robot>,
    /// The generator.
    pub generator: Generator,
    /// The critic that ranks, where there is one.
    pub critic: Option<Critic>,
    /// Strength by which it guides too.
    pub strength: f64,
    /// Settings of one part.
    pub options: SampleOptions,
    /// Part of a clip, or poses, that every candidate keeps.
    pub kept: Option<Kept>,
}

/// A part of the body kept from a clip, or poses.
pub struct Kept {
    given: Given,
    words: String,
    licence: String,
}

/// One motion with its verdict.
pub struct Candidate {
    /// The clip.
    pub clip: MotionClip,
    /// Verdict on it.
    pub verdict: Verdict,
    /// Number among the candidates.
    pub candidate: usize,
    /// Its clauses, where it is of a script.
    pub parts: Vec<PartReport>,
}

impl Kept {
    /// Returns what is given of a motion, in words, under a licence.
    pub fn new(given: Given, words: String, licence: String) -> Self {
        Self { given, words, licence }
    }

    /// Reads a part of the body (`legs`, `arms`) of a clip, with the root where that part carries it. Returns it with
    /// the duration of the clip (s), at most the longest of the generator.
    pub fn read(
        file: &Path,
        part: &str,
        root: bool,
        robot: &Robot,
        generator: &Generator,
    ) -> Result<(Self, f64), CliError> {
        let clip = clips::load_one(file, robot)?;
        let spec = &generator.header().spec;
        let rows = FeatureMatrix::from_clip(&clip, spec)?;
        let seconds = (rows.n.saturating_sub(1) as f64 / spec.fps).min(generator.header().max_seconds);
        let joints = joints_of(&robot.character, &robot.anatomy, &[part.to_string()])?;
        let given = Given::joints(rows, spec, &joints, root)?;
        let words = format!("the {part} of '{}'", clip.name);
        Ok((Self { given, words, licence: clip.provenance.licence }, seconds))
    }
}

impl Maker {
    /// Returns candidates of sentences that follow each other, the best first.
    pub fn make(&self, prompts: &[String]) -> Result<Vec<Candidate>, CliError> {
        let (all, ends) = self.rows(prompts)?;
        Ok(ranked(all.iter().map(|one| self.finish(one, prompts, &ends)).collect::<Result<_, _>>()?))
    }

    /// Returns candidates of one sentence with its own seed and duration (s), the best first.
    pub fn clauses(
        &self,
        sentence: &str,
        seconds: Option<f64>,
        seed: u64,
        candidates: usize,
    ) -> Result<Vec<Candidate>, CliError> {
        let prompts = [sentence.to_string()];
        let options = SampleOptions { seconds, seed, candidates, ..self.options };
        let (all, ends) = self.rows_with(&prompts, options)?;
        Ok(ranked(all.iter().map(|one| self.finish(one, &prompts, &ends)).collect::<Result<_, _>>()?))
    }

    /// Returns candidates after their motion was changed, the best first.
    pub fn projected(
        &self,
        candidates: Vec<Candidate>,
        change: impl Fn(&[MotionClip]) -> Result<Vec<MotionClip>, CliError>,
    ) -> Result<Vec<Candidate>, CliError> {
        let (clips, others): (Vec<_>, Vec<_>) =
            candidates.into_iter().map(|one| (one.clip, (one.candidate, one.parts))).unzip();
        let judge = |((clip, asked), (candidate, parts)): ((MotionClip, &MotionClip), (usize, Vec<PartReport>))| {
            let rows = FeatureMatrix::from_clip(&clip, &self.generator.header().spec)?;
            let mut verdict = Verdict::of(&clip, &rows, &self.robot, self.critic.as_ref())?;
            verdict.softened = softened(asked, &clip, &self.robot)?;
            Ok(Candidate { clip, verdict, candidate, parts })
        };
        let changed = change(&clips)?.into_iter().zip(&clips).zip(others);
        Ok(ranked(changed.map(judge).collect::<Result<_, CliError>>()?))
    }

    /// Returns rows of every candidate, and where the parts end (s).
    fn rows(&self, prompts: &[String]) -> Result<(Vec<Generated>, Vec<f64>), CliError> {
        self.rows_with(prompts, self.options)
    }

    fn rows_with(&self, prompts: &[String], settings: SampleOptions) -> Result<(Vec<Generated>, Vec<f64>), CliError> {
        let header = self.generator.header();
        let guide = self.critic.as_ref().filter(|_| self.strength != 0.0);
        let guide = guide.map(|critic| (critic as &dyn RewardSurrogate, self.strength));
        let mut all: Vec<Generated> = Vec::new();
        let mut ends = Vec::with_capacity(prompts.len());
        for (part, prompt) in prompts.iter().enumerate() {
            let mut options = settings;
            options.seed = options.seed.wrapping_add(NEXT_SEED.wrapping_mul(part as u64));
            let before = all.first().map_or(0, |first| first.rows.n);
            let seconds = OVERLAP.min(header.max_seconds / 2.0);
            let overlap = ((seconds * header.spec.fps).round() as usize + 1).min(before);
            if before == 0 {
                let kept = self.kept.as_ref().map(|kept| vec![kept.given.clone(); options.candidates]);
                all = self.generator.sample_given(prompt, &options, guide, &kept.unwrap_or_default())?;
            } else {
                let asked = options.seconds.unwrap_or_else(|| self.generator.seconds(prompt));
                options.seconds = Some((asked + overlap as f64 / header.spec.fps).min(header.max_seconds));
                let given = all.iter().map(|one| tail(&one.rows, overlap).map(Given::Beginning));
                let given = given.collect::<Result<Vec<_>, CliError>>()?;
                let next = self.generator.sample_given(prompt, &options, guide, &given)?;
                for (one, next) in all.iter_mut().zip(next) {
                    one.rows = join(&one.rows, &next.rows, overlap)?;
                }
            }
            let rows = all.first().map_or(1, |first| first.rows.n);
            ends.push((rows - 1) as f64 / header.spec.fps);
        }
        Ok((all, ends))
    }

    /// Returns one motion as a clip with its captions, verdict and provenance.
    fn finish(&self, one: &Generated, prompts: &[String], ends: &[f64]) -> Result<Candidate, CliError> {
        let mut clip = self.generator.clip(one, prompts.first().map_or("", String::as_str), &self.robot)?;
        let verdict = Verdict::of(&clip, &one.rows, &self.robot, self.critic.as_ref())?;
        let starts = [0.0].into_iter().chain(ends.iter().copied());
        let parts = prompts.iter().zip(starts.zip(ends));
        let caption = |(text, (start, end)): (&String, (f64, &f64))| Caption { start, end: *end, text: text.clone() };
        let provenance = &mut clip.provenance;
        provenance.captions = parts.map(caption).collect();
        if let Some(kept) = &self.kept {
            provenance.source += &format!(", with {}", kept.words);
            let known = kept.licence.is_empty() || provenance.licence.split("; ").any(|own| own == kept.licence);
            if !known {
                provenance.licence += &format!("; {}", kept.licence);
            }
        }
        provenance.source += &format!(" of seed {}", self.options.seed);
        Ok(Candidate { clip, verdict, candidate: one.candidate, parts: Vec::new() })
    }
}

/// Sorts candidates, the best first.
fn ranked(mut made: Vec<Candidate>) -> Vec<Candidate> {
    made.sort_by(|a, b| a.verdict.compare(&b.verdict).then(a.candidate.cmp(&b.candidate)));
    made
}

/// Sorts candidates by the critic's mean value, the highest first.
pub fn sort_by_realism(made: &mut [Candidate]) {
    let realism = |one: &Candidate| one.verdict.critic.as_ref().map_or(f64::NEG_INFINITY, |opinion| opinion.realism);
    made.sort_by(|a, b| realism(b).total_cmp(&realism(a)).then(a.candidate.cmp(&b.candidate)));
}

fn tail(rows: &FeatureMatrix, count: usize) -> Result<FeatureMatrix, CliError> {
    Ok(FeatureMatrix::new(rows.rows[(rows.n - count) * rows.width..].to_vec(), rows.width)?)
}
