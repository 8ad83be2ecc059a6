//! The root's state from IMU and legs: orientation, linear velocity, height.
//!
//! A contact-aided filter ([`filter`]) for machines that measure neither velocity nor place of the root. Contacts come from
//! kinematics and accelerometer, so that no torque or force has to be measured:
//!
//! - a foot may carry weight where its lowest point is within [`NEAR`] leg lengths of the lowest of all feet;
//! - its contact point must not move faster than [`SLIDING`], or it is the slowest of these feet;
//! - nothing carries weight while the specific force is below [`FALLING`] of gravity.
//!
//! A foot that moves is believed less: its speed enters the variance of its contact point. The contact point rolls over the
//! sole: it is the mean of the sole's corners, weighted by their heights.

mod filter;

use std::sync::Arc;

use lifelike_character::Kinematics;
use lifelike_character::anatomy::Sole;
use lifelike_character::rotation::{Mat3, Quat, Vec3, from_wxyz, to_wxyz};
use lifelike_robot::Robot;
use lifelike_robot::observation::{Sensor, Source};

use crate::bus::Measurement;
use filter::{Filter, GRAVITY};

/// Greatest height of a foot that carries weight above the lowest, in heights of the standing root.
const NEAR: f64 = 0.02;
/// Speed of a contact point that slides (m/s).
const SLIDING: f64 = 0.3;
/// Share of gravity below which a robot falls freely, and the time over which the specific force is averaged (s).
const FALLING: f64 = 0.3;
const FALLING_TIME: f64 = 0.02;
/// Height over which corners of a sole share the contact (m).
const ROLLING: f64 = 0.003;
/// Density of a resting contact point's motion (m/s/√Hz).
const SLIP: f64 = 0.01;
/// Standard deviation of joint positions, with play and flex (rad).
const ENCODER: f64 = 0.005;
/// Time without a packet after which the estimate begins again (s).
const SILENCE: f64 = 0.25;

/// Estimated state of the root.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// Orientation (`wxyz`, world). The heading begins as measured and drifts with the gyroscope.
    pub orientation: [f32; 4],
    /// Angular velocity without the gyroscope's bias (rad/s, frame of the root).
    pub angular_velocity_b: [f32; 3],
    /// Position (m, world): odometry in the plane, and the height above the ground under the feet.
    pub position: [f32; 3],
    /// Linear velocity (m/s, world).
    pub linear_velocity_w: [f32; 3],
}

/// One foot.
#[derive(Debug, Clone)]
struct Foot {
    body: usize,
    corners: Vec<Vec3>,
    /// Contact point (m, frame of the foot, and frame of the root).
    local: Vec3,
    point_b: Vec3,
    /// Its velocity against the root, without the root's turn (m/s, frame of the root).
    velocity_b: Vec3,
    /// Covariance of the point by the encoders' (m², frame of the root).
    noise_b: Mat3,
    /// Height of the lowest corner over the root (m, world).
    lowest: f64,
    /// Speed of the point by the estimate (m/s, world).
    speed: f64,
    carries: bool,
}

/// The estimator of one robot.
#[derive(Debug, Clone)]
pub struct StateEstimator {
    robot: Arc<Robot>,
    kinematics: Kinematics,
    /// Generalised position of the measured joints, the root at the origin.
    joints: Vec<f64>,
    /// Joint of each column of the Jacobian.
    columns: Vec<Option<usize>>,
    filter: Filter,
    feet: Vec<Foot>,
    slip: Vec<f64>,
    /// Greatest height of a foot that carries weight above the lowest (m).
    near: f64,
    clock: Option<u64>,
    angular_velocity_b: Vec3,
    /// Averaged specific force (m/s²).
    force: f64,
    /// Height of the ground in the filter's world (m).
    ground: f64,
}

