//! What limits motion: joint limits, dry friction, the ground. MuJoCo's convex model, solved by projected Gauss-Seidel.
//!
//! Each constraint row r has a Jacobian J_r, a reference acceleration a*_r = -b v_r - k i d_r (violation d_r, impedance i)
//! and a regularization R_r = (1 - i) / i · Â_r. Forces minimise ½ fᵀ(A + R)f + fᵀ(J a₀ - a*), A = J M⁻¹ Jᵀ, within their
//! bounds (MuJoCo documentation, "Computation"). A contact with friction is a pyramid of four edges J_n ± μ J_t whose
//! forces are not negative.
//!
//! In the coordinates u = D^(1/2) L a (M = Lᵀ D L) the matrix is Y Yᵀ with rows y_r = D^(-1/2) L^(-T) J_rᵀ that have
//! entries on one chain of the tree only. So a row is visited by one scalar product and one update of u, and A is never
//! formed. [`SWEEPS`] visits of all rows per step, each contact solved [`INNER`] times within itself, started from the
//! forces of the step before: fixed, so that every environment does the same. `tests/oracle_engine.rs` says how far
//! that is from MuJoCo's converged forces, and that a hundred sweeps arrive there.

use super::dynamics::Workspace;
use super::lane::{Lane, Scalar};
use super::spatial::{Vec3, add, rotate, vector};
use super::tree::{Softness, Tree};
use lifelike_robot::actuator::Number;

/// Visits of all rows per physics step, where nobody says otherwise.
pub const SWEEPS: usize = 12;
/// Visits of a contact's four edges per visit of the contact.
pub const INNER: usize = 2;
/// How much further than to its own optimum an edge's force goes (successive over-relaxation): the four corners of a
/// sole share their load, and plain Gauss-Seidel shifts it between them slowly. Without it, and with 8 sweeps, a box at 98%
/// of its friction angle slid at 5.9 cm/s that creeps at 0.6 in MuJoCo.
const RELAXATION: f64 = 1.3;

/// Inverse weights at the reference position (MuJoCo's `invweight0`), which scale the regularization.
#[derive(Debug, Clone)]
pub struct InverseWeights<T: Scalar, const W: usize> {
    /// Of each body's centre of mass, translation (1/kg).
    pub body: Vec<Lane<T, W>>,
    /// Of each dof.
    pub dof: Vec<Lane<T, W>>,
}

/// Forces of every possible row, kept from step to step.
#[derive(Debug, Clone)]
pub struct Forces<T: Scalar, const W: usize> {
    /// Dry friction of each dof.
    pub friction: Vec<Lane<T, W>>,
    /// Each limit; positive pushes away from the limit.
    pub limit: Vec<Lane<T, W>>,
    /// The side of each limit: 1 at the lower, -1 at the upper.
    pub side: Vec<Lane<T, W>>,
    /// Edges of each ground point's pyramid.
    pub contact: Vec<[Lane<T, W>; 4]>,
}

impl<T: Scalar, const W: usize> Forces<T, W> {
    pub fn new(tree: &Tree) -> Self {
        let zero = Lane::zero();
        let points = tree.shapes.iter().map(|s| s.points.len()).sum();
        Self {
            friction: vec![zero; tree.nv],
            limit: vec![zero; tree.limits.len()],
            side: vec![zero; tree.limits.len()],
            contact: vec![[zero; 4]; points],
        }
    }

    /// Every number, in a fixed order: for saving, and for bringing one environment back.
    pub fn numbers_mut(&mut self) -> impl Iterator<Item = &mut Lane<T, W>> {
        let ends = self.friction.iter_mut().chain(&mut self.limit).chain(&mut self.side);
        ends.chain(self.contact.iter_mut().flatten())
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.friction.len() + self.limit.len() + self.side.len() + 4 * self.contact.len()
    }
}

/// One bounded row on the chain of a dof.
#[derive(Debug, Clone)]
struct Row<T: Scalar, const W: usize> {
    /// Index into `Forces::friction` or `Forces::limit`.
    slot: usize,
    dof: usize,
    y: usize,
    offset: Lane<T, W>,
    softness: Lane<T, W>,
    inverse: Lane<T, W>,
    low: Lane<T, W>,
    high: Lane<T, W>,
}

