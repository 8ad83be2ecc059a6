//! Roles of a captured skeleton's joints: by the words in their names, and where those say nothing by their place in
//! the tree. The one list of names, for readers and retargeting alike.

use std::collections::BTreeMap;

use lifelike_character::{Role, Vec3};

mod place;
mod words;

use words::{Name, Side};

/// Thigh, shank and foot of the left and the right side.
pub(crate) const LEGS: [[Role; 3]; 2] =
    [[Role::LeftThigh, Role::LeftShank, Role::LeftFoot], [Role::RightThigh, Role::RightShank, Role::RightFoot]];
/// Upper arm, forearm and hand of the left and the right side.
pub(crate) const ARMS: [[Role; 3]; 2] = [
    [Role::LeftUpperArm, Role::LeftForearm, Role::LeftHand],
    [Role::RightUpperArm, Role::RightForearm, Role::RightHand],
];

/// A skeleton's tree, as far as roles need it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Tree<'a> {
    pub names: &'a [String],
    pub parents: &'a [Option<usize>],
    /// Offsets from the parents; only lengths are used.
    pub offsets: &'a [Vec3],
}

/// Joints of roles.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Roles {
    pub joints: BTreeMap<Role, usize>,
    /// Joints at the balls of the feet (left, right).
    pub toes: [Option<usize>; 2],
    /// Flag of sides that the names do not tell: which of the two is left is open.
    pub unsided: bool,
}

impl Roles {
    pub fn get(&self, role: Role) -> Option<usize> {
        self.joints.get(&role).copied()
    }

    /// Returns the joints of a limb, if it has all three.
    pub fn limb(&self, roles: [Role; 3]) -> Option<[usize; 3]> {
        Some([self.get(roles[0])?, self.get(roles[1])?, self.get(roles[2])?])
    }

    /// Returns the legs (left, right), if both are there.
    pub fn legs(&self) -> Option<[[usize; 3]; 2]> {
        Some([self.limb(LEGS[0])?, self.limb(LEGS[1])?])
    }

    /// Returns the arms that there are.
    pub fn arms(&self) -> [Option<[usize; 3]>; 2] {
        ARMS.map(|arm| self.limb(arm))
    }

    /// Swaps left and right.
    pub fn mirror(&mut self) {
        for limbs in [LEGS, ARMS] {
            for (left, right) in limbs[0].into_iter().zip(limbs[1]) {
                let (a, b) = (self.joints.remove(&left), self.joints.remove(&right));
                b.map(|joint| self.joints.insert(left, joint));
                a.map(|joint| self.joints.insert(right, joint));
            }
        }
        self.toes.swap(0, 1);
    }
}

/// Finds the roles. `given` are certain.
pub(crate) fn find(tree: Tree<'_>, given: &BTreeMap<Role, usize>) -> Roles {
    let names: Vec<Name> = tree.names.iter().map(|name| Name::read(name)).collect();
    let mut roles = Roles { joints: given.clone(), ..Roles::default() };
    for (side, at) in [(Side::Left, 0), (Side::Right, 1)] {
        let limbs = [
            (LEGS[at], [words::THIGH, words::SHANK, words::FOOT]),
            (ARMS[at], [words::UPPER_ARM, words::FOREARM, words::HAND]),
        ];
        for (limb, parts) in limbs {
            for (role, joint) in by_words(tree, &names, side, limb, parts, given) {
                roles.joints.entry(role).or_insert(joint);
            }
        }
        let foot = roles.get(LEGS[at][2]);
        roles.toes[at] = words::ranked(&names, side, words::TOE)
            .into_iter()
            .find(|&toe| foot.is_none_or(|foot| toe != foot && is_below(tree, toe, foot)));
    }
    if let Some(head) = words::ranked(&names, Side::Middle, words::HEAD).first() {
        roles.joints.entry(Role::Head).or_insert(*head);
    }
    if roles.legs().is_none() && given.is_empty() {
        place::fill(tree, &mut roles);
    }
    for (middle, [left, right]) in
        [(Role::Pelvis, [Role::LeftThigh, Role::RightThigh]), (Role::Chest, [Role::LeftUpperArm, Role::RightUpperArm])]
    {
        if let (Some(a), Some(b)) = (roles.get(left), roles.get(right))
            && let Some(joint) = common_ancestor(tree.parents, a, b)
        {
            roles.joints.entry(middle).or_insert(joint);
        }
    }
    if let (None, Some(chest)) = (roles.get(Role::Head), roles.get(Role::Chest)) {
        let limbs = [LEGS, ARMS].concat();
        let limbs: Vec<usize> = limbs.iter().filter_map(|limb| roles.get(limb[0])).collect();
        let head = place::head(tree, chest, &limbs);
        head.map(|head| roles.joints.insert(Role::Head, head));
    }
    let pelvis = *roles.joints.entry(Role::Pelvis).or_insert(0);
    roles.joints.entry(Role::Chest).or_insert(pelvis);
    roles
}

