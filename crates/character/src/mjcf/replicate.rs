//! `<replicate>`: copies of what it holds, each moved and turned against the one before.

use crate::error::CharacterError;
use crate::mjcf::attributes::Attributes;
use crate::mjcf::compiler::Compiler;
use crate::mjcf::document::{Element, numbers};
use crate::mjcf::pose::Pose;
use crate::rotation::to_wxyz;

/// More elements than any model has; copies of copies multiply.
const MAX_ELEMENTS: usize = 200_000;

/// Puts `<frame>`s with the copies in place of each `<replicate>` of the tree.
pub(crate) fn expand(root: &mut Element, compiler: &Compiler) -> Result<(), CharacterError> {
    let mut room = MAX_ELEMENTS;
    for world in root.children.iter_mut().filter(|c| c.name == "worldbody") {
        expand_in(world, compiler, &mut room)?;
    }
    Ok(())
}

fn expand_in(element: &mut Element, compiler: &Compiler, room: &mut usize) -> Result<(), CharacterError> {
    for mut child in std::mem::take(&mut element.children) {
        expand_in(&mut child, compiler, room)?;
        if child.name == "replicate" {
            copies(&child, compiler, room, &mut element.children)?;
        } else {
            element.children.push(child);
        }
    }
    Ok(())
}

fn copies(
    replicate: &Element,
    compiler: &Compiler,
    room: &mut usize,
    into: &mut Vec<Element>,
) -> Result<(), CharacterError> {
    let a = Attributes::own(replicate);
    a.only(&["count", "offset", "euler", "sep"])?;
    a.required("count")?;
    let count = a.integer("count", 1, 0..MAX_ELEMENTS as i64)? as usize;
    let size = replicate.children.iter().map(elements).sum::<usize>() + 1;
    *room = room.checked_sub(count.saturating_mul(size)).ok_or_else(|| {
        a.invalid(format!("at most {MAX_ELEMENTS} elements of all copies"), format!("{count} times {size}"))
    })?;
    let mut euler = replicate.clone();
    euler.attributes.retain(|(name, _)| name == "euler");
    let step = Pose {
        position: a.numbers::<3>("offset")?.unwrap_or_default().into(),
        orientation: Pose::read(&Attributes::own(&euler), compiler)?.orientation,
    };
    let digits = count.saturating_sub(1).to_string().len();
    let mut pose = Pose::identity();
    for copy in 0..count {
        let suffix = format!("{}{copy:0digits$}", a.text("sep").unwrap_or(""));
        let mut children = replicate.children.clone();
        children.iter_mut().for_each(|child| rename(child, &suffix));
        let attributes = vec![
            ("pos".into(), numbers(pose.position.as_slice())),
            ("quat".into(), numbers(&to_wxyz(&pose.orientation))),
        ];
        into.push(Element { name: "frame".into(), attributes, children, at: replicate.at.clone() });
        pose = pose.then(&step);
    }
    Ok(())
}

fn elements(element: &Element) -> usize {
    1 + element.children.iter().map(elements).sum::<usize>()
}

fn rename(element: &mut Element, suffix: &str) {
    for (_, value) in element.attributes.iter_mut().filter(|(name, value)| name == "name" && !value.is_empty()) {
        value.push_str(suffix);
    }
    element.children.iter_mut().for_each(|child| rename(child, suffix));
}
