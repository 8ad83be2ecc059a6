//! Errors of several policies over the same frames.
//!
//! A mean over the frames before a fall flatters who falls early: what is hard comes late. Over the frames that ALL policies survive, of
//! the same episodes, means can be compared.

use crate::error::EvaluationError;
use crate::score::EpisodeScore;

/// Errors of one policy over the frames that all policies survive.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct CommonErrors {
    /// Share of all planned frames that all survive.
    pub covered: f64,
    /// Mean absolute joint error (deg); NaN where no frame is left.
    pub joint_error_deg: f64,
    /// Mean end-effector error (m).
    pub effector_error_m: f64,
}

/// Returns each policy's errors, in their order, over the frames that all of them survive.
///
/// # Errors
/// [`EvaluationError::Mismatch`] where they were not evaluated on the same episodes.
pub fn on_common_frames(policies: &[&[EpisodeScore]]) -> Result<Vec<CommonErrors>, EvaluationError> {
    let Some(first) = policies.first() else { return Ok(Vec::new()) };
    for other in policies {
        let asked = |e: &EpisodeScore| (e.clip.clone(), e.start.to_bits(), e.planned_frames);
        if !first.iter().map(asked).eq(other.iter().map(asked)) {
            return Err(EvaluationError::Mismatch {
                what: "evaluations to compare".into(),
                expected: "the same episodes".into(),
                got: "others".into(),
            });
        }
    }
    let survived = |episode: usize| policies.iter().map(|p| p[episode].frame_errors.len()).min().unwrap_or(0);
    let frames: Vec<usize> = (0..first.len()).map(survived).collect();
    let (all, planned) = (frames.iter().sum::<usize>() as f64, first.iter().map(|e| e.planned_frames).sum::<usize>());
    let errors = |policy: &&[EpisodeScore]| {
        let kept = policy.iter().zip(&frames).flat_map(|(episode, n)| &episode.frame_errors[..*n]);
        let sums = kept
            .fold([0.0; 2], |sums, [joint, effector]| [sums[0] + f64::from(*joint), sums[1] + f64::from(*effector)]);
        let [joint_error_deg, effector_error_m] = sums.map(|sum| if all > 0.0 { sum / all } else { f64::NAN });
        CommonErrors { covered: all / planned.max(1) as f64, joint_error_deg, effector_error_m }
    };
    Ok(policies.iter().map(errors).collect())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use lifelike_character::Vec3;

    use super::*;
    use crate::rollout::example::{rollout, snapshot};
    use crate::rollout::{Cause, Outcome};

    /// Frames after the start are off by `joint` (rad), twice as much from the fourth on.
    fn episode(joint: f64, fall: Option<usize>) -> EpisodeScore {
        let grows = move |t: f64| snapshot(Vec3::z(), 0.0, if t > 0.35 { 2.0 * joint } else { joint });
        let mut r = rollout(9, |_| snapshot(Vec3::z(), 0.0, 0.0), grows);
        if let Some(frame) = fall {
            r.outcome = Outcome::Fell { frame, cause: Cause::Tilt };
        }
        EpisodeScore::of(&r)
    }

    #[test]
    fn who_falls_early_is_compared_over_what_came_before() {
        let (stays, falls) = ([episode(1.0, None)], [episode(1.0, Some(4))]);
        assert!(falls[0].joint_error_deg < stays[0].joint_error_deg, "so far it looks better");
        let common = on_common_frames(&[&stays, &falls]).unwrap();
        assert_eq!(common[0], common[1]);
        assert!((common[0].joint_error_deg - 1.0_f64.to_degrees()).abs() < 1e-4, "{common:?}");
        assert!((common[0].covered - 3.0 / 8.0).abs() < 1e-12);
    }

    #[test]
    fn episodes_that_differ_are_refused_and_frames_may_run_out() {
        let (one, two) = ([episode(1.0, None)], [episode(1.0, None), episode(1.0, None)]);
        assert!(on_common_frames(&[&one, &two]).unwrap_err().to_string().contains("the same episodes"));
        let at_once = [episode(1.0, Some(1))];
        assert!(on_common_frames(&[&one, &at_once]).unwrap()[0].joint_error_deg.is_nan());
    }
}
