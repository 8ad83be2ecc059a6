//! Motion windows, thesis eq. 4.2: M_t = {m_{t-W}, ..., m_{t+W}}, in the heading frame of the centre frame.

use crate::error::MotionError;
use crate::features::Frame;
use crate::resample::frame_at;

/// Position of a window in time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WindowSpec {
    /// W: frames before and after the centre.
    pub half_width: usize,
    /// Time between two frames of the window (s).
    pub dt: f64,
}

impl WindowSpec {
    /// Returns the number of frames, 2W + 1.
    pub fn len(&self) -> usize {
        2 * self.half_width + 1
    }

    /// Returns `false`: a window has at least its centre.
    pub fn is_empty(&self) -> bool {
        false
    }
}

/// Writes the window whose centre is at `centre_time` (s since the first frame) into `out`.
///
/// `frames` stand `1 / fps` s apart. Between frames the motion is interpolated; before the first and after the last
/// frame that frame is repeated, velocities and all (thesis 4.2.1).
///
/// # Shapes
/// `out: [2W + 1, F]`, `F` = `FeatureLayout::size()`; eq. 4.1's features, not yet divided by their spread.
///
/// # Errors
/// [`MotionError::Unfit`] when there are no frames, the rate or step is not positive, or `out` has the wrong length.
pub fn write_window(
    frames: &[Frame],
    fps: f64,
    centre_time: f64,
    window: WindowSpec,
    out: &mut [f64],
) -> Result<(), MotionError> {
    let unfit = |message: String| MotionError::Unfit { clip: "window".into(), message };
    let first = frames.first().ok_or_else(|| unfit("no frames".into()))?;
    let size = first.feature_size();
    if out.len() != size * window.len() {
        return Err(unfit(format!("expected room for {} x {size} numbers, got {}", window.len(), out.len())));
    }
    if !(fps > 0.0 && window.dt > 0.0 && centre_time.is_finite()) {
        return Err(unfit(format!(
            "expected positive rate and step and a finite time, got {fps} Hz, {} s, {centre_time} s",
            window.dt
        )));
    }
    let mut frame = first.clone();
    frame_at(frames, centre_time * fps, &mut frame);
    let centre = frame.root_orientation;
    for (i, row) in out.chunks_exact_mut(size).enumerate() {
        let offset = i as f64 - window.half_width as f64;
        frame_at(frames, (centre_time + offset * window.dt) * fps, &mut frame);
        frame.write_features(&centre, row);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use lifelike_character::{Quat, Vec3};

    /// One joint, one effector; walks along its own forward direction at 1 m/s, 10 frames per second.
    fn frames(yaw: f64, from: Vec3) -> Vec<Frame> {
        let turn = Quat::from_euler_angles(0.0, 0.0, yaw);
        (0..11)
            .map(|i| {
                let t = f64::from(i) * 0.1;
                let root = from + turn * Vec3::new(t, 0.0, 0.8 + 0.1 * t);
                Frame {
                    root_position: root,
                    root_orientation: turn * Quat::from_euler_angles(0.0, 0.2, 0.5 * t),
                    linear_velocity_w: turn * Vec3::new(1.0, 0.0, 0.1),
                    angular_velocity_w: Vec3::new(0.0, 0.0, 0.5),
                    joint_positions: vec![t * t],
                    joint_velocities: vec![2.0 * t],
                    effectors_w: vec![root + turn * Vec3::new(0.0, 0.3, t)],
                }
            })
            .collect()
    }

    fn window(frames: &[Frame], time: f64, spec: WindowSpec) -> Vec<Vec<f64>> {
        let size = 13 + 2 + 3;
        let mut out = vec![f64::NAN; size * spec.len()];
        write_window(frames, 10.0, time, spec, &mut out).unwrap();
        out.chunks(size).map(<[f64]>::to_vec).collect()
    }

    #[test]
    fn a_window_knows_neither_place_nor_heading() {
        let spec = WindowSpec { half_width: 3, dt: 0.07 };
        let here = window(&frames(0.0, Vec3::zeros()), 0.43, spec);
        let there = window(&frames(2.0, Vec3::new(5.0, -3.0, 0.0)), 0.43, spec);
        for (a, b) in here.iter().flatten().zip(there.iter().flatten()) {
            assert!((a - b).abs() < 1e-12, "{a} {b}");
        }
    }

    #[test]
    fn the_numbers_are_those_of_hand_arithmetic() {
        let spec = WindowSpec { half_width: 1, dt: 0.2 };
        let rows = window(&frames(0.0, Vec3::zeros()), 0.5, spec);
        // The centre frame heads 0.5 * 0.5 = 0.25 rad; at t = 0.3 and 0.7 the root is at height 0.8 + 0.1 t.
        let (s, c) = 0.25_f64.sin_cos();
        for (row, t) in rows.iter().zip([0.3, 0.5, 0.7]) {
            let expected_head = [0.8 + 0.1 * t];
            let yaw: f64 = 0.5 * t - 0.25;
            // First column of Rz(yaw) Ry(0.2).
            let first = [yaw.cos() * 0.2_f64.cos(), yaw.sin() * 0.2_f64.cos(), -0.2_f64.sin()];
            let velocity = [c, -s, 0.1, 0.0, 0.0, 0.5];
            let tail = [t * t, 2.0 * t, 0.3 * s, 0.3 * c, t];
            let parts = [(0, &expected_head[..]), (1, &first), (7, &velocity), (13, &tail)];
            for (at, part) in parts {
                for (g, e) in row[at..].iter().zip(part) {
                    assert!((g - e).abs() < 1e-9, "t {t}, from column {at}: {g} {e}");
                }
            }
        }
    }

    #[test]
    fn ends_are_repeated() {
        let all = frames(0.3, Vec3::zeros());
        let rows = window(&all, 0.0, WindowSpec { half_width: 2, dt: 0.1 });
        assert_eq!(rows[0], rows[2]);
        assert_eq!(rows[1], rows[2]);
        assert_ne!(rows[3], rows[2]);
        let rows = window(&all, 1.0, WindowSpec { half_width: 2, dt: 0.1 });
        assert_eq!(rows[4], rows[2]);
        assert_ne!(rows[1], rows[2]);
    }

    #[test]
    fn misuse_is_an_error() {
        let all = frames(0.0, Vec3::zeros());
        let mut out = vec![0.0; 18 * 3];
        let spec = WindowSpec { half_width: 1, dt: 0.1 };
        assert!(write_window(&[], 10.0, 0.0, spec, &mut out).is_err());
        assert!(write_window(&all, 0.0, 0.0, spec, &mut out).is_err());
        assert!(write_window(&all, 10.0, f64::NAN, spec, &mut out).is_err());
        assert!(write_window(&all, 10.0, 0.0, spec, &mut out[1..]).is_err());
        assert!(write_window(&all, 10.0, 0.0, spec, &mut out).is_ok());
    }
}
