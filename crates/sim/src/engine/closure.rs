//! Equality constraints: welds and ball joints that close loops (MuJoCo's `mj_instantiateEquality`).
//!
//! Two frames on two bodies are held together. With anchors p_1, p_2 and orientations q_1, q_2 the violation is p_1 -
//! p_2 and, for a weld, s x. Here (w, x) = conj(q_2) q_1 and s is a length that makes it one (MuJoCo's `torquescale`).
//! It changes by v_1(p_1) - v_2(p_2) and ½ s (w ω + ω × x). Here ω is the rotation of the first frame against the
//! second, in the axes of the second. [`super::closure_rows`] solves for the forces along these rows.

use lifelike_character::EqualityKind;
use lifelike_robot::Robot;

use super::dof_chain::DofChain;
use super::lanes::{Lanes, Scalar};
use super::rigid_body::RigidBodyDynamics;
use super::row_block::Groups;
use super::spatial::{
    Mat3, Spatial, Vec3, accumulate, add, along, column, cross, dot, matrix_quaternion, product_constant, rotate,
    rotate_constant, sub, velocity_at,
};
use super::surface::Softness;

/// One constraint, in constants of the model.
#[derive(Debug, Clone, PartialEq)]
pub struct Closure<T> {
    pub bodies: [usize; 2],
    /// In the frames of the bodies (m).
    anchors: [[T; 3]; 2],
    /// None for a ball joint.
    pub weld: Option<Weld<T>>,
    /// The dofs that move one body against the other.
    pub dof_chain: usize,
    pub softness: Softness<T>,
}

/// Parts of a weld besides the anchors.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Weld<T> {
    /// Row-major orientations in the bodies.
    axes: [[T; 9]; 2],
    /// Violation per vector part of a quaternion (m).
    scale: T,
}

/// All constraints of a robot.
#[derive(Debug, Clone, PartialEq)]
pub struct Closures<T> {
    pub list: Vec<Closure<T>>,
    /// Three rows of the anchors, and three of the orientations of a weld.
    pub triples: Groups<3>,
}

impl<T> Default for Closures<T> {
    fn default() -> Self {
        Self { list: Vec::new(), triples: Groups::default() }
    }
}

impl<T: Scalar> Closures<T> {
    /// Those of a robot that are active and have something to hold. `chain` are the dofs that move a body; dof chains that are
    /// not there are added.
    pub fn new<'a>(robot: &Robot, chain: impl Fn(usize) -> &'a [usize], dof_chains: &mut Vec<DofChain>) -> Self {
        let mut closures = Self::default();
        for equality in robot.character.equalities.iter().filter(|e| e.active) {
            let dof_chain = DofChain::between(chain(equality.bodies[0]), chain(equality.bodies[1]));
            // What moves both bodies moves neither against the other.
            if dof_chain.len() == dof_chain.shared {
                continue;
            }
            let index = dof_chains.iter().position(|c| *c == dof_chain).unwrap_or_else(|| {
                dof_chains.push(dof_chain);
                dof_chains.len() - 1
            });
            let weld = match equality.kind {
                EqualityKind::Connect => None,
                EqualityKind::Weld { torque_scale } => Some(Weld {
                    axes: equality.orientations.map(|q| {
                        let matrix = q.to_rotation_matrix();
                        std::array::from_fn(|i| T::new(matrix.matrix()[(i / 3, i % 3)]))
                    }),
                    scale: T::new(torque_scale),
                }),
            };
            for _ in 0..if weld.is_some() { 2 } else { 1 } {
                closures.triples.add(index, dof_chains);
            }
            closures.list.push(Closure {
                bodies: equality.bodies,
                anchors: equality.anchors.map(|p| [T::new(p.x), T::new(p.y), T::new(p.z)]),
                weld,
                dof_chain: index,
                softness: Softness::new(equality.solref, equality.solimp, robot.timestep()),
            });
        }
        closures
    }

    /// Returns whether something holds the orientation of a body.
    pub fn turn(&self, body: usize) -> bool {
        self.list.iter().any(|c| c.weld.is_some() && c.bodies.contains(&body))
    }
}

/// The two frames of a constraint.
pub struct Frames<V: Lanes> {
    /// Anchors, from the root's position (m).
    pub points: [Vec3<V>; 2],
    pub turn: Option<Turn<V>>,
}

/// Rotation of a weld.
pub struct Turn<V: Lanes> {
    /// Axes of the second frame.
    axes: Mat3<V>,
    /// The first frame seen from the second: a quaternion `wxyz`.
    error: [V; 4],
    scale: V,
}

impl<V: Lanes> Turn<V> {
    /// The violation (m).
    #[inline(always)]
    pub fn violation(&self) -> Vec3<V> {
        [self.error[1] * self.scale, self.error[2] * self.scale, self.error[3] * self.scale]
    }

