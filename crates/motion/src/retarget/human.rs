//! The captured human as what a body can be asked to do: where the hips are, which way segments point, where the soles
//! are. Nothing here depends on the rest pose's arms or on the file's axes.

use lifelike_character::rotation::heading_angle;
use lifelike_character::{Quat, Role, Vec3};

use super::correspondence::SourceRoles;
use crate::contacts::ground_level;
use crate::roles::ancestors;
use crate::source::SourceClip;

/// Arm directions of one frame (unit vectors, world), for one side.
#[derive(Debug, Clone, Copy)]
pub(super) struct ArmPose {
    pub upper: Vec3,
    pub fore: Vec3,
    /// Direction of the hand and normal of its palm, where the skeleton has fingers.
    pub hand: Option<(Vec3, Vec3)>,
}

/// Leg of one frame, for one side.
#[derive(Debug, Clone, Copy)]
pub(super) struct LegPose {
    pub thigh: Vec3,
    pub shank: Vec3,
    /// Orientation of the foot: x towards the toes, z out of the instep; level when the sole is flat.
    pub foot: Quat,
    /// The point of the sole under the ankle, and the ends of the sole (m, world, human size, z = 0 on the ground).
    pub under: Vec3,
    pub toe: Vec3,
    pub heel: Vec3,
}

impl LegPose {
    /// Returns whether the sole looks down, if only at a slant: what touches the ground otherwise is not the sole.
    pub fn is_upright(&self) -> bool {
        (self.foot * Vec3::z()).z > 0.5
    }
}

/// One instant.
#[derive(Debug, Clone, Copy)]
pub(super) struct HumanFrame {
    /// Middle between the hip joints (m, world; z above the ground).
    pub hips: Vec3,
    pub pelvis: Quat,
    pub chest: Quat,
    pub head: Option<Quat>,
    pub legs: [LegPose; 2],
    pub arms: [Option<ArmPose>; 2],
    /// Height of the lowest joint or end (m).
    pub lowest: f64,
}

/// A captured clip at the output rate.
#[derive(Debug)]
pub(super) struct Human {
    pub frames: Vec<HumanFrame>,
    /// From the hip joint along the straight leg to the sole (m).
    pub leg_length: f64,
    /// Half the distance between the hip joints (m).
    pub hip_half_width: f64,
    /// Frames before and after the clip proper, there for a cycle's sake.
    pub padding: usize,
}

pub(super) use crate::roles::{ARMS as ARM_ROLES, LEGS as LEG_ROLES};

/// Geometry of one foot in the rest pose.
struct FootShape {
    /// From the ankle down to the sole (m).
    height: f64,
    /// From under the ankle forward to the toes (m).
    toe: f64,
    /// Yaw of the foot in the rest pose (rad).
    yaw: f64,
}

struct Reader<'a> {
    clip: &'a SourceClip,
    roles: &'a SourceRoles,
    rest: Vec<Vec3>,
    needed: Vec<bool>,
    feet: [FootShape; 2],
    /// Per side: direction of the fingers and palm normal in the hand's rest frame.
    hands: [Option<(Vec3, Vec3)>; 2],
    position: Vec<Vec3>,
    rotation: Vec<Quat>,
}

impl Human {
    /// Returns the length of the legs (m).
    pub fn leg_length_of(clip: &SourceClip, roles: &SourceRoles) -> f64 {
        Reader::new(clip, roles).leg_length()
    }

    /// Samples the clip at `fps`. A cycle is continued for up to half a second at both ends.
    pub fn read(clip: &SourceClip, roles: &SourceRoles, fps: f64) -> Self {
        let mut reader = Reader::new(clip, roles);
        let seconds = clip.seconds();
        let frames = (seconds * fps + 1e-6).floor() as usize + 1;
        let padding = if clip.cyclic { ((seconds.min(0.5)) * fps) as usize } else { 0 };
        let mut human = Self {
            frames: (0..frames + 2 * padding).map(|t| reader.sample((t as f64 - padding as f64) / fps)).collect(),
            leg_length: reader.leg_length(),
            hip_half_width: 0.5 * (reader.rest_of(Role::LeftThigh) - reader.rest_of(Role::RightThigh)).norm(),
            padding,
        };
        human.stand_on_the_ground(fps);
        human
    }

