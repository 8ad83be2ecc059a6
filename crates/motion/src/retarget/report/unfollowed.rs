//! Limbs that only one of the two has: the human's that nothing follows, the character's that follow nothing.

use lifelike_character::{Role, Vec3};

use super::super::human::{ARM_ROLES, HumanFrame};
use super::super::rig::Rig;
use super::Gather;

/// Returns a sentence for every limb that has no counterpart.
pub(super) fn limbs(rig: &Rig, frames: &[HumanFrame]) -> Vec<String> {
    let Some(first) = frames.first() else { return Vec::new() };
    let mut found = Vec::new();
    for (side, name) in ["left", "right"].into_iter().enumerate() {
        match (first.arms[side].is_some(), rig.arms[side].is_some()) {
            (true, false) => found.push(format!("the capture's {name} arm is followed by nothing: the robot has none")),
            (false, true) => {
                let roles = ["upper_arm", "forearm", "hand"];
                let options = roles.map(|role| format!("correspondence.roles.{name}_{role}=JOINT")).join(" ");
                found.push(format!(
                    "the robot's {name} arm follows nothing: no joints of the capture have its roles. \
                                    Name them: {options}"
                ));
            }
            _ => {}
        }
    }
    match (first.head.is_some(), rig.head.is_some()) {
        (true, false) => found.push("the capture's head is followed by nothing: the robot has none".into()),
        (false, true) => found.push(
            "the robot's head follows nothing: no joint of the capture has its role. Name it: \
             correspondence.roles.head=JOINT"
                .into(),
        ),
        _ => {}
    }
    found
}

/// Returns the errors of arms that the character lacks: angles (deg) from their mean direction in the chest's frame, the
/// least error that something still can have.
pub(super) fn arm_errors(rig: &Rig, frames: &[HumanFrame]) -> Vec<(Role, Gather)> {
    let mut errors = Vec::new();
    for side in (0..2).filter(|&side| rig.arms[side].is_none()) {
        let segments = |f: &HumanFrame| {
            let arm = f.arms[side]?;
            Some([arm.upper, arm.fore].map(|direction| f.chest.inverse() * direction))
        };
        let seen: Vec<[Vec3; 2]> = frames.iter().filter_map(segments).collect();
        for (part, role) in ARM_ROLES[side].into_iter().take(2).enumerate().filter(|_| !seen.is_empty()) {
            let mean: Vec3 = seen.iter().map(|segments| segments[part]).sum();
            let mut error = Gather::default();
            seen.iter().for_each(|segments| error.add(segments[part].angle(&mean).to_degrees()));
            errors.push((role, error));
        }
    }
    errors
}
