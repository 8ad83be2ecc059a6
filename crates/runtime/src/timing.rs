//! Distribution of times without allocation.

/// Buckets per power of two.
const FINE: u32 = 8;
const BUCKETS: usize = 40 * FINE as usize;

/// Counts of times in buckets an eighth of a power of two wide: quantiles are at most 12.5% too large.
#[derive(Debug, Clone)]
pub struct Histogram {
    counts: [u64; BUCKETS],
    count: u64,
    sum: u128,
    max: u64,
}

impl Default for Histogram {
    fn default() -> Self {
        Self { counts: [0; BUCKETS], count: 0, sum: 0, max: 0 }
    }
}

impl Histogram {
    /// Adds a time (ns).
    pub fn add(&mut self, nanoseconds: u64) {
        self.counts[bucket(nanoseconds)] += 1;
        self.count += 1;
        self.sum += u128::from(nanoseconds);
        self.max = self.max.max(nanoseconds);
    }

    /// Returns the upper end of the bucket that holds a quantile (µs); the largest time at most.
    pub fn quantile(&self, q: f64) -> f64 {
        let wanted = (q * self.count as f64).ceil().max(1.0) as u64;
        let mut seen = 0;
        for (i, count) in self.counts.iter().enumerate() {
            seen += count;
            if seen >= wanted {
                return upper(i).min(self.max) as f64 * 1e-3;
            }
        }
        self.max as f64 * 1e-3
    }

    /// Returns count, mean, median, 99%, 99.9% and largest time.
    pub fn quantiles(&self) -> Quantiles {
        Quantiles {
            count: self.count,
            mean_us: self.sum as f64 * 1e-3 / self.count.max(1) as f64,
            p50_us: self.quantile(0.5),
            p99_us: self.quantile(0.99),
            p999_us: self.quantile(0.999),
            max_us: self.max as f64 * 1e-3,
        }
    }
}

/// Distribution of a time (µs).
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Quantiles {
    /// Number of times.
    pub count: u64,
    /// Mean.
    pub mean_us: f64,
    /// Median.
    pub p50_us: f64,
    /// 99%.
    pub p99_us: f64,
    /// 99.9%.
    pub p999_us: f64,
    /// Largest.
    pub max_us: f64,
}

fn bucket(nanoseconds: u64) -> usize {
    let power = 63 - (nanoseconds | 1).leading_zeros();
    if power < 3 {
        return nanoseconds as usize;
    }
    let within = (nanoseconds >> (power - 3)) as usize & (FINE as usize - 1);
    ((power as usize - 2) * FINE as usize + within).min(BUCKETS - 1)
}

/// Largest time of a bucket (ns).
fn upper(bucket: usize) -> u64 {
    let (power, within) = (bucket / FINE as usize, bucket as u64 % u64::from(FINE));
    if power == 0 {
        return bucket as u64;
    }
    ((within + u64::from(FINE) + 1) << (power - 1)) - 1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn buckets_hold_what_they_say() {
        for time in (0..2000).chain([4095, 4096, 1_000_000, 123_456_789, 10_000_000_000]) {
            let i = bucket(time);
            assert!(upper(i) >= time && (i == 0 || upper(i - 1) < time), "{time} in {i}");
            assert!(upper(i) as f64 <= 1.125 * time as f64 + 1.0);
        }
    }

    #[test]
    fn quantiles_are_those_of_the_times() {
        let mut histogram = Histogram::default();
        (1..=1000).for_each(|time| histogram.add(time * 1000));
        let Quantiles { mean_us, p50_us, p99_us, max_us, count, .. } = histogram.quantiles();
        assert_eq!((count, max_us), (1000, 1000.0));
        assert!(
            (mean_us - 500.5).abs() < 1e-9 && (500.0..562.0).contains(&p50_us) && (990.0..=1000.0).contains(&p99_us)
        );
    }
}
