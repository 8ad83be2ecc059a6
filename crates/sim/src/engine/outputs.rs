//! Outputs of the environments of a vector: computed on lanes, then turned into rows.

use super::block::{Block, Model};
use super::lanes::{Lanes, Scalar};
use super::rigid_body::RigidBodyDynamics;
use super::spatial::{Mat3, add, dot, rotate_constant, vec3};
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
        let root = [block.q[tree.root_q], block.q[tree.root_q + 1], block.q[tree.root_q + 2]];
        let spin = [block.v[tree.root_v + 3], block.v[tree.root_v + 4], block.v[tree.root_v + 5]];
        for x in &block.q[tree.root_q..tree.root_q + 7] {
            self.put(*x);
        }
        for x in &block.v[tree.root_v..tree.root_v + 3] {
            self.put(*x);
        }
        for k in 0..3 {
            self.put(dot(&vec3(&dynamics.rotation[tree.root_body], k), &spin));
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
            self.put_all(quaternion(rotation));
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
                    for [a, b, c, d] in &block.forces.contact[slot..slot + shape.points.len()] {
                        sum += *a + *b + *c + *d;
                    }
                }
                slot += shape.points.len();
            }
            self.put(sum);
        }
        for (i, joint) in model.tree.driven.iter().enumerate() {
            let mut force = block.forces.friction[joint.v];
            for (k, limit) in model.tree.limits.iter().enumerate() {
                if limit.scalar == i {
                    force = force.add_mul(block.forces.limit[k], block.forces.side[k]);
                }
            }
            self.put(force);
        }
    }
}

/// The unit quaternion `wxyz` of a rotation, by its component that is surely not small (Shepperd 1978).
#[inline(always)]
fn quaternion<V: Lanes>(r: &Mat3<V>) -> [V; 4] {
    let (zero, one) = (V::zero(), V::splat_f64(1.0));
    let (xx, yy, zz) = (r[0], r[4], r[8]);
    let trace = xx + yy + zz;
    // Four times the square of the component that is chosen, and four times its product with the others.
    let (wx, wy, wz) = (r[7] - r[5], r[2] - r[6], r[3] - r[1]);
    let (xy, xz, yz) = (r[1] + r[3], r[2] + r[6], r[5] + r[7]);
    let of_w = [one + trace, wx, wy, wz];
    let of_x = [wx, one + xx - yy - zz, xy, xz];
    let of_y = [wy, xy, one + yy - xx - zz, yz];
    let of_z = [wz, xz, yz, one + zz - xx - yy];
    let mut chosen = [zero; 4];
    let mut square = zero;
    let largest_x = (xx - yy).min(xx - zz);
    for k in 0..4 {
        let turned = largest_x.select_gt(zero, of_x[k], (yy - zz).select_gt(zero, of_y[k], of_z[k]));
        chosen[k] = trace.select_gt(zero, of_w[k], turned);
    }
    for x in chosen {
        square = square.add_mul(x, x);
    }
    let inverse = square.sqrt().recip();
    for x in &mut chosen {
        *x = *x * inverse;
    }
    chosen
}

#[cfg(test)]
mod tests {
    use lifelike_character::rotation::to_wxyz;
    use nalgebra::{Quaternion, UnitQuaternion};
    use rand::{Rng, SeedableRng};

    use super::*;

    #[test]
    fn quaternions_of_rotations_by_every_axis() {
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(1);
        for i in 0..4000 {
            let mut q: [f64; 4] = std::array::from_fn(|_| rng.random_range(-1.0..1.0));
            // Turns by half a circle have no w to go by, turns about one axis nothing else.
            match i % 4 {
                0 => q[0] = 0.0,
                1 => (q[0], q[1 + i % 3]) = (0.0, 0.0),
                2 => q[1..].iter_mut().for_each(|x| *x *= 1e-6),
                _ => {}
            }
            let expected = UnitQuaternion::new_normalize(Quaternion::new(q[0], q[1], q[2], q[3]));
            let matrix = expected.to_rotation_matrix();
            let got = quaternion(&std::array::from_fn(|k| matrix.matrix()[(k / 3, k % 3)] as f32));
            let sign = to_wxyz(&expected).iter().zip(got).map(|(a, b)| a * f64::from(b)).sum::<f64>().signum();
            for (a, b) in to_wxyz(&expected).iter().zip(got) {
                assert!((a * sign - f64::from(b)).abs() < 3e-7, "{expected:?}: {got:?}");
            }
        }
    }
}
