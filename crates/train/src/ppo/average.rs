//! The mean of a policy's parameters over the last part of its training (Polyak and Juditsky 1992): the policy that is written.
//!
//! Steps that are large enough to learn fast end anywhere in a region of policies that are about as good. The middle
//! of the region is better than its points (docs/results/tracking-changes.md). The training itself goes on from the
//! last point.

use lifelike_checkpoint::Checkpoint;

use crate::TrainError;
use crate::networks::Actor;

/// The mean, and how many iterations it has followed.
pub struct PolicyAverage {
    actor: Actor,
    iterations: u64,
}

impl PolicyAverage {
    /// Begins with a policy.
    pub fn new(actor: &Actor) -> Self {
        Self { actor: actor.clone(), iterations: 0 }
    }

    /// Returns the mean.
    pub fn actor(&self) -> &Actor {
        &self.actor
    }

    /// Takes the policy of one iteration more into the mean, which looks back over this share of all iterations: in the beginning,
    /// when every policy is better than the one before, it follows at once.
    pub fn follow(&mut self, actor: &Actor, share: f64) {
        self.iterations += 1;
        let weight = 1.0 / (share * self.iterations as f64).max(1.0);
        self.actor.approach(actor, weight as f32);
    }

    /// Writes it.
    ///
    /// # Errors
    /// Two entries of one name.
    pub fn save_into(&self, checkpoint: &mut Checkpoint, prefix: &str) -> Result<(), TrainError> {
        self.actor.parameters().save_into(checkpoint, prefix)?;
        Ok(checkpoint.put_u64(&iterations(prefix), &[1], vec![self.iterations])?)
    }

    /// Goes on from a checkpoint; one of a time before there was a mean begins with the policy that it has.
    ///
    /// # Errors
    /// The checkpoint is of networks of other sizes.
    pub fn load(checkpoint: &Checkpoint, prefix: &str, actor: &Actor) -> Result<Self, TrainError> {
        let mut average = Self::new(actor);
        if has(checkpoint, prefix) {
            average.actor = actor.load_from(checkpoint, prefix)?;
            average.iterations = checkpoint.u64s(&iterations(prefix), &[1])?[0];
        }
        Ok(average)
    }
}

/// Returns the name of the mean in a run's checkpoint.
pub fn of_run(prefix: &str) -> String {
    format!("{prefix}.average")
}

/// Returns whether a checkpoint has a mean under this name.
pub fn has(checkpoint: &Checkpoint, prefix: &str) -> bool {
    checkpoint.contains(&iterations(prefix))
}

fn iterations(prefix: &str) -> String {
    format!("{prefix}_iterations")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::networks::ActorSize;

    #[test]
    fn it_follows_at_once_and_later_looks_back_over_a_share() {
        let size = ActorSize { inputs: 2, encoder: None, hidden: &[], outputs: 1 };
        // Without hidden layers the outputs are linear in the parameters: their means are the mean's outputs.
        let policies: Vec<Actor> = (1..=4_u8).map(|i| Actor::init(size.clone(), f64::from(i), i.into())).collect();
        let said = |actor: &Actor| [actor.means(&[30.0, -20.0])[0], actor.log_std()[0]];
        let mut average = PolicyAverage::new(&policies[3]);
        let mut expected = [0.0; 2];
        // Windows of 1, 1, 1.5, 2.
        for (policy, weight) in policies.iter().zip([1.0, 1.0, 2.0 / 3.0, 0.5]) {
            average.follow(policy, 0.5);
            expected.iter_mut().zip(said(policy)).for_each(|(mean, x)| *mean += weight * (x - *mean));
            for (got, expected) in said(average.actor()).iter().zip(expected) {
                assert!((got - expected).abs() < 1e-5, "{got} {expected}");
            }
        }
        assert!(said(&policies[0]).iter().zip(said(&policies[3])).all(|(a, b)| (a - b).abs() > 0.01), "they differ");
    }
}
