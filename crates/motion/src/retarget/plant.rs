//! The soles onto the ground: of a motion that follows a human, or of a finished one that was edited.

use super::feet::{self, FootTarget, Stance};
use super::options::RetargetOptions;
use super::rig::Rig;
use super::shapes::Shapes;
use super::{finish, ground, own, passes, smooth};

/// Locks the standing soles with root and legs where they are in `walked`, zero-phase smoothing between the passes; everything else
/// stays as in `followed`. Generalised positions.
pub(super) fn plant(
    rig: &Rig,
    followed: &[Vec<f64>],
    walked: &[Vec<f64>],
    soft: &[Vec<FootTarget>; 2],
    stances: &[Stance; 2],
    options: &RetargetOptions,
) -> Vec<Vec<f64>> {
    let fps = options.fps;
    let sigma = options.smoothing * fps;
    let clearance = options.swing_clearance * rig.leg_length / 0.44;
    let locked = feet::locked_targets(rig, walked, soft, stances, clearance, fps);
    let mut standing = passes::stand(rig, followed, &locked, fps, 3);
    smooth::smooth_change(rig, followed, &mut standing, sigma);
    let mut settled = passes::stand(rig, &standing, &locked, fps, 3);
    smooth::smooth_change(rig, &standing, &mut settled, 0.3 * sigma);
    smooth::smooth_poses(rig, &mut settled, 0.6 * sigma);
    settled
}

/// Puts the soles of an edited motion back on the ground while they stood in `before`, the motion as it was. Only the
/// root and the legs move; legs come out within ranges and speeds. `standing` says for left and right foot and frame
/// whether it stands, where that is known. `options.fps` is the rate of both motions.
pub(crate) fn replant(
    rig: &Rig,
    before: &[Vec<f64>],
    edited: &[Vec<f64>],
    standing: &[Option<Vec<bool>>; 2],
    options: &RetargetOptions,
) -> Vec<Vec<f64>> {
    stand_as(rig, before, edited, edited, standing, options)
}

/// As [`replant`], with every sole where it is in `walked`: the body may sway above its own steps.
pub(crate) fn stand_as(
    rig: &Rig,
    before: &[Vec<f64>],
    walked: &[Vec<f64>],
    edited: &[Vec<f64>],
    standing: &[Option<Vec<bool>>; 2],
    options: &RetargetOptions,
) -> Vec<Vec<f64>> {
    let stances = own::stances(rig, before, standing, options);
    let soft = own::soft_targets(rig, walked, &stances, options.fps);
    let mut poses = plant(rig, edited, walked, &soft, &stances, options);
    ground::settle(rig, &Shapes::new(rig.character), &mut poses, &stances);
    finish(rig, &mut poses, options.fps);
    // The last smoothing is for the legs; what else moves stays as sharp as it was edited.
    for (pose, edited) in poses.iter_mut().zip(edited) {
        for axis in rig.axes.iter().filter(|a| !a.leg) {
            pose[axis.q] = edited[axis.q];
        }
    }
    poses
}
