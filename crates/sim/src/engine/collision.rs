//! Collision detection: the robot with the ground and with itself.

use super::box_collision::{self, ContactPoint, Cuboid};
use super::contact::{ContactCandidate, Contacts};
use super::lanes::{Lanes, Scalar};
use super::shapes::{GroundShape, Pair, ROUNDING, Shape};
use super::solver_context::{Forces, SolverContext};
use super::spatial::{Vec3, add, along, cross, dot, rotate_constant, sub};
use super::tree::Tree;

/// Poses of the shapes that may touch each other, axes of the world, from the root's position.
#[derive(Debug, Clone)]
pub struct Detector<V: Lanes> {
    center: Vec<Vec3<V>>,
    axis: Vec<Vec3<V>>,
    /// Axes of boxes, the columns of their rotation.
    turn: Vec<[Vec3<V>; 3]>,
    /// Pairs that may touch in this state.
    near: Vec<usize>,
}

impl<V: Lanes> Detector<V> {
    pub fn new(tree: &Tree<V::Scalar>) -> Self {
        let nowhere = vec![[V::zero(); 3]; tree.shapes.len()];
        Self {
            center: nowhere.clone(),
            axis: nowhere,
            turn: vec![[[V::zero(); 3]; 3]; tree.shapes.len()],
            near: Vec::new(),
        }
    }

    fn update(&mut self, s: &SolverContext<'_, V>) {
        V::vectorize(
            #[inline(always)]
            || {
                for (i, shape) in s.tree.shapes.iter().enumerate() {
                    let (rotation, position) = (&s.dynamics.rotation[shape.body], &s.dynamics.position[shape.body]);
                    self.center[i] = add(position, &rotate_constant(rotation, &shape.center));
                    self.axis[i] = rotate_constant(rotation, &shape.axis);
                    if let Some((_, local)) = &shape.cuboid {
                        for (k, axis) in self.turn[i].iter_mut().enumerate() {
                            *axis = rotate_constant(rotation, &[local[k], local[3 + k], local[6 + k]]);
                        }
                    }
                }
            },
        );
    }

    /// Returns the reach of a shape from its centre along a direction of unit length, and back.
    #[inline(always)]
    fn extent(&self, i: usize, shape: &Shape<V::Scalar>, direction: &Vec3<V>) -> V {
        match &shape.cuboid {
            None => dot(&self.axis[i], direction).abs() + V::splat(shape.radius),
            Some((half, _)) => {
                let turn = &self.turn[i];
                (dot(&turn[0], direction).abs() * V::splat(half[0]))
                    .add_mul(dot(&turn[1], direction).abs(), V::splat(half[1]))
                    .add_mul(dot(&turn[2], direction).abs(), V::splat(half[2]))
            }
        }
    }
}

impl<V: Lanes> Detector<V> {
    /// The contacts of a state. Forces of the step before end where nothing touches any more.
    pub fn find(&mut self, s: &SolverContext<'_, V>, forces: &mut Forces<V>, contacts: &mut Contacts<V>) {
        contacts.clear();
        let mut slot = 0;
        for shape in &s.tree.ground_shapes {
            collide_ground(s, shape, slot, forces, contacts);
            slot += shape.count();
        }
        self.update(s);
        self.find_near(s, forces);
        for i in &self.near {
            let pair = &s.tree.pairs[*i];
            if s.tree.shapes[pair.shapes[1]].cuboid.is_some() {
                self.collide_box(s, pair, forces, contacts);
            } else {
                self.collide_round(s, pair, forces, contacts);
            }
        }
    }

    /// Finds the pairs whose centres are near each other in any environment, and ends the forces between the others.
    fn find_near(&mut self, s: &SolverContext<'_, V>, forces: &mut Forces<V>) {
        V::vectorize(
            #[inline(always)]
            || {
                self.near.clear();
                for (i, pair) in s.tree.pairs.iter().enumerate() {
                    if self.nearness(pair).any_positive() {
                        self.near.push(i);
                    } else {
                        for slot in pair.first..pair.first + pair.contacts {
                            forces.end(slot);
                        }
                    }
                }
            },
        );
    }

