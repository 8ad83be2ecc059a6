//! Links and joints as one tree: what hangs on what, and whether all of it hangs on one root.

use std::collections::{BTreeMap, BTreeSet};

use super::child;
use crate::error::CharacterError;
use crate::mjcf::document::Element;

/// Elements of which a link or joint has at most one.
const SINGLE: [&str; 8] = ["inertial", "origin", "parent", "child", "axis", "limit", "dynamics", "mimic"];

/// A robot's links and joints.
pub(super) struct Tree<'a> {
    pub links: BTreeMap<&'a str, &'a Element>,
    /// Joints that hang on a link, in document order.
    pub joints: BTreeMap<&'a str, Vec<&'a Element>>,
    pub root: &'a Element,
}

impl<'a> Tree<'a> {
    /// Reads the tree; refuses links that do not hang on its root.
    pub fn read(robot: &'a Element) -> Result<Self, CharacterError> {
        let mut links = BTreeMap::new();
        for link in robot.children_named("link") {
            single(link)?;
            let name = link.attribute("name").ok_or_else(|| link.invalid("attribute 'name'", "none"))?;
            if links.insert(name, link).is_some() {
                return Err(link.invalid("a link name that is not taken", format!("'{name}'")));
            }
        }
        let mut joints: BTreeMap<&str, Vec<&Element>> = BTreeMap::new();
        let mut parents: BTreeMap<&str, &Element> = BTreeMap::new();
        for joint in robot.children_named("joint") {
            single(joint)?;
            let end = |tag: &'static str| {
                let name = child(joint, tag).and_then(|c| c.attribute("link"));
                let name = name.ok_or_else(|| joint.invalid(format!("<{tag} link=...>"), "none"))?;
                match links.contains_key(name) {
                    true => Ok(name),
                    false => Err(joint.invalid(format!("a known link for <{tag}>"), format!("'{name}'"))),
                }
            };
            let (parent, below) = (end("parent")?, end("child")?);
            if parents.insert(below, joint).is_some() {
                return Err(joint.invalid("a child link that no other joint moves", format!("'{below}'")));
            }
            joints.entry(parent).or_default().push(joint);
        }
        let reached = |root: &'a str| {
            let (mut seen, mut next) = (BTreeSet::from([root]), vec![root]);
            while let Some(link) = next.pop() {
                let below = joints.get(link).into_iter().flatten();
                let below = below.filter_map(|joint| child(joint, "child")?.attribute("link"));
                next.extend(below.filter(|link| seen.insert(link)));
            }
            seen
        };
        let mut roots: Vec<&str> = links.keys().copied().filter(|name| !parents.contains_key(name)).collect();
        roots.sort_by_key(|root| std::cmp::Reverse(reached(root).len()));
        let root = *roots.first().ok_or_else(|| robot.invalid("a link that is no joint's child", "none"))?;
        if let [_, others @ ..] = roots.as_slice()
            && let Some(link) = others.first().and_then(|other| links.get(other))
        {
            let expected = format!("one link that is no joint's child ('{root}' has most links below it)");
            return Err(link.invalid(expected, format!("{} more: {}", others.len(), quoted(others))));
        }
        let reached = reached(root);
        let lost: Vec<&str> = links.keys().copied().filter(|name| !reached.contains(name)).collect();
        if let Some(joint) = lost.first().and_then(|link| parents.get(link)) {
            let expected = format!("links that all hang on the root '{root}'");
            return Err(joint.invalid(expected, format!("a loop of joints that carries {}", quoted(&lost))));
        }
        let root = links.get(root).copied().ok_or_else(|| robot.invalid("a root link", "none"))?;
        Ok(Self { links, joints, root })
    }
}

/// Refuses an element that has one of [`SINGLE`] twice.
fn single(element: &Element) -> Result<(), CharacterError> {
    for name in SINGLE {
        if let Some(second) = element.children_named(name).nth(1) {
            let owner = format!("{} '{}'", element.name, element.attribute("name").unwrap_or_default());
            return Err(second.invalid(format!("one <{name}> in {owner}"), "a second one"));
        }
    }
    Ok(())
}

fn quoted(names: &[&str]) -> String {
    names.iter().map(|name| format!("'{name}'")).collect::<Vec<_>>().join(", ")
}
