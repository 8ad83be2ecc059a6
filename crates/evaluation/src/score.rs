//! Scores of episodes, and of a clip's together.

use super::accuracy::{
    PHC_LIMIT, body_errors, contact_agreement, effector_error, joint_error, joint_errors, mean,
    root_relative_body_errors,
};
use super::drift::drift;
use super::failure::Failure;
use super::field::{human_tracker, mpkpe, root_relative_mpkpe};
use super::heat::{joint_heat, mean_and_worst};
use super::rollout::Rollout;
use super::root::root_errors;
use super::slip::sole_slip;
use super::smoothness::jerk;
use super::steps::steps;
use super::verdict::Verdict;

/// The score of one episode. Errors are means over the frames before a fall; NaN (`null` in JSON) where it fell at once.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct EpisodeScore {
    /// The clip.
    pub clip: String,
    /// Start within the clip (s).
    pub start: f64,
    /// Seconds that it would have lasted without a fall.
    pub planned_seconds: f64,
    /// Frames that count.
    pub frames: usize,
    /// Frames that would have counted without a fall.
    pub planned_frames: usize,
    /// No fall.
    pub survived: bool,
    /// No fall, and the mean body error (m, world) never above 0.5 m: success in the sense of PHC.
    pub success: bool,
    /// Mean absolute joint error (deg).
    pub joint_error_deg: f64,
    /// Mean absolute error of each joint (deg), in the order of [`Evaluation::joints`](crate::Evaluation::joints).
    pub joint_errors_deg: Vec<f64>,
    /// Mean absolute error of the joints that are not legs' (deg); NaN without any.
    pub upper_joint_error_deg: f64,
    /// Mean absolute error of the legs' joints (deg); NaN without any.
    pub lower_joint_error_deg: f64,
    /// Mean error of the root's velocity (m/s).
    pub root_velocity_error: f64,
    /// Mean error of the root's angular velocity (rad/s).
    pub root_angular_velocity_error: f64,
    /// Mean error of the root's orientation (deg), heading included.
    pub root_rotation_error_deg: f64,
    /// Mean error of the root's up direction (deg): without heading.
    pub root_tilt_error_deg: f64,
    /// Share of frames and feet whose ground contact is the reference's.
    pub contact_agreement: f64,
    /// Whole steps of the reference before a fall.
    pub steps_planned: usize,
    /// Those that the robot took: its foot left the ground.
    pub steps_taken: usize,
    /// Mean end-effector error (m).
    pub effector_error_m: f64,
    /// Mean body error (m, world), drift included: MPJPE_g.
    pub body_error_m: f64,
    /// Mean body error with both roots in one place (m): MPJPE_l.
    pub root_relative_body_error_m: f64,
    /// Mean distance from the reference on the ground (m).
    pub position_drift_mean_m: f64,
    /// The same at the end (m).
    pub position_drift_end_m: f64,
    /// Mean heading error (deg).
    pub heading_drift_mean_deg: f64,
    /// The same at the end (deg).
    pub heading_drift_end_deg: f64,
    /// Mean joint jerk (rad/s³).
    pub jerk: f64,
    /// Mean joint jerk of the reference over the same frames (rad/s³).
    pub reference_jerk: f64,
    /// Mean speed of standing soles over the ground (m/s); NaN where none stands.
    pub sole_slip: f64,
    /// Mean over joints of squared torque over continuous torque squared; 1 is the continuous rating.
    pub heat: f64,
    /// The same of the hottest joint.
    pub worst_heat: f64,
    /// The same of each joint, in the order of [`Evaluation::joints`](crate::Evaluation::joints).
    pub joint_heat: Vec<f64>,
    /// No failure by HumanTracker's rule.
    pub human_tracker_success: bool,
    /// Frames before that failure.
    pub human_tracker_frames: usize,
    /// Mean absolute joint error over them (rad).
    pub human_tracker_mpjpe_rad: f64,
    /// mjlab's `mpkpe` (m): mean distance of its key bodies in the world.
    pub mpkpe_m: f64,
    /// mjlab's `r_mpkpe` (m): the same, the reference moved to the robot's anchor.
    pub r_mpkpe_m: f64,
    /// Why it fell.
    pub failure: Option<Failure>,
}

