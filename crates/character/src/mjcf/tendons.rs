//! `<tendon>`: strings through sites or sums of joints. One without forces changes nothing; others are MuJoCo's alone.

use crate::error::CharacterError;
use crate::mjcf::attributes::Attributes;
use crate::mjcf::defaults::Defaults;
use crate::mjcf::document::Element;
use crate::mjcf::names::has_joint;

/// Attributes that give a tendon a force.
const FORCES: [&str; 4] = ["stiffness", "damping", "frictionloss", "armature"];

/// Checks the tendons; adds a line to `notes` for those without forces and to `warnings` for others.
pub(crate) fn read(
    root: &Element,
    defaults: &Defaults,
    autolimits: bool,
    notes: &mut Vec<String>,
    warnings: &mut Vec<String>,
) -> Result<(), CharacterError> {
    let (mut idle, mut with_forces) = (0, Vec::new());
    for element in root.children_named("tendon").flat_map(|section| &section.children) {
        if !matches!(element.name.as_str(), "fixed" | "spatial") {
            return Err(element.unsupported("kind of tendon"));
        }
        let a = defaults.resolve(element, None)?;
        if element.children.is_empty() {
            return Err(a.invalid("a path", "an empty tendon"));
        }
        for joint in element.children_named("joint") {
            let name = joint.attribute("joint").unwrap_or_default();
            if !has_joint(root, name) {
                return Err(joint.invalid("the name of a joint", format!("'{name}'")));
            }
        }
        let mut forces = Vec::new();
        for name in FORCES {
            let (first, rest) = match a.text(name) {
                None => continue,
                Some(text) => text.split_once(char::is_whitespace).unwrap_or((text, "")),
            };
            if format!("{first} {rest}").split_whitespace().any(|word| word.parse::<f64>() != Ok(0.0)) {
                forces.push(name);
            }
        }
        if a.limits("range", "limited", autolimits)?.is_some() {
            forces.push("range");
        }
        match forces.is_empty() {
            true => idle += 1,
            false => with_forces.push(format!("{} ({})", name(&a), forces.join(", "))),
        }
    }
    if idle > 0 {
        notes.push(format!("{idle} tendons have neither stiffness nor limits"));
    }
    if !with_forces.is_empty() {
        warnings
            .push(format!("tendons with forces, which MuJoCo has and our engine has not: {}", with_forces.join(", ")));
    }
    Ok(())
}

/// Returns the joint that a fixed tendon follows and its coefficient; `None` for tendons of several joints or through sites.
pub(crate) fn only_joint<'a>(
    root: &'a Element,
    name: &str,
    user: &Attributes,
) -> Result<Option<(&'a str, f64)>, CharacterError> {
    let mut all = root.children_named("tendon").flat_map(|section| &section.children);
    let tendon = all.find(|tendon| tendon.attribute("name") == Some(name));
    let tendon = tendon.ok_or_else(|| user.invalid("the name of a tendon", format!("'{name}'")))?;
    match (tendon.name.as_str(), tendon.children.as_slice()) {
        ("fixed", [joint]) => {
            let coefficient = Attributes::own(joint).number("coef")?.unwrap_or(1.0);
            Ok(joint.attribute("joint").map(|name| (name, coefficient)))
        }
        _ => Ok(None),
    }
}

fn name(a: &Attributes) -> String {
    a.text("name").map_or_else(|| format!("line {}", a.at.line), str::to_string)
}
