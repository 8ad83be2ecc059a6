//! Place and cause of an episode's failure.

use super::accuracy::posture_errors;
use super::rollout::{Cause, Outcome, Rollout};

/// A body this far from the reference's posture has left it (m).
pub const LEFT: f64 = 0.15;
/// A joint that uses more than this share of its largest torque is at its limit.
pub const SATURATED: f64 = 0.95;
/// A joint is named when it was at its limit for at least this share of the look back.
pub const NAMED: f64 = 0.3;
/// Time before the fall in which torques and ground contact are looked at (s).
pub const LOOK_BACK: f64 = 0.5;
/// Shorter stretches without ground are part of walking quickly (s).
pub const WORTH_TELLING: f64 = 0.1;
/// A foot that carries less than this share of the weight is unloaded.
pub const BEARING: f32 = 0.02;

/// The first body to leave the reference's posture.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct FirstBody {
    /// Its name.
    pub body: String,
    /// When, in the episode (s).
    pub second: f64,
    /// Its distance from the reference then (m).
    pub metres: f64,
}

/// A joint at its torque limit.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Saturated {
    /// Its name.
    pub joint: String,
    /// Share of the last [`LOOK_BACK`] seconds.
    pub share: f64,
}

/// A fall, explained.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Failure {
    /// The clip.
    pub clip: String,
    /// When in the episode (s).
    pub second: f64,
    /// When in the clip (s).
    pub clip_second: f64,
    /// Sign by which the fall is known.
    pub cause: Cause,
    /// The first body that left the posture for good, if one left before the fall.
    pub first_body: Option<FirstBody>,
    /// Joints at their torque limit before the fall, the worst first, three at most.
    pub saturated: Vec<Saturated>,
    /// For how long before the fall no foot bore anything (s); 0 where there is no foot to say.
    pub without_ground: f64,
}

impl Failure {
    /// Explains the fall of a rollout, if it fell.
    pub fn of(rollout: &Rollout) -> Option<Self> {
        let Outcome::Fell { frame, cause } = rollout.outcome else { return None };
        let second = frame as f64 / rollout.fps;
        Some(Self {
            clip: rollout.clip.clone(),
            second,
            clip_second: rollout.start + second,
            cause,
            first_body: first_body(rollout, frame),
            saturated: saturated(rollout, frame),
            without_ground: without_ground(rollout, frame),
        })
    }

    /// Returns the events before the fall, in words.
    pub fn why(&self) -> String {
        let mut parts = Vec::new();
        if let Some(first) = &self.first_body {
            parts.push(format!("{} left first at {:.2} s ({:.2} m)", first.body, first.second, first.metres));
        }
        if !self.saturated.is_empty() {
            let joints: Vec<String> =
                self.saturated.iter().map(|s| format!("{} {:.0}%", s.joint, 100.0 * s.share)).collect();
            parts.push(format!("at torque limit: {}", joints.join(", ")));
        }
        if self.without_ground >= WORTH_TELLING {
            parts.push(format!("no foot on the ground for {:.2} s", self.without_ground));
        }
        parts.join("; ")
    }
}

/// Goes back from the fall to the last frame in which every body was in place; what left right after it left first.
fn first_body(rollout: &Rollout, fall: usize) -> Option<FirstBody> {
    let end = fall.min(rollout.reference.len()).min(rollout.simulated.len());
    let errors = |f: usize| posture_errors(&rollout.reference[f], &rollout.simulated[f]);
    let in_place = |f: &usize| errors(*f).iter().all(|e| *e <= LEFT);
    let frame = (0..end).rev().find(in_place).map_or(0, |f| f + 1);
    if frame >= end {
        return None;
    }
    let (body, metres) = errors(frame).into_iter().enumerate().max_by(|a, b| a.1.total_cmp(&b.1))?;
    let name = rollout.names.bodies.get(body + 1)?;
    Some(FirstBody { body: name.clone(), second: frame as f64 / rollout.fps, metres })
}

/// The frames of the look back, the frame of the fall excluded.
fn look_back(rollout: &Rollout, fall: usize, columns: usize, recorded: usize) -> std::ops::Range<usize> {
    let end = fall.min(recorded.checked_div(columns).unwrap_or(0));
    end.saturating_sub((LOOK_BACK * rollout.fps).round() as usize).max(1).min(end)..end
}

