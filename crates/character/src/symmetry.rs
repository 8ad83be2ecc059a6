//! The left-right symmetry of a character: derived from the tree and its geometry, then checked on many poses.

use crate::anatomy::words::{side, without_side};
use crate::error::CharacterError;
use crate::kinematics::Kinematics;
use crate::model::{Body, Character, JointKind};
use crate::rotation::{Mat3, Quat, Vec3, from_wxyz, to_wxyz};

/// Distance of a body from the mirror image of its partner in any pose, as a share of the character's size. Built
/// robots are a little lopsided: a few millimetres per metre.
pub const TOLERANCE: f64 = 0.02;
/// Largest deviation of an axis from the mirror image of its partner (sine of the angle).
const AXIS_TOLERANCE: f64 = 0.05;
/// Poses that are checked.
const POSES: usize = 32;

/// Pairs of joints that mirror each other, with signs.
#[derive(Debug, Clone, PartialEq)]
pub struct Symmetry {
    /// For each scalar joint (in the order of `Character::scalar_joints`), the index of its mirror image.
    pub joint: Vec<usize>,
    /// For each scalar joint, the sign that its mirror image's angle takes.
    pub sign: Vec<f64>,
    /// For each body, the index of its mirror image. Bodies without joints that have no partner are their own.
    pub body: Vec<usize>,
    /// Normal of the mirror plane in the frame of the root body (unit): the y axis for characters whose root's x axis
    /// points forward.
    pub root_normal: Vec3,
}

impl Symmetry {
    /// Returns the pairs bodies by the tree and by where they are, takes the signs from the axes, and checks the
    /// result: in random poses the centre of mass of each body must be its partner's in the mirrored pose, to within
    /// [`TOLERANCE`] of the size.
    ///
    /// # Errors
    /// [`CharacterError::Unfit`] that names what is not symmetric.
    pub fn derive(character: &Character) -> Result<Self, CharacterError> {
        let kinematics = Kinematics::new(character);
        let pairing = Pairing::new(character, &kinematics)?;
        let body = pairing.pair()?;
        let (joint, sign) = pairing.joints(&body)?;
        let root = pairing.root;
        let root_normal = kinematics.body_orientation[root].inverse() * pairing.normal;
        let symmetry = Self { joint, sign, body, root_normal };
        symmetry.check(character, root, pairing.size, &pairing.lonely(&symmetry.body))?;
        Ok(symmetry)
    }

    /// Returns the mirror image of a generalised position across the world's xz plane.
    pub fn mirror_position(&self, character: &Character, q: &[f64]) -> Vec<f64> {
        let mut mirrored = q.to_vec();
        if let Some(root) = character.root_joint() {
            let i = root.q_index;
            mirrored[i + 1] = -q[i + 1];
            if let Some(orientation) = from_wxyz([q[i + 3], q[i + 4], q[i + 5], q[i + 6]]) {
                mirrored[i + 3..i + 7].copy_from_slice(&to_wxyz(&self.mirror_orientation(&orientation)));
            }
        }
        let at: Vec<usize> = character.scalar_joints().map(|j| j.q_index).collect();
        for (i, partner) in self.joint.iter().enumerate() {
            mirrored[at[*partner]] = self.sign[i] * q[at[i]];
        }
        mirrored
    }

    /// Returns the mirror image of a root orientation across the world's xz plane.
    pub fn mirror_orientation(&self, orientation: &Quat) -> Quat {
        let turn = orientation.to_rotation_matrix().into_inner();
        let mirrored = reflection(&Vec3::y()) * turn * reflection(&self.root_normal);
        Quat::from_rotation_matrix(&nalgebra::Rotation3::from_matrix_unchecked(mirrored))
    }

    fn check(&self, character: &Character, root: usize, size: f64, lonely: &[bool]) -> Result<(), CharacterError> {
        let mut pose = Kinematics::new(character);
        let mut image = pose.clone();
        for number in 0..POSES {
            let q = scattered_pose(character, number);
            pose.update(character, &q);
            image.update(character, &self.mirror_position(character, &q));
            for (b, partner) in self.body.iter().enumerate().skip(root) {
                let expected = reflection(&Vec3::y()) * place(character, &pose, b);
                let off = (place(character, &image, *partner) - expected).norm();
                if off > TOLERANCE * size && !lonely[b] {
                    let (name, partner) = (&character.bodies[b].name, &character.bodies[*partner].name);
                    return Err(unfit(
                        character,
                        format!(
                            "not symmetric: in a mirrored pose '{partner}' is {:.1} mm from the mirror image of '{name}' (allowed: {:.1} mm)",
                            off * 1e3,
                            TOLERANCE * size * 1e3
                        ),
                    ));
                }
            }
        }
        Ok(())
    }
}

