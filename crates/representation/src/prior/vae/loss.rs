//! The reconstruction loss of thesis eqs. 4.3-4.4.

use burn::tensor::Tensor;
use lifelike_motion::FeatureLayout;
use lifelike_nn::losses::rotation_distance_squared;

/// Returns eq. 4.3 averaged over the batch: per sample of a window, the squared differences of all normalised features, and
/// ‖R(θ) − R(θ')‖_F² for the orientation, summed; then averaged over samples and windows.
///
/// # Shapes
/// Two `[B, 2W + 1, F]` to `[1]`.
pub fn reconstruction(x: Tensor<3>, y: Tensor<3>) -> Tensor<1> {
    let [b, t, f] = x.dims();
    let orientation = FeatureLayout::ORIENTATION;
    let rotation = |v: &Tensor<3>| v.clone().narrow(2, orientation.start, orientation.len()).reshape([b * t, 6]);
    let angle = rotation_distance_squared(rotation(&x), rotation(&y)).sum();
    let difference = (x - y).square();
    let height = difference.clone().narrow(2, FeatureLayout::HEIGHT, 1).sum();
    let rest = difference.narrow(2, orientation.end, f - orientation.end).sum();
    (height + angle + rest).div_scalar((b * t) as f64)
}
