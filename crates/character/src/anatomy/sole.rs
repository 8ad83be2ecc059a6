//! Contact patches of feet: the outline that touches the ground.

use crate::kinematics::Kinematics;
use crate::model::{Character, Geom, GeomShape, welded};
use crate::outline::outline;
use crate::rotation::{Quat, Vec3};

/// Returns the corners of the contact patch of a foot in its body's frame: the convex outline of the lowest points of
/// what is fixed to it, at the reference position. Colliding geoms count; where there are none, any; where there are
/// none at all, the box that has the foot's inertia.
pub(crate) fn corners(character: &Character, kinematics: &Kinematics, foot: usize) -> Vec<Vec3> {
    let fixed = welded(&character.bodies, foot);
    let on_foot = || character.geoms.iter().filter(|g| fixed[g.body]);
    let points =
        |geoms: &mut dyn Iterator<Item = &Geom>| geoms.flat_map(|g| lowest(g, kinematics)).collect::<Vec<Vec3>>();
    let mut low = points(&mut on_foot().filter(|g| g.collides()));
    if low.is_empty() {
        low = points(&mut on_foot());
    }
    if low.is_empty() {
        low = box_of_inertia(character, kinematics, foot);
    }
    let bottom = low.iter().map(|p| p.z).fold(f64::MAX, f64::min);
    let spread = extent(&low);
    // A sole may be tilted a little at the reference position, and toes may stand higher than heels.
    let patch: Vec<Vec3> = low.into_iter().filter(|p| p.z - bottom <= 0.25 * spread).collect();
    let back = kinematics.body_orientation[foot].inverse();
    outline(patch).iter().map(|p| back * (p - kinematics.body_position[foot])).collect()
}

fn extent(points: &[Vec3]) -> f64 {
    let mut widest = 0.0_f64;
    for a in points {
        for b in points {
            widest = widest.max((a - b).norm());
        }
    }
    widest
}

/// Returns the points of a geom that can be its lowest (m, world): none for planes, meshes and height fields.
pub fn lowest(geom: &Geom, kinematics: &Kinematics) -> Vec<Vec3> {
    let turn = kinematics.body_orientation[geom.body] * geom.orientation;
    let middle = kinematics.point(geom.body, &geom.position);
    let down = |r: f64| Vec3::new(0.0, 0.0, -r);
    let ends = |half: f64| [turn * Vec3::new(0.0, 0.0, half), turn * Vec3::new(0.0, 0.0, -half)];
    match &geom.shape {
        GeomShape::Sphere(r) => vec![middle + down(*r)],
        GeomShape::Capsule(r, half) => ends(*half).iter().map(|e| middle + e + down(*r)).collect(),
        GeomShape::Box(h) => lower_face(&middle, &turn, h),
        GeomShape::Cylinder(r, half) => {
            let axis = turn * Vec3::z();
            if axis.z.abs() > 0.7 {
                let end = ends(*half).into_iter().min_by(|a, b| a.z.total_cmp(&b.z)).unwrap_or_else(Vec3::zeros);
                let rim = [Vec3::x(), Vec3::y(), -Vec3::x(), -Vec3::y()];
                rim.iter().map(|d| middle + end + turn * d * *r).collect()
            } else {
                // Lying: the lowest line of its side.
                let across = Vec3::z() - axis * axis.z;
                let drop = across.normalize() * -*r;
                ends(*half).iter().map(|e| middle + e + drop).collect()
            }
        }
        GeomShape::Ellipsoid(h) => {
            let up = turn.inverse() * Vec3::z();
            let scaled = h.component_mul(h).component_mul(&up);
            vec![middle - turn * (scaled / h.component_mul(&up).norm().max(1e-12))]
        }
        GeomShape::Plane | GeomShape::Mesh(_) | GeomShape::HeightField(_) => Vec::new(),
    }
}

/// Returns the four corners of the side that faces down most.
fn lower_face(middle: &Vec3, turn: &Quat, half: &Vec3) -> Vec<Vec3> {
    let (mut axis, mut steepest) = (2, 0.0);
    for i in 0..3 {
        let z = (turn * Vec3::ith(i, 1.0)).z;
        if z.abs() > f64::abs(steepest) {
            (axis, steepest) = (i, z);
        }
    }
    let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
    [(1.0, 1.0), (1.0, -1.0), (-1.0, -1.0), (-1.0, 1.0)]
        .iter()
        .map(|(a, b)| {
            let mut corner = Vec3::zeros();
            corner[axis] = -half[axis] * f64::signum(steepest);
            corner[u] = half[u] * a;
            corner[v] = half[v] * b;
            middle + turn * corner
        })
        .collect()
}

fn box_of_inertia(character: &Character, kinematics: &Kinematics, foot: usize) -> Vec<Vec3> {
    let inertial = &character.bodies[foot].inertial;
    if inertial.mass <= 0.0 {
        return Vec::new();
    }
    let d = inertial.diagonal;
    let half = Vec3::from_fn(|i, _| (1.5 * (d.sum() - 2.0 * d[i]) / inertial.mass).max(0.0).sqrt());
    let turn = kinematics.body_orientation[foot] * inertial.orientation;
    lower_face(&kinematics.point(foot, &inertial.com), &turn, &half)
}
