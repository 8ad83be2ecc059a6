//! A trained motion prior of any kind from its file, as the tracker and the evaluation use it.

use std::path::Path;

use lifelike_checkpoint::{Checkpoint, FromInput};
use lifelike_motion::features::frames_of;
use lifelike_motion::resample::resample;
use lifelike_motion::{FeatureLayout, Frame, MotionClip};
use lifelike_representation::{MotionPrior, PriorClip};
use lifelike_robot::controller::PriorEncoder;
use lifelike_robot::{Controller, LatentEncoder, Robot, RobotError};
use sha2::{Digest, Sha256};

use crate::error::CliError;
use crate::shipped::{self, Kind};

/// The prior and the digest of its file, by which a policy remembers it.
pub struct Prior {
    prior: MotionPrior,
    encoder: Option<PriorEncoder>,
    digest: String,
}

impl Prior {
    /// Reads it.
    pub fn load(path: &Path) -> Result<Self, CliError> {
        let path = &shipped::file(path, Kind::Prior)?;
        let bytes = std::fs::read(path).map_err(|e| CliError::Input(format!("{}: {e}", path.display())))?;
        let digest = Sha256::digest(&bytes).iter().map(|b| format!("{b:02x}")).collect();
        let prior = MotionPrior::load(path)?;
        let encoder = PriorEncoder::from_prior(&Checkpoint::from_bytes(&bytes, path)?).ok();
        Ok(Self { prior, encoder, digest })
    }

    /// As [`Self::load`], for this robot.
    ///
    /// # Errors
    /// As [`load_for`].
    pub fn load_for(path: &Path, robot: &Robot) -> Result<Self, CliError> {
        let prior = Self::load(path)?;
        check(&prior.prior, path, robot)?;
        Ok(prior)
    }

    /// SHA-256 of its file, hexadecimal.
    pub fn digest(&self) -> &str {
        &self.digest
    }

    /// Returns its encoder as a controller has it; none for a Spline-based Transformer, which runs beside one only.
    pub fn encoder(&self) -> Option<PriorEncoder> {
        self.encoder.clone()
    }

    /// Reads the prior of a controller that wants latent codes and has no encoder of its own. It is checked to be the
    /// very one that the controller was trained with.
    pub fn for_controller(controller: &Controller, path: Option<&Path>) -> Result<Option<Self>, CliError> {
        let header = controller.header();
        if header.observation.reference.latent == 0 || controller.prior().is_some() {
            return Ok(None);
        }
        let header = &header.provenance;
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
    pub fn as_encode(&self) -> &dyn LatentEncoder {
        self
    }
}

/// A prior for this robot.
///
/// # Errors
/// No prior in the file, or one of a robot with other joints or end effectors.
pub fn load_for(path: &Path, robot: &Robot) -> Result<MotionPrior, CliError> {
    let prior = MotionPrior::load(&shipped::file(path, Kind::Prior)?)?;
    check(&prior, path, robot)?;
    Ok(prior)
}

/// Refuses a prior of other joints or end effectors than the robot's.
fn check(prior: &MotionPrior, path: &Path, robot: &Robot) -> Result<(), CliError> {
    if *prior.layout() != robot.layout {
        let names = |layout: &FeatureLayout| format!("{:?} and {:?}", layout.joints, layout.end_effectors);
        let text = format!(
            "{}: expected a prior of '{}' with {}, got one with {}",
            path.display(),
            robot.name,
            names(&robot.layout),
            names(prior.layout())
        );
        return Err(CliError::Input(text));
    }
    Ok(())
}

/// Every clip at this rate (Hz), as priors take it.
pub fn frames(clips: &[MotionClip], robot: &Robot, rate: f64) -> Result<Vec<PriorClip>, CliError> {
    let frames = clips.iter().map(|clip| {
        let clip = resample(clip, rate)?;
        let frames = frames_of(&clip, &robot.character, &robot.effectors)?;
        Ok(PriorClip { name: clip.name, frames })
    });
    frames.collect()
}

impl LatentEncoder for Prior {
    fn latent_size(&self) -> usize {
        self.prior.latent_size()
    }

    fn encode(&self, clip: &MotionClip, frames: &[Frame], fps: f64) -> Result<Vec<f32>, RobotError> {
        let rate = self.prior.windows().frame_rate;
        if (rate - fps).abs() > 1e-9 {
            let what = format!("clip '{}' for the prior (frames per second)", clip.name);
            return Err(RobotError::mismatch(what, rate, fps));
        }
        let codes = self.prior.encode_clip(frames);
        codes.map_err(|source| RobotError::Encoder { clip: clip.name.clone(), source: Box::new(source) })
    }
}
