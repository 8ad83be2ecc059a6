//! Direction (thesis 4.3.4): motion made from motion, without retraining anything.
//!
//! Every operation takes clips of a robot and returns a [`MotionClip`](crate::MotionClip), joints by name:
//!
//! - [`sequence()`] and [`blend`](mod@blend) combine clips in time, [`compose`](mod@compose) in space (the arms of
//!   another clip);
//! - [`warp`](mod@warp) moves events in time, [`place`](mod@place) moves a body to a given position;
//! - [`amplify`](mod@amplify), [`smooth`](mod@smooth), [`mirror`](mod@mirror) and [`trim`](mod@trim) change the whole
//!   clip;
//! - [`settle`] restores joint ranges and ground contact after other edits;
//! - [`speed`] lists joints that are too fast for their actuators.

pub mod amplify;
pub mod blend;
pub mod compose;
mod joints;
pub mod mirror;
mod monotone;
pub mod parts;
mod path;
pub mod place;
mod poses;
pub mod repair;
mod restyle;
pub mod sequence;
pub mod smooth;
pub mod speed;
mod story;
mod support;
pub mod trim;
pub mod warp;

pub use amplify::{Amplify, Around, amplify};
pub use blend::blend;
pub use compose::{Compose, Length, compose};
pub use mirror::mirror;
pub use parts::joints_of;
pub use place::{Key, PlaceReport, Target, place};
pub use repair::{Repaired, compare, repair};
pub use restyle::settle;
pub use sequence::{Part, sequence};
pub use smooth::{low_passed, smooth};
pub use speed::{TooFast, too_fast};
pub use support::support_shift;
pub use trim::trim;
pub use warp::{Warp, warp};
