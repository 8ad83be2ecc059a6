//! Joint commands of the environments of a vector.

use super::lane::{Lane, Scalar};
use crate::simulation::Drive;

/// A drive on lanes.
#[derive(Debug, Clone)]
pub struct Command<T: Scalar, const W: usize> {
    /// True for targets (rad) of the actuator model, false for torques (N m).
    pub targets: bool,
    /// One number per scalar joint.
    pub values: Vec<Lane<T, W>>,
}

impl<T: Scalar, const W: usize> Command<T, W> {
    /// No torques on so many scalar joints.
    pub fn none(joints: usize) -> Self {
        Self { targets: false, values: vec![Lane::zero(); joints] }
    }

    /// Takes over the drive of up to `W` environments.
    pub fn set(&mut self, drive: Drive<'_>, joints: usize) {
        self.targets = matches!(drive, Drive::Targets(_));
        for (lane, row) in drive.values().chunks_exact(joints).enumerate() {
            for (slot, x) in self.values.iter_mut().zip(row) {
                slot.0[lane] = T::new(f64::from(*x));
            }
        }
    }
}