impl StateEstimator {
    /// An estimator before its first packet; `None` for a robot without a free root or feet.
    pub fn new(robot: &Arc<Robot>) -> Option<Self> {
        let character = &robot.character;
        character.root_joint()?;
        let foot = |sole: &Sole| Foot {
            body: sole.body,
            corners: sole.corners.clone(),
            local: sole.middle(),
            point_b: Vec3::zeros(),
            velocity_b: Vec3::zeros(),
            noise_b: Mat3::zeros(),
            lowest: 0.0,
            speed: 0.0,
            carries: false,
        };
        let feet: Vec<Foot> = robot.anatomy.soles.values().filter(|sole| !sole.corners.is_empty()).map(foot).collect();
        if feet.is_empty() {
            return None;
        }
        let mut columns = vec![None; character.nv];
        character.scalar_joints().enumerate().for_each(|(i, joint)| columns[joint.v_index] = Some(i));
        let mut own = Self {
            kinematics: Kinematics::new(character),
            joints: robot.default_position(),
            columns,
            filter: Filter::new(feet.len()),
            slip: vec![0.0; feet.len()],
            near: 0.0,
            clock: None,
            angular_velocity_b: Vec3::zeros(),
            force: GRAVITY,
            ground: 0.0,
            feet,
            robot: Arc::clone(robot),
        };
        let pose: Vec<f32> = robot.default_pose.iter().map(|angle| *angle as f32).collect();
        own.measure_legs(&pose, &vec![0.0; pose.len()]);
        own.near = -NEAR * own.find_lowest(&Quat::identity());
        Some(own)
    }

    /// Returns whether a controller sees what only this estimates: velocity, height or place of the root.
    pub fn is_needed_by(controller: &lifelike_robot::Controller) -> bool {
        let parts = controller.observation().parts();
        let mut sensors = parts.iter().filter_map(|part| match part.source {
            Source::Measured(sensor) => Some(sensor),
            Source::Action | Source::Reference | Source::Past => None,
        });
        sensors.any(|sensor| matches!(sensor, Sensor::RootLinearVelocity | Sensor::RootHeight | Sensor::Place))
    }

    /// Returns the estimate; none before the first packet with an accelerometer.
    pub fn estimate(&self) -> Option<Estimate> {
        self.clock?;
        let Filter { orientation, velocity, position, gyroscope_bias, .. } = &self.filter;
        let three = |v: Vec3| [v.x as f32, v.y as f32, v.z as f32];
        Some(Estimate {
            orientation: to_wxyz(orientation).map(|x| x as f32),
            angular_velocity_b: three(self.angular_velocity_b - gyroscope_bias),
            position: three(position - Vec3::new(0.0, 0.0, self.ground)),
            linear_velocity_w: three(*velocity),
        })
    }

