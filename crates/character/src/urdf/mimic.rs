//! Joints that mimic others (`<mimic>`) as equality constraints: of those that move together one leads.
//!
//! Mostly they are fingers of a gripper. A gear that drives a limb is carried by the joint that mimics, so the leader
//! is not always the mimicked one: the leader has the actuator, and motion has a number for it.

use std::collections::BTreeMap;

use super::{child, element};
use crate::error::CharacterError;
use crate::mjcf::attributes::Attributes;
use crate::mjcf::document::{Element, numbers};

/// A joint that mimics leads where it moves this many times the mass of the one that it mimics.
const CARRIES: f64 = 2.0;

/// A position as a number and a share of the leader's position.
type Line = [f64; 2];

/// Joints that follow others, and those that are held because nothing leads them.
#[derive(Debug, Default)]
pub(super) struct Mimics<'a> {
    /// Leader of each follower, and the follower's position (rad or m).
    followers: BTreeMap<&'a str, (&'a str, Line)>,
    /// Positions of joints that are held (rad or m).
    held: BTreeMap<&'a str, f64>,
    /// A line on each that is held, and on each group whose leader mimics.
    pub warnings: Vec<String>,
}

impl<'a> Mimics<'a> {
    /// Finds the groups among a robot's joints. `mass` returns what a joint moves (kg), `None` where nothing of it weighs: a group
    /// of these is left to whoever holds such joints.
    pub fn read(joints: &[&'a Element], mass: impl Fn(&Element) -> Option<f64>) -> Result<Self, CharacterError> {
        let named: BTreeMap<&str, &Element> = joints.iter().filter_map(|j| Some((j.attribute("name")?, *j))).collect();
        let mut groups: BTreeMap<&str, Vec<(&'a str, Line)>> = BTreeMap::new();
        let mut mimics = Self::default();
        for joint in joints {
            let Some(name) = joint.attribute("name") else { continue };
            if !is_mimic(joint) {
                continue;
            }
            let (leader, line) = trace(joint, &named)?;
            match named.get(leader) {
                Some(found) if found.attribute("type") != Some("fixed") => {
                    groups.entry(leader).or_default().push((name, line));
                }
                found => {
                    let why = if found.is_some() { "is fixed" } else { "there is not" };
                    mimics.warnings.push(format!("joint '{name}' mimics '{leader}', which {why}: held"));
                    mimics.held.insert(name, line[0]);
                }
            }
        }
        for (mimicked, followers) in groups {
            let moved = |name: &str| named.get(name).and_then(|joint| mass(joint)).unwrap_or(-1.0);
            let turns = followers.iter().filter(|(_, line)| line[1] != 0.0);
            let heaviest = turns.max_by(|(a, _), (b, _)| moved(a).total_cmp(&moved(b)));
            let carrier = heaviest.filter(|(name, _)| moved(name) > CARRIES * moved(mimicked));
            let (leader, [offset, share]) = carrier.copied().unwrap_or((mimicked, [0.0, 1.0]));
            if moved(leader) < 0.0 {
                continue;
            }
            if leader != mimicked {
                mimics
                    .warnings
                    .push(format!("joint '{leader}' carries more than '{mimicked}', which it mimics: it leads"));
            }
            // The mimicked joint by the leader, then all others by that.
            let back = [-offset / share, 1.0 / share];
            let all = std::iter::once((mimicked, [0.0, 1.0])).chain(followers).filter(|(name, _)| *name != leader);
            for (name, [a, b]) in all {
                mimics.followers.insert(name, (leader, [a + b * back[0], b * back[1]]));
            }
        }
        Ok(mimics)
    }

    /// Returns where a joint is held, if it is.
    pub fn held(&self, joint: &Element) -> Option<f64> {
        self.held.get(joint.attribute("name")?).copied()
    }

    /// Returns the constraints in MJCF, as far as `moves` says that both joints of them do. `robot` is where errors point to.
    pub fn constraints(&self, robot: &Element, moves: impl Fn(&str) -> bool) -> Element {
        let mut section = element(robot, "equality", &[]);
        for (follower, (leader, [offset, share])) in &self.followers {
            if moves(follower) && moves(leader) {
                let polynomial = numbers(&[*offset, *share, 0.0, 0.0, 0.0]);
                let attributes =
                    [("joint1", follower.to_string()), ("joint2", leader.to_string()), ("polycoef", polynomial)];
                section.children.push(element(robot, "joint", &attributes));
            }
        }
        section
    }
}

fn is_mimic(joint: &Element) -> bool {
    joint.attribute("type") != Some("fixed") && child(joint, "mimic").is_some()
}

/// Returns the name at the end of a chain of mimics, and the first joint's position by that one's.
fn trace<'a>(joint: &'a Element, named: &BTreeMap<&str, &'a Element>) -> Result<(&'a str, Line), CharacterError> {
    let (mut at, mut line) = (joint, [0.0, 1.0]);
    let mut seen: Vec<&str> = Vec::new();
    while let Some(mimic) = child(at, "mimic").filter(|_| is_mimic(at)) {
        let a = Attributes::own(mimic);
        let leader = mimic.attribute("joint").ok_or_else(|| a.invalid("attribute 'joint'", "none"))?;
        line[0] += line[1] * a.number("offset")?.unwrap_or(0.0);
        line[1] *= a.number("multiplier")?.unwrap_or(1.0);
        let Some(next) = named.get(leader) else { return Ok((leader, line)) };
        if let Some(start) = seen.iter().position(|name| *name == leader) {
            let circle = [&seen[start..], &[leader]].concat().join("' mimics '");
            return Err(a.invalid("joints that do not mimic each other in a circle", format!("'{circle}'")));
        }
        seen.push(leader);
        at = next;
    }
    Ok((at.attribute("name").unwrap_or_default(), line))
}
