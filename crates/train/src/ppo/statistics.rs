//! Moments over all samples, in whichever process they are.

use crate::collective::Collective;

/// Mean of numbers.
pub fn mean(values: &[f32]) -> f64 {
    values.iter().map(|x| f64::from(*x)).sum::<f64>() / values.len() as f64
}

fn variance(values: impl Iterator<Item = f64> + Clone) -> f64 {
    let n = values.clone().count() as f64;
    let mean = values.clone().sum::<f64>() / n;
    values.map(|x| (x - mean).powi(2)).sum::<f64>() / n
}

/// Mean zero, deviation one, over the samples of all processes.
pub fn standardised(mut values: Vec<f32>, all: &dyn Collective) -> Vec<f32> {
    let mut sum = [values.len() as f64, values.iter().map(|x| f64::from(*x)).sum()];
    all.sum_wide(&mut sum);
    let [n, total] = sum;
    let centre = total / n;
    let mut squares = [values.iter().map(|x| (f64::from(*x) - centre).powi(2)).sum::<f64>()];
    all.sum_wide(&mut squares);
    let (centre, deviation) = (centre as f32, (squares[0] / n).sqrt() as f32 + 1e-8);
    values.iter_mut().for_each(|x| *x = (*x - centre) / deviation);
    values
}

/// 1 − Var(returns − values) / Var(returns).
pub fn explained_variance(returns: &[f32], values: &[f32]) -> f64 {
    let left = variance(returns.iter().zip(values).map(|(r, v)| f64::from(r - v)));
    1.0 - left / variance(returns.iter().map(|r| f64::from(*r))).max(1e-12)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::collective::Alone;

    #[test]
    fn explained_variance_is_one_for_the_truth_and_zero_for_a_constant() {
        let returns = [1.0, 2.0, 4.0];
        assert_eq!(explained_variance(&returns, &returns), 1.0);
        assert!(explained_variance(&returns, &[7.0; 3]).abs() < 1e-12);
        assert!(explained_variance(&returns, &[4.0, 2.0, 1.0]) < -1.0);
    }

    #[test]
    fn standardised_values_have_mean_zero_and_deviation_one() {
        let x = standardised(vec![1.0, 2.0, 3.0, 6.0], &Alone);
        assert!(mean(&x).abs() < 1e-6 && (variance(x.iter().map(|x| f64::from(*x))) - 1.0).abs() < 1e-5);
    }
}