    /// Above zero where the centres are near each other.
    #[inline(always)]
    fn nearness(&self, pair: &Pair<V::Scalar>) -> V {
        let between = sub(&self.center[pair.shapes[1]], &self.center[pair.shapes[0]]);
        V::splat(pair.reach_squared) - dot(&between, &between)
    }

    /// Two spheres or capsules: the nearest points of two lines.
    fn collide_round(
        &self,
        s: &SolverContext<'_, V>,
        pair: &Pair<V::Scalar>,
        forces: &mut Forces<V>,
        contacts: &mut Contacts<V>,
    ) {
        V::vectorize(
            #[inline(always)]
            || {
                let (zero, one, tiny) = (V::zero(), V::splat_f64(1.0), V::splat_f64(1e-12));
                let [a, b] = pair.shapes;
                let (p, q) = (&self.axis[a], &self.axis[b]);
                let apart = sub(&self.center[a], &self.center[b]);
                let (pp, pq, qq) = (dot(p, p), -dot(p, q), dot(q, q));
                let (u, v) = (-dot(p, &apart), dot(q, &apart));
                let determinant = (pp * qq).sub_mul(pq, pq);
                // Of parallel lines, the points nearest to the first one's centre.
                let crossing = determinant - V::splat_f64(1e-5) * pp * qq;
                let x = crossing.select_gt(zero, inside((qq * u).sub_mul(pq, v) / determinant.max(tiny * tiny)), zero);
                let y = inside(v.sub_mul(pq, x) / qq.max(tiny));
                let x = inside(u.sub_mul(pq, y) / pp.max(tiny));
                let on_a = along(&self.center[a], p, x);
                let on_b = along(&self.center[b], q, y);
                let gap = sub(&on_b, &on_a);
                let length = dot(&gap, &gap).sqrt();
                let inverse = length.max(V::splat_f64(1e-9)).recip();
                let known = length - V::splat_f64(1e-9);
                let normal = [
                    known.select_gt(zero, gap[0] * inverse, one),
                    known.select_gt(zero, gap[1] * inverse, zero),
                    known.select_gt(zero, gap[2] * inverse, zero),
                ];
                let (shape_a, shape_b) = (&s.tree.shapes[a], &s.tree.shapes[b]);
                let distance = length - V::splat(shape_a.radius) - V::splat(shape_b.radius);
                let penetration = V::splat(pair.mixed.margin) - distance;
                let touching = penetration.select_gt(zero, one, zero);
                if forces.keep(pair.first, touching) {
                    let point = along(&on_a, &normal, V::splat(shape_a.radius).add_mul(distance, V::splat_f64(0.5)));
                    contacts.push(s, &pair.candidate(s, 0, point, normal, penetration, touching));
                }
            },
        );
    }

    /// With a box: environment by environment, those that are near.
    fn collide_box(
        &self,
        s: &SolverContext<'_, V>,
        pair: &Pair<V::Scalar>,
        forces: &mut Forces<V>,
        contacts: &mut Contacts<V>,
    ) {
        V::vectorize(
            #[inline(always)]
            || {
                let (zero, one) = (V::zero(), V::splat_f64(1.0));
                // What an axis of a box separates is not near, by more than single precision could get wrong.
                let [a, b] = pair.shapes;
                let (shape_a, shape_b) = (&s.tree.shapes[a], &s.tree.shapes[b]);
                let between = sub(&self.center[b], &self.center[a]);
                let margin = V::splat(pair.mixed.margin) + V::splat_f64(ROUNDING);
                let mut near = self.nearness(pair);
                for i in [a, b].into_iter().filter(|i| s.tree.shapes[*i].cuboid.is_some()) {
                    for axis in &self.turn[i] {
                        let apart = dot(&between, axis);
                        let both = self.extent(a, shape_a, axis) + self.extent(b, shape_b, axis);
                        near = near.min(both + margin - apart.abs());
                    }
                }
                let mut found = [(zero, zero, [zero; 3], [one, zero, zero]); box_collision::MAX_POINTS];
                for lane in (0..V::LANES).filter(|lane| near.lane(*lane) > Scalar::new(0.0)) {
                    for (slot, touch) in found.iter_mut().zip(self.contact_points(s, pair, lane).iter()) {
                        slot.0.set_lane(lane, Scalar::new(pair.mixed.margin.to_f64() - touch.distance));
                        slot.1.set_lane(lane, Scalar::new(1.0));
                        for k in 0..3 {
                            slot.2[k].set_lane(lane, Scalar::new(touch.point[k]));
                            slot.3[k].set_lane(lane, Scalar::new(touch.normal[k]));
                        }
                    }
                }
                for (k, (penetration, touching, point, normal)) in found.into_iter().take(pair.contacts).enumerate() {
                    if forces.keep(pair.first + k, touching) {
                        contacts.push(s, &pair.candidate(s, k, point, normal, penetration, touching));
                    }
                }
            },
        );
    }

