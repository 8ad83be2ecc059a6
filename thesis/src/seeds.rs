//! Summary of several seeds of one training.

/// Mean and half the range.
pub fn spread(values: impl Iterator<Item = f64> + Clone) -> (f64, f64) {
    let n = values.clone().count() as f64;
    let (low, high) = values.clone().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
    (values.sum::<f64>() / n, 0.5 * (high - low))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spread_by_hand() {
        assert_eq!(spread([1.0, 2.0, 6.0].into_iter()), (3.0, 2.5));
        assert_eq!(spread([4.0].into_iter()), (4.0, 0.0));
    }
}
