//! A trained motion prior from its file, as the tracker and the evaluation use it.

use std::path::Path;

use lifelike_learn::LearnError;
use lifelike_learn::representation::MotionPrior;
use lifelike_learn::tracking::{Encode, Policy};
use lifelike_motion::{Frame, MotionClip};
use sha2::{Digest, Sha256};

use crate::error::CliError;

/// The prior and the digest of its file, by which a policy remembers it.
pub struct Prior {
    prior: MotionPrior,
    digest: String,
}

impl Prior {
    /// Reads it.
    pub fn load(path: &Path) -> Result<Self, CliError> {
        let bytes = std::fs::read(path).map_err(|e| CliError::Input(format!("{}: {e}", path.display())))?;
        let digest = Sha256::digest(&bytes).iter().map(|b| format!("{b:02x}")).collect();
        Ok(Self { prior: MotionPrior::load(path)?, digest })
    }

    /// SHA-256 of its file, hexadecimal.
    pub fn digest(&self) -> &str {
        &self.digest
    }

    /// The prior of a policy that wants one, checked to be the very one that it was trained with.
    pub fn for_policy(policy: &Policy, path: Option<&Path>) -> Result<Option<Self>, CliError> {
        let header = policy.header();
        if header.observation.reference.latent == 0 {
            return Ok(None);
        }
        let path = path.ok_or_else(|| {
            CliError::Usage(format!(
                "this policy wants latent codes; name its prior (SHA-256 {}) with --prior",
                header.prior
            ))
        })?;
        let prior = Self::load(path)?;
        if !header.prior.is_empty() && header.prior != prior.digest {
            let text = format!(
                "{}: expected the prior that the policy was trained with (SHA-256 {}), got {}",
                path.display(),
                header.prior,
                prior.digest
            );
            return Err(CliError::Input(text));
        }
        Ok(Some(prior))
    }

    /// For the tracker's library.
    pub fn as_encode(&self) -> &dyn Encode {
        self
    }
}

impl Encode for Prior {
    fn latent(&self) -> usize {
        self.prior.latent_size()
    }

    fn encode(&self, clip: &MotionClip, frames: &[Frame], fps: f64) -> Result<Vec<f32>, LearnError> {
        let rate = self.prior.plan().frame_rate;
        if (rate - fps).abs() > 1e-9 {
            return Err(LearnError::Mismatch {
                what: format!("clip '{}' for the prior (frames per second)", clip.name),
                expected: rate.to_string(),
                got: fps.to_string(),
            });
        }
        self.prior.encode_clip(frames)
    }
}
