//! Which episodes an evaluation has.

use lifelike_character::rotation::heading;
use lifelike_character::{Quat, Vec3};
use lifelike_motion::MotionClip;

/// Frames in which the episodes of a clip start: `starts` of them, evenly from the first frame to the last that leaves
/// a whole episode. A clip shorter than an episode and a half leaves half of itself. Fewer where frames coincide.
///
/// A clip of `frames` frames that may repeat (`cyclic`) is started anywhere in its cycle.
pub fn start_frames(frames: usize, episode: usize, starts: usize, cyclic: bool) -> Vec<usize> {
    let last = frames.saturating_sub(1);
    let latest = if cyclic { last } else { last.saturating_sub(episode).max(last / 2) };
    // The end of a cycle is its beginning: it is left out by dividing into one part more.
    let parts = if cyclic { starts.max(1) } else { starts.saturating_sub(1).max(1) };
    let mut all: Vec<usize> = (0..starts.max(1)).map(|k| k * latest / parts).collect();
    all.dedup();
    all
}

/// A cyclic clip repeated until it lasts at least `seconds`; any other clip as it is: its episodes end with it.
///
/// Each repetition begins where the last one ended: the first frame's place on the ground and heading are laid over the
/// last frame's (which shows the same posture and is not repeated).
pub fn repeated(clip: &MotionClip, seconds: f64) -> MotionClip {
    let (n, columns) = (clip.len(), clip.joint_names.len());
    let mut out = clip.clone();
    if !clip.cyclic || n < 2 {
        return out;
    }
    let ground = |p: Vec3| Vec3::new(p.x, p.y, 0.0);
    let step: Quat = heading(&clip.root_orientation[n - 1]) * heading(&clip.root_orientation[0]).inverse();
    let from = ground(clip.root_position[0]);
    let to = ground(clip.root_position[n - 1]);
    let (mut turn, mut shift) = (Quat::identity(), Vec3::zeros());
    while out.seconds() < seconds {
        // This repetition maps p to turn p + shift; the next one takes the first frame to where the last one is now.
        let end = turn * to + shift;
        turn = step * turn;
        shift = end - turn * from;
        for frame in 1..n {
            out.root_position.push(turn * clip.root_position[frame] + shift);
            out.root_orientation.push(turn * clip.root_orientation[frame]);
            out.joints.extend_from_slice(clip.joints_at(frame));
        }
        if let (Some(all), Some(one)) = (&mut out.contacts, &clip.contacts) {
            all.flags.extend_from_slice(&one.flags[one.names.len().min(one.flags.len())..]);
        }
    }
    debug_assert_eq!(out.joints.len(), out.len() * columns);
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn starts_by_hand() {
        assert_eq!(start_frames(1001, 500, 3, false), [0, 250, 500]);
        assert_eq!(start_frames(101, 500, 3, false), [0, 25, 50], "a short clip: its first half");
        assert_eq!(start_frames(51, 500, 2, true), [0, 25], "a cycle: all of it, its end being its beginning");
        assert_eq!(start_frames(3, 500, 4, false), [0, 1]);
        assert_eq!(start_frames(1001, 500, 1, false), [0]);
    }

    /// A quarter of a circle of radius 1 about the origin, walked to the left.
    fn quarter() -> MotionClip {
        let angle = |i: usize| std::f64::consts::FRAC_PI_2 * i as f64 / 4.0;
        MotionClip {
            name: "turn".into(),
            fps: 4.0,
            joint_names: vec!["knee".into()],
            root_position: (0..5).map(|i| Vec3::new(angle(i).sin(), -angle(i).cos(), 0.9)).collect(),
            root_orientation: (0..5).map(|i| Quat::from_axis_angle(&Vec3::z_axis(), angle(i))).collect(),
            joints: vec![0.0, 0.1, 0.2, 0.1, 0.0],
            contacts: None,
            cyclic: true,
            provenance: lifelike_motion::Provenance::default(),
        }
    }

    #[test]
    fn four_quarters_make_a_circle() {
        let circle = repeated(&quarter(), 4.0);
        assert_eq!((circle.len(), circle.seconds()), (17, 4.0));
        for (i, p) in circle.root_position.iter().enumerate() {
            let angle = std::f64::consts::TAU * i as f64 / 16.0;
            let expected = Vec3::new(angle.sin(), -angle.cos(), 0.9);
            assert!((p - expected).norm() < 1e-9, "frame {i}: {p} and not {expected}");
            let turned = Quat::from_axis_angle(&Vec3::z_axis(), angle);
            assert!(circle.root_orientation[i].angle_to(&turned) < 1e-7);
        }
        assert_eq!(circle.joints[4..9], [0.0, 0.1, 0.2, 0.1, 0.0]);
    }

    #[test]
    fn what_is_long_enough_or_no_cycle_stays() {
        assert_eq!(repeated(&quarter(), 1.0), quarter());
        let once = MotionClip { cyclic: false, ..quarter() };
        assert_eq!(repeated(&once, 9.0), once);
    }
}
