//! A trained evaluator, and its file.

use std::path::Path;

use lifelike_checkpoint::{Checkpoint, CheckpointError};

use super::network::EvaluatorNetwork;
use super::plan::EvaluatorPlan;
use crate::metrics::Embeddings;
use crate::representation::{FeatureMatrix, RepresentationSpec, Standardizer};
use crate::text::pieces::WordPieces;
use crate::{FromInput, GenerationError};

/// Name of the networks in a file.
pub(super) const NETWORK: &str = "evaluator";

/// Embeds sentences and motions of one robot.
#[derive(Debug, Clone)]
pub struct Evaluator {
    pub(super) plan: EvaluatorPlan,
    pub(super) spec: RepresentationSpec,
    pub(super) standardizer: Standardizer,
    pub(super) pieces: WordPieces,
    pub(super) network: EvaluatorNetwork,
}

impl Evaluator {
    /// Checks that it compares motion of these joints at this rate.
    ///
    /// # Errors
    /// [`GenerationError::Input`] with both layouts.
    pub fn check(&self, representation: &RepresentationSpec) -> Result<(), GenerationError> {
        self.spec.expect("rows for the evaluator", representation)
    }

    /// Embeds motions, of which only the first [`EvaluatorPlan::max_rows`] rows are read.
    ///
    /// # Errors
    /// [`GenerationError::Input`] for rows of another width, or an embedding that is not finite.
    pub fn motions(&self, motions: &[FeatureMatrix]) -> Result<Embeddings, GenerationError> {
        let rows = motions.iter().map(|motion| self.rows(motion, 0)).collect::<Result<Vec<_>, _>>()?;
        Embeddings::new(self.network.motions(&rows), self.plan.width)
    }

    /// Embeds sentences.
    ///
    /// # Errors
    /// [`GenerationError::Prompt`] for a text that is no sentence.
    pub fn sentences(&self, sentences: &[&str]) -> Result<Embeddings, GenerationError> {
        let ids = sentences.iter().map(|text| self.pieces.encode(text)).collect::<Result<Vec<_>, _>>()?;
        Embeddings::new(self.network.sentences(&ids), self.plan.width)
    }

    /// Returns standardized rows of a motion, from a row on, as many as are read.
    pub(super) fn rows(&self, motion: &FeatureMatrix, from: usize) -> Result<Vec<f32>, GenerationError> {
        if motion.width != self.spec.width() {
            return Err(GenerationError::mismatch("width of a motion", self.spec.width(), motion.width));
        }
        let last = motion.n.min(from + self.plan.max_rows);
        let mut rows = motion.rows[from.min(last) * motion.width..last * motion.width].to_vec();
        self.standardizer.standardize(&mut rows);
        Ok(rows)
    }

    /// Writes a `*.evaluator.safetensors`.
    ///
    /// # Errors
    /// As [`Checkpoint::save`].
    pub fn save(&self, path: &Path) -> Result<(), GenerationError> {
        let mut checkpoint = Checkpoint::new();
        self.save_into(&mut checkpoint)?;
        Ok(checkpoint.save(path)?)
    }

    /// Reads a file of [`Self::save`].
    ///
    /// # Errors
    /// A file that cannot be read, or is none of an evaluator.
    pub fn load(path: &Path) -> Result<Self, GenerationError> {
        Self::load_from(&Checkpoint::load(path)?)
    }

    /// Adds everything to a checkpoint.
    pub(super) fn save_into(&self, checkpoint: &mut Checkpoint) -> Result<(), CheckpointError> {
        checkpoint.set_meta("evaluator", &self.plan)?;
        checkpoint.set_meta("representation", &self.spec)?;
        checkpoint.set_meta("word_pieces", &self.pieces)?;
        let width = self.spec.width();
        checkpoint.put_f32("standardizer.mean", &[width], self.standardizer.mean.clone())?;
        checkpoint.put_f32("standardizer.std", &[width], self.standardizer.std.clone())?;
        self.network.parameters().save_into(checkpoint, NETWORK)
    }

    /// Reads what [`Self::save_into`] added.
    pub(super) fn load_from(checkpoint: &Checkpoint) -> Result<Self, GenerationError> {
        let plan: EvaluatorPlan = checkpoint.meta("evaluator")?;
        plan.check()?;
        let spec: RepresentationSpec = checkpoint.meta("representation")?;
        spec.check()?;
        let pieces: WordPieces = checkpoint.meta("word_pieces")?;
        let column = |name: &str| checkpoint.f32s(name, &[spec.width()]);
        let standardizer = Standardizer { mean: column("standardizer.mean")?, std: column("standardizer.std")? };
        let mut network = EvaluatorNetwork::new(&plan, spec.width(), pieces.len());
        *network.parameters_mut() = network.parameters().load_from(checkpoint, NETWORK)?;
        Ok(Self { plan, spec, standardizer, pieces, network })
    }
}
