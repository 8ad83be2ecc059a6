//! Clips to follow, one after the other.

use std::sync::Arc;

use lifelike_motion::MotionClip;
use lifelike_robot::reference::standing_clip;
use lifelike_robot::{ClipPlayer, Controller, LatentEncoder, ReferenceLibrary, ReferenceStream};
use sha2::{Digest, Sha256};

use crate::error::RuntimeError;

/// Clips in their order, played once. At the end of one, the next is laid at the robot.
#[derive(Debug, Clone)]
pub struct Playlist {
    library: Arc<ReferenceLibrary>,
    player: ClipPlayer<Arc<ReferenceLibrary>>,
    /// First and last frame of each part in the library.
    parts: Vec<(usize, usize)>,
    part: usize,
    /// The first part is a stand, and after it comes this one: the robot has got up.
    interrupted: Option<usize>,
    first_up_b: [f32; 3],
}

impl Playlist {
    /// Makes a playlist of clips for a controller. With `standing` seconds of its default pose before and after them.
    ///
    /// # Errors
    /// A clip does not fit the robot; there is none.
    pub fn new(controller: &Controller, clips: &[MotionClip], standing: f64) -> Result<Self, RuntimeError> {
        let robot = controller.robot();
        let mut all = clips.to_vec();
        let mut order: Vec<usize> = (0..clips.len()).collect();
        if standing > 0.0 {
            all.push(standing_clip(robot, standing));
            order.insert(0, clips.len());
            order.push(clips.len());
        }
        let encoder = controller.prior().map(|prior| prior as &dyn LatentEncoder);
        let wanted = controller.observation().reference.latent > 0;
        let library = Arc::new(ReferenceLibrary::new(robot, &all, encoder.filter(|_| wanted))?);
        let parts = order.iter().map(|clip| library.range(*clip)).map(|range| (range.start, range.end - 1)).collect();
        Ok(Self::of(library, parts))
    }

    /// Makes a playlist of parts of a library: first and last frame of each.
    ///
    /// # Panics
    /// There is no part.
    pub fn of(library: Arc<ReferenceLibrary>, parts: Vec<(usize, usize)>) -> Self {
        let player = ClipPlayer::new(Arc::clone(&library), parts[0].0);
        let first_up_b = up_of(player.present_root().orientation);
        Self { library, player, parts, part: 0, interrupted: None, first_up_b }
    }

    /// Returns the player of the present clip.
    pub(crate) fn player(&mut self) -> &mut ClipPlayer<Arc<ReferenceLibrary>> {
        &mut self.player
    }

    /// Goes to the beginning.
    pub(crate) fn rewind(&mut self) {
        (self.part, self.interrupted) = (0, None);
        self.player.seek(self.parts[0].0);
    }

    /// Goes to the beginning, and from there to the part that was interrupted.
    pub(crate) fn resume(&mut self) {
        let part = self.interrupted.unwrap_or(self.part);
        self.rewind();
        self.interrupted = Some(part).filter(|part| *part > 0);
    }

    /// Goes to the next part where the present one has ended; returns whether it did.
    pub(crate) fn next_part(&mut self) -> bool {
        if self.player.frame() < self.parts[self.part].1 || self.part + 1 >= self.parts.len() {
            return false;
        }
        self.part = self.interrupted.take().unwrap_or(self.part + 1);
        self.player.seek(self.parts[self.part].0);
        true
    }

    /// Returns whether the last part has ended.
    pub fn is_over(&self) -> bool {
        self.part + 1 >= self.parts.len() && self.player.frame() >= self.parts[self.part].1
    }

    /// Returns the joint positions of the frame to reach, `[J]` (rad).
    pub(crate) fn joints(&self) -> &[f32] {
        let library = &self.library;
        library.joints_at(library.ahead(self.player.frame(), 1))
    }

    /// Returns the joint positions of the first frame, `[J]` (rad).
    pub(crate) fn first_joints(&self) -> &[f32] {
        self.library.joints_at(self.parts[0].0)
    }

    /// Returns the up direction of the present frame, seen from its root.
    pub(crate) fn up_b(&self) -> [f32; 3] {
        up_of(self.player.present_root().orientation)
    }

    /// Returns the up direction of the first frame, seen from its root.
    pub(crate) fn first_up_b(&self) -> [f32; 3] {
        self.first_up_b
    }

    /// Returns a SHA-256 over the frames and their order, hexadecimal.
    pub fn digest(&self) -> String {
        let mut hash = Sha256::new();
        for values in [&self.library.features, &self.library.root_position, &self.library.latents] {
            values.iter().for_each(|x| hash.update(x.to_le_bytes()));
        }
        self.parts.iter().for_each(|(first, last)| hash.update(format!("{first}-{last};")));
        hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
    }
}

/// Returns the world's up direction, seen from a body of this orientation (`wxyz`).
fn up_of([w, x, y, z]: [f32; 4]) -> [f32; 3] {
    [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)]
}