/// Returns the joints of a limb by their names: of all that fit, the best ranked that form a chain outwards. A limb that
/// is no chain has no joints; one that lacks its last joint has two.
fn by_words(
    tree: Tree<'_>,
    names: &[Name],
    side: Side,
    limb: [Role; 3],
    parts: [&[&str]; 3],
    given: &BTreeMap<Role, usize>,
) -> Vec<(Role, usize)> {
    let candidates = |at: usize| match given.get(&limb[at]) {
        Some(joint) => vec![*joint],
        None => words::ranked(names, side, parts[at]),
    };
    let [first, second, third] = [candidates(0), candidates(1), candidates(2)];
    let below = |joint: usize, above: usize| joint != above && is_below(tree, joint, above);
    for &a in &first {
        for &b in second.iter().filter(|&&b| below(b, a)) {
            if let Some(&c) = third.iter().find(|&&c| below(c, b)) {
                // A shoulder above a joint whose name says nothing: that joint is the upper arm.
                let between = tree.parents[b].filter(|m| *m != a && names[*m].says_nothing());
                let a = between.filter(|_| !given.contains_key(&limb[0])).unwrap_or(a);
                return limb.into_iter().zip([a, b, c]).collect();
            }
        }
    }
    for &a in &first {
        if let Some(&b) = second.iter().find(|&&b| below(b, a)) {
            return limb.into_iter().zip([a, b]).collect();
        }
    }
    Vec::new()
}

/// Returns `joint`, its parent, and so on up to the root.
pub(crate) fn ancestors(parents: &[Option<usize>], joint: usize) -> impl Iterator<Item = usize> + '_ {
    std::iter::successors(Some(joint), |&j| parents[j])
}

fn is_below(tree: Tree<'_>, joint: usize, above: usize) -> bool {
    ancestors(tree.parents, joint).any(|j| j == above)
}

fn common_ancestor(parents: &[Option<usize>], a: usize, b: usize) -> Option<usize> {
    let of_a: Vec<usize> = ancestors(parents, a).skip(1).collect();
    ancestors(parents, b).skip(1).find(|j| of_a.contains(j))
}

/// Returns whether the chain goes outwards: each joint below the one before.
pub(crate) fn goes_outwards(parents: &[Option<usize>], joints: &[usize]) -> bool {
    joints.windows(2).all(|w| w[0] != w[1] && ancestors(parents, w[1]).any(|j| j == w[0]))
}

/// Returns the joint after the last one below a joint, where each joint's descendants follow it in one piece.
pub(crate) fn end_of(parents: &[Option<usize>], joint: usize) -> usize {
    let is_outside = |j: &usize| parents[*j].is_none_or(|parent| parent < joint);
    (joint + 1..parents.len()).find(is_outside).unwrap_or(parents.len())
}

/// Returns the joint that moves as the root. The first joint may be a place in the scene, with the body below it and
/// targets of inverse kinematics beside that. `moves` tells the joints that change their place in their parent's frame,
/// `ends` those on which an end hangs.
pub(crate) fn body_root(tree: Tree<'_>, moves: &[bool], ends: &[usize]) -> usize {
    let roles = find(tree, &BTreeMap::new());
    let legs = roles.legs().into_iter().flatten().flatten();
    let upper: Vec<usize> = roles.arms().into_iter().flatten().flatten().chain(roles.get(Role::Head)).collect();
    let is_known = roles.legs().is_some() && !upper.is_empty();
    let parts: Vec<usize> = legs.chain(upper).collect();
    let mut root = 0;
    loop {
        let children: Vec<usize> = (root + 1..moves.len()).filter(|j| tree.parents[*j] == Some(root)).collect();
        let holds_body =
            |child: usize| is_known && parts.iter().all(|part| (child..end_of(tree.parents, child)).contains(part));
        let is_next = |child: &&usize| {
            let is_only = children.len() == 1 && !ends.contains(&root);
            moves[**child] && (is_only || holds_body(**child))
        };
        match children.iter().find(is_next) {
            Some(child) => root = *child,
            None => return root,
        }
    }
}
