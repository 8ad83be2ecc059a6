//! Our fix for the collapse of thesis 3.3.5 ("additional regularization may help", 3.4): control points of a sequence
//! that come close to each other are driven apart.
//!
//! For a sequence's P control points of d numbers, s² = Σ ‖pᵢ − p̄‖² / (P d), and the penalty is max(0, 1 − s / floor)²,
//! averaged over the batch. A network whose points are apart does not notice it. Its gradient does not
//! fade as s goes to 0. Points that have nearly met are therefore driven apart as hard as those that begin to.

/// Weight and floor of the penalty on close control points.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Spread {
    /// Weight of the penalty beside the mean squared error.
    #[schemars(extend("unit" = "1"), range(min = 0.0, max = 1e6))]
    pub weight: f64,
    /// Spread s of control points from which on nothing is penalised.
    #[schemars(extend("unit" = "1"), range(min = 1e-6, max = 1e6))]
    pub floor: f64,
}

/// Keeps the gradient finite where all points are the same.
const EPSILON: f64 = 1e-12;

/// Returns the derivative, by each number of some sequences' control points, of the weight times the mean penalty of
/// their batch.
///
/// # Shapes
/// `control_points: [sequences, points, latent]` of a batch of `batch` sequences, row-major; so is what is returned.
pub fn penalty_gradient(
    spread: Spread,
    control_points: &[f32],
    points: usize,
    latent: usize,
    batch: usize,
) -> Vec<f32> {
    let Spread { weight, floor } = spread;
    let (count, share) = ((points * latent) as f64, weight / batch.max(1) as f64);
    let mut gradient = Vec::with_capacity(control_points.len());
    for sequence in control_points.chunks_exact((points * latent).max(1)) {
        let mean: Vec<f64> = (0..latent)
            .map(|k| sequence.iter().skip(k).step_by(latent).map(|p| f64::from(*p)).sum::<f64>() / points as f64)
            .collect();
        let apart = |(i, p): (usize, &f32)| f64::from(*p) - mean[i % latent];
        let s = (sequence.iter().enumerate().map(|p| apart(p).powi(2)).sum::<f64>() / count + EPSILON).sqrt();
        let short = (1.0 - s / floor).max(0.0);
        let scale = -2.0 * share * short / (floor * count * s);
        gradient.extend(sequence.iter().enumerate().map(|p| (scale * apart(p)) as f32));
    }
    gradient
}

#[cfg(test)]
mod tests {
    use super::*;

    const FLOOR: f64 = 0.5;

    fn of(weight: f64, control_points: &[f32], points: usize, latent: usize, batch: usize) -> Vec<f32> {
        penalty_gradient(Spread { weight, floor: FLOOR }, control_points, points, latent, batch)
    }

    /// Returns the penalty of one sequence as the head of this file has it, point by point.
    fn penalty(control_points: &[f32], latent: usize) -> f64 {
        let points: Vec<&[f32]> = control_points.chunks_exact(latent).collect();
        let mean = |k: usize| points.iter().map(|p| f64::from(p[k])).sum::<f64>() / points.len() as f64;
        let squares: f64 =
            (0..latent).map(|k| points.iter().map(|p| (f64::from(p[k]) - mean(k)).powi(2)).sum::<f64>()).sum();
        (1.0 - (squares / control_points.len() as f64).sqrt() / FLOOR).max(0.0).powi(2)
    }

    #[test]
    fn points_that_are_apart_are_left_alone() {
        assert_eq!(of(3.0, &[-0.6, 0.6, 0.6, -0.6], 2, 2, 1), vec![0.0; 4]);
    }

    #[test]
    fn the_gradient_is_that_of_hand_arithmetic() {
        // s = 0.25 is half of the floor. Weight 2 over a batch of 4: −2 (2 / 4) (0.5) (± 0.25) / (0.5 · 2 · 0.25)
        let gradient = of(2.0, &[1.25, 0.75], 2, 1, 4);
        assert!((gradient[0] + 0.5).abs() < 1e-6 && (gradient[1] - 0.5).abs() < 1e-6, "{gradient:?}");
    }

    #[test]
    fn the_gradient_is_the_derivative() {
        let points: Vec<f32> = (0..24).map(|i| ((i * 37 % 11) as f32 - 5.0) * 0.03).collect();
        let of_points = |points: &[f32]| 1.7 / 2.0 * points.chunks_exact(12).map(|own| penalty(own, 3)).sum::<f64>();
        let gradient = of(1.7, &points, 4, 3, 2);
        assert!(gradient.iter().any(|s| s.abs() > 0.01));
        for i in 0..points.len() {
            let mut moved = [points.clone(), points.clone()];
            moved[0][i] -= 1e-3;
            moved[1][i] += 1e-3;
            let difference = (of_points(&moved[1]) - of_points(&moved[0])) / f64::from(moved[1][i] - moved[0][i]);
            assert!((difference - f64::from(gradient[i])).abs() < 1e-5, "{i}: {difference} {}", gradient[i]);
        }
        // One point, or all the same: nothing to tell them apart by, and no division by zero.
        assert_eq!(of(1.0, &[0.3, 0.4], 1, 2, 1), [0.0, 0.0]);
        assert!(of(1.0, &[0.3; 8], 4, 2, 1).iter().all(|s| *s == 0.0));
    }
}
