//! Two clips of one robot, column for column.

use super::story::unfit;
use crate::clip::MotionClip;
use crate::error::MotionError;
use crate::resample::resample;

/// Returns `other` at the rate of `base`, with its joints in the order of `base`.
///
/// # Errors
/// [`MotionError::Unfit`] when one of them is not consistent, or names joints that the other has not: clips of
/// different robots are put together by retargeting, not by editing.
pub(super) fn like(base: &MotionClip, other: &MotionClip) -> Result<MotionClip, MotionError> {
    base.check()?;
    let mut out = resample(other, base.fps)?;
    if out.joint_names == base.joint_names {
        return Ok(out);
    }
    let lacks = |has: &[String], wanted: &[String]| -> Vec<String> {
        wanted.iter().filter(|name| !has.contains(name)).cloned().collect()
    };
    let (missing, unknown) =
        (lacks(&other.joint_names, &base.joint_names), lacks(&base.joint_names, &other.joint_names));
    if !missing.is_empty() || !unknown.is_empty() {
        let message = format!(
            "expected the joints of clip '{}', got others; missing: {missing:?}; unknown there: {unknown:?}",
            base.name
        );
        return Err(unfit(other, message));
    }
    let columns: Vec<usize> =
        base.joint_names.iter().filter_map(|name| other.joint_names.iter().position(|n| n == name)).collect();
    out.joints =
        (0..out.len()).flat_map(|t| columns.iter().map(move |c| (t, *c))).map(|(t, c)| out.joints_at(t)[c]).collect();
    out.joint_names = base.joint_names.clone();
    Ok(out)
}

/// Returns the columns of these joints.
///
/// # Errors
/// [`MotionError::Unfit`] for a name that the clip has not, and for no name at all.
pub(super) fn columns(clip: &MotionClip, names: &[String]) -> Result<Vec<usize>, MotionError> {
    if names.is_empty() {
        return Err(unfit(clip, "expected at least one joint to be picked, got none".into()));
    }
    let find = |name: &String| {
        let at = clip.joint_names.iter().position(|n| n == name);
        at.ok_or_else(|| unfit(clip, format!("expected one of its joints {:?}, got '{name}'", clip.joint_names)))
    };
    names.iter().map(find).collect()
}

/// Returns one joint over time.
pub(super) fn column(clip: &MotionClip, at: usize) -> Vec<f64> {
    clip.joints.iter().skip(at).step_by(clip.joint_names.len().max(1)).copied().collect()
}

/// Replaces one joint over time.
pub(super) fn set_column(clip: &mut MotionClip, at: usize, values: &[f64]) {
    let width = clip.joint_names.len().max(1);
    for (old, new) in clip.joints.iter_mut().skip(at).step_by(width).zip(values) {
        *old = *new;
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::fixtures::clip;

    #[test]
    fn columns_go_by_name_and_rates_agree() {
        let a = clip(3, |t| [t, -t]);
        let mut b = clip(3, |t| [10.0 * t, 1.0]);
        b.joint_names.reverse();
        b.fps = 25.0;
        let out = like(&a, &b).unwrap();
        assert_eq!((out.fps, out.len()), (50.0, 5));
        // b's second frame (a's third instant): its column 'slide' is now called 'hinge', and stands first.
        assert_eq!(out.joints_at(2), [1.0, 10.0 * 0.02]);
        b.joint_names[0] = "elbow".into();
        let message = like(&a, &b).unwrap_err().to_string();
        assert!(message.contains("elbow") && message.contains("slide"), "{message}");
        assert!(columns(&a, &["knee".into()]).unwrap_err().to_string().contains("knee"));
        assert!(columns(&a, &[]).is_err());
    }
}