/// One contact point: normal and two tangents on the chain of its body.
#[derive(Debug, Clone)]
struct Contact<T: Scalar, const W: usize> {
    slot: usize,
    dof: usize,
    y: usize,
    offset: Vec3<T, W>,
    /// y_n·y_n, y_1·y_1, y_2·y_2, y_n·y_1, y_n·y_2, y_1·y_2.
    gram: [Lane<T, W>; 6],
    softness: Lane<T, W>,
    inverse: [Lane<T, W>; 4],
    friction: Lane<T, W>,
    /// Above zero where it touches.
    touching: Lane<T, W>,
    smooth: bool,
}

/// The rows of one step.
#[derive(Debug, Clone)]
pub struct Solver<T: Scalar, const W: usize> {
    frictions: Vec<Row<T, W>>,
    limits: Vec<Row<T, W>>,
    contacts: Vec<Contact<T, W>>,
    /// The y of all rows.
    y: Vec<Lane<T, W>>,
}

/// What a step's constraints depend on.
pub struct Setting<'a, T: Scalar, const W: usize> {
    pub tree: &'a Tree,
    pub work: &'a Workspace<T, W>,
    pub weights: &'a InverseWeights<T, W>,
    /// Friction of the ground for every part of the robot; where it is below zero, each shape's own.
    pub ground_friction: Lane<T, W>,
    pub q: &'a [Lane<T, W>],
    pub v: &'a [Lane<T, W>],
    /// Visits of all rows.
    pub sweeps: usize,
}

impl<T: Scalar, const W: usize> Solver<T, W> {
    pub fn new() -> Self {
        Self { frictions: Vec::new(), limits: Vec::new(), contacts: Vec::new(), y: Vec::new() }
    }

    /// Finds the forces, and adds what they do to `u`, which comes with what everything else does.
    #[inline(always)]
    pub fn solve(&mut self, setting: &Setting<'_, T, W>, forces: &mut Forces<T, W>, u: &mut [Lane<T, W>]) {
        self.y.clear();
        self.add_frictions(setting);
        self.add_limits(setting, forces);
        self.add_contacts(setting, forces);
        self.start(setting.tree, forces, u);
        let tree = setting.tree;
        for _ in 0..setting.sweeps {
            for row in &self.frictions {
                row.visit(tree, &self.y, &mut forces.friction[row.slot], u);
            }
            for row in &self.limits {
                row.visit(tree, &self.y, &mut forces.limit[row.slot], u);
            }
            for contact in &self.contacts {
                contact.visit(tree, &self.y, &mut forces.contact[contact.slot], u);
            }
        }
    }

    /// The forces of the step before.
    #[inline(always)]
    fn start(&self, tree: &Tree, forces: &Forces<T, W>, u: &mut [Lane<T, W>]) {
        for (rows, values) in [(&self.frictions, &forces.friction), (&self.limits, &forces.limit)] {
            for row in rows {
                let chain = &tree.dofs[row.dof].chain;
                spread(chain, &self.y[row.y..row.y + chain.len()], values[row.slot], u);
            }
        }
        for contact in &self.contacts {
            let chain = &tree.dofs[contact.dof].chain;
            let n = chain.len();
            for (k, force) in contact.total(&forces.contact[contact.slot]).into_iter().enumerate() {
                spread(chain, &self.y[contact.y + k * n..contact.y + (k + 1) * n], force, u);
            }
        }
    }

    #[inline(always)]
    fn add_frictions(&mut self, s: &Setting<'_, T, W>) {
        self.frictions.clear();
        let softness = &s.tree.joint_softness;
        for (d, dof) in s.tree.dofs.iter().enumerate().filter(|(_, dof)| dof.frictionloss > 0.0) {
            let regular = regularization(Lane::of(softness.impedance[0]), s.weights.dof[d]);
            let (y, own) = self.push_unit(s, d, Lane::of(1.0));
            self.frictions.push(Row {
                slot: d,
                dof: d,
                y,
                offset: s.v[d] * Lane::of(softness.damping),
                softness: regular,
                inverse: (own + regular).recip(),
                low: Lane::of(-dof.frictionloss),
                high: Lane::of(dof.frictionloss),
            });
        }
    }

