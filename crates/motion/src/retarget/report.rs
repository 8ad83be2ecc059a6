//! Quality of a retargeted clip, measured on the clip itself.

use std::collections::BTreeMap;

use lifelike_character::{Kinematics, Role, Vec3};

use super::feet::Stance;
use super::ground::lowest_point;
use super::human::{ARM_ROLES, Human, HumanFrame, LEG_ROLES};
use super::rig::{Rig, Segment};
use super::shapes::Shapes;

mod unfollowed;

/// Mean and maximum of something over a clip.
#[derive(Debug, Clone, Copy, Default, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Spread {
    /// Mean.
    pub mean: f64,
    /// Largest value.
    pub max: f64,
}

/// Values of a [`Spread`].
#[derive(Default)]
pub(crate) struct Gather {
    sum: f64,
    max: f64,
    count: usize,
}

impl Gather {
    pub fn add(&mut self, value: f64) {
        self.sum += value;
        self.max = self.max.max(value);
        self.count += 1;
    }
    pub fn spread(&self) -> Spread {
        Spread { mean: self.sum / self.count.max(1) as f64, max: self.max }
    }
}

/// Quality of one retargeted clip.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RetargetReport {
    /// The clip.
    pub clip: String,
    /// The character.
    pub character: String,
    /// Frames of the result.
    pub frames: usize,
    /// Duration (s).
    pub seconds: f64,
    /// Character size over human size, by the legs: what positions were multiplied with.
    pub scale: f64,
    /// Speed of the motion as a multiple of the captured one.
    pub tempo: f64,
    /// Distance (m) of key bodies from where the human has them, in the character's size. The pelvis in the world (its
    /// path was scaled). Knees and feet from the hip joint, elbows and hands from the shoulder, with the character's
    /// own segment lengths along the human's directions.
    pub position_error: BTreeMap<Role, Spread>,
    /// Angle (deg) between orientations: pelvis, chest and feet whole, the head's gaze. Arms that the character lacks
    /// count by how far the human's turn from their mean direction in the chest's frame.
    pub orientation_error: BTreeMap<Role, Spread>,
    /// Limbs of the capture that nothing of the character follows, and the reverse.
    #[serde(default)]
    pub unfollowed: Vec<String>,
    /// Guesses and repairs of the capture's reader.
    #[serde(default)]
    pub notes: Vec<String>,
    /// Mean and largest horizontal speed (m/s) of sole corners within 5 mm of the ground, over frames in which their
    /// foot is labelled as standing.
    pub foot_skate: Spread,
    /// The same for all corners within 3 mm of the ground, whatever the labels say.
    pub touching_skate: Spread,
    /// Share of frames in which at least one foot stands.
    pub contact_share: f64,
    /// Depth (m) of the lowest point of the whole body below the ground; mean over all frames.
    pub ground_penetration: Spread,
    /// Height (m) of the lowest sole corner of a foot labelled as standing above the ground.
    pub ground_float: Spread,
    /// Largest excess over a joint's range (rad); 0 by construction.
    pub range_excess: f64,
    /// Share of frames in which a joint is at an end of its range (within 0.01 rad), for joints that ever are.
    pub limit_hits: BTreeMap<String, f64>,
    /// Share of frames in which a joint moves at its speed limit (above 99% of it), for joints that ever do.
    pub velocity_hits: BTreeMap<String, f64>,
    /// Overlap (m) of parts that are not neighbours, shapes taken as capsules.
    pub self_penetration: Spread,
    /// Root mean square of the joints' angular jerk (rad/s³).
    pub joint_jerk: f64,
    /// Largest change of a joint's velocity from one frame to the next (rad/s²): pops.
    pub largest_acceleration: f64,
    /// Frames solved per second of one core, everything included.
    pub frames_per_second: f64,
}

impl RetargetReport {
    /// Returns the mean of the position errors over roles (m).
    pub fn mean_position_error(&self) -> f64 {
        mean(&self.position_error)
    }

    /// Returns the mean of the orientation errors over roles (deg).
    pub fn mean_orientation_error(&self) -> f64 {
        mean(&self.orientation_error)
    }
}

