//! Mistakes of convention in a robot's motion: quaternion order, units, axes, rate, wrapped angles, columns of other joints.
//!
//! Such a clip is well formed, and wrong. Each [`Mistake`] is a hypothesis with a correction. [`Fit`] measures how a clip
//! stands on the ground within its joints' ranges. A mistake is reported where its correction removes most of the misfit,
//! so a clip that only moves oddly (lies, crawls, leaps) is not blamed. Motion that no correction explains is for
//! [`feasibility`](crate::feasibility).

mod columns;
mod fit;
mod mistake;

use lifelike_character::{Anatomy, Character};

use crate::clip::MotionClip;
use crate::error::MotionError;

pub use columns::JointOrder;
pub use fit::Fit;
pub use mistake::{MIN_FPS, Mistake};

/// Largest number of mistakes that are corrected one after the other.
const MAX_ROUNDS: usize = 4;

/// A mistake in a clip.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Flaw {
    /// The mistake.
    pub mistake: Mistake,
    /// Measures that show it.
    pub evidence: String,
    /// Share of the misfit that the correction removes (0 to 1).
    pub confidence: f64,
}

impl Flaw {
    /// Returns a sentence.
    pub fn words(&self) -> String {
        format!("{} ({}; confidence {:.0}%)", self.mistake.words(), self.evidence, 100.0 * self.confidence)
    }
}

/// Finds the mistakes of a clip, and corrects them one after the other. Returns the clip as it is when there are none.
///
/// # Errors
/// [`MotionError::Unfit`] for an inconsistent clip, [`MotionError::Mismatch`] when clip and character name different
/// joints.
pub fn lint(
    clip: &MotionClip,
    character: &Character,
    anatomy: &Anatomy,
) -> Result<(MotionClip, Vec<Flaw>), MotionError> {
    clip.check()?;
    let columns = clip.columns_for(character)?;
    let mut best = clip.clone();
    let mut flaws = mistake::certain(&mut best, character, &columns);
    let measure = |clip: &MotionClip| Fit::of(clip, character, anatomy, &columns);
    let mut fit = measure(&best);
    let explained = |clip: &MotionClip, fit: &Fit| {
        let candidates = mistake::hypotheses(clip, character).into_iter().filter_map(|mistake| {
            let corrected = mistake.corrected(clip, character, &columns)?;
            let fit = measure(&corrected);
            Some((mistake, corrected, fit))
        });
        let best = candidates.min_by(|a, b| a.2.cost().total_cmp(&b.2.cost()));
        best.filter(|(.., better)| better.explains(fit))
    };
    // These two leave a clip that hardly looks wrong.
    let subtle =
        [(mistake::is_turned_away(&best), Mistake::QuaternionOrder), (true, Mistake::Columns(JointOrder::OtherSide))];
    for (is_possible, mistake) in subtle {
        if is_possible && let Some(corrected) = mistake.corrected(&best, character, &columns) {
            let better = measure(&corrected);
            // Signs of all angles, for one, make the sides look exchanged.
            let is_other = fit.is_bad() && explained(&best, &fit).is_some_and(|(.., fit)| fit.cost() < better.cost());
            if better.is_clearly_better(&fit) && !is_other {
                flaws.push(flaw(mistake, &fit, &better));
                (best, fit) = (corrected, better);
            }
        }
    }
    for _ in 0..MAX_ROUNDS {
        if !fit.is_bad() {
            break;
        }
        let Some((mistake, corrected, better)) = explained(&best, &fit) else {
            break;
        };
        flaws.push(flaw(mistake, &fit, &better));
        (best, fit) = (corrected, better);
    }
    flaws.extend(mistake::height(&mut best, &fit));
    Ok((best, flaws))
}

fn flaw(mistake: Mistake, before: &Fit, after: &Fit) -> Flaw {
    let evidence = format!("as it is: {before}; corrected: {after}");
    Flaw { mistake, evidence, confidence: 1.0 - after.cost() / before.cost() }
}

#[cfg(test)]
mod tests;
