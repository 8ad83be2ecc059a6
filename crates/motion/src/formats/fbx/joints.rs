//! The joints of a scene: its bones, and the pose in which they were bound.

use lifelike_character::{Quat, Vec3};
use ufbx::{Node, Scene};

/// More joints than any skeleton of a body with fingers and a face has.
const MOST_JOINTS: usize = 1000;
/// More nodes than any scene with one body has.
const MOST_NODES: usize = 100_000;

/// A skeleton of a scene, each joint before those below it and with them in one piece.
pub(super) struct Joints<'a> {
    pub nodes: Vec<&'a Node>,
    pub names: Vec<String>,
    pub parents: Vec<Option<usize>>,
    /// Joints that only end a chain.
    pub ends: Vec<usize>,
    /// World rotations in the bind pose, if there is one.
    bind: Option<Vec<Quat>>,
}

impl<'a> Joints<'a> {
    /// Finds the skeleton.
    ///
    /// # Errors
    /// Expected and got, for a scene without bones, with two skeletons, or with too many nodes.
    pub(super) fn find(scene: &'a Scene, notes: &mut Vec<String>) -> Result<Self, (String, String)> {
        if scene.nodes.count > MOST_NODES {
            return Err((format!("at most {MOST_NODES} nodes"), scene.nodes.count.to_string()));
        }
        let tops = tops(scene);
        let mut trees: Vec<Vec<(&Node, Option<usize>)>> = tops.into_iter().map(below).collect();
        trees.sort_by_key(|tree| std::cmp::Reverse(tree.len()));
        let Some(tree) = trees.first() else {
            let got = format!("{} nodes without one: export the armature with the animation", scene.nodes.count);
            return Err(("bones of a skeleton".to_owned(), got));
        };
        let others = &trees[1..];
        if let Some(other) = others.first().filter(|other| 2 * other.len() > tree.len()) {
            let got = format!("'{}' and '{}'", &*tree[0].0.element.name, &*other[0].0.element.name);
            return Err(("one skeleton (write each into a file of its own)".to_owned(), got));
        }
        if !others.is_empty() {
            let names: Vec<&str> = others.iter().take(5).map(|tree| &*tree[0].0.element.name).collect();
            notes.push(format!("bones beside the skeleton were left out: {}", names.join(", ")));
        }
        if tree.len() > MOST_JOINTS {
            return Err((format!("at most {MOST_JOINTS} joints"), tree.len().to_string()));
        }
        let nodes: Vec<&Node> = tree.iter().map(|(node, _)| *node).collect();
        let names: Vec<String> = nodes.iter().map(|node| node.element.name.to_string()).collect();
        if let Some(at) = (1..names.len()).find(|at| names[..*at].contains(&names[*at])) {
            return Err(("names of joints that no other has".to_owned(), format!("'{}' twice", names[at])));
        }
        let parents: Vec<Option<usize>> = tree.iter().map(|(_, parent)| *parent).collect();
        let is_end = |joint: &usize| {
            let name = names[*joint].to_ascii_lowercase();
            (name.ends_with("_end") || name.ends_with("nub")) && !parents.contains(&Some(*joint))
        };
        let ends = (0..names.len()).filter(is_end).collect();
        let mut joints = Self { nodes, names, parents, ends, bind: None };
        joints.bind = joints.find_bind(scene);
        if joints.bind.is_none() {
            notes.push("the file has no bind pose: the standing pose was found from the motion".to_owned());
        }
        Ok(joints)
    }

    /// Returns the world rotations of all joints in the bind pose. A joint without one, such as the end of a chain, goes on
    /// as its parent.
    fn find_bind(&self, scene: &Scene) -> Option<Vec<Quat>> {
        let poses: Vec<&ufbx::BonePose> =
            scene.poses.into_iter().filter(|pose| pose.is_bind_pose).flat_map(|pose| &pose.bone_poses).collect();
        let bound = |node: &Node| {
            let pose = poses.iter().find(|pose| pose.bone_node.element.element_id == node.element.element_id)?;
            rotation(ufbx::matrix_to_transform(&pose.bone_to_world).rotation)
        };
        let mut bind: Vec<Quat> = Vec::with_capacity(self.nodes.len());
        for (joint, node) in self.nodes.iter().enumerate() {
            let above = self.parents[joint].map(|parent| bind[parent]);
            let own = rotation(node.local_transform.rotation);
            bind.push(bound(node).or_else(|| Some(above? * own?))?);
        }
        Some(bind)
    }

    /// Returns the rotations that the joints made since the bind pose; world rotations where there is none.
    pub(super) fn aligned(&self, turns: &[Quat]) -> Vec<Quat> {
        match &self.bind {
            Some(bind) => turns.iter().zip(bind).map(|(turn, bind)| turn * bind.inverse()).collect(),
            None => turns.to_vec(),
        }
    }
}

/// Returns the bones without a bone above; nulls in their place where a scene has no bones.
fn tops(scene: &Scene) -> Vec<&Node> {
    let has_bones = scene.bones.count > 0;
    let is_joint = |node: &Node| if has_bones { is_bone(node) } else { is_null(node) };
    let is_top = |node: &&Node| {
        let mut above = node.parent.as_deref();
        while let Some(parent) = above.filter(|parent| !is_joint(parent)) {
            above = parent.parent.as_deref();
        }
        is_joint(node) && above.is_none()
    };
    scene.nodes.into_iter().filter(is_top).collect()
}

/// Returns whether a node is a bone. The library puts a helper without a name below a bone whose scale goes another way
/// than its turn. The helper carries what makes it a bone.
fn is_bone(node: &Node) -> bool {
    let below = node.scale_helper.as_deref().is_some_and(|helper| helper.bone.is_some());
    !node.is_scale_helper && (node.bone.is_some() || below)
}

/// Returns whether a node is a null, as some programs write joints.
fn is_null(node: &Node) -> bool {
    !node.is_root
        && !node.is_scale_helper
        && matches!(node.attrib_type, ufbx::ElementType::Empty | ufbx::ElementType::Unknown)
}

/// Returns a joint and those below it, with the place of each one's parent. Nodes that are no joints are passed through.
fn below(top: &Node) -> Vec<(&Node, Option<usize>)> {
    let by_null = !is_bone(top);
    let mut tree = Vec::new();
    let mut open = vec![(top, None)];
    while let Some((node, parent)) = open.pop() {
        let is_joint = if by_null { is_null(node) } else { is_bone(node) };
        let above = if is_joint {
            tree.push((node, parent));
            Some(tree.len() - 1)
        } else {
            parent
        };
        let children: Vec<&Node> = node.children.into_iter().collect();
        open.extend(children.into_iter().rev().map(|child| (child, above)));
    }
    tree
}

/// Returns a rotation; `None` for numbers that are none.
pub(super) fn rotation(q: ufbx::Quat) -> Option<Quat> {
    lifelike_character::rotation::from_wxyz([q.w, q.x, q.y, q.z])
}

/// Returns a vector.
pub(super) fn vector(v: ufbx::Vec3) -> Vec3 {
    Vec3::new(v.x, v.y, v.z)
}
