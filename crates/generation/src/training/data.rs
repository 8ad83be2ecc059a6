//! Captioned motion of one robot, in the network's numbers.

use std::path::{Path, PathBuf};

use lifelike_motion::{MotionClip, container};
use lifelike_robot::{Robot, clips};
use sha2::{Digest, Sha256};

use super::GeneratorPlan;
use crate::GenerationError;
use crate::generator::Generator;
use crate::representation::{FeatureMatrix, RepresentationSpec, Standardizer};
use crate::space::MotionSpace;
use crate::text::pieces::WordPieces;

/// Use of a motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Part {
    /// Trained on.
    Train,
    /// For the curve of the loss.
    Validation,
    /// For the tables.
    Test,
    /// For the tables; combinations and words never trained on.
    HeldOut,
}

/// One motion with its captions.
#[derive(Debug, Clone, PartialEq)]
pub struct CaptionedMotion {
    /// Name, for messages.
    pub name: String,
    /// Use.
    pub part: Part,
    /// The motion.
    pub rows: FeatureMatrix,
    /// Sentences about all of it.
    pub captions: Vec<String>,
    /// Terms of use.
    pub licence: String,
}

/// The lines of an index that training reads.
#[derive(serde::Deserialize)]
struct IndexLine {
    file: PathBuf,
    split: Part,
    captions: Vec<String>,
    #[serde(default)]
    licence: String,
}

/// The index of a folder of captioned clips.
const INDEX: &str = "dataset.jsonl";
/// Rows below which there is no motion.
const MIN_ROWS: usize = 10;

impl CaptionedMotion {
    /// Returns the motions of folders with an index and of other clips, in the order of their names within each input.
    ///
    /// # Errors
    /// A file that cannot be read, a line of an index that is none, or no motion at all.
    pub fn load(inputs: &[PathBuf], robot: &Robot, max_seconds: f64) -> Result<Vec<Self>, GenerationError> {
        let spec = RepresentationSpec::of(&robot.layout);
        let rows = |clip: &MotionClip| -> Result<FeatureMatrix, GenerationError> {
            let mut rows = FeatureMatrix::from_clip(clip, &spec)?;
            rows.n = rows.n.min((max_seconds * spec.fps).round() as usize + 1);
            rows.rows.truncate(rows.n * rows.width);
            Ok(rows)
        };
        let mut out = Vec::new();
        for input in inputs {
            if input.join(INDEX).is_file() {
                for line in index(&input.join(INDEX))? {
                    let clip = container::read(&input.join(&line.file))?;
                    let (rows, captions) = (rows(&clip)?, line.captions);
                    out.push(Self { name: clip.name, part: line.split, rows, captions, licence: line.licence });
                }
                continue;
            }
            for clip in clips::load(std::slice::from_ref(input), robot)?.all()? {
                let licence = clip.provenance.licence.clone();
                let captions = captions(&clip);
                out.push(Self { part: Part::Train, rows: rows(&clip)?, captions, licence, name: clip.name });
            }
        }
        out.retain(|motion| motion.rows.n >= MIN_ROWS && !motion.captions.is_empty());
        if out.iter().any(|motion| motion.part == Part::Train) {
            return Ok(out);
        }
        Err(GenerationError::mismatch(
            "captioned motion to train on",
            format!("at least one of {MIN_ROWS} rows"),
            "none",
        ))
    }
}

fn index(path: &Path) -> Result<Vec<IndexLine>, GenerationError> {
    let text =
        std::fs::read_to_string(path).map_err(|source| GenerationError::Io { path: path.to_path_buf(), source })?;
    let lines = text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty());
    let read = |(i, line): (usize, &str)| {
        let what = format!("{}:{}", path.display(), i + 1);
        serde_json::from_str(line).map_err(|e| GenerationError::mismatch(what, "a line of a captioned data set", e))
    };
    lines.map(read).collect()
}

/// Returns the sentences of a clip's container, or its name as words.
fn captions(clip: &MotionClip) -> Vec<String> {
    let own: Vec<String> = clip.provenance.captions.iter().map(|caption| caption.text.clone()).collect();
    if own.is_empty() { vec![clip.name.replace(['_', '-', '+', '.'], " ")] } else { own }
}

/// One motion in the network's numbers.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Sample {
    /// Standardized, `[tokens, width]`.
    pub(super) tokens: Vec<f32>,
    /// Rows that the tokens stand for.
    pub(super) rows: usize,
    pub(super) captions: Vec<Vec<u32>>,
}

