//! Actuators of robots whose profile names none: the model's own, as far as they go; the rest invented from masses and lengths.

use lifelike_character::{Actuator, Anatomy, Character, Command, Drive, Joint, JointKind, Kinematics, Role};

use crate::actuator::ActuatorParameters;

/// Natural frequency of a joint's rotor on its gain alone (rad/s): 10 Hz, near what the drives of common robots have.
const ROTOR_FREQUENCY: f64 = 2.0 * std::f64::consts::PI * 10.0;

/// The inertia that counts as none (kg m²).
const NOTHING: f64 = 1e-6;

/// Largest believable torque of a motor, as a multiple of 0.6 of the robot's weight at its greatest reach. Legs of robots have
/// 0.5 to 3 of it; files have placeholders of 1000 to 100000 N m.
const MAX_TORQUE: f64 = 10.0;

/// Torque that any small servo may have (N m), whatever the robot weighs.
const SERVO_TORQUE: f64 = 10.0;

/// Speed (rad/s) at which an actuator of unknown speed has no torque left.
const SPEED: f64 = 30.0;

/// Joints, in the character's order: a guess and the lines that tell of it.
pub(crate) struct Guesser<'a> {
    character: &'a Character,
    anatomy: &'a Anatomy,
    kinematics: Kinematics,
    inertias: Vec<f64>,
    /// One line per guess, for `inspect`.
    pub notes: Vec<String>,
}

/// Gain and damping of a joint's drive (N m/rad, N m s/rad).
pub(crate) type Gains = (f64, f64);

/// Largest torque of a joint by its model.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Limit {
    /// In both directions (N m).
    Known(f64),
    /// More than any motor has (N m).
    Placeholder(f64),
    Unknown,
}

impl<'a> Guesser<'a> {
    pub fn new(character: &'a Character, anatomy: &'a Anatomy) -> Self {
        let kinematics = Kinematics::new(character);
        // Where something weighs nothing, no gain is safe.
        let inertias = kinematics.effective_inertias(character).unwrap_or_else(|| vec![NOTHING; character.nv]);
        Self { character, anatomy, kinematics, inertias, notes: Vec::new() }
    }

    /// Guesses the rotor inertia of hinges where the model says nothing of it (kg m²). Strong geared motors are heavy, through
    /// their gears more so than the link that they move: without its rotor a foot would weigh next to nothing to the ankle, and no
    /// gain that can hold the robot would be stable.
    pub fn rotors(&mut self) -> Vec<Option<f64>> {
        let rotor = |joint: &Joint| {
            let servo = self.drive(joint).is_some_and(|drive| drive.stiffness > 0.0);
            let unknown = joint.kind == JointKind::Hinge
                && joint.armature == 0.0
                && !servo
                && !self.is_passive(joint)
                && !self.is_brake(joint);
            // A link that weighs nothing is a mistake in the model, to be told and not to be fixed.
            let unknown = unknown && self.inertias[joint.v_index] > NOTHING;
            unknown.then(|| self.torque(joint) / (ROTOR_FREQUENCY * ROTOR_FREQUENCY))
        };
        let rotors: Vec<Option<f64>> = self.character.scalar_joints().map(rotor).collect();
        for (joint, armature) in self.character.scalar_joints().zip(&rotors) {
            if let Some(armature) = armature {
                self.notes.push(format!(
                    "rotor of '{}': {armature:.4} kg m2 through its gear, invented from the torque",
                    joint.name
                ));
            }
        }
        rotors
    }

    /// Returns the spring and damper of a motor's joint that are the gains of its drive in truth: Isaac Gym reads a
    /// joint's `stiffness` and `damping` so. Robots written for it have springs that no motor of theirs could bend
    /// through the joint's range.
    pub fn drive_gains(&mut self) -> Vec<Option<Gains>> {
        let gains = |joint: &Joint| {
            let motor = self.drive(joint)?.stiffness == 0.0 && !self.is_brake(joint);
            let (low, high) = joint.range?;
            let bend = (low - joint.spring_reference).abs().max((high - joint.spring_reference).abs());
            let Limit::Known(torque) = self.limit(joint) else { return None };
            (motor && joint.stiffness * bend > torque).then_some((joint.stiffness, joint.damping))
        };
        let gains: Vec<Option<Gains>> = self.character.scalar_joints().map(gains).collect();
        for (joint, gains) in self.character.scalar_joints().zip(&gains) {
            if let Some((stiffness, damping)) = gains {
                self.notes.push(format!(
                    "spring of '{}': stiffness {stiffness} and damping {damping} are its drive's gains, no spring that its motor could not bend",
                    joint.name
                ));
            }
        }
        gains
    }

