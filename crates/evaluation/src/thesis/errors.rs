//! Errors over all frames, and the termination.

use crate::accuracy::{effector_distances, mean};
use crate::fall::fallen;
use crate::interval::interval;
use crate::rollout::Snapshot;
use crate::root::{rotation, tilt, velocity_errors};

/// Rule of termination: eq. t^p for f seconds.
pub(super) struct Persistence {
    distance: f64,
    /// Longest time above the distance (frames).
    patience: f64,
    lasted: usize,
}

impl Persistence {
    pub(super) fn new(distance: f64, seconds: f64, fps: f64) -> Self {
        Self { distance, patience: seconds * fps, lasted: 0 }
    }

    /// Counts a frame; returns whether the largest end-effector deviation has been above the distance for too long. Positions are
    /// relative to root and heading, as in training.
    pub(super) fn exceeded(&mut self, reference: &Snapshot, simulated: &Snapshot) -> bool {
        let far = effector_distances(reference, simulated).into_iter().any(|d| d > self.distance);
        self.lasted = if far { self.lasted + 1 } else { 0 };
        // Half a frame of slack: 3 s at 50 Hz are 150 frames, whatever the rounding.
        self.lasted as f64 > self.patience + 0.5
    }

    pub(super) fn forget(&mut self) {
        self.lasted = 0;
    }
}

/// Sums over the frames of one episode.
#[derive(Debug, Clone)]
pub(super) struct ErrorSums {
    legs: Vec<bool>,
    frames: usize,
    /// Absolute error of each joint (rad).
    joints: Vec<f64>,
    /// End-effector distance (m), velocity (m/s), angular velocity (rad/s), rotation and tilt (rad) of the root.
    others: [f64; 5],
    pub(super) terminations: usize,
    /// A frame of it shows a fall, by our own rule.
    pub(super) fell: bool,
}

impl ErrorSums {
    pub(super) fn new(legs: &[bool]) -> Self {
        Self {
            legs: legs.to_vec(),
            frames: 0,
            joints: vec![0.0; legs.len()],
            others: [0.0; 5],
            terminations: 0,
            fell: false,
        }
    }

    /// Adds a frame of reference and robot; `before` is the frame before.
    pub(super) fn add(&mut self, before: &(Snapshot, Snapshot), (r, s): &(Snapshot, Snapshot), fps: f64) {
        self.frames += 1;
        for (sum, (a, b)) in self.joints.iter_mut().zip(r.joints.iter().zip(&s.joints)) {
            *sum += (a - b).abs();
        }
        let (velocity, angular_velocity) = velocity_errors([&before.0, r], [&before.1, s], fps);
        let effectors = mean(effector_distances(r, s).into_iter());
        let others = [effectors, velocity, angular_velocity, rotation(r, s), tilt(r, s)];
        self.others.iter_mut().zip(others).for_each(|(sum, x)| *sum += x);
        self.fell |= fallen(r, s).is_some();
    }

    fn joint_error(&self, is: impl Fn(bool) -> bool) -> f64 {
        let chosen = self.joints.iter().zip(&self.legs).filter(|(_, leg)| is(**leg));
        (mean(chosen.map(|(sum, _)| *sum)) / self.frames as f64).to_degrees()
    }
}

/// Errors by the thesis' protocol: means over all frames of all episodes, whatever the robot did in them.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct ThesisErrors {
    /// Frames that the means are over.
    pub frames: usize,
    /// Share of episodes without a fall, by our own rule ([`fall`](crate::fall)).
    pub survival: f64,
    /// Mean absolute joint error (deg): the first number of Table 4.3.
    pub joint_error_deg: f64,
    /// 95% interval of it, by resampling episodes (deg).
    pub joint_error_interval_deg: [f64; 2],
    /// Mean end-effector error, relative to root and heading (m): the second number of Table 4.3.
    pub effector_error_m: f64,
    /// Mean error of the root's velocity (m/s): Table 5.3.
    pub root_velocity_error: f64,
    /// Mean error of the root's angular velocity (rad/s): Table 5.3.
    pub root_angular_velocity_error: f64,
    /// Mean error of the root's orientation, heading included (deg).
    pub root_rotation_error_deg: f64,
    /// Mean error of the root's up direction, so without heading (deg): Table 5.3.
    pub root_tilt_error_deg: f64,
    /// Mean absolute error of the joints that are not legs' (deg): Table 5.3.
    pub upper_joint_error_deg: f64,
    /// Mean absolute error of the legs' joints (deg): Table 5.3.
    pub lower_joint_error_deg: f64,
    /// Number of terminations.
    pub terminations: usize,
    /// Terminations per minute of simulated time.
    pub terminations_per_minute: f64,
}