    fn contact_points(&self, s: &SolverContext<'_, V>, pair: &Pair<V::Scalar>, lane: usize) -> Vec<ContactPoint> {
        let vector =
            |v: &Vec3<V>| nalgebra::Vector3::new(v[0].lane(lane), v[1].lane(lane), v[2].lane(lane)).map(Scalar::to_f64);
        let cuboid = |i: usize| {
            let shape = &s.tree.shapes[i];
            let (half, _) = shape.cuboid?;
            let turn = &self.turn[i];
            let rotation = nalgebra::Matrix3::from_columns(&[vector(&turn[0]), vector(&turn[1]), vector(&turn[2])]);
            Some(Cuboid { center: vector(&self.center[i]), rotation, half: half.map(Scalar::to_f64).into() })
        };
        let [a, b] = pair.shapes;
        let margin = pair.mixed.margin.to_f64();
        match (cuboid(a), cuboid(b)) {
            (Some(a), Some(b)) => box_collision::two_boxes(&a, &b, margin),
            (None, Some(b)) => {
                let (center, axis) = (vector(&self.center[a]), vector(&self.axis[a]));
                box_collision::round_and_box(&center, &axis, s.tree.shapes[a].radius.to_f64(), &b, margin)
            }
            _ => Vec::new(),
        }
    }
}

/// One shape and the ground, level or not.
fn collide_ground<V: Lanes>(
    s: &SolverContext<'_, V>,
    shape: &GroundShape<V::Scalar>,
    first: usize,
    forces: &mut Forces<V>,
    contacts: &mut Contacts<V>,
) {
    V::vectorize(
        #[inline(always)]
        || {
            let (zero, one) = (V::zero(), V::splat_f64(1.0));
            let (rotation, position) = (&s.dynamics.rotation[shape.body], &s.dynamics.position[shape.body]);
            let Some(dof_chain) = s.tree.bodies[shape.body].last_dof else { return };
            let (top, slant) = s
                .terrain
                .map_or((s.tree.ground_height, Scalar::new(1.0)), |t| (Scalar::new(t.top()), Scalar::new(t.slant())));
            let height = s.dynamics.origin[2] - V::splat(top);
            if !(V::splat(shape.reach) * V::splat(slant) + V::splat_f64(ROUNDING) - height - position[2]).any_positive()
            {
                for slot in first..first + shape.count() {
                    forces.keep(slot, zero);
                }
                return;
            }
            let middle = shape.middle.map(|m| add(position, &rotate_constant(rotation, &m)));
            let axis = shape.axis.map(|a| rotate_constant(rotation, &a));
            let (radius, margin) = (V::splat(shape.radius), V::splat(shape.mixed.margin));
            let curved = shape.curved.as_ref().map(|curved| {
                let center = add(position, &rotate_constant(rotation, &curved.center));
                let (_, normal) = ground_below(s, &center, height);
                curved.points(rotation, &normal).map(|point| add(&center, &point))
            });
            for k in 0..shape.count() {
                let point = match &curved {
                    Some(points) => points[k],
                    None => add(position, &rotate_constant(rotation, &shape.points[k])),
                };
                let (above, normal) = ground_below(s, &point, height);
                let distance = above - radius;
                let penetration = margin - distance;
                let touching = match middle {
                    // A corner above the middle of its box does not touch.
                    Some(middle) => {
                        let lower = dot(&normal, &sub(&middle, &point));
                        penetration.select_gt(zero, lower.select_gt(-V::splat_f64(1e-12), one, zero), zero)
                    }
                    None => penetration.select_gt(zero, one, zero),
                };
                if forces.keep(first + k, touching) {
                    // Half way between the two surfaces.
                    let point = along(&point, &normal, -(radius.add_mul(distance, V::splat_f64(0.5))));
                    let weight = s.invweight.body[shape.body];
                    let bodies = [0, shape.body];
                    let frame = frame(normal, axis);
                    let mixed = &shape.mixed;
                    let friction = shape.foot.map_or(s.friction, |foot| s.foot_friction[foot]);
                    let slot = first + k;
                    let candidate = ContactCandidate {
                        slot,
                        bodies,
                        dof_chain,
                        point,
                        frame,
                        penetration,
                        touching,
                        weight,
                        mixed,
                        friction,
                    };
                    contacts.push(s, &candidate);
                }
            }
        },
    );
}

