//! A trained augmentation as one file, and what it makes of traces.

use std::path::Path;

use lifelike_checkpoint::Checkpoint;
use lifelike_sim::trace::{BlockTrace, Trace};
use rayon::prelude::*;

use crate::loss::LossKind;
use crate::model::{Inputs, Network, NetworkPass, SatSizes, Scales, Stream, closed_loop};
use crate::{AugmentationError, FromInput};

/// Ending of the files' names.
pub const EXTENSION: &str = ".augmentation.safetensors";
const KEY: &str = "augmentation";
const NETWORK: &str = "network";
/// The widest layer and the longest history that a file is believed.
const LARGEST: usize = 1 << 14;
/// Rows that pass through the network at a time in a running simulation.
const BLOCK: usize = 128;
/// A correction is at most so many times the largest error that was measured in training: a network that is lost stays bounded.
const GUARD: f32 = 1.5;

/// Description of an augmentation.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AugmentationHeader {
    /// Names of what it reads and predicts, the class and the rate.
    pub inputs: Inputs,
    /// Their scales.
    pub scales: Scales,
    /// Sizes of the network.
    pub sizes: SatSizes,
    /// The loss it was trained with: it says how predictions lie in the output.
    pub loss: LossKind,
    /// Largest errors of training, in units of their scales.
    pub limit: Vec<f32>,
    /// SHA-256 of what it learned from, hexadecimal.
    pub learned_from: String,
}

/// Kind of the errors before that the encoder reads (thesis 2.4).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Feedback {
    /// Nothing: the prediction follows from the simulation alone, and cannot drift.
    #[default]
    None,
    /// Its own predictions.
    Predicted,
    /// Measured errors, as of a robot that runs beside its simulation.
    Measured,
}

/// A frozen augmentation of one class of building blocks.
#[derive(Debug, Clone)]
pub struct Augmentation {
    header: AugmentationHeader,
    network: Network,
    values: Vec<f32>,
}

impl Augmentation {
    /// Packs a network's parameters.
    pub fn new(header: AugmentationHeader, values: &[f32]) -> Self {
        let network = Network::new(header.sizes, &header.sizes.layout(), values);
        Self { header, network, values: values.to_vec() }
    }

    /// Returns its description.
    pub fn header(&self) -> &AugmentationHeader {
        &self.header
    }

    /// Returns Δs of all steps of a block in SI units, `[steps, outputs]`.
    ///
    /// # Errors
    /// [`AugmentationError::Input`] for a block of another class, with other columns, or that lacks what is to be fed back.
    pub fn errors(&self, block: &BlockTrace, feedback: Feedback) -> Result<Vec<f32>, AugmentationError> {
        Ok(self.errors_of(&[block], feedback)?.swap_remove(0))
    }

    /// Returns Δs of some blocks, as [`Self::errors`]; with its own predictions they run side by side.
    ///
    /// # Errors
    /// As [`Self::errors`], for the first block that does not fit.
    pub fn errors_of(&self, blocks: &[&BlockTrace], feedback: Feedback) -> Result<Vec<Vec<f32>>, AugmentationError> {
        let AugmentationHeader { inputs, scales, .. } = &self.header;
        let mut all = match feedback {
            Feedback::Predicted => {
                let rows = |block: &&BlockTrace| Ok(inputs.sequence("", block, scales)?.rows);
                self.closed_loop(&blocks.iter().map(rows).collect::<Result<Vec<_>, AugmentationError>>()?)
            }
            Feedback::None | Feedback::Measured => {
                let own = |block: &&BlockTrace| Ok(self.pass(block, feedback)?.0);
                blocks.iter().map(own).collect::<Result<_, AugmentationError>>()?
            }
        };
        for (block, out) in blocks.iter().zip(&mut all) {
            self.guard(out);
            for row in out.chunks_exact_mut(scales.error.len()) {
                row.iter_mut().zip(&scales.error).for_each(|(x, s)| *x *= s);
            }
            inputs.frame.leave(block, &inputs.outputs(), out)?;
        }
        Ok(all)
    }

    /// Guarded predictions of sequences that are fed them.
    fn closed_loop(&self, rows: &[Vec<f32>]) -> Vec<Vec<f32>> {
        let rows: Vec<&[f32]> = rows.iter().map(Vec::as_slice).collect();
        closed_loop(&self.network, &rows, self.header.sizes.known(false), |out| {
            let mut out = self.header.loss.predictions(out);
            self.guard(&mut out);
            out
        })
    }

