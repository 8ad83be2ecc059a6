//! Derivatives of the losses by the networks' outputs: PPO's two, and that of a policy with a teacher.
//!
//! They are written by hand; tests compare them with finite differences and hand arithmetic. Backward passes through the
//! networks are `lifelike_dense`'s.

/// Objective of a policy over a minibatch, with its gradient.
#[derive(Debug, Clone, PartialEq)]
pub struct Objective {
    /// Mean over the minibatch.
    pub value: f64,
    /// Derivative of −value by each mean, `[B, J]`.
    pub by_mean: Vec<f32>,
    /// Derivative of −value by each log standard deviation, `[J]`.
    pub by_log_std: Vec<f32>,
}

/// The clipped surrogate objective of Schulman et al. 2017, eq. 7, for a diagonal Gaussian: the mean of
/// min(r A, clip(r, 1 ± ε) A).
///
/// If the clipped branch is the smaller one, the ratio has no say: no derivative. The rows may be a part of a
/// minibatch of `batch`: the results of all parts, added up, are the minibatch's.
///
/// # Shapes
/// `means`, `actions`: `[B, J]`; `log_std`: `[J]`; `old` (log-probabilities when the actions were drawn), `advantages`:
/// `[B]`.
pub fn surrogate(
    means: &[f32],
    log_std: &[f32],
    actions: &[f32],
    old: &[f32],
    advantages: &[f32],
    clip: f32,
    batch: usize,
) -> Objective {
    let (joints, batch) = (log_std.len(), batch as f32);
    let inverse: Vec<f32> = log_std.iter().map(|l| (-l).exp()).collect();
    let mut out = Objective { value: 0.0, by_mean: vec![0.0; means.len()], by_log_std: vec![0.0; joints] };
    let mut z = vec![0.0; joints];
    for i in 0..advantages.len() {
        let row = i * joints..(i + 1) * joints;
        for (((z, a), m), s) in z.iter_mut().zip(&actions[row.clone()]).zip(&means[row.clone()]).zip(&inverse) {
            *z = (a - m) * s;
        }
        let ratio = (super::gaussian::log_probability_of_noise(&z, log_std) - old[i]).exp();
        let (free, clipped) = (ratio * advantages[i], ratio.clamp(1.0 - clip, 1.0 + clip) * advantages[i]);
        out.value += f64::from(free.min(clipped) / batch);
        if clipped < free {
            continue;
        }
        // d(−r A)/d log p = −r A; d log p/dμ = z/σ, d log p/d log σ = z² − 1.
        let gradient = -free / batch;
        for (((by_mean, z), s), by_log_std) in
            out.by_mean[row].iter_mut().zip(&z).zip(&inverse).zip(&mut out.by_log_std)
        {
            *by_mean = gradient * z * s;
            *by_log_std += gradient * (z * z - 1.0);
        }
    }
    out
}

/// The objective of a policy with a teacher: −KL(teacher ‖ policy) of two Gaussians with the policy's standard deviations,
/// −½ Σ ((μ − μ')/σ)². The standard deviations stay as they are: by this objective they would grow without end.
///
/// # Shapes
/// `means` and `taught` (the teacher's): `[B, J]`; `log_std`: `[J]`. The rows may be a part of a minibatch of `batch`.
pub fn imitation(means: &[f32], log_std: &[f32], taught: &[f32], batch: usize) -> Objective {
    let precision: Vec<f32> = log_std.iter().map(|l| (-2.0 * l).exp() / batch as f32).collect();
    let mut out =
        Objective { value: 0.0, by_mean: Vec::with_capacity(means.len()), by_log_std: vec![0.0; log_std.len()] };
    for ((mean, teacher), precision) in means.iter().zip(taught).zip(precision.iter().cycle()) {
        let error = mean - teacher;
        out.value -= f64::from(0.5 * error * error * precision);
        out.by_mean.push(error * precision);
    }
    out
}

