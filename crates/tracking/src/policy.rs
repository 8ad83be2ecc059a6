//! A trained policy as a file (`*.policy.safetensors`), of which controllers are made.
//!
//! It has the network, the normaliser of its inputs, and the layout of inputs and outputs with all names. Robots with
//! other joints, or joints in another order, are therefore refused.

use std::path::Path;

use lifelike_checkpoint::Checkpoint;
use lifelike_nn::normalizer::RunningNormalizer;
use lifelike_robot::controller::PolicyHeader;
use lifelike_robot::{ReferenceLibrary, Robot};

use crate::TrackerError;
use lifelike_train::networks::{Actor, ActorSize, Critic};
use lifelike_train::ppo::SavedNetworks;

/// Frames that are encoded at a time.
const CHUNK: usize = 256;

/// Ending of the names of policy files.
pub const EXTENSION: &str = lifelike_robot::controller::POLICY_EXTENSION;

/// A policy, ready to act.
#[derive(Debug, Clone)]
pub struct Policy {
    header: PolicyHeader,
    actor: Actor,
    normalizer: RunningNormalizer,
    /// State that training goes on with; nothing that acts needs it.
    value: Option<(Critic, RunningNormalizer)>,
}

/// Names of the networks in the file.
const ACTOR: &str = "actor";
const NORMALIZER: &str = "normalizer";
const CRITIC: &str = "critic";
const CRITIC_NORMALIZER: &str = "critic_normalizer";

/// Returns the names of the networks in a policy's file.
pub(crate) fn networks() -> SavedNetworks {
    SavedNetworks {
        actor: ACTOR.into(),
        actor_normalizer: NORMALIZER.into(),
        critic: CRITIC.into(),
        critic_normalizer: CRITIC_NORMALIZER.into(),
    }
}

impl Policy {
    /// Returns the policy of a network in training.
    pub fn new(header: PolicyHeader, actor: &Actor, normalizer: &RunningNormalizer) -> Self {
        let mut normalizer = normalizer.clone();
        normalizer.set_frozen(true);
        Self { header, actor: actor.clone(), normalizer, value: None }
    }

    /// With the value function, so that a training that begins with the file (`init`) goes on with both.
    #[must_use]
    pub fn with_value(self, critic: &Critic, normalizer: &RunningNormalizer) -> Self {
        Self { value: Some((critic.clone(), normalizer.clone())), ..self }
    }

    /// Returns the header of the file.
    pub fn header(&self) -> &PolicyHeader {
        &self.header
    }

    /// Returns the network (for exporters); its inputs are to be normalised with [`Self::normalizer`].
    pub fn actor(&self) -> &Actor {
        &self.actor
    }

    /// Returns the normaliser of observations.
    pub fn normalizer(&self) -> &RunningNormalizer {
        &self.normalizer
    }

    /// Checks that the policy may drive this robot.
    ///
    /// # Errors
    /// Names, order, default pose or rate are others.
    pub fn check(&self, robot: &Robot) -> Result<(), TrackerError> {
        check(&self.header, robot)
    }

    /// Returns the outputs of the deterministic policy: `[N, O]` observations as `ObservationSpec::write` wrote them → `[N, J]` outputs (not
    /// clamped).
    ///
    /// # Errors
    /// The length is no multiple of the observation's.
    pub fn outputs(&self, mut observations: Vec<f32>) -> Result<Vec<f32>, TrackerError> {
        let width = self.header.observation.size();
        if !observations.len().is_multiple_of(width) {
            return Err(TrackerError::Mismatch {
                what: "observations".into(),
                expected: format!("rows of {width} numbers"),
                got: format!("{} numbers", observations.len()),
            });
        }
        self.normalizer.normalize(&mut observations);
        Ok(self.actor.means(&observations))
    }

    /// Returns the codes of its own encoder for every frame of a library, `[T, code]`, each of length one; none where it has no
    /// encoder.
    ///
    /// # Errors
    /// The library has other joints or end effectors.
    pub fn codes(&self, library: &ReferenceLibrary) -> Result<Vec<f32>, TrackerError> {
        let spec = &self.header.observation;
        let (width, window) = (spec.size(), spec.window_size());
        let mut codes = Vec::new();
        for first in (0..library.len()).step_by(CHUNK) {
            let last = (first + CHUNK).min(library.len());
            let mut rows = vec![0.0; (last - first) * width];
            for (frame, row) in (first..last).zip(rows.chunks_exact_mut(width)) {
                let frames = library.window_at(frame, &spec.reference.window);
                spec.write_frames(&frames, &mut row[width - window..])?;
            }
            self.normalizer.normalize(&mut rows);
            let windows: Vec<f32> = rows.chunks_exact(width).flat_map(|row| &row[width - window..]).copied().collect();
            codes.extend(self.actor.codes(&windows));
        }
        Ok(codes)
    }