    /// Whatever height the capture's floor has, and however the foot's rest pose is tilted: a resting sole is level and
    /// at zero.
    fn stand_on_the_ground(&mut self, fps: f64) {
        let size = self.leg_length / 0.9;
        let path = |frames: &[HumanFrame], side: usize, toe: bool| -> Vec<Vec3> {
            frames.iter().map(|f| if toe { f.legs[side].toe } else { f.legs[side].heel }).collect()
        };
        let level = |side: usize, end: usize| {
            let upright = |t: usize| self.frames[t].legs[side].is_upright();
            ground_level(&path(&self.frames, side, end == 0), fps, 0.25 * size, upright)
        };
        let found = [0, 1].map(|side: usize| [0, 1].map(|end: usize| level(side, end)));
        // Of someone who never stands only the capture's own floor is known.
        let floor = found.iter().flatten().flatten().copied().min_by(f64::total_cmp).unwrap_or(0.0);
        // A foot that never comes down (hopping, lying) tells nothing about its sole.
        let levels = found.map(|ends| ends.map(|l| l.filter(|l| *l < floor + 0.07 * size).unwrap_or(floor)));
        for (side, [toe_level, heel_level]) in levels.into_iter().enumerate() {
            let flat = |leg: &LegPose| leg.toe.z - toe_level < 0.03 * size && leg.heel.z - heel_level < 0.03 * size;
            let mut up = Vec3::zeros();
            let mut count = 0;
            for leg in self.frames.iter().map(|f| &f.legs[side]).filter(|l| flat(l)) {
                up += leg.foot.inverse() * Vec3::z();
                count += 1;
            }
            let level_sole = up
                .try_normalize(1e-6)
                .filter(|u| count > 2 && u.z > 0.7)
                .and_then(|u| Quat::rotation_between(&Vec3::z(), &u))
                .unwrap_or_else(Quat::identity);
            for frame in &mut self.frames {
                let leg = &mut frame.legs[side];
                leg.foot *= level_sole;
                leg.toe.z -= toe_level;
                leg.heel.z -= heel_level;
                let whole = (leg.toe - leg.heel).norm_squared().max(1e-9);
                let share = (leg.under - leg.heel).xy().dot(&(leg.toe - leg.heel).xy()) / whole;
                leg.under.z = leg.heel.z + share.clamp(0.0, 0.5) * (leg.toe.z - leg.heel.z);
            }
        }
        for frame in &mut self.frames {
            frame.hips.z -= floor;
            frame.lowest -= floor;
        }
    }
}

/// Returns whether an ankle can do this. Captures of fast feet flip: the foot upside down, or back to front.
fn is_possible(foot: &Quat, shank: &Vec3, pelvis: &Quat) -> bool {
    let upside_down = (foot * Vec3::z()).dot(shank) > 0.2;
    let hanging = shank.dot(&(pelvis * Vec3::z())) < -0.7;
    let backwards = (foot * Vec3::x()).dot(&(pelvis * Vec3::x())) < -0.75;
    !(upside_down || (hanging && backwards))
}

/// Returns a foot at a right angle to its shank, forward like the pelvis.
fn at_rest(shank: &Vec3, pelvis: &Quat) -> Quat {
    let up = -shank;
    let left = up.cross(&(pelvis * Vec3::x())).try_normalize(1e-3).unwrap_or_else(|| pelvis * Vec3::y());
    let axes = nalgebra::Matrix3::from_columns(&[left.cross(&up), left, up]);
    Quat::from_rotation_matrix(&nalgebra::Rotation3::from_matrix_unchecked(axes))
}

impl<'a> Reader<'a> {
    fn new(clip: &'a SourceClip, roles: &'a SourceRoles) -> Self {
        let skeleton = &clip.skeleton;
        let n = skeleton.names.len();
        let mut rest: Vec<Vec3> = Vec::with_capacity(n);
        for j in 0..n {
            let from = skeleton.parents[j].map_or_else(Vec3::zeros, |p| rest[p] + skeleton.offsets[j]);
            rest.push(from);
        }
        let mut needed = vec![false; n];
        for &joint in roles.joints.values().chain(roles.toes.iter().flatten()) {
            ancestors(&skeleton.parents, joint).for_each(|j| needed[j] = true);
        }
        let mut reader = Self {
            clip,
            roles,
            rest,
            needed,
            feet: [FootShape { height: 0.0, toe: 0.0, yaw: 0.0 }, FootShape { height: 0.0, toe: 0.0, yaw: 0.0 }],
            hands: [None, None],
            position: vec![Vec3::zeros(); n],
            rotation: vec![Quat::identity(); n],
        };
        for side in 0..2 {
            reader.feet[side] = reader.foot_shape(side);
            reader.hands[side] = reader.hand_shape(side);
        }
        reader
    }

