//! `<actuator>`: which joint, which limits, which gains.

use crate::error::CharacterError;
use crate::mjcf::attributes::Attributes;
use crate::mjcf::compiler::Compiler;
use crate::mjcf::defaults::Defaults;
use crate::mjcf::document::Element;
use crate::model::{Actuator, Joint};

const KINDS: [&str; 7] = ["motor", "position", "velocity", "general", "intvelocity", "damper", "cylinder"];

/// Reads every actuator that drives a joint; others become notes.
pub(crate) fn read(
    root: &Element,
    defaults: &Defaults,
    compiler: &Compiler,
    joints: &[Joint],
    notes: &mut Vec<String>,
) -> Result<Vec<Actuator>, CharacterError> {
    let mut actuators = Vec::new();
    for element in root.children_named("actuator").flat_map(|s| &s.children) {
        if !KINDS.contains(&element.name.as_str()) {
            return Err(element.unsupported("kind of actuator"));
        }
        let a = defaults.resolve(element, None)?;
        let Some(target) = a.text("joint").or(a.text("jointinparent")) else {
            notes.push(format!(
                "{}: actuator '{}' does not drive a joint: left out",
                a.at,
                a.text("name").unwrap_or("")
            ));
            continue;
        };
        let joint = joints
            .iter()
            .position(|j| j.name == target)
            .ok_or_else(|| a.invalid("the name of a joint", format!("'{target}'")))?;
        actuators.push(one(&a, &element.name, joint, joints, compiler)?);
    }
    for i in 0..actuators.len() {
        if actuators[i].name.is_empty() {
            actuators[i].name =
                super::names::made_up(format!("actuator{i}"), actuators.iter().map(|a| a.name.as_str()));
        }
    }
    Ok(actuators)
}

fn one(
    a: &Attributes,
    kind: &str,
    joint: usize,
    joints: &[Joint],
    compiler: &Compiler,
) -> Result<Actuator, CharacterError> {
    let servo = kind == "position";
    let mut ctrl_range = a.limits("ctrlrange", "ctrllimited", compiler.autolimits)?;
    let share = a.number("inheritrange")?.filter(|s| servo && *s > 0.0 && a.text("ctrlrange").is_none());
    if let (Some(share), Some((low, high))) = (share, joints[joint].range) {
        let (middle, half) = (0.5 * (low + high), 0.5 * (high - low) * share);
        ctrl_range = Some((middle - half, middle + half));
    }
    Ok(Actuator {
        name: a.text("name").unwrap_or("").to_string(),
        joint,
        gear: a.prefix("gear", [1.0, 0.0, 0.0, 0.0, 0.0, 0.0])?[0],
        ctrl_range,
        force_range: a.limits("forcerange", "forcelimited", compiler.autolimits)?,
        kp: if servo { Some(a.prefix("kp", [1.0, 0.0, 0.0])?[0]) } else { None },
        kv: if servo { Some(a.prefix("kv", [0.0; 3])?[0]) } else { None },
    })
}