fn mean(errors: &BTreeMap<Role, Spread>) -> f64 {
    errors.values().map(|spread| spread.mean).sum::<f64>() / errors.len().max(1) as f64
}

/// A retargeted clip before it is given away.
pub(super) struct Outcome<'a> {
    pub rig: &'a Rig<'a>,
    pub shapes: &'a Shapes,
    pub frames: &'a [HumanFrame],
    pub poses: &'a [Vec<f64>],
    pub stances: &'a [Stance; 2],
    pub fps: f64,
    pub tempo: f64,
}

pub(super) fn measure(outcome: &Outcome, human: &Human, clip: &str) -> RetargetReport {
    let Outcome { rig, poses, fps, .. } = *outcome;
    let mut errors = Errors::default();
    let mut ground = Ground::default();
    let mut inside = Gather::default();
    let mut kinematics = Kinematics::new(rig.character);
    let scale = rig.leg_length / human.leg_length;
    let mut before: Option<[Vec<Vec3>; 2]> = None;
    for (t, pose) in poses.iter().enumerate() {
        kinematics.update(rig.character, pose);
        errors.add(rig, &kinematics, &outcome.frames[t], scale);
        inside.add(outcome.shapes.self_penetration(&kinematics));
        ground.penetration.add((-lowest_point(rig, outcome.shapes, &kinematics)).max(0.0));
        let corners = [0, 1].map(|side: usize| {
            let foot = &rig.legs[side].foot;
            foot.corners.iter().map(|c| kinematics.point(foot.body, c)).collect::<Vec<_>>()
        });
        for side in 0..2 {
            let stands = outcome.stances[side].any(t);
            let stood = t > 0 && outcome.stances[side].any(t - 1);
            let old = before.as_ref().map(|b| b[side].as_slice());
            ground.add(&corners[side], old, stands, stood, fps);
        }
        before = Some(corners);
    }
    let unfollowed = unfollowed::limbs(rig, outcome.frames);
    errors.orientation.extend(unfollowed::arm_errors(rig, outcome.frames));
    let standing = (0..poses.len()).filter(|&t| outcome.stances.iter().any(|s| s.any(t))).count();
    let motion = Motion::measure(rig, poses, fps);
    RetargetReport {
        clip: clip.to_string(),
        character: rig.character.name.clone(),
        frames: poses.len(),
        seconds: poses.len().saturating_sub(1) as f64 / fps,
        scale,
        tempo: outcome.tempo,
        position_error: errors.position.iter().map(|(r, g)| (*r, g.spread())).collect(),
        orientation_error: errors.orientation.iter().map(|(r, g)| (*r, g.spread())).collect(),
        unfollowed,
        notes: Vec::new(),
        foot_skate: ground.skate.spread(),
        touching_skate: ground.touching.spread(),
        contact_share: standing as f64 / poses.len() as f64,
        ground_penetration: ground.penetration.spread(),
        ground_float: ground.float.spread(),
        range_excess: motion.range_excess,
        limit_hits: motion.limit_hits,
        velocity_hits: motion.velocity_hits,
        self_penetration: inside.spread(),
        joint_jerk: motion.jerk,
        largest_acceleration: motion.acceleration,
        frames_per_second: 0.0,
    }
}

#[derive(Default)]
struct Errors {
    position: BTreeMap<Role, Gather>,
    orientation: BTreeMap<Role, Gather>,
}

