//! Collision shapes of a robot: against the ground, and against its other parts.

use lifelike_character::{Character, Geom, GeomShape, Vec3};
use lifelike_robot::Robot;

use super::curved::{Curved, Form};
use super::dof_chain::DofChain;
use super::lanes::Scalar;
use super::surface::{Mixed, Surface};

/// A convex part of the robot, in its body's frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Shape<T> {
    pub body: usize,
    pub center: [T; 3],
    /// From the centre to the end of a capsule's axis; zero for spheres and boxes.
    pub axis: [T; 3],
    /// Of a sphere or capsule (m); zero for a box.
    pub radius: T,
    /// Half edges of a box, and its axes as the columns of a row-major rotation.
    pub cuboid: Option<([T; 3], [T; 9])>,
    /// Radius of a ball about the centre that holds it (m).
    bound: f64,
}

/// A shape that may touch the ground, as the points of it that can.
#[derive(Debug, Clone, PartialEq)]
pub struct GroundShape<T> {
    pub body: usize,
    /// Points in the body frame (m).
    pub points: Vec<[T; 3]>,
    /// In place of fixed points, of a cylinder or ellipsoid.
    pub curved: Option<Curved<T>>,
    /// Every point is the centre of a ball of this radius (m).
    pub radius: T,
    /// Middle of the shape in the body frame (m): of a box only corners below it touch (MuJoCo's rule).
    pub middle: Option<[T; 3]>,
    /// Direction in the body frame that the first tangent follows.
    pub axis: Option<[T; 3]>,
    /// Furthest of its points from the body's frame, radius and margin included (m).
    pub reach: T,
    pub mixed: Mixed<T>,
    /// The foot it belongs to.
    pub foot: Option<usize>,
}

/// Two shapes of different bodies that may touch.
#[derive(Debug, Clone, PartialEq)]
pub struct Pair<T> {
    /// Indices of shapes; a box is never before what is none.
    pub shapes: [usize; 2],
    pub bodies: [usize; 2],
    /// Index of their [`DofChain`].
    pub dof_chain: usize,
    /// Square of the distance beyond which centres are too far apart to touch (m²).
    pub reach_squared: T,
    /// Index of its first contact in `Forces::contact`, and their greatest number.
    pub first: usize,
    pub contacts: usize,
    pub mixed: Mixed<T>,
}

/// Rounding error of single precision in lengths of a robot's size (m).
pub const ROUNDING: f64 = 1e-5;

/// Contacts of two boxes, and of a box with something round.
const BOX_BOX: usize = 4;
const BOX_ROUND: usize = 2;

impl<T: Scalar> GroundShape<T> {
    /// Greatest number of its contacts.
    pub fn count(&self) -> usize {
        self.curved.as_ref().map_or(self.points.len(), Curved::count)
    }
}

/// Returns true for shapes that touch the ground.
pub fn touches_ground(geom: &Geom) -> bool {
    touches_parts(geom) || matches!(geom.shape, GeomShape::Cylinder(..) | GeomShape::Ellipsoid(_))
}

/// Returns true for shapes that touch the ground and other parts of the robot.
pub fn touches_parts(geom: &Geom) -> bool {
    matches!(geom.shape, GeomShape::Sphere(_) | GeomShape::Capsule(..) | GeomShape::Box(_))
}

/// Returns the geoms of the robot that can collide.
pub fn solid(character: &Character) -> impl Iterator<Item = &Geom> {
    character.geoms.iter().filter(|g| g.body != 0 && g.collides())
}

/// Returns the pairs of a robot's own geoms that MuJoCo lets collide: masks, exclusions, and never a body and the one it hangs
/// from. Bodies without joints count as part of what they are fixed to.
pub fn collision_pairs(character: &Character) -> Vec<(&Geom, &Geom)> {
    let whole = |mut body: usize| {
        while body != 0 && character.bodies[body].joints.is_empty() {
            body = character.bodies[body].parent;
        }
        body
    };
    let above = |body: usize| whole(character.bodies[whole(body)].parent);
    let related = |a: usize, b: usize| {
        let (own, other) = (whole(a), whole(b));
        own == other || (own != 0 && other != 0 && (above(a) == other || above(b) == own))
    };
    let excluded = |a, b| character.excludes.contains(&(a, b)) || character.excludes.contains(&(b, a));
    let own: Vec<_> = solid(character).collect();
    let pairs = own.iter().enumerate().flat_map(|(i, a)| own[i + 1..].iter().map(move |b| (*a, *b)));
    pairs
        .filter(|(a, b)| {
            Surface::of(a).can_collide(&Surface::of(b)) && !related(a.body, b.body) && !excluded(a.body, b.body)
        })
        .collect()
}

/// Returns the shapes of a robot that can collide with the ground.
pub fn ground_shapes<T: Scalar>(robot: &Robot, ground: &Surface) -> Vec<GroundShape<T>> {
    let character = &robot.character;
    let excluded = |g: &Geom| character.excludes.iter().any(|pair| [(0, g.body), (g.body, 0)].contains(pair));
    solid(character)
        .filter(|g| touches_ground(g) && Surface::of(g).can_collide(ground) && !excluded(g))
        .map(|geom| {
            let mixed = Surface::of(geom).mix(ground, robot.timestep());
            ground_shape(geom, mixed, robot.anatomy.foot_of(character, geom.body))
        })
        .collect()
}

