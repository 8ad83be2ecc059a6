//! What of a robot is the same in all environments: the tree, its joints, its contact points.

use lifelike_character::rotation::to_wxyz;
use lifelike_character::{Character, Geom, GeomShape, JointKind};
use lifelike_robot::Robot;

use crate::error::SimError;

/// One degree of freedom.
#[derive(Debug, Clone, PartialEq)]
pub struct Dof {
    pub body: usize,
    /// The dofs that move this one, root first, and itself at the end.
    pub chain: Vec<usize>,
    /// Where its row of the mass matrix begins: one entry per element of `chain`.
    pub row: usize,
    pub armature: f64,
    pub damping: f64,
    pub frictionloss: f64,
}

/// One joint, in constants of the model.
#[derive(Debug, Clone, PartialEq)]
pub struct TreeJoint {
    pub kind: JointKind,
    pub anchor: [f64; 3],
    pub axis: [f64; 3],
    pub q: usize,
    pub v: usize,
    pub reference: f64,
    pub stiffness: f64,
    pub spring_reference: f64,
}

/// One body.
#[derive(Debug, Clone, PartialEq)]
pub struct TreeBody {
    pub parent: usize,
    pub position: [f64; 3],
    /// Row-major rotation in the parent.
    pub rotation: [f64; 9],
    pub joints: Vec<TreeJoint>,
    /// The last dof that moves it; none for what is fixed to the world.
    pub last_dof: Option<usize>,
    pub mass: f64,
    pub com: [f64; 3],
    /// xx, yy, zz, xy, xz, yz about the centre of mass, axes of the body.
    pub inertia: [f64; 6],
}

/// How hard a constraint is: MuJoCo's `solref` and `solimp` in the numbers that a step needs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Softness {
    /// Stiffness of the reference acceleration (1/s²).
    pub stiffness: f64,
    /// Its damping (1/s).
    pub damping: f64,
    /// `solimp`: d0, dmax, width, midpoint, power.
    pub impedance: [f64; 5],
}

impl Softness {
    /// MuJoCo's `mj_makeImpedance`, for both meanings of `solref`; time constants are kept above two time steps.
    pub fn new(solref: [f64; 2], solimp: [f64; 5], timestep: f64) -> Self {
        let clamp = |x: f64| x.clamp(1e-4, 0.9999);
        let impedance = [clamp(solimp[0]), clamp(solimp[1]), solimp[2].max(0.0), clamp(solimp[3]), solimp[4].max(1.0)];
        let dmax = impedance[1];
        let (stiffness, damping) = if solref[0] > 0.0 {
            let (time, ratio) = (solref[0].max(2.0 * timestep), solref[1]);
            (1.0 / (dmax * dmax * time * time * ratio * ratio).max(1e-15), 2.0 / (dmax * time).max(1e-15))
        } else {
            (-solref[0] / (dmax * dmax).max(1e-15), -solref[1] / dmax.max(1e-15))
        };
        Self { stiffness, damping, impedance }
    }
}

/// A shape of the robot that may touch the ground, as the points of it that can.
#[derive(Debug, Clone, PartialEq)]
pub struct GroundShape {
    pub body: usize,
    /// Points in the body frame (m).
    pub points: Vec<[f64; 3]>,
    /// Every point is the centre of a ball of this radius (m).
    pub radius: f64,
    /// Where the shape's middle is in the body frame (m): of a box only corners below it touch (MuJoCo's rule).
    pub middle: Option<[f64; 3]>,
    /// Direction in the body frame that the first tangent follows.
    pub axis: Option<[f64; 3]>,
    pub friction: f64,
    /// Frictionless (`condim` 1).
    pub smooth: bool,
    pub softness: Softness,
    pub margin: f64,
    /// The foot it belongs to.
    pub foot: Option<usize>,
}

/// A limit of a joint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limit {
    pub q: usize,
    pub dof: usize,
    pub low: f64,
    pub high: f64,
    /// The scalar joint it is.
    pub scalar: usize,
}

/// A scalar joint as its actuator needs it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Driven {
    pub q: usize,
    pub v: usize,
}

