//! The networks that a training begins with, where its plan names others than fresh ones (`init`).

use std::path::Path;

use lifelike_checkpoint::Checkpoint;
use lifelike_report::run::RunFolder;
use lifelike_robot::ObservationSpec;
use lifelike_robot::controller::{ControllerHeader, KIND};
use lifelike_train::ppo::{Inputs, SavedNetworks};

use super::Trainer;
use super::task::KEEP;
use crate::policy;
use crate::{FromInput, TrackerError};

/// Account of the networks that a training began with.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Beginning {
    /// The value function was taken over too; else it is fresh.
    pub value_function: bool,
    /// Parts of the observation that the other policy did not see, by name; they count for nothing at first.
    pub new_parts: Vec<String>,
}

impl Trainer {
    /// Begins with the networks of a controller's file or of a run (`plan.init`). The plan's policy may see more than the
    /// other did.
    ///
    /// # Errors
    /// There is nothing of the kind, or it sees something that this plan's policy does not, or moves something else.
    pub fn initialised(mut self, path: &Path) -> Result<(Self, Beginning), TrackerError> {
        let (checkpoint, names) = if path.is_dir() {
            let checkpoints = RunFolder::open(path)?.checkpoints(KEEP);
            let Some((info, bytes)) = checkpoints.latest() else {
                return Err(TrackerError::mismatch(path.display(), "a run with a checkpoint", "none"));
            };
            let checkpoint = Checkpoint::from_bytes(&bytes, &checkpoints.path(info.iteration))?;
            let names = SavedNetworks::of_run(&checkpoint, "learner");
            (checkpoint, names)
        } else {
            (Checkpoint::load(path)?, policy::networks())
        };
        if !checkpoint.contains(&format!("{}.log_std", names.actor)) {
            let expected =
                "a controller as training writes it, with the width of its noise and its value function".into();
            return Err(mismatch(path, "networks", expected, "one as `lifelike export` writes it".into()));
        }
        let other: ControllerHeader = checkpoint.meta(KIND)?;
        self.alike(path, &other)?;
        let (policy, new_parts) = self.inputs(path, &other.observation)?;
        let same = self.environment.observation().size() == other.observation.size() && new_parts.is_empty();
        if !same && (other.encoder.is_some() || other.memory.is_some()) {
            let expected = format!("none beside {}, which are new to it", new_parts.join(", "));
            return Err(mismatch(path, "encoder", expected, "one".into()));
        }
        // The value function sees the policy's parts less history and window, and then what only a simulation knows.
        let unencoded = |spec: &ObservationSpec| spec.size() - spec.window_size() - spec.history_size();
        let (now, before) = (unencoded(self.environment.observation()), unencoded(&other.observation));
        let known = self.environment.critic_size() - now;
        let mut value = policy[..now].to_vec();
        value.extend((0..known).map(|i| Some(before + i)));
        let inputs = (!same).then_some(Inputs { policy: &policy, value: &value });
        let value_function = self.learner.adopt(&checkpoint, &names, inputs)?;
        Ok((self, Beginning { value_function, new_parts }))
    }

    /// Checks that the outputs of another policy mean the same, and that it is of the same make.
    fn alike(&self, path: &Path, other: &ControllerHeader) -> Result<(), TrackerError> {
        other.check_robot(&self.robot)?;
        let latent = other.observation.reference.latent > 0;
        let prior = |header: &ControllerHeader| if latent { header.provenance.prior.clone() } else { String::new() };
        let make = |header: &ControllerHeader| {
            [
                ("action", format!("{:?}", header.action)),
                ("hidden layers", format!("{:?}", header.hidden)),
                ("encoder", format!("{:?}", header.encoder)),
                ("memory", format!("{:?}", header.memory)),
                ("prior", prior(header)),
            ]
        };
        let different = make(&self.header()).into_iter().zip(make(other)).find(|(own, other)| own != other);
        match different {
            None => Ok(()),
            Some(((what, expected), (_, got))) => Err(mismatch(path, what, expected, got)),
        }
    }

    /// Returns the place in the other policy's observation of each number of this one's, and the names of the parts that are new.
    fn inputs(&self, path: &Path, other: &ObservationSpec) -> Result<(Vec<Option<usize>>, Vec<String>), TrackerError> {
        let spec = self.environment.observation();
        let (parts, others) = (spec.parts(), other.parts());
        let sees = |name: &str, size: usize| parts.iter().any(|p| p.name == name && p.range.len() == size);
        if let Some(lost) = others.iter().find(|part| !sees(&part.name, part.range.len())) {
            let names: Vec<&str> = parts.iter().map(|part| part.name.as_str()).collect();
            let expected = format!("parts of this plan's observation ({}) of the same sizes", names.join(", "));
            return Err(mismatch(path, "inputs", expected, format!("'{}' of {} numbers", lost.name, lost.range.len())));
        }
        let (mut places, mut new) = (vec![None; spec.size()], Vec::new());
        for part in parts {
            match others.iter().find(|other| other.name == part.name) {
                Some(other) => part.range.zip(other.range.clone()).for_each(|(to, from)| places[to] = Some(from)),
                None => new.push(part.name),
            }
        }
        Ok((places, new))
    }
}

fn mismatch(path: &Path, what: &str, expected: String, got: String) -> TrackerError {
    TrackerError::mismatch(format!("{what} of the policy of {}", path.display()), expected, got)
}
