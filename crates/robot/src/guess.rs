//! Actuators of robots whose profile names none: from the model's own actuators, else from masses and lengths.

use lifelike_character::{Actuator, Anatomy, Character, Joint, JointKind, Kinematics, Mat3, Role};
use nalgebra::DMatrix;

use crate::actuator::ActuatorParameters;

/// Natural frequency of a joint's rotor on its gain alone (rad/s): 10 Hz, near what the drives of common robots have.
const ROTOR_FREQUENCY: f64 = 2.0 * std::f64::consts::PI * 10.0;

/// The inertia that counts as none (kg m²).
const NOTHING: f64 = 1e-6;

/// Guesses the rotor inertia of hinges where the model says nothing of it (kg m²), in the character's order. Strong
/// geared motors are heavy, through their gears more so than the link that they move: without its rotor a foot would
/// weigh next to nothing to the ankle, and no gain that can hold the robot would be stable.
pub(crate) fn rotors(character: &Character, anatomy: &Anatomy, notes: &mut Vec<String>) -> Vec<Option<f64>> {
    let kinematics = Kinematics::new(character);
    let inertias = effective_inertias(character, &kinematics);
    let rotor = |joint: &Joint| {
        let own = servo(character, joint).is_some_and(|a| a.kp.is_some());
        let unknown = joint.kind == JointKind::Hinge && joint.armature == 0.0 && !own;
        // A link that weighs nothing is a mistake in the model, to be told and not to be fixed.
        let unknown = unknown && inertias[joint.v_index] > NOTHING;
        let torque = || limit(character, joint).unwrap_or_else(|| load(character, anatomy, &kinematics, joint));
        unknown.then(|| torque() / (ROTOR_FREQUENCY * ROTOR_FREQUENCY))
    };
    let rotors: Vec<Option<f64>> = character.scalar_joints().map(rotor).collect();
    for (joint, armature) in character.scalar_joints().zip(&rotors) {
        if let Some(armature) = armature {
            notes.push(format!("rotor of '{}': {armature:.4} kg m2 through its gear (from the torque)", joint.name));
        }
    }
    rotors
}

/// Gain and damping of a joint's drive (N m/rad, N m s/rad).
pub(crate) type Gains = (f64, f64);

/// Returns, per scalar joint in the character's order, the spring and damper of a motor's joint that are the gains of its
/// drive in truth: Isaac Gym reads a joint's `stiffness` and `damping` so, and robots written for it have springs that no
/// motor of theirs could bend through the joint's range.
pub(crate) fn drive_gains(character: &Character, notes: &mut Vec<String>) -> Vec<Option<Gains>> {
    let gains = |joint: &Joint| {
        let motor = servo(character, joint)?.kp.is_none();
        let (low, high) = joint.range?;
        let bend = (low - joint.spring_reference).abs().max((high - joint.spring_reference).abs());
        let unbending = joint.stiffness * bend > limit(character, joint)?;
        (motor && unbending).then_some((joint.stiffness, joint.damping))
    };
    let gains: Vec<Option<Gains>> = character.scalar_joints().map(gains).collect();
    for (joint, (stiffness, damping)) in character.scalar_joints().zip(&gains).filter_map(|(j, g)| Some((j, (*g)?))) {
        notes.push(format!(
            "spring of '{}': stiffness {stiffness} and damping {damping} are its drive's gains, no spring that its motor could not bend",
            joint.name
        ));
    }
    gains
}

/// Returns a guess for every scalar joint, in the character's order; one note per joint says where it came from.
/// `drives` are the gains of [`drive_gains`].
pub(crate) fn actuators(
    character: &Character,
    anatomy: &Anatomy,
    drives: &[Option<Gains>],
    physics_hz: f64,
    notes: &mut Vec<String>,
) -> Vec<ActuatorParameters> {
    let kinematics = Kinematics::new(character);
    let inertias = effective_inertias(character, &kinematics);
    character
        .scalar_joints()
        .zip(drives)
        .map(|(joint, drive)| {
            let (parameters, source) =
                actuator(character, anatomy, &kinematics, joint, *drive, inertias[joint.v_index], physics_hz);
            notes.push(format!(
                "actuator of '{}': kp {:.3}, kd {:.3}, at most {:.2} N m ({source})",
                joint.name, parameters.kp, parameters.kd, parameters.torque_max
            ));
            parameters
        })
        .collect()
}