/// The compiled robot.
#[derive(Debug, Clone, PartialEq)]
pub struct Tree {
    pub nq: usize,
    pub nv: usize,
    /// Entries of the mass matrix.
    pub entries: usize,
    pub bodies: Vec<TreeBody>,
    pub dofs: Vec<Dof>,
    pub limits: Vec<Limit>,
    pub shapes: Vec<GroundShape>,
    pub driven: Vec<Driven>,
    pub feet: usize,
    pub gravity: [f64; 3],
    pub timestep: f64,
    pub substeps: usize,
    pub root_q: usize,
    pub root_v: usize,
    pub root_body: usize,
    /// End effectors, then key bodies: body and point in its frame.
    pub places: Vec<(usize, [f64; 3])>,
    /// Softness of joint limits and dry friction: MuJoCo's default.
    pub joint_softness: Softness,
    /// Height of the ground (m).
    pub ground_height: f64,
}

/// MuJoCo's defaults.
const SOLREF: [f64; 2] = [0.02, 1.0];
const SOLIMP: [f64; 5] = [0.9, 0.95, 0.001, 0.5, 2.0];

impl Tree {
    /// Takes a robot apart.
    ///
    /// # Errors
    /// [`SimError::Model`] for a robot without a free root on a body of the world, or with ground that is not flat.
    pub fn new(robot: &Robot) -> Result<Self, SimError> {
        let character = &robot.character;
        let fail =
            |message: String| SimError::Model { engine: super::ENGINE, character: character.name.clone(), message };
        let timestep = robot.timestep();
        let ground = ground(character).map_err(fail)?;
        let mut tree = Self {
            nq: character.nq,
            nv: character.nv,
            entries: 0,
            bodies: character.bodies.iter().map(|b| body(character, b)).collect(),
            dofs: Vec::new(),
            limits: Vec::new(),
            shapes: Vec::new(),
            driven: character.scalar_joints().map(|j| Driven { q: j.q_index, v: j.v_index }).collect(),
            feet: robot.anatomy.soles.len(),
            gravity: character.gravity.into(),
            timestep,
            substeps: robot.substeps,
            root_q: character.root_joint().map_or(0, |j| j.q_index),
            root_body: character.root_joint().map_or(0, |j| j.body),
            root_v: character.root_joint().map_or(0, |j| j.v_index),
            places: robot.effectors.iter().chain(&robot.key_bodies).map(|(b, p)| (*b, (*p).into())).collect(),
            joint_softness: Softness::new(SOLREF, SOLIMP, timestep),
            ground_height: ground.height,
        };
        tree.add_dofs(character);
        let scalars = character.scalar_joints().enumerate();
        tree.limits = scalars
            .filter_map(|(scalar, j)| {
                j.range.map(|(low, high)| Limit { q: j.q_index, dof: j.v_index, low, high, scalar })
            })
            .collect();
        for geom in character.geoms.iter().filter(|g| g.body != 0 && collides(g, &ground)) {
            tree.shapes.extend(shape(geom, &ground, robot.anatomy.foot_of(character, geom.body), timestep));
        }
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
                    self.dofs.push(Dof {
                        body: b,
                        chain,
                        row,
                        armature: joint.armature,
                        damping: joint.damping,
                        frictionloss: joint.frictionloss,
                    });
                    last = Some(index);
                }
            }
            self.bodies[b].last_dof = last;
        }
    }
}

fn body(character: &Character, body: &lifelike_character::Body) -> TreeBody {
    let rotation = body.orientation.to_rotation_matrix();
    let axes = body.inertial.orientation.to_rotation_matrix();
    let inertia = axes.matrix() * nalgebra::Matrix3::from_diagonal(&body.inertial.diagonal) * axes.matrix().transpose();
    TreeBody {
        parent: body.parent,
        position: body.position.into(),
        rotation: row_major(rotation.matrix()),
        joints: character.joints[body.joints.clone()]
            .iter()
            .map(|j| TreeJoint {
                kind: j.kind,
                anchor: j.position.into(),
                axis: j.axis.into(),
                q: j.q_index,
                v: j.v_index,
                reference: j.reference,
                stiffness: j.stiffness,
                spring_reference: j.spring_reference,
            })
            .collect(),
        last_dof: None,
        mass: body.inertial.mass,
        com: body.inertial.com.into(),
        inertia: [inertia[(0, 0)], inertia[(1, 1)], inertia[(2, 2)], inertia[(0, 1)], inertia[(0, 2)], inertia[(1, 2)]],
    }
}

fn row_major(m: &nalgebra::Matrix3<f64>) -> [f64; 9] {
    std::array::from_fn(|i| m[(i / 3, i % 3)])
}

/// The ground: the model's own plane, or MuJoCo's default one where it has none.
#[derive(Debug, Clone)]
struct Ground {
    height: f64,
    contype: u32,
    conaffinity: u32,
    condim: u32,
    friction: f64,
    solref: [f64; 2],
    solimp: [f64; 5],
    margin: f64,
    gap: f64,
    priority: i32,
}

