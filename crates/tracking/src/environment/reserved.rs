//! Environments that are kept for some of the clips: an exact share of the steps, whatever the clips' lengths.

use lifelike_train::limits::range;
use rand_chacha::ChaCha8Rng;

use super::Environment;
use crate::TrackerError;
use crate::reference::RsiSampler;

/// Samplers of the environments that are kept for some clips, the first ones, and of the others.
#[derive(Debug, Clone)]
pub(super) struct Reserved {
    count: usize,
    samplers: [RsiSampler; 2],
}

impl Reserved {
    /// Returns the sampler of environment `i`.
    pub(super) fn sampler(&self, i: usize) -> &RsiSampler {
        &self.samplers[usize::from(i >= self.count)]
    }
}

/// Returns the number of environments of `n` that a share of them is, at least one on either side of a share between.
fn reserved_count(n: usize, share: f64) -> usize {
    let count = (n as f64 * share).round() as usize;
    if share > 0.0 && share < 1.0 && n > 1 { count.clamp(1, n - 1) } else { count.min(n) }
}

impl Environment {
    /// Keeps a share of the environments for the clips with a flag, and the others for the clips without; all begin anew.
    /// Nothing changes where no clip or every clip has one.
    ///
    /// # Errors
    /// A share outside of 0 to 1; the simulation refuses.
    pub fn reserve(&mut self, clips: &[bool], share: f64) -> Result<(), TrackerError> {
        range("share of environments for some of the clips", share, 0.0, 1.0)?;
        let others: Vec<bool> = clips.iter().map(|flag| !flag).collect();
        let (Some(first), Some(rest)) = (self.rsi.only(clips), self.rsi.only(&others)) else { return Ok(()) };
        self.reserved = Some(Reserved { count: reserved_count(self.len(), share), samplers: [first, rest] });
        self.reset(&(0..self.len()).collect::<Vec<_>>(), None)
    }

    /// Draws a frame for environment `i` to begin at.
    pub(super) fn draw(&self, i: usize, rng: &mut ChaCha8Rng) -> usize {
        self.reserved.as_ref().map_or(&self.rsi, |reserved| reserved.sampler(i)).draw(rng)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_share_between_nothing_and_everything_leaves_an_environment_on_either_side() {
        assert_eq!((reserved_count(512, 0.5), reserved_count(512, 0.25)), (256, 128));
        assert_eq!((reserved_count(10, 0.01), reserved_count(10, 0.99)), (1, 9));
        assert_eq!((reserved_count(10, 0.0), reserved_count(10, 1.0), reserved_count(1, 0.5)), (0, 10, 1));
    }
}
