//! The standing pose of a skeleton whose file does not say it: axes of the world and the frame of every joint.
//!
//! Zero rotations are the rest pose if they make a body that stands. Else (bones along one axis, as in LAFAN1,
//! Rokoko's exports and bone-aligned rigs) every joint's frame is found from the places of joints over time. A frame
//! has two parts: the direction of its bone is exact. The turn about the bone leaves the joint on average without
//! twist against its parent. It is set to the nearest axis of the frame if one is near.

use std::f64::consts::FRAC_PI_2;

use lifelike_character::{Quat, Role, Vec3};
use nalgebra::{Matrix3, Rotation3};

use super::anatomy::{Body, Posture, Samples, stands_on_zero, walks};
use super::axes::Axis;
use crate::roles::{self, ARMS, LEGS, Roles, Tree};

/// A frame's axis within this angle (rad) of where it would point is taken to point there exactly.
const NEAR: f64 = 0.35;
/// Dip (rad) of the line from ankle to toes of a flat foot, where neither toes nor stance show it.
const USUAL_DIP: f64 = 0.4;

/// Meaning of a file's axes and frames.
pub(crate) struct Standing {
    /// Turns the file's world into ours (z up, x forward, y left).
    pub basis: Quat,
    /// World rotation of each joint's frame in the standing pose, in the file's axes.
    pub rest: Vec<Quat>,
    pub notes: Vec<String>,
}

/// Axes that a user states.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Stated {
    pub up: Option<Axis>,
    pub forward: Option<Axis>,
}

/// Axes and rest pose that a format fixes.
pub(crate) struct Known {
    /// Turns the file's world into ours.
    pub basis: Quat,
    /// World rotation of each joint's frame in the rest pose, in the file's axes.
    pub rest: Vec<Quat>,
}

impl Known {
    fn directions(&self) -> Option<Directions> {
        let back = self.basis.inverse();
        Some(Directions { up: back * Vec3::z(), left: back * Vec3::y() })
    }
}

/// The directions of a standing body.
#[derive(Debug, Clone, Copy)]
struct Directions {
    up: Vec3,
    left: Vec3,
}

impl Directions {
    fn forward(&self) -> Vec3 {
        self.left.cross(&self.up)
    }

    /// Returns the turn from our axes to these.
    fn turn(&self) -> Quat {
        from_axes(self.forward(), self.left, self.up)
    }
}

/// A skeleton with ends, in the file's axes.
pub(crate) struct Skeleton<'a> {
    pub tree: Tree<'a>,
    pub ends: &'a [(usize, Vec3)],
}

/// Finds the standing pose; left and right of `roles` are settled on the way. `known` is that of a format which says it.
/// An error says what is in doubt, and which option settles it.
pub(crate) fn find(
    skeleton: &Skeleton<'_>,
    roles: &mut Roles,
    samples: &Samples,
    stated: Stated,
    known: Option<Known>,
) -> Result<Standing, String> {
    let at_rest = match &known {
        Some(known) => known.directions(),
        None => zero_pose(skeleton.tree, roles)?,
    };
    let Some(up) = up_axis(samples, roles, at_rest, stated)? else {
        let (basis, rest) = known.map_or_else(|| default_of(skeleton.tree), |known| (known.basis, known.rest));
        return Ok(Standing { basis, rest, notes: Vec::new() });
    };
    if known.is_none() {
        settle_sides(&rest_places(skeleton.tree), at_rest, samples, roles, up)?;
    }
    check_height(samples, roles, up)?;
    let Some(at_rest) = at_rest else {
        let axes = Directions { up: up.unit(), left: facing(samples, roles, up, stated)? };
        let note = format!(
            "zero rotations are no standing pose: it was found from the motion (up {up}, forward {})",
            name(axes.forward())
        );
        let rest = Solver::new(skeleton, roles, samples, axes).solve();
        return Ok(Standing { basis: axes.turn().inverse(), rest, notes: vec![note] });
    };
    let (basis, rest) = match known {
        Some(known) => (known.basis, known.rest),
        None => (at_rest.turn().inverse(), vec![Quat::identity(); skeleton.tree.names.len()]),
    };
    let faces = |forward: Axis| forward.unit().dot(&at_rest.forward()) > 0.5;
    if up.unit().dot(&at_rest.up) > 0.5 && stated.forward.is_none_or(faces) {
        return Ok(Standing { basis, rest, notes: Vec::new() });
    }
    let axes = Directions { up: up.unit(), left: facing(samples, roles, up, stated)? };
    let note = format!(
        "the rest pose stands along {}, the motion along {up}, facing {}: the motion's axes are used (--up and --forward \
         override them)",
        name(at_rest.up),
        name(axes.forward())
    );
    let turn = axes.turn() * at_rest.turn().inverse();
    let rest = rest.into_iter().map(|frame| turn * frame).collect();
    Ok(Standing { basis: axes.turn().inverse(), rest, notes: vec![note] })
}