    /// Returns its rate when the first frame turns against the second (axes of the world).
    #[inline(always)]
    pub fn rate(&self, angular: &Vec3<V>) -> Vec3<V> {
        let own = [0, 1, 2].map(|k| dot(&column(&self.axes, k), angular));
        self.halved(&own, &cross(&own, &self.vector()))
    }

    /// Returns the change of the rate by velocities alone: its derivative less what accelerations of dofs are to it.
    #[inline(always)]
    pub fn drift(&self, first: &Motion<V>, second: &Motion<V>) -> Vec3<V> {
        let relative = sub(&angular(&first.velocity), &angular(&second.velocity));
        // The axes turn with the second body.
        let change = sub(&angular(&first.acceleration), &angular(&second.acceleration));
        let change = sub(&change, &cross(&angular(&second.velocity), &relative));
        let share = self.scale * V::splat_f64(0.25) * dot(&relative, &relative);
        along(&self.rate(&change), &self.vector(), -share)
    }

    /// The torque on the first body of forces along the rows (axes of the world): the transpose of [`Self::rate`].
    #[inline(always)]
    fn torque(&self, forces: &Vec3<V>) -> Vec3<V> {
        rotate(&self.axes, &self.halved(forces, &cross(&self.vector(), forces)))
    }

    #[inline(always)]
    fn vector(&self) -> Vec3<V> {
        [self.error[1], self.error[2], self.error[3]]
    }

    /// ½ s (w a + b).
    #[inline(always)]
    fn halved(&self, a: &Vec3<V>, b: &Vec3<V>) -> Vec3<V> {
        let half = self.scale * V::splat_f64(0.5);
        [0, 1, 2].map(|k| half * b[k].add_mul(self.error[0], a[k]))
    }
}

/// Velocity of a body, and its acceleration where no dof accelerates.
pub struct Motion<V: Lanes> {
    pub velocity: Spatial<V>,
    acceleration: Spatial<V>,
}

impl<V: Lanes> Motion<V> {
    #[inline(always)]
    pub fn of(dynamics: &RigidBodyDynamics<V>, body: usize) -> Self {
        // Gravity is in it as the ground's acceleration, and is the same for two bodies.
        Self { velocity: dynamics.velocity[body], acceleration: dynamics.acceleration[body] }
    }

    /// The acceleration of one of its points.
    #[inline(always)]
    pub fn drift(&self, point: &Vec3<V>) -> Vec3<V> {
        let turning = cross(&angular(&self.velocity), &velocity_at(&self.velocity, point));
        add(&velocity_at(&self.acceleration, point), &turning)
    }
}

#[inline(always)]
pub fn angular<V: Lanes>(motion: &Spatial<V>) -> Vec3<V> {
    [motion[0], motion[1], motion[2]]
}

impl<T: Scalar> Closure<T> {
    #[inline(always)]
    pub fn frames<V: Lanes<Scalar = T>>(&self, dynamics: &RigidBodyDynamics<V>) -> Frames<V> {
        let [a, b] = self.bodies;
        let point = |k: usize, body: usize| {
            add(&dynamics.position[body], &rotate_constant(&dynamics.rotation[body], &self.anchors[k]))
        };
        let turn = self.weld.map(|weld| {
            let first = product_constant(&dynamics.rotation[a], &weld.axes[0]);
            let axes = product_constant(&dynamics.rotation[b], &weld.axes[1]);
            let relative = std::array::from_fn(|i| dot(&column(&axes, i / 3), &column(&first, i % 3)));
            Turn { axes, error: matrix_quaternion(&relative), scale: V::splat(weld.scale) }
        });
        Frames { points: [point(0, a), point(1, b)], turn }
    }
}

impl<T: Scalar> Closures<T> {
    /// Adds the wrenches of forces along all rows to those on each body, about the root's position; what acts on the world is
    /// left out.
    #[inline(always)]
    pub fn wrenches<V: Lanes<Scalar = T>>(
        &self,
        dynamics: &RigidBodyDynamics<V>,
        forces: &[V],
        out: &mut [Spatial<V>],
    ) {
        let mut triples = forces.as_chunks::<3>().0.iter();
        for closure in &self.list {
            let zero = [V::zero(); 3];
            let Frames { points, turn } = closure.frames(dynamics);
            let force = triples.next().unwrap_or(&zero);
            let torque = turn.map_or(zero, |turn| turn.torque(triples.next().unwrap_or(&zero)));
            let about_root = |point: &Vec3<V>| {
                let torque = add(&torque, &cross(point, force));
                [torque[0], torque[1], torque[2], force[0], force[1], force[2]]
            };
            let [a, b] = closure.bodies;
            accumulate(&mut out[a], &about_root(&points[0]));
            accumulate(&mut out[b], &about_root(&points[1]).map(|x| -x));
        }
        out[0] = [V::zero(); 6];
    }
}
