//! A clip as rows of numbers that do not depend on where on the ground it happens, and back.

use std::ops::Range;

use lifelike_character::rotation::{heading, heading_angle};
use lifelike_character::{Quat, Vec3};
use lifelike_motion::MotionClip;
use lifelike_motion::resample::locate;

/// A clip's frames.
///
/// A row holds, from its beginning: root height (m); tilt, the rotation vector of the root against its own heading
/// (rad, 3 numbers). Then come velocity over the ground, forward and left, on the way to the next frame (m/s), and
/// turn rate on that way (rad/s). Last are joints in the clip's order (rad or m). The last frame moves as the one
/// before it.
#[derive(Debug, Clone, PartialEq)]
pub struct Poses {
    /// Frames per second.
    pub fps: f64,
    /// Joints of a row.
    pub joints: usize,
    /// `[frames, width]`, row-major.
    pub rows: Vec<f64>,
}

impl Poses {
    /// Numbers before the joints.
    pub const ROOT: usize = 7;
    /// Height, tilt, velocity, turn rate: numbers of one kind are scaled alike.
    pub(super) const KINDS: [Range<usize>; 4] = [0..1, 1..4, 4..6, 6..7];
    /// Numbers that are rates, so grow with the speed of playing.
    pub(super) const RATES: Range<usize> = 4..7;

    /// Returns the poses of a clip.
    pub fn of(clip: &MotionClip) -> Self {
        let (joints, frames) = (clip.joint_names.len(), clip.len());
        let angle = |frame: usize| heading_angle(&clip.root_orientation[frame]);
        let mut rows = Vec::with_capacity(frames * (Self::ROOT + joints));
        for frame in 0..frames {
            let turn = clip.root_orientation[frame];
            let upright = heading(&turn).inverse();
            // The last frame moves as the one before it.
            let from = frame.min(frames.saturating_sub(2));
            let to = (from + 1).min(frames - 1);
            let step = heading(&clip.root_orientation[from]).inverse()
                * (clip.root_position[to] - clip.root_position[from])
                * clip.fps;
            rows.push(clip.root_position[frame].z);
            rows.extend((upright * turn).scaled_axis().iter());
            rows.extend([step.x, step.y, wrapped(angle(to) - angle(from)) * clip.fps]);
            rows.extend(clip.joints_at(frame));
        }
        Self { fps: clip.fps, joints, rows }
    }

    /// Returns the numbers of a row.
    pub fn width(&self) -> usize {
        Self::ROOT + self.joints
    }

    /// Returns the number of rows.
    pub fn len(&self) -> usize {
        self.rows.len() / self.width()
    }

    /// Returns whether there are none.
    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// Writes the row at a time in frames, between two of them linearly; beyond the ends the nearest.
    pub fn write_at(&self, frame: f64, out: &mut [f64]) {
        let (width, (before, share)) = (self.width(), locate(frame, self.len()));
        let row = |at: usize| &self.rows[at.min(self.len() - 1) * width..][..width];
        for ((out, a), b) in out.iter_mut().zip(row(before)).zip(row(before + 1)) {
            *out = a + share * (b - a);
        }
    }

    /// Returns a clip that begins where `like` does, with its names. Contacts are not known any more.
    pub fn to_clip(&self, like: &MotionClip) -> MotionClip {
        let width = self.width();
        let mut place = like.root_position.first().copied().unwrap_or_else(Vec3::zeros);
        let mut angle = like.root_orientation.first().map_or(0.0, heading_angle);
        let mut clip = MotionClip {
            fps: self.fps,
            root_position: Vec::with_capacity(self.len()),
            root_orientation: Vec::with_capacity(self.len()),
            joints: Vec::with_capacity(self.len() * self.joints),
            contacts: None,
            ..like.clone()
        };
        for row in self.rows.chunks_exact(width) {
            let turn = Quat::from_axis_angle(&Vec3::z_axis(), angle);
            clip.root_position.push(Vec3::new(place.x, place.y, row[0]));
            clip.root_orientation.push(turn * Quat::from_scaled_axis(Vec3::new(row[1], row[2], row[3])));
            clip.joints.extend(&row[Self::ROOT..]);
            place += turn * Vec3::new(row[4], row[5], 0.0) / self.fps;
            angle += row[6] / self.fps;
        }
        clip
    }
}

/// Returns an angle's equal in −π to π.
fn wrapped(angle: f64) -> f64 {
    (angle + std::f64::consts::PI).rem_euclid(std::f64::consts::TAU) - std::f64::consts::PI
}

#[cfg(test)]
mod tests {
    use super::super::testing::walk;
    use super::*;

    #[test]
    fn a_clip_comes_back() {
        let clip = walk("walk", 60, 25.0);
        let back = Poses::of(&clip).to_clip(&clip);
        for frame in 0..clip.len() {
            assert!((back.root_position[frame] - clip.root_position[frame]).norm() < 1e-9, "frame {frame}");
            assert!(back.root_orientation[frame].angle_to(&clip.root_orientation[frame]) < 1e-6, "frame {frame}");
            assert_eq!(back.joints_at(frame), clip.joints_at(frame));
        }
    }

    #[test]
    fn rows_do_not_depend_on_the_place() {
        let clip = walk("walk", 30, 25.0);
        let mut moved = clip.clone();
        let turn = Quat::from_axis_angle(&Vec3::z_axis(), 2.5);
        moved.root_position.iter_mut().for_each(|p| *p = turn * *p + Vec3::new(3.0, -4.0, 0.0));
        moved.root_orientation.iter_mut().for_each(|q| *q = turn * *q);
        let (a, b) = (Poses::of(&clip), Poses::of(&moved));
        assert!(a.rows.iter().zip(&b.rows).all(|(a, b)| (a - b).abs() < 1e-9));
        // Half a metre per second forward, turning left at 0.3 rad/s; the heading of a root that rolls sways a little.
        let row = &a.rows[..Poses::ROOT];
        assert!((row[4] - 0.5).abs() < 0.01 && row[5].abs() < 0.01 && (row[6] - 0.3).abs() < 0.01, "{row:?}");
    }

    #[test]
    fn between_rows_numbers_are_interpolated() {
        let poses = Poses { fps: 1.0, joints: 0, rows: [[0.0; 7], [2.0; 7]].concat() };
        let mut row = [0.0; 7];
        for (at, expected) in [(-1.0, 0.0), (0.25, 0.5), (1.0, 2.0), (7.0, 2.0)] {
            poses.write_at(at, &mut row);
            assert_eq!(row, [expected; 7]);
        }
    }
}
