//! The loss that tells the pairs of a batch apart.

use burn::tensor::activation::log_softmax;
use burn::tensor::{Tensor, TensorData};

/// Taken off the score of a pair that is not told apart.
const EXCLUDED: f32 = -1e9;

/// Returns the mean over both directions of −log softmax of −d²/2 (InfoNCE, van den Oord et al. 2018), d the Euclidean
/// distance by which the metrics compare: the log-likelihood of finding the own motion for a sentence, and the own
/// sentence for a motion.
///
/// `kinds[i]` is the same for rows of the same sentence: those are not told apart.
///
/// # Shapes
/// `text, motion: [B, width]`, row i of both belongs together.
pub fn contrastive_loss(text: Tensor<2>, motion: Tensor<2>, kinds: &[usize]) -> Tensor<1> {
    let (n, device) = (kinds.len(), text.device());
    let excluded = |(i, j): (usize, usize)| if i != j && kinds[i] == kinds[j] { EXCLUDED } else { 0.0 };
    let pairs = || (0..n).flat_map(|i| (0..n).map(move |j| (i, j)));
    let square = |values: Vec<f32>| Tensor::<2>::from_data(TensorData::new(values, [n, n]), &device);
    let own = square(pairs().map(|(i, j)| if i == j { 1.0 } else { 0.0 }).collect());
    // −d²/2 = t·m − |t|²/2 − |m|²/2
    let half = |x: &Tensor<2>| x.clone().square().sum_dim(1).mul_scalar(0.5);
    let (halves_t, halves_m) = (half(&text), half(&motion).transpose());
    let scores = text.matmul(motion.transpose()) - halves_t - halves_m + square(pairs().map(excluded).collect());
    let found = log_softmax(scores.clone(), 1) + log_softmax(scores, 0);
    (found * own).sum().mul_scalar(-0.5 / n as f64)
}

#[cfg(test)]
mod tests {
    use lifelike_nn::device;

    use super::*;

    fn loss(text: &[f32], motion: &[f32], kinds: &[usize]) -> f64 {
        let n = kinds.len();
        let tensor =
            |x: &[f32]| Tensor::<2>::from_data(TensorData::new(x.to_vec(), [n, x.len() / n]), &device::inference());
        f64::from(contrastive_loss(tensor(text), tensor(motion), kinds).into_scalar::<f32>())
    }

    #[test]
    fn it_is_the_hand_worked_number() {
        // On a line: sentences at 0 and 1, motions at 0 and 2. −d²/2: [0, −2], [−1/2, −1/2].
        let rows = (1.0 + (-2f64).exp()).ln() + 2f64.ln();
        let columns = (1.0 + (-0.5f64).exp()).ln() + (1.0 + (-1.5f64).exp()).ln();
        let expected = (rows + columns) / 4.0;
        let got = loss(&[0.0, 1.0], &[0.0, 2.0], &[0, 1]);
        // Four logarithms in single precision.
        assert!((got - expected).abs() < 1e-6, "{got} {expected}");
    }

    #[test]
    fn equal_sentences_are_not_told_apart() {
        assert_eq!(loss(&[0.0, 0.0], &[0.0, 0.0], &[4, 4]), 0.0);
        assert!(loss(&[0.0, 0.0], &[0.0, 0.0], &[4, 5]) > 0.69);
    }
}
