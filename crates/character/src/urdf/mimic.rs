//! Joints that mimic others (`<mimic>`): of those that move together one has a coordinate, the others are held.
//!
//! Mostly they are fingers of a gripper, which no motion of a body asks for. Where a gear drives a limb, the one that mimics
//! carries it, so the one that stays is not always the one that is mimicked.

use std::collections::{BTreeMap, BTreeSet};

use super::child;
use crate::error::CharacterError;
use crate::mjcf::attributes::Attributes;
use crate::mjcf::document::Element;

/// A joint that mimics carries the robot, and the mimicked one does not, where it moves this many times the mass.
const CARRIES: f64 = 2.0;

/// Joints that are held, and the position of each (rad or m).
#[derive(Debug, Default)]
pub(super) struct Held<'a> {
    positions: BTreeMap<&'a str, f64>,
    /// A line on each group.
    pub warnings: Vec<String>,
}

impl<'a> Held<'a> {
    /// Finds the groups among a robot's joints. `mass` tells how much a joint moves (kg), `None` where nothing of it weighs: a group
    /// of these is left to whoever holds such joints.
    pub fn read(joints: &[&'a Element], mass: impl Fn(&Element) -> Option<f64>) -> Result<Self, CharacterError> {
        let named: BTreeMap<&str, &Element> = joints.iter().filter_map(|j| Some((j.attribute("name")?, *j))).collect();
        let mut groups: BTreeMap<&str, Vec<(&'a str, f64)>> = BTreeMap::new();
        let mut held = Self::default();
        for joint in joints {
            let Some(name) = joint.attribute("name") else { continue };
            if is_mimic(joint) {
                match follow(joint, &named)? {
                    (Ok(leader), position) => groups.entry(leader).or_default().push((name, position)),
                    (Err(unknown), position) => {
                        held.warnings.push(format!("joint '{name}' mimics '{unknown}', which there is not: held"));
                        held.positions.insert(name, position);
                    }
                }
            }
        }
        for (leader, followers) in groups {
            let moved = |name: &str| named.get(name).and_then(|joint| mass(joint)).unwrap_or(-1.0);
            let heaviest = followers.iter().map(|(name, _)| *name).max_by(|a, b| moved(a).total_cmp(&moved(b)));
            let moving = heaviest.filter(|name| moved(name) > CARRIES * moved(leader)).unwrap_or(leader);
            if moved(moving) < 0.0 {
                continue;
            }
            let all = std::iter::once((leader, 0.0)).chain(followers).filter(|(name, _)| *name != moving);
            let all: BTreeMap<&str, f64> = all.collect();
            let names: Vec<&str> = all.keys().copied().collect();
            held.warnings
                .push(format!("joints that move together: only '{moving}' does, held are {}", names.join(", ")));
            held.positions.extend(all);
        }
        Ok(held)
    }

    /// Returns where a joint is held, if it is.
    pub fn position(&self, joint: &Element) -> Option<f64> {
        self.positions.get(joint.attribute("name")?).copied()
    }
}

fn is_mimic(joint: &Element) -> bool {
    joint.attribute("type") != Some("fixed") && child(joint, "mimic").is_some()
}

/// Returns the joint at the end of a chain of mimics, or its name if there is none, and the position of the first while that one is
/// at zero.
fn follow<'a>(
    joint: &'a Element,
    named: &BTreeMap<&str, &'a Element>,
) -> Result<(Result<&'a str, &'a str>, f64), CharacterError> {
    let (mut at, mut factor, mut position) = (joint, 1.0, 0.0);
    let mut seen = BTreeSet::new();
    while let Some(mimic) = child(at, "mimic").filter(|_| is_mimic(at)) {
        let a = Attributes::own(mimic);
        let leader = mimic.attribute("joint").ok_or_else(|| a.invalid("attribute 'joint'", "none"))?;
        position += factor * a.number("offset")?.unwrap_or(0.0);
        factor *= a.number("multiplier")?.unwrap_or(1.0);
        let Some(next) = named.get(leader) else { return Ok((Err(leader), position)) };
        if !seen.insert(leader) {
            return Err(a.invalid("a joint that does not mimic itself", format!("'{leader}'")));
        }
        at = next;
    }
    Ok((Ok(at.attribute("name").unwrap_or_default()), position))
}
