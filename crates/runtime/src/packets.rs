//! Order, loss and age of packets.

/// Verdict on one packet.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Arrival {
    /// Newer than all before it, with the number of packets lost in between.
    New {
        /// Packets that never came, or come later and are then dropped.
        lost: u32,
    },
    /// The same packet again.
    Repeated,
    /// Older than one that has arrived.
    Reordered,
}

/// Counts of packets.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct Counts {
    /// Packets that were used.
    pub used: u64,
    /// Gaps in the sequence.
    pub lost: u64,
    /// Packets that came twice.
    pub repeated: u64,
    /// Packets that came after a newer one.
    pub reordered: u64,
    /// Packets with numbers that are not finite.
    pub non_finite: u64,
    /// Ticks after more than half of the longest time without a packet.
    pub late_ticks: u64,
}

/// The sequence and the clocks of one machine.
#[derive(Debug, Clone, Default)]
pub struct Monitor {
    /// Counts since the start.
    pub counts: Counts,
    last: Option<(u32, u64)>,
    /// Arrival of the last packet that was used (ns, our clock).
    arrived: u64,
    /// Least difference between our clock and the robot's (ns): the fastest packet.
    offset: Option<i128>,
    /// Age of the last packet beyond that of the fastest (ns).
    delay: i128,
}

impl Monitor {
    /// Looks at a packet that arrives at `now` (ns).
    pub fn arrival(&mut self, now: u64, sequence: u32, clock: u64) -> Arrival {
        let verdict = match self.last {
            None => Arrival::New { lost: 0 },
            Some((last, _)) => match sequence.wrapping_sub(last) {
                0 => Arrival::Repeated,
                ahead if ahead < 1 << 31 => Arrival::New { lost: ahead - 1 },
                _ => Arrival::Reordered,
            },
        };
        match verdict {
            Arrival::New { lost } => {
                self.counts.used += 1;
                self.counts.lost += u64::from(lost);
                self.last = Some((sequence, clock));
                self.arrived = now;
                let difference = i128::from(now) - i128::from(clock);
                let least = self.offset.map_or(difference, |offset| offset.min(difference));
                self.delay = difference - self.offset.unwrap_or(difference);
                self.offset = Some(least);
            }
            Arrival::Repeated => self.counts.repeated += 1,
            Arrival::Reordered => self.counts.reordered += 1,
        }
        verdict
    }

    /// Returns the time since the last packet that was used (s).
    pub fn silence(&self, now: u64) -> f64 {
        now.saturating_sub(self.arrived) as f64 * 1e-9
    }

    /// Returns the delay of the last packet beyond that of the fastest (s): negative when it was the fastest by so much.
    pub fn delay(&self) -> f64 {
        self.delay as f64 * 1e-9
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn order_is_judged_by_the_sequence_and_survives_its_wrap() {
        let mut monitor = Monitor::default();
        let order = [
            (u32::MAX - 1, Arrival::New { lost: 0 }),
            (u32::MAX, Arrival::New { lost: 0 }),
            (u32::MAX, Arrival::Repeated),
            (1, Arrival::New { lost: 1 }),
            (0, Arrival::Reordered),
            (5, Arrival::New { lost: 3 }),
        ];
        for (now, (sequence, expected)) in order.into_iter().enumerate() {
            assert_eq!(monitor.arrival(now as u64, sequence, now as u64), expected, "{sequence}");
        }
        let Counts { used, lost, repeated, reordered, .. } = monitor.counts;
        assert_eq!((used, lost, repeated, reordered), (4, 4, 1, 1));
    }

    #[test]
    fn delay_and_silence_are_differences_of_clocks() {
        let mut monitor = Monitor::default();
        monitor.arrival(5_000_000, 1, 1_000_000);
        assert_eq!(monitor.delay(), 0.0);
        monitor.arrival(17_000_000, 2, 3_000_000);
        assert_eq!(monitor.delay(), 0.01, "14 ms apart, where the fastest was 4 ms");
        monitor.arrival(18_000_000, 3, 1_018_000_000);
        assert_eq!(monitor.delay(), -1.004, "a clock that jumps ahead by a second");
        assert_eq!(monitor.silence(20_000_000), 0.002);
    }
}
