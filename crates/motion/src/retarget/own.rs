//! Contacts and soles of a character's own motion, in the form in which those of a captured human come.

use lifelike_character::rotation::heading;
use lifelike_character::{Kinematics, Vec3};

use super::feet::{FootTarget, Stance, hold, keep_of_tilt};
use super::options::RetargetOptions;
use super::rig::Rig;
use crate::contacts::point_contacts;

/// Finds the ends of the soles that stand: those that are low and slow, and while the clip says that the foot stands
/// (`standing[side]`) at least the lower one.
pub(super) fn stances(
    rig: &Rig,
    poses: &[Vec<f64>],
    standing: &[Option<Vec<bool>>; 2],
    options: &RetargetOptions,
) -> [Stance; 2] {
    let rule = options.contact.scaled(rig.leg_length);
    let paths = ends(rig, poses);
    [0, 1].map(|side: usize| {
        let mut down = [0, 1].map(|end: usize| point_contacts(&paths[side][end], 0.0, options.fps, &rule));
        if let Some(known) = &standing[side] {
            for (t, &stands) in known.iter().enumerate().take(poses.len()) {
                if !stands {
                    (down[0][t], down[1][t]) = (false, false);
                } else if !down[0][t] && !down[1][t] {
                    let lower = usize::from(paths[side][1][t].z < paths[side][0][t].z);
                    down[lower][t] = true;
                }
            }
        }
        Stance { down }
    })
}

/// Returns the soles in the edited motion, level while both ends stand. A tilt of the foot while one end stands is its
/// own doing and stays.
pub(super) fn soft_targets(rig: &Rig, poses: &[Vec<f64>], stances: &[Stance; 2], fps: f64) -> [Vec<FootTarget>; 2] {
    let paths = ends(rig, poses);
    let mut kinematics = Kinematics::new(rig.character);
    let mut targets: [Vec<FootTarget>; 2] = [Vec::new(), Vec::new()];
    let holds = [0, 1].map(|side: usize| [0, 1].map(|end: usize| hold(&stances[side].down[end], fps)));
    for (t, pose) in poses.iter().enumerate() {
        kinematics.update(rig.character, pose);
        for (side, targets) in targets.iter_mut().enumerate() {
            let foot = &rig.legs[side].foot;
            let turn = kinematics.body_orientation[foot.body] * foot.rest.inverse();
            let hold = [holds[side][0][t], holds[side][1][t]];
            let level = heading(&turn);
            let orientation = level * (level.inverse() * turn).powf(keep_of_tilt(hold, 1.0));
            let ends = [paths[side][0][t], paths[side][1][t]];
            targets.push(FootTarget { ends, hold, orientation, left: level * Vec3::y(), turn_hold: 0.0 });
        }
    }
    targets
}

/// Paths of toe and heel of both soles (m, world): `[side][toe, heel][frame]`.
fn ends(rig: &Rig, poses: &[Vec<f64>]) -> [[Vec<Vec3>; 2]; 2] {
    let mut kinematics = Kinematics::new(rig.character);
    let mut paths: [[Vec<Vec3>; 2]; 2] = Default::default();
    for pose in poses {
        kinematics.update(rig.character, pose);
        for (leg, paths) in rig.legs.iter().zip(&mut paths) {
            for (point, path) in [leg.foot.toe, leg.foot.heel].iter().zip(paths) {
                path.push(kinematics.point(leg.foot.body, point));
            }
        }
    }
    paths
}
