//! Convex outlines of points.

use crate::rotation::Vec3;

/// Returns the convex outline of points, seen from above, counter-clockwise (Andrew's monotone chain). Points above
/// each other count once.
pub fn outline(mut points: Vec<Vec3>) -> Vec<Vec3> {
    points.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    points.dedup_by(|a, b| (a.xy() - b.xy()).norm() < 1e-6);
    if points.len() < 3 {
        return points;
    }
    let turn = |o: &Vec3, a: &Vec3, b: &Vec3| (a.xy() - o.xy()).perp(&(b.xy() - o.xy()));
    let half = |points: &mut dyn Iterator<Item = &Vec3>| {
        let mut chain: Vec<Vec3> = Vec::new();
        for p in points {
            while chain.len() >= 2 && turn(&chain[chain.len() - 2], &chain[chain.len() - 1], p) <= 1e-9 {
                chain.pop();
            }
            chain.push(*p);
        }
        chain.pop();
        chain
    };
    let mut hull = half(&mut points.iter());
    hull.extend(half(&mut points.iter().rev()));
    hull
}
