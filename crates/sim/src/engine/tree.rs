//! Constants of a robot that all environments share: the tree, its joints, its contact points.

use std::ops::Range;

use lifelike_character::rotation::to_wxyz;
use lifelike_character::{Body, Character, Joint, JointKind, Vec3};
use lifelike_robot::{Robot, level_ground};

use super::closure::Closures;
use super::coupling::Couplings;
use super::dof_chain::{DofChain, Run, runs};
use super::lanes::Scalar;
use super::shapes::{self, GroundShape, Pair, Shape};
use super::surface::{SOLIMP, SOLREF, Softness, Surface};
use crate::error::SimError;

/// One degree of freedom.
#[derive(Debug, Clone, PartialEq)]
pub struct Dof<T> {
    pub body: usize,
    /// The dofs that move this one, root first, and itself at the end.
    pub chain: Vec<usize>,
    /// Start of its row of the mass matrix: one entry per element of `chain`.
    pub row: usize,
    /// Starts of the rows of the dofs that this one moves, nearest first.
    pub descendants: Vec<usize>,
    /// The dofs that move this one, without itself, as runs of neighbours.
    pub ancestors: Vec<Run>,
    pub armature: T,
    pub damping: T,
    pub frictionloss: T,
    /// True where dry friction holds it: `frictionloss`, or that of its actuator under load.
    pub dry: bool,
}

/// One joint, in constants of the model.
#[derive(Debug, Clone, PartialEq)]
pub struct TreeJoint<T> {
    pub kind: JointKind,
    /// None at the body's own origin.
    pub anchor: Option<[T; 3]>,
    pub axis: [T; 3],
    /// The coordinate axis that a hinge turns about; none for an oblique one.
    pub coordinate: Option<usize>,
    /// It turns about the opposite of that axis.
    pub backwards: bool,
    pub q: usize,
    pub v: usize,
    pub reference: T,
}

/// A spring of a joint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spring<T> {
    pub q: usize,
    pub v: usize,
    pub stiffness: T,
    pub reference: T,
}

/// One body.
#[derive(Debug, Clone, PartialEq)]
pub struct TreeBody<T> {
    pub parent: usize,
    pub position: [T; 3],
    /// Row-major rotation in the parent; none where there is none.
    pub rotation: Option<[T; 9]>,
    /// Its joints, a range of [`Tree::joints`].
    pub joints: Range<usize>,
    /// The last dof that moves it; none for what is fixed to the world.
    pub last_dof: Option<usize>,
    pub mass: T,
    pub com: [T; 3],
    /// xx, yy, zz, xy, xz, yz about the centre of mass, axes of the body.
    pub inertia: [T; 6],
}

/// A limit of a joint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limit<T> {
    pub q: usize,
    pub dof: usize,
    pub low: T,
    pub high: T,
}

/// A scalar joint as its actuator needs it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Driven {
    pub q: usize,
    pub v: usize,
}

/// The root, whose pose is an output of its own.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Root<T> {
    /// A floating base: first position and velocity of its joint, and its body.
    Free { q: usize, v: usize, body: usize },
    /// Fixed to the world: position (m) and orientation (wxyz).
    Fixed { position: [T; 3], orientation: [T; 4] },
}

