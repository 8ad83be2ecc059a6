//! A robot: a character and all that its control needs, by name.

use std::collections::BTreeSet;
use std::sync::Arc;

use lifelike_character::{Anatomy, Character, Joint, JointKind, Role, Vec3};
use lifelike_motion::FeatureLayout;

use crate::actuator::ActuatorSet;
use crate::error::RobotError;
use crate::guess::{self, Guesser};
use crate::profile::{ActuatorGroup, CONTINUOUS_SHARE, Profile, glob};
use crate::standing::standing;

/// A robot, ready to be simulated, trained and run.
#[derive(Debug, Clone)]
pub struct Robot {
    /// Its name.
    pub name: String,
    /// Its body.
    pub character: Arc<Character>,
    /// Roles of the bodies.
    pub anatomy: Anatomy,
    /// Its actuators, one per scalar joint, in the character's order.
    pub actuators: ActuatorSet,
    /// Names of its joints and end effectors: the layout of eq. 4.1 for this robot.
    pub layout: FeatureLayout,
    /// Sites of the end effectors, in the order of `layout.end_effectors`: body index and point in its frame (m).
    pub effectors: Vec<(usize, Vec3)>,
    /// Sites of the key bodies of the observation, likewise.
    pub key_bodies: Vec<(usize, Vec3)>,
    /// Default pose, one angle per scalar joint (rad).
    pub default_pose: Vec<f64>,
    /// Policy rate (Hz).
    pub control_hz: f64,
    /// Physics steps per policy step.
    pub substeps: usize,
    /// The profile it was made with, `key_bodies` included where they were given.
    pub profile: Profile,
    /// Guesses where the profile does not say: a line each, for `inspect`.
    pub notes: Vec<String>,
}

/// Roles whose sites are tracked where the profile names none.
const HANDS_AND_FEET: [Role; 4] = [Role::LeftHand, Role::RightHand, Role::LeftFoot, Role::RightFoot];

/// No policy acts faster (Hz).
const MAX_CONTROL_HZ: f64 = 2000.0;

/// No physics of a robot has shorter steps (Hz).
const MAX_PHYSICS_HZ: f64 = 20_000.0;

/// t^p of robots whose profile does not say (m): that of the thesis' robot (Table 4.1).
const DEVIATION_LIMIT: f64 = 0.3;