    /// Returns the mean weight of attention on each history step, from the latest to the oldest, and last on the present step
    /// (Fig. 2.11), with this feedback; none without attention.
    ///
    /// # Errors
    /// As [`Self::errors`].
    pub fn attention(&self, block: &BlockTrace, feedback: Feedback) -> Result<Option<Vec<f64>>, AugmentationError> {
        let (_, pass) = self.pass(block, feedback)?;
        Ok(self.network.profile(&pass))
    }

    /// Predictions of all steps of a block, in units of the scales.
    fn pass(&self, block: &BlockTrace, feedback: Feedback) -> Result<(Vec<f32>, NetworkPass), AugmentationError> {
        let AugmentationHeader { inputs, scales, loss, sizes, .. } = &self.header;
        let sequence = inputs.sequence("", block, scales)?;
        let (width, outputs) = (inputs.fields.len(), inputs.selection.len());
        let steps = sequence.rows.len() / width;
        let mut fed_back = vec![0.0; steps * (outputs + 1)];
        match feedback {
            Feedback::None => {}
            Feedback::Measured if sequence.error.is_empty() => {
                let what = format!("what is fed back to '{}'", block.name);
                return Err(AugmentationError::mismatch(what, "measured columns", "none"));
            }
            Feedback::Measured => feed(&mut fed_back, &sequence.error, sizes.known(true)),
            Feedback::Predicted => {
                let own = self.closed_loop(std::slice::from_ref(&sequence.rows));
                feed(&mut fed_back, &own[0], sizes.known(false));
            }
        }
        let (out, pass) = self.network.forward(&sequence.rows, &fed_back, 1);
        Ok((loss.predictions(out), pass))
    }

    /// Returns the network for passes step by step.
    pub fn stream(&self) -> Stream {
        Stream::new(self.network.clone())
    }

