//! Collision of boxes with other parts of the robot, one environment at a time: rare, and full of cases.

use nalgebra::{Matrix3, Vector3};

/// Greatest number of points at which two shapes are held apart.
pub const MAX_POINTS: usize = 4;
/// An edge must separate so much better (m) than a face to be preferred: faces give more points.
const EDGE_BIAS: f64 = 1e-6;

/// A box somewhere.
#[derive(Debug, Clone, Copy)]
pub struct Cuboid {
    pub center: Vector3<f64>,
    /// Its axes are the columns.
    pub rotation: Matrix3<f64>,
    /// Half edges (m).
    pub half: Vector3<f64>,
}

/// One point where two shapes touch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactPoint {
    /// Between the surfaces.
    pub point: Vector3<f64>,
    /// From the first shape to the second.
    pub normal: Vector3<f64>,
    /// Below zero: overlap (m).
    pub distance: f64,
}

/// A sphere, or a capsule with the half axis `axis`, against a box.
pub fn round_and_box(
    center: &Vector3<f64>,
    axis: &Vector3<f64>,
    radius: f64,
    b: &Cuboid,
    margin: f64,
) -> Vec<ContactPoint> {
    let near = |touch: &ContactPoint| touch.distance < margin;
    let ball = |t: f64| ball_and_box(&(center + axis * t), radius, b);
    if *axis == Vector3::zeros() {
        return Some(ball(0.0)).into_iter().filter(near).collect();
    }
    // The distance from a box is a convex function of the place on the axis.
    let (mut low, mut high) = (-1.0, 1.0);
    for _ in 0..60 {
        let (a, c) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
        if ball(a).distance <= ball(c).distance { high = c } else { low = a }
    }
    let nearest = ball(0.5 * (low + high));
    if !near(&nearest) {
        return Vec::new();
    }
    // Over a face it is held at both ends of the stretch that lies over the face; at an edge or a corner, or where its axis is
    // inside of the box, there.
    let outward = b.rotation.transpose() * -nearest.normal;
    let face = outward.iamax();
    if outward[face].abs() > 1.0 - 1e-9 && nearest.distance > -radius {
        let (from, along) = (b.rotation.transpose() * (center - b.center), b.rotation.transpose() * axis);
        let (mut first, mut last) = (-1.0_f64, 1.0_f64);
        for k in (0..3).filter(|k| *k != face && along[*k] != 0.0) {
            let (a, c) = ((-b.half[k] - from[k]) / along[k], (b.half[k] - from[k]) / along[k]);
            (first, last) = (first.max(a.min(c)), last.min(a.max(c)));
        }
        if last - first > 1e-6 {
            return [ball(first), ball(last)].into_iter().filter(near).collect();
        }
    }
    vec![nearest]
}

/// The surface of a box nearest to a ball.
fn ball_and_box(center: &Vector3<f64>, radius: f64, b: &Cuboid) -> ContactPoint {
    let local = b.rotation.transpose() * (center - b.center);
    let nearest = Vector3::from_fn(|k, _| local[k].clamp(-b.half[k], b.half[k]));
    let gap = nearest - local;
    let (outward, distance) = match gap.norm() {
        length if length > 1e-12 => (-gap / length, length),
        // The centre is inside: out through the nearest face.
        _ => {
            let k = (b.half - local.abs()).imin();
            let mut outward = Vector3::zeros();
            outward[k] = if local[k] < 0.0 { -1.0 } else { 1.0 };
            (outward, local[k].abs() - b.half[k])
        }
    };
    let outward = b.rotation * outward;
    let point = center - outward * (distance + 0.5 * (radius - distance));
    ContactPoint { point, normal: -outward, distance: distance - radius }
}

/// Two boxes: the axis that separates them best (Gottschalk et al. 1996), then the incident face clipped by the sides of
/// the reference face, or the nearest points of two edges.
pub fn two_boxes(a: &Cuboid, b: &Cuboid, margin: f64) -> Vec<ContactPoint> {
    let apart = b.center - a.center;
    let extent = |cuboid: &Cuboid, axis: &Vector3<f64>| {
        (0..3).map(|k| cuboid.half[k] * cuboid.rotation.column(k).dot(axis).abs()).sum::<f64>()
    };
    let separation = |axis: &Vector3<f64>| apart.dot(axis).abs() - extent(a, axis) - extent(b, axis);
    let mut best = (f64::NEG_INFINITY, Vector3::zeros(), Kind::Face(true));
    for (of_a, cuboid) in [(true, a), (false, b)] {
        for k in 0..3 {
            let axis: Vector3<f64> = cuboid.rotation.column(k).into();
            let distance = separation(&axis);
            if distance > best.0 {
                best = (distance, axis, Kind::Face(of_a));
            }
        }
    }
    for i in 0..3 {
        for j in 0..3 {
            let axis = a.rotation.column(i).cross(&b.rotation.column(j));
            let length = axis.norm();
            // Parallel edges separate no better than faces.
            if length > 1e-6 {
                let axis = axis / length;
                let distance = separation(&axis);
                if distance > best.0 + EDGE_BIAS {
                    best = (distance, axis, Kind::Edges(i, j));
                }
            }
        }
    }
    let (distance, axis, kind) = best;
    if distance >= margin {
        return Vec::new();
    }
    let normal = if apart.dot(&axis) < 0.0 { -axis } else { axis };
    match kind {
        Kind::Edges(i, j) => vec![edges(a, b, (i, j), &normal, distance)],
        Kind::Face(true) => faces(a, b, &normal, margin),
        Kind::Face(false) => {
            let turned = faces(b, a, &-normal, margin).into_iter();
            turned.map(|touch| ContactPoint { normal: -touch.normal, ..touch }).collect()
        }
    }
}

