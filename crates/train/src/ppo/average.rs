//! The mean of a policy's parameters over the last part of its training (Polyak and Juditsky 1992): the policy that is written.
//!
//! Steps that are large enough to learn fast end anywhere in a region of policies that are about as good; the middle of the region
//! is better than its points (docs/results/tracking-hard.md). The training itself goes on from the last point.

use burn::module::Module;
use lifelike_checkpoint::Checkpoint;
use lifelike_nn::ModuleCheckpoint;
use lifelike_nn::device;

use crate::TrainError;
use crate::networks::Actor;

/// The mean, and how many iterations it has followed.
pub struct PolicyAverage {
    actor: Actor,
    numbers: Vec<f32>,
    iterations: u64,
}

impl PolicyAverage {
    /// Begins with a policy.
    pub fn new(actor: &Actor) -> Result<Self, TrainError> {
        let actor = actor.clone().fork(&device::inference());
        Ok(Self { numbers: actor.numbers()?, actor, iterations: 0 })
    }

    /// Returns the mean, for the CPU.
    pub fn actor(&self) -> &Actor {
        &self.actor
    }

    /// Takes the policy of one iteration more into the mean, which looks back over this share of all iterations: in the beginning,
    /// when every policy is better than the one before, it follows at once.
    pub fn follow(&mut self, actor: &Actor, share: f64) -> Result<(), TrainError> {
        self.iterations += 1;
        let weight = 1.0 / (share * self.iterations as f64).max(1.0);
        let latest = actor.numbers()?;
        self.numbers.iter_mut().zip(latest).for_each(|(mean, x)| *mean += weight as f32 * (x - *mean));
        self.actor = self.actor.clone().with_numbers(&self.numbers)?;
        Ok(())
    }

    /// Writes it.
    ///
    /// # Errors
    /// Two entries of one name.
    pub fn save_into(&self, checkpoint: &mut Checkpoint, prefix: &str) -> Result<(), TrainError> {
        checkpoint.put_module(prefix, &self.actor)?;
        Ok(checkpoint.put_u64(&iterations(prefix), &[1], vec![self.iterations])?)
    }

    /// Goes on from a checkpoint; one of a time before there was a mean begins with the policy that it has.
    ///
    /// # Errors
    /// The checkpoint is of networks of other sizes.
    pub fn load(checkpoint: &Checkpoint, prefix: &str, actor: &Actor) -> Result<Self, TrainError> {
        let mut average = Self::new(actor)?;
        if has(checkpoint, prefix) {
            average.actor = checkpoint.load_module(prefix, average.actor)?;
            average.numbers = average.actor.numbers()?;
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
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::networks::ActorSize;

    #[test]
    fn it_follows_at_once_and_later_looks_back_over_a_share() {
        let size = ActorSize { inputs: 2, window: 0, encoder: &[], code: 0, hidden: &[], outputs: 1 };
        let actor = Actor::init(size, 1.0, 0, &device::inference());
        let at = |x: f32| actor.clone().with_numbers(&vec![x; actor.numbers().unwrap().len()]).unwrap();
        let mut average = PolicyAverage::new(&at(5.0)).unwrap();
        let mut after = |x: f32| {
            average.follow(&at(x), 0.5).unwrap();
            let numbers = average.actor().numbers().unwrap();
            assert!(numbers.iter().all(|y| *y == numbers[0]));
            numbers[0]
        };
        // Windows of 1, 1, 1.5, 2: weights of 1, 1, 2/3, 1/2.
        assert_eq!([after(1.0), after(4.0), after(1.0), after(4.0)], [1.0, 4.0, 2.0, 3.0]);
    }
}