impl ThesisErrors {
    /// Pools episodes over their frames.
    pub(super) fn of(episodes: &[ErrorSums], fps: f64) -> Self {
        let mut all = ErrorSums::new(episodes.first().map_or(&[][..], |e| &e.legs));
        for episode in episodes {
            all.frames += episode.frames;
            all.terminations += episode.terminations;
            all.joints.iter_mut().zip(&episode.joints).for_each(|(sum, x)| *sum += x);
            all.others.iter_mut().zip(episode.others).for_each(|(sum, x)| *sum += x);
        }
        let each: Vec<f64> = episodes.iter().map(|e| e.joint_error(|_| true)).collect();
        let [effectors, velocity, angular_velocity, rotation, tilt] = all.others.map(|sum| sum / all.frames as f64);
        Self {
            frames: all.frames,
            survival: mean(episodes.iter().map(|e| if e.fell { 0.0 } else { 1.0 })),
            joint_error_deg: all.joint_error(|_| true),
            joint_error_interval_deg: interval(&each),
            effector_error_m: effectors,
            root_velocity_error: velocity,
            root_angular_velocity_error: angular_velocity,
            root_rotation_error_deg: rotation.to_degrees(),
            root_tilt_error_deg: tilt.to_degrees(),
            upper_joint_error_deg: all.joint_error(|leg| !leg),
            lower_joint_error_deg: all.joint_error(|leg| leg),
            terminations: all.terminations,
            terminations_per_minute: 60.0 * fps * all.terminations as f64 / all.frames as f64,
        }
    }
}

#[cfg(test)]
mod tests {
    use lifelike_character::{Quat, Vec3};

    use super::*;
    use crate::rollout::example::snapshot;

    #[test]
    fn a_deviation_ends_the_episode_when_it_lasts_for_longer_than_f() {
        let reference = snapshot(Vec3::z(), 0.0, 0.0);
        let off = |by: f64| {
            let mut s = snapshot(Vec3::new(5.0, 0.0, 1.0), 0.0, 0.0);
            s.effectors[0].y += by;
            s
        };
        // Three frames at 10 Hz: the fourth is too many.
        let mut rule = Persistence::new(0.3, 0.3, 10.0);
        let mut told = |by: f64| rule.exceeded(&reference, &off(by));
        assert_eq!([0.31, 0.4, 0.5].map(&mut told), [false; 3]);
        assert!(!told(0.29), "the time begins anew");
        assert_eq!([0.31, 0.31, 0.31, 0.31].map(&mut told), [false, false, false, true]);
        rule.forget();
        assert!(!rule.exceeded(&reference, &off(1.0)));
    }

    #[test]
    fn all_frames_count_alike_and_heading_is_told_apart_from_tilt() {
        // Two joints, one of a leg. Two frames at 10 Hz in the first episode, one in the second.
        let with = |x: f64, joints: [f64; 2], turn: Quat| {
            let mut s = snapshot(Vec3::new(x, 0.0, 1.0), 0.0, 0.0);
            (s.joints, s.root_orientation) = (joints.to_vec(), turn);
            s
        };
        let (level, yaw) = (Quat::identity(), |a| Quat::from_euler_angles(0.0, 0.0, a));
        let reference = |x: f64| with(x, [0.0, 0.0], level);
        let mut first = ErrorSums::new(&[true, false]);
        let start = (reference(0.0), reference(0.0));
        // The robot goes half as fast (0.1 for 0.2 m in 0.1 s), with 0.3 and 0.1 rad of joint error, then tilts by 0.2 rad.
        let second = (reference(0.2), with(0.1, [0.3, 0.1], level));
        first.add(&start, &second, 10.0);
        let third = (reference(0.4), with(0.2, [0.3, 0.1], Quat::from_euler_angles(0.2, 0.0, 0.0)));
        first.add(&second, &third, 10.0);
        first.terminations = 2;
        // The other turns by 0.5 rad, stands still and has joint errors of 0.9 rad.
        let mut other = ErrorSums::new(&[true, false]);
        other.add(&start, &(reference(0.0), with(0.0, [0.9, 0.9], yaw(0.5))), 10.0);
        let mut fallen = other.clone();
        let lies = with(0.0, [0.9, 0.9], Quat::from_euler_angles(1.1, 0.0, 0.0));
        fallen.add(&start, &(reference(0.0), lies), 10.0);
        fallen.add(&start, &start, 10.0);
        assert_eq!(ThesisErrors::of(&[first.clone(), fallen], 10.0).survival, 0.5, "it stood up again, but fell");
        let errors = ThesisErrors::of(&[first, other], 10.0);
        let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-9, "{a} and not {b}");
        near(errors.joint_error_deg, ((0.2 + 0.2 + 0.9) / 3.0_f64).to_degrees());
        near(errors.lower_joint_error_deg, 0.5_f64.to_degrees());
        near(errors.upper_joint_error_deg, (1.1 / 3.0_f64).to_degrees());
        near(errors.root_velocity_error, (1.0 + 1.0) / 3.0);
        near(errors.root_angular_velocity_error, (0.0 + 2.0 + 5.0) / 3.0);
        near(errors.root_rotation_error_deg, ((0.2 + 0.5) / 3.0_f64).to_degrees());
        near(errors.root_tilt_error_deg, (0.2 / 3.0_f64).to_degrees());
        // Two in 0.3 s.
        near(errors.terminations_per_minute, 400.0);
        assert_eq!((errors.frames, errors.terminations, errors.survival), (3, 2, 1.0));
        let [low, high] = errors.joint_error_interval_deg;
        near(low, 0.2_f64.to_degrees());
        near(high, 0.9_f64.to_degrees());
    }
}