    #[inline(always)]
    fn add_limits(&mut self, s: &Setting<'_, T, W>, forces: &mut Forces<T, W>) {
        self.limits.clear();
        let softness = &s.tree.joint_softness;
        let (zero, one) = (Lane::zero(), Lane::of(1.0));
        for (slot, limit) in s.tree.limits.iter().enumerate() {
            let q = s.q[limit.q];
            let (below, over) = (Lane::of(limit.low) - q, q - Lane::of(limit.high));
            let beyond = below.most(over);
            if !beyond.any_positive() {
                forces.limit[slot] = zero;
                continue;
            }
            let side = below.above(over, one, -one);
            // The force of the step before counts on its own side only.
            let same = (side * forces.side[slot]).above(zero, forces.limit[slot], zero);
            forces.limit[slot] = beyond.above(zero, same, zero);
            forces.side[slot] = side;
            let impedance = impedance(softness, beyond);
            let regular = regularization(impedance, s.weights.dof[limit.dof]);
            let (y, own) = self.push_unit(s, limit.dof, side);
            let pull = Lane::of(softness.stiffness) * impedance * beyond;
            self.limits.push(Row {
                slot,
                dof: limit.dof,
                y,
                offset: (side * s.v[limit.dof] * Lane::of(softness.damping)) - pull,
                softness: regular,
                inverse: (own + regular).recip(),
                low: zero,
                high: beyond.above(zero, Lane::of(1e30), zero),
            });
        }
    }

    /// The row of one dof: where its y is, and y·y.
    #[inline(always)]
    fn push_unit(&mut self, s: &Setting<'_, T, W>, d: usize, entry: Lane<T, W>) -> (usize, Lane<T, W>) {
        let chain = &s.tree.dofs[d].chain;
        let at = self.y.len();
        self.y.resize(at + chain.len() - 1, Lane::zero());
        self.y.push(entry);
        let y = &mut self.y[at..];
        s.work.factors.half_solve_chain(s.tree, chain, y);
        let own = y.iter().fold(Lane::zero(), |sum, x| sum.plus(*x, *x));
        (at, own)
    }

    #[inline(always)]
    fn add_contacts(&mut self, s: &Setting<'_, T, W>, forces: &mut Forces<T, W>) {
        self.contacts.clear();
        let (zero, one) = (Lane::zero(), Lane::of(1.0));
        let height = s.q[s.tree.root_q + 2] - Lane::of(s.tree.ground_height);
        let mut slot = 0;
        for shape in &s.tree.shapes {
            let (rotation, position) = (&s.work.rotation[shape.body], &s.work.position[shape.body]);
            let Some(dof) = s.tree.bodies[shape.body].last_dof else {
                slot += shape.points.len();
                continue;
            };
            let middle = shape.middle.map(|m| add(position, &rotate(rotation, &vector(m)))[2]);
            for local in &shape.points {
                let mut point = add(position, &rotate(rotation, &vector(*local)));
                let distance = point[2] + height - Lane::of(shape.radius);
                let deep = Lane::of(shape.margin) - distance;
                let touching = match middle {
                    // A corner above the middle of its box does not touch.
                    Some(middle) => deep.above(zero, (middle - point[2]).above(-Lane::of(1e-12), one, zero), zero),
                    None => deep.above(zero, one, zero),
                };
                let kept = &mut forces.contact[slot];
                for edge in kept.iter_mut() {
                    *edge = touching.above(zero, *edge, zero);
                }
                if touching.any_positive() {
                    // Half way between the two surfaces.
                    point[2] = point[2] - Lane::of(shape.radius) - distance * Lane::of(0.5);
                    let along = shape.axis.map(|a| rotate(rotation, &vector(a)));
                    self.push_contact(s, shape, (slot, dof), &point, along, deep, touching);
                }
                slot += 1;
            }
        }
    }

