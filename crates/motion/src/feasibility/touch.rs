//! Points of a body that could take a force from level ground.

use lifelike_character::anatomy::{lowest, outline};
use lifelike_character::{Anatomy, Character, Kinematics, Vec3};

/// Lower than this is on the ground (m): a policy stretches a leg by so much without anybody seeing it, and retargeted
/// feet swing higher.
pub const TOUCH: f64 = 0.015;

/// Points near the ground in one pose.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Touch {
    /// Points on the ground (m, world).
    pub points: Vec<Vec3>,
    /// Depth below [`TOUCH`] of the lowest point that belongs to no foot (m), and its body.
    pub other: Option<(f64, usize)>,
    /// Depth of the deepest point in the ground (m), and its body.
    pub deepest: Option<(f64, usize)>,
}

/// Finds what touches. Shapes that collide count, or all shapes of a character without such; soles always.
pub fn touches(character: &Character, anatomy: &Anatomy, pose: &Kinematics) -> Touch {
    let solid = |g: &&lifelike_character::Geom| g.body != 0 && (g.contype | g.conaffinity) != 0;
    let any = character.geoms.iter().any(|g| solid(&g));
    let shapes = character.geoms.iter().filter(|g| if any { solid(g) } else { g.body != 0 });
    let of_shapes = shapes.flat_map(|geom| lowest(geom, pose).into_iter().map(|point| (geom.body, point)));
    let soles = anatomy.soles.values();
    let of_soles = soles.flat_map(|sole| sole.corners.iter().map(|corner| (sole.body, pose.point(sole.body, corner))));
    let mut touch = Touch::default();
    for (body, point) in of_shapes.chain(of_soles) {
        if point.z >= TOUCH {
            continue;
        }
        let below = TOUCH - point.z;
        if anatomy.foot_of(character, body).is_none() && touch.other.is_none_or(|(most, _)| below > most) {
            touch.other = Some((below, body));
        }
        if point.z < 0.0 && touch.deepest.is_none_or(|(most, _)| -point.z > most) {
            touch.deepest = Some((-point.z, body));
        }
        touch.points.push(point);
    }
    touch
}

/// Returns the distance of a position outside of the points' convex outline, seen from above (m); 0 inside, `None`
/// without points.
pub fn outside(points: &[Vec3], place: &Vec3) -> Option<f64> {
    nearest(points, place).map(|nearest| (nearest.xy() - place.xy()).norm())
}

/// Returns the position of the points' convex outline, seen from above, that is nearest to a position (its height is kept): itself inside,
/// `None` without points.
pub fn nearest(points: &[Vec3], place: &Vec3) -> Option<Vec3> {
    let hull = outline(points.to_vec());
    let edges = || hull.iter().zip(hull.iter().cycle().skip(1));
    let inside = hull.len() > 2 && edges().all(|(a, b)| (b.xy() - a.xy()).perp(&(place.xy() - a.xy())) >= 0.0);
    if inside {
        return Some(*place);
    }
    let on_edge = |a: &Vec3, b: &Vec3| {
        let (along, to) = (b.xy() - a.xy(), place.xy() - a.xy());
        let share = (to.dot(&along) / along.norm_squared().max(1e-18)).clamp(0.0, 1.0);
        Vec3::new(a.x + along.x * share, a.y + along.y * share, place.z)
    };
    let far = |p: &Vec3| (p - place).norm_squared();
    edges().map(|(a, b)| on_edge(a, b)).min_by(|a, b| far(a).total_cmp(&far(b)))
}