/// Axis that separates two boxes best.
#[derive(Debug, Clone, Copy)]
enum Kind {
    /// A face, of the first box or of the second.
    Face(bool),
    Edges(usize, usize),
}

/// Both edges that reach furthest towards each other, at their nearest points.
fn edges(a: &Cuboid, b: &Cuboid, (i, j): (usize, usize), normal: &Vector3<f64>, distance: f64) -> ContactPoint {
    let middle = |cuboid: &Cuboid, along: usize, towards: &Vector3<f64>| {
        (0..3).filter(|k| *k != along).fold(cuboid.center, |p, k| {
            let axis = cuboid.rotation.column(k);
            p + axis * cuboid.half[k] * axis.dot(towards).signum()
        })
    };
    let (p, q) = (middle(a, i, normal), middle(b, j, &-normal));
    let (u, v) = (a.rotation.column(i), b.rotation.column(j));
    let (uv, gap) = (u.dot(&v), q - p);
    // The edges are not parallel: their cross product was an axis.
    let t = (u.dot(&gap) - uv * v.dot(&gap)) / (1.0 - uv * uv).max(1e-12);
    let on_a = p + u * t.clamp(-a.half[i], a.half[i]);
    ContactPoint { point: on_a + normal * (0.5 * distance), normal: *normal, distance }
}

/// The face of `b` that looks most against `normal`, clipped by the sides of the face of `a` that `normal` leaves.
fn faces(a: &Cuboid, b: &Cuboid, normal: &Vector3<f64>, margin: f64) -> Vec<ContactPoint> {
    let against = b.rotation.transpose() * normal;
    let k = against.iamax();
    let (side, up) = ((k + 1) % 3, (k + 2) % 3);
    let face = b.center - b.rotation.column(k) * b.half[k] * against[k].signum();
    let (x, y) = (b.rotation.column(side) * b.half[side], b.rotation.column(up) * b.half[up]);
    let mut polygon = vec![face + x + y, face - x + y, face - x - y, face + x - y];
    let leaves = (a.rotation.transpose() * normal).iamax();
    for k in (0..3).filter(|k| *k != leaves) {
        let axis: Vector3<f64> = a.rotation.column(k).into();
        for axis in [axis, -axis] {
            polygon = clip(&polygon, &axis, axis.dot(&a.center) + a.half[k]);
        }
    }
    let level = normal.dot(&a.center) + a.half[leaves];
    let touches = polygon.into_iter().map(|p| {
        let distance = normal.dot(&p) - level;
        ContactPoint { point: p - normal * (0.5 * distance), normal: *normal, distance }
    });
    spread_out(touches.filter(|touch| touch.distance < margin).collect())
}

/// The part of a polygon where `axis · p` is at most `limit` (Sutherland and Hodgman 1974).
fn clip(polygon: &[Vector3<f64>], axis: &Vector3<f64>, limit: f64) -> Vec<Vector3<f64>> {
    let mut out = Vec::with_capacity(polygon.len() + 1);
    for (i, p) in polygon.iter().enumerate() {
        let q = &polygon[(i + 1) % polygon.len()];
        let (from, to) = (axis.dot(p) - limit, axis.dot(q) - limit);
        if from <= 0.0 {
            out.push(*p);
        }
        if (from < 0.0 && to > 0.0) || (from > 0.0 && to < 0.0) {
            out.push(p + (q - p) * (from / (from - to)));
        }
    }
    out
}