/// Returns the directions of the zero pose, if that stands.
fn zero_pose(tree: Tree<'_>, roles: &Roles) -> Result<Option<Directions>, String> {
    let places = rest_places(tree);
    let Some(body) = Body::new(&places, roles) else { return Ok(None) };
    let Some(up) = body.standing_axis() else { return Ok(None) };
    let mut left = left_across(&body.left(), up).ok_or("the hips' joints are in one place")?;
    if roles.unsided && side_of_front(&body, up).is_some_and(|side| side < 0.0) {
        left = -left;
    }
    Ok(Some(Directions { up: up.unit(), left }))
}

fn default_of(tree: Tree<'_>) -> (Quat, Vec<Quat>) {
    (super::raw::from_y_up_z_forward(), vec![Quat::identity(); tree.names.len()])
}

/// Refuses a body whose root has its height along another axis than the one along which the body stands.
fn check_height(samples: &Samples, roles: &Roles, up: Axis) -> Result<(), String> {
    let bodies: Vec<Body<'_>> = samples.places.iter().filter_map(|places| Body::new(places, roles)).collect();
    let Some(leg) = bodies.first().map(Body::leg_length) else { return Ok(()) };
    let range = |axis: Axis| {
        let heights = bodies.iter().map(|body| body.hips().dot(&axis.unit()) / leg);
        heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), h| (low.min(h), high.max(h)))
    };
    let (low, high) = range(up);
    if low < -0.2 || high > 0.2 {
        return Ok(());
    }
    for other in ["x", "y", "z"].iter().filter_map(|axis| axis.parse::<Axis>().ok()) {
        let (low, high) = range(other);
        if !other.is_parallel(up) && low > 0.75 && high < 1.25 {
            return Err(format!(
                "the body stands along {up}, but its root has the height of hips along {other}: places and rotations \
                 are in different axes, write both with {up} up"
            ));
        }
    }
    Ok(())
}

fn name(direction: Vec3) -> String {
    Axis::nearest(&direction).map_or_else(String::new, |(axis, _)| axis.to_string())
}

fn from_axes(forward: Vec3, left: Vec3, up: Vec3) -> Quat {
    Quat::from_rotation_matrix(&Rotation3::from_matrix_unchecked(Matrix3::from_columns(&[forward, left, up])))
}

fn rest_places(tree: Tree<'_>) -> Vec<Vec3> {
    let mut places: Vec<Vec3> = Vec::with_capacity(tree.names.len());
    for (offset, parent) in tree.offsets.iter().zip(tree.parents) {
        places.push(parent.map_or_else(Vec3::zeros, |p| places[p] + offset));
    }
    places
}

/// Returns the axis that is up in the motion; `None` where no legs tell.
fn up_axis(
    samples: &Samples,
    roles: &Roles,
    at_rest: Option<Directions>,
    stated: Stated,
) -> Result<Option<Axis>, String> {
    if stated.up.is_some() || roles.legs().is_none() {
        return Ok(stated.up);
    }
    let posture = Posture::of(samples, roles);
    let at_rest = at_rest.and_then(|axes| Some(Axis::nearest(&axes.up)?.0));
    match (at_rest, posture) {
        (Some(rest), Some(motion)) if motion.axis != rest && motion.is_steady => {
            if walks(samples, roles, motion.axis) || stands_on_zero(samples, roles, motion.axis, rest) {
                return Ok(Some(motion.axis));
            }
            Ok(Some(rest))
        }
        (Some(rest), _) => Ok(Some(rest)),
        (None, Some(motion)) => Ok(Some(motion.axis)),
        (None, None) => Err("neither rest pose nor motion shows which way is up: state it, --up y or --up z".into()),
    }
}

/// Returns the axis next to the left direction, across `up`.
fn left_across(left: &Vec3, up: Axis) -> Option<Vec3> {
    let across = left - up.unit() * up.unit().dot(left);
    Axis::nearest(&across).map(|(axis, _)| axis.unit())
}

