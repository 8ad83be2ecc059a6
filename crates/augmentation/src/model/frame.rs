//! Rigid bodies in the frame of their parent: what is learned does not depend on where the robot stands or how it is attached.

use lifelike_character::rotation::from_wxyz;
use lifelike_character::{Quat, Vec3};
use lifelike_sim::trace::{BlockTrace, Columns, FRAME, Trace};

use crate::{AugmentationError, FromInput};

/// Axes of a body's state, forces and errors, as the network reads and predicts them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Frame {
    /// Axes of the world.
    #[default]
    World,
    /// The simulated pose of the body's parent: places relative to it, everything in its axes. Actuators have no parent.
    Parent,
}

/// Place and orientation of a parent in the world.
type Pose = (Vec3, Quat);

impl Frame {
    /// Returns the poses that a block's numbers are expressed in; none for the world's axes and for blocks that are no bodies.
    ///
    /// # Errors
    /// [`AugmentationError::Input`] for a body whose trace has no pose of its parent.
    pub(super) fn poses(self, block: &BlockTrace) -> Result<Option<Vec<Pose>>, AugmentationError> {
        if self == Self::World || block.simulated.index("position_x").is_none() {
            return Ok(None);
        }
        if block.frame.names != FRAME {
            let what = format!("parent's pose of '{}'", block.name);
            let cure = "none (make the traces anew, or set augmentation.frame='world')";
            return Err(AugmentationError::mismatch(what, format!("columns {FRAME:?}"), cure));
        }
        let pose = |row: &[f32]| {
            let turn = from_wxyz([row[3], row[4], row[5], row[6]].map(f64::from)).unwrap_or_else(Quat::identity);
            (vector(&row[..3]), turn)
        };
        Ok(Some(block.frame.rows().map(pose).collect()))
    }

    /// Returns a block with its numbers in this frame; the block itself where they are.
    ///
    /// # Errors
    /// As [`Self::poses`].
    pub fn of(self, block: &BlockTrace) -> Result<BlockTrace, AugmentationError> {
        let mut local = block.clone();
        if let Some(poses) = self.poses(block)? {
            for columns in [&mut local.simulated, &mut local.force, &mut local.measured] {
                enter(columns, &poses);
            }
        }
        Ok(local)
    }

    /// Turns predicted errors of a block back into the axes of the world.
    ///
    /// # Shapes
    /// `errors: [steps, names]`, whose coordinates of one vector stand side by side.
    ///
    /// # Errors
    /// As [`Self::poses`].
    pub(crate) fn leave(self, block: &BlockTrace, names: &[&str], errors: &mut [f32]) -> Result<(), AugmentationError> {
        let Some(poses) = self.poses(block)? else { return Ok(()) };
        for (row, (_, turn)) in errors.chunks_exact_mut(names.len().max(1)).zip(&poses) {
            for (first, _) in vectors(names) {
                let turned = turn * vector(&row[first..]);
                row[first..first + 3].iter_mut().zip(turned.iter()).for_each(|(x, y)| *x = *y as f32);
            }
        }
        Ok(())
    }
}

/// Returns a trace with all blocks of a class in their parents' frames.
///
/// # Errors
/// [`AugmentationError::Input`] for a body whose trace has no pose of its parent.
pub fn in_parents(trace: &Trace, class: &str) -> Result<Trace, AugmentationError> {
    let mut local = trace.clone();
    for block in local.blocks.iter_mut().filter(|block| block.class == class) {
        *block = Frame::Parent.of(block)?;
    }
    Ok(local)
}

/// Expresses the vectors among some columns in frames; places are measured from their origins.
fn enter(columns: &mut Columns, poses: &[Pose]) {
    let names: Vec<&str> = columns.names.iter().map(String::as_str).collect();
    let vectors = vectors(&names);
    for (row, (place, turn)) in columns.values.chunks_exact_mut(names.len().max(1)).zip(poses) {
        for &(first, is_place) in &vectors {
            let from = if is_place { *place } else { Vec3::zeros() };
            let turned = turn.inverse() * (vector(&row[first..]) - from);
            row[first..first + 3].iter_mut().zip(turned.iter()).for_each(|(x, y)| *x = *y as f32);
        }
    }
}

/// First coordinates of the vectors (`NAME_x`, `NAME_y`, `NAME_z` side by side) among some names, and true for places.
pub(super) fn vectors(names: &[&str]) -> Vec<(usize, bool)> {
    let vector = |(i, three): (usize, &[&str])| {
        let stem = three[0].strip_suffix("_x")?;
        let side_by_side = three[1].strip_suffix("_y") == Some(stem) && three[2].strip_suffix("_z") == Some(stem);
        side_by_side.then_some((i, stem == "position"))
    };
    names.windows(3).enumerate().filter_map(vector).collect()
}

fn vector(row: &[f32]) -> Vec3 {
    Vec3::new(row[0].into(), row[1].into(), row[2].into())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    /// A parent at (1, 0, 0), turned by 90 degrees about z: its x axis is the world's y.
    fn block() -> BlockTrace {
        let h = 0.5_f64.sqrt();
        let one = |x: f64| vec![x];
        let frame = [one(1.0), one(0.0), one(0.0), one(h), one(0.0), one(0.0), one(h)];
        let frame: Vec<(&str, &[f64])> = FRAME.into_iter().zip(&frame).map(|(name, x)| (name, &x[..])).collect();
        let three = |stem: &'static str| ["x", "y", "z"].map(|axis| format!("{stem}_{axis}"));
        let (place, force) = (three("position"), three("force"));
        let columns = |names: &[String; 3], xyz: [f64; 3]| Columns {
            names: names.to_vec(),
            values: xyz.map(|x| x as f32).to_vec(),
        };
        BlockTrace {
            name: "shin".into(),
            class: "body".into(),
            simulated: columns(&place, [1.0, 2.0, 3.0]),
            measured: columns(&place, [1.1, 2.0, 3.0]),
            force: columns(&force, [5.0, 0.0, 7.0]),
            frame: Columns::new(&frame),
            ..BlockTrace::default()
        }
    }

    fn near(got: &[f32], expected: [f32; 3]) {
        assert!(got.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-6), "{got:?} for {expected:?}");
    }

    #[test]
    fn places_and_forces_by_hand() {
        let local = Frame::Parent.of(&block()).unwrap();
        near(&local.simulated.values, [2.0, 0.0, 3.0]);
        near(&local.measured.values, [2.0, -0.1, 3.0]);
        near(&local.force.values, [0.0, -5.0, 7.0]);
        assert_eq!(Frame::World.of(&block()).unwrap(), block());
        // The error comes back where it was: 0.1 along the world's x.
        let mut error = [0.0, -0.1, 0.0];
        Frame::Parent.leave(&block(), &["position_x", "position_y", "position_z"], &mut error).unwrap();
        near(&error, [0.1, 0.0, 0.0]);
    }

    #[test]
    fn bodies_without_a_parent_are_refused_and_actuators_have_none() {
        let old = BlockTrace { frame: Columns::default(), ..block() };
        let text = Frame::Parent.of(&old).unwrap_err().to_string();
        assert!(text.contains("'shin'") && text.contains("augmentation.frame='world'"), "{text}");
        let servo = BlockTrace { simulated: Columns::new(&[("position", &[1.0])]), ..BlockTrace::default() };
        assert_eq!(Frame::Parent.of(&servo).unwrap(), servo);
        let names = ["position_x", "position_y", "position_z", "turn_x", "turn_z", "a_x", "a_y", "a_z"];
        assert_eq!(vectors(&names), [(0, true), (5, false)]);
    }
}