/// Returns the height of a point above the ground and the ground's normal; `height` is the root's above level ground.
#[inline(always)]
fn ground_below<V: Lanes>(s: &SolverContext<'_, V>, point: &Vec3<V>, height: V) -> (V, Vec3<V>) {
    let (zero, one) = (V::zero(), V::splat_f64(1.0));
    let Some(terrain) = s.terrain else { return (point[2] + height, [zero, zero, one]) };
    let mut above = zero;
    let mut normal = [zero, zero, one];
    for lane in 0..V::LANES {
        let world = [0, 1, 2].map(|k| s.dynamics.origin[k].lane(lane).to_f64() + point[k].lane(lane).to_f64());
        let (distance, n) = terrain.clearance(world);
        above.set_lane(lane, Scalar::new(distance));
        for k in 0..3 {
            normal[k].set_lane(lane, Scalar::new(n[k]));
        }
    }
    (above, normal)
}

impl<T: Scalar> Pair<T> {
    #[inline(always)]
    fn candidate<V: Lanes<Scalar = T>>(
        &self,
        s: &SolverContext<'_, V>,
        k: usize,
        point: Vec3<V>,
        normal: Vec3<V>,
        penetration: V,
        touching: V,
    ) -> ContactCandidate<'_, V> {
        let weight = s.invweight.body[self.bodies[0]] + s.invweight.body[self.bodies[1]];
        let (slot, frame) = (self.first + k, frame(normal, None));
        ContactCandidate {
            slot,
            bodies: self.bodies,
            dof_chain: self.dof_chain,
            point,
            frame,
            penetration,
            touching,
            weight,
            mixed: &self.mixed,
            friction: s.friction,
        }
    }
}

/// MuJoCo's contact frame: the first tangent lies along `hint` where that is not too near the normal, else along y or z.
#[inline(always)]
fn frame<V: Lanes>(normal: Vec3<V>, hint: Option<Vec3<V>>) -> [Vec3<V>; 3] {
    let (zero, one, half) = (V::zero(), V::splat_f64(1.0), V::splat_f64(0.5));
    let steep = normal[1].abs() - half;
    let mut tangent = across(&normal, &[zero, steep.select_gt(zero, zero, one), steep.select_gt(zero, one, zero)]);
    if let Some(hint) = hint {
        let hint = across(&normal, &hint);
        let long = dot(&hint, &hint).sqrt() - half;
        for k in 0..3 {
            tangent[k] = long.select_gt(zero, hint[k], tangent[k]);
        }
    }
    let inverse = dot(&tangent, &tangent).sqrt().max(V::splat_f64(1e-6)).recip();
    let tangent = [tangent[0] * inverse, tangent[1] * inverse, tangent[2] * inverse];
    [normal, tangent, cross(&normal, &tangent)]
}

/// The part of a vector across a direction of unit length.
#[inline(always)]
fn across<V: Lanes>(direction: &Vec3<V>, v: &Vec3<V>) -> Vec3<V> {
    along(v, direction, -dot(v, direction))
}

/// A number brought between -1 and 1.
#[inline(always)]
fn inside<V: Lanes>(x: V) -> V {
    let one = V::splat_f64(1.0);
    x.max(-one).min(one)
}
