//! Thesis eqs. 4.3 and 4.4 in plain numbers, with the gradient written out: the loss of the β-VAE ([`crate::prior::vae`]) for the Spline-based
//! Transformer, whose passes have no tape.

use lifelike_motion::FeatureLayout;

type Vector = nalgebra::Vector3<f32>;

/// Adds up eq. 4.4 over normalised rows and writes its gradient by `y`: squared differences of all features, and ‖R(θ) − R(θ')‖_F² in
/// place of those of the six numbers of the orientation.
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
        sum += rotation(&x[six.clone()], &y[six.clone()], &mut gradient[six]);
    }
    sum
}

/// Returns ‖R(x) − R(y)‖_F² of two 6D rotations, and writes its gradient by `y`.
fn rotation(x: &[f32], y: &[f32], gradient: &mut [f32]) -> f64 {
    let (wanted, is) = (Columns::of(x), Columns::of(y));
    let [first, second, third] = [is.first - wanted.first, is.second - wanted.second, is.third() - wanted.third()];
    let distance = f64::from(first.norm_squared() + second.norm_squared() + third.norm_squared());
    // Backwards through third = first × second, second = unit(b − first (first · b)), first = unit(a).
    let mut by_first = 2.0 * first + is.second.cross(&(2.0 * third));
    let by_second = 2.0 * second + (2.0 * third).cross(&is.first);
    let by_rest = (by_second - is.second * is.second.dot(&by_second)) / is.rest;
    let by_b = by_rest - is.first * is.first.dot(&by_rest);
    by_first -= by_rest * is.first.dot(&is.b) + is.b * is.first.dot(&by_rest);
    let by_a = (by_first - is.first * is.first.dot(&by_first)) / is.length;
    gradient[..3].copy_from_slice(by_a.as_slice());
    gradient[3..].copy_from_slice(by_b.as_slice());
    distance
}

/// Gram-Schmidt of 6D numbers (Zhou et al. 2019, eq. 15), and what its gradient needs.
struct Columns {
    first: Vector,
    second: Vector,
    b: Vector,
    /// |a|, and |b less its part along the first|.
    length: f32,
    rest: f32,
}

impl Columns {
    fn of(six: &[f32]) -> Self {
        let (a, b) = (Vector::new(six[0], six[1], six[2]), Vector::new(six[3], six[4], six[5]));
        // The small number keeps the gradient finite for a zero vector.
        let length = (a.norm_squared() + 1e-12).sqrt();
        let first = a / length;
        let along = b - first * first.dot(&b);
        let rest = (along.norm_squared() + 1e-12).sqrt();
        Self { first, second: along / rest, b, length, rest }
    }

    fn third(&self) -> Vector {
        self.first.cross(&self.second)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use burn::tensor::{Tensor, TensorData};
    use lifelike_checkpoint::rng::stream;
    use lifelike_nn::device;
    use lifelike_nn::numbers::read;
    use rand_distr::{Distribution, StandardNormal};

    use super::*;
    use crate::prior::vae::loss;

    #[test]
    fn value_and_gradient_are_those_of_automatic_differentiation() {
        const SHAPE: [usize; 3] = [4, 5, 31];
        let mut rng = stream(3, "test", 0, 0);
        let mut numbers = || -> Vec<f32> { (0..4 * 5 * 31).map(|_| StandardNormal.sample(&mut rng)).collect() };
        let (x, y) = (numbers(), numbers());
        let mut gradient = vec![f32::NAN; x.len()];
        let rows = (SHAPE[0] * SHAPE[1]) as f64;
        let value = reconstruction(&x, &y, SHAPE[2], &mut gradient) / rows;

        let device = device::training();
        let tensor = |values: &[f32]| Tensor::<3>::from_data(TensorData::new(values.to_vec(), SHAPE), &device);
        let back = tensor(&y).require_grad();
        let expected = loss::reconstruction(tensor(&x), back.clone());
        let by_back = back.grad(&expected.backward()).unwrap();
        let expected_gradient = read(by_back).unwrap();
        let expected = f64::from(expected.into_scalar::<f32>());
        assert!((value - expected).abs() < 1e-5 * expected, "{value}, not {expected}");
        for (got, wanted) in gradient.iter().zip(&expected_gradient) {
            let got = got / rows as f32;
            assert!((got - wanted).abs() < 1e-5 + 1e-4 * wanted.abs(), "{got}, not {wanted}");
        }
    }
}