/// Returns the left direction, where the body faces a stated axis, or the one nearest to where it faces at first.
fn facing(samples: &Samples, roles: &Roles, up: Axis, stated: Stated) -> Result<Vec3, String> {
    if let Some(forward) = stated.forward {
        if forward.is_parallel(up) {
            return Err(format!("--forward {forward} is along --up {up}"));
        }
        return Ok(up.unit().cross(&forward.unit()));
    }
    let bodies = samples.places.iter().filter_map(|places| Body::new(places, roles));
    let found = bodies.filter(|body| body.axis().is_some_and(|axis| axis.angle(&up.unit()) < 0.8));
    let found = found.map(|body| body.left()).find_map(|left| left_across(&left, up));
    found.ok_or_else(|| {
        "the motion does not show where the body faces: state it, --forward x, -x, y, -y, z or -z".into()
    })
}

/// Returns the share (-1 to 1) of the left direction that is left of where toes and knees point.
fn side_of_front(body: &Body<'_>, up: Axis) -> Option<f64> {
    let front = body.front();
    let front = front - up.unit() * up.unit().dot(&front);
    let left = body.left().try_normalize(1e-9)?;
    (front.norm() > 0.1 * body.leg_length()).then(|| left.dot(&up.unit().cross(&front.normalize())))
}

/// Makes left what is left: with the toes and knees in front, and up above. Named sides that are mirrored are an error.
fn settle_sides(
    zero: &[Vec3],
    at_rest: Option<Directions>,
    samples: &Samples,
    roles: &mut Roles,
    up: Axis,
) -> Result<(), String> {
    let rest_up = at_rest.and_then(|axes| Some(Axis::nearest(&axes.up)?.0));
    let at_zero = rest_up.and_then(|up| side_of_front(&Body::new(zero, roles)?, up));
    let votes: Vec<f64> = match at_zero {
        Some(vote) => vec![vote],
        None => samples.places.iter().filter_map(|places| side_of_front(&Body::new(places, roles)?, up)).collect(),
    };
    let mean = votes.iter().sum::<f64>() / votes.len().max(1) as f64;
    if roles.unsided {
        if votes.is_empty() {
            return Err("neither names nor feet show which leg is the left one: name the joints with --roles".into());
        }
        if mean < 0.0 {
            roles.mirror();
        }
        roles.unsided = false;
    } else if mean < -0.5 && roles.toes.iter().any(Option::is_some) {
        return Err("the joints named left are on the right of the toes: the file's axes are left-handed, or --roles must name \
                    the sides"
            .into());
    }
    Ok(())
}

/// Finds the frames of joints in the standing pose.
struct Solver<'a> {
    skeleton: &'a Skeleton<'a>,
    roles: &'a Roles,
    samples: &'a Samples,
    axes: Directions,
    children: Vec<Option<usize>>,
}

impl<'a> Solver<'a> {
    fn new(skeleton: &'a Skeleton<'a>, roles: &'a Roles, samples: &'a Samples, axes: Directions) -> Self {
        let parents = skeleton.tree.parents;
        let mut children: Vec<Option<usize>> = vec![None; parents.len()];
        let mut limbs: Vec<usize> = roles.joints.values().copied().chain(roles.toes.into_iter().flatten()).collect();
        limbs.sort_unstable();
        // The main child is the one on the way to a role; of several or none the first.
        for limb in limbs.into_iter().chain(0..parents.len()) {
            for joint in roles::ancestors(parents, limb) {
                if let Some(parent) = parents[joint] {
                    children[parent].get_or_insert(joint);
                }
            }
        }
        Self { skeleton, roles, samples, axes, children }
    }

    fn solve(&self) -> Vec<Quat> {
        let directions = self.directions();
        let count = self.skeleton.tree.names.len();
        let mut rest: Vec<Quat> = Vec::with_capacity(count);
        for joint in 0..count {
            let parent = self.skeleton.tree.parents[joint].map(|p| (p, rest[p]));
            let middle = [(Role::Pelvis, LEGS), (Role::Chest, ARMS)]
                .into_iter()
                .find(|(role, _)| self.roles.get(*role) == Some(joint))
                .and_then(|(_, limbs)| self.trunk(joint, [limbs[0][0], limbs[1][0]]));
            let bone = self.bone(joint).zip(directions[joint]);
            rest.push(match (middle, bone, parent) {
                (Some(frame), ..) => frame,
                (None, Some((bone, direction)), Some(parent)) => self.limb(joint, bone, direction, parent),
                (None, _, Some(parent)) => self.average(joint, parent),
                (None, ..) => Quat::identity(),
            });
        }
        rest
    }

