//! A wire with delay, jitter and loss.

use std::collections::BTreeMap;

use rand::Rng;
use rand_chacha::ChaCha8Rng;

/// Packets on their way. Jitter lets them overtake each other.
#[derive(Debug)]
pub struct Link<T> {
    /// Shortest time on the way, and the longest beyond it (ns).
    delay: u64,
    jitter: u64,
    loss: f64,
    rng: ChaCha8Rng,
    /// By time of arrival and number.
    packets: BTreeMap<(u64, u64), T>,
    count: u64,
}

impl<T> Link<T> {
    /// A wire with a delay and a jitter (s) that loses this share of packets.
    pub fn new(delay: f64, jitter: f64, loss: f64, seed: u64, purpose: &str) -> Self {
        Self {
            delay: (delay * 1e9) as u64,
            jitter: (jitter * 1e9) as u64,
            loss,
            rng: lifelike_checkpoint::rng::stream(seed, purpose, 0, 0),
            packets: BTreeMap::new(),
            count: 0,
        }
    }

    /// Puts a packet on the wire at `now` (ns).
    pub fn send(&mut self, now: u64, packet: T) {
        if self.loss > 0.0 && self.rng.random_bool(self.loss) {
            return;
        }
        let jitter = if self.jitter > 0 { self.rng.random_range(0..=self.jitter) } else { 0 };
        self.count += 1;
        self.packets.insert((now + self.delay + jitter, self.count), packet);
    }

    /// Returns the next packet that has arrived by `now` (ns).
    pub fn receive(&mut self, now: u64) -> Option<T> {
        let entry = self.packets.first_entry().filter(|entry| entry.key().0 <= now)?;
        Some(entry.remove())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn packets_take_their_time_and_some_are_lost() {
        let mut link = Link::new(2e-3, 3e-3, 0.25, 1, "test");
        (0..1000u64).for_each(|i| link.send(i * 1_000_000, i));
        assert_eq!(link.receive(1_900_000), None);
        let mut arrived = Vec::new();
        for now in 0..2000u64 {
            while let Some(i) = link.receive(now * 1_000_000) {
                assert!((2..=6).contains(&(now - i)), "{i} at {now}");
                arrived.push(i);
            }
        }
        assert!((700..800).contains(&arrived.len()), "{}", arrived.len());
        assert!(arrived.windows(2).any(|pair| pair[0] > pair[1]), "some overtake others");
    }
}