/// Half the mean squared error over a minibatch of `batch`, of which these are a part, and its derivative by each value.
pub fn squared_error(values: &[f32], targets: &[f32], batch: usize) -> (f64, Vec<f32>) {
    let n = batch as f32;
    let errors: Vec<f32> = values.iter().zip(targets).map(|(v, t)| v - t).collect();
    let loss = errors.iter().map(|e| f64::from(e * e)).sum::<f64>() / (2.0 * f64::from(n));
    (loss, errors.into_iter().map(|e| e / n).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    #[test]
    fn the_surrogates_derivatives_are_those_of_finite_differences() {
        let (batch, joints) = (40, 3);
        let wave = |i: usize, k: f32| (i as f32 * k).sin();
        let means: Vec<f32> = (0..batch * joints).map(|i| wave(i, 1.3)).collect();
        let actions: Vec<f32> = (0..batch * joints).map(|i| wave(i, 1.3) + 0.5 * wave(i, 2.1)).collect();
        let advantages: Vec<f32> = (0..batch).map(|i| wave(i, 0.7)).collect();
        let log_std = vec![-0.5, 0.1, -1.0];
        let probability = |row: usize| {
            let noise = |j: usize| (actions[row * joints + j] - means[row * joints + j]) * (-log_std[j] as f32).exp();
            crate::gaussian::log_probability_of_noise(&(0..joints).map(noise).collect::<Vec<_>>(), &log_std)
        };
        // Ratios on both sides of both bounds.
        let old: Vec<f32> = (0..batch).map(|i| probability(i) + 0.4 * wave(i, 1.9)).collect();
        let value =
            |means: &[f32], log_std: &[f32]| surrogate(means, log_std, &actions, &old, &advantages, 0.2, batch).value;
        let got = surrogate(&means, &log_std, &actions, &old, &advantages, 0.2, batch);
        // By hand: the mean of the smaller of two products.
        let smaller = |i: usize| {
            let ratio = f64::from(probability(i) - old[i]).exp();
            (ratio * f64::from(advantages[i])).min(ratio.clamp(0.8, 1.2) * f64::from(advantages[i]))
        };
        let expected = (0..batch).map(smaller).sum::<f64>() / batch as f64;
        assert!((got.value - expected).abs() < 1e-6);
        assert!(got.by_mean.contains(&0.0) && got.by_mean.iter().any(|x| *x != 0.0), "both branches are met");

        let step = 1e-3;
        let moved = |numbers: &[f32], at: usize, by: f32| -> Vec<f32> {
            let mut numbers = numbers.to_vec();
            numbers[at] += by;
            numbers
        };
        for (at, by) in got.by_mean.iter().enumerate() {
            let slope = value(&moved(&means, at, step), &log_std) - value(&moved(&means, at, -step), &log_std);
            assert!((-slope / 2e-3 - f64::from(*by)).abs() < 3e-4, "mean {at}: {} {by}", -slope / 2e-3);
        }
        for (at, by) in got.by_log_std.iter().enumerate() {
            let slope = value(&means, &moved(&log_std, at, step)) - value(&means, &moved(&log_std, at, -step));
            assert!((-slope / 2e-3 - f64::from(*by)).abs() < 3e-4, "log std {at}: {} {by}", -slope / 2e-3);
        }
    }

    #[test]
    fn imitation_by_hand() {
        // Standard deviations of 1 and 1/2: errors of 0.5 and -1 are half and two of them, then 0 and 1 are none and two.
        let log_std = [0.0, 0.5_f32.ln()];
        let got = imitation(&[1.5, 0.0, 3.0, 2.0], &log_std, &[1.0, 1.0, 3.0, 1.0], 2);
        assert!((got.value - -(0.125 + 2.0 + 0.0 + 2.0) / 2.0).abs() < 1e-6, "{}", got.value);
        for (a, b) in got.by_mean.iter().zip([0.25, -2.0, 0.0, 2.0]) {
            assert!((a - b).abs() < 1e-6, "{a} {b}");
        }
        assert_eq!(got.by_log_std, [0.0, 0.0]);
    }

    #[test]
    fn squared_error_by_hand() {
        let (loss, gradient) = squared_error(&[1.0, 3.0], &[0.0, 5.0], 2);
        assert_eq!((loss, gradient), (1.25, vec![0.5, -1.0]));
    }
}