fn saturated(rollout: &Rollout, fall: usize) -> Vec<Saturated> {
    let joints = rollout.names.joints.len();
    let window = look_back(rollout, fall, joints, rollout.torque_share.len());
    let mut all: Vec<Saturated> = rollout
        .names
        .joints
        .iter()
        .enumerate()
        .map(|(j, name)| {
            let at_limit =
                window.clone().filter(|f| f64::from(rollout.torque_share[f * joints + j].abs()) >= SATURATED).count();
            Saturated { joint: name.clone(), share: at_limit as f64 / window.len().max(1) as f64 }
        })
        .filter(|s| s.share >= NAMED)
        .collect();
    all.sort_by(|a, b| b.share.total_cmp(&a.share));
    all.truncate(3);
    all
}

fn without_ground(rollout: &Rollout, fall: usize) -> f64 {
    let feet = rollout.names.feet.len();
    let window = look_back(rollout, fall, feet, rollout.foot_force.len());
    let airborne = |f: &usize| rollout.foot_force[f * feet..(f + 1) * feet].iter().all(|force| *force < BEARING);
    window.rev().take_while(airborne).count() as f64 / rollout.fps
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use lifelike_character::Vec3;

    use super::super::rollout::example::{rollout, snapshot};
    use super::*;

    /// Physics sinks at 0.5 m/s from t = 1 s on; its hand drops faster by a factor of two.
    fn sinking() -> Rollout {
        let mut r = rollout(
            20,
            |_| snapshot(Vec3::z(), 0.0, 0.0),
            |t| {
                let depth = 0.5 * (t - 1.0).max(0.0);
                let mut s = snapshot((1.0 - depth) * Vec3::z(), 0.0, 0.0);
                s.bodies[2].0.z -= depth;
                s
            },
        );
        r.outcome = Outcome::Fell { frame: 18, cause: Cause::Height };
        r
    }

    #[test]
    fn the_first_body_to_leave_by_hand() {
        let failure = Failure::of(&sinking()).unwrap();
        assert_eq!((failure.second, failure.clip_second), (1.8, 3.8));
        // The hand is off by 2 * 0.5 * (t - 1): 0.1 m at 1.1 s, 0.2 m at 1.2 s; the pelvis gets to 0.15 m at 1.3 s.
        let first = failure.first_body.unwrap();
        assert_eq!(first.body, "hand");
        assert!((first.second - 1.2).abs() < 1e-12 && (first.metres - 0.2).abs() < 1e-12, "{first:?}");
    }

    #[test]
    fn a_body_that_left_and_came_back_is_not_blamed() {
        let mut r = sinking();
        r.simulated[5].bodies[1].0.z += 0.5;
        assert_eq!(Failure::of(&r).unwrap().first_body.unwrap().body, "hand");
    }

    #[test]
    fn joints_at_their_limit_and_feet_in_the_air() {
        let mut r = sinking();
        // The look back is frames 13..18.
        for f in [13, 14, 17] {
            r.torque_share[f] = 0.96;
        }
        for f in [14, 16, 17] {
            r.foot_force[f] = 0.0;
        }
        let failure = Failure::of(&r).unwrap();
        assert_eq!(failure.saturated, [Saturated { joint: "knee".into(), share: 0.6 }]);
        assert_eq!(failure.without_ground, 0.2, "frames 16 and 17; at 15 it stood");
        assert_eq!(
            failure.why(),
            "hand left first at 1.20 s (0.20 m); at torque limit: knee 60%; no foot on the ground for 0.20 s"
        );
    }

    #[test]
    fn a_fall_in_the_first_frame_is_explained_as_far_as_it_goes() {
        let mut r = sinking();
        r.outcome = Outcome::Fell { frame: 0, cause: Cause::Diverged };
        let failure = Failure::of(&r).unwrap();
        assert_eq!((failure.first_body, failure.saturated.len(), failure.without_ground), (None, 0, 0.0));
        r.outcome = Outcome::Survived;
        assert!(Failure::of(&r).is_none());
    }
}
