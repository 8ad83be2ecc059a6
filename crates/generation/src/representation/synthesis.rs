//! Rows to a clip: the root's path is summed, what lies between rows is a cubic curve through them.

use lifelike_character::rotation::{Turn, heading};
use lifelike_character::{Quat, Vec3};
use lifelike_motion::{MotionClip, Provenance};

use super::{FeatureMatrix, RepresentationSpec};
use crate::{FromInput, GenerationError};

impl FeatureMatrix {
    /// Returns the rows as a clip of `fps` frames per second that begins above the origin with heading 0:
    ///
    /// `ψ_{t+1} = ψ_t + ω_t / fps`, `p_{t+1} = p_t + R(ψ_t) v_t / fps`. Between rows every curve is the cubic through
    /// four of them (Catmull & Rom 1974). It is smooth at any rate, and passes through the rows. Velocity columns
    /// of joints are not needed. Feet are not touched: see `representation::grounded`.
    ///
    /// # Errors
    /// [`GenerationError::Input`] for no row, rows of another width, a number that is not finite, or a bad rate.
    pub fn to_clip(&self, spec: &RepresentationSpec, name: &str, fps: f64) -> Result<MotionClip, GenerationError> {
        spec.check()?;
        if self.width != spec.width() || self.n == 0 || self.rows.len() != self.n * self.width {
            let got = format!("{} numbers as {} x {}", self.rows.len(), self.n, self.width);
            let expected = format!("at least one row of {}", spec.width());
            return Err(GenerationError::mismatch("feature matrix", expected, got));
        }
        if let Some(at) = self.rows.iter().position(|x| !x.is_finite()) {
            let got = format!("{} in row {}, column {}", self.rows[at], at / self.width, at % self.width);
            return Err(GenerationError::mismatch("feature matrix", "finite numbers", got));
        }
        if !(fps > 0.0 && fps <= 1000.0) {
            return Err(GenerationError::mismatch("rate of the clip", "0 < rate <= 1000 Hz", fps));
        }
        let (width, curves) = self.curves(spec);
        let frames = ((self.n - 1) as f64 * fps / spec.fps + 1e-6).floor() as usize + 1;
        let mut clip = MotionClip {
            name: name.to_string(),
            fps,
            joint_names: spec.joint_names.clone(),
            root_position: Vec::with_capacity(frames),
            root_orientation: Vec::with_capacity(frames),
            joints: Vec::with_capacity(frames * spec.joints()),
            contacts: None,
            cyclic: false,
            provenance: Provenance::default(),
        };
        for frame in 0..frames {
            let at = cubic(&curves, width, frame as f64 * spec.fps / fps);
            clip.root_position.push(Vec3::new(at[0], at[1], at[2]));
            let turn = Quat::from_axis_angle(&Vec3::z_axis(), at[3]) * tilt(Vec3::new(at[4], at[5], at[6]));
            let flipped = clip.root_orientation.last().is_some_and(|last: &Quat| last.coords.dot(&turn.coords) < 0.0);
            clip.root_orientation.push(if flipped { Quat::new_unchecked(-turn.into_inner()) } else { turn });
            clip.joints.extend_from_slice(&at[7..]);
        }
        Ok(clip)
    }

    /// Returns rows of position (m, world), heading (rad, unrolled), up direction and joint angles.
    fn curves(&self, spec: &RepresentationSpec) -> (usize, Vec<f64>) {
        let width = 7 + spec.joints();
        let mut out = Vec::with_capacity(self.n * width);
        let (mut place, mut yaw) = ([0.0_f64; 2], 0.0);
        for row in self.rows.chunks_exact(self.width) {
            let number = |at: usize| f64::from(row[at]);
            out.extend([place[0], place[1], number(RepresentationSpec::HEIGHT), yaw]);
            out.extend(row[RepresentationSpec::UP].iter().chain(&row[spec.angles()]).map(|x| f64::from(*x)));
            let [vx, vy] = Turn::by(yaw).on_ground([number(1), number(2)]);
            place = [place[0] + vx / spec.fps, place[1] + vy / spec.fps];
            yaw += number(RepresentationSpec::YAW_RATE) / spec.fps;
        }
        (width, out)
    }
}

/// Returns the rotation without heading under which the world's up is `up` in the body's frame; without a direction
/// the identity.
fn tilt(up: Vec3) -> Quat {
    let Some(up) = up.try_normalize(1e-6) else { return Quat::identity() };
    let upside_down = || Quat::from_axis_angle(&Vec3::x_axis(), std::f64::consts::PI);
    let any = Quat::rotation_between(&up, &Vec3::z()).unwrap_or_else(upside_down);
    heading(&any).inverse() * any
}

/// Returns the cubic through rows at a place between them (in rows); slopes at the ends are one-sided.
fn cubic(rows: &[f64], width: usize, place: f64) -> Vec<f64> {
    let last = rows.len() / width - 1;
    let before = (place.floor() as usize).min(last);
    let t = (place - before as f64).clamp(0.0, 1.0);
    let row = |i: usize| &rows[i.min(last) * width..][..width];
    let (a, b) = (row(before), row(before + 1));
    let slope = |i: usize, column: usize| {
        let (low, high) = (i.saturating_sub(1), (i + 1).min(last));
        if high > low { (row(high)[column] - row(low)[column]) / (high - low) as f64 } else { 0.0 }
    };
    let (t2, t3) = (t * t, t * t * t);
    let value = |c: usize| {
        let (m0, m1) = (slope(before, c), slope((before + 1).min(last), c));
        (2.0 * t3 - 3.0 * t2 + 1.0) * a[c] + (t3 - 2.0 * t2 + t) * m0 + (3.0 * t2 - 2.0 * t3) * b[c] + (t3 - t2) * m1
    };
    (0..width).map(value).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tilt_has_no_heading_and_that_up_direction() {
        for i in 0..60 {
            let t = f64::from(i);
            let any = Quat::from_euler_angles((t * 0.9).sin() * 3.0, (t * 0.7).cos() * 1.5, t * 1.3);
            let up = any.inverse() * Vec3::z();
            let back = tilt(up);
            assert!((back.inverse() * Vec3::z() - up).norm() < 1e-9);
            assert!(back.angle_to(&(heading(&any).inverse() * any)) < 1e-6, "{i}");
        }
        assert_eq!(tilt(Vec3::zeros()), Quat::identity());
        assert!((tilt(-Vec3::z()).inverse() * Vec3::z() + Vec3::z()).norm() < 1e-9);
    }

    #[test]
    fn a_cubic_meets_its_rows_and_follows_a_parabola() {
        let rows: Vec<f64> = (0..6).map(|i| f64::from(i * i)).collect();
        for i in 0..6 {
            assert_eq!(cubic(&rows, 1, f64::from(i)), [f64::from(i * i)]);
        }
        assert!((cubic(&rows, 1, 2.5)[0] - 6.25).abs() < 1e-12);
        assert_eq!(cubic(&[3.0], 1, 0.0), [3.0]);
    }
}