impl EpisodeScore {
    /// The score of a rollout.
    pub fn of(rollout: &Rollout) -> Self {
        let errors = body_errors(rollout);
        let survived = rollout.survived();
        let (drift, root, joints) = (drift(rollout), root_errors(rollout), joint_errors(rollout));
        let of = |legs: bool| {
            let is = |(error, leg): (&f64, &bool)| (*leg == legs).then_some(*error);
            mean(joints.iter().zip(&rollout.names.legs).filter_map(is))
        };
        let (steps, tracker, heat) = (steps(rollout), human_tracker(rollout), joint_heat(rollout));
        let (mean_heat, worst_heat) = mean_and_worst(&heat);
        let end = rollout.counted().end.min(rollout.simulated.len()).min(rollout.reference.len());
        Self {
            clip: rollout.clip.clone(),
            start: rollout.start,
            planned_seconds: rollout.planned.saturating_sub(1) as f64 / rollout.fps,
            frames: errors.len(),
            planned_frames: rollout.planned.saturating_sub(1),
            survived,
            success: survived && errors.iter().all(|e| *e <= PHC_LIMIT),
            joint_error_deg: joint_error(rollout),
            upper_joint_error_deg: of(false),
            lower_joint_error_deg: of(true),
            root_velocity_error: root.velocity,
            root_angular_velocity_error: root.angular_velocity,
            root_rotation_error_deg: root.rotation,
            root_tilt_error_deg: root.tilt,
            joint_errors_deg: joints,
            contact_agreement: contact_agreement(rollout),
            steps_planned: steps.planned,
            steps_taken: steps.taken,
            effector_error_m: effector_error(rollout),
            body_error_m: mean(errors.iter().copied()),
            root_relative_body_error_m: mean(root_relative_body_errors(rollout).into_iter()),
            position_drift_mean_m: drift.position_mean,
            position_drift_end_m: drift.position_end,
            heading_drift_mean_deg: drift.heading_mean,
            heading_drift_end_deg: drift.heading_end,
            jerk: jerk(&rollout.simulated[..end], rollout.fps),
            reference_jerk: jerk(&rollout.reference[..end], rollout.fps),
            sole_slip: sole_slip(rollout),
            heat: mean_heat,
            worst_heat,
            joint_heat: heat,
            human_tracker_success: tracker.success,
            human_tracker_frames: tracker.frames,
            human_tracker_mpjpe_rad: tracker.joint_error_rad,
            mpkpe_m: mpkpe(rollout),
            r_mpkpe_m: root_relative_mpkpe(rollout),
            failure: Failure::of(rollout),
        }
    }
}

/// The score of a clip, or of all of them. Errors are pooled over frames ("over all frames, joints, and evaluation
/// episodes", thesis 4.3.3), drift at the end and rates over episodes.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct ClipScore {
    /// The clip; `all` for the sum.
    pub clip: String,
    /// Verdict on all of its episodes.
    pub verdict: Verdict,
    /// Number of episodes.
    pub episodes: usize,
    /// Mean length that the episodes would have had (s).
    pub seconds: f64,
    /// Share of episodes without a fall.
    pub survival: f64,
    /// Share of episodes that succeed in the sense of PHC.
    pub success: f64,
    /// Share of frames before a fall: what the errors are means over.
    pub covered: f64,
    /// Mean absolute joint error (deg).
    pub joint_error_deg: f64,
    /// The joint with the largest mean error, an index into [`Evaluation::joints`](crate::Evaluation::joints); none where no frame counts.
    pub worst_joint: Option<usize>,
    /// Its error (deg).
    pub worst_joint_error_deg: f64,
    /// Mean absolute error of the joints that are not legs' (deg).
    pub upper_joint_error_deg: f64,
    /// Mean absolute error of the legs' joints (deg).
    pub lower_joint_error_deg: f64,
    /// Mean error of the root's velocity (m/s).
    pub root_velocity_error: f64,
    /// Mean error of the root's angular velocity (rad/s).
    pub root_angular_velocity_error: f64,
    /// Mean error of the root's orientation (deg), heading included.
    pub root_rotation_error_deg: f64,
    /// Mean error of the root's up direction (deg): without heading.
    pub root_tilt_error_deg: f64,
    /// Share of frames and feet whose ground contact is the reference's.
    pub contact_agreement: f64,
    /// Share of the reference's whole steps that were taken; NaN where it takes none.
    pub steps_taken: f64,
    /// Mean end-effector error (m).
    pub effector_error_m: f64,
    /// Mean body error (m, world), drift included: MPJPE_g.
    pub body_error_m: f64,
    /// Mean body error with both roots in one place (m): MPJPE_l.
    pub root_relative_body_error_m: f64,
    /// Mean distance from the reference on the ground (m).
    pub position_drift_mean_m: f64,
    /// The same at the end of the episodes (m).
    pub position_drift_end_m: f64,
    /// Mean heading error (deg).
    pub heading_drift_mean_deg: f64,
    /// The same at the end of the episodes (deg).
    pub heading_drift_end_deg: f64,
    /// Mean joint jerk (rad/s³).
    pub jerk: f64,
    /// Mean joint jerk of the reference (rad/s³).
    pub reference_jerk: f64,
    /// Mean speed of standing soles over the ground (m/s).
    pub sole_slip: f64,
    /// Mean over joints of squared torque over continuous torque squared; 1 is the continuous rating.
    pub heat: f64,
    /// The same of the hottest joint.
    pub worst_heat: f64,
    /// The hottest joint, an index into [`Evaluation::joints`](crate::Evaluation::joints).
    pub worst_heat_joint: Option<usize>,
    /// Share of episodes without a failure by HumanTracker's rule.
    pub human_tracker_success: f64,
    /// Mean absolute joint error over the frames before that failure (rad).
    pub human_tracker_mpjpe_rad: f64,
    /// mjlab's `mpkpe` (m), a mean over episodes of means over frames.
    pub mpkpe_m: f64,
    /// mjlab's `r_mpkpe` (m), likewise.
    pub r_mpkpe_m: f64,
}

