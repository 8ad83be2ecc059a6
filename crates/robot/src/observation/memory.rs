//! Memory of earlier observations, for policies that see them (`inputs.history`).

use super::spec::ObservationSpec;

/// Memory of the earlier steps of one robot, the oldest first.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Memory {
    /// `[history · remembered]`; empty before the first step.
    past: Vec<f32>,
    /// The present step's, which [`Self::advance`] makes the newest of the past.
    now: Vec<f32>,
}

impl Memory {
    /// Returns the earlier steps, as an observation has them; empty before the first step.
    pub fn past(&self) -> &[f32] {
        &self.past
    }

    /// Forgets everything, as an episode begins.
    pub fn clear(&mut self) {
        self.past.clear();
        self.now.clear();
    }

    /// Takes note of an observation as the policy sees it. Before the first step nothing was seen: the past in the row becomes
    /// like the present.
    ///
    /// `remembered` are [`ObservationSpec::remembered`]'s numbers. Allocates nothing from the second observation on.
    pub fn recall(&mut self, spec: &ObservationSpec, remembered: &[usize], row: &mut [f32]) {
        let steps = spec.reference.history;
        if steps == 0 {
            return;
        }
        self.now.clear();
        self.now.extend(remembered.iter().filter_map(|&number| row.get(number)));
        if !self.past.is_empty() {
            return;
        }
        (0..steps).for_each(|_| self.past.extend_from_slice(&self.now));
        let first = row.len().saturating_sub(self.past.len());
        row[first..].copy_from_slice(&self.past);
    }

    /// Makes the present step the newest of the past.
    pub fn advance(&mut self) {
        if self.past.is_empty() {
            return;
        }
        let kept = self.past.len() - self.now.len();
        self.past.rotate_left(self.now.len());
        self.past[kept..].copy_from_slice(&self.now);
    }

    /// Returns everything as numbers, for a checkpoint: past, then present.
    pub fn numbers(&self) -> impl Iterator<Item = f32> {
        self.past.iter().chain(&self.now).copied()
    }

    /// Returns the memory of these numbers, `remembered` of them for each step.
    pub fn from_numbers(numbers: &[f32], remembered: usize) -> Self {
        let (past, now) = numbers.split_at(numbers.len().saturating_sub(remembered));
        Self { past: past.to_vec(), now: now.to_vec() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Robot;
    use crate::observation::{AnchorSpec, ReferenceSpec};

    #[test]
    #[allow(clippy::unwrap_used)]
    fn the_past_begins_like_the_present_and_moves_on_a_step_at_a_time() {
        let robot = Robot::load("lima").unwrap();
        let spec =
            ObservationSpec::new(&robot, ReferenceSpec { history: 3, ..Default::default() }, AnchorSpec::default());
        let remembered = spec.remembered();
        // Orientation 6, both velocities, and positions, velocities and the last action of 20 joints.
        assert_eq!(remembered.len(), usize::from(spec.root_height) + 6 + 3 + 3 + 3 * 20);
        assert_eq!(spec.history_size(), 3 * remembered.len());
        let own = spec.size() - spec.history_size();
        let mut memory = Memory::default();
        for step in 0..5 {
            let mut row = vec![step as f32; own];
            row.extend(if step == 0 { vec![-1.0; spec.history_size()] } else { memory.past().to_vec() });
            memory.recall(&spec, &remembered, &mut row);
            let oldest_first = [3, 2, 1].map(|ago: i32| (step - ago).max(0) as f32);
            for (seen, expected) in row[own..].chunks_exact(remembered.len()).zip(oldest_first) {
                assert!(seen.iter().all(|x| *x == expected), "step {step}: {expected} {seen:?}");
            }
            let numbers: Vec<f32> = memory.numbers().collect();
            assert_eq!(Memory::from_numbers(&numbers, remembered.len()), memory);
            memory.advance();
        }
    }
}
