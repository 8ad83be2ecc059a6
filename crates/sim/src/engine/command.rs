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
    numbers: Vec<V::Scalar>,
}

impl<V: Lanes> Command<V> {
    /// No torques on so many scalar joints.
    pub fn none(joints: usize) -> Self {
        Self { targets: false, values: vec![V::zero(); joints], numbers: Vec::new() }
    }

    /// Takes over the drive of up to as many environments as there are lanes.
    pub fn set(&mut self, drive: Drive<'_>, joints: usize) {
        self.targets = matches!(drive, Drive::Targets(_));
        // Turned over in memory first: lanes are not to be written one by one.
        let numbers = &mut self.numbers;
        numbers.resize(V::LANES * joints, Scalar::new(0.0));
        for (lane, row) in drive.values().chunks_exact(joints).enumerate() {
            for (slot, x) in numbers[lane..].iter_mut().step_by(V::LANES).zip(row) {
                *slot = Scalar::new(f64::from(*x));
            }
        }
        V::vectorize(
            #[inline(always)]
            || {
                for (value, numbers) in self.values.iter_mut().zip(numbers.chunks_exact(V::LANES)) {
                    *value = V::load(numbers);
                }
            },
        );
    }
}