fn unfit(character: &Character, message: String) -> CharacterError {
    CharacterError::Unfit { character: character.name.clone(), message }
}

/// Returns the position of a body: its centre of mass, as frames are drawn anywhere along a joint's axis.
fn place(character: &Character, kinematics: &Kinematics, body: usize) -> Vec3 {
    let inertial = &character.bodies[body].inertial;
    if inertial.mass > 0.0 { kinematics.point(body, &inertial.com) } else { kinematics.body_position[body] }
}

fn reflection(normal: &Vec3) -> Mat3 {
    Mat3::identity() - normal * normal.transpose() * 2.0
}

/// Returns a pose with every joint somewhere in its range: a fixed sequence that covers the ranges evenly.
fn scattered_pose(character: &Character, number: usize) -> Vec<f64> {
    let mut q = character.reference_position();
    let mut place = 0;
    let mut share = || {
        place += 1;
        // Multiples of the golden ratio are spread evenly over the unit interval.
        ((number * 131 + place) as f64 * 0.618_033_988_749_894_9 + number as f64 * 0.377).fract()
    };
    for joint in &character.joints {
        let i = joint.q_index;
        match joint.kind {
            JointKind::Free => {
                for k in 0..3 {
                    q[i + k] = share() - 0.5;
                }
                let turn = Quat::from_euler_angles(share() * 6.0 - 3.0, share() * 3.0 - 1.5, share() * 6.0 - 3.0);
                q[i + 3..i + 7].copy_from_slice(&to_wxyz(&turn));
            }
            JointKind::Ball => {}
            JointKind::Hinge | JointKind::Slide => {
                let (low, high) = joint.range.unwrap_or((-0.8, 0.8));
                q[i] = low + share() * (high - low);
            }
        }
    }
    q
}

/// Pairs bodies and joints.
struct Pairing<'a> {
    character: &'a Character,
    kinematics: &'a Kinematics,
    root: usize,
    /// Of the mirror plane at the reference position (world).
    normal: Vec3,
    /// Extent of the character (m).
    size: f64,
    /// Flags of bodies that have joints, or carry one that has.
    moves: Vec<bool>,
}

impl<'a> Pairing<'a> {
    fn new(character: &'a Character, kinematics: &'a Kinematics) -> Result<Self, CharacterError> {
        if let Some(ball) = character.joints.iter().find(|j| j.kind == JointKind::Ball) {
            return Err(unfit(character, format!("the mirror image of ball joint '{}' is not implemented", ball.name)));
        }
        let first = (character.bodies.len() > 1).then_some(1);
        let root = character.root_joint().map(|j| j.body).or(first);
        let root = root.ok_or_else(|| unfit(character, "no bodies to be symmetric".into()))?;
        let mut moves = vec![false; character.bodies.len()];
        for (i, body) in character.bodies.iter().enumerate().skip(1).rev() {
            moves[i] |= !body.joints.is_empty();
            moves[body.parent] |= moves[i];
        }
        let origin = kinematics.body_position[root];
        let reach = kinematics.body_position.iter().skip(root).map(|p| (p - origin).norm());
        let size = 2.0 * reach.fold(0.0, f64::max);
        let mut pairing = Self { character, kinematics, root, normal: Vec3::y(), size, moves };
        pairing.normal = pairing.find_normal();
        Ok(pairing)
    }

    /// Returns the direction from the right to the left of the bodies or joints whose names tell; y where no name does.
    fn find_normal(&self) -> Vec3 {
        let named: Vec<(&str, usize)> = self
            .character
            .bodies
            .iter()
            .enumerate()
            .map(|(i, b)| (b.name.as_str(), i))
            .chain(self.character.joints.iter().map(|j| (j.name.as_str(), j.body)))
            .filter(|(name, _)| side(name).is_some())
            .collect();
        let at = |body: usize| place(self.character, self.kinematics, body);
        let mut across = Vec3::zeros();
        for (name, body) in named.iter().filter(|(n, _)| side(n) == Some(crate::anatomy::words::Side::Left)) {
            let stripped = without_side(name);
            let right = named.iter().find(|(n, _)| side(n) != side(name) && without_side(n) == stripped);
            across += right.map_or_else(Vec3::zeros, |(_, partner)| at(*body) - at(*partner));
        }
        let turn = self.kinematics.body_orientation[self.root];
        let local = turn.inverse() * across.try_normalize(1e-9).unwrap_or_else(Vec3::y);
        // Robots are drawn along the axes of their root; the mean of lopsided pairs is not.
        let axis = (0..3).map(|i| Vec3::ith(i, local[i].signum())).find(|a| a.dot(&local) > 0.99);
        turn * axis.unwrap_or(local)
    }

