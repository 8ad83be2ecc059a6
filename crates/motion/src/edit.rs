//! Direction (thesis 4.3.4): motion made from motion, without retraining anything.
//!
//! Every operation takes clips of a robot and gives a [`MotionClip`](crate::MotionClip) like any other, joints by name:
//! [`sequence`] and [`blend`](mod@blend) put clips together in time, [`compose`](mod@compose) in space (the arms of
//! another clip); [`warp`](mod@warp) moves events in time, [`place`](mod@place) puts a body exactly where it is to be;
//! [`amplify`](mod@amplify), [`smooth`](mod@smooth), [`mirror`](mod@mirror) and [`trim`](mod@trim) change how the whole
//! looks, and [`settle`] finishes what others have changed. [`speed`] says what an actuator could not follow.

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
