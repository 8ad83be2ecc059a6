//! Time stamps of a log, and by how much one signal lags behind another.

/// Steps of time that are far longer than the others are gaps.
const GAP: f64 = 4.0;

/// Regularity of a log's time stamps.
#[derive(Debug, Clone, Copy, PartialEq, Default, serde::Serialize)]
pub struct Clock {
    /// Median step (s).
    pub step: f64,
    /// Standard deviation of the steps (s).
    pub jitter: f64,
    /// Longest step (s).
    pub longest: f64,
}

impl Clock {
    /// Looks at time stamps (s).
    ///
    /// # Errors
    /// Index of the first stamp that is not later than the one before, or that comes after a gap, with what was expected and got.
    pub fn of(time: &[f64]) -> Result<Self, (usize, String, String)> {
        let steps: Vec<f64> = time.windows(2).map(|pair| pair[1] - pair[0]).collect();
        if let Some(i) = steps.iter().position(|step| step.is_nan() || *step <= 0.0) {
            let expected = format!("a time after {} s", time[i]);
            return Err((i + 1, expected, format!("{} s", time[i + 1])));
        }
        let mut sorted = steps.clone();
        sorted.sort_by(f64::total_cmp);
        let Some(&step) = sorted.get(sorted.len() / 2) else {
            return Err((0, "at least two times".into(), time.len().to_string()));
        };
        if let Some(i) = steps.iter().position(|own| *own > GAP * step) {
            let expected = format!("no gap longer than {GAP} times the median step of {:.2} ms", 1e3 * step);
            return Err((i + 1, expected, format!("{:.2} ms after {} s", 1e3 * steps[i], time[i])));
        }
        let mean = steps.iter().sum::<f64>() / steps.len() as f64;
        let variance = steps.iter().map(|own| (own - mean).powi(2)).sum::<f64>() / steps.len() as f64;
        Ok(Self { step, jitter: variance.sqrt(), longest: sorted[sorted.len() - 1] })
    }
}

/// Returns by how many steps `late` lags behind `early` (negative: it leads), at most `most`: where the mean square of their
/// difference is least, between steps by a parabola. Signals of one length.
pub fn delay(early: &[f64], late: &[f64], most: usize) -> f64 {
    let n = early.len().min(late.len());
    let most = most.min(n / 4) as isize;
    let error = |lag: isize| -> f64 {
        let (first, last) = (lag.max(0) as usize, (n as isize + lag.min(0)) as usize);
        let pairs = (first..last).map(|i| (late[i] - early[(i as isize - lag) as usize]).powi(2));
        pairs.sum::<f64>() / (last - first).max(1) as f64
    };
    let errors: Vec<f64> = (-most..=most).map(error).collect();
    let Some((best, _)) = errors.iter().enumerate().min_by(|a, b| a.1.total_cmp(b.1)) else { return 0.0 };
    let whole = best as f64 - most as f64;
    match (best.checked_sub(1).map(|i| errors[i]), errors.get(best + 1)) {
        (Some(left), Some(right)) => {
            let bend = left - 2.0 * errors[best] + right;
            if bend > 0.0 { whole + 0.5 * (left - right) / bend } else { whole }
        }
        _ => whole,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_delay_between_steps_is_found() {
        let signal = |lag: f64| -> Vec<f64> {
            (0..400).map(|i| ((f64::from(i) - lag) * 0.05).sin() + 0.3 * ((f64::from(i) - lag) * 0.13).cos()).collect()
        };
        for lag in [0.0, 3.0, 4.5, -2.25] {
            let found = delay(&signal(0.0), &signal(lag), 10);
            assert!((found - lag).abs() < 0.05, "{lag}: {found}");
        }
    }

    #[test]
    fn repeated_times_and_gaps_are_told() {
        assert_eq!(Clock::of(&[0.0, 0.1, 0.1, 0.2]), Err((2, "a time after 0.1 s".into(), "0.1 s".into())));
        let gap = Clock::of(&[0.0, 0.01, 0.02, 0.03, 0.3, 0.31]);
        assert!(matches!(gap, Err((4, _, _))), "{gap:?}");
        assert!(matches!(Clock::of(&[0.0]), Err((0, _, _))));
        assert!(matches!(Clock::of(&[0.0, f64::NAN]), Err((1, _, _))));
    }
}