    /// Returns for each body its partner.
    fn pair(&self) -> Result<Vec<usize>, CharacterError> {
        let mut partner: Vec<usize> = (0..self.character.bodies.len()).collect();
        let mut children = vec![Vec::new(); self.character.bodies.len()];
        for (i, body) in self.character.bodies.iter().enumerate().skip(1) {
            children[body.parent].push(i);
        }
        let mut todo = vec![self.root];
        while let Some(body) = todo.pop() {
            let mut free = children[partner[body]].clone();
            for child in &children[body] {
                let cost = |c: &usize| self.cost(*child, *c);
                let best =
                    free.iter().copied().filter(|c| self.alike(*child, *c)).min_by(|a, b| cost(a).total_cmp(&cost(b)));
                match best {
                    Some(best) if self.moves[*child] || self.cost(*child, best) < TOLERANCE => {
                        partner[*child] = best;
                        free.retain(|c| *c != best);
                        todo.push(*child);
                    }
                    _ if !self.moves[*child] => {}
                    _ => {
                        let message = format!("not symmetric: '{}' has no partner", self.name(*child));
                        return Err(unfit(self.character, message));
                    }
                }
            }
        }
        match (0..partner.len()).find(|b| partner[partner[*b]] != *b) {
            None => Ok(partner),
            Some(b) => {
                let message = format!("not symmetric: '{}' has no partner of its own", self.name(b));
                Err(unfit(self.character, message))
            }
        }
    }

    /// Returns the bodies that were left without a partner although they are not in the middle.
    fn lonely(&self, partner: &[usize]) -> Vec<bool> {
        let off = |b: usize| partner[b] == b && !self.moves[b] && self.cost(b, b) > TOLERANCE;
        let mut lonely: Vec<bool> = (0..partner.len()).map(off).collect();
        for (i, body) in self.character.bodies.iter().enumerate().skip(1) {
            lonely[i] |= lonely[body.parent];
        }
        lonely
    }

    fn name(&self, body: usize) -> &str {
        &self.character.bodies[body].name
    }

    /// Returns whether two bodies have joints of the same kinds, and as much hanging on them.
    fn alike(&self, a: usize, b: usize) -> bool {
        let kinds = |body: &Body| self.character.joints[body.joints.clone()].iter().map(|j| j.kind).collect::<Vec<_>>();
        kinds(&self.character.bodies[a]) == kinds(&self.character.bodies[b]) && self.moves[a] == self.moves[b]
    }

    /// Returns the cost of pairing `a` with `b`: distance as a share of the size, and a little where names do not
    /// agree.
    fn cost(&self, a: usize, b: usize) -> f64 {
        let origin = self.kinematics.body_position[self.root];
        let from_plane = |body: usize| place(self.character, self.kinematics, body) - origin;
        let distance = (reflection(&self.normal) * from_plane(a) - from_plane(b)).norm() / self.size.max(1e-9);
        let (name, other) = (self.name(a), self.name(b));
        let opposite = side(name).is_none() || side(name) != side(other);
        let names_agree = opposite && without_side(name) == without_side(other);
        distance + if names_agree { 0.0 } else { 1e-3 }
    }

    /// Returns the partner and sign of each scalar joint.
    fn joints(&self, partner: &[usize]) -> Result<(Vec<usize>, Vec<f64>), CharacterError> {
        let character = self.character;
        let mut place = vec![0; character.joints.len()];
        let mut count = 0;
        for (i, joint) in character.joints.iter().enumerate() {
            if joint.is_scalar() {
                place[i] = count;
                count += 1;
            }
        }
        let (mut joints, mut signs) = (Vec::new(), Vec::new());
        for (i, joint) in character.joints.iter().enumerate() {
            if !joint.is_scalar() {
                continue;
            }
            let within = i - character.bodies[joint.body].joints.start;
            let image = character.bodies[partner[joint.body]].joints.start + within;
            if !character.joints[image].is_scalar() {
                let follower = &character.joints[image].name;
                let message =
                    format!("not symmetric: '{follower}' follows another joint, and '{}' does not", joint.name);
                return Err(unfit(character, message));
            }
            let mirrored = reflection(&self.normal) * self.kinematics.joint_axis[i];
            let axis = self.kinematics.joint_axis[image];
            if mirrored.cross(&axis).norm() > AXIS_TOLERANCE {
                let message = format!(
                    "not symmetric: the axis of '{}' is {:.1} degrees from the mirror image of that of '{}'",
                    character.joints[image].name,
                    mirrored.cross(&axis).norm().min(1.0).asin().to_degrees(),
                    joint.name
                );
                return Err(unfit(character, message));
            }
            // A mirrored turn goes the other way about the mirrored axis; a mirrored shift goes along it.
            let along = mirrored.dot(&axis).signum();
            joints.push(place[image]);
            signs.push(if joint.kind == JointKind::Hinge { -along } else { along });
        }
        Ok((joints, signs))
    }
}