    /// Returns the way each joint's bone points in the T-pose, where that is known.
    fn directions(&self) -> Vec<Option<Vec3>> {
        let Directions { up, left } = self.axes;
        let parents = self.skeleton.tree.parents;
        let mut directions = vec![None; parents.len()];
        let mut set = |role: Option<usize>, direction: Vec3| {
            if let Some(joint) = role {
                directions[joint] = Some(direction);
            }
        };
        if let Some(head) = self.roles.get(Role::Head) {
            roles::ancestors(parents, head).for_each(|joint| set(Some(joint), up));
        }
        for (side, aside) in [left, -left].into_iter().enumerate() {
            let [thigh, shank, foot] = LEGS[side].map(|role| self.roles.get(role));
            set(thigh, -up);
            set(shank, -up);
            set(foot, self.foot_direction(side));
            set(self.roles.toes[side], self.axes.forward());
            let [upper, fore, hand] = ARMS[side].map(|role| self.roles.get(role));
            if let Some(upper) = upper {
                let chest = self.roles.get(Role::Chest);
                roles::ancestors(parents, upper).take_while(|j| Some(*j) != chest).for_each(|j| set(Some(j), aside));
            }
            set(fore, aside);
            set(hand, aside);
        }
        directions
    }

    /// Returns the way from ankle to toes of a flat foot. It dips by the angle against the toes' own bone; without one, as
    /// it does while the ankle is low.
    fn foot_direction(&self, side: usize) -> Vec3 {
        let Some(foot) = self.roles.get(LEGS[side][2]) else { return self.axes.forward() };
        let up = self.axes.up;
        let toe = self.roles.toes[side].or(self.children[foot]).and_then(|toe| Some((toe, self.bone(toe)?)));
        let dip = self.bone(foot).and_then(|bone| {
            let points = |frames: &[Quat]| frames[foot] * bone;
            if let Some((toe, own)) = toe {
                let angles = self.samples.frames.iter().map(|frames| points(frames).angle(&(frames[toe] * own)));
                return median(angles.collect());
            }
            let heights: Vec<f64> = self.samples.places.iter().map(|places| places[foot].dot(&up)).collect();
            let low = median(heights.clone())?;
            let standing = self.samples.frames.iter().zip(heights).filter(|(_, height)| *height <= low);
            median(standing.map(|(frames, _)| (-points(frames).dot(&up)).clamp(-1.0, 1.0).asin()).collect())
        });
        let dip = dip.filter(|dip| (0.0..1.0).contains(dip)).unwrap_or(USUAL_DIP);
        self.axes.forward() * dip.cos() - up * dip.sin()
    }

    /// Returns the direction of a joint's bone in the joint's frame: to its main child, or its end.
    fn bone(&self, joint: usize) -> Option<Vec3> {
        let child = self.children[joint].map(|child| self.skeleton.tree.offsets[child]);
        let end = || self.skeleton.ends.iter().find(|(j, _)| *j == joint).map(|(_, offset)| *offset);
        child.filter(|offset| offset.norm() > 1e-9).or_else(end)?.try_normalize(1e-9)
    }

    /// Returns the frame of pelvis or chest: left from limb to limb, up where the trunk goes on.
    fn trunk(&self, joint: usize, limbs: [Role; 2]) -> Option<Quat> {
        let parents = self.skeleton.tree.parents;
        let branch = |role: Role| {
            let limb = self.roles.get(role)?;
            roles::ancestors(parents, limb).find(|&j| parents[j] == Some(joint))
        };
        let branches = [branch(limbs[0])?, branch(limbs[1])?];
        let offsets = self.skeleton.tree.offsets;
        let apart = offsets[branches[0]] - offsets[branches[1]];
        let size = offsets[branches[0]].norm() + offsets[branches[1]].norm();
        // Collar bones may begin in one place.
        let ends =
            if apart.norm() > 0.05 * size { branches } else { [self.roles.get(limbs[0])?, self.roles.get(limbs[1])?] };
        let left = self.seen_from(joint, |places| places[ends[0]] - places[ends[1]])?;
        let middle = |places: &[Vec3]| 0.5 * (places[ends[0]] + places[ends[1]]);
        let next = self.roles.get(Role::Head).and_then(|head| {
            roles::ancestors(parents, head).find(|&j| parents[j] == Some(joint) && offsets[j].norm() > 1e-9)
        });
        let is_pelvis = limbs[0] == LEGS[0][0];
        let up = match next {
            Some(next) if is_pelvis => self.seen_from(joint, |places| places[next] - middle(places))?,
            Some(next) => self.seen_from(joint, |places| places[next] - places[joint])?,
            None => self.seen_from(joint, |_| self.axes.up)?,
        };
        let up = (up - left * up.dot(&left)).try_normalize(1e-6)?;
        let own = from_axes(left.cross(&up), left, up);
        Some(snapped(self.axes.turn() * own.inverse(), self.axes))
    }

