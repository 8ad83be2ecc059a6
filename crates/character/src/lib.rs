//! Floor 0: what a character *is*.
//!
//! A [`Character`] is a constant: a kinematic tree of bodies with joints, inertias, geoms and sites, read from MJCF or
//! URDF text. Everything that moves (poses, velocities) lives elsewhere and refers to the character by name.
//!
//! The main path: [`Character::load`] → [`Kinematics`] (where every body is, for a generalised position) →
//! [`Anatomy`] (which body is the left foot) → [`Symmetry`] (what is left of what).
//!
//! Conventions of the whole project: SI units, radians, z up, x forward, right-handed; quaternions `wxyz`.

pub mod anatomy;
pub mod error;
pub mod inertia;
pub mod kinematics;
mod load;
pub mod mjcf;
pub mod model;
pub mod rotation;
pub mod symmetry;
pub mod urdf;

pub use anatomy::{Anatomy, Role};
pub use error::{CharacterError, Location};
pub use kinematics::Kinematics;
pub use model::{Actuator, Body, Character, Geom, GeomShape, Inertial, Joint, JointKind, Site};
pub use rotation::{Mat3, Quat, Vec3};
pub use symmetry::Symmetry;
