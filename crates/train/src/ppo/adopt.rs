//! Networks of another training, to begin with. They may have seen less: numbers that are new count for nothing at first.

use lifelike_checkpoint::Checkpoint;
use lifelike_nn::normalizer::RunningNormalizer;
use lifelike_nn::parameters::Parameters;
use lifelike_nn::rows::Entry;

use super::Learner;
use super::average::{self, PolicyAverage};
use crate::{FromInput, TrainError};

/// First weights of the policy and of the value function: the only ones that depend on what is seen.
const FIRST_OF_POLICY: &str = "mean.layers.0.weight";
const FIRST_OF_VALUE: &str = "value.layers.0.weight";

/// Names under which networks and what their inputs are normalised with stand in a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SavedNetworks {
    /// The policy.
    pub actor: String,
    /// The normalizer of its observations.
    pub actor_normalizer: String,
    /// The value function, which a file may lack.
    pub critic: String,
    /// The normalizer of its observations.
    pub critic_normalizer: String,
}

impl SavedNetworks {
    /// Names in the checkpoint of a run, below the learner's own. The policy is the averaged one, which its file has too.
    pub fn of_run(checkpoint: &Checkpoint, prefix: &str) -> Self {
        let name = |name: &str| format!("{prefix}.{name}");
        let average = average::of_run(prefix);
        Self {
            actor: if average::has(checkpoint, &average) { average } else { name("actor") },
            actor_normalizer: name("actor_normalizer"),
            critic: name("critic"),
            critic_normalizer: name("critic_normalizer"),
        }
    }
}

/// The place in the other's row of each number of a row; none for numbers that the other did not see.
#[derive(Debug, Clone, Copy)]
pub struct Inputs<'a> {
    /// Rows of the policy.
    pub policy: &'a [Option<usize>],
    /// Rows of the value function.
    pub value: &'a [Option<usize>],
}

impl Learner {
    /// Takes over the networks of another training, and what their inputs are normalised with. Returns whether the value function
    /// came along: where the file has none, or one with other layers, it stays fresh. Without `inputs` rows are the same.
    ///
    /// # Errors
    /// The policy is of other sizes.
    pub fn adopt(
        &mut self,
        checkpoint: &Checkpoint,
        names: &SavedNetworks,
        inputs: Option<Inputs<'_>>,
    ) -> Result<bool, TrainError> {
        let (policy, value) = inputs.map(|inputs| (inputs.policy, inputs.value)).unzip();
        *self.actor.parameters_mut() =
            load(checkpoint, &names.actor, FIRST_OF_POLICY, self.actor.parameters(), policy)?;
        self.average = PolicyAverage::new(&self.actor);
        self.actor_normalizer = normalizer(checkpoint, &names.actor_normalizer, &self.actor_normalizer, policy)?;
        let has = checkpoint.contains(&format!("{}.mean", names.critic_normalizer));
        if !has || !alike(checkpoint, &names.critic, FIRST_OF_VALUE, self.critic.parameters()) {
            return Ok(false);
        }
        *self.critic.parameters_mut() =
            load(checkpoint, &names.critic, FIRST_OF_VALUE, self.critic.parameters(), value)?;
        self.critic_normalizer = normalizer(checkpoint, &names.critic_normalizer, &self.critic_normalizer, value)?;
        Ok(true)
    }
}

/// Returns true when a file has the layers of a network, whatever the first of them sees.
fn alike(checkpoint: &Checkpoint, prefix: &str, first: &str, parameters: &Parameters) -> bool {
    parameters.layout().entries().iter().all(|Entry { name, shape, .. }| {
        let stored = checkpoint.entry(&format!("{prefix}.{name}")).map(|entry| entry.shape().to_vec());
        stored.is_ok_and(|stored| if name == first { stored.get(1) == shape.get(1) } else { stored == *shape })
    })
}

/// Returns a network with the parameters of a file, the rows of its first weights where `places` says.
fn load(
    checkpoint: &Checkpoint,
    prefix: &str,
    first: &str,
    parameters: &Parameters,
    places: Option<&[Option<usize>]>,
) -> Result<Parameters, TrainError> {
    let first = format!("{prefix}.{first}");
    let shape = checkpoint.entry(&first)?.shape().to_vec();
    let (&[rows, columns], Some(places)) = (shape.as_slice(), places) else {
        return Ok(parameters.load_from(checkpoint, prefix)?);
    };
    let stored = checkpoint.f32s(&first, &shape)?;
    let mut weights = Vec::with_capacity(places.len() * columns);
    for place in places {
        match place {
            Some(row) if *row < rows => weights.extend_from_slice(&stored[row * columns..(row + 1) * columns]),
            Some(row) => return Err(beyond(&first, rows, *row)),
            None => weights.resize(weights.len() + columns, 0.0),
        }
    }
    let mut grown = Checkpoint::new();
    let under = format!("{prefix}.");
    for (name, entry) in checkpoint.entries().iter().filter(|(name, _)| name.starts_with(&under) && **name != first) {
        grown.put(name, entry.clone())?;
    }
    grown.put_f32(&first, &[places.len(), columns], weights)?;
    Ok(parameters.load_from(&grown, prefix)?)
}

/// Returns the normalizer of a file; numbers that it does not have keep the scale of the `fresh` one.
fn normalizer(
    checkpoint: &Checkpoint,
    prefix: &str,
    fresh: &RunningNormalizer,
    places: Option<&[Option<usize>]>,
) -> Result<RunningNormalizer, TrainError> {
    let name = format!("{prefix}.mean");
    let size = match places {
        None => fresh.size(),
        Some(_) => checkpoint.entry(&name)?.shape().iter().product(),
    };
    let mut stored = RunningNormalizer::load_from(checkpoint, prefix, size)?;
    stored.set_frozen(false);
    let Some(places) = places else { return Ok(stored) };
    match places.iter().flatten().find(|place| **place >= size) {
        Some(place) => Err(beyond(&name, size, *place)),
        None => Ok(stored.rearranged(fresh, places)),
    }
}

fn beyond(name: &str, size: usize, got: usize) -> TrainError {
    TrainError::mismatch(format!("rows of {name}"), format!("more than {got}"), size)
}