    #[inline(always)]
    #[allow(clippy::too_many_arguments)]
    fn push_contact(
        &mut self,
        s: &Setting<'_, T, W>,
        shape: &super::tree::GroundShape,
        (slot, dof): (usize, usize),
        point: &Vec3<T, W>,
        along: Option<Vec3<T, W>>,
        deep: Lane<T, W>,
        touching: Lane<T, W>,
    ) {
        let (zero, one) = (Lane::zero(), Lane::of(1.0));
        let (tx, ty) = tangent(along);
        let chain = &s.tree.dofs[dof].chain;
        let n = chain.len();
        let at = self.y.len();
        self.y.resize(at + 3 * n, zero);
        let mut velocity = [zero; 3];
        for (i, d) in chain.iter().enumerate() {
            let [x, y, z] = s.work.point_velocity(*d, point);
            let column = [z, (tx * x).plus(ty, y), (tx * y).minus(ty, x)];
            for k in 0..3 {
                velocity[k] = velocity[k].plus(column[k], s.v[*d]);
                self.y[at + k * n + i] = column[k];
            }
        }
        for k in 0..3 {
            s.work.factors.half_solve_chain(s.tree, chain, &mut self.y[at + k * n..at + (k + 1) * n]);
        }
        let gram = |a: usize, b: usize| {
            let (a, b) = (&self.y[at + a * n..at + (a + 1) * n], &self.y[at + b * n..at + (b + 1) * n]);
            a.iter().zip(b).fold(Lane::zero(), |sum: Lane<T, W>, (x, y)| sum.plus(*x, *y))
        };
        let gram = [gram(0, 0), gram(1, 1), gram(2, 2), gram(0, 1), gram(0, 2), gram(1, 2)];
        let own = Lane::of(shape.friction);
        let friction = if shape.smooth { zero } else { s.ground_friction.above(zero, s.ground_friction, own) };
        let impedance = impedance(&shape.softness, deep);
        let weight = s.weights.body[shape.body] * one.plus(friction, friction);
        let regular = regularization(impedance, weight);
        let regular = if shape.smooth { regular } else { (friction * friction + friction * friction) * regular };
        let two = Lane::of(2.0);
        let edge = |sign: f64, cross: Lane<T, W>, side: Lane<T, W>| {
            let sign = Lane::of(sign);
            ((gram[0] + regular).plus(two * sign * friction, cross).plus(friction * friction, side)).recip()
        };
        let inverse = [
            edge(1.0, gram[3], gram[1]),
            edge(-1.0, gram[3], gram[1]),
            edge(1.0, gram[4], gram[2]),
            edge(-1.0, gram[4], gram[2]),
        ];
        let b = Lane::of(shape.softness.damping);
        let pull = Lane::of(shape.softness.stiffness) * impedance * deep;
        self.contacts.push(Contact {
            slot,
            dof,
            y: at,
            offset: [b * velocity[0] - pull, b * velocity[1], b * velocity[2]],
            gram,
            softness: regular,
            inverse,
            friction,
            touching,
            smooth: shape.smooth,
        });
    }
}

/// MuJoCo's contact frame on level ground: the first tangent is the shape's axis where that lies rather flat, else y.
#[inline(always)]
fn tangent<T: Scalar, const W: usize>(along: Option<Vec3<T, W>>) -> (Lane<T, W>, Lane<T, W>) {
    let (zero, one) = (Lane::zero(), Lane::of(1.0));
    let Some([x, y, _]) = along else { return (zero, one) };
    let length = (x * x).plus(y, y).sqrt();
    let inverse = length.most(Lane::of(1e-6)).recip();
    let half = Lane::of(0.5);
    (length.above(half, x * inverse, zero), length.above(half, y * inverse, one))
}

/// MuJoCo's impedance of a violation (m or rad).
#[inline(always)]
fn impedance<T: Scalar, const W: usize>(softness: &Softness, violation: Lane<T, W>) -> Lane<T, W> {
    let [low, high, width, middle, power] = softness.impedance;
    if width < 1e-15 || low == high {
        return Lane::of(0.5 * (low + high));
    }
    let one = Lane::of(1.0);
    let x = (violation.most(-violation) * Lane::of(1.0 / width)).least(one);
    let raised = |x: Lane<T, W>| {
        if power == 2.0 { x * x } else { x.map(|x| T::new(x.wide().powf(power))) }
    };
    let scale = |m: f64| if power == 2.0 { 1.0 / m } else { m.powf(1.0 - power) };
    let y = if power == 1.0 {
        x
    } else {
        let rising = raised(x) * Lane::of(scale(middle));
        let falling = one - raised(one - x) * Lane::of(scale(1.0 - middle));
        x.above(Lane::of(middle), falling, rising)
    };
    Lane::of(low).plus(y, Lane::of(high - low))
}

