//! Addressed randomness: every stream is keyed by its purpose. Results do not depend on the number of threads or on the
//! order of draws. A resumed run draws the same numbers as an uninterrupted one.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use sha2::{Digest, Sha256};

/// Returns the random stream of one purpose, environment and iteration of a run.
///
/// ```
/// use lifelike_checkpoint::rng::stream;
/// use rand::Rng;
///
/// let draw = |purpose, environment| stream(7, purpose, environment, 0).random::<u64>();
/// assert_eq!(draw("push", 3), draw("push", 3));
/// assert_ne!(draw("push", 3), draw("push", 4));
/// ```
pub fn stream(seed: u64, purpose: &str, environment: u64, iteration: u64) -> ChaCha8Rng {
    let mut hash = Sha256::new();
    hash.update(seed.to_le_bytes());
    hash.update((purpose.len() as u64).to_le_bytes());
    hash.update(purpose.as_bytes());
    hash.update(environment.to_le_bytes());
    hash.update(iteration.to_le_bytes());
    ChaCha8Rng::from_seed(hash.finalize().into())
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::Rng;

    #[test]
    fn every_part_of_the_address_matters_and_nothing_else() {
        let draw = |s, p, e, i| stream(s, p, e, i).random::<u64>();
        let base = draw(1, "action", 2, 3);
        assert_eq!(base, draw(1, "action", 2, 3));
        for other in [draw(2, "action", 2, 3), draw(1, "push", 2, 3), draw(1, "action", 3, 3), draw(1, "action", 2, 4)]
        {
            assert_ne!(base, other);
        }
    }
}