impl Robot {
    /// Returns a robot from a character and a profile, whose gaps are guessed ([`Self::notes`] says what).
    ///
    /// # Errors
    /// [`RobotError::Unfit`] for ball joints, a late free joint, joints that no actuator group names, or two, and for
    /// rates that do not divide. [`RobotError::Character`] for unknown names.
    pub fn from_character(character: impl Into<Arc<Character>>, profile: Profile) -> Result<Self, RobotError> {
        let mut character: Arc<Character> = character.into();
        controllable(&character)?;
        let mut notes = Vec::new();
        let anatomy = standing(&mut character, &profile, &mut notes)?;
        let (control_hz, substeps) = rates(&character, &profile, &mut notes)?;
        let joints: Vec<String> = character.scalar_joints().map(|j| j.name.clone()).collect();
        let parameters = if profile.actuator.is_empty() {
            let drives = tell(&mut notes, Guesser::new(&character, &anatomy), Guesser::drive_gains);
            character = with_joints(character, &drives, |joint, _| (joint.stiffness, joint.damping) = (0.0, 0.0));
            let rotors = tell(&mut notes, Guesser::new(&character, &anatomy), Guesser::rotors);
            character = with_joints(character, &rotors, |joint, armature| joint.armature = *armature);
            let mut guesser = Guesser::new(&character, &anatomy);
            let parameters = guesser.actuators(&drives, control_hz * substeps as f64);
            let warnings = guesser.warnings();
            notes.append(&mut guesser.notes);
            Arc::make_mut(&mut character).warnings.extend(warnings);
            parameters
        } else {
            let groups = grouped(&character, &profile)?;
            let armatures: Vec<Option<f64>> = groups.iter().map(|group| group.armature).collect();
            character = with_joints(character, &armatures, |joint, armature| joint.armature = *armature);
            groups.into_iter().map(|group| group.parameters).collect()
        };
        let (end_effectors, effectors) = if profile.end_effectors.is_empty() {
            let present: Vec<(Role, &lifelike_character::anatomy::Place)> = HANDS_AND_FEET
                .iter()
                .filter_map(|&role| anatomy.places.get(&role).map(|place| (role, place)))
                .collect();
            let names: Vec<String> = present.iter().map(|&(role, _)| role_name(role)).collect();
            notes.push(format!(
                "end effectors: {}",
                if names.is_empty() { "none found".into() } else { names.join(", ") }
            ));
            (names, present.iter().map(|(_, place)| (place.body, place.point)).collect())
        } else {
            (profile.end_effectors.clone(), sites(&character, &anatomy, &profile.end_effectors)?)
        };
        let key_bodies = sites(&character, &anatomy, &profile.key_bodies)?;
        let default_pose = default_pose(&character, &profile)?;
        if character.home.is_some() && profile.default_pose.is_empty() {
            notes.push("default pose: the model's keyframe 'home'".into());
            let beyond = character.scalar_joints().filter_map(|joint| {
                let ((low, high), angle) = (joint.range?, *character.home.as_ref()?.get(joint.q_index)?);
                let slack = 1e-3 * (high - low);
                let is_within = (low - slack..=high + slack).contains(&angle);
                (!is_within).then(|| format!("{} ({angle} beyond {low:.4} to {high:.4})", joint.name))
            });
            let beyond: Vec<String> = beyond.collect();
            if !beyond.is_empty() {
                let what = "joints that the keyframe 'home' puts beyond their range are clamped";
                Arc::make_mut(&mut character).warnings.push(format!("{what}: {}", beyond.join(", ")));
            }
        }
        Ok(Self {
            name: character.name.clone(),
            anatomy,
            actuators: ActuatorSet { joints: joints.clone(), parameters },
            layout: FeatureLayout { joints, end_effectors },
            effectors,
            key_bodies,
            default_pose,
            control_hz,
            substeps,
            profile,
            notes,
            character,
        })
    }

    /// Returns the robot with its joints in the order of a policy that has the same ones: they are matched by name. A robot with
    /// other joints stays as it is.
    ///
    /// # Errors
    /// No order of its limbs gives that order of its joints.
    pub fn in_joint_order(self, joints: &[String]) -> Result<Self, RobotError> {
        let set = |names: &[String]| names.iter().cloned().collect::<BTreeSet<String>>();
        if self.layout.joints == joints || set(&self.layout.joints) != set(joints) {
            return Ok(self);
        }
        let mut robot = Self::from_character(self.character.in_joint_order(joints)?, self.profile)?;
        robot.notes.push("its joints are in the policy's order, not the file's".into());
        Ok(robot)
    }

    /// Returns the number of scalar joints J.
    pub fn joints(&self) -> usize {
        self.layout.joints.len()
    }

    /// Returns the name of the profile's group of actuators that a joint is in: what its actuator is. None where the profile has none.
    pub fn actuator_group(&self, joint: &str) -> Option<&str> {
        let named = |group: &ActuatorGroup| group.joints.iter().any(|pattern| glob(pattern, joint));
        self.profile.actuator.iter().find(|(_, group)| named(group)).map(|(name, _)| name.as_str())
    }

    /// Returns the length of its stretched leg, hip to ankle (m): by it, sizes of robots are compared. None for a robot without legs.
    pub fn leg_length(&self) -> Option<f64> {
        guess::leg_length(&self.character, &self.anatomy)
    }

    /// Returns the largest speeds of the scalar joints (rad/s or m/s); infinite where nothing limits them.
    pub fn speeds(&self) -> Vec<f64> {
        self.actuators.parameters.iter().map(|p| p.velocity_max).collect()
    }

    /// Returns the continuous torque of each scalar joint's actuator (N m): the profile's, or a third of the largest.
    pub fn continuous_torques(&self) -> Vec<f64> {
        let named = |joint: &str| self.actuator_group(joint).map(|name| self.profile.actuator[name].continuous());
        let peaks = self.actuators.parameters.iter().map(|p| CONTINUOUS_SHARE * p.torque_max);
        self.layout.joints.iter().zip(peaks).map(|(joint, guess)| named(joint).unwrap_or(guess)).collect()
    }

