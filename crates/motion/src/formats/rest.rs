//! One rest pose for every format: the T-pose.
//!
//! Legs hang straight down, feet point forward and lie flat, arms point straight to the sides, palms down. The elbows'
//! hinges are vertical: bending a forearm brings it forward. Formats differ: the legs of an ASF are spread by 20
//! degrees and its elbows' hinges tilted by 30. The forearms of a Daz figure are drawn bent by 17, DeepMimic's arms
//! hang down. With one rest pose the rotation of a thigh means the same in every format. The local rotation of a knee
//! or an elbow is the angle between its two bones.

use lifelike_character::{Quat, Vec3};

use crate::roles::Roles;
use crate::source::Skeleton;

/// The joints of one side: thigh, shin, foot, upper arm, forearm, hand.
pub(crate) type Limbs = [usize; 6];

/// Returns the left and the right limbs of a skeleton, if it has all of them.
pub(crate) fn limbs(roles: &Roles) -> Option<[Limbs; 2]> {
    let [left, right] = roles.legs()?;
    let side = |[a, b, c]: [usize; 3], arm: [usize; 3]| [a, b, c, arm[0], arm[1], arm[2]];
    match roles.arms() {
        [Some(arm), Some(other)] => Some([side(left, arm), side(right, other)]),
        _ => None,
    }
}

/// Facts about a format's rest pose that geometry does not show.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct Hints {
    /// Angle (rad) by which the elbows' hinges are turned about the arms (about y, from x towards -z) in the T-pose.
    pub elbow_tilt: f64,
    /// The forearms are drawn bent although zero rotation means a straight arm: what hangs on them is straightened.
    pub drawn_bent: bool,
    /// A joint whose frame looks up by this angle (rad) when the head is level.
    pub looks_up: Option<(usize, f64)>,
}

/// Changes the rest pose of a skeleton (z up, x forward, y left) to the T-pose, as far as its limbs are known by name.
/// Returns the world rotation by which each joint's segment was turned.
pub(crate) fn straighten(skeleton: &mut Skeleton, roles: &Roles, hints: &Hints) -> Vec<Quat> {
    let n = skeleton.names.len();
    let mut own: Vec<Option<Quat>> = vec![None; n];
    if let Some(sides) = limbs(roles) {
        if hints.drawn_bent {
            for [.., upper, fore, hand] in sides {
                unbend(skeleton, upper, fore, hand);
            }
        }
        let positions = skeleton.rest_positions();
        let bone = |from: usize, to: usize| positions[to] - positions[from];
        let hinge = Quat::from_axis_angle(&Vec3::y_axis(), hints.elbow_tilt);
        for (side, [thigh, shin, foot, upper, fore, hand]) in sides.into_iter().enumerate() {
            let aside = if side == 0 { Vec3::y() } else { -Vec3::y() };
            own[thigh] = Quat::rotation_between(&bone(thigh, shin), &-Vec3::z());
            own[shin] = Quat::rotation_between(&bone(shin, foot), &-Vec3::z());
            // The sole lies flat in every rest pose met, seen from the side; only the legs' spread must be undone.
            let down = bone(shin, foot);
            own[foot] = Quat::rotation_between(&Vec3::new(0.0, down.y, down.z), &-Vec3::z());
            own[upper] = Quat::rotation_between(&bone(upper, fore), &aside).map(|turn| hinge * turn);
            own[hand] = Quat::rotation_between(&bone(fore, hand), &aside);
            own[fore] = own[hand].map(|turn| hinge * turn);
        }
    }
    if let Some((joint, angle)) = hints.looks_up {
        own[joint] = Some(Quat::from_axis_angle(&Vec3::y_axis(), -angle));
    }
    let mut turns: Vec<Quat> = Vec::with_capacity(n);
    for (joint, own) in own.into_iter().enumerate() {
        let parent = skeleton.parents[joint].map_or_else(Quat::identity, |p| turns[p]);
        skeleton.offsets[joint] = parent * skeleton.offsets[joint];
        turns.push(own.unwrap_or(parent));
    }
    for (joint, offset) in &mut skeleton.ends {
        *offset = turns[*joint] * *offset;
    }
    turns
}

/// Turns what hangs on a forearm so that it goes on in the upper arm's direction.
fn unbend(skeleton: &mut Skeleton, upper: usize, fore: usize, hand: usize) {
    let is_one_chain = skeleton.parents[fore] == Some(upper) && skeleton.parents[hand] == Some(fore);
    let turn = Quat::rotation_between(&skeleton.offsets[hand], &skeleton.offsets[fore]);
    let (true, Some(turn)) = (is_one_chain, turn) else { return };
    let mut below = vec![false; skeleton.names.len()];
    for joint in 0..skeleton.names.len() {
        below[joint] = joint == fore || skeleton.parents[joint].is_some_and(|p| below[p]);
        if below[joint] && joint != fore {
            skeleton.offsets[joint] = turn * skeleton.offsets[joint];
        }
    }
    for (joint, offset) in &mut skeleton.ends {
        if below[*joint] {
            *offset = turn * *offset;
        }
    }
}
