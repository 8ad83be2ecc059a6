//! The reconstruction loss of thesis eqs. 4.3 and 4.4 with its gradient.

use lifelike_motion::FeatureLayout;
use lifelike_nn::losses::rotation_distance_squared;

/// Adds up eq. 4.3 over normalised rows and writes its gradient by `y`: squared differences of all features, and ‖R(θ) − R(θ')‖_F²
/// (eq. 4.4) in place of those of the six numbers of the orientation.
///
/// # Shapes
/// All `[rows, width]`.
pub(super) fn reconstruction(x: &[f32], y: &[f32], width: usize, gradient: &mut [f32]) -> f64 {
    let mut sum = 0.0;
    let rows = x.chunks_exact(width).zip(y.chunks_exact(width)).zip(gradient.chunks_exact_mut(width));
    for ((x, y), gradient) in rows {
        for ((x, y), g) in x.iter().zip(y).zip(gradient.iter_mut()) {
            *g = 2.0 * (y - x);
        }
        let squares = |range: std::ops::Range<usize>| -> f64 {
            x[range.clone()].iter().zip(&y[range]).map(|(x, y)| f64::from(x - y).powi(2)).sum()
        };
        let six = FeatureLayout::ORIENTATION;
        sum += squares(0..six.start) + squares(six.end..width);
        let orientation = |row: &[f32]| -> [f32; 6] { std::array::from_fn(|i| row[six.start + i]) };
        let (apart, by_y) = rotation_distance_squared(orientation(x), orientation(y));
        sum += f64::from(apart);
        gradient[six].copy_from_slice(&by_y);
    }
    sum
}

#[cfg(test)]
mod tests {
    use lifelike_checkpoint::rng::stream;
    use rand_distr::{Distribution, StandardNormal};

    use super::*;

    /// The rotation's part is held against PyTorch in `lifelike-nn`.
    #[test]
    fn the_gradient_is_that_of_finite_differences() {
        let width = 31;
        let mut rng = stream(3, "test", 0, 0);
        let mut numbers = || -> Vec<f32> { (0..2 * width).map(|_| StandardNormal.sample(&mut rng)).collect() };
        let (x, y) = (numbers(), numbers());
        let value = |y: &[f32], gradient: &mut [f32]| reconstruction(&x, y, width, gradient);
        let mut gradient = vec![f32::NAN; y.len()];
        assert!(value(&x, &mut gradient) < 1e-9);
        value(&y, &mut gradient);
        for at in 0..y.len() {
            let moved = |by: f32| {
                let mut y = y.clone();
                y[at] += by;
                value(&y, &mut vec![0.0; y.len()])
            };
            let slope = (moved(2e-3) - moved(-2e-3)) / 4e-3;
            let wanted = f64::from(gradient[at]);
            assert!((slope - wanted).abs() < 2e-3 * (1.0 + wanted.abs()), "{at}: {slope}, not {wanted}");
        }
    }
}
