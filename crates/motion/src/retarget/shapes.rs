//! A character's collision shapes: how low they reach, and how deep they are in each other.

use lifelike_character::{Character, Geom, GeomShape, Kinematics, Vec3};

use super::rig::Spot;

/// A capsule fixed to a body that stands for one of its geoms.
#[derive(Debug, Clone)]
struct Capsule {
    body: usize,
    ends: [Vec3; 2],
    radius: f64,
}

/// Shapes that collide, as far as they have a simple form (no meshes, no height fields).
#[derive(Debug)]
pub(crate) struct Shapes {
    /// Geoms that can touch the ground, with the radius of a sphere about their centre that holds them.
    geoms: Vec<(Geom, f64)>,
    capsules: Vec<Capsule>,
    pairs: Vec<(usize, usize)>,
}

/// Returns the half lengths of the box that holds a shape in its frame.
fn half_size(shape: &GeomShape) -> Option<Vec3> {
    match *shape {
        GeomShape::Sphere(r) => Some(Vec3::repeat(r)),
        GeomShape::Capsule(r, h) => Some(Vec3::new(r, r, h + r)),
        GeomShape::Cylinder(r, h) => Some(Vec3::new(r, r, h)),
        GeomShape::Box(half) | GeomShape::Ellipsoid(half) => Some(half),
        GeomShape::Plane | GeomShape::Mesh(_) | GeomShape::HeightField(_) => None,
    }
}

impl Capsule {
    /// Exact for spheres and capsules; for the others a capsule along the longest side, as thick as the mean of the
    /// other two.
    fn around(geom: &Geom) -> Option<Self> {
        let half = half_size(&geom.shape)?;
        let long = half.imax();
        let radius = match geom.shape {
            GeomShape::Sphere(r) | GeomShape::Capsule(r, _) | GeomShape::Cylinder(r, _) => r,
            _ => 0.5 * (half.sum() - half[long]),
        };
        let along = geom.orientation * Vec3::ith(long, (half[long] - radius).max(0.0));
        Some(Self { body: geom.body, ends: [geom.position - along, geom.position + along], radius })
    }
}

impl Shapes {
    pub fn new(character: &Character) -> Self {
        let solid = |g: &&Geom| g.body != 0 && (g.contype | g.conaffinity) != 0;
        let geoms: Vec<(Geom, f64)> = character
            .geoms
            .iter()
            .filter(solid)
            .filter_map(|g| half_size(&g.shape).map(|h| (g.clone(), h.norm())))
            .collect();
        let capsules: Vec<Capsule> = geoms.iter().filter_map(|(g, _)| Capsule::around(g)).collect();
        let mut shapes = Self { geoms, capsules, pairs: Vec::new() };
        // What touches in the pose as written touches by construction.
        let rest = Kinematics::new(character);
        for a in 0..shapes.capsules.len() {
            for b in 0..a {
                let (i, j) = (shapes.capsules[a].body, shapes.capsules[b].body);
                let adjacent = i == j || character.bodies[i].parent == j || character.bodies[j].parent == i;
                let excluded = character.excludes.iter().any(|&(x, y)| (x, y) == (i, j) || (x, y) == (j, i));
                if !adjacent && !excluded && shapes.depth(&rest, a, b) <= 0.0 {
                    shapes.pairs.push((a, b));
                }
            }
        }
        shapes
    }

    /// Returns the deepest overlap of two parts that are not neighbours (m; 0 when none).
    pub fn self_penetration(&self, kinematics: &Kinematics) -> f64 {
        self.pairs.iter().map(|&(a, b)| self.depth(kinematics, a, b)).fold(0.0, f64::max)
    }

    /// Returns the deepest overlap (m) with its two bodies; none without pairs.
    pub fn deepest(&self, kinematics: &Kinematics) -> Option<(f64, [usize; 2])> {
        let depths = self.pairs.iter().map(|&(a, b)| (self.depth(kinematics, a, b), [a, b]));
        let (depth, pair) = depths.max_by(|a, b| a.0.total_cmp(&b.0))?;
        Some((depth, pair.map(|capsule| self.capsules[capsule].body)))
    }

    /// Calls `visit(a, b, normal, distance)` for parts nearer to each other than `margin` (m): the nearest spots of
    /// their capsules' axes, the direction from `b` to `a`, and how far these spots must be apart for the margin.
    pub fn for_each_touching(
        &self,
        kinematics: &Kinematics,
        margin: f64,
        mut visit: impl FnMut(Spot, Spot, Vec3, f64),
    ) {
        for &(i, j) in &self.pairs {
            let (a, b) = (&self.capsules[i], &self.capsules[j]);
            let (p, q) = self.nearest(kinematics, i, j);
            let wanted = a.radius + b.radius + margin;
            if let Some(normal) = (p - q).try_normalize(1e-9).filter(|_| (p - q).norm() < wanted) {
                let spot = |body: usize, w: Vec3| Spot {
                    body,
                    point: kinematics.body_orientation[body].inverse() * (w - kinematics.body_position[body]),
                };
                visit(spot(a.body, p), spot(b.body, q), normal, wanted);
            }
        }
    }

    fn depth(&self, kinematics: &Kinematics, a: usize, b: usize) -> f64 {
        let (p, q) = self.nearest(kinematics, a, b);
        self.capsules[a].radius + self.capsules[b].radius - (p - q).norm()
    }

