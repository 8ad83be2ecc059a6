//! The policies that a training learns from, where its plan names any.

use std::path::PathBuf;

use glob::Pattern;
use lifelike_robot::clips::MIRRORED;

use crate::TrackerError;
use lifelike_train::limits::{PlanError, wrong};

/// A policy to learn from, and what it teaches.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TeacherSpec {
    /// The folder of a run, a policy's file, or a controller's.
    pub policy: PathBuf,
    /// Names or patterns (`walk*`) of the clips that it teaches; none: every clip.
    ///
    /// The first of several teachers of a clip teaches it, and its mirror image.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub clips: Vec<String>,
}

impl TeacherSpec {
    /// Checks the patterns.
    pub(super) fn check(&self) -> Result<(), PlanError> {
        self.patterns().map(|_| ())
    }

    fn patterns(&self) -> Result<Vec<Pattern>, PlanError> {
        let pattern = |text: &String| {
            Pattern::new(text)
                .map_err(|e| wrong("teachers.clips", "names of clips, or patterns of them", format!("'{text}' ({e})")))
        };
        self.clips.iter().map(pattern).collect()
    }
}

/// Returns the number of each clip's teacher.
///
/// # Errors
/// [`TrackerError::Plan`] with the first clip that none of them teaches, or the first teacher without a clip.
pub(crate) fn teachers_of(teachers: &[TeacherSpec], clips: &[String]) -> Result<Vec<usize>, TrackerError> {
    let patterns: Vec<Vec<Pattern>> = teachers.iter().map(TeacherSpec::patterns).collect::<Result<_, _>>()?;
    // The mirror image of a clip has the clip's teacher.
    let named = |pattern: &Pattern, clip: &str| {
        pattern.matches(clip) || clip.strip_suffix(MIRRORED).is_some_and(|clip| pattern.matches(clip))
    };
    let teaches = |patterns: &[Pattern], clip: &str| patterns.is_empty() || patterns.iter().any(|p| named(p, clip));
    let teacher = |clip: &String| {
        let teacher = patterns.iter().position(|patterns| teaches(patterns, clip));
        teacher.ok_or_else(|| wrong("teachers", "a teacher of every clip", format!("none of '{clip}'")))
    };
    let of_clip: Vec<usize> = clips.iter().map(teacher).collect::<Result<_, _>>()?;
    if let Some(idle) = (0..teachers.len()).find(|i| !of_clip.contains(i)) {
        let got =
            format!("none for '{}' (of several that teach a clip the first does)", teachers[idle].policy.display());
        return Err(wrong("teachers.clips", "a clip for every teacher", got).into());
    }
    Ok(of_clip)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn teacher(policy: &str, clips: &[&str]) -> TeacherSpec {
        TeacherSpec { policy: policy.into(), clips: clips.iter().map(ToString::to_string).collect() }
    }

    #[test]
    fn the_first_that_teaches_a_clip_does_and_mirror_images_are_named_after_their_clips() {
        let clips = ["walk_slow", "walk_slow+mirror", "kick", "kick+mirror", "bow"].map(String::from);
        let teachers = [teacher("a", &["walk*"]), teacher("b", &["kick", "walk_slow"]), teacher("c", &[])];
        assert_eq!(teachers_of(&teachers, &clips).unwrap(), [0, 0, 1, 1, 2]);
    }

    #[test]
    fn a_clip_without_a_teacher_and_a_teacher_without_a_clip_are_named() {
        let clips = ["walk", "kick"].map(String::from);
        let refused = |teachers: &[TeacherSpec]| teachers_of(teachers, &clips).unwrap_err().to_string();
        assert!(refused(&[teacher("a", &["walk*"])]).contains("none of 'kick'"));
        assert!(refused(&[teacher("a", &[]), teacher("b", &["kick"])]).contains("none for 'b'"));
        assert!(refused(&[teacher("a", &["[walk"])]).contains("'[walk'"));
    }
}
