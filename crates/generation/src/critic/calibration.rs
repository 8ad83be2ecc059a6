//! Rank agreement of predictions with measurements.

use lifelike_checkpoint::rng::stream;
use rand::Rng;

/// Resamples of a bootstrap.
const RESAMPLES: u64 = 1000;

/// Returns the rank of each number from 1, equal ones sharing their mean rank.
fn ranks(values: &[f64]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|a, b| values[*a].total_cmp(&values[*b]));
    let mut ranks = vec![0.0; values.len()];
    let mut first = 0;
    for equal in order.chunk_by(|a, b| values[*a] == values[*b]) {
        let rank = first as f64 + (equal.len() as f64 + 1.0) / 2.0;
        equal.iter().for_each(|i| ranks[*i] = rank);
        first += equal.len();
    }
    ranks
}

/// Returns Spearman's rank correlation, NaN where one side is constant.
///
/// # Panics
/// The lengths differ.
pub fn spearman(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len(), "pairs of a rank correlation");
    let (a, b) = (ranks(a), ranks(b));
    let mean = (a.len() as f64 + 1.0) / 2.0;
    let sum = |x: &[f64], y: &[f64]| x.iter().zip(y).map(|(x, y)| (x - mean) * (y - mean)).sum::<f64>();
    sum(&a, &b) / (sum(&a, &a) * sum(&b, &b)).sqrt()
}

/// Returns the area under the ROC curve: the probability that a positive has a higher score than a negative, ties counting
/// half (Mann & Whitney 1947). NaN where one of the classes is empty.
///
/// # Panics
/// The lengths differ.
pub fn auc(scores: &[f64], positive: &[bool]) -> f64 {
    assert_eq!(scores.len(), positive.len(), "scores and their classes");
    let ranks = ranks(scores);
    let positives = positive.iter().filter(|p| **p).count() as f64;
    let negatives = positive.len() as f64 - positives;
    let sum: f64 = ranks.iter().zip(positive).filter(|(_, p)| **p).map(|(rank, _)| rank).sum();
    (sum - positives * (positives + 1.0) / 2.0) / (positives * negatives)
}

/// Returns the 95% interval of a statistic of samples that come in groups (the episodes of a clip). It draws groups
/// with replacement, and takes percentiles of 1000 resamples; those for which the statistic is NaN are left out.
///
/// `statistic` gets the numbers of the samples of a resample.
pub fn bootstrap(groups: &[usize], seed: u64, statistic: impl Fn(&[usize]) -> f64) -> [f64; 2] {
    let count = groups.iter().max().map_or(0, |last| last + 1);
    let mut members = vec![Vec::new(); count];
    groups.iter().enumerate().for_each(|(sample, group)| members[*group].push(sample));
    members.retain(|members| !members.is_empty());
    let mut values: Vec<f64> = Vec::new();
    for resample in 0..if members.is_empty() { 0 } else { RESAMPLES } {
        let mut rng = stream(seed, "bootstrap", 0, resample);
        let drawn = (0..members.len()).map(|_| rng.random_range(0..members.len()));
        let samples: Vec<usize> = drawn.flat_map(|group| members[group].iter().copied()).collect();
        values.extend(Some(statistic(&samples)).filter(|value| !value.is_nan()));
    }
    values.sort_by(f64::total_cmp);
    let at = |share: f64| values.get((share * (values.len().max(1) - 1) as f64).round() as usize).copied();
    [0.025, 0.975].map(|share| at(share).unwrap_or(f64::NAN))
}

/// A linear model of standardized features: ridge regression.
#[derive(Debug, Clone, PartialEq)]
pub struct Ridge {
    mean: Vec<f64>,
    std: Vec<f64>,
    weights: Vec<f64>,
    level: f64,
}

