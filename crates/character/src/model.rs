//! The character itself: a constant tree of named parts, in MuJoCo's terms.
//!
//! Generalised coordinates have MuJoCo's layout. A free joint has 7 positions (x y z, then the quaternion `wxyz`). Its
//! 6 velocities are linear in the WORLD frame, then angular in the BODY frame. A ball joint has 4 and 3; hinge and
//! slide have 1 and 1.

use std::collections::BTreeMap;
use std::ops::Range;
use std::path::PathBuf;

use crate::coupling::Coupling;
use crate::error::CharacterError;
use crate::mesh::MeshFile;
use crate::rotation::{Quat, Vec3};

/// A kinematic tree with masses, shapes and named places. Body 0 is the world.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Character {
    /// The model's name.
    pub name: String,
    /// The text it was compiled from, if from MJCF: engines that compile themselves (MuJoCo) get exactly this.
    pub mjcf: Option<String>,
    /// The folder that relative file names of [`Self::mjcf`] start from.
    pub folder: Option<PathBuf>,
    /// Bodies, parents before children. `bodies[0]` is the world.
    pub bodies: Vec<Body>,
    /// Joints in the order of the generalised coordinates.
    pub joints: Vec<Joint>,
    /// Geoms in document order, body after body.
    pub geoms: Vec<Geom>,
    /// Sites in document order, body after body.
    pub sites: Vec<Site>,
    /// Actuators in document order.
    pub actuators: Vec<Actuator>,
    /// Pairs of bodies that never collide (`<contact><exclude>`).
    pub excludes: Vec<(usize, usize)>,
    /// Names of two geoms that MuJoCo lets touch whatever their masks say (`<contact><pair>`).
    pub pairs: Vec<[String; 2]>,
    /// Constraints that close kinematic loops (`<equality>`), in document order.
    pub equalities: Vec<Equality>,
    /// Joints that follow others (`<equality><joint>`, `<mimic>`), in document order.
    pub couplings: Vec<Coupling>,
    /// Position of the keyframe `home`, if there is one (`nq` numbers): the default pose.
    pub home: Option<Vec<f64>>,
    /// Files of meshes by the mesh's name, as far as they are there: what boxes can be fitted to.
    pub meshes: BTreeMap<String, MeshFile>,
    /// Number of generalised positions.
    pub nq: usize,
    /// Number of generalised velocities.
    pub nv: usize,
    /// Gravity (m/s², world).
    pub gravity: Vec3,
    /// Physics time step (s).
    pub timestep: f64,
    /// Parts of the text that are read but not simulated (meshes, cameras, sensors, ...): a line each, for `inspect`.
    pub notes: Vec<String>,
    /// Parts of the text that were meant to matter and could not be had (missing files): a line each, with what to do.
    pub warnings: Vec<String>,
}

/// A rigid body.
#[derive(Debug, Clone, PartialEq)]
pub struct Body {
    /// Unique name (made up as `body<index>` where the text gives none).
    pub name: String,
    /// Index of the parent; the world is its own parent.
    pub parent: usize,
    /// Position in the parent's frame (m).
    pub position: Vec3,
    /// Orientation in the parent's frame.
    pub orientation: Quat,
    /// Mass and inertia.
    pub inertial: Inertial,
    /// Its joints, a range of [`Character::joints`].
    pub joints: Range<usize>,
    /// Gravity compensation, a share of the weight.
    pub gravcomp: f64,
}

/// Mass properties in the body frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Inertial {
    /// Mass (kg).
    pub mass: f64,
    /// Centre of mass (m, body frame).
    pub com: Vec3,
    /// Orientation of the principal axes in the body frame.
    pub orientation: Quat,
    /// Principal moments (kg m²), in MuJoCo's order (descending when it diagonalised them).
    pub diagonal: Vec3,
}

/// Kind of motion of a joint.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum JointKind {
    /// Six degrees of freedom: a floating base.
    Free,
    /// Three rotations.
    Ball,
    /// One translation along the axis.
    Slide,
    /// One rotation about the axis.
    Hinge,
}

