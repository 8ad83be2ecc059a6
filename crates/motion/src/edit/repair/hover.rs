//! Height: a body that neither touches nor falls comes down.

use super::{FALLING, Needs};
use crate::clip::MotionClip;
use crate::edit::poses::{positions, set_positions};
use crate::edit::restyle::{set_standing, standing};
use crate::error::MotionError;
use crate::retarget::rig::Rig;
use crate::retarget::smooth::smooth;
use crate::retarget::{RetargetOptions, replant};

/// Higher than this share of its legs it is not lowered: it is on something.
const HIGHEST: f64 = 0.3;
/// Going down and up takes so long (s).
const SMOOTH: f64 = 0.06;

/// Returns the clip with what hovers on the ground; `None` if nothing does.
pub(super) fn lower(
    clip: &MotionClip,
    needs: &Needs,
    rig: &Rig,
    options: &RetargetOptions,
) -> Result<Option<MotionClip>, MotionError> {
    let mut down = vec![0.0; clip.len()];
    let mut stands = standing(clip, rig);
    for (start, end) in needs.airborne() {
        let hovers = needs.falls((start, end), clip.fps).is_some_and(|fall| fall < FALLING * needs.gravity);
        let lowest = |t: usize| needs.soles[t][0].min(needs.soles[t][1]);
        if !hovers || (start..end).any(|t| lowest(t) > HIGHEST * rig.leg_length) {
            continue;
        }
        let mean = |side: usize| needs.soles[start..end].iter().map(|z| z[side]).sum::<f64>();
        let side = usize::from(mean(1) < mean(0));
        (start..end).for_each(|t| down[t] = needs.soles[t][side]);
        if let Some(stands) = &mut stands[side] {
            stands[start..end].fill(true);
        }
    }
    if down.iter().all(|z| *z == 0.0) {
        return Ok(None);
    }
    let old = positions(clip, rig.character)?;
    let mut lowered = old.clone();
    for (q, z) in lowered.iter_mut().zip(smooth(&down, SMOOTH * clip.fps)) {
        q[rig.root.q_index + 2] -= z;
    }
    let new = replant(rig, &lowered, &lowered, &stands, options);
    let mut out = clip.clone();
    set_positions(&mut out, rig.character, &new);
    set_standing(&mut out, rig, &stands);
    Ok(Some(out))
}