    /// Returns the actuator of every scalar joint; one note per joint says where it came from. `drives` are the gains of
    /// [`Self::drive_gains`].
    pub fn actuators(&mut self, drives: &[Option<Gains>], physics_hz: f64) -> Vec<ActuatorParameters> {
        let guesses: Vec<(ActuatorParameters, String)> =
            self.character.scalar_joints().zip(drives).map(|(j, drive)| self.actuator(j, *drive, physics_hz)).collect();
        for (joint, (p, source)) in self.character.scalar_joints().zip(&guesses) {
            self.notes.push(format!(
                "actuator of '{}': kp {:.3}, kd {:.3}, at most {:.2} N m ({source})",
                joint.name, p.kp, p.kd, p.torque_max
            ));
        }
        guesses.into_iter().map(|(parameters, _)| parameters).collect()
    }

    fn actuator(&self, joint: &Joint, spring: Option<Gains>, physics_hz: f64) -> (ActuatorParameters, String) {
        let velocity_max = joint.velocity_limit.unwrap_or(SPEED);
        let with = |kp: f64, kd: f64, torque_max: f64| ActuatorParameters {
            kp,
            kd,
            friction_velocity: 0.1,
            static_friction: 0.0,
            viscous_friction: 0.0,
            torque_max,
            full_torque_velocity: velocity_max / 3.0,
            velocity_max,
            extended_friction: None,
        };
        if self.is_passive(joint) {
            return (with(0.0, 0.0, 0.0), "the model has no actuator for it".into());
        }
        let torque_max = self.torque(joint);
        let torque = match self.limit(joint) {
            Limit::Known(_) => "the model's limit",
            Limit::Placeholder(_) | Limit::Unknown => "torque invented from the weight it may carry",
        };
        let drive = self.drive(joint).unwrap_or(Drive { stiffness: 0.0, damping: 0.0, torque: None });
        if self.is_brake(joint) {
            return (with(0.0, drive.damping, torque_max), format!("the model's damper; {torque}"));
        }
        if drive.stiffness > 0.0 {
            return (with(drive.stiffness, drive.damping.max(0.0), torque_max), format!("the model's gains; {torque}"));
        }
        // One radian of error asks for the whole torque, as on the legs of common robots; 40 ms of velocity are damped.
        // Explicit PD control is stable while kp h² and kd h stay well below the inertia that the motor feels.
        let inertia = self.inertias[joint.v_index];
        let (stable_kp, stable_kd) = (0.25 * inertia * physics_hz * physics_hz, 0.5 * inertia * physics_hz);
        let kp = spring.map_or(torque_max, |(stiffness, _)| stiffness).min(stable_kp);
        let kd = spring.map_or(0.04 * kp, |(_, damping)| damping).min(stable_kd);
        let (kd, gains) = match (spring, drive.damping > 0.0) {
            (Some(_), _) => (kd, "the joint's stiffness and damping, as far as they are stable"),
            (None, true) => (drive.damping, "the model's kd, kp invented"),
            (None, false) => (kd, "kp and kd invented"),
        };
        (with(kp, kd, torque_max), format!("{gains}; {torque}"))
    }