impl JointKind {
    /// Returns the number of generalised positions.
    pub fn nq(self) -> usize {
        match self {
            Self::Free => 7,
            Self::Ball => 4,
            Self::Slide | Self::Hinge => 1,
        }
    }
    /// Returns the number of generalised velocities.
    pub fn nv(self) -> usize {
        match self {
            Self::Free => 6,
            Self::Ball => 3,
            Self::Slide | Self::Hinge => 1,
        }
    }
}

/// A joint between a body and its parent.
#[derive(Debug, Clone, PartialEq)]
pub struct Joint {
    /// Unique name (made up as `<body>_free` or `joint<index>` where the text gives none).
    pub name: String,
    /// The body that it moves.
    pub body: usize,
    /// Kind of motion.
    pub kind: JointKind,
    /// Anchor in the body frame (m).
    pub position: Vec3,
    /// Unit axis in the body frame.
    pub axis: Vec3,
    /// Limits (rad or m; for a ball joint the second number is the largest angle). `None`: unlimited.
    pub range: Option<(f64, f64)>,
    /// First generalised position.
    pub q_index: usize,
    /// First generalised velocity.
    pub v_index: usize,
    /// Position at the reference configuration (rad or m).
    pub reference: f64,
    /// Rotor inertia reflected through the gear (kg m² or kg).
    pub armature: f64,
    /// Viscous damping (N m s/rad or N s/m).
    pub damping: f64,
    /// Dry friction (N m or N).
    pub frictionloss: f64,
    /// Spring (N m/rad or N/m).
    pub stiffness: f64,
    /// Rest position of the spring (rad or m).
    pub spring_reference: f64,
    /// Largest actuator force through this joint (`actuatorfrcrange`).
    pub actuator_force_range: Option<(f64, f64)>,
    /// Largest speed of its actuator (rad/s or m/s), where the file says one.
    pub velocity_limit: Option<f64>,
    /// The coupling that sets it, as an index into [`Character::couplings`]; `None` for a joint that moves by itself.
    pub coupling: Option<usize>,
}

impl Joint {
    /// Returns true for a hinge or slide that moves by itself: one that control and motion have a number for.
    pub fn is_scalar(&self) -> bool {
        matches!(self.kind, JointKind::Hinge | JointKind::Slide) && self.coupling.is_none()
    }
}

/// The shape of a geom. Sizes in metres, MuJoCo's meaning (half lengths, radii).
#[derive(Debug, Clone, PartialEq)]
pub enum GeomShape {
    /// The half space below z = 0 of its frame.
    Plane,
    /// Radius.
    Sphere(f64),
    /// Radius, half length along z (without the caps).
    Capsule(f64, f64),
    /// Radius, half length along z.
    Cylinder(f64, f64),
    /// Half lengths.
    Box(Vec3),
    /// Half axes.
    Ellipsoid(Vec3),
    /// A mesh asset by name; a picture only, unless the model says otherwise in [`Character::notes`].
    Mesh(String),
    /// A height field asset by name.
    HeightField(String),
}

/// A shape fixed to a body.
#[derive(Debug, Clone, PartialEq)]
pub struct Geom {
    /// Unique name (made up as `geom<index>` where the text gives none).
    pub name: String,
    /// The body that it belongs to.
    pub body: usize,
    /// The shape.
    pub shape: GeomShape,
    /// Position in the body frame (m).
    pub position: Vec3,
    /// Orientation in the body frame.
    pub orientation: Quat,
    /// Collision bit mask of its own.
    pub contype: u32,
    /// Collision bit mask of what it reacts to.
    pub conaffinity: u32,
    /// Dimensions of the contact's friction (1, 3, 4, 6).
    pub condim: u32,
    /// Sliding, torsional, rolling friction.
    pub friction: [f64; 3],
    /// Constraint solver reference (MuJoCo's `solref`).
    pub solref: [f64; 2],
    /// Constraint solver impedance (MuJoCo's `solimp`).
    pub solimp: [f64; 5],
    /// Contact margin (m).
    pub margin: f64,
    /// Distance beyond the margin at which a contact is already found (m); it has no force there.
    pub gap: f64,
    /// Priority: the parameters of the geom with the higher one win.
    pub priority: i32,
    /// Red, green, blue, opacity.
    pub rgba: [f32; 4],
}