impl Ridge {
    /// Fits targets `[n]` to rows `[n, width]` with the penalty `n λ |w|²` on standardized features.
    ///
    /// # Panics
    /// There are not as many rows as targets, or none.
    pub fn fit(rows: &[Vec<f64>], targets: &[f64], penalty: f64) -> Self {
        assert!(rows.len() == targets.len() && !rows.is_empty(), "rows and targets of a regression");
        let (n, width) = (rows.len() as f64, rows[0].len());
        let column = |i: usize| rows.iter().map(move |row| row[i]);
        let mean: Vec<f64> = (0..width).map(|i| column(i).sum::<f64>() / n).collect();
        let square = |i: usize| column(i).map(|x| (x - mean[i]).powi(2)).sum::<f64>() / n;
        let std: Vec<f64> = (0..width).map(|i| square(i).sqrt().max(1e-9)).collect();
        let level = targets.iter().sum::<f64>() / n;
        let standard: Vec<Vec<f64>> =
            rows.iter().map(|row| (0..width).map(|i| (row[i] - mean[i]) / std[i]).collect()).collect();
        let mut equations = vec![vec![0.0; width + 1]; width];
        for (row, target) in standard.iter().zip(targets) {
            for (i, equation) in equations.iter_mut().enumerate() {
                (0..width).for_each(|j| equation[j] += row[i] * row[j]);
                equation[width] += row[i] * (target - level);
            }
        }
        (0..width).for_each(|i| equations[i][i] += penalty * n);
        Self { mean, std, weights: solve(equations), level }
    }

    /// Returns the prediction for a row.
    pub fn predict(&self, row: &[f64]) -> f64 {
        let standard = row.iter().zip(&self.mean).zip(&self.std).map(|((x, m), s)| (x - m) / s);
        self.level + standard.zip(&self.weights).map(|(x, w)| x * w).sum::<f64>()
    }
}

/// Solves symmetric positive definite equations `[n, n + 1]`, the right side last, by elimination.
fn solve(mut equations: Vec<Vec<f64>>) -> Vec<f64> {
    let n = equations.len();
    for i in 0..n {
        for j in i + 1..n {
            let factor = equations[j][i] / equations[i][i];
            let (above, below) = equations.split_at_mut(j);
            below[0].iter_mut().zip(&above[i]).skip(i).for_each(|(x, y)| *x -= factor * y);
        }
    }
    let mut x = vec![0.0; n];
    for i in (0..n).rev() {
        let known: f64 = (i + 1..n).map(|j| equations[i][j] * x[j]).sum();
        x[i] = (equations[i][n] - known) / equations[i][i];
    }
    x
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[derive(serde::Deserialize)]
    struct Fixture {
        a: Vec<f64>,
        b: Vec<f64>,
        positive: Vec<bool>,
        spearman: f64,
        auc: f64,
        rows: Vec<Vec<f64>>,
        penalty: f64,
        ridge: Vec<f64>,
    }

    #[test]
    fn correlation_auc_and_ridge_are_those_of_scipy_and_numpy() {
        let fixture: Fixture =
            serde_json::from_str(include_str!("../../tests/fixtures/calibration/calibration.json")).unwrap();
        assert!((spearman(&fixture.a, &fixture.b) - fixture.spearman).abs() < 1e-12);
        assert!((auc(&fixture.a, &fixture.positive) - fixture.auc).abs() < 1e-12);
        let ridge = Ridge::fit(&fixture.rows, &fixture.b, fixture.penalty);
        for (row, expected) in fixture.rows.iter().zip(&fixture.ridge) {
            assert!((ridge.predict(row) - expected).abs() < 1e-10, "{} for {expected}", ridge.predict(row));
        }
    }

    #[test]
    fn a_class_without_members_and_constants_have_no_number() {
        assert!(auc(&[1.0, 2.0], &[true, true]).is_nan());
        assert!(spearman(&[1.0, 1.0], &[1.0, 2.0]).is_nan());
    }

    #[test]
    fn an_interval_of_a_mean_is_as_wide_as_its_standard_error_says() {
        // 200 groups of two equal numbers, uniform on 0..1: the mean of the groups has a standard error of 0.0204.
        let values: Vec<f64> = (0..400).map(|i| f64::from(i / 2 * 37 % 200) / 200.0).collect();
        let groups: Vec<usize> = (0..400).map(|i| i / 2).collect();
        let mean = |samples: &[usize]| samples.iter().map(|i| values[*i]).sum::<f64>() / samples.len() as f64;
        let [low, high] = bootstrap(&groups, 3, mean);
        assert!((high - low - 2.0 * 1.96 * 0.0204).abs() < 0.012, "{low} to {high}");
        assert_eq!(bootstrap(&groups, 3, mean), [low, high]);
        assert!(bootstrap(&[], 0, mean)[0].is_nan());
    }
}
