//! Roles by place in the tree, where names say nothing: the limbs are two pairs of chains of equal bones.
//!
//! Legs hang on the joint that is nearer to the root, arms on the one from which the head goes on. Which of a pair is
//! left only geometry and motion tell.

use lifelike_character::Role;

use super::{ARMS, LEGS, Roles, Tree};

/// Largest difference between the bones of a pair, as a share.
const SAME: f64 = 0.03;

/// A pair of chains that begin at children of one joint.
struct Pair {
    at: usize,
    depth: usize,
    chains: [Vec<usize>; 2],
}

pub(super) fn fill(tree: Tree<'_>, roles: &mut Roles) {
    let all = Chains::new(tree);
    let mut pairs = pairs(tree, &all);
    // Fingers are pairs of nobody's: they hang on another pair's chain.
    let within = |joint: usize, pair: &Pair| {
        super::ancestors(tree.parents, joint).any(|j| pair.chains.iter().any(|chain| chain.first() == Some(&j)))
    };
    let outer: Vec<usize> = (0..pairs.len()).filter(|&p| !pairs.iter().any(|q| within(pairs[p].at, q))).collect();
    let mut at = 0;
    pairs.retain(|_| {
        at += 1;
        outer.contains(&(at - 1))
    });
    pairs.sort_by_key(|pair| pair.depth);
    let [legs, arms] = match pairs.as_slice() {
        // Both on one joint (a root in the chest): legs are the longer ones.
        [a, b, ..] if a.depth == b.depth && reach(tree, &a.chains[0]) < reach(tree, &b.chains[0]) => [b, a],
        [legs, arms, ..] => [legs, arms],
        _ => return,
    };
    for (pair, limbs) in [(legs, LEGS), (arms, ARMS)] {
        for (chain, limb) in pair.chains.iter().zip(limbs) {
            for (role, joint) in limb.into_iter().zip(limb_of(tree, chain)) {
                roles.joints.insert(role, joint);
            }
        }
    }
    for (toe, chain) in roles.toes.iter_mut().zip(&legs.chains) {
        *toe = chain.get(limb_start(tree, chain) + 3).copied();
    }
    let head = all.below(arms.at, &arms.chains.each_ref().map(|chain| chain.first().copied().unwrap_or_default()));
    if let Some(head) = head.last() {
        roles.joints.insert(Role::Head, *head);
    }
    roles.unsided = true;
}

/// Returns the head of a skeleton in which no name tells it: the end of the longest chain from the chest that is no
/// limb's.
pub(super) fn head(tree: Tree<'_>, chest: usize, limbs: &[usize]) -> Option<usize> {
    let branches: Vec<usize> = limbs
        .iter()
        .filter_map(|&limb| super::ancestors(tree.parents, limb).find(|&j| tree.parents[j] == Some(chest)))
        .collect();
    Chains::new(tree).below(chest, &branches).last().copied()
}

/// The longest chain below each joint.
struct Chains {
    /// Children of each joint.
    children: Vec<Vec<usize>>,
    /// Length from a joint's parent through it to the end of its longest chain.
    reach: Vec<f64>,
}

impl Chains {
    fn new(tree: Tree<'_>) -> Self {
        let n = tree.parents.len();
        let mut children = vec![Vec::new(); n];
        let mut reach: Vec<f64> = tree.offsets.iter().map(|offset| offset.norm()).collect();
        for joint in (0..n).rev() {
            let below = children[joint].iter().map(|&c: &usize| reach[c]).fold(0.0, f64::max);
            reach[joint] += below;
            if let Some(parent) = tree.parents[joint] {
                children[parent].push(joint);
            }
        }
        Self { children, reach }
    }

    /// Returns the longest chain below a joint, without it and without some children.
    fn below(&self, joint: usize, without: &[usize]) -> Vec<usize> {
        let longest = |joint: usize, without: &[usize]| {
            let children = self.children[joint].iter().copied().filter(|c| !without.contains(c));
            children.max_by(|&a, &b| self.reach[a].total_cmp(&self.reach[b]))
        };
        std::iter::successors(longest(joint, without), |&j| longest(j, &[])).collect()
    }
}

/// Returns every pair of chains of at least three joints with equal bones.
fn pairs(tree: Tree<'_>, all: &Chains) -> Vec<Pair> {
    let mut pairs = Vec::new();
    for at in 0..tree.parents.len() {
        let chains: Vec<Vec<usize>> = all.children[at]
            .iter()
            .map(|&child| std::iter::once(child).chain(all.below(child, &[])).collect())
            .collect();
        for (i, a) in chains.iter().enumerate() {
            for b in &chains[i + 1..] {
                if a.len() >= 3 && a.len() == b.len() && a.iter().zip(b).all(|(&a, &b)| same(tree, a, b)) {
                    let depth = super::ancestors(tree.parents, at).count();
                    pairs.push(Pair { at, depth, chains: [a.clone(), b.clone()] });
                }
            }
        }
    }
    pairs
}

fn same(tree: Tree<'_>, a: usize, b: usize) -> bool {
    let (a, b) = (tree.offsets[a].norm(), tree.offsets[b].norm());
    (a - b).abs() <= SAME * a.max(b)
}

fn reach(tree: Tree<'_>, chain: &[usize]) -> f64 {
    chain.iter().map(|&j| tree.offsets[j].norm()).sum()
}

/// Returns where a limb begins in its chain: the two bones after it are the longest neighbours.
fn limb_start(tree: Tree<'_>, chain: &[usize]) -> usize {
    let bones = |at: usize| reach(tree, &chain[at + 1..at + 3]);
    (0..chain.len().saturating_sub(2)).max_by(|&a, &b| bones(a).total_cmp(&bones(b)).then(b.cmp(&a))).unwrap_or(0)
}

fn limb_of(tree: Tree<'_>, chain: &[usize]) -> Vec<usize> {
    chain.iter().copied().skip(limb_start(tree, chain)).take(3).collect()
}
