//! A contact: a pyramid of four edges, solved in the forces along them.

use super::dof_chain::DofChain;
use super::lanes::{Lanes, Scalar};
use super::solver_context::SolverContext;
use super::spatial::{Vec3, dot, sub, velocity_at};
use super::surface::{Mixed, regularization};

/// Visits of a contact's four edges per visit of the contact.
pub const INNER: usize = 2;
/// Factor on the step of an edge's force towards its own optimum (successive over-relaxation): the four corners of a
/// sole share their load, and plain Gauss-Seidel shifts it between them slowly. Without it, and with 8 iterations, a box at 98%
/// of its friction angle slid at 5.9 cm/s that creeps at 0.6 in MuJoCo.
const RELAXATION: f64 = 1.3;
/// Pairs of different edges, in the order of `Contact::cross`.
const CROSS: [[usize; 4]; 4] = [[9, 0, 1, 2], [0, 9, 3, 4], [1, 3, 9, 5], [2, 4, 5, 9]];

/// A possible contact, in all environments of a vector at once.
pub struct ContactCandidate<'a, V: Lanes> {
    /// Index into `Forces::contact`.
    pub slot: usize,
    /// The bodies; 0 is the ground.
    pub bodies: [usize; 2],
    /// The dofs that move one body against the other.
    pub dof_chain: usize,
    /// Between the surfaces, from the root's position (m).
    pub point: Vec3<V>,
    /// From the first body (or the ground) to the second, and two directions across.
    pub frame: [Vec3<V>; 3],
    /// Overlap (m).
    pub penetration: V,
    /// Above zero where they touch.
    pub touching: V,
    /// Inverse weight of both bodies (1/kg).
    pub weight: V,
    pub mixed: &'a Mixed<V::Scalar>,
    /// Friction that the environment asks for; where it is below zero, the surfaces' own.
    pub friction: V,
}

/// Frame in which a contact's force acts: recorded only when constraint wrenches are asked for.
#[derive(Debug, Clone)]
pub struct ContactFrame<V: Lanes> {
    pub bodies: [usize; 2],
    pub point: Vec3<V>,
    /// Normal and two tangents.
    pub axes: [Vec3<V>; 3],
}

/// One contact, ready to be solved. Its edges are n + μ t₁, n - μ t₁, n + μ t₂, n - μ t₂.
#[derive(Debug, Clone)]
pub struct Contact<V: Lanes> {
    pub slot: usize,
    pub dof_chain: usize,
    /// Start of its y: rows of normal and tangents.
    pub y: usize,
    offset: Vec3<V>,
    /// y·y of different edges.
    cross: [V; 6],
    /// Part of the way to its own optimum that an edge's force takes at a visit.
    relaxation: V::Scalar,
    /// Change of an edge's force per residual: negative, and zero where nothing touches.
    response: [V; 4],
    softness: V,
    friction: V,
}

/// The contacts of a step.
#[derive(Debug, Clone)]
pub struct Contacts<V: Lanes> {
    pub list: Vec<Contact<V>>,
    /// The y of all: normal and two tangents. Entries behind those of the list are of other steps.
    pub y: Vec<[V; 3]>,
    used: usize,
    /// D^(-1/2) L^(-T) of the motion between two bodies (angular, then linear), for the dof chains that have a contact. Every
    /// contact's rows are combinations of these six.
    bases: Vec<[V; 6]>,
    /// Begin of each dof chain's basis.
    basis_of: Vec<Option<usize>>,
    /// Their frames, if those are asked for.
    pub recorded: Option<Vec<ContactFrame<V>>>,
}

impl<V: Lanes> Contacts<V> {
    pub fn new(dof_chains: usize) -> Self {
        let basis_of = vec![None; dof_chains];
        Self { list: Vec::new(), y: Vec::new(), used: 0, bases: Vec::new(), basis_of, recorded: None }
    }

    /// Before another step.
    pub fn clear(&mut self) {
        self.list.clear();
        self.used = 0;
        self.bases.clear();
        self.basis_of.fill(None);
    }

    /// Returns where the basis of a dof chain begins.
    #[inline(always)]
    fn basis(&mut self, s: &SolverContext<'_, V>, index: usize) -> usize {
        if let Some(at) = self.basis_of[index] {
            return at;
        }
        let (at, dof_chain) = (self.bases.len(), &s.tree.dof_chains[index]);
        self.basis_of[index] = Some(at);
        // What moves both bodies moves neither against the other.
        self.bases.resize(at + dof_chain.shared, [V::zero(); 6]);
        for (n, d) in dof_chain.dofs.iter().enumerate().skip(dof_chain.shared) {
            let mut motion = s.dynamics.motion[*d];
            if n < dof_chain.fork {
                for x in &mut motion {
                    *x = -*x;
                }
            }
            self.bases.push(motion);
        }
        s.dynamics.factors.half_solve_rows(s.tree, dof_chain, &mut self.bases[at..]);
        at
    }