    /// Returns the largest end-effector deviation without consequence (m): t^p of Table 4.1.
    pub fn deviation_limit(&self) -> f64 {
        self.profile.deviation_limit.unwrap_or(DEVIATION_LIMIT)
    }

    /// Physics time step (s).
    pub fn timestep(&self) -> f64 {
        1.0 / (self.control_hz * self.substeps as f64)
    }

    /// Returns the default pose as a generalised position (MuJoCo's layout), the root where the model or its keyframe `home` puts
    /// it.
    pub fn default_position(&self) -> Vec<f64> {
        let home = self.character.home.clone().filter(|_| self.profile.default_pose.is_empty());
        let mut q = home.unwrap_or_else(|| self.character.reference_position());
        for (joint, &angle) in self.character.scalar_joints().zip(&self.default_pose) {
            q[joint.q_index] = angle;
        }
        self.character.follow(&mut q, &mut vec![0.0; self.character.nv]);
        q
    }
}

/// Returns the name of a role as text writes it, such as `left_hand`.
pub fn role_name(role: Role) -> String {
    let mut name = String::new();
    for c in format!("{role:?}").chars() {
        if c.is_uppercase() && !name.is_empty() {
            name.push('_');
        }
        name.extend(c.to_lowercase());
    }
    name
}

fn unfit(character: &Character, message: String) -> RobotError {
    RobotError::Unfit { robot: character.name.clone(), message }
}

/// Checks that control can work: it needs scalar joints, and before them one floating base or none. Without one the robot is
/// fixed to the world: it can be simulated and driven, but no motion moves it ([`Robot::readiness`] says so).
fn controllable(character: &Character) -> Result<(), RobotError> {
    let names = |kind: JointKind| {
        let names: Vec<&str> = character.joints.iter().filter(|j| j.kind == kind).map(|j| j.name.as_str()).collect();
        names.join(", ")
    };
    match character.joints.iter().filter(|j| j.kind == JointKind::Free).count() {
        0 => {}
        1 if character.joints[0].kind == JointKind::Free => {}
        1 => return Err(unfit(character, "expected its free joint to be its first joint".into())),
        n => {
            let message = format!(
                "expected one free joint, got {n}: {}; leave only the robot in its file",
                names(JointKind::Free)
            );
            return Err(unfit(character, message));
        }
    }
    if let Some(joint) = character.joints.iter().find(|joint| !character.is_own(joint.body)) {
        let (joint, body) = (&joint.name, &character.bodies[joint.body].name);
        let base = &character.bodies[character.root_body()].name;
        let message = format!(
            "expected all joints on its base '{base}', got '{joint}' of '{body}'; leave only the robot in its file"
        );
        return Err(unfit(character, message));
    }
    let balls = names(JointKind::Ball);
    if !balls.is_empty() {
        return Err(unfit(character, format!("expected hinges and slides, got ball joints: {balls}")));
    }
    if character.scalar_joints().next().is_none() {
        return Err(unfit(character, "expected joints to control, got none".into()));
    }
    Ok(())
}

fn rates(character: &Character, profile: &Profile, notes: &mut Vec<String>) -> Result<(f64, usize), RobotError> {
    let mut rate = |given: Option<f64>, key: &str, otherwise: f64, most: f64| {
        let rate = given.unwrap_or(otherwise);
        if given.is_none() {
            notes.push(format!("{key}: {otherwise}"));
        }
        if rate > 0.0 && rate <= most {
            Ok(rate)
        } else {
            Err(unfit(character, format!("{key}: expected a rate above 0 and at most {most} Hz, got {rate}")))
        }
    };
    let control = rate(profile.control_hz, "control_hz", 50.0, MAX_CONTROL_HZ)?;
    let physics = (200.0 / control).ceil().max(1.0) * control;
    let physics = rate(profile.physics_hz, "physics_hz", physics, MAX_PHYSICS_HZ)?;
    let substeps = (physics / control).round();
    if substeps < 1.0 || (substeps * control - physics).abs() > 1e-9 * physics {
        let message = format!("physics_hz: expected a multiple of control_hz ({control}), got {physics}");
        return Err(unfit(character, message));
    }
    Ok((control, substeps as usize))
}

