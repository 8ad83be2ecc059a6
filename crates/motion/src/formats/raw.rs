//! From a file's own axes, unit and rest pose to those of [`SourceClip`].

use std::collections::BTreeMap;

use lifelike_character::{Quat, Role, Vec3};

use super::anatomy::Samples;
use super::standing::{self, Known, Standing};
use super::{ReadOptions, rest};
use crate::error::MotionError;
use crate::roles::{self, Roles, Tree};
use crate::source::{Skeleton, SourceClip};

/// Rates that a user may state (frames per second).
const RATES: std::ops::RangeInclusive<f64> = 1.0..=10_000.0;

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
    /// Axes and rest pose, where the format says them.
    pub known: Option<Known>,
    /// Facts about that rest pose that geometry does not show.
    pub hints: rest::Hints,
    /// Position of the root (m, the file's axes).
    pub root_position: Vec<Vec3>,
    /// Rotation of a joint's frame in its parent's, `[frame][joint]`, in the file's axes.
    pub rotations: Vec<Vec<Quat>>,
    pub notes: Vec<String>,
}

impl RawClip {
    /// Changes axes and rest pose.
    ///
    /// `W` is a joint's world rotation in the file, `B` its rest, `C` the basis and `T` the straightening of the rest
    /// pose. The new world rotation is `C W B^-1 C^-1 T^-1`, so the local one is `(T C B)_parent L (T C B)_joint^-1`.
    ///
    /// # Errors
    /// [`MotionError::Unfit`] where axes or sides are in doubt, or a stated joint is not there.
    pub(crate) fn finish(mut self, options: &ReadOptions) -> Result<SourceClip, MotionError> {
        let name = self.name.clone();
        let unfit = |message: String| MotionError::Unfit { clip: name.clone(), message };
        if let Some(fps) = options.fps.filter(|fps| !RATES.contains(fps)) {
            return Err(unfit(format!("expected --fps of 1 to 10000 frames per second, got {fps}")));
        }
        let (given, toes) = options.correspondence.joints(&self.names).map_err(unfit)?;
        let mut roles = self.find_roles(&given);
        for (toe, given) in roles.toes.iter_mut().zip(toes) {
            *toe = given.or(*toe);
        }
        let samples = Samples::new(&self.parents, &self.offsets, &self.root_position, &self.rotations);
        let stated = standing::Stated { up: options.up, forward: options.forward };
        let known = self.known.take();
        let skeleton = standing::Skeleton { tree: self.tree(), ends: &self.ends };
        let standing = standing::find(&skeleton, &mut roles, &samples, stated, known).map_err(unfit)?;
        Ok(self.with_standing(standing, &roles, options.t_pose))
    }

    pub(crate) fn tree(&self) -> Tree<'_> {
        Tree { names: &self.names, parents: &self.parents, offsets: &self.offsets }
    }

    /// Finds the roles. A limb that ends in an end site gets a joint there.
    fn find_roles(&mut self, given: &BTreeMap<Role, usize>) -> Roles {
        let mut roles = roles::find(self.tree(), given);
        for [first, second, third] in roles::LEGS.into_iter().chain(roles::ARMS) {
            let (Some(_), Some(joint), None) = (roles.get(first), roles.get(second), roles.get(third)) else {
                continue;
            };
            let is_taken = self.names.iter().any(|name| *name == format!("{third:?}"));
            let Some(at) = self.ends.iter().position(|(j, _)| *j == joint).filter(|_| !is_taken) else { continue };
            let (_, offset) = self.ends.swap_remove(at);
            // By this name it has its role wherever the skeleton is read again.
            self.names.push(format!("{third:?}"));
            self.parents.push(Some(joint));
            self.offsets.push(offset);
            self.rotations.iter_mut().for_each(|frame| frame.push(Quat::identity()));
            if let Some(known) = &mut self.known {
                known.rest.push(known.rest[joint]);
            }
            roles.joints.insert(third, self.names.len() - 1);
        }
        roles
    }

    fn with_standing(self, standing: Standing, roles: &Roles, t_pose: bool) -> SourceClip {
        let Standing { basis, rest, notes } = standing;
        let n = self.names.len();
        let turned: Vec<Quat> = rest.iter().map(|b| basis * b * basis.inverse()).collect();
        let place = |joint: usize, offset: &Vec3| turned[joint] * (basis * offset);
        let mut skeleton = Skeleton {
            offsets: (0..n).map(|j| self.parents[j].map_or_else(Vec3::zeros, |p| place(p, &self.offsets[j]))).collect(),
            ends: self.ends.iter().map(|(joint, offset)| (*joint, place(*joint, offset))).collect(),
            names: self.names,
            parents: self.parents,
        };
        let straight =
            if t_pose { rest::straighten(&mut skeleton, roles, &self.hints) } else { vec![Quat::identity(); n] };

        let frames: Vec<Quat> = (0..n).map(|j| straight[j] * basis * rest[j]).collect();
        let before: Vec<Quat> = skeleton.parents.iter().map(|p| p.map_or(basis, |p| frames[p])).collect();
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
            root_position: self.root_position.iter().map(|p| basis * p).collect(),
            rotations,
            cyclic: self.cyclic,
            captions: Vec::new(),
            provenance: self.provenance,
            notes: [self.notes, notes].concat(),
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