impl ClipScore {
    /// The score of some episodes under one name.
    pub fn of(name: &str, episodes: &[&EpisodeScore]) -> Self {
        // An episode without frames has NaN errors and no weight.
        let pooled = |value: fn(&EpisodeScore) -> f64| pooled(episodes, &value);
        let worst = largest(episodes, |e| &e.joint_errors_deg);
        let hottest = largest(episodes, |e| &e.joint_heat);
        let ended = |value: fn(&EpisodeScore) -> f64| mean(episodes.iter().map(|e| value(e)).filter(|v| v.is_finite()));
        let share = |is: fn(&EpisodeScore) -> bool| mean(episodes.iter().map(|e| if is(e) { 1.0 } else { 0.0 }));
        let planned: usize = episodes.iter().map(|e| e.planned_frames).sum();
        let frames: usize = episodes.iter().map(|e| e.frames).sum();
        let steps: usize = episodes.iter().map(|e| e.steps_planned).sum();
        let taken: usize = episodes.iter().map(|e| e.steps_taken).sum();
        Self {
            clip: name.into(),
            verdict: Verdict::of(episodes),
            episodes: episodes.len(),
            seconds: mean(episodes.iter().map(|e| e.planned_seconds)),
            survival: share(|e| e.survived),
            success: share(|e| e.success),
            covered: if planned == 0 { f64::NAN } else { frames as f64 / planned as f64 },
            joint_error_deg: pooled(|e| e.joint_error_deg),
            worst_joint: worst.map(|(joint, _)| joint),
            worst_joint_error_deg: worst.map_or(f64::NAN, |(_, error)| error),
            upper_joint_error_deg: pooled(|e| e.upper_joint_error_deg),
            lower_joint_error_deg: pooled(|e| e.lower_joint_error_deg),
            root_velocity_error: pooled(|e| e.root_velocity_error),
            root_angular_velocity_error: pooled(|e| e.root_angular_velocity_error),
            root_rotation_error_deg: pooled(|e| e.root_rotation_error_deg),
            root_tilt_error_deg: pooled(|e| e.root_tilt_error_deg),
            contact_agreement: pooled(|e| e.contact_agreement),
            steps_taken: if steps == 0 { f64::NAN } else { taken as f64 / steps as f64 },
            effector_error_m: pooled(|e| e.effector_error_m),
            body_error_m: pooled(|e| e.body_error_m),
            root_relative_body_error_m: pooled(|e| e.root_relative_body_error_m),
            position_drift_mean_m: pooled(|e| e.position_drift_mean_m),
            position_drift_end_m: ended(|e| e.position_drift_end_m),
            heading_drift_mean_deg: pooled(|e| e.heading_drift_mean_deg),
            heading_drift_end_deg: ended(|e| e.heading_drift_end_deg),
            jerk: pooled(|e| e.jerk),
            reference_jerk: pooled(|e| e.reference_jerk),
            sole_slip: pooled(|e| e.sole_slip),
            heat: pooled(|e| e.heat),
            worst_heat: hottest.map_or(f64::NAN, |(_, heat)| heat),
            worst_heat_joint: hottest.map(|(joint, _)| joint),
            human_tracker_success: share(|e| e.human_tracker_success),
            human_tracker_mpjpe_rad: weighted(episodes, &|e| (e.human_tracker_mpjpe_rad, e.human_tracker_frames)),
            mpkpe_m: ended(|e| e.mpkpe_m),
            r_mpkpe_m: ended(|e| e.r_mpkpe_m),
        }
    }
}