impl Geom {
    /// Returns whether it can touch anything, by its masks.
    pub fn collides(&self) -> bool {
        self.contype != 0 || self.conaffinity != 0
    }
}

/// A named place on a body.
#[derive(Debug, Clone, PartialEq)]
pub struct Site {
    /// Unique name.
    pub name: String,
    /// The body that it belongs to.
    pub body: usize,
    /// Position in the body frame (m).
    pub position: Vec3,
    /// Orientation in the body frame.
    pub orientation: Quat,
}

/// An actuator as MuJoCo compiles it. Its force is `gain · control + bias · (1, length, velocity)`, where length and
/// velocity are the joint's times the gear. The gear times the force acts on the joint.
#[derive(Debug, Clone, PartialEq)]
pub struct Actuator {
    /// Unique name.
    pub name: String,
    /// Tag of its element, such as `position`.
    pub kind: String,
    /// The joint it drives, as an index.
    pub joint: usize,
    /// Gear ratio (first number of `gear`).
    pub gear: f64,
    /// Limits of the control signal.
    pub ctrl_range: Option<(f64, f64)>,
    /// Limits of the force (N m).
    pub force_range: Option<(f64, f64)>,
    /// Force per control.
    pub gain: f64,
    /// Force without control: constant, per length, per velocity.
    pub bias: [f64; 3],
    /// Damping per control, of a `<damper>`.
    pub damper: f64,
}

/// Kind of an equality constraint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum EqualityKind {
    /// The anchors: a ball joint (`<connect>`).
    Connect,
    /// Anchors and orientations (`<weld>`).
    Weld {
        /// Factor on the error of the orientations (m): MuJoCo's `torquescale`.
        torque_scale: f64,
    },
}

/// Two frames on two bodies that a soft constraint holds together: what closes a loop, which a tree cannot say.
#[derive(Debug, Clone, PartialEq)]
pub struct Equality {
    /// Unique name (made up as `equality<index>` where the text gives none).
    pub name: String,
    /// Kind of what it holds together.
    pub kind: EqualityKind,
    /// The two bodies; 0 is the world.
    pub bodies: [usize; 2],
    /// Position of each frame in its body (m).
    pub anchors: [Vec3; 2],
    /// Orientation of each frame in its body; a [`EqualityKind::Connect`] does not use it.
    pub orientations: [Quat; 2],
    /// Constraint solver reference (MuJoCo's `solref`).
    pub solref: [f64; 2],
    /// Constraint solver impedance (MuJoCo's `solimp`).
    pub solimp: [f64; 5],
    /// False for one that does nothing.
    pub active: bool,
}

/// Flags a body and what is fixed to it, through bodies without joints.
pub(crate) fn welded(bodies: &[Body], to: usize) -> Vec<bool> {
    let mut welded = vec![false; bodies.len()];
    welded[to] = true;
    // Children follow their parents, so one pass marks everything.
    for (i, body) in bodies.iter().enumerate().skip(to + 1) {
        welded[i] = welded[body.parent] && body.joints.is_empty();
    }
    welded
}

impl Character {
    /// Returns whether pictures show a geom: visible meshes, and visible shapes unless they collide on a body with meshes.
    pub fn is_drawn(&self, geom: &Geom) -> bool {
        let is_picture = |g: &Geom| g.rgba[3] > 0.0 && matches!(g.shape, GeomShape::Mesh(_));
        let is_covered = || geom.collides() && self.geoms.iter().any(|g| g.body == geom.body && is_picture(g));
        geom.rgba[3] > 0.0 && (is_picture(geom) || !is_covered())
    }