    /// Returns a line for each kind of doubtful number, with all joints that have it.
    pub fn warnings(&self) -> Vec<String> {
        let mut warnings = Vec::new();
        let mut say = |text: &str, names: Vec<String>| {
            if !names.is_empty() {
                warnings.push(format!("{text}: {}", names.join(", ")));
            }
        };
        let of = |line: &dyn Fn(&Joint) -> Option<String>| self.character.scalar_joints().filter_map(line).collect();
        say("joints without an actuator, which swing freely", of(&|j| self.is_passive(j).then(|| j.name.clone())));
        say(
            "torque limits that no motor has, taken for placeholders and replaced by the torque that the weight asks for",
            of(&|j| match self.limit(j) {
                Limit::Placeholder(torque) => Some(format!("{} ({torque} N m)", j.name)),
                _ => None,
            }),
        );
        say(
            "torque ranges that differ by direction, of which both directions get the smaller one",
            of(&|j| {
                let (low, high) = self.torque_range(j)?;
                ((low + high).abs() > 1e-9 * (high - low)).then(|| format!("{} ({low} to {high} N m)", j.name))
            }),
        );
        say(
            "position servos without any damping, in the servo or the joint",
            of(&|j| {
                let drive = self.drive(j)?;
                (drive.stiffness > 0.0 && drive.damping + j.damping <= 0.0).then(|| j.name.clone())
            }),
        );
        say(
            "servos whose gain pushes away from the target",
            of(&|j| self.drive(j).filter(|d| d.stiffness < 0.0 || d.damping < 0.0).map(|_| j.name.clone())),
        );
        warnings
    }

    /// Returns the model's own actuators of a joint.
    fn drive(&self, joint: &Joint) -> Option<Drive> {
        self.character.joint(&joint.name).ok().and_then(|index| self.character.drive(index))
    }

    /// Returns whether a joint has no actuator in a model that has some.
    fn is_passive(&self, joint: &Joint) -> bool {
        !self.character.actuators.is_empty() && self.drive(joint).is_none()
    }

    /// Returns whether actuators damp a joint and none moves it.
    fn is_brake(&self, joint: &Joint) -> bool {
        let is_of = |actuator: &&Actuator| self.character.joints[actuator.joint].name == joint.name;
        let mut own = self.character.actuators.iter().filter(is_of);
        self.drive(joint).is_some() && own.all(|actuator| actuator.command() == Command::Damping)
    }

    /// Returns the torques that the model allows (N m).
    fn torque_range(&self, joint: &Joint) -> Option<(f64, f64)> {
        let range = if self.is_passive(joint) { None } else { self.drive(joint).map(|drive| drive.torque) };
        let range = range.unwrap_or(joint.actuator_force_range.filter(|_| !self.is_passive(joint)));
        range.filter(|(low, high)| low.is_finite() && high.is_finite())
    }

    fn limit(&self, joint: &Joint) -> Limit {
        let gravity = self.character.gravity.norm().max(1.0);
        let most = MAX_TORQUE * 0.6 * self.character.mass() * gravity * reach(self.character, &self.kinematics);
        match self.torque_range(joint).map(|(low, high)| (-low).min(high).max(0.0)) {
            None => Limit::Unknown,
            Some(torque) if torque > most.max(SERVO_TORQUE) => Limit::Placeholder(torque),
            Some(torque) => Limit::Known(torque),
        }
    }

    /// Returns the torque of a joint: its limit, else what it may have to hold (N m).
    fn torque(&self, joint: &Joint) -> f64 {
        match self.limit(joint) {
            Limit::Known(torque) => torque,
            Limit::Placeholder(_) | Limit::Unknown => load(self.character, self.anatomy, &self.kinematics, joint),
        }
    }
}

/// Returns the greatest distance between the root and another body's centre of mass in the reference position (m).
pub(crate) fn reach(character: &Character, kinematics: &Kinematics) -> f64 {
    let root = kinematics.body_position[character.root_body()];
    let distances = character
        .bodies
        .iter()
        .enumerate()
        .skip(1)
        .filter(|(i, _)| character.is_own(*i))
        .map(|(i, body)| (kinematics.point(i, &body.inertial.com) - root).norm());
    distances.fold(0.0, f64::max)
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
        character.is_below(foot.body, joint.body).then_some(0.6 * character.mass() * gravity * length)
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
    for (i, body) in character.bodies.iter().enumerate().filter(|&(i, _)| character.is_below(i, joint.body)) {
        mass += body.inertial.mass;
        reach = reach.max((kinematics.point(i, &body.inertial.com) - anchor).norm());
    }
    (2.0 * mass * gravity * reach).max(0.1)
}
