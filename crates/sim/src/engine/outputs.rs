//! Outputs of the environments of a vector: computed on lanes, then turned into rows.

use super::block::{Block, Model};
use super::lanes::{Lanes, Scalar};
use super::rigid_body::RigidBodyDynamics;
use super::spatial::{add, dot, matrix_quaternion, rotate_constant, vec3};
use super::tree::Root;
use crate::rows::{Rows, Sizes};

/// Every column of the outputs, of all lanes: number after number, in the order of [`Rows`].
#[derive(Debug, Clone)]
pub struct Outputs<V: Lanes> {
    numbers: Vec<V::Scalar>,
}

impl<V: Lanes> Outputs<V> {
    /// Computes the outputs of a block; the kinematics are those of its state.
    pub fn compute(&mut self, model: &Model<V>, block: &Block<V>, dynamics: &RigidBodyDynamics<V>, sizes: &Sizes) {
        self.numbers.resize(sizes.columns() * V::LANES, Scalar::new(0.0));
        let mut columns = Columns(self.numbers.chunks_exact_mut(V::LANES));
        V::vectorize(
            #[inline(always)]
            || {
                columns.put_state(model, block, dynamics);
                columns.put_forces(model, block);
            },
        );
    }

    /// Writes the rows of some environments that lie side by side, the first of them in lane `first`.
    pub fn write(&self, first: usize, rows: &mut Rows<'_>) {
        let n = rows.diverged.len();
        let mut rest = self.numbers.as_slice();
        let mut write = |out: &mut [f32]| {
            let width = out.len() / n;
            let (own, others) = rest.split_at(width * V::LANES);
            for (lane, row) in out.chunks_exact_mut(width.max(1)).enumerate() {
                for (slot, x) in row.iter_mut().zip(own[first + lane..].iter().step_by(V::LANES)) {
                    *slot = x.to_f64() as f32;
                }
            }
            rest = others;
        };
        rows.kinematic_columns().into_iter().for_each(&mut write);
        rows.force_columns().into_iter().for_each(&mut write);
    }
}

impl<V: Lanes> Default for Outputs<V> {
    fn default() -> Self {
        Self { numbers: Vec::new() }
    }
}

/// The columns that are not computed yet.
struct Columns<'a, V: Lanes>(std::slice::ChunksExactMut<'a, V::Scalar>);

impl<V: Lanes> Columns<'_, V> {
    #[inline(always)]
    fn put(&mut self, number: V) {
        if let Some(column) = self.0.next() {
            number.store(column);
        }
    }

    #[inline(always)]
    fn put_all<const N: usize>(&mut self, numbers: [V; N]) {
        for x in numbers {
            self.put(x);
        }
    }

    /// Poses and velocities.
    #[inline(always)]
    fn put_state(&mut self, model: &Model<V>, block: &Block<V>, dynamics: &RigidBodyDynamics<V>) {
        let tree = &model.tree;
        let root = dynamics.origin;
        match &tree.root {
            Root::Free { q, v, body } => {
                let spin = [block.v[v + 3], block.v[v + 4], block.v[v + 5]];
                for x in &block.q[*q..q + 7] {
                    self.put(*x);
                }
                for x in &block.v[*v..v + 3] {
                    self.put(*x);
                }
                for k in 0..3 {
                    self.put(dot(&vec3(&dynamics.rotation[*body], k), &spin));
                }
            }
            Root::Fixed { position, orientation } => {
                self.put_all(position.map(V::splat));
                self.put_all(orientation.map(V::splat));
                self.put_all([V::zero(); 6]);
            }
        }
        for joint in &tree.driven {
            self.put(block.q[joint.q]);
        }
        for joint in &tree.driven {
            self.put(block.v[joint.v]);
        }
        for (body, point) in &tree.sites {
            let from_root = add(&dynamics.position[*body], &rotate_constant(&dynamics.rotation[*body], point));
            self.put_all(add(&root, &from_root));
        }
        // The world is where it is.
        let (zero, one) = (V::zero(), V::splat_f64(1.0));
        self.put_all([zero; 3]);
        for position in &dynamics.position[1..] {
            self.put_all(add(&root, position));
        }
        self.put_all([one, zero, zero, zero]);
        for rotation in &dynamics.rotation[1..] {
            self.put_all(matrix_quaternion(rotation));
        }
    }

    /// Torques and forces of the last substep; squared torques as the mean over all.
    #[inline(always)]
    fn put_forces(&mut self, model: &Model<V>, block: &Block<V>) {
        for numbers in [&block.torque_squared, &block.torque] {
            for x in numbers {
                self.put(*x);
            }
        }
        for foot in 0..model.tree.feet {
            let (mut sum, mut slot) = (V::zero(), 0);
            for shape in &model.tree.ground_shapes {
                if shape.foot == Some(foot) {
                    for [a, b, c, d] in &block.forces.contact[slot..slot + shape.count()] {
                        sum += *a + *b + *c + *d;
                    }
                }
                slot += shape.count();
            }
            self.put(sum);
        }
        for joint in &model.tree.driven {
            let mut force = block.forces.friction[joint.v];
            for (k, limit) in model.tree.limits.iter().enumerate() {
                if limit.dof == joint.v {
                    force = force.add_mul(block.forces.limit[k], block.forces.side[k]);
                }
            }
            self.put(force);
        }
    }
}