    /// Returns the index of the body with this name.
    pub fn body(&self, name: &str) -> Result<usize, CharacterError> {
        index_of(&self.name, "body", name, self.bodies.iter().map(|b| b.name.as_str()))
    }

    /// Returns the index of the joint with this name.
    pub fn joint(&self, name: &str) -> Result<usize, CharacterError> {
        index_of(&self.name, "joint", name, self.joints.iter().map(|j| j.name.as_str()))
    }

    /// Returns the index of the site with this name.
    pub fn site(&self, name: &str) -> Result<usize, CharacterError> {
        index_of(&self.name, "site", name, self.sites.iter().map(|s| s.name.as_str()))
    }

    /// Returns the index of the geom with this name.
    pub fn geom(&self, name: &str) -> Result<usize, CharacterError> {
        index_of(&self.name, "geom", name, self.geoms.iter().map(|g| g.name.as_str()))
    }

    /// Returns the total mass (kg): of the floating base and all that hangs on it, without what else is in the world.
    pub fn mass(&self) -> f64 {
        let own = self.bodies.iter().enumerate().filter(|(body, _)| self.is_own(*body));
        own.map(|(_, body)| body.inertial.mass).sum()
    }

    /// Returns whether a body is part of the character: of its floating base and all that hangs on it, or of anything where
    /// the character is fixed to the world.
    pub fn is_own(&self, body: usize) -> bool {
        self.root_joint().is_none_or(|root| self.is_below(body, root.body))
    }

    /// Returns whether `body` is `ancestor` or hangs on it; the world is neither.
    pub fn is_below(&self, mut body: usize, ancestor: usize) -> bool {
        while body != 0 && body != ancestor {
            body = self.bodies[body].parent;
        }
        body != 0
    }

    /// Returns the floating base: the first free joint.
    pub fn root_joint(&self) -> Option<&Joint> {
        self.joints.iter().find(|j| j.kind == JointKind::Free)
    }

    /// Returns the root: the body of the floating base, or of a character that is fixed to the world its first body.
    pub fn root_body(&self) -> usize {
        self.root_joint().map_or(usize::from(self.bodies.len() > 1), |joint| joint.body)
    }

    /// Returns the pose of the root of a character that is fixed to the world: where its first body hangs (m, world). It
    /// never changes. `None` with a floating base.
    pub fn fixed_base(&self) -> Option<(Vec3, Quat)> {
        let root = &self.bodies[self.root_body()];
        self.root_joint().is_none().then_some((root.position, root.orientation))
    }

    /// Returns the hinges and slides that move by themselves, in the order of the coordinates: what a motion clip's joint
    /// columns are matched with. Joints that follow others are not among them.
    pub fn scalar_joints(&self) -> impl Iterator<Item = &Joint> {
        self.joints.iter().filter(|j| j.is_scalar())
    }

    /// Returns the generalised position of the text as written: every joint at its reference, bodies where the text put
    /// them.
    pub fn reference_position(&self) -> Vec<f64> {
        let mut q = vec![0.0; self.nq];
        for joint in &self.joints {
            let i = joint.q_index;
            match joint.kind {
                JointKind::Free => {
                    let body = &self.bodies[joint.body];
                    q[i..i + 3].copy_from_slice(body.position.as_slice());
                    q[i + 3..i + 7].copy_from_slice(&crate::rotation::to_wxyz(&body.orientation));
                }
                JointKind::Ball => q[i] = 1.0,
                JointKind::Slide | JointKind::Hinge => q[i] = joint.reference,
            }
        }
        q
    }
}

fn index_of<'a>(
    character: &str,
    kind: &'static str,
    name: &str,
    mut names: impl Iterator<Item = &'a str> + Clone,
) -> Result<usize, CharacterError> {
    let all = names.clone();
    names.position(|n| n == name).ok_or_else(|| CharacterError::UnknownName {
        character: character.to_string(),
        kind,
        name: name.to_string(),
        available: all.collect::<Vec<_>>().join(", "),
    })
}
