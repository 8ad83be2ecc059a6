//! Vectors, rotations and spatial algebra (Featherstone) on lanes.
//!
//! Spatial vectors are `[angular, linear]` about one origin, axes of the world.

use super::lanes::Lanes;

pub type Vec3<V> = [V; 3];
/// Row-major.
pub type Mat3<V> = [V; 9];
pub type Spatial<V> = [V; 6];
/// Mass, mass times centre of mass, inertia about the origin (xx, yy, zz, xy, xz, yz).
pub type Inertia<V> = [V; 10];

#[inline(always)]
pub fn vector<V: Lanes>(v: &[V::Scalar; 3]) -> Vec3<V> {
    [V::splat(v[0]), V::splat(v[1]), V::splat(v[2])]
}

/// Row i of a matrix.
#[inline(always)]
pub fn vec3<V: Lanes>(m: &Mat3<V>, i: usize) -> Vec3<V> {
    [m[3 * i], m[3 * i + 1], m[3 * i + 2]]
}

/// Column k of a matrix.
#[inline(always)]
pub fn column<V: Lanes>(m: &Mat3<V>, k: usize) -> Vec3<V> {
    [m[k], m[3 + k], m[6 + k]]
}

#[inline(always)]
pub fn add<V: Lanes>(a: &Vec3<V>, b: &Vec3<V>) -> Vec3<V> {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

#[inline(always)]
pub fn sub<V: Lanes>(a: &Vec3<V>, b: &Vec3<V>) -> Vec3<V> {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[inline(always)]
pub fn cross<V: Lanes>(a: &Vec3<V>, b: &Vec3<V>) -> Vec3<V> {
    [(a[1] * b[2]).sub_mul(a[2], b[1]), (a[2] * b[0]).sub_mul(a[0], b[2]), (a[0] * b[1]).sub_mul(a[1], b[0])]
}

/// r v of a constant vector.
#[inline(always)]
pub fn rotate_constant<V: Lanes>(r: &Mat3<V>, v: &[V::Scalar; 3]) -> Vec3<V> {
    rotate(r, &vector(v))
}

#[inline(always)]
pub fn dot<V: Lanes>(a: &Vec3<V>, b: &Vec3<V>) -> V {
    (a[0] * b[0]).add_mul(a[1], b[1]).add_mul(a[2], b[2])
}

/// a + b s.
#[inline(always)]
pub fn along<V: Lanes>(a: &Vec3<V>, b: &Vec3<V>, s: V) -> Vec3<V> {
    [a[0].add_mul(b[0], s), a[1].add_mul(b[1], s), a[2].add_mul(b[2], s)]
}

#[inline(always)]
pub fn rotate<V: Lanes>(r: &Mat3<V>, v: &Vec3<V>) -> Vec3<V> {
    [
        (r[0] * v[0]).add_mul(r[1], v[1]).add_mul(r[2], v[2]),
        (r[3] * v[0]).add_mul(r[4], v[1]).add_mul(r[5], v[2]),
        (r[6] * v[0]).add_mul(r[7], v[1]).add_mul(r[8], v[2]),
    ]
}

#[inline(always)]
pub fn product<V: Lanes>(a: &Mat3<V>, b: &Mat3<V>) -> Mat3<V> {
    let mut out = [V::zero(); 9];
    for i in 0..3 {
        for j in 0..3 {
            out[3 * i + j] = (a[3 * i] * b[j]).add_mul(a[3 * i + 1], b[3 + j]).add_mul(a[3 * i + 2], b[6 + j]);
        }
    }
    out
}

/// a b of a constant b.
#[inline(always)]
pub fn product_constant<V: Lanes>(a: &Mat3<V>, b: &[V::Scalar; 9]) -> Mat3<V> {
    let mut out = [V::zero(); 9];
    for i in 0..3 {
        for j in 0..3 {
            let (x, y, z) = (V::splat(b[j]), V::splat(b[3 + j]), V::splat(b[6 + j]));
            out[3 * i + j] = (a[3 * i] * x).add_mul(a[3 * i + 1], y).add_mul(a[3 * i + 2], z);
        }
    }
    out
}

/// The rotation of a unit quaternion `wxyz`.
#[inline(always)]
pub fn quaternion_matrix<V: Lanes>(q: &[V]) -> Mat3<V> {
    let (w, x, y, z) = (q[0], q[1], q[2], q[3]);
    let (one, two) = (V::splat_f64(1.0), V::splat_f64(2.0));
    [
        one.sub_mul(two, (y * y).add_mul(z, z)),
        two * (x * y).sub_mul(w, z),
        two * (x * z).add_mul(w, y),
        two * (x * y).add_mul(w, z),
        one.sub_mul(two, (x * x).add_mul(z, z)),
        two * (y * z).sub_mul(w, x),
        two * (x * z).sub_mul(w, y),
        two * (y * z).add_mul(w, x),
        one.sub_mul(two, (x * x).add_mul(y, y)),
    ]
}

/// The turn by an angle of this sine and cosine about a constant unit axis (Rodrigues).
#[inline(always)]
pub fn turn<V: Lanes>(axis: &[V::Scalar; 3], s: V, c: V) -> Mat3<V> {
    let a = vector(axis);
    let versed = V::splat_f64(1.0) - c;
    let mut r = [V::zero(); 9];
    for i in 0..3 {
        for j in 0..3 {
            r[3 * i + j] = versed * (a[i] * a[j]);
        }
        r[4 * i] += c;
    }
    r[1] -= s * a[2];
    r[2] += s * a[1];
    r[3] += s * a[2];
    r[5] -= s * a[0];
    r[6] -= s * a[1];
    r[7] += s * a[0];
    r
}

/// r times the turn by an angle of this sine and cosine about coordinate axis K: the other two columns turn.
#[inline(always)]
pub fn turned_about<V: Lanes, const K: usize>(r: &Mat3<V>, s: V, c: V) -> Mat3<V> {
    let (i, j) = ((K + 1) % 3, (K + 2) % 3);
    let mut out = *r;
    for row in 0..3 {
        let (a, b) = (r[3 * row + i], r[3 * row + j]);
        out[3 * row + i] = (a * c).add_mul(b, s);
        out[3 * row + j] = (b * c).sub_mul(a, s);
    }
    out
}

/// Adds `b` to `a`.
#[inline(always)]
pub fn accumulate<V: Lanes, const N: usize>(a: &mut [V; N], b: &[V; N]) {
    for i in 0..N {
        a[i] += b[i];
    }
}

#[inline(always)]
pub fn dot6<V: Lanes>(a: &Spatial<V>, b: &Spatial<V>) -> V {
    let first = (a[0] * b[0]).add_mul(a[1], b[1]).add_mul(a[2], b[2]);
    let second = (a[3] * b[3]).add_mul(a[4], b[4]).add_mul(a[5], b[5]);
    first + second
}

/// I v: momentum of a motion.
#[inline(always)]
pub fn momentum<V: Lanes>(i: &Inertia<V>, v: &Spatial<V>) -> Spatial<V> {
    let (w, l, h) = ([v[0], v[1], v[2]], [v[3], v[4], v[5]], [i[1], i[2], i[3]]);
    let turning = [
        (i[4] * w[0]).add_mul(i[7], w[1]).add_mul(i[8], w[2]),
        (i[7] * w[0]).add_mul(i[5], w[1]).add_mul(i[9], w[2]),
        (i[8] * w[0]).add_mul(i[9], w[1]).add_mul(i[6], w[2]),
    ];
    let angular = add(&turning, &cross(&h, &l));
    let linear = cross(&w, &h);
    [
        angular[0],
        angular[1],
        angular[2],
        linear[0].add_mul(i[0], l[0]),
        linear[1].add_mul(i[0], l[1]),
        linear[2].add_mul(i[0], l[2]),
    ]
}

/// v × s: how a motion that moves along with `v` changes.
#[inline(always)]
pub fn cross_motion<V: Lanes>(v: &Spatial<V>, s: &Spatial<V>) -> Spatial<V> {
    let (w, l, a, b) = ([v[0], v[1], v[2]], [v[3], v[4], v[5]], [s[0], s[1], s[2]], [s[3], s[4], s[5]]);
    let (x, y) = (cross(&w, &a), add(&cross(&w, &b), &cross(&l, &a)));
    [x[0], x[1], x[2], y[0], y[1], y[2]]
}

/// v ×* f: how a force that moves along with `v` changes.
#[inline(always)]
pub fn cross_force<V: Lanes>(v: &Spatial<V>, f: &Spatial<V>) -> Spatial<V> {
    let (w, l, a, b) = ([v[0], v[1], v[2]], [v[3], v[4], v[5]], [f[0], f[1], f[2]], [f[3], f[4], f[5]]);
    let (x, y) = (add(&cross(&w, &a), &cross(&l, &b)), cross(&w, &b));
    [x[0], x[1], x[2], y[0], y[1], y[2]]
}

/// The velocity of a point of what moves so.
#[inline(always)]
pub fn velocity_at<V: Lanes>(v: &Spatial<V>, point: &Vec3<V>) -> Vec3<V> {
    add(&cross(&[v[0], v[1], v[2]], point), &[v[3], v[4], v[5]])
}

/// The unit quaternion `wxyz` of a rotation, by its component that is surely not small (Shepperd 1978).
#[inline(always)]
pub fn matrix_quaternion<V: Lanes>(r: &Mat3<V>) -> [V; 4] {
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
            let got = matrix_quaternion(&std::array::from_fn(|k| matrix.matrix()[(k / 3, k % 3)] as f32));
            let sign = to_wxyz(&expected).iter().zip(got).map(|(a, b)| a * f64::from(b)).sum::<f64>().signum();
            for (a, b) in to_wxyz(&expected).iter().zip(got) {
                assert!((a * sign - f64::from(b)).abs() < 3e-7, "{expected:?}: {got:?}");
            }
        }
    }
}
