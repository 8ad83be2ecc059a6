//! The loss that tells the pairs of a batch apart.

use super::network::ContrastiveLoss;

/// Returns the mean over both directions of −log softmax of −d²/2 (InfoNCE, van den Oord et al. 2018), d the Euclidean
/// distance by which the metrics compare: the log-likelihood of finding the own motion for a sentence, and the own
/// sentence for a motion.
///
/// `kinds[i]` is the same for rows of the same sentence: those are not told apart.
///
/// # Shapes
/// `text, motion: [B, width]`, row i of both belongs together.
pub(super) fn contrastive_loss(text: &[f32], motion: &[f32], kinds: &[usize]) -> ContrastiveLoss {
    let n = kinds.len();
    let width = text.len() / n;
    let row = |rows: &[f32], i: usize| -> Vec<f32> { rows[i * width..(i + 1) * width].to_vec() };
    let told_apart = |i: usize, j: usize| i == j || kinds[i] != kinds[j];
    // −d²/2 of each pair, sentences by motions.
    let mut scores = vec![f64::NEG_INFINITY; n * n];
    for i in 0..n {
        for j in (0..n).filter(|j| told_apart(i, *j)) {
            let apart = row(text, i).into_iter().zip(row(motion, j)).map(|(a, b)| f64::from(a - b).powi(2));
            scores[i * n + j] = -0.5 * apart.sum::<f64>();
        }
    }
    let rows: Vec<f64> = (0..n).map(|i| log_sum_exp((0..n).map(|j| scores[i * n + j]))).collect();
    let columns: Vec<f64> = (0..n).map(|j| log_sum_exp((0..n).map(|i| scores[i * n + j]))).collect();
    let found = |i: usize| 2.0 * scores[i * (n + 1)] - rows[i] - columns[i];
    let value = -0.5 / n as f64 * (0..n).map(found).sum::<f64>();

    let (mut by_text, mut by_motion) = (vec![0.0; text.len()], vec![0.0; motion.len()]);
    for i in 0..n {
        for j in (0..n).filter(|j| told_apart(i, *j)) {
            let score = scores[i * n + j];
            let own = if i == j { 2.0 } else { 0.0 };
            let by_score = 0.5 / n as f64 * ((score - rows[i]).exp() + (score - columns[j]).exp() - own);
            for k in 0..width {
                let apart = motion[j * width + k] - text[i * width + k];
                by_text[i * width + k] += by_score as f32 * apart;
                by_motion[j * width + k] -= by_score as f32 * apart;
            }
        }
    }
    ContrastiveLoss { value, by_text, by_motion }
}

fn log_sum_exp(scores: impl Iterator<Item = f64> + Clone) -> f64 {
    let most = scores.clone().fold(f64::NEG_INFINITY, f64::max);
    most + scores.map(|score| (score - most).exp()).sum::<f64>().ln()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn loss(text: &[f32], motion: &[f32], kinds: &[usize]) -> f64 {
        contrastive_loss(text, motion, kinds).value
    }

    #[test]
    fn it_is_the_hand_worked_number() {
        // On a line: sentences at 0 and 1, motions at 0 and 2. −d²/2: [0, −2], [−1/2, −1/2].
        let rows = (1.0 + (-2f64).exp()).ln() + 2f64.ln();
        let columns = (1.0 + (-0.5f64).exp()).ln() + (1.0 + (-1.5f64).exp()).ln();
        let expected = (rows + columns) / 4.0;
        let got = loss(&[0.0, 1.0], &[0.0, 2.0], &[0, 1]);
        assert!((got - expected).abs() < 1e-9, "{got} {expected}");
    }

    #[test]
    fn equal_sentences_are_not_told_apart() {
        assert_eq!(loss(&[0.0, 0.0], &[0.0, 0.0], &[4, 4]), 0.0);
        assert!(loss(&[0.0, 0.0], &[0.0, 0.0], &[4, 5]) > 0.69);
    }

    #[test]
    fn gradients_are_those_of_finite_differences() {
        let wave = |k: f32| -> Vec<f32> { (0..15).map(|i| (i as f32 * k).sin()).collect() };
        let (text, motion, kinds) = (wave(0.7), wave(1.3), [0, 1, 0, 2, 3]);
        let got = contrastive_loss(&text, &motion, &kinds);
        let moved = |rows: &[f32], at: usize, by: f32| {
            let mut rows = rows.to_vec();
            rows[at] += by;
            rows
        };
        for at in 0..15 {
            let by_text =
                loss(&moved(&text, at, 1e-3), &motion, &kinds) - loss(&moved(&text, at, -1e-3), &motion, &kinds);
            let by_motion =
                loss(&text, &moved(&motion, at, 1e-3), &kinds) - loss(&text, &moved(&motion, at, -1e-3), &kinds);
            assert!((by_text / 2e-3 - f64::from(got.by_text[at])).abs() < 1e-4, "{at}");
            assert!((by_motion / 2e-3 - f64::from(got.by_motion[at])).abs() < 1e-4, "{at}");
        }
    }
}