    /// Returns Δs of one step of some rows in units of the scales, guarded, and writes the step's records. Many rows are shared between the
    /// processors.
    ///
    /// # Shapes
    /// `rows: [rows, inputs]` standardized; as [`Stream::predict`] and [`Stream::remember`].
    pub fn step<'a, I>(
        &self,
        stream: &Stream,
        rows: &[f32],
        feedback: Feedback,
        past: impl Fn(usize) -> I + Sync,
        records: &mut [f32],
    ) -> Vec<f32>
    where
        I: DoubleEndedIterator<Item = &'a [f32]>,
    {
        let (width, kept) = (BLOCK * self.header.inputs.fields.len(), BLOCK * stream.record_width());
        if rows.len() <= width {
            return self.block(stream, rows, feedback, past, records);
        }
        let blocks = rows.par_chunks(width).zip(records.par_chunks_mut(kept)).enumerate();
        let one = |(i, (rows, records)): (usize, (&[f32], &mut [f32]))| {
            self.block(stream, rows, feedback, |row| past(i * BLOCK + row), records)
        };
        blocks.map(one).collect::<Vec<_>>().concat()
    }

    /// A step of so few rows that what it passes through stays in the cache.
    fn block<'a, I>(
        &self,
        stream: &Stream,
        rows: &[f32],
        feedback: Feedback,
        past: impl Fn(usize) -> I,
        records: &mut [f32],
    ) -> Vec<f32>
    where
        I: DoubleEndedIterator<Item = &'a [f32]>,
    {
        let outputs = self.header.inputs.selection.len();
        let mut out = self.header.loss.predictions(stream.predict(rows, &past));
        self.guard(&mut out);
        let mut fed_back = vec![0.0; out.len() / outputs * (outputs + 1)];
        if feedback == Feedback::Predicted {
            feed(&mut fed_back, &out, self.header.sizes.known(false));
        }
        stream.remember(rows, &fed_back, past, records);
        out
    }

    /// Returns the trace with s(t) + Δs(t) in place of s(t), of all blocks of the class. References, forces and what was measured
    /// stay. With measurements as feedback, blocks that have none are told nothing.
    ///
    /// # Errors
    /// As [`Self::errors`]; [`AugmentationError::Input`] for another rate.
    pub fn corrected(&self, trace: &Trace, feedback: Feedback) -> Result<Trace, AugmentationError> {
        let inputs = &self.header.inputs;
        if trace.rate != inputs.rate {
            let what = format!("rate of trace '{}'", trace.name);
            return Err(AugmentationError::mismatch(what, format!("{} Hz", inputs.rate), format!("{} Hz", trace.rate)));
        }
        let own: Vec<&BlockTrace> = trace.blocks.iter().filter(|block| block.class == inputs.class).collect();
        let errors = match feedback {
            Feedback::Measured => {
                let of = |block: &&BlockTrace| match block.measured.names.is_empty() {
                    true => self.errors(block, Feedback::None),
                    false => self.errors(block, Feedback::Measured),
                };
                own.iter().map(of).collect::<Result<Vec<_>, _>>()?
            }
            other => self.errors_of(&own, other)?,
        };
        let mut trace = trace.clone();
        let blocks = trace.blocks.iter_mut().filter(|block| block.class == inputs.class);
        for (block, errors) in blocks.zip(errors) {
            let width = block.simulated.names.len();
            for (i, row) in inputs.selection.iter().enumerate() {
                // A measured number that is one column of the state tells that column; sums do not tell their parts.
                let [(name, factor)] = &row.state[..] else { continue };
                let Some(column) = block.simulated.index(name) else { continue };
                let values = block.simulated.values.chunks_exact_mut(width);
                for (state, errors) in values.zip(errors.chunks_exact(inputs.selection.len())) {
                    state[column] += errors[i] / factor;
                }
            }
        }
        Ok(trace)
    }

    fn guard(&self, out: &mut [f32]) {
        for row in out.chunks_exact_mut(self.header.limit.len()) {
            for (x, limit) in row.iter_mut().zip(&self.header.limit) {
                *x = x.clamp(-GUARD * limit, GUARD * limit);
            }
        }
    }

    /// Saves the augmentation.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn save(&self, path: &Path) -> Result<(), AugmentationError> {
        let mut file = Checkpoint::new();
        self.header.sizes.layout().save_into(&mut file, NETWORK, &self.values)?;
        file.set_meta(KEY, &self.header)?;
        Ok(file.save(path)?)
    }

    /// Loads an augmentation.
    ///
    /// # Errors
    /// A file that is none, is damaged, or does not fit itself.
    pub fn load(path: &Path) -> Result<Self, AugmentationError> {
        let file = Checkpoint::load(path)?;
        let header: AugmentationHeader = file.meta(KEY)?;
        let AugmentationHeader { inputs, scales, sizes, loss, limit, .. } = &header;
        let what = |part: &str| format!("{}: {part}", path.display());
        sizes.check()?;
        let (fields, outputs) = (inputs.fields.len(), inputs.selection.len());
        let counts = [sizes.inputs, sizes.outputs, sizes.quantiles];
        if counts != [fields, outputs, loss.quantiles()] || fields == 0 || outputs == 0 || fields > LARGEST {
            let expected = format!("{fields} inputs, {outputs} outputs, {} quantiles", loss.quantiles());
            return Err(AugmentationError::mismatch(what("sizes"), expected, format!("{counts:?}")));
        }
        for (part, numbers, count) in [
            ("means", &scales.mean, fields),
            ("deviations", &scales.std, fields),
            ("errors", &scales.error, outputs),
            ("limits", limit, outputs),
        ] {
            if numbers.len() != count || numbers.iter().any(|x| !x.is_finite()) {
                return Err(AugmentationError::mismatch(what(part), format!("{count} finite numbers"), numbers.len()));
            }
        }
        if !(inputs.rate.is_finite() && inputs.rate > 0.0) || scales.std.iter().chain(&scales.error).any(|x| *x <= 0.0)
        {
            return Err(AugmentationError::mismatch(what("rate and scales"), "numbers above 0", inputs.rate));
        }
        let values = sizes.layout().load_from(&file, NETWORK)?;
        Ok(Self::new(header, &values))
    }
}

/// Writes errors of rows, `[rows, outputs]`, as the network is fed them, `[rows, outputs + 1]`.
fn feed(fed_back: &mut [f32], errors: &[f32], known: f32) {
    let outputs = errors.len() / (fed_back.len() - errors.len()).max(1);
    for (fed, errors) in fed_back.chunks_exact_mut(outputs + 1).zip(errors.chunks_exact(outputs.max(1))) {
        fed[..outputs].copy_from_slice(errors);
        fed[outputs] = known;
    }
}
