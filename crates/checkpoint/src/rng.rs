//! Addressed randomness: every stream is keyed by what it is for, so results do not depend on the number of threads or
//! on who drew first, and a resumed run draws what an uninterrupted one would have drawn.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use sha2::{Digest, Sha256};

/// The stream for one purpose, environment and iteration of a run.
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