/// The compiled robot.
#[derive(Debug, Clone, PartialEq)]
pub struct Tree<T> {
    pub nq: usize,
    pub nv: usize,
    /// Entries of the mass matrix.
    pub entries: usize,
    pub bodies: Vec<TreeBody<T>>,
    pub joints: Vec<TreeJoint<T>>,
    pub springs: Vec<Spring<T>>,
    pub dofs: Vec<Dof<T>>,
    /// Chain of each dof, then of each pair of bodies that may touch or are held together.
    pub dof_chains: Vec<DofChain>,
    pub limits: Vec<Limit<T>>,
    /// Shapes that may touch the ground.
    pub ground_shapes: Vec<GroundShape<T>>,
    /// Shapes that may touch another part of the robot, and their pairs.
    pub shapes: Vec<Shape<T>>,
    pub pairs: Vec<Pair<T>>,
    /// Welds and ball joints that close loops.
    pub closures: Closures<T>,
    /// Joints that follow others.
    pub couplings: Couplings<T>,
    /// Possible contacts: the ground's points, then those of the pairs.
    pub contacts: usize,
    pub driven: Vec<Driven>,
    /// Number of actuators whose outer torques are kept: all where any has friction under load, else none.
    pub loaded: usize,
    pub feet: usize,
    pub gravity: [T; 3],
    pub timestep: f64,
    pub substeps: usize,
    pub root: Root<T>,
    /// End effectors, then key bodies: body and point in its frame.
    pub sites: Vec<(usize, [T; 3])>,
    /// Softness of joint limits and dry friction: MuJoCo's default.
    pub joint_softness: Softness<T>,
    /// Height of level ground (m).
    pub ground_height: T,
}

impl<T: Scalar> Tree<T> {
    /// Compiles a robot.
    ///
    /// # Errors
    /// [`SimError::Model`] for ground that is not level, and for other things that are fixed to the world.
    pub fn new(robot: &Robot) -> Result<Self, SimError> {
        let character = &robot.character;
        let fail =
            |message: String| SimError::Model { engine: super::ENGINE, character: character.name.clone(), message };
        let timestep = robot.timestep();
        let (height, surface) = ground(character).map_err(fail)?;
        let mut tree = Self {
            nq: character.nq,
            nv: character.nv,
            entries: 0,
            bodies: character.bodies.iter().map(body).collect(),
            joints: character.joints.iter().map(joint).collect(),
            springs: character.joints.iter().filter(|j| j.stiffness != 0.0).map(spring).collect(),
            dofs: Vec::new(),
            dof_chains: Vec::new(),
            limits: Vec::new(),
            ground_shapes: Vec::new(),
            shapes: Vec::new(),
            pairs: Vec::new(),
            closures: Closures::default(),
            couplings: Couplings::default(),
            contacts: 0,
            driven: character.scalar_joints().map(|j| Driven { q: j.q_index, v: j.v_index }).collect(),
            loaded: 0,
            feet: robot.anatomy.soles.len(),
            gravity: numbers(character.gravity.into()),
            timestep,
            substeps: robot.substeps,
            root: root(character),
            sites: robot.effectors.iter().chain(&robot.key_bodies).map(|(b, p)| (*b, numbers((*p).into()))).collect(),
            joint_softness: Softness::new(SOLREF, SOLIMP, timestep),
            ground_height: T::new(height),
        };
        tree.add_dofs(character);
        for (joint, actuator) in tree.driven.iter().zip(&robot.actuators.parameters) {
            if actuator.extended_friction.is_some() {
                tree.dofs[joint.v].dry = true;
                tree.loaded = tree.driven.len();
            }
        }
        tree.dof_chains = tree.dofs.iter().map(|dof| DofChain::of(&dof.chain)).collect();
        tree.limits = character
            .joints
            .iter()
            .filter(|j| j.kind.nq() == 1)
            .filter_map(|j| {
                let (low, high) = j.range?;
                Some(Limit { q: j.q_index, dof: j.v_index, low: T::new(low), high: T::new(high) })
            })
            .collect();
        tree.ground_shapes = shapes::ground_shapes(robot, &surface);
        tree.contacts = tree.ground_shapes.iter().map(|shape| shape.count()).sum();
        let chains: Vec<&[usize]> =
            tree.bodies.iter().map(|b| b.last_dof.map_or(&[][..], |dof| tree.dofs[dof].chain.as_slice())).collect();
        (tree.shapes, tree.pairs) = shapes::pairs(robot, |body| chains[body], &mut tree.dof_chains, &mut tree.contacts);
        tree.closures = Closures::new(robot, |body| chains[body], &mut tree.dof_chains);
        tree.couplings = Couplings::new(robot, &tree.dofs, &mut tree.dof_chains);
        Ok(tree)
    }