/// Returns a guess, and adds its lines to `notes`.
fn tell<'a, T>(notes: &mut Vec<String>, mut guesser: Guesser<'a>, guess: impl Fn(&mut Guesser<'a>) -> T) -> T {
    let guessed = guess(&mut guesser);
    notes.append(&mut guesser.notes);
    guessed
}

/// Returns the character with its scalar joints changed by these values; `None` leaves a joint as it is.
fn with_joints<T>(character: Arc<Character>, values: &[Option<T>], change: impl Fn(&mut Joint, &T)) -> Arc<Character> {
    if values.iter().all(Option::is_none) {
        return character;
    }
    let joints: Vec<usize> = character.scalar_joints().map(|j| j.v_index).collect();
    let mut changed = Arc::unwrap_or_clone(character);
    for (v_index, value) in joints.into_iter().zip(values) {
        let joint = changed.joints.iter_mut().find(|j| j.v_index == v_index);
        if let (Some(joint), Some(value)) = (joint, value) {
            change(joint, value);
        }
    }
    Arc::new(changed)
}

/// Returns the one group that names each scalar joint.
fn grouped<'a>(character: &Character, profile: &'a Profile) -> Result<Vec<&'a ActuatorGroup>, RobotError> {
    for (group, pattern) in profile.actuator.iter().flat_map(|(n, g)| g.joints.iter().map(move |p| (n, p))) {
        if !character.scalar_joints().any(|j| glob(pattern, &j.name)) {
            return Err(unfit(character, format!("[actuator.{group}]: no joint is named '{pattern}'")));
        }
    }
    let of_joint = |joint: &str| {
        let groups: Vec<(&String, &ActuatorGroup)> = profile
            .actuator
            .iter()
            .filter(|(_, group)| group.joints.iter().any(|pattern| glob(pattern, joint)))
            .collect();
        match groups.as_slice() {
            [(_, group)] => Ok(*group),
            [] => Err(unfit(character, format!("joint '{joint}' is in no [actuator.*] group"))),
            [(a, _), (b, _), ..] => {
                Err(unfit(character, format!("joint '{joint}' is in both [actuator.{a}] and [actuator.{b}]")))
            }
        }
    };
    character.scalar_joints().map(|joint| of_joint(&joint.name)).collect()
}

/// Returns the sites by the name of a site, a body or a role.
fn sites(character: &Character, anatomy: &Anatomy, names: &[String]) -> Result<Vec<(usize, Vec3)>, RobotError> {
    let place = |name: &String| {
        if let Ok(site) = character.site(name) {
            return Ok((character.sites[site].body, character.sites[site].position));
        }
        let role = anatomy.places.iter().find(|&(&role, _)| role_name(role) == *name);
        if let (Some((_, place)), Err(_)) = (role, character.body(name)) {
            return Ok((place.body, place.point));
        }
        Ok((character.body(name)?, Vec3::zeros()))
    };
    names.iter().map(place).collect()
}

fn default_pose(character: &Character, profile: &Profile) -> Result<Vec<f64>, RobotError> {
    for name in profile.default_pose.keys() {
        if !character.scalar_joints().any(|j| j.name == *name) {
            character.joint(name)?;
            return Err(unfit(character, format!("default_pose: '{name}' is not a hinge or slide")));
        }
    }
    let home = |joint: &Joint| {
        let home = character.home.as_ref().filter(|_| profile.default_pose.is_empty())?;
        home.get(joint.q_index).copied()
    };
    let of_joint = |joint: &Joint| {
        let (low, high) = joint.range.unwrap_or((f64::NEG_INFINITY, f64::INFINITY));
        match profile.default_pose.get(&joint.name) {
            None => Ok(home(joint).unwrap_or(0.0).max(low).min(high)),
            Some(&angle) if (low..=high).contains(&angle) => Ok(angle),
            Some(angle) => {
                let name = &joint.name;
                let (unit, radians) = (if joint.kind == JointKind::Slide { "m" } else { "rad" }, angle.to_radians());
                let mut message = format!("default_pose.{name}: expected {low:.3} to {high:.3} {unit}, got {angle}");
                if unit == "rad" && (low..=high).contains(&radians) {
                    message += &format!("; {angle} degrees would be {radians:.3} rad");
                }
                Err(unfit(character, message))
            }
        }
    };
    character.scalar_joints().map(of_joint).collect()
}