    fn joint(&self, role: Role) -> usize {
        self.roles.get(role).unwrap_or(0)
    }

    fn rest_of(&self, role: Role) -> Vec3 {
        self.rest[self.joint(role)]
    }

    /// Returns the rest positions of all joints and end sites that hang on this joint.
    fn hanging_on(&self, joint: usize) -> Vec<Vec3> {
        let skeleton = &self.clip.skeleton;
        let below = |j: usize| ancestors(&skeleton.parents, j).any(|a| a == joint);
        let joints = (0..self.rest.len()).filter(|&j| j != joint && below(j)).map(|j| self.rest[j]);
        let ends = skeleton.ends.iter().filter(|(j, _)| below(*j)).map(|(j, o)| self.rest[*j] + o);
        joints.chain(ends).collect()
    }

    fn bones(&self, side: usize) -> f64 {
        let [thigh, shank, foot] = LEG_ROLES[side].map(|r| self.rest_of(r));
        (shank - thigh).norm() + (foot - shank).norm()
    }

    fn leg_length(&self) -> f64 {
        (0..2).map(|side| 0.5 * (self.bones(side) + self.feet[side].height)).sum()
    }

    fn foot_shape(&self, side: usize) -> FootShape {
        let bones = self.bones(side);
        let joint = self.joint(LEG_ROLES[side][2]);
        let ankle = self.rest[joint];
        let hanging = self.hanging_on(joint);
        let lowest = hanging.iter().map(|p| ankle.z - p.z).fold(0.0, f64::max);
        // A foot without bones, or a toe in the air, tells no height: take a person's proportions.
        let height = if (0.02..0.16).contains(&(lowest / bones)) { lowest } else { 0.065 * bones };
        let reach = |p: Vec3| (p - ankle).xy().norm();
        let tip = self.roles.toes[side].map(|t| self.rest[t]).filter(|p| reach(*p) > 0.08 * bones);
        let tip = tip.or_else(|| hanging.iter().copied().max_by(|a, b| reach(*a).total_cmp(&reach(*b))));
        let (toe, yaw) = match tip {
            Some(p) if reach(p) > 0.08 * bones => (reach(p).min(0.25 * bones), (p.y - ankle.y).atan2(p.x - ankle.x)),
            _ => (0.16 * bones, 0.0),
        };
        FootShape { height, toe, yaw: if yaw.abs() < 0.8 { yaw } else { 0.0 } }
    }

    fn hand_shape(&self, side: usize) -> Option<(Vec3, Vec3)> {
        let roles = ARM_ROLES[side];
        let joint = self.roles.get(roles[2])?;
        let wrist = self.rest[joint];
        let fingers = self.hanging_on(joint);
        let middle = fingers.iter().map(|p| p - wrist).sum::<Vec3>();
        let direction = middle.try_normalize(1e-3)?;
        // The palm looks down when the arm is stretched out sideways; swing that with the arm's rest direction.
        let out = if side == 0 { Vec3::y() } else { -Vec3::y() };
        let arm = (wrist - self.rest_of(roles[0])).try_normalize(1e-6)?;
        let palm = Quat::rotation_between(&out, &arm)? * -Vec3::z();
        let palm = (palm - direction * palm.dot(&direction)).try_normalize(1e-3)?;
        Some((direction, palm))
    }