/// Everything that a training reads.
#[derive(Debug, Clone)]
pub struct TrainingData {
    pub(crate) space: MotionSpace,
    pub(crate) standardizer: Standardizer,
    pub(crate) pieces: WordPieces,
    /// Every caption trained on, once.
    pub(crate) captions: Vec<String>,
    pub(crate) licences: Vec<String>,
    /// Median duration of the motion trained on (s).
    pub(crate) median_seconds: f64,
    pub(super) training: Vec<Sample>,
    pub(super) validation: Vec<Sample>,
    digest: String,
}

impl TrainingData {
    /// Returns motions in the numbers of a plan's network; statistics and word pieces are those of what is trained on.
    ///
    /// # Errors
    /// Motion that does not fit the robot, captions that are no sentences.
    pub fn new(plan: &GeneratorPlan, robot: &Robot, motions: &[CaptionedMotion]) -> Result<Self, GenerationError> {
        let space = MotionSpace::new(RepresentationSpec::of(&robot.layout), plan.space);
        let of = || motions.iter().filter(|motion| motion.part == Part::Train);
        let encode = |motion: &CaptionedMotion| FeatureMatrix::new(space.encode(&motion.rows)?, space.width());
        let tokens = of().map(encode).collect::<Result<Vec<_>, _>>()?;
        let standardizer = Standardizer::of(&tokens, Standardizer::FLOOR)?;
        let captions = of().flat_map(|motion| &motion.captions).map(String::as_str);
        let pieces = WordPieces::learn(captions, plan.pieces)?;
        Self::with(space, standardizer, pieces, motions)
    }

    /// Returns motions in the numbers of a trained generator, with its statistics and word pieces.
    ///
    /// # Errors
    /// As [`Self::new`], and another robot than the generator's.
    pub fn of_generator(
        generator: &Generator,
        robot: &Robot,
        motions: &[CaptionedMotion],
    ) -> Result<Self, GenerationError> {
        generator.check_robot(robot)?;
        let pieces = generator.header().pieces.clone();
        Self::with(generator.space(), generator.standardizer().clone(), pieces, motions)
    }

    fn with(
        space: MotionSpace,
        standardizer: Standardizer,
        pieces: WordPieces,
        motions: &[CaptionedMotion],
    ) -> Result<Self, GenerationError> {
        let of = |part: Part| motions.iter().filter(move |motion| motion.part == part);
        let mut captions: Vec<String> = of(Part::Train).flat_map(|motion| motion.captions.clone()).collect();
        captions.sort();
        captions.dedup();
        let sample = |motion: &CaptionedMotion| -> Result<Sample, GenerationError> {
            let mut tokens = space.encode(&motion.rows)?;
            standardizer.standardize(&mut tokens);
            let captions = motion.captions.iter().map(|text| pieces.encode(text)).collect::<Result<_, _>>()?;
            Ok(Sample { tokens, rows: motion.rows.n, captions })
        };
        let training = of(Part::Train).map(sample).collect::<Result<Vec<_>, _>>()?;
        let validation = of(Part::Validation).map(sample).collect::<Result<Vec<_>, _>>()?;
        let mut seconds: Vec<f64> = of(Part::Train).map(|m| (m.rows.n - 1) as f64 / space.spec().fps).collect();
        seconds.sort_by(f64::total_cmp);
        let mut licences: Vec<String> = of(Part::Train).map(|m| m.licence.trim().to_string()).collect();
        licences.sort();
        licences.dedup();
        licences.retain(|licence| !licence.is_empty());
        let mut hash = Sha256::new();
        for sample in training.iter().chain(&validation) {
            sample.tokens.iter().for_each(|x| hash.update(x.to_le_bytes()));
            sample.captions.iter().flatten().for_each(|id| hash.update(id.to_le_bytes()));
        }
        let digest = hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect();
        let median_seconds = seconds.get(seconds.len() / 2).copied().unwrap_or(0.0);
        Ok(Self { space, standardizer, pieces, captions, licences, median_seconds, training, validation, digest })
    }

    /// Returns counts in a line, with the digest of all numbers.
    pub fn describe(&self) -> String {
        let (training, validation) = (self.training.len(), self.validation.len());
        format!("{training} motions, {validation} for validation, SHA-256 {}", self.digest)
    }
}
