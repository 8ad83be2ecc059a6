//! The trained critic as one file.

use std::path::Path;

use lifelike_checkpoint::Checkpoint;

use super::ensemble;
use super::member::named;
use super::network::{Bounds, CriticNetwork};
use super::surrogate::RewardSurrogate;
use super::windows::PaddedRows;
use crate::representation::{FeatureMatrix, RepresentationSpec, Standardizer};
use crate::{FromInput, GenerationError};

/// Ending of the names of critics' files.
pub const EXTENSION: &str = ".critic.safetensors";
/// In files.
const KEY: &str = "critic";
const NETWORK: &str = "network";
/// The widest window and layer that a file is believed.
const LARGEST: usize = 1 << 16;
/// Most networks that a file is believed.
pub(super) const MAX_MEMBERS: usize = 16;

/// Description of a critic.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CriticHeader {
    /// Name of the robot.
    pub robot: String,
    /// SHA-256 of the controller whose rewards it predicts, hexadecimal.
    pub controller: String,
    /// Layout of the rows, with the joints' names.
    pub representation: RepresentationSpec,
    /// Mean and standard deviation of each column of the training motion.
    pub standardizer: Standardizer,
    /// Rows of a window on either side of its centre; beyond the ends of a motion its first and last row are repeated.
    pub radius: usize,
    /// Hidden layers.
    pub hidden: Vec<usize>,
    /// Least and greatest value that rewards like those of the records can sum to.
    pub bounds: Bounds,
    /// Discount of a control step.
    pub gamma: f64,
    /// Control steps per second.
    pub control_hz: f64,
    /// Control steps of the records that it learned from.
    pub steps: u64,
    /// Networks; a value is their least. Files of one network do not say so.
    #[serde(default = "one", skip_serializing_if = "is_one")]
    pub members: usize,
}

fn one() -> usize {
    1
}

#[allow(clippy::trivially_copy_pass_by_ref)] // serde passes a reference
fn is_one(members: &usize) -> bool {
    *members == 1
}

/// A frozen critic.
#[derive(Debug, Clone)]
pub struct Critic {
    header: CriticHeader,
    networks: Vec<CriticNetwork>,
}

impl Critic {
    pub(super) fn new(header: CriticHeader, networks: Vec<CriticNetwork>) -> Self {
        Self { header, networks }
    }

    #[cfg(test)]
    pub(super) fn networks(&self) -> &[CriticNetwork] {
        &self.networks
    }

    /// Returns the description.
    pub fn header(&self) -> &CriticHeader {
        &self.header
    }

    /// Returns the Realism of a motion (thesis 5.3.1): the mean of v(m_t) over its rows, so that long and short motions
    /// compare.
    ///
    /// # Errors
    /// As [`RewardSurrogate::values`].
    pub fn realism(&self, motion: &FeatureMatrix) -> Result<f64, GenerationError> {
        let values = self.values(motion)?;
        Ok(values.iter().map(|v| f64::from(*v)).sum::<f64>() / values.len() as f64)
    }

    /// Writes the file; it appears under its name only when it is complete.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn save(&self, path: &Path) -> Result<(), GenerationError> {
        let mut file = Checkpoint::new();
        file.set_meta(KEY, &self.header)?;
        for (number, network) in self.networks.iter().enumerate() {
            let parameters = network.parameters();
            file.put_f32(&named(NETWORK, number), &[parameters.len()], parameters.to_vec())?;
        }
        Ok(file.save(path)?)
    }

    /// Reads a critic.
    ///
    /// # Errors
    /// The file is damaged or no critic; sizes in its header do not fit each other.
    pub fn load(path: &Path) -> Result<Self, GenerationError> {
        let file = Checkpoint::load(path)?;
        let header: CriticHeader = file.meta(KEY)?;
        header.representation.check()?;
        let width = header.representation.width();
        let inputs = (2 * header.radius.min(LARGEST) + 1) * width;
        let what = |what: &str| format!("{}: {what} of the critic", path.display());
        for numbers in [&header.standardizer.mean, &header.standardizer.std] {
            if numbers.len() != width {
                return Err(GenerationError::mismatch(what("statistics"), format!("{width} numbers"), numbers.len()));
            }
        }
        if let Some(std) = header.standardizer.std.iter().find(|std| **std <= 0.0 || std.is_nan()) {
            return Err(GenerationError::mismatch(what("standard deviations"), "numbers above 0", std));
        }
        let Bounds { low, high } = header.bounds;
        if !(low < high && low.is_finite() && high.is_finite()) {
            return Err(GenerationError::mismatch(what("bounds"), "a range", format!("{low} to {high}")));
        }
        let widths = [&[inputs], &header.hidden[..]].concat();
        if let Some(size) = widths.iter().find(|size| !(1..=LARGEST).contains(*size)) {
            return Err(GenerationError::mismatch(what("layer sizes"), format!("1 to {LARGEST}"), size));
        }
        let sizes = CriticNetwork::sizes(inputs, &header.hidden);
        if !(1..=MAX_MEMBERS).contains(&header.members) {
            return Err(GenerationError::mismatch(what("members"), format!("1 to {MAX_MEMBERS}"), header.members));
        }
        let network = |number: usize| -> Result<CriticNetwork, GenerationError> {
            let parameters = file.f32s(&named(NETWORK, number), &[sizes.parameters()])?;
            Ok(CriticNetwork::new(sizes.clone(), parameters, header.bounds))
        };
        let networks = (0..header.members).map(network).collect::<Result<_, _>>()?;
        Ok(Self { networks, header })
    }

    /// Checks that it judges motion of these joints at this rate.
    ///
    /// # Errors
    /// [`GenerationError::Input`] with both layouts.
    pub fn check(&self, representation: &RepresentationSpec) -> Result<(), GenerationError> {
        self.header.representation.expect("rows for the critic", representation)
    }
}

impl RewardSurrogate for Critic {
    fn values(&self, motion: &FeatureMatrix) -> Result<Vec<f32>, GenerationError> {
        let padded = PaddedRows::new(motion, &self.header.standardizer, self.header.radius)?;
        Ok(ensemble::least(&self.networks, &padded).0)
    }

    fn gradient(&self, motion: &FeatureMatrix) -> Result<(Vec<f32>, FeatureMatrix), GenerationError> {
        let standardizer = &self.header.standardizer;
        let padded = PaddedRows::new(motion, standardizer, self.header.radius)?;
        let (values, by) = ensemble::gradient(&self.networks, &padded, motion.width);
        Ok((values, FeatureMatrix::new(padded.fold(&by, standardizer), motion.width)?))
    }
}