    /// Adds one.
    pub fn push(&mut self, s: &SolverContext<'_, V>, m: &ContactCandidate<'_, V>) {
        V::vectorize(
            #[inline(always)]
            || {
                let (zero, one, two) = (V::zero(), V::splat_f64(1.0), V::splat_f64(2.0));
                let basis = self.basis(s, m.dof_chain);
                let dofs = s.tree.dof_chains[m.dof_chain].len();
                let at = self.used;
                self.used += dofs;
                if self.y.len() < self.used {
                    self.y.resize(self.used, [zero; 3]);
                }
                let [a, b] = m.bodies.map(|body| &s.dynamics.velocity[body]);
                let between = velocity_at(b, &m.point);
                let between = sub(&between, &velocity_at(a, &m.point));
                let velocity = [dot(&m.frame[0], &between), dot(&m.frame[1], &between), dot(&m.frame[2], &between)];
                let mut gram = [zero; 6];
                for (y, basis) in self.y[at..self.used].iter_mut().zip(&self.bases[basis..basis + dofs]) {
                    let moved = velocity_at(basis, &m.point);
                    let [n, a, b] = [dot(&m.frame[0], &moved), dot(&m.frame[1], &moved), dot(&m.frame[2], &moved)];
                    *y = [n, a, b];
                    gram[0] = gram[0].add_mul(n, n);
                    gram[1] = gram[1].add_mul(a, a);
                    gram[2] = gram[2].add_mul(b, b);
                    gram[3] = gram[3].add_mul(n, a);
                    gram[4] = gram[4].add_mul(n, b);
                    gram[5] = gram[5].add_mul(a, b);
                }
                let mixed = m.mixed;
                let rough = m.friction.select_gt(zero, m.friction, V::splat(mixed.friction));
                let friction = if mixed.smooth { zero } else { rough };
                let impedance = mixed.softness.impedance(m.penetration);
                let regular = regularization(impedance, m.weight * one.add_mul(friction, friction));
                let softness = if mixed.smooth { regular } else { two * friction * friction * regular };
                let [nn, aa, bb, na, nb, ab] = gram;
                let (a, b) = (friction * na, friction * nb);
                let square = friction * friction;
                let (aa, bb, ab) = (square * aa, square * bb, square * ab);
                let (plus_a, minus_a, plus_b, minus_b) = (nn + a, nn - a, nn + b, nn - b);
                let own = [
                    plus_a + a + aa + softness,
                    minus_a - a + aa + softness,
                    plus_b + b + bb + softness,
                    minus_b - b + bb + softness,
                ];
                let cross = [nn - aa, plus_a + b + ab, plus_a - b - ab, minus_a + b - ab, minus_a - b + ab, nn - bb];
                // Without friction the edges are one, and the first stands for it.
                let relaxation = Scalar::new(if mixed.smooth { 1.0 } else { RELAXATION });
                let mut response = [zero; 4];
                for k in 0..if mixed.smooth { 1 } else { 4 } {
                    response[k] = m.touching.select_gt(zero, -V::splat(relaxation) / own[k], zero);
                }
                let damping = V::splat(mixed.softness.damping);
                let pull = V::splat(mixed.softness.stiffness) * impedance * m.penetration;
                let offset = [damping * velocity[0] - pull, damping * velocity[1], damping * velocity[2]];
                if let Some(recorded) = &mut self.recorded {
                    recorded.push(ContactFrame { bodies: m.bodies, point: m.point, axes: m.frame });
                }
                let (slot, dof_chain) = (m.slot, m.dof_chain);
                self.list.push(Contact {
                    slot,
                    dof_chain,
                    y: at,
                    offset,
                    cross,
                    relaxation,
                    response,
                    softness,
                    friction,
                });
            },
        );
    }
}

impl<V: Lanes> Contact<V> {
    /// Force along normal and tangents.
    #[inline(always)]
    pub fn total(&self, edges: &[V; 4]) -> Vec3<V> {
        [
            edges[0] + edges[1] + edges[2] + edges[3],
            self.friction * (edges[0] - edges[1]),
            self.friction * (edges[2] - edges[3]),
        ]
    }

    #[inline(always)]
    pub fn visit(&self, dof_chain: &DofChain, y: &[[V; 3]], edges: &mut [V; 4], u: &mut [V]) {
        let y = &y[self.y..self.y + dof_chain.len()];
        let acceleration = dof_chain.gather(y, u);
        let normal = acceleration[0] + self.offset[0];
        let a = self.friction * (acceleration[1] + self.offset[1]);
        let b = self.friction * (acceleration[2] + self.offset[2]);
        let mut force = *edges;
        let mut residual = [normal + a, normal - a, normal + b, normal - b];
        for k in 0..4 {
            residual[k] = residual[k].add_mul(self.softness, force[k]);
        }
        // From here on in units of force, where each wants to go from where it is: an edge waits for the one before it, and so
        // for nothing but a maximum and a product.
        let mut wish = [V::zero(); 4];
        let mut coupling = [[V::zero(); 4]; 4];
        for k in 0..4 {
            wish[k] = residual[k] * self.response[k];
            for i in 0..4 {
                coupling[k][i] =
                    if i == k { -V::splat(self.relaxation) } else { self.cross[CROSS[k][i]] * self.response[k] };
            }
        }
        for _ in 0..INNER {
            for k in 0..4 {
                let change = wish[k].max(-force[k]);
                force[k] += change;
                for i in 0..4 {
                    wish[i] = wish[i].add_mul(coupling[i][k], change);
                }
            }
        }
        let (before, after) = (self.total(edges), self.total(&force));
        *edges = force;
        dof_chain.spread(y, &[after[0] - before[0], after[1] - before[1], after[2] - before[2]], u);
    }
}
