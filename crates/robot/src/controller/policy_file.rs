//! Policies as training writes them (`*.policy.safetensors`), with the motion prior in a file of its own.

use lifelike_checkpoint::Checkpoint;
use sha2::{Digest, Sha256};

use super::file::ControllerFile;
use super::header::{ControllerHeader, Provenance};
use super::policy::FrozenPolicy;
use super::prior::PriorEncoder;
use crate::action::ActionSpec;
use crate::error::RobotError;
use crate::network::Layer;
use crate::observation::ObservationSpec;

/// Ending of the names of policy files.
pub const POLICY_EXTENSION: &str = ".policy.safetensors";
/// Metadata key of a policy's header.
pub(super) const POLICY: &str = "policy";

/// Names and sizes in a policy's file.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PolicyHeader {
    /// Name of the robot that it was trained for.
    pub robot: String,
    /// Layout of its observations.
    pub observation: ObservationSpec,
    /// Meaning of its outputs.
    pub action: ActionSpec,
    /// Policy rate (Hz).
    pub control_hz: f64,
    /// Widths of the hidden layers.
    pub hidden: Vec<usize>,
    /// The layers of a network that was not trained here; none: linear layers of those widths with ELU between them.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub layers: Vec<Layer>,
    /// Hidden layers of the encoder of the window, where it has one, and the size of its code.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub encoder: Option<(Vec<usize>, usize)>,
    /// SHA-256 of the motion prior whose latent codes it sees, hexadecimal; empty without.
    #[serde(default)]
    pub prior: String,
    /// Environment steps of training.
    pub steps: u64,
}

impl ControllerFile {
    /// Makes a controller of a policy's file and its prior's. Without the prior it follows references that bring their
    /// latent codes.
    ///
    /// # Errors
    /// A file is damaged, or is no policy or no prior that a controller can run.
    pub fn from_policy(policy: &Checkpoint, prior: Option<&Checkpoint>) -> Result<Self, RobotError> {
        Self::join(policy, prior, sha256(&policy.to_bytes()?))
    }

    /// As [`Self::from_policy`], of a policy's file with this digest.
    pub(super) fn join(policy: &Checkpoint, prior: Option<&Checkpoint>, digest: String) -> Result<Self, RobotError> {
        let of: PolicyHeader = policy.meta(POLICY)?;
        let prior = match (of.observation.reference.latent, prior) {
            (0, _) | (_, None) => None,
            (_, Some(prior)) => Some(PriorEncoder::from_prior(prior)?),
        };
        of.observation.check_sizes()?;
        let header = ControllerHeader {
            version: ControllerHeader::VERSION,
            robot: of.robot,
            parts: ControllerHeader::parts_of(&of.observation),
            observation: of.observation,
            action: of.action,
            control_hz: of.control_hz,
            hidden: of.hidden,
            layers: of.layers,
            encoder: of.encoder,
            prior: prior.as_ref().map(|prior| prior.header().clone()),
            provenance: Provenance { policy: digest, prior: of.prior, steps: of.steps },
            environment: None,
        };
        header.check()?;
        let policy = FrozenPolicy::load(policy, &header)?;
        Self::assemble(header, policy, prior, None)
    }
}

pub(super) fn sha256(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|b| format!("{b:02x}")).collect()
}
