//! Definition of a fall.
//!
//! Poor tracking is not a fall. The limits are far beyond the deviations at which training terminates (a height off by
//! 12 cm, a tilt off by 0.7 rad). A policy that lags, crouches or drifts has therefore not fallen. Both limits are
//! relative to the reference, which may lie down; heights are above the respective ground. A root within
//! [`HEIGHT_MARGIN`] of the reference has not fallen: 60% of a lying reference's height is less than the error of
//! retargeting.

use super::rollout::{Cause, Snapshot};
use super::root::tilt;

/// A root below this share of the reference's height has fallen.
pub const HEIGHT_SHARE: f64 = 0.6;
/// A root that is lower than the reference by no more than this has not fallen (m). It matters where the reference's root is below
/// 12.5 cm: lying.
pub const HEIGHT_MARGIN: f64 = 0.05;
/// A root whose up direction is off by more than this has fallen (rad; 57.3 deg).
pub const TILT: f64 = 1.0;

/// Returns the cause where a frame shows a fall.
pub fn fallen(reference: &Snapshot, simulated: &Snapshot) -> Option<Cause> {
    let tilt = tilt(reference, simulated);
    let height = |s: &Snapshot| s.root_position.z - s.ground;
    let (asked, done) = (height(reference), height(simulated));
    if !simulated.root_position.iter().all(|c| c.is_finite()) || !tilt.is_finite() {
        Some(Cause::Diverged)
    } else if tilt > TILT {
        Some(Cause::Tilt)
    } else if done < HEIGHT_SHARE * asked && done < asked - HEIGHT_MARGIN {
        Some(Cause::Height)
    } else {
        None
    }
}

#[cfg(test)]
mod tests {
    use lifelike_character::{Quat, Vec3};

    use super::super::rollout::example::snapshot;
    use super::*;

    #[test]
    fn low_or_tilted_against_the_reference() {
        let reference = snapshot(Vec3::z(), 0.0, 0.0);
        let at = |z: f64, roll: f64, yaw: f64| {
            let mut s = snapshot(z * Vec3::z(), 0.0, 0.0);
            s.root_orientation = Quat::from_euler_angles(roll, 0.0, yaw);
            s
        };
        assert_eq!(fallen(&reference, &at(0.61, 0.0, 3.0)), None, "turning round is no fall");
        assert_eq!(fallen(&reference, &at(0.59, 0.0, 0.0)), Some(Cause::Height));
        assert_eq!(fallen(&reference, &at(1.0, 0.99, 0.0)), None);
        assert_eq!(fallen(&reference, &at(1.0, -1.01, 2.0)), Some(Cause::Tilt));
        assert_eq!(fallen(&at(0.2, 1.5, 0.0), &at(0.15, 1.4, 1.0)), None, "a clip may lie down");
        assert_eq!(fallen(&at(0.1, 1.5, 0.0), &at(0.055, 1.5, 0.0)), None, "4.5 cm on the ground are no fall");
        assert_eq!(fallen(&at(0.1, 1.5, 0.0), &at(0.045, 1.5, 0.0)), Some(Cause::Height));
        assert_eq!(fallen(&reference, &at(f64::NAN, 0.0, 0.0)), Some(Cause::Diverged));
        let hilltop = Snapshot { ground: 0.5, ..at(1.05, 0.0, 0.0) };
        assert_eq!(fallen(&reference, &hilltop), Some(Cause::Height), "0.55 m above its own ground");
    }
}