    fn nearest(&self, kinematics: &Kinematics, a: usize, b: usize) -> (Vec3, Vec3) {
        let (a, b) = (&self.capsules[a], &self.capsules[b]);
        let [p, q] = a.ends.map(|e| kinematics.point(a.body, &e));
        let [r, s] = b.ends.map(|e| kinematics.point(b.body, &e));
        nearest_points(p, q, r, s)
    }

    /// Calls `visit(body, point in the body frame, height)` for the lowest point of each geom that reaches below
    /// `height` (m, world).
    pub fn for_each_below(&self, kinematics: &Kinematics, height: f64, mut visit: impl FnMut(usize, Vec3, f64)) {
        for (geom, reach) in &self.geoms {
            let turn = kinematics.body_orientation[geom.body];
            let centre = kinematics.body_position[geom.body] + turn * geom.position;
            if centre.z - reach > height {
                continue;
            }
            let down = (turn * geom.orientation).inverse() * -Vec3::z();
            let local = geom.position + geom.orientation * support(&geom.shape, &down);
            let lowest = kinematics.point(geom.body, &local).z;
            if lowest < height {
                visit(geom.body, local, lowest);
            }
        }
    }

    /// Returns the height of the lowest point of all (m).
    pub fn lowest(&self, kinematics: &Kinematics) -> f64 {
        let mut lowest = f64::INFINITY;
        self.for_each_below(kinematics, f64::INFINITY, |_, _, z| lowest = lowest.min(z));
        lowest
    }
}

/// Returns the point of a shape furthest in a direction (unit, shape frame).
fn support(shape: &GeomShape, d: &Vec3) -> Vec3 {
    match *shape {
        GeomShape::Sphere(r) => d * r,
        GeomShape::Capsule(r, h) => d * r + Vec3::z() * (h * d.z.signum()),
        GeomShape::Cylinder(r, h) => {
            let flat = Vec3::new(d.x, d.y, 0.0).try_normalize(1e-9).unwrap_or_else(Vec3::zeros);
            flat * r + Vec3::z() * (h * d.z.signum())
        }
        GeomShape::Box(half) => half.component_mul(&d.map(f64::signum)),
        GeomShape::Ellipsoid(half) => {
            let scaled = half.component_mul(d);
            half.component_mul(&scaled) / scaled.norm().max(1e-12)
        }
        GeomShape::Plane | GeomShape::Mesh(_) | GeomShape::HeightField(_) => Vec3::zeros(),
    }
}

/// Returns the nearest points of two line segments (Ericson, *Real-Time Collision Detection*, 5.1.9).
fn nearest_points(p1: Vec3, q1: Vec3, p2: Vec3, q2: Vec3) -> (Vec3, Vec3) {
    let (d1, d2, r) = (q1 - p1, q2 - p2, p1 - p2);
    let (a, e, f) = (d1.norm_squared(), d2.norm_squared(), d2.dot(&r));
    let tiny = 1e-12;
    let (s, t) = if a < tiny && e < tiny {
        (0.0, 0.0)
    } else if a < tiny {
        (0.0, (f / e).clamp(0.0, 1.0))
    } else {
        let c = d1.dot(&r);
        if e < tiny {
            ((-c / a).clamp(0.0, 1.0), 0.0)
        } else {
            let b = d1.dot(&d2);
            let denominator = a * e - b * b;
            let s = if denominator > tiny { ((b * f - c * e) / denominator).clamp(0.0, 1.0) } else { 0.0 };
            let t = (b * s + f) / e;
            if t < 0.0 {
                ((-c / a).clamp(0.0, 1.0), 0.0)
            } else if t > 1.0 {
                (((b - c) / a).clamp(0.0, 1.0), 1.0)
            } else {
                (s, t)
            }
        }
    };
    (p1 + d1 * s, p2 + d2 * t)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn segment_distance(p: Vec3, q: Vec3, r: Vec3, s: Vec3) -> f64 {
        let (a, b) = nearest_points(p, q, r, s);
        (a - b).norm()
    }

    #[test]
    fn distances_of_segments_by_hand() {
        let v = Vec3::new;
        let d = segment_distance(v(0.0, 0.0, 0.0), v(1.0, 0.0, 0.0), v(0.5, -1.0, 0.3), v(0.5, 1.0, 0.3));
        assert!((d - 0.3).abs() < 1e-12, "crossing: {d}");
        let d = segment_distance(v(0.0, 0.0, 0.0), v(1.0, 0.0, 0.0), v(2.0, 0.0, 0.0), v(3.0, 0.0, 0.0));
        assert!((d - 1.0).abs() < 1e-12, "in line: {d}");
        let d = segment_distance(v(0.0, 0.0, 0.0), v(1.0, 0.0, 0.0), v(0.0, 2.0, 0.0), v(1.0, 2.0, 0.0));
        assert!((d - 2.0).abs() < 1e-12, "parallel: {d}");
    }

    #[test]
    fn supports_are_the_lowest_points() {
        let down = Vec3::new(0.6, 0.0, -0.8);
        assert!((support(&GeomShape::Box(Vec3::new(1.0, 2.0, 3.0)), &down).dot(&down) - 3.0).abs() < 1e-12);
        let e = GeomShape::Ellipsoid(Vec3::new(1.0, 2.0, 3.0));
        let expected = (0.36_f64 + 0.64 * 9.0).sqrt();
        assert!((support(&e, &down).dot(&down) - expected).abs() < 1e-12);
        assert!((support(&GeomShape::Capsule(0.5, 1.0), &down).dot(&down) - 1.3).abs() < 1e-12);
    }
}
