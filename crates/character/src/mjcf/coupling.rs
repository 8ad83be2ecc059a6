//! `<equality><joint>`: a joint whose position is a polynomial of another's. Of the two only the other moves; the first is held.

use std::collections::BTreeSet;

use crate::error::CharacterError;
use crate::mjcf::attributes::Attributes;
use crate::mjcf::document::Element;
use crate::mjcf::names::has_joint;

/// Removes the joints that such a constraint moves, with what refers to them; adds a line for all of them to `warnings`. Each
/// stays where the model has it at zero.
pub(crate) fn hold(root: &mut Element, warnings: &mut Vec<String>) -> Result<(), CharacterError> {
    let mut held = BTreeSet::new();
    let mut lines = Vec::new();
    for element in root.children_named("equality").flat_map(|section| section.children_named("joint")) {
        let a = Attributes::own(element);
        a.only(&["name", "class", "joint1", "joint2", "polycoef", "active", "solref", "solimp"])?;
        let follower = a.required("joint1")?;
        for name in [Some(follower), a.text("joint2")].into_iter().flatten() {
            if !has_joint(root, name) {
                return Err(a.invalid("the name of a joint", format!("'{name}'")));
            }
        }
        if a.boolean("active", true)? {
            lines
                .push(a.text("joint2").map_or(follower.to_string(), |leader| format!("{follower} (follows {leader})")));
            held.insert(follower.to_string());
        }
    }
    for section in root.children.iter_mut().filter(|c| c.name == "equality") {
        section.children.retain(|c| c.name != "joint");
    }
    if held.is_empty() {
        return Ok(());
    }
    let names = |element: &Element| element.attribute("name").is_some_and(|name| held.contains(name));
    for world in root.children.iter_mut().filter(|c| c.name == "worldbody") {
        remove(world, &|element| element.name == "joint" && names(element));
    }
    let refers = |element: &Element| element.attribute("joint").is_some_and(|joint| held.contains(joint));
    let mut tendons = BTreeSet::new();
    for section in root.children.iter_mut().filter(|c| c.name == "tendon") {
        let gone = |tendon: &Element| tendon.children.iter().any(refers);
        tendons.extend(
            section.children.iter().filter(|t| gone(t)).filter_map(|t| t.attribute("name")).map(str::to_string),
        );
        section.children.retain(|tendon| !gone(tendon));
    }
    for section in root.children.iter_mut().filter(|c| c.name == "actuator") {
        let gone = |a: &Element| refers(a) || a.attribute("tendon").is_some_and(|name| tendons.contains(name));
        section.children.retain(|actuator| !gone(actuator));
    }
    // Their entries may be of what is gone, and say nothing about the dynamics.
    root.children.retain(|c| !matches!(c.name.as_str(), "sensor" | "keyframe"));
    warnings.push(format!("joints whose position an equality constraint gives are held: {}", lines.join(", ")));
    Ok(())
}

fn remove(element: &mut Element, is_gone: &dyn Fn(&Element) -> bool) {
    element.children.retain(|child| !is_gone(child));
    element.children.iter_mut().for_each(|child| remove(child, is_gone));
}
