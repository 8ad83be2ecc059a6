//! From a file's own axes, unit and rest pose to those of [`SourceClip`].

use lifelike_character::{Quat, Vec3};

use super::rest;
use crate::source::{Skeleton, SourceClip};

/// A skeleton and its motion as a file has them.
pub(crate) struct RawClip {
    pub name: String,
    pub provenance: String,
    pub fps: f64,
    pub cyclic: bool,
    pub names: Vec<String>,
    pub parents: Vec<Option<usize>>,
    /// Offset of a joint in its parent's frame (m).
    pub offsets: Vec<Vec3>,
    pub ends: Vec<(usize, Vec3)>,
    /// World rotation of each joint's frame when the body stands in its rest pose. Identity where the file's zero pose
    /// is the rest pose.
    pub rest: Vec<Quat>,
    /// Facts about that rest pose that geometry does not show.
    pub hints: rest::Hints,
    /// Turns the file's world into ours (z up, x forward, y left).
    pub basis: Quat,
    /// Position of the root (m, the file's axes).
    pub root_position: Vec<Vec3>,
    /// Rotation of a joint's frame in its parent's, `[frame][joint]`, in the file's axes.
    pub rotations: Vec<Vec<Quat>>,
}

impl RawClip {
    /// Changes axes and rest pose.
    ///
    /// With `W` a joint's world rotation in the file, `B` its rest, `C` the basis and `T` the straightening of the rest
    /// pose, the new world rotation is `C W B^-1 C^-1 T^-1`; so the local one is `(T C B)_parent L (T C B)_joint^-1`.
    pub(crate) fn finish(self, t_pose: bool) -> SourceClip {
        let n = self.names.len();
        let turned: Vec<Quat> = self.rest.iter().map(|b| self.basis * b * self.basis.inverse()).collect();
        let place = |joint: usize, offset: &Vec3| turned[joint] * (self.basis * offset);
        let mut skeleton = Skeleton {
            offsets: (0..n).map(|j| self.parents[j].map_or_else(Vec3::zeros, |p| place(p, &self.offsets[j]))).collect(),
            ends: self.ends.iter().map(|(joint, offset)| (*joint, place(*joint, offset))).collect(),
            names: self.names,
            parents: self.parents,
        };
        let straight = if t_pose { rest::straighten(&mut skeleton, &self.hints) } else { vec![Quat::identity(); n] };

        let frames: Vec<Quat> = (0..n).map(|j| straight[j] * self.basis * self.rest[j]).collect();
        let before: Vec<Quat> = skeleton.parents.iter().map(|p| p.map_or(self.basis, |p| frames[p])).collect();
        let after: Vec<Quat> = frames.iter().map(Quat::inverse).collect();
        let mut rotations = self.rotations;
        for frame in &mut rotations {
            for (joint, rotation) in frame.iter_mut().enumerate() {
                *rotation = before[joint] * *rotation * after[joint];
            }
        }
        without_flips(&mut rotations);
        SourceClip {
            name: self.name,
            fps: self.fps,
            skeleton,
            root_position: self.root_position.iter().map(|p| self.basis * p).collect(),
            rotations,
            cyclic: self.cyclic,
            captions: Vec::new(),
            provenance: self.provenance,
        }
    }
}

/// Of the two quaternions of each rotation, takes the one next to the frame before.
fn without_flips(rotations: &mut [Vec<Quat>]) {
    for at in 1..rotations.len() {
        let (done, rest) = rotations.split_at_mut(at);
        for (now, before) in rest[0].iter_mut().zip(&done[at - 1]) {
            if now.coords.dot(&before.coords) < 0.0 {
                *now = Quat::new_unchecked(-now.into_inner());
            }
        }
    }
}

/// Returns a rotation about one of the file's axes (0 = x, 1 = y, 2 = z) by an angle (rad).
pub(crate) fn about(axis: usize, angle: f64) -> Quat {
    let (sin, cos) = (0.5 * angle).sin_cos();
    let mut imaginary = Vec3::zeros();
    imaginary[axis] = sin;
    Quat::new_unchecked(nalgebra::Quaternion::from_parts(cos, imaginary))
}

/// Returns the turn from y up, z forward, x left (Vicon, Daz, Bandai) to z up, x forward, y left.
pub(crate) fn from_y_up_z_forward() -> Quat {
    let columns = [Vec3::y(), Vec3::z(), Vec3::x()];
    Quat::from_matrix(&nalgebra::Matrix3::from_columns(&columns))
}

/// Returns the rate of a frame time (s). Files round the time (0.0083333 s), so a rate within 0.1% of a whole number is
/// that.
pub(crate) fn rate(frame_time: f64) -> f64 {
    let fps = 1.0 / frame_time;
    if (fps - fps.round()).abs() < 1e-3 * fps { fps.round().max(1.0) } else { fps }
}