impl Errors {
    fn add(&mut self, rig: &Rig, kinematics: &Kinematics, frame: &HumanFrame, scale: f64) {
        let mut position = |role, error: Vec3| self.position.entry(role).or_default().add(error.norm());
        let vector =
            |s: &Segment| kinematics.point(s.to.body, &s.to.point) - kinematics.point(s.from.body, &s.from.point);
        position(Role::Pelvis, kinematics.point(rig.hips.body, &rig.hips.point) - frame.hips * scale);
        for (side, (leg, pose)) in rig.legs.iter().zip(&frame.legs).enumerate() {
            let [_, shank, foot] = LEG_ROLES[side];
            let knee = vector(&leg.thigh) - pose.thigh * leg.thigh.length;
            position(shank, knee);
            position(foot, knee + vector(&leg.shank) - pose.shank * leg.shank.length);
            if let (Some(arm), Some(pose)) = (&rig.arms[side], &frame.arms[side]) {
                let elbow = vector(&arm.upper) - pose.upper * arm.upper.length;
                position(ARM_ROLES[side][1], elbow);
                position(ARM_ROLES[side][2], elbow + vector(&arm.fore) - pose.fore * arm.fore.length);
            }
        }
        let mut angle = |role, radians: f64| self.orientation.entry(role).or_default().add(radians.to_degrees());
        let turned = |body: usize, rest| kinematics.body_orientation[body] * lifelike_character::Quat::inverse(&rest);
        angle(Role::Pelvis, turned(rig.pelvis.0, rig.pelvis.1).angle_to(&frame.pelvis));
        if let Some((body, rest)) = rig.chest {
            angle(Role::Chest, turned(body, rest).angle_to(&frame.chest));
        }
        if let (Some((body, rest)), Some(head)) = (rig.head, frame.head) {
            angle(Role::Head, (turned(body, rest) * Vec3::x()).angle(&(head * Vec3::x())));
        }
        for ((leg, pose), roles) in rig.legs.iter().zip(&frame.legs).zip(LEG_ROLES) {
            angle(roles[2], turned(leg.foot.body, leg.foot.rest).angle_to(&pose.foot));
        }
    }
}

#[derive(Default)]
struct Ground {
    skate: Gather,
    touching: Gather,
    penetration: Gather,
    float: Gather,
}

impl Ground {
    fn add(&mut self, corners: &[Vec3], before: Option<&[Vec3]>, stands: bool, stood: bool, fps: f64) {
        if stands {
            self.float.add(corners.iter().map(|c| c.z).fold(f64::INFINITY, f64::min).max(0.0));
        }
        let Some(before) = before else { return };
        for (now, old) in corners.iter().zip(before) {
            let speed = (now - old).xy().norm() * fps;
            let highest = now.z.max(old.z);
            if stands && stood && highest < 0.005 {
                self.skate.add(speed);
            }
            if highest < 0.003 {
                self.touching.add(speed);
            }
        }
    }
}

struct Motion {
    range_excess: f64,
    limit_hits: BTreeMap<String, f64>,
    velocity_hits: BTreeMap<String, f64>,
    jerk: f64,
    acceleration: f64,
}

impl Motion {
    fn measure(rig: &Rig, poses: &[Vec<f64>], fps: f64) -> Self {
        let frames = poses.len() as f64;
        let mut motion = Self {
            range_excess: 0.0,
            limit_hits: BTreeMap::new(),
            velocity_hits: BTreeMap::new(),
            jerk: 0.0,
            acceleration: 0.0,
        };
        let (mut jerks, mut count) = (0.0, 0_usize);
        for (axis, joint) in rig.axes.iter().zip(rig.character.scalar_joints()) {
            let q = |t: usize| poses[t][axis.q];
            let (low, high) = axis.range;
            let at_limit = poses.iter().filter(|p| p[axis.q] < low + 0.01 || p[axis.q] > high - 0.01).count();
            for p in poses {
                motion.range_excess = motion.range_excess.max(low - p[axis.q]).max(p[axis.q] - high);
            }
            let at_speed = (1..poses.len()).filter(|&t| (q(t) - q(t - 1)).abs() * fps > 0.99 * axis.speed).count();
            for (map, hits) in [(&mut motion.limit_hits, at_limit), (&mut motion.velocity_hits, at_speed)] {
                if hits > 0 {
                    map.insert(joint.name.clone(), hits as f64 / frames);
                }
            }
            for t in 2..poses.len() {
                let acceleration = (q(t) - 2.0 * q(t - 1) + q(t - 2)) * fps * fps;
                motion.acceleration = motion.acceleration.max(acceleration.abs());
                if t > 2 {
                    let jerk = (q(t) - 3.0 * q(t - 1) + 3.0 * q(t - 2) - q(t - 3)) * fps.powi(3);
                    jerks += jerk * jerk;
                    count += 1;
                }
            }
        }
        motion.jerk = (jerks / count.max(1) as f64).sqrt();
        motion
    }
}
