//! Provenance and captions of an edited clip: its sources, and the sentences that are still true of it.

use crate::clip::{Caption, MotionClip, Provenance};
use crate::error::MotionError;

/// Returns the error of an edit: this clip cannot be used for it.
pub(super) fn unfit(clip: &MotionClip, message: String) -> MotionError {
    MotionError::Unfit { clip: clip.name.clone(), message }
}

/// Returns the provenance of a clip made from these: `done` says what was done; the terms of all sources hold together.
pub(super) fn provenance(sources: &[&MotionClip], done: String, captions: Vec<Caption>) -> Provenance {
    let mut terms: Vec<&str> = Vec::new();
    for licence in sources.iter().map(|clip| clip.provenance.licence.as_str()) {
        if !licence.is_empty() && !terms.contains(&licence) {
            terms.push(licence);
        }
    }
    let character = sources.first().map(|clip| clip.provenance.character.clone()).unwrap_or_default();
    Provenance { character, source: done, licence: terms.join("; "), captions }
}

/// Returns the captions after their times went through `map` (s); what is left of `[0, seconds]` is kept.
pub(super) fn captions(clip: &MotionClip, seconds: f64, map: impl Fn(f64) -> f64) -> Vec<Caption> {
    let moved = clip.provenance.captions.iter().map(|caption| Caption {
        start: map(caption.start).max(0.0),
        end: map(caption.end).min(seconds),
        text: caption.text.clone(),
    });
    moved.filter(|caption| caption.end > caption.start).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixtures::clip;

    #[test]
    fn terms_of_all_sources_hold_and_captions_move_along() {
        let mut a = clip(3, |_| [0.0, 0.0]);
        a.provenance.licence = "CC0".into();
        a.provenance.captions = vec![
            Caption { start: 0.0, end: 1.0, text: "early".into() },
            Caption { start: 2.0, end: 9.0, text: "late".into() },
        ];
        let mut b = a.clone();
        b.provenance.licence = "MIT".into();
        assert_eq!(provenance(&[&a, &b, &a], "x".into(), vec![]).licence, "CC0; MIT");
        let kept = captions(&a, 3.0, |t| t - 1.5);
        assert_eq!(kept, [Caption { start: 0.5, end: 3.0, text: "late".into() }]);
    }
}