/// R = (1 - i) / i · Â.
#[inline(always)]
fn regularization<T: Scalar, const W: usize>(impedance: Lane<T, W>, weight: Lane<T, W>) -> Lane<T, W> {
    ((Lane::of(1.0) - impedance) / impedance * weight).most(Lane::of(1e-15))
}

/// Adds a force on one row to u.
#[inline(always)]
fn spread<T: Scalar, const W: usize>(chain: &[usize], y: &[Lane<T, W>], force: Lane<T, W>, u: &mut [Lane<T, W>]) {
    for (d, y) in chain.iter().zip(y) {
        u[*d] = u[*d].plus(*y, force);
    }
}

/// y · u.
#[inline(always)]
fn gather<T: Scalar, const W: usize>(chain: &[usize], y: &[Lane<T, W>], u: &[Lane<T, W>]) -> Lane<T, W> {
    // Two sums at once: one would wait for itself.
    let (mut even, mut odd) = (Lane::zero(), Lane::zero());
    let mut pairs = chain.chunks_exact(2).zip(y.chunks_exact(2));
    for (d, y) in &mut pairs {
        even = even.plus(y[0], u[d[0]]);
        odd = odd.plus(y[1], u[d[1]]);
    }
    if chain.len() % 2 == 1 {
        let last = chain.len() - 1;
        even = even.plus(y[last], u[chain[last]]);
    }
    even + odd
}

impl<T: Scalar, const W: usize> Row<T, W> {
    #[inline(always)]
    fn visit(&self, tree: &Tree, y: &[Lane<T, W>], force: &mut Lane<T, W>, u: &mut [Lane<T, W>]) {
        let chain = &tree.dofs[self.dof].chain;
        let y = &y[self.y..self.y + chain.len()];
        let residual = (gather(chain, y, u) + self.offset).plus(self.softness, *force);
        let new = force.minus(residual, self.inverse).most(self.low).least(self.high);
        spread(chain, y, new - *force, u);
        *force = new;
    }
}

impl<T: Scalar, const W: usize> Contact<T, W> {
    /// Force along normal and tangents.
    #[inline(always)]
    fn total(&self, edges: &[Lane<T, W>; 4]) -> Vec3<T, W> {
        [
            edges[0] + edges[1] + edges[2] + edges[3],
            self.friction * (edges[0] - edges[1]),
            self.friction * (edges[2] - edges[3]),
        ]
    }

    #[inline(always)]
    fn visit(&self, tree: &Tree, y: &[Lane<T, W>], edges: &mut [Lane<T, W>; 4], u: &mut [Lane<T, W>]) {
        let chain = &tree.dofs[self.dof].chain;
        let n = chain.len();
        let part = |k: usize| &y[self.y + k * n..self.y + (k + 1) * n];
        let zero = Lane::zero();
        if self.smooth {
            let residual = (gather(chain, part(0), u) + self.offset[0]).plus(self.softness, edges[0]);
            let new = self.touching.above(zero, edges[0].minus(residual, self.inverse[0]).most(zero), zero);
            spread(chain, part(0), new - edges[0], u);
            edges[0] = new;
            return;
        }
        let mut a: Vec3<T, W> = std::array::from_fn(|k| gather(chain, part(k), u) + self.offset[k]);
        let before = self.total(edges);
        let g = &self.gram;
        for _ in 0..INNER {
            for (edge, tangent, sign) in [(0, 1, 1.0), (1, 1, -1.0), (2, 2, 1.0), (3, 2, -1.0)] {
                let slope = self.friction * Lane::of(sign);
                let residual = (a[0].plus(slope, a[tangent])).plus(self.softness, edges[edge]);
                let wished = edges[edge].minus(residual, self.inverse[edge] * Lane::of(RELAXATION)).most(zero);
                let new = self.touching.above(zero, wished, zero);
                let change = new - edges[edge];
                edges[edge] = new;
                let aside = slope * change;
                let (with_normal, with_first, with_second) =
                    if tangent == 1 { (g[3], g[1], g[5]) } else { (g[4], g[5], g[2]) };
                a[0] = a[0].plus(g[0], change).plus(with_normal, aside);
                a[1] = a[1].plus(g[3], change).plus(with_first, aside);
                a[2] = a[2].plus(g[4], change).plus(with_second, aside);
            }
        }
        let after = self.total(edges);
        for k in 0..3 {
            spread(chain, part(k), after[k] - before[k], u);
        }
    }
}