    /// Returns the mean direction of something in a joint's frame.
    fn seen_from(&self, joint: usize, what: impl Fn(&[Vec3]) -> Vec3) -> Option<Vec3> {
        let seen = self.samples.places.iter().zip(&self.samples.frames);
        seen.map(|(places, frames)| frames[joint].inverse() * what(places)).sum::<Vec3>().try_normalize(1e-9)
    }

    /// Returns the frame of a joint whose bone points along `direction`, without twist against its parent on average.
    fn limb(&self, joint: usize, bone: Vec3, direction: Vec3, (parent, parent_rest): (usize, Quat)) -> Quat {
        let aligned = Quat::rotation_between(&bone, &direction)
            .unwrap_or_else(|| Quat::from_axis_angle(&across(&bone), std::f64::consts::PI));
        let back = aligned.inverse();
        let (mut cosine, mut sine) = (0.0, 0.0);
        for frames in &self.samples.frames {
            let relative = parent_rest * frames[parent].inverse() * frames[joint] * back;
            let (w, along) = (relative.w, relative.imag().dot(&direction));
            cosine += w * w - along * along;
            sine += 2.0 * w * along;
        }
        let twist = sine.atan2(cosine);
        let axis = nalgebra::Unit::new_normalize(direction);
        let about = |angle: f64| Quat::from_axis_angle(&axis, angle) * aligned;
        let side = self.side_of(direction);
        let candidates = [Vec3::x(), Vec3::y(), Vec3::z()].into_iter().filter_map(|own| {
            let points = aligned * own;
            let flat = (points - direction * points.dot(&direction)).try_normalize(0.99)?;
            Some(side.dot(&direction.cross(&flat)).atan2(side.dot(&flat)))
        });
        // The turn that brings an axis of the frame to the side, or to a quarter from it, next to the mean twist.
        let exact = candidates.map(|angle| angle + ((twist - angle) / FRAC_PI_2).round() * FRAC_PI_2);
        let nearest = exact.min_by(|a, b| (a - twist).abs().total_cmp(&(b - twist).abs()));
        about(nearest.filter(|angle| (angle - twist).abs() < NEAR).unwrap_or(twist))
    }

    /// Returns a direction of the standing body across a bone.
    fn side_of(&self, direction: Vec3) -> Vec3 {
        let left = self.axes.left;
        if left.dot(&direction).abs() < 0.5 { left } else { self.axes.up }
    }

    /// Returns the frame that on average moves with the parent.
    fn average(&self, joint: usize, (parent, parent_rest): (usize, Quat)) -> Quat {
        let mut sum = nalgebra::Vector4::zeros();
        for frames in &self.samples.frames {
            let turn = parent_rest * frames[parent].inverse() * frames[joint];
            sum += turn.coords * if turn.coords.dot(&sum) < 0.0 { -1.0 } else { 1.0 };
        }
        let mean = Quat::new_normalize(nalgebra::Quaternion::from(sum));
        snapped(if sum.norm() > 1e-9 { mean } else { parent_rest }, self.axes)
    }
}

fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}

/// Returns a unit vector across another.
fn across(v: &Vec3) -> nalgebra::Unit<Vec3> {
    let helper = if v.x.abs() < 0.7 { Vec3::x() } else { Vec3::y() };
    nalgebra::Unit::new_normalize(v.cross(&helper))
}

/// Returns the frame with all axes along the body's, if one is near; else the frame itself.
fn snapped(frame: Quat, axes: Directions) -> Quat {
    let ours = axes.turn().inverse() * frame;
    let nearest = |v: Vec3| Axis::nearest(&v).map_or(v, |(axis, _)| axis.unit());
    let (x, z) = (nearest(ours * Vec3::x()), nearest(ours * Vec3::z()));
    if x.dot(&z).abs() > 0.5 {
        return frame;
    }
    let exact = axes.turn() * from_axes(x, z.cross(&x), z);
    if exact.angle_to(&frame) < NEAR { exact } else { frame }
}