fn actuator(
    character: &Character,
    anatomy: &Anatomy,
    kinematics: &Kinematics,
    joint: &Joint,
    drive: Option<Gains>,
    inertia: f64,
    physics_hz: f64,
) -> (ActuatorParameters, &'static str) {
    let own = servo(character, joint);
    let gear = own.map_or(1.0, |a| a.gear.abs());
    let limit = limit(character, joint);
    let load = load(character, anatomy, kinematics, joint);
    let torque_max = limit.unwrap_or(load);
    let kp = own.and_then(|a| a.kp).map(|kp| kp * gear * gear).filter(|kp| kp.is_finite() && *kp > 0.0);
    let kd = own.and_then(|a| a.kv).map(|kv| kv * gear * gear).filter(|kv| kv.is_finite() && *kv > 0.0);
    let source = match (kp, limit) {
        _ if drive.is_some() => "the joint's stiffness and damping, as far as they are stable; the model's limits",
        (Some(_), Some(_)) => "the model's gains and limits",
        (Some(_), None) => "the model's gains; torque from the weight it may carry",
        (None, Some(_)) => "the model's limits; gains from the torque",
        (None, None) => "from the weight it may carry",
    };
    // One radian of error asks for the whole torque, as on the legs of common robots; 40 ms of velocity are damped.
    // Explicit PD control is stable while kp h² and kd h stay well below the inertia that the motor feels.
    let (stable_kp, stable_kd) = (0.25 * inertia * physics_hz * physics_hz, 0.5 * inertia * physics_hz);
    let kp = kp.unwrap_or(drive.map_or(torque_max, |(stiffness, _)| stiffness).min(stable_kp));
    let kd = kd.unwrap_or(drive.map_or(0.04 * kp, |(_, damping)| damping).min(stable_kd));
    let parameters = ActuatorParameters {
        kp,
        kd,
        friction_velocity: 0.1,
        static_friction: 0.0,
        viscous_friction: 0.0,
        torque_max,
        full_torque_velocity: 10.0,
        velocity_max: 30.0,
    };
    (parameters, source)
}

/// Returns the model's own actuator of a joint.
fn servo<'a>(character: &'a Character, joint: &Joint) -> Option<&'a Actuator> {
    let index = character.joints.iter().position(|j| j.name == joint.name);
    character.actuators.iter().find(|a| Some(a.joint) == index)
}

/// Returns the largest torque that the model allows (N m).
fn limit(character: &Character, joint: &Joint) -> Option<f64> {
    let own = servo(character, joint);
    let gear = own.map_or(1.0, |a| a.gear.abs());
    let largest = |range: (f64, f64)| range.0.abs().max(range.1.abs());
    let limits = [
        own.and_then(|a| a.force_range).map(|r| largest(r) * gear),
        // The control of a motor is its force; that of a position servo is an angle.
        own.filter(|a| a.kp.is_none()).and_then(|a| a.ctrl_range).map(|r| largest(r) * gear),
        joint.actuator_force_range.map(largest),
    ];
    limits.into_iter().flatten().filter(|l| l.is_finite() && *l > 0.0).reduce(f64::min)
}

/// Returns the length of a leg from hip over knee to ankle, mean over the legs that the model has whole (m).
pub(crate) fn leg_length(character: &Character, anatomy: &Anatomy) -> Option<f64> {
    let kinematics = Kinematics::new(character);
    let legs =
        [[Role::LeftThigh, Role::LeftShank, Role::LeftFoot], [Role::RightThigh, Role::RightShank, Role::RightFoot]];
    let point = |role: &Role| anatomy.places.get(role).map(|place| kinematics.point(place.body, &place.point));
    let length = |leg: &[Role; 3]| {
        let [hip, knee, ankle] = [point(&leg[0])?, point(&leg[1])?, point(&leg[2])?];
        Some((hip - knee).norm() + (knee - ankle).norm())
    };
    let lengths: Vec<f64> = legs.iter().filter_map(length).filter(|length| *length > 0.0).collect();
    (!lengths.is_empty()).then(|| lengths.iter().sum::<f64>() / lengths.len() as f64)
}

