//! Motion as it was captured: a human skeleton of its own, before any robot is thought of.

use lifelike_character::{Quat, Vec3};

use crate::clip::Caption;
use crate::error::MotionError;
use crate::roles::{Roles, Tree};

/// The skeleton that a capture came with. All of it in the rest pose, in metres, z up, x forward, y left.
#[derive(Debug, Clone, PartialEq)]
pub struct Skeleton {
    /// Joint names, parents before children.
    pub names: Vec<String>,
    /// Parent of each joint; `None` for the root.
    pub parents: Vec<Option<usize>>,
    /// Offset of each joint from its parent in the rest pose (m).
    pub offsets: Vec<Vec3>,
    /// End sites (finger tips, toes): the joint they hang on, and the offset (m).
    pub ends: Vec<(usize, Vec3)>,
}

impl Skeleton {
    pub(crate) fn tree(&self) -> Tree<'_> {
        Tree { names: &self.names, parents: &self.parents, offsets: &self.offsets }
    }

    /// Returns whether the left leg of these roles is on the right side.
    pub(crate) fn is_mirrored(&self, roles: &Roles) -> bool {
        let places = self.rest_positions();
        roles.legs().is_some_and(|[left, right]| places[left[0]].y < places[right[0]].y)
    }

    /// Returns the positions of the joints in the rest pose, the root at the origin (m).
    pub(crate) fn rest_positions(&self) -> Vec<Vec3> {
        let mut positions: Vec<Vec3> = Vec::with_capacity(self.names.len());
        for (offset, parent) in self.offsets.iter().zip(&self.parents) {
            positions.push(parent.map_or_else(Vec3::zeros, |p| positions[p] + offset));
        }
        positions
    }
}

/// A captured clip: rotations of each joint's frame, which in the rest pose is aligned with the world (z up, x
/// forward).
///
/// So a joint's WORLD rotation is the rotation that its segment made since the rest pose, whatever axes the file used.
#[derive(Debug, Clone, PartialEq)]
pub struct SourceClip {
    /// Name, from the file's name.
    pub name: String,
    /// Frames per second.
    pub fps: f64,
    /// The skeleton.
    pub skeleton: Skeleton,
    /// Position of the root joint (m, world), one per frame.
    pub root_position: Vec<Vec3>,
    /// Rotation of each joint relative to its parent, `[frame][joint]`; the root's is relative to the world.
    pub rotations: Vec<Vec<Quat>>,
    /// Flag of a clip that is one cycle and may be repeated.
    pub cyclic: bool,
    /// Captions.
    pub captions: Vec<Caption>,
    /// Source and terms of use, as far as known.
    pub provenance: String,
    /// Guesses and repairs of the reader that a user should know of.
    pub notes: Vec<String>,
}

impl SourceClip {
    /// Returns the number of frames.
    pub fn len(&self) -> usize {
        self.root_position.len()
    }

    /// Returns whether there is no frame.
    pub fn is_empty(&self) -> bool {
        self.root_position.is_empty()
    }

    /// Returns the duration from the first to the last frame (s).
    pub fn seconds(&self) -> f64 {
        self.len().saturating_sub(1) as f64 / self.fps
    }

    /// Checks that the clip is one that can be computed with: at least two frames and 0.2 s of finite numbers, one
    /// rotation for each frame and joint, and a skeleton with parents before children.
    ///
    /// # Errors
    /// [`MotionError::Unfit`] with the first thing that is wrong.
    pub fn check(&self) -> Result<(), MotionError> {
        let unfit = |message: String| Err(MotionError::Unfit { clip: self.name.clone(), message });
        let n = self.skeleton.names.len();
        if !(self.fps.is_finite() && self.fps > 0.0) {
            return unfit(format!("its rate is {} frames per second", self.fps));
        }
        if self.len() < 2 || self.seconds() < 0.2 {
            return unfit(format!(
                "it is too short: {} frames, {:.3} s; at least 0.2 s are needed",
                self.len(),
                self.seconds()
            ));
        }
        if self.rotations.len() != self.len() || self.rotations.iter().any(|r| r.len() != n) {
            return unfit(format!("its rotations are not one per frame and joint ({} frames, {n} joints)", self.len()));
        }
        let skeleton = &self.skeleton;
        if skeleton.parents.len() != n
            || skeleton.offsets.len() != n
            || skeleton.parents.iter().enumerate().any(|(j, p)| p.is_some_and(|p| p >= j))
        {
            return unfit("its skeleton is not a tree with parents before children".into());
        }
        for t in 0..self.len() {
            let rotations = self.rotations[t].iter().all(|r| r.coords.iter().all(|c| c.is_finite()));
            if !rotations || !self.root_position[t].iter().all(|c| c.is_finite()) {
                return unfit(format!("frame {t} holds a number that is not finite"));
            }
        }
        Ok(())
    }

    /// Returns the world position and rotation of every joint at one frame.
    pub fn pose(&self, frame: usize) -> (Vec<Vec3>, Vec<Quat>) {
        let n = self.skeleton.names.len();
        let (mut positions, mut rotations) = (Vec::with_capacity(n), Vec::with_capacity(n));
        for joint in 0..n {
            let local = self.rotations[frame][joint];
            match self.skeleton.parents[joint] {
                None => {
                    positions.push(self.root_position[frame]);
                    rotations.push(local);
                }
                Some(parent) => {
                    let position: Vec3 = positions[parent] + rotations[parent] * self.skeleton.offsets[joint];
                    let rotation: Quat = rotations[parent] * local;
                    positions.push(position);
                    rotations.push(rotation);
                }
            }
        }
        (positions, rotations)
    }
}
