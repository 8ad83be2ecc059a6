//! Poses of a page, as its own program reads them.

use lifelike_character::rotation::from_wxyz;
use lifelike_character::{Quat, Vec3};
use serde_json::Value;

use crate::base64::decode;
use crate::playback::BodyPose;
use crate::{FromInput, ReportError};

/// Poses of all bodies over time.
#[derive(Debug)]
pub(super) struct Track {
    frames: Vec<Vec<BodyPose>>,
    fps: f64,
}

impl Track {
    /// Reads the poses that [`crate::Playback`] packs; nothing where there are none.
    pub fn read(packed: &Value, frames: usize, bodies: usize, fps: f64) -> Result<Option<Self>, ReportError> {
        if packed.is_null() {
            return Ok(None);
        }
        let bytes = packed["data"].as_str().and_then(decode).unwrap_or_default();
        let unit = packed["unit"].as_f64().unwrap_or_default();
        let expected = frames * (12 + 14 * bodies);
        if bytes.len() != expected || frames == 0 {
            let (expected, got) = (format!("{expected} bytes of poses"), format!("{}", bytes.len()));
            return Err(ReportError::mismatch("motion on the page", expected, got));
        }
        let (roots, poses) = bytes.split_at(12 * frames);
        let float = |b: &[u8]| f64::from(f32::from_le_bytes([b[0], b[1], b[2], b[3]]));
        let short = |b: &[u8]| f64::from(i16::from_le_bytes([b[0], b[1]]));
        let root = |bytes: &[u8]| Vec3::new(float(bytes), float(&bytes[4..]), float(&bytes[8..]));
        let body = |root: Vec3, b: &[u8]| {
            let v: Vec<f64> = b.chunks_exact(2).map(short).collect();
            let turn = from_wxyz([v[3], v[4], v[5], v[6]]).unwrap_or_else(Quat::identity);
            (root + Vec3::new(v[0], v[1], v[2]) * unit, turn)
        };
        let all = roots.chunks_exact(12).zip(poses.chunks_exact(14 * bodies.max(1)));
        let frames = all
            .map(|(r, poses)| {
                let root = root(r);
                poses.chunks_exact(14).map(|b| body(root, b)).collect()
            })
            .collect();
        Ok(Some(Self { frames, fps }))
    }

    /// Returns the poses at a time (s), between the two frames around it.
    pub fn pose(&self, time: f64) -> Vec<BodyPose> {
        let last = self.frames.len() - 1;
        let at = (time * self.fps).clamp(0.0, last as f64);
        let (a, b) = (&self.frames[at as usize], &self.frames[(at as usize + 1).min(last)]);
        let share = at.fract();
        a.iter().zip(b).map(|(a, b)| (a.0.lerp(&b.0, share), a.1.nlerp(&b.1, share))).collect()
    }

    /// Returns the root's way without its sway (m).
    pub fn calm_root(&self, time: f64) -> Vec3 {
        let n = 9;
        let root = |i: i32| self.pose(time + (f64::from(i) / f64::from(n - 1) - 0.5) * 0.9)[0].0;
        (0..n).map(root).sum::<Vec3>() / f64::from(n)
    }
}