    /// Updates the world pose of the needed joints at a time (s), beyond the ends for cycles.
    fn pose(&mut self, time: f64) {
        let clip = self.clip;
        let (seconds, last) = (clip.seconds(), clip.len() - 1);
        let cycle = if clip.cyclic && seconds > 0.0 && !(0.0..=seconds).contains(&time) {
            (time / seconds).floor()
        } else {
            0.0
        };
        let at = ((time - cycle * seconds) * clip.fps).clamp(0.0, last as f64);
        let from = (at.floor() as usize).min(last);
        let to = (from + 1).min(last);
        let share = at - from as f64;
        for j in 0..self.needed.len() {
            if !self.needed[j] {
                continue;
            }
            let (a, b) = (&clip.rotations[from][j], &clip.rotations[to][j]);
            let local = if share == 0.0 { *a } else { a.try_slerp(b, share, 1e-9).unwrap_or(*a) };
            match clip.skeleton.parents[j] {
                None => {
                    self.position[j] = clip.root_position[from].lerp(&clip.root_position[to], share);
                    self.rotation[j] = local;
                    self.continue_cycle(j, cycle);
                }
                Some(p) => {
                    self.position[j] = self.position[p] + self.rotation[p] * clip.skeleton.offsets[j];
                    self.rotation[j] = self.rotation[p] * local;
                }
            }
        }
    }

    /// Moves the root by `cycle` whole cycles: by the change of place and heading from the first to the last frame.
    fn continue_cycle(&mut self, root: usize, cycle: f64) {
        if cycle == 0.0 {
            return;
        }
        let last = self.clip.len() - 1;
        let heading = |t: usize| heading_angle(&self.clip.rotations[t][root]);
        let turn = Quat::from_axis_angle(&Vec3::z_axis(), heading(last) - heading(0));
        let (first, end) = (self.clip.root_position[0], self.clip.root_position[last]);
        let (p, r) = (self.position[root], self.rotation[root]);
        let (position, rotation) = if cycle > 0.0 {
            (end + turn * (p - first), turn * r)
        } else {
            (first + turn.inverse() * (p - end), turn.inverse() * r)
        };
        self.position[root] = Vec3::new(position.x, position.y, p.z);
        self.rotation[root] = rotation;
    }

    fn direction(&self, from: Role, to: Role) -> Vec3 {
        let delta = self.position[self.joint(to)] - self.position[self.joint(from)];
        delta.try_normalize(1e-9).unwrap_or_else(|| -Vec3::z())
    }

    fn leg(&self, side: usize) -> LegPose {
        let [thigh, shank, foot] = LEG_ROLES[side];
        let shape = &self.feet[side];
        let ankle = self.position[self.joint(foot)];
        let shank_direction = self.direction(shank, foot);
        let captured = self.rotation[self.joint(foot)] * Quat::from_axis_angle(&Vec3::z_axis(), shape.yaw);
        let pelvis = self.rotation[self.joint(Role::Pelvis)];
        let orientation = if is_possible(&captured, &shank_direction, &pelvis) {
            captured
        } else {
            at_rest(&shank_direction, &pelvis)
        };
        let sole = |x: f64| ankle + orientation * Vec3::new(x, 0.0, -shape.height);
        LegPose {
            thigh: self.direction(thigh, shank),
            shank: shank_direction,
            foot: orientation,
            under: sole(0.0),
            toe: sole(shape.toe),
            heel: sole(-0.35 * shape.toe),
        }
    }

    fn arm(&self, side: usize) -> Option<ArmPose> {
        let [upper, fore, hand] = ARM_ROLES[side];
        let wrist = self.roles.get(hand)?;
        let turn = self.rotation[wrist];
        Some(ArmPose {
            upper: self.direction(upper, fore),
            fore: self.direction(fore, hand),
            hand: self.hands[side].map(|(direction, palm)| (turn * direction, turn * palm)),
        })
    }

    fn sample(&mut self, time: f64) -> HumanFrame {
        self.pose(time);
        let at = |role: Role| self.position[self.joint(role)];
        let legs = [self.leg(0), self.leg(1)];
        let joints = (0..self.needed.len()).filter(|&j| self.needed[j]).map(|j| self.position[j].z);
        let soles = legs.iter().flat_map(|l| [l.toe.z, l.heel.z]);
        HumanFrame {
            hips: 0.5 * (at(Role::LeftThigh) + at(Role::RightThigh)),
            pelvis: self.rotation[self.joint(Role::Pelvis)],
            chest: self.rotation[self.joint(Role::Chest)],
            head: self.roles.get(Role::Head).map(|j| self.rotation[j]),
            lowest: joints.chain(soles).fold(f64::INFINITY, f64::min),
            legs,
            arms: [self.arm(0), self.arm(1)],
        }
    }
}
