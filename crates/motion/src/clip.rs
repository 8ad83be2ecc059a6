//! A motion of one character: the root's pose and the joints' angles by name, at a constant rate.

use lifelike_character::{Character, JointKind, Quat, Vec3};

use crate::error::MotionError;

/// A sentence about a stretch of a clip.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Caption {
    /// Start (s).
    pub start: f64,
    /// End (s).
    pub end: f64,
    /// The sentence.
    pub text: String,
}

/// Provenance of a clip.
#[derive(Debug, Clone, Default, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Provenance {
    /// The character that it was made for.
    pub character: String,
    /// The file or data set it came from.
    pub source: String,
    /// Terms of use, as far as known.
    pub licence: String,
    /// Captions.
    pub captions: Vec<Caption>,
}

/// Contacts with the ground: sites and times.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Contacts {
    /// Names of the bodies (feet).
    pub names: Vec<String>,
    /// `[frame * names.len() + place]`.
    pub flags: Vec<bool>,
}

/// A motion of one character.
#[derive(Debug, Clone, PartialEq)]
pub struct MotionClip {
    /// Name, unique within a data set.
    pub name: String,
    /// Frames per second.
    pub fps: f64,
    /// Names of the hinge and slide joints, one per column of `joints`.
    pub joint_names: Vec<String>,
    /// Position of the root body's frame (m, world), one per frame.
    pub root_position: Vec<Vec3>,
    /// Orientation of the root body, one per frame, without sign flips between neighbours.
    pub root_orientation: Vec<Quat>,
    /// Joint angles (rad) or slides (m), row-major `[frame, joint]`.
    pub joints: Vec<f64>,
    /// Foot contacts, where they are known.
    pub contacts: Option<Contacts>,
    /// Flag of a clip that may be repeated end to start.
    pub cyclic: bool,
    /// Provenance.
    pub provenance: Provenance,
}

impl MotionClip {
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

    /// Checks that there is a frame, that the rate is positive, that arrays fit together, that names are unique and
    /// numbers finite.
    ///
    /// # Errors
    /// [`MotionError::Unfit`] with the first thing that is wrong, and the frame where it is.
    pub fn check(&self) -> Result<(), MotionError> {
        let unfit = |message: String| Err(MotionError::Unfit { clip: self.name.clone(), message });
        let (frames, joints) = (self.len(), self.joint_names.len());
        if frames == 0 {
            return unfit("expected at least one frame, got none".into());
        }
        if !(self.fps.is_finite() && self.fps > 0.0) {
            return unfit(format!("expected a positive number of frames per second, got {}", self.fps));
        }
        if self.root_orientation.len() != frames {
            return unfit(format!("expected {frames} root orientations, got {}", self.root_orientation.len()));
        }
        if frames.checked_mul(joints) != Some(self.joints.len()) {
            return unfit(format!("expected {frames} x {joints} joint values, got {}", self.joints.len()));
        }
        if let Some(contacts) = &self.contacts {
            let places = contacts.names.len();
            if frames.checked_mul(places) != Some(contacts.flags.len()) {
                return unfit(format!("expected {frames} x {places} contacts, got {}", contacts.flags.len()));
            }
        }
        let mut seen = std::collections::BTreeSet::new();
        if let Some(twice) = self.joint_names.iter().find(|name| !seen.insert(name.as_str())) {
            return unfit(format!("joint '{twice}' stands twice"));
        }
        for frame in 0..frames {
            let root = self.root_position[frame].iter().chain(self.root_orientation[frame].coords.iter());
            if !root.copied().all(f64::is_finite) {
                return unfit(format!("root pose of frame {frame} is not finite"));
            }
            if let Some(joint) = self.joints_at(frame).iter().position(|v| !v.is_finite()) {
                return unfit(format!("joint '{}' of frame {frame} is not finite", self.joint_names[joint]));
            }
        }
        Ok(())
    }

    /// Returns the joints' values at one frame.
    pub fn joints_at(&self, frame: usize) -> &[f64] {
        let n = self.joint_names.len();
        &self.joints[frame * n..(frame + 1) * n]
    }

    /// Matches the clip's columns with the character's scalar joints BY NAME. Element `i` is the clip's column for the
    /// character's `i`-th scalar joint. Columns of joints that follow others are not used.
    ///
    /// # Errors
    /// [`MotionError::Mismatch`] lists every name that one has and the other has not.
    pub fn columns_for(&self, character: &Character) -> Result<Vec<usize>, MotionError> {
        let wanted: Vec<&str> = character.scalar_joints().map(|j| j.name.as_str()).collect();
        let missing: Vec<&str> = wanted.iter().copied().filter(|n| !self.joint_names.iter().any(|m| m == n)).collect();
        let is_known = |name: &str| character.joints.iter().any(|j| j.name == name && j.kind.nq() == 1);
        let unknown: Vec<&str> = self.joint_names.iter().map(String::as_str).filter(|n| !is_known(n)).collect();
        if !missing.is_empty() || !unknown.is_empty() {
            return Err(MotionError::Mismatch {
                clip: self.name.clone(),
                character: character.name.clone(),
                message: self.other_joints(&missing, &unknown),
            });
        }
        Ok(wanted.iter().filter_map(|n| self.joint_names.iter().position(|m| m == n)).collect())
    }

    /// Says that the joints are another robot's, and the remedy.
    fn other_joints(&self, missing: &[&str], unknown: &[&str]) -> String {
        let counted = |names: &[&str], which: &str| {
            names.first().map(|first| format!("{} {which}, such as '{first}'", names.len()))
        };
        let differ = [counted(missing, "joints are missing"), counted(unknown, "are unknown")];
        let differ = differ.into_iter().flatten().collect::<Vec<_>>().join("; ");
        let of = match self.provenance.character.as_str() {
            "" => String::new(),
            name => format!("it is motion of '{name}'; "),
        };
        format!(
            "{of}{differ}. Motion of another robot is retargeted: \
             lifelike motion retarget CLIP --source-robot ITS_ROBOT --robot ROBOT -o FOLDER"
        )
    }

    /// Writes the generalised position at one frame, in MuJoCo's layout. `columns` is from [`Self::columns_for`].
    pub fn write_position(&self, character: &Character, columns: &[usize], frame: usize, q: &mut [f64]) {
        let row = self.joints_at(frame);
        let mut scalar = 0;
        for joint in &character.joints {
            let at = joint.q_index;
            match joint.kind {
                JointKind::Free => {
                    q[at..at + 3].copy_from_slice(self.root_position[frame].as_slice());
                    q[at + 3..at + 7]
                        .copy_from_slice(&lifelike_character::rotation::to_wxyz(&self.root_orientation[frame]));
                }
                // What follows another joint is where that one puts it.
                _ if !joint.is_scalar() => {}
                _ => {
                    q[at] = row[columns[scalar]];
                    scalar += 1;
                }
            }
        }
    }
}