/// At most [`MAX_POINTS`] of the points: the deepest, then whatever is furthest from those chosen.
fn spread_out(mut points: Vec<ContactPoint>) -> Vec<ContactPoint> {
    if points.len() <= MAX_POINTS {
        return points;
    }
    points.sort_by(|a, b| a.distance.total_cmp(&b.distance));
    let mut chosen = vec![points.remove(0)];
    while chosen.len() < MAX_POINTS {
        let apart = |p: &ContactPoint| chosen.iter().map(|c| (c.point - p.point).norm()).fold(f64::INFINITY, f64::min);
        let furthest = (0..points.len()).max_by(|i, j| apart(&points[*i]).total_cmp(&apart(&points[*j])));
        match furthest {
            Some(i) => chosen.push(points.remove(i)),
            None => break,
        }
    }
    chosen
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use nalgebra::{Quaternion, UnitQuaternion};
    use rand::{Rng, SeedableRng};

    use super::*;
    use crate::mujoco::native::{Data, Model};

    /// Our contacts and MuJoCo's of two geoms in random poses near each other: (deepest ours, deepest MuJoCo's, cosine
    /// between the normals).
    fn both(first: &str, second: &str, ours: impl Fn(&[Cuboid; 2]) -> Vec<ContactPoint>) -> Vec<(f64, f64, f64)> {
        let body = |geom: &str| format!("<body><freejoint/><geom {geom} mass=\"1\"/></body>");
        let text = format!("<mujoco><worldbody>{}{}</worldbody></mujoco>", body(first), body(second));
        let mut data = Data::new(Model::from_xml_string(&text).unwrap()).unwrap();
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(3);
        let mut out = Vec::new();
        for _ in 0..2000 {
            let mut cuboids =
                [Cuboid { center: Vector3::zeros(), rotation: Matrix3::identity(), half: Vector3::zeros() }; 2];
            for (i, cuboid) in cuboids.iter_mut().enumerate() {
                let wxyz: [f64; 4] = std::array::from_fn(|_| rng.random_range(-1.0..1.0));
                let turn = UnitQuaternion::new_normalize(Quaternion::new(wxyz[0], wxyz[1], wxyz[2], wxyz[3]));
                cuboid.center = Vector3::from_fn(|_, _| rng.random_range(-0.2..0.2));
                cuboid.rotation = *turn.to_rotation_matrix().matrix();
                cuboid.half = Vector3::from(data.model().geom_size()[i]);
                data.qpos_mut()[7 * i..7 * i + 3].copy_from_slice(cuboid.center.as_slice());
                data.qpos_mut()[7 * i + 3..7 * i + 7].copy_from_slice(&[turn.w, turn.i, turn.j, turn.k]);
            }
            data.forward();
            let theirs = data
                .contact()
                .iter()
                .min_by(|a, b| a.dist.total_cmp(&b.dist))
                .map(|c| (c.dist, Vector3::new(c.frame[0], c.frame[1], c.frame[2])));
            let own = ours(&cuboids).into_iter().min_by(|a, b| a.distance.total_cmp(&b.distance));
            match (own, theirs) {
                (None, None) => {}
                (own, theirs) => {
                    let (a, b) = (own.map_or(0.0, |t| t.distance), theirs.map_or(0.0, |t| t.0));
                    let cosine = own.zip(theirs).map_or(f64::NAN, |(a, b)| a.normal.dot(&b.1));
                    out.push((a, b, cosine));
                }
            }
        }
        out
    }

    #[test]
    fn boxes_touch_where_mujocos_do() {
        let ball = both("type=\"sphere\" size=\"0.05\"", "type=\"box\" size=\"0.15 0.1 0.06\"", |[a, b]| {
            round_and_box(&a.center, &Vector3::zeros(), 0.05, b, 0.0)
        });
        let capsule = both("type=\"capsule\" size=\"0.04 0.1\"", "type=\"box\" size=\"0.15 0.1 0.06\"", |[a, b]| {
            round_and_box(&a.center, &(a.rotation.column(2) * 0.1), 0.04, b, 0.0)
        });
        let cuboid = both("type=\"box\" size=\"0.05 0.08 0.1\"", "type=\"box\" size=\"0.15 0.1 0.06\"", |[a, b]| {
            two_boxes(a, b, 0.0)
        });
        // Where a capsule's axis is inside of the box the two have no common answer: MuJoCo's own depends on the order of its cases.
        let capsule: Vec<_> = capsule.into_iter().filter(|t| t.0 > -0.04 && t.1 > -0.039).collect();
        // Of two axes that separate boxes almost equally well either may be chosen: depths agree closer than normals.
        for (what, touches, depth, cosine) in
            [("ball", ball, 1e-12, 1.0 - 1e-9), ("capsule", capsule, 1e-9, 1.0 - 1e-9), ("box", cuboid, 2e-3, 0.98)]
        {
            let mut off: Vec<f64> = touches.iter().map(|(a, b, _)| (a - b).abs()).collect();
            off.sort_by(f64::total_cmp);
            let (typical, worst) = (off[off.len() * 9 / 10], off[off.len() - 1]);
            // Both touch or neither does; a contact of one alone has no cosine.
            let alone = touches.iter().filter(|t| t.2.is_nan() && (t.0 - t.1).abs() > 1e-9).count();
            let aside = touches.iter().map(|t| t.2).fold(1.0, f64::min);
            println!(
                "{what}: {} touch, depth {typical:.1e} m off in nine of ten, {worst:.1e} at worst, {aside}",
                off.len()
            );
            assert!(alone == 0 && off.len() > 200 && typical < 1e-9 && worst < depth && aside > cosine, "{what}");
        }
    }
}
