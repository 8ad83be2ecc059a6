//! Unique names for what the text leaves unnamed.

use std::collections::BTreeSet;

use crate::error::CharacterError;
use crate::mjcf::document::Element;

/// Returns `wanted`, with underscores appended until it is not among `taken`.
pub(crate) fn made_up<'a>(mut wanted: String, taken: impl Iterator<Item = &'a str>) -> String {
    let taken: BTreeSet<&str> = taken.collect();
    while taken.contains(wanted.as_str()) {
        wanted.push('_');
    }
    wanted
}

/// Fails where one kind of element uses a name twice.
pub(crate) fn all_different(root: &Element) -> Result<(), CharacterError> {
    let mut seen = BTreeSet::new();
    for section in
        root.children.iter().filter(|c| matches!(c.name.as_str(), "worldbody" | "actuator" | "asset" | "equality"))
    {
        check(section, &mut seen)?;
    }
    Ok(())
}

fn check<'a>(element: &'a Element, seen: &mut BTreeSet<(&'a str, &'a str)>) -> Result<(), CharacterError> {
    let parent = element.name.as_str();
    for child in &element.children {
        let kind = match child.name.as_str() {
            "freejoint" => "joint",
            _ if parent == "actuator" || parent == "equality" => parent,
            other => other,
        };
        let name = child.attribute("name").filter(|n| !n.is_empty());
        if let Some(name) = name.filter(|n| !seen.insert((kind, *n))) {
            return Err(child.invalid(format!("a {kind} name that is not taken"), format!("'{name}'")));
        }
        check(child, seen)?;
    }
    Ok(())
}

/// Returns whether the model has a joint of this name.
pub(crate) fn has_joint(root: &Element, name: &str) -> bool {
    let is_it = |e: &Element| matches!(e.name.as_str(), "joint" | "freejoint") && e.attribute("name") == Some(name);
    let places = root.children.iter().filter(|c| matches!(c.name.as_str(), "worldbody" | "body" | "frame"));
    root.children.iter().any(is_it) || places.into_iter().any(|place| has_joint(place, name))
}
