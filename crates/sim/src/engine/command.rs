//! Joint commands of the environments of a vector.

use super::lanes::{Lanes, Scalar};
use crate::simulation::Drive;

/// A drive on lanes.
#[derive(Debug, Clone)]
pub struct Command<V: Lanes> {
    /// True for targets (rad) of the actuator model, false for torques (N m).
    pub targets: bool,
    /// One number per scalar joint.
    pub values: Vec<V>,
}

impl<V: Lanes> Command<V> {
    /// No torques on so many scalar joints.
    pub fn none(joints: usize) -> Self {
        Self { targets: false, values: vec![V::zero(); joints] }
    }

    /// Takes over the drive of up to as many environments as there are lanes.
    pub fn set(&mut self, drive: Drive<'_>, joints: usize) {
        self.targets = matches!(drive, Drive::Targets(_));
        for (lane, row) in drive.values().chunks_exact(joints).enumerate() {
            for (slot, x) in self.values.iter_mut().zip(row) {
                slot.set_lane(lane, Scalar::new(f64::from(*x)));
            }
        }
    }
}
