//! Where tensors live. burn 0.22 chooses the backend by a value, not by a type, so this is the one place that names it.

pub use burn::tensor::Device;

/// The device for inference: burn's `flex` backend on the CPU (SIMD, all cores).
pub fn inference() -> Device {
    Device::flex()
}

/// The device for training: as [`inference`], and tensors created on it record what gradients need.
pub fn training() -> Device {
    inference().autodiff()
}