    fn add_dofs(&mut self, character: &Character) {
        for (b, body) in character.bodies.iter().enumerate() {
            let mut last = if b == 0 { None } else { self.bodies[body.parent].last_dof };
            for joint in &character.joints[body.joints.clone()] {
                for k in 0..joint.kind.nv() {
                    let index = self.dofs.len();
                    debug_assert_eq!(index, joint.v_index + k);
                    let mut chain = last.map_or_else(Vec::new, |d: usize| self.dofs[d].chain.clone());
                    chain.push(index);
                    let row = self.entries;
                    self.entries += chain.len();
                    for above in &chain[..chain.len() - 1] {
                        self.dofs[*above].descendants.push(row);
                    }
                    self.dofs.push(Dof {
                        body: b,
                        ancestors: runs(&chain[..chain.len() - 1]),
                        chain,
                        row,
                        descendants: Vec::new(),
                        armature: T::new(joint.armature),
                        damping: T::new(joint.damping),
                        frictionloss: T::new(joint.frictionloss),
                        dry: joint.frictionloss > 0.0,
                    });
                    last = Some(index);
                }
            }
            self.bodies[b].last_dof = last;
        }
    }
}

fn root<T: Scalar>(character: &Character) -> Root<T> {
    match (character.root_joint(), character.fixed_base()) {
        (Some(joint), _) => Root::Free { q: joint.q_index, v: joint.v_index, body: joint.body },
        (None, base) => {
            let (position, orientation) = base.unwrap_or_default();
            Root::Fixed { position: numbers(position.into()), orientation: numbers(to_wxyz(&orientation)) }
        }
    }
}

fn numbers<T: Scalar, const N: usize>(values: [f64; N]) -> [T; N] {
    values.map(T::new)
}

fn row_major(m: &nalgebra::Matrix3<f64>) -> [f64; 9] {
    std::array::from_fn(|i| m[(i / 3, i % 3)])
}

fn body<T: Scalar>(body: &Body) -> TreeBody<T> {
    let axes = body.inertial.orientation.to_rotation_matrix();
    let inertia = axes.matrix() * nalgebra::Matrix3::from_diagonal(&body.inertial.diagonal) * axes.matrix().transpose();
    let entries = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)];
    TreeBody {
        parent: body.parent,
        position: numbers(body.position.into()),
        rotation: (body.orientation.angle() > 0.0)
            .then(|| numbers(row_major(body.orientation.to_rotation_matrix().matrix()))),
        joints: body.joints.clone(),
        last_dof: None,
        mass: T::new(body.inertial.mass),
        com: numbers(body.inertial.com.into()),
        inertia: numbers(entries.map(|entry| inertia[entry])),
    }
}

fn joint<T: Scalar>(j: &Joint) -> TreeJoint<T> {
    TreeJoint {
        kind: j.kind,
        anchor: (j.position != Vec3::zeros()).then(|| numbers(j.position.into())),
        axis: numbers(j.axis.into()),
        coordinate: (0..3).find(|k| j.axis[*k].abs() == 1.0),
        backwards: (0..3).any(|k| j.axis[k] == -1.0),
        q: j.q_index,
        v: j.v_index,
        reference: T::new(j.reference),
    }
}

fn spring<T: Scalar>(j: &Joint) -> Spring<T> {
    Spring { q: j.q_index, v: j.v_index, stiffness: T::new(j.stiffness), reference: T::new(j.spring_reference) }
}

/// Height and surface of the ground: the model's own plane, or MuJoCo's default one where it has none.
fn ground(character: &Character) -> Result<(f64, Surface), String> {
    let plane = level_ground(character)?;
    Ok(plane.map_or_else(|| (0.0, Surface::default_ground()), |geom| (geom.position.z, Surface::of(geom))))
}