/// Returns the joint with the largest mean over frames, and that mean.
fn largest(episodes: &[&EpisodeScore], value: impl Fn(&EpisodeScore) -> &[f64]) -> Option<(usize, f64)> {
    let joints = episodes.first().map_or(0, |e| value(e).len());
    let means = (0..joints).map(|joint| (joint, pooled(episodes, &|e| value(e)[joint])));
    means.filter(|(_, mean)| mean.is_finite()).max_by(|a, b| a.1.total_cmp(&b.1))
}

/// Mean over the frames that count; NaN where there are none.
fn pooled(episodes: &[&EpisodeScore], value: &dyn Fn(&EpisodeScore) -> f64) -> f64 {
    weighted(episodes, &|e| (value(e), e.frames))
}

/// Mean of each episode's value, weighted by its number of frames; NaN where there are none.
fn weighted(episodes: &[&EpisodeScore], value: &dyn Fn(&EpisodeScore) -> (f64, usize)) -> f64 {
    let known = || episodes.iter().map(|e| value(e)).filter(|(v, frames)| v.is_finite() && *frames > 0);
    let frames: f64 = known().map(|(_, frames)| frames as f64).sum();
    if frames == 0.0 { f64::NAN } else { known().map(|(v, frames)| v * frames as f64).sum::<f64>() / frames }
}

#[cfg(test)]
mod tests {
    use lifelike_character::Vec3;

    use super::super::rollout::example::{rollout, snapshot};
    use super::super::rollout::{Cause, Outcome};
    use super::*;

    fn episode(frames: usize, joint: f64, aside: f64, fall: Option<usize>) -> EpisodeScore {
        let at = move |_| snapshot(Vec3::new(0.0, aside, 1.0), 0.0, joint);
        let mut r = rollout(frames, |_| snapshot(Vec3::z(), 0.0, 0.0), at);
        if let Some(frame) = fall {
            r.outcome = Outcome::Fell { frame, cause: Cause::Tilt };
        }
        EpisodeScore::of(&r)
    }

    #[test]
    fn success_needs_survival_and_bodies_within_half_a_metre() {
        let flags = |e: EpisodeScore| (e.survived, e.success);
        assert_eq!(flags(episode(5, 0.0, 0.49, None)), (true, true));
        assert_eq!(flags(episode(5, 0.0, 0.51, None)), (true, false));
        assert_eq!(flags(episode(5, 0.0, 0.0, Some(3))), (false, false));
    }

    #[test]
    fn errors_are_pooled_over_frames_and_rates_over_episodes() {
        // 4 frames at 1 rad; 1 frame (a fall in frame 2 of a planned 8) at 2 rad; a fall at once.
        let episodes = [episode(5, 1.0, 0.0, None), episode(9, 2.0, 0.3, Some(2)), episode(5, 3.0, 0.0, Some(1))];
        let score = ClipScore::of("walk", &episodes.iter().collect::<Vec<_>>());
        assert!((score.joint_error_deg.to_radians() - (4.0 + 2.0) / 5.0).abs() < 1e-12);
        assert!((score.survival - 1.0 / 3.0).abs() < 1e-12);
        assert!((score.covered - 5.0 / 16.0).abs() < 1e-12);
        assert!((score.position_drift_end_m - 0.15).abs() < 1e-12, "0 and 0.3 m; the third has no end to speak of");
        assert_eq!(score.episodes, 3);
    }
}
