//! The same character with its limbs in another order.

use crate::error::CharacterError;
use crate::mjcf::document::{Element, parse};
use crate::model::Character;

impl Character {
    /// Returns this character with its scalar joints in the given order, which names each of them: bodies that hang on one body
    /// change places, in the text for other engines as well.
    ///
    /// # Errors
    /// [`CharacterError::Unfit`] where no order of the limbs gives that order of the joints.
    pub fn in_joint_order(&self, joints: &[String]) -> Result<Self, CharacterError> {
        let unfit = |message: &str| CharacterError::Unfit { character: self.name.clone(), message: message.into() };
        let text = self.mjcf.as_deref().ok_or_else(|| unfit("expected a character from a text"))?;
        let mut root = parse(text, std::path::Path::new("<reordered>"), None)?.root;
        for world in root.children.iter_mut().filter(|c| c.name == "worldbody") {
            sort(world, joints);
        }
        // Its numbers are in the order of before; the default pose is carried over below.
        root.children.retain(|c| c.name != "keyframe");
        let mut sorted = Self::from_mjcf(&root.to_xml(), "<reordered>", self.folder.as_deref())?;
        if !sorted.scalar_joints().map(|joint| &joint.name).eq(joints) {
            return Err(unfit(&format!("its joints cannot be in the order {}", joints.join(", "))));
        }
        let mut home = self.home.as_ref().map(|_| sorted.reference_position());
        for joint in &mut sorted.joints {
            let Some(old) = self.joints.iter().find(|old| old.name == joint.name) else { continue };
            joint.velocity_limit = old.velocity_limit;
            if let (Some(to), Some(from)) = (&mut home, &self.home) {
                let count = joint.kind.nq();
                to[joint.q_index..joint.q_index + count].copy_from_slice(&from[old.q_index..old.q_index + count]);
            }
        }
        sorted.home = home;
        (sorted.notes, sorted.warnings) = (self.notes.clone(), self.warnings.clone());
        Ok(sorted)
    }
}

/// Sorts the bodies in an element by the first of their joints.
fn sort(element: &mut Element, joints: &[String]) {
    element.children.iter_mut().for_each(|child| sort(child, joints));
    let is_limb = |child: &Element| matches!(child.name.as_str(), "body" | "frame");
    let mut limbs: Vec<Element> = element.children.iter().filter(|child| is_limb(child)).cloned().collect();
    limbs.sort_by_key(|limb| first(limb, joints));
    let mut limbs = limbs.into_iter();
    for place in element.children.iter_mut().filter(|child| is_limb(child)) {
        if let Some(limb) = limbs.next() {
            *place = limb;
        }
    }
}

/// Returns the place in `joints` of the first joint in an element.
fn first(element: &Element, joints: &[String]) -> usize {
    let own = element.attribute("name").filter(|_| element.name == "joint");
    let own = own.and_then(|name| joints.iter().position(|joint| joint == name));
    element.children.iter().map(|child| first(child, joints)).chain(own).min().unwrap_or(usize::MAX)
}
