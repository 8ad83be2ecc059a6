//! Motion to follow: [`ReferenceStream`] is what a controller asks for, [`ClipPlayer`] plays clips of a
//! [`ReferenceLibrary`], and an [`Alignment`] lays their world over the robot's.

mod alignment;
mod encoder;
mod library;
mod stream;

pub use alignment::{Alignment, Laid, Offset, wrap, yaw};
pub use encoder::LatentEncoder;
pub use library::{ReferenceLibrary, SOLE_DOWN, standing_clip};
pub use stream::{ClipPlayer, ReferenceStream, RootPose};
