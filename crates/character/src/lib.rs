//! Floor 0: what a character *is*.
//!
//! A [`Character`] is a constant: a kinematic tree of bodies with joints, inertias, geoms and sites, read from MJCF or
//! URDF text. State (poses, velocities) is stored elsewhere and refers to the character by name.
//!
//! The main path: [`Character::load`] → [`Kinematics`] (poses of all bodies) → [`Anatomy`] (roles of bodies, such as
//! the left foot) → [`Symmetry`] (pairs of left and right).
//!
//! Conventions of the whole project: SI units, radians, z up, x forward, right-handed; quaternions `wxyz`.
//!
//! ```
//! use lifelike_character::Character;
//!
//! let ball = "<mujoco><worldbody><body name='ball'><freejoint/><geom size='.1' mass='2'/></body></worldbody></mujoco>";
//! let character = Character::from_mjcf(ball, "ball.xml", None)?;
//! assert_eq!((character.mass(), character.nq, character.nv), (2.0, 7, 6));
//!
//! // What is not understood is refused with file, line and element.
//! let wheel = Character::from_mjcf("<mujoco><wheels/></mujoco>", "car.xml", None).unwrap_err();
//! assert_eq!(wheel.to_string(), "car.xml:1: <wheels>: unsupported section of a model");
//! # Ok::<(), lifelike_character::CharacterError>(())
//! ```

pub mod anatomy;
mod coupling;
mod drive;
pub mod error;
mod fitted;
pub mod inertia;
pub mod kinematics;
mod load;
mod mesh;
pub mod mjcf;
pub mod model;
mod outline;
mod reorder;
pub mod rotation;
pub mod symmetry;
pub mod urdf;

pub use anatomy::{Anatomy, Role};
pub use coupling::Coupling;
pub use drive::{Command, Drive};
pub use error::{CharacterError, Location};
pub use fitted::Fitted;
pub use kinematics::Kinematics;
pub use mesh::{MeshFile, Triangles};
pub use model::{Actuator, Body, Character, Equality, EqualityKind, Geom, GeomShape, Inertial, Joint, JointKind, Site};
pub use rotation::{Mat3, Quat, Vec3};
pub use symmetry::Symmetry;

/// The README's example, which runs as a test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
pub struct Readme;