fn ground(character: &Character) -> Result<Ground, String> {
    let mut found = None;
    for geom in character.geoms.iter().filter(|g| g.body == 0) {
        match geom.shape {
            GeomShape::Plane => {
                let [w, x, y, _] = to_wxyz(&geom.orientation);
                if x.abs() + y.abs() > 1e-9 * w.abs().max(1.0) {
                    return Err(format!("the plane '{}' is not level: this engine has level ground only", geom.name));
                }
                if found.is_some() {
                    return Err(format!("'{}' is a second plane: this engine has one ground", geom.name));
                }
                found = Some(Ground {
                    height: geom.position.z,
                    contype: geom.contype,
                    conaffinity: geom.conaffinity,
                    condim: geom.condim,
                    friction: geom.friction[0],
                    solref: geom.solref,
                    solimp: geom.solimp,
                    margin: geom.margin,
                    gap: geom.gap,
                    priority: geom.priority,
                });
            }
            GeomShape::Mesh(_) => {}
            _ if geom.contype == 0 && geom.conaffinity == 0 => {}
            _ => return Err(format!("'{}' is fixed to the world: this engine has level ground only", geom.name)),
        }
    }
    Ok(found.unwrap_or(Ground {
        height: 0.0,
        contype: 1,
        conaffinity: 1,
        condim: 3,
        friction: 1.0,
        solref: SOLREF,
        solimp: SOLIMP,
        margin: 0.0,
        gap: 0.0,
        priority: 0,
    }))
}

/// MuJoCo's filter.
fn collides(geom: &Geom, ground: &Ground) -> bool {
    (geom.contype & ground.conaffinity) != 0 || (ground.contype & geom.conaffinity) != 0
}

/// The points of a geom that can touch the ground, with the parameters of the pair (`mj_contactParam`).
fn shape(geom: &Geom, ground: &Ground, foot: Option<usize>, timestep: f64) -> Option<GroundShape> {
    let at = |v: lifelike_character::Vec3| -> [f64; 3] { (geom.position + geom.orientation * v).into() };
    let vec = lifelike_character::Vec3::new;
    let (points, radius, middle): (Vec<[f64; 3]>, f64, Option<[f64; 3]>) = match geom.shape {
        GeomShape::Sphere(radius) => (vec![at(vec(0.0, 0.0, 0.0))], radius, None),
        GeomShape::Capsule(radius, half) => (vec![at(vec(0.0, 0.0, half)), at(vec(0.0, 0.0, -half))], radius, None),
        GeomShape::Box(half) => {
            let sign = |i: usize, bit: usize| if i & bit != 0 { 1.0 } else { -1.0 };
            let corner = |i: usize| vec(sign(i, 1) * half.x, sign(i, 2) * half.y, sign(i, 4) * half.z);
            ((0..8).map(|i| at(corner(i))).collect(), 0.0, Some(at(vec(0.0, 0.0, 0.0))))
        }
        // `inspect` lists these: their contact with the ground is not simulated.
        _ => return None,
    };
    let own_wins = geom.priority > ground.priority;
    let ground_wins = geom.priority < ground.priority;
    let pick = |own: f64, other: f64, both: f64| {
        if own_wins {
            own
        } else if ground_wins {
            other
        } else {
            both
        }
    };
    let mean = |a: f64, b: f64| pick(a, b, 0.5 * (a + b));
    let solref = std::array::from_fn(|i| {
        let (a, b) = (geom.solref[i], ground.solref[i]);
        let mixed = if geom.solref[0] > 0.0 && ground.solref[0] > 0.0 { 0.5 * (a + b) } else { a.min(b) };
        pick(a, b, mixed)
    });
    let solimp = std::array::from_fn(|i| mean(geom.solimp[i], ground.solimp[i]));
    let condim = pick(geom.condim.into(), ground.condim.into(), geom.condim.max(ground.condim).into());
    let margin = geom.margin.max(ground.margin) - geom.gap.max(ground.gap);
    Some(GroundShape {
        body: geom.body,
        points,
        radius,
        middle,
        axis: matches!(geom.shape, GeomShape::Capsule(..)).then(|| (geom.orientation * vec(0.0, 0.0, 1.0)).into()),
        friction: pick(geom.friction[0], ground.friction, geom.friction[0].max(ground.friction)),
        smooth: condim < 2.0,
        softness: Softness::new(solref, solimp, timestep),
        margin,
        foot,
    })
}