    /// Returns whether each foot carries weight.
    pub fn contacts(&self) -> impl Iterator<Item = bool> + '_ {
        self.feet.iter().map(|foot| foot.carries)
    }

    /// Takes a packet. Those without an accelerometer are left out. Allocates nothing.
    pub fn receive(&mut self, packet: &Measurement) {
        let (gyroscope, force) = (packet.gyroscope_b.map(f64::from), packet.accelerometer_b.map(f64::from));
        let (gyroscope, force) = (Vec3::from(gyroscope), Vec3::from(force));
        if !force.iter().all(|x| x.is_finite()) {
            return;
        }
        let dt = self.clock.map_or(f64::INFINITY, |clock| packet.clock.saturating_sub(clock) as f64 * 1e-9);
        self.angular_velocity_b = gyroscope;
        if dt > SILENCE || !self.filter.is_finite() {
            self.measure_legs(&packet.position, &packet.velocity);
            self.begin(packet);
            self.clock = Some(packet.clock);
            return;
        }
        if dt == 0.0 {
            return;
        }
        self.clock = Some(packet.clock);
        self.force += (force.norm() - self.force) * (dt / FALLING_TIME).min(1.0);
        for (slip, foot) in self.slip.iter_mut().zip(&self.feet) {
            *slip = SLIP * SLIP * dt + (foot.speed * dt).powi(2);
        }
        self.filter.propagate(gyroscope, force, dt, &self.slip);
        self.measure_legs(&packet.position, &packet.velocity);
        self.roll();
        self.find_contacts();
    }

    /// Begins with the measured orientation; the feet give the velocity.
    fn begin(&mut self, packet: &Measurement) {
        let orientation = from_wxyz(packet.orientation.map(f64::from)).unwrap_or_default();
        self.force = GRAVITY;
        self.ground = 0.0;
        let lowest = self.find_lowest(&orientation);
        let mut velocity = Vec3::zeros();
        let mut roll = |foot: &mut Foot| {
            foot.local = contact_point(foot, &self.kinematics, &orientation);
            foot.point_b = self.kinematics.point(foot.body, &foot.local);
            if foot.lowest == lowest {
                velocity = -(orientation * (self.angular_velocity_b.cross(&foot.point_b) + foot.velocity_b));
            }
            foot.carries = false;
        };
        self.feet.iter_mut().for_each(&mut roll);
        self.filter.begin(orientation, velocity, Vec3::new(0.0, 0.0, -lowest));
        self.find_contacts();
    }

    /// Poses of the feet and the motion of their contact points by the joints.
    fn measure_legs(&mut self, position: &[f32], velocity: &[f32]) {
        let character = &self.robot.character;
        for (joint, angle) in character.scalar_joints().zip(position) {
            self.joints[joint.q_index] = f64::from(*angle);
        }
        if let Some(root) = character.root_joint() {
            self.joints[root.q_index..root.q_index + 7].copy_from_slice(&[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]);
        }
        self.kinematics.update(character, &self.joints);
        for foot in &mut self.feet {
            let point = self.kinematics.point(foot.body, &foot.local);
            let (mut moved, mut noise) = (Vec3::zeros(), Mat3::zeros());
            self.kinematics.for_each_column(character, foot.body, &point, |column, linear, _| {
                // The root has columns without a joint.
                let Some(joint) = self.columns[column] else { return };
                moved += linear * f64::from(velocity[joint]);
                noise += linear * linear.transpose() * (ENCODER * ENCODER);
            });
            (foot.point_b, foot.velocity_b, foot.noise_b) = (point, moved, noise);
        }
    }

    /// Writes the height of each foot's lowest corner over the root, and returns the lowest (m).
    fn find_lowest(&mut self, orientation: &Quat) -> f64 {
        for foot in &mut self.feet {
            let heights = foot.corners.iter().map(|corner| (orientation * self.kinematics.point(foot.body, corner)).z);
            foot.lowest = heights.fold(f64::INFINITY, f64::min);
        }
        self.feet.iter().map(|foot| foot.lowest).fold(f64::INFINITY, f64::min)
    }

    /// Moves the contact points over the soles.
    fn roll(&mut self) {
        for (i, foot) in self.feet.iter_mut().enumerate() {
            let local = contact_point(foot, &self.kinematics, &self.filter.orientation);
            let before = foot.point_b;
            (foot.local, foot.point_b) = (local, self.kinematics.point(foot.body, &local));
            self.filter.contacts[i] += self.filter.orientation * (foot.point_b - before);
        }
    }

    /// Decides which feet carry weight, and corrects the filter by those that did before.
    fn find_contacts(&mut self) {
        let orientation = self.filter.orientation;
        let lowest = self.find_lowest(&orientation);
        let rate = self.angular_velocity_b - self.filter.gyroscope_bias;
        let (near, falls) = (lowest + self.near, self.force < FALLING * GRAVITY);
        for foot in &mut self.feet {
            let moved = orientation * (rate.cross(&foot.point_b) + foot.velocity_b);
            foot.speed = (self.filter.velocity + moved).norm();
        }
        let is_near = |foot: &&Foot| foot.lowest < near;
        let slowest = self.feet.iter().filter(is_near).map(|foot| foot.speed).fold(f64::INFINITY, f64::min);
        let turn = orientation.to_rotation_matrix().into_inner();
        for (i, foot) in self.feet.iter_mut().enumerate() {
            let carries = !falls && foot.lowest < near && (foot.speed < SLIDING || foot.speed == slowest);
            let noise = turn * foot.noise_b * turn.transpose() + Mat3::from_diagonal_element(1e-8);
            if carries && foot.carries {
                self.filter.correct(i, foot.point_b, &noise);
            } else {
                self.filter.place(i, foot.point_b, &noise);
            }
            foot.carries = carries;
        }
        let down = self.feet.iter().zip(&self.filter.contacts).filter(|(foot, _)| foot.carries);
        let ground = down.map(|(_, point)| point.z).fold(f64::INFINITY, f64::min);
        if ground.is_finite() {
            self.ground = ground;
        }
    }
}

/// Returns the mean of a sole's corners, each weighted by its height over the lowest (m, frame of the foot).
fn contact_point(foot: &Foot, kinematics: &Kinematics, orientation: &Quat) -> Vec3 {
    let height = |corner: &Vec3| (orientation * kinematics.point(foot.body, corner)).z;
    let lowest = foot.corners.iter().map(height).fold(f64::INFINITY, f64::min);
    let (mut sum, mut weights) = (Vec3::zeros(), 0.0);
    for corner in &foot.corners {
        let weight = (-(height(corner) - lowest) / ROLLING).exp();
        (sum, weights) = (sum + corner * weight, weights + weight);
    }
    sum / weights
}