    /// Returns the file's content.
    ///
    /// # Errors
    /// Two entries of one name.
    pub fn to_checkpoint(&self) -> Result<Checkpoint, TrackerError> {
        let mut checkpoint = Checkpoint::new();
        checkpoint.set_meta("policy", &self.header)?;
        self.actor.parameters().save_into(&mut checkpoint, ACTOR)?;
        self.normalizer.save_into(&mut checkpoint, NORMALIZER)?;
        if let Some((critic, normalizer)) = &self.value {
            critic.parameters().save_into(&mut checkpoint, CRITIC)?;
            normalizer.save_into(&mut checkpoint, CRITIC_NORMALIZER)?;
        }
        Ok(checkpoint)
    }

    /// Writes the file; it appears under its name only when it is complete.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn save(&self, path: &Path) -> Result<(), TrackerError> {
        Ok(self.to_checkpoint()?.save(path)?)
    }

    /// Reads a policy for a robot.
    ///
    /// # Errors
    /// The file is damaged or no policy, or was made for another robot.
    pub fn load(path: &Path, robot: &Robot) -> Result<Self, TrackerError> {
        let policy = Self::read(path)?;
        policy.check(robot)?;
        Ok(policy)
    }

    /// Reads a policy for any robot, to inspect it; without the value function.
    ///
    /// # Errors
    /// The file is damaged or no policy.
    pub fn read(path: &Path) -> Result<Self, TrackerError> {
        let checkpoint = Checkpoint::load(path)?;
        let header: PolicyHeader = checkpoint.meta("policy")?;
        let (inputs, joints) = (header.observation.size(), header.observation.joints.len());
        let (encoder, code) = header.encoder.clone().unwrap_or_default();
        let window = header.observation.window_size();
        if (window > 0) != (code > 0) {
            return Err(TrackerError::Mismatch {
                what: format!("{}: size of the code of a window of {window} numbers", path.display()),
                expected: if window > 0 { "above 0" } else { "0" }.into(),
                got: code.to_string(),
            });
        }
        fits(&checkpoint, "actor.mean", inputs - window + code, &header.hidden, joints)?;
        if code > 0 {
            fits(&checkpoint, "actor.encoder", window, &encoder, code)?;
        }
        let size = ActorSize { inputs, window, encoder: &encoder, code, hidden: &header.hidden, outputs: joints };
        let actor = Actor::init(size, 1.0, 0).load_from(&checkpoint, ACTOR)?;
        let normalizer = RunningNormalizer::load_from(&checkpoint, NORMALIZER, inputs)?;
        Ok(Self { header, actor, normalizer, value: None })
    }
}

/// Checks that a policy with this header may drive a robot.
pub(crate) fn check(header: &PolicyHeader, robot: &Robot) -> Result<(), TrackerError> {
    header.observation.check(robot)?;
    if header.control_hz != robot.control_hz {
        return Err(TrackerError::Mismatch {
            what: format!("policy rate for robot '{}' (Hz)", robot.name),
            expected: header.control_hz.to_string(),
            got: robot.control_hz.to_string(),
        });
    }
    Ok(())
}

/// Checks that the file holds the layers that its header describes, before memory is allocated by sizes from a header.
fn fits(
    checkpoint: &Checkpoint,
    prefix: &str,
    inputs: usize,
    hidden: &[usize],
    outputs: usize,
) -> Result<(), TrackerError> {
    let widths: Vec<usize> = [inputs].into_iter().chain(hidden.iter().copied()).chain([outputs]).collect();
    for (layer, pair) in widths.windows(2).enumerate() {
        let name = format!("{prefix}.layers.{layer}.weight");
        let shape = checkpoint.entry(&name)?.shape();
        if shape != pair {
            return Err(TrackerError::Mismatch {
                what: format!("shape of {name}"),
                expected: format!("{pair:?}"),
                got: format!("{shape:?}"),
            });
        }
    }
    Ok(())
}
