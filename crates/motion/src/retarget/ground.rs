//! The last step: the whole motion up or down by a little, so that what stands touches and nothing is below the ground.

use lifelike_character::Kinematics;

use super::feet::Stance;
use super::rig::Rig;
use super::shapes::Shapes;
use super::smooth::smooth;

/// Shifts the root's height smoothly: the lowest point is on the ground while a foot stands, and nowhere below it.
pub(super) fn settle(rig: &Rig, shapes: &Shapes, poses: &mut [Vec<f64>], stances: &[Stance; 2]) {
    let mut kinematics = Kinematics::new(rig.character);
    let lowest: Vec<f64> = poses
        .iter()
        .map(|pose| {
            kinematics.update(rig.character, pose);
            lowest_point(rig, shapes, &kinematics)
        })
        .collect();
    let standing = |t: usize| stances.iter().any(|s| s.any(t));
    // Between contacts the shift goes over linearly, so flight keeps its shape.
    let mut shift = vec![0.0; poses.len()];
    let mut last: Option<usize> = None;
    for t in (0..poses.len()).filter(|&t| standing(t)) {
        shift[t] = -lowest[t];
        match last {
            None => shift[..t].fill(-lowest[t]),
            Some(before) => {
                for k in before + 1..t {
                    let share = (k - before) as f64 / (t - before) as f64;
                    shift[k] = shift[before] + share * (shift[t] - shift[before]);
                }
            }
        }
        last = Some(t);
    }
    if let Some(before) = last {
        let value = shift[before];
        shift[before + 1..].fill(value);
    }
    let mut shift = smooth(&shift, 2.0);
    // What is still below comes up: the envelope of the penetrations, smoothed by less than it was widened.
    let below: Vec<f64> = lowest.iter().zip(&shift).map(|(z, s)| (-(z + s) - 1e-3).max(0.0)).collect();
    let widened: Vec<f64> = (0..below.len())
        .map(|t| below[t.saturating_sub(6)..(t + 7).min(below.len())].iter().copied().fold(0.0, f64::max))
        .collect();
    for (s, up) in shift.iter_mut().zip(smooth(&widened, 2.0)) {
        *s += up.max(0.0);
    }
    let at = rig.root.q_index + 2;
    for (pose, s) in poses.iter_mut().zip(&shift) {
        pose[at] += s;
    }
}

/// Returns the height of the lowest point of all shapes and soles (m).
pub(super) fn lowest_point(rig: &Rig, shapes: &Shapes, kinematics: &Kinematics) -> f64 {
    let soles = rig.legs.iter().flat_map(|l| l.foot.corners.iter().map(|c| kinematics.point(l.foot.body, c).z));
    soles.fold(shapes.lowest(kinematics), f64::min)
}
