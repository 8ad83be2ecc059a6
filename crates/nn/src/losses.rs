//! Loss terms with their gradients. Each returns one number per row, so callers choose how rows are weighed.

/// Normalises a row of scores to exponentials of sum 1, in place.
pub fn softmax(row: &mut [f32]) {
    let most = row.iter().copied().fold(f32::NEG_INFINITY, f32::max);
    row.iter_mut().for_each(|x| *x = (*x - most).exp());
    let sum: f32 = row.iter().sum();
    row.iter_mut().for_each(|x| *x /= sum);
}

/// Returns the weighted cross entropy of the softmax of a row of scores, and puts its gradient in the row's place.
///
/// The wanted distribution is 1 − `smoothing` at `target`, and the rest evenly over all classes (Szegedy et al. 2016, eq. 3).
pub fn softmax_cross_entropy(row: &mut [f32], target: usize, smoothing: f32, weight: f32) -> f64 {
    softmax(row);
    let classes = row.len() as f32;
    let mut loss = 0.0;
    for (i, p) in row.iter_mut().enumerate() {
        let wanted = smoothing / classes + if i == target { 1.0 - smoothing } else { 0.0 };
        loss -= f64::from(wanted * p.max(1e-12).ln() * weight);
        *p = (*p - wanted) * weight;
    }
    loss
}

/// Returns the KL divergence of N(μ, e^{log σ²}) from the standard normal (Kingma & Welling 2013, App. B):
/// ½ Σ (μ² + σ² − 1 − log σ²). Adds `weight` times its gradients to those by mean and log variance.
///
/// # Shapes
/// All `[d]`.
pub fn kl_from_standard_normal(
    [mean, log_variance]: [&[f32]; 2],
    weight: f32,
    [by_mean, by_log_variance]: [&mut [f32]; 2],
) -> f32 {
    let mut sum = 0.0;
    for (i, (mean, log_variance)) in mean.iter().zip(log_variance).enumerate() {
        let variance = log_variance.exp();
        sum += mean * mean + variance - (log_variance + 1.0);
        by_mean[i] += weight * mean;
        by_log_variance[i] += weight * 0.5 * (variance - 1.0);
    }
    0.5 * sum
}

/// Returns ‖R(a) − R(b)‖_F² for 6D rotations (thesis eq. 4.4), with its gradient by b. 6D numbers are a matrix' first two columns, made
/// orthonormal by Gram-Schmidt (Zhou et al. 2019, eq. 15).
pub fn rotation_distance_squared(a: [f32; 6], b: [f32; 6]) -> (f32, [f32; 6]) {
    let [ax, ay, az] = Frame::of(a).columns();
    let frame = Frame::of(b);
    let [bx, by, bz] = frame.columns();
    let apart = [minus(bx, ax), minus(by, ay), minus(bz, az)];
    let value = apart.iter().map(|d| dot(*d, *d)).sum();
    (value, frame.backward(apart.map(|d| times(d, 2.0))))
}

/// Two columns of a rotation on their way out of 6D numbers.
struct Frame {
    lengths: [f32; 2],
    second: [f32; 3],
    x: [f32; 3],
    y: [f32; 3],
}

impl Frame {
    fn of(six: [f32; 6]) -> Self {
        let (first, second) = ([six[0], six[1], six[2]], [six[3], six[4], six[5]]);
        let x_length = length(first);
        let x = times(first, 1.0 / x_length);
        let rest = minus(second, times(x, dot(x, second)));
        let y_length = length(rest);
        Self { lengths: [x_length, y_length], second, x, y: times(rest, 1.0 / y_length) }
    }

    fn columns(&self) -> [[f32; 3]; 3] {
        [self.x, self.y, cross(self.x, self.y)]
    }

    /// The gradient by the 6D numbers, from those by the three columns.
    fn backward(&self, [by_x, by_y, by_z]: [[f32; 3]; 3]) -> [f32; 6] {
        // z = x × y.
        let by_y = plus(by_y, cross(by_z, self.x));
        let mut by_x = plus(by_x, cross(self.y, by_z));
        // y = rest / |rest|: what points along y changes nothing.
        let by_rest = times(minus(by_y, times(self.y, dot(self.y, by_y))), 1.0 / self.lengths[1]);
        // rest = second − x (x · second).
        let along = dot(self.x, by_rest);
        let by_second = minus(by_rest, times(self.x, along));
        by_x = minus(by_x, plus(times(by_rest, dot(self.x, self.second)), times(self.second, along)));
        let by_first = times(minus(by_x, times(self.x, dot(self.x, by_x))), 1.0 / self.lengths[0]);
        let mut out = [0.0; 6];
        out[..3].copy_from_slice(&by_first);
        out[3..].copy_from_slice(&by_second);
        out
    }
}

/// The small number keeps the gradient finite for a zero vector, which training never aims at.
fn length(v: [f32; 3]) -> f32 {
    (dot(v, v) + 1e-12).sqrt()
}

fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn plus(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [0, 1, 2].map(|i| a[i] + b[i])
}

fn minus(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [0, 1, 2].map(|i| a[i] - b[i])
}

fn times(a: [f32; 3], factor: f32) -> [f32; 3] {
    a.map(|x| x * factor)
}

fn cross(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Scores 0 and ln 3 are probabilities of a quarter and three quarters.
    #[test]
    fn cross_entropy_by_hand() {
        for (smoothing, wanted) in [(0.0, [0.0, 1.0]), (0.2, [0.1, 0.9])] {
            let mut row = [0.0, 3.0_f32.ln()];
            let loss = softmax_cross_entropy(&mut row, 1, smoothing, 2.0);
            let expected = -2.0 * (wanted[0] * 0.25_f64.ln() + wanted[1] * 0.75_f64.ln());
            assert!((loss - expected).abs() < 1e-6, "{loss} {expected}");
            let gradient = [2.0 * (0.25 - wanted[0]), 2.0 * (0.75 - wanted[1])];
            assert!(
                row.iter().zip(gradient).all(|(got, expected)| (f64::from(*got) - expected).abs() < 1e-6),
                "{row:?}"
            );
        }
    }
}