/// Returns per scalar joint the torque that it holds while the robot stands on bent legs (N m); `None` beside the legs.
pub(crate) fn standing_loads(character: &Character, anatomy: &Anatomy) -> Vec<Option<f64>> {
    let kinematics = Kinematics::new(character);
    character.scalar_joints().map(|joint| standing_load(character, anatomy, &kinematics, joint)).collect()
}

/// Returns 0.6 of the whole weight at the leg's length (N m), for a joint of a leg.
fn standing_load(character: &Character, anatomy: &Anatomy, kinematics: &Kinematics, joint: &Joint) -> Option<f64> {
    let gravity = character.gravity.norm().max(1.0);
    let legs = [(Role::LeftThigh, Role::LeftFoot), (Role::RightThigh, Role::RightFoot)];
    legs.into_iter().find_map(|(thigh, foot)| {
        let (thigh, foot) = (anatomy.places.get(&thigh)?, anatomy.places.get(&foot)?);
        let length = (kinematics.point(thigh.body, &thigh.point) - kinematics.point(foot.body, &foot.point)).norm();
        is_below(character, foot.body, joint.body).then_some(0.6 * character.mass() * gravity * length)
    })
}

/// Returns the torque that a joint may have to hold (N m): in a leg 0.6 of the whole weight at the leg's length,
/// elsewhere twice the weight beyond the joint, held out straight.
fn load(character: &Character, anatomy: &Anatomy, kinematics: &Kinematics, joint: &Joint) -> f64 {
    if let Some(load) = standing_load(character, anatomy, kinematics, joint) {
        return load.max(0.1);
    }
    let gravity = character.gravity.norm().max(1.0);
    let (mut mass, mut reach) = (0.0, 0.0_f64);
    let anchor = kinematics.body_position[joint.body];
    for (i, body) in character.bodies.iter().enumerate().filter(|&(i, _)| is_below(character, i, joint.body)) {
        mass += body.inertial.mass;
        reach = reach.max((kinematics.point(i, &body.inertial.com) - anchor).norm());
    }
    (2.0 * mass * gravity * reach).max(0.1)
}

/// Returns the inertia that each joint's motor feels in the reference pose (kg m², or kg for a slide), by velocity
/// index: the inverse of the diagonal of the inverse mass matrix, so that it counts what gives way on both sides of the
/// joint.
fn effective_inertias(character: &Character, kinematics: &Kinematics) -> Vec<f64> {
    let mut mass = DMatrix::<f64>::zeros(character.nv, character.nv);
    for (i, body) in character.bodies.iter().enumerate().skip(1) {
        let inertial = &body.inertial;
        let jacobian = kinematics.jacobian(character, i, &kinematics.point(i, &inertial.com));
        let axes = (kinematics.body_orientation[i] * inertial.orientation).to_rotation_matrix().into_inner();
        let inertia = axes * Mat3::from_diagonal(&inertial.diagonal) * axes.transpose();
        let (linear, angular) = (jacobian.rows(0, 3), jacobian.rows(3, 3));
        mass += inertial.mass * linear.transpose() * linear;
        mass += angular.transpose() * inertia * angular;
    }
    for joint in &character.joints {
        for dof in joint.v_index..joint.v_index + joint.kind.nv() {
            mass[(dof, dof)] += joint.armature;
        }
    }
    match mass.cholesky() {
        Some(factor) => factor.inverse().diagonal().iter().map(|inverse| 1.0 / inverse).collect(),
        // Something weighs nothing: no gain is safe there.
        None => vec![NOTHING; character.nv],
    }
}

/// Returns whether `body` is `ancestor` or hangs on it.
pub(crate) fn is_below(character: &Character, mut body: usize, ancestor: usize) -> bool {
    while body != 0 {
        if body == ancestor {
            return true;
        }
        body = character.bodies[body].parent;
    }
    ancestor == 0
}
