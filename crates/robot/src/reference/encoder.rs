//! The one thing that references ask of a motion prior.

use lifelike_motion::{Frame, MotionClip};

use crate::error::RobotError;

/// Encoder of the motion around a frame into a latent code z_t (thesis 4.2.1), whatever network it is.
pub trait LatentEncoder {
    /// Returns the size of a code, d_z.
    fn latent_size(&self) -> usize;

    /// Returns the code of every frame of a clip at `fps` frames per second, `[frames, d_z]`.
    ///
    /// # Errors
    /// The clip does not fit the encoder.
    fn encode(&self, clip: &MotionClip, frames: &[Frame], fps: f64) -> Result<Vec<f32>, RobotError>;
}
