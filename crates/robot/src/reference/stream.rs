//! Motion to follow, as a controller sees it.

use lifelike_character::rotation::from_wxyz;
use lifelike_character::{Quat, Vec3};
use lifelike_motion::{FeatureLayout, Frame};
use nalgebra::Vector3;

use super::library::ReferenceLibrary;

/// Root pose of a reference frame in the reference's own world.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RootPose {
    /// Position (m).
    pub position: [f32; 3],
    /// Orientation (`wxyz`).
    pub orientation: [f32; 4],
}

/// Motion to follow: a clip player, an edit, a generator or a live operator; the controller cannot tell which.
///
/// Time: the robot is in the present frame t and shall reach t + 1, the *target*. A stream that ends repeats its last
/// frame, and before its first it repeats that.
pub trait ReferenceStream {
    /// Returns the names of joints and end effectors of its frames.
    fn layout(&self) -> &FeatureLayout;

    /// Returns the features (eq. 4.1) of the frame `steps` after the PRESENT one, in its own heading frame, `[F]`.
    fn ahead(&self, steps: u32) -> &[f32];

    /// Returns the features of the frame `steps` after (or before) the TARGET, in its own heading frame, `[F]`.
    fn around(&self, steps: i32) -> &[f32];

    /// Returns the root pose of the target.
    fn root(&self) -> RootPose;

    /// Returns the root pose of the present frame.
    fn present_root(&self) -> RootPose;

    /// Returns the latent code z_t of the target where the stream has it; `None`: the controller encodes the motion around
    /// the target ([`Self::write_frame`]).
    fn latent(&self) -> Option<&[f32]> {
        None
    }

    /// Writes the frame `steps` after (or before) the target, whose vectors are reused: what a motion prior's window is
    /// made of.
    fn write_frame(&self, steps: i32, out: &mut Frame);

    /// Goes on by one step.
    fn advance(&mut self);
}

/// A clip of a library, played frame by frame from any frame of it on. `L` is a reference to the library, or an `Arc`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ClipPlayer<L> {
    library: L,
    frame: usize,
}

impl<L: AsRef<ReferenceLibrary>> ClipPlayer<L> {
    /// Plays from this frame of the library on.
    pub fn new(library: L, frame: usize) -> Self {
        Self { library, frame }
    }

    /// The present frame of the library.
    pub fn frame(&self) -> usize {
        self.frame
    }

    /// Goes to another frame of the library.
    pub fn seek(&mut self, frame: usize) {
        self.frame = frame;
    }

    /// Returns true when the present frame is the last of its clip.
    pub fn is_over(&self) -> bool {
        self.library.as_ref().ahead(self.frame, 1) == self.frame
    }

    fn target(&self) -> usize {
        self.library.as_ref().ahead(self.frame, 1)
    }

    fn pose(&self, frame: usize) -> RootPose {
        let library = self.library.as_ref();
        RootPose { position: library.position_at(frame), orientation: library.orientation_at(frame) }
    }
}

impl<L: AsRef<ReferenceLibrary>> ReferenceStream for ClipPlayer<L> {
    fn layout(&self) -> &FeatureLayout {
        &self.library.as_ref().layout
    }

    fn ahead(&self, steps: u32) -> &[f32] {
        let library = self.library.as_ref();
        library.features_at(library.ahead(self.frame, steps as usize))
    }

    fn around(&self, steps: i32) -> &[f32] {
        let library = self.library.as_ref();
        library.features_at(library.around(self.target(), steps))
    }

    fn root(&self) -> RootPose {
        self.pose(self.target())
    }

    fn present_root(&self) -> RootPose {
        self.pose(self.frame)
    }

    fn latent(&self) -> Option<&[f32]> {
        let library = self.library.as_ref();
        (library.latent > 0).then(|| library.latent_at(self.target()))
    }

    fn write_frame(&self, steps: i32, out: &mut Frame) {
        let library = self.library.as_ref();
        let frame = library.around(self.target(), steps);
        let wide = |v: [f32; 3]| Vec3::from(v.map(f64::from));
        out.root_position = wide(library.position_at(frame));
        out.root_orientation = from_wxyz(library.orientation_at(frame).map(f64::from)).unwrap_or_else(Quat::identity);
        out.linear_velocity_w = wide(library.linear_velocity_at(frame));
        out.angular_velocity_w = wide(library.angular_velocity_at(frame));
        out.joint_positions.clear();
        out.joint_positions.extend(library.joints_at(frame).iter().map(|q| f64::from(*q)));
        out.joint_velocities.clear();
        out.joint_velocities.extend(library.joint_velocities_at(frame).iter().map(|q| f64::from(*q)));
        let heading = lifelike_character::rotation::heading(&out.root_orientation);
        let (effectors, root) = (&library.features_at(frame)[library.layout.effectors()], out.root_position);
        out.effectors_w.clear();
        out.effectors_w.extend(effectors.chunks_exact(3).map(|p| {
            let place = Vector3::new(f64::from(p[0]), f64::from(p[1]), f64::from(p[2]));
            root + heading * place
        }));
    }

    fn advance(&mut self) {
        self.frame = self.target();
    }
}
