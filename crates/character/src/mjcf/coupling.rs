//! `<equality><joint>`: a joint whose position is a polynomial of another's, or constant.

use crate::coupling::Coupling;
use crate::error::CharacterError;
use crate::mjcf::defaults::Defaults;
use crate::mjcf::document::Element;
use crate::mjcf::equality::{SOLIMP, SOLREF};
use crate::model::{Actuator, Joint, JointKind};

/// Reads the couplings that are active. A joint without an actuator becomes the follower of its first coupling, unless
/// its leader follows it. All others are constraints of the physics only, and have a line in `warnings`.
pub(crate) fn read(
    root: &Element,
    defaults: &Defaults,
    joints: &mut [Joint],
    actuators: &[Actuator],
    warnings: &mut Vec<String>,
) -> Result<Vec<Coupling>, CharacterError> {
    let mut couplings: Vec<Coupling> = Vec::new();
    let mut stiff = Vec::new();
    for element in root.children_named("equality").flat_map(|section| section.children_named("joint")) {
        // Its tag is also that of a hinge, whose defaults are others.
        let a = defaults.resolve(&Element { name: "equality".into(), ..element.clone() }, None)?;
        a.only(&["name", "class", "joint1", "joint2", "polycoef", "active", "solref", "solimp"])?;
        let find = |attribute: &str, name: &str| match joints.iter().position(|joint| joint.name == name) {
            Some(i) if matches!(joints[i].kind, JointKind::Hinge | JointKind::Slide) => Ok(i),
            Some(_) => Err(a.invalid(format!("a hinge or slide for '{attribute}'"), format!("'{name}'"))),
            None => Err(a.invalid(format!("the name of a joint for '{attribute}'"), format!("'{name}'"))),
        };
        let follower = find("joint1", a.required("joint1")?)?;
        let leader = a.text("joint2").map(|name| find("joint2", name)).transpose()?;
        if leader == Some(follower) {
            return Err(a.invalid("two different joints", format!("'{}' twice", joints[follower].name)));
        }
        let polynomial = a.prefix("polycoef", [0.0, 1.0, 0.0, 0.0, 0.0])?;
        let (solref, solimp) = (a.prefix("solref", SOLREF)?, a.prefix("solimp", SOLIMP)?);
        if !a.boolean("active", true)? {
            continue;
        }
        let mut above = leader;
        while let Some(next) = above.filter(|joint| *joint != follower) {
            above = joints[next].coupling.and_then(|index| couplings[index].leader);
        }
        let driven = actuators.iter().any(|actuator| actuator.joint == follower);
        if driven || joints[follower].coupling.is_some() || above.is_some() {
            stiff.push(joints[follower].name.clone());
        } else {
            joints[follower].coupling = Some(couplings.len());
        }
        couplings.push(Coupling { follower, leader, polynomial, solref, solimp });
    }
    if !stiff.is_empty() {
        warnings.push(format!(
            "joints that an equality constraint ties to others and that move by themselves, by an actuator or another \
             constraint: physics has the constraint, retargeting has not: {}",
            stiff.join(", ")
        ));
    }
    Ok(couplings)
}