/// Returns the shapes of a robot that can collide with another part of it, and their pairs. `chain` are the dofs that move
/// a body; dof chains that are not there are added; contacts are counted on from `contacts`.
pub fn pairs<'a, T: Scalar>(
    robot: &Robot,
    chain: impl Fn(usize) -> &'a [usize],
    dof_chains: &mut Vec<DofChain>,
    contacts: &mut usize,
) -> (Vec<Shape<T>>, Vec<Pair<T>>) {
    let (mut geoms, mut shapes, mut pairs) = (Vec::<&Geom>::new(), Vec::<Shape<T>>::new(), Vec::new());
    let is_box = |g: &Geom| matches!(g.shape, GeomShape::Box(_));
    for (a, b) in collision_pairs(&robot.character).into_iter().filter(|(a, b)| touches_parts(a) && touches_parts(b)) {
        let (a, b) = if is_box(a) && !is_box(b) { (b, a) } else { (a, b) };
        let bodies = [a.body, b.body];
        let dof_chain = DofChain::between(chain(bodies[0]), chain(bodies[1]));
        if dof_chain.len() == 0 {
            continue;
        }
        let indices = [a, b].map(|geom| {
            geoms.iter().position(|g| std::ptr::eq(*g, geom)).unwrap_or_else(|| {
                geoms.push(geom);
                shapes.push(shape(geom));
                geoms.len() - 1
            })
        });
        let dof_chain = dof_chains.iter().position(|s| *s == dof_chain).unwrap_or_else(|| {
            dof_chains.push(dof_chain);
            dof_chains.len() - 1
        });
        let mixed: Mixed<T> = Surface::of(a).mix(&Surface::of(b), robot.timestep());
        let max = match (is_box(a), is_box(b)) {
            (true, _) => BOX_BOX,
            (_, true) => BOX_ROUND,
            _ => 1,
        };
        let reach = shapes[indices[0]].bound + shapes[indices[1]].bound + mixed.margin.to_f64();
        let (reach_squared, first) = (T::new((reach + ROUNDING).powi(2)), *contacts);
        pairs.push(Pair { shapes: indices, bodies, dof_chain, reach_squared, first, contacts: max, mixed });
        *contacts += max;
    }
    (shapes, pairs)
}

fn numbers<T: Scalar>(v: Vec3) -> [T; 3] {
    [T::new(v.x), T::new(v.y), T::new(v.z)]
}

fn shape<T: Scalar>(geom: &Geom) -> Shape<T> {
    let (axis, radius, cuboid, bound) = match geom.shape {
        GeomShape::Capsule(radius, half) => (Vec3::new(0.0, 0.0, half), radius, None, radius + half),
        GeomShape::Box(half) => {
            let rotation = geom.orientation.to_rotation_matrix();
            let rotation = std::array::from_fn(|i| T::new(rotation.matrix()[(i / 3, i % 3)]));
            (Vec3::zeros(), 0.0, Some((numbers(half), rotation)), half.norm())
        }
        GeomShape::Sphere(radius) => (Vec3::zeros(), radius, None, radius),
        _ => (Vec3::zeros(), 0.0, None, 0.0),
    };
    Shape {
        body: geom.body,
        center: numbers(geom.position),
        axis: numbers(geom.orientation * axis),
        radius: T::new(radius),
        cuboid,
        bound,
    }
}

fn ground_shape<T: Scalar>(geom: &Geom, mixed: Mixed<T>, foot: Option<usize>) -> GroundShape<T> {
    let (local, radius): (Vec<Vec3>, f64) = match geom.shape {
        GeomShape::Sphere(radius) => (vec![Vec3::zeros()], radius),
        GeomShape::Capsule(radius, half) => (vec![Vec3::new(0.0, 0.0, half), Vec3::new(0.0, 0.0, -half)], radius),
        GeomShape::Box(half) => {
            let sign = |i: usize, bit: usize| if i & bit != 0 { 1.0 } else { -1.0 };
            let corner = |i: usize| Vec3::new(sign(i, 1) * half.x, sign(i, 2) * half.y, sign(i, 4) * half.z);
            ((0..8).map(corner).collect(), 0.0)
        }
        _ => (Vec::new(), 0.0),
    };
    let points: Vec<Vec3> = local.into_iter().map(|p| geom.position + geom.orientation * p).collect();
    let form = match geom.shape {
        GeomShape::Cylinder(radius, half) => Some((Form::Cylinder(T::new(radius), T::new(half)), radius.hypot(half))),
        GeomShape::Ellipsoid(half) => Some((Form::Ellipsoid(numbers(half)), half.max())),
        _ => None,
    };
    let axes = || [Vec3::x(), Vec3::y(), Vec3::z()].map(|axis| numbers(geom.orientation * axis));
    let curved = form.map(|(form, _)| Curved { center: numbers(geom.position), axes: axes(), form });
    let bound = form.map_or(0.0, |(_, bound)| geom.position.norm() + bound);
    let reach = points.iter().map(|p| p.norm()).fold(bound, f64::max) + radius + mixed.margin.to_f64();
    let z = || numbers(geom.orientation * Vec3::z());
    GroundShape {
        body: geom.body,
        radius: T::new(radius),
        middle: matches!(geom.shape, GeomShape::Box(_)).then(|| numbers(geom.position)),
        axis: matches!(geom.shape, GeomShape::Capsule(..)).then(z),
        reach: T::new(reach),
        points: points.into_iter().map(numbers).collect(),
        curved,
        mixed,
        foot,
    }
}
