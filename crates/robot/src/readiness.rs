//! Readiness of a robot for training: defects that prevent or endanger it, found before training.
//!
//! A robot without collision shapes falls through the ground, and its policy still collects reward. Commands that
//! simulate therefore call [`Robot::require_ready`] first.

mod ground;
mod numbers;

use std::f64::consts::PI;

use lifelike_character::{Anatomy, Character, Geom, GeomShape, Joint};

use crate::actuator::ActuatorParameters;
use crate::error::RobotError;
use crate::guess;
use crate::robot::Robot;

pub use ground::level_ground;

/// Weight below which a robot is taken for a mistake of units (kg).
const MIN_MASS: f64 = 0.02;
/// Weight above which it is (kg).
const MAX_MASS: f64 = 2000.0;
/// Share of the torque that standing on bent legs takes, of which the strongest joint of the legs has at least this
/// much.
const MIN_TORQUE: f64 = 0.05;
/// The same, below which motion is doubtful.
const LOW_TORQUE: f64 = 0.25;
/// Remedy for joints that are too weak.
const TORQUE_REMEDY: &str = "check torque_max in its profile, or forcerange and gear of its actuators (N m)";

/// Shapes that a physics engine lets touch.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shapes {
    /// Spheres, capsules, boxes, cylinders and ellipsoids: those of our engine.
    Primitives,
    /// All, meshes whose files are there included: those of MuJoCo.
    All,
}

/// Weight of a problem.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Severity {
    /// Training would be in vain.
    CannotTrain,
    /// Training may work, and the result may disappoint.
    Warning,
}

/// A problem of a robot.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize)]
pub struct Problem {
    /// Weight.
    pub severity: Severity,
    /// Description, with names and numbers.
    pub problem: String,
    /// Proposed fix.
    pub remedy: String,
}

/// The problems of a robot, the gravest first.
#[derive(Debug, Clone, Default, PartialEq, Eq, serde::Serialize)]
pub struct Readiness {
    /// The problems.
    pub problems: Vec<Problem>,
}

impl Readiness {
    /// Returns whether nothing forbids training.
    pub fn can_train(&self) -> bool {
        self.problems.iter().all(|p| p.severity != Severity::CannotTrain)
    }

    /// Returns all of it in one line, with the gravest problem and what to do.
    pub fn verdict(&self) -> String {
        let warnings = self.problems.iter().filter(|p| p.severity == Severity::Warning).count();
        match self.problems.first() {
            None => "ready to train".into(),
            Some(p) if p.severity == Severity::CannotTrain => {
                format!("cannot be trained: {}; {}", p.problem, p.remedy)
            }
            Some(_) => format!("ready to train, with {warnings} warning{}", if warnings == 1 { "" } else { "s" }),
        }
    }

    fn add(&mut self, severity: Severity, problem: String, remedy: &str) {
        self.problems.push(Problem { severity, problem, remedy: remedy.into() });
    }
}

impl Robot {
    /// Looks for what makes training impossible or doubtful in an engine with these shapes.
    pub fn readiness(&self, shapes: Shapes) -> Readiness {
        let mut readiness = Readiness::default();
        base(&self.character, &mut readiness);
        if let Some(body) = self.character.bodies.iter().find(|b| b.gravcomp != 0.0 && shapes == Shapes::Primitives) {
            let problem =
                format!("gravity is compensated in MuJoCo and not in our engine: gravcomp of '{}'", body.name);
            readiness.add(Severity::CannotTrain, problem, "remove gravcomp, or use --engine mujoco");
        }
        numbers::check(&self.character, &mut readiness);
        ground::check(&self.character, shapes, &mut readiness);
        contact(self, shapes, &mut readiness);
        mass(&self.character, &mut readiness);
        torque(self, &mut readiness);
        for warning in &self.character.warnings {
            readiness.add(Severity::Warning, warning.clone(), "");
        }
        readiness.problems.sort_by_key(|p| p.severity != Severity::CannotTrain);
        readiness
    }

    /// Refuses a robot that cannot be trained in an engine with these shapes.
    ///
    /// # Errors
    /// [`RobotError::Unfit`] with the verdict.
    pub fn require_ready(&self, shapes: Shapes) -> Result<(), RobotError> {
        let readiness = self.readiness(shapes);
        if readiness.can_train() {
            return Ok(());
        }
        Err(RobotError::Unfit { robot: self.name.clone(), message: readiness.verdict() })
    }
}

/// Checks that motion can move it.
fn base(character: &Character, readiness: &mut Readiness) {
    if character.root_joint().is_none() {
        let root = name(character, character.root_body());
        let problem = format!("it is fixed to the world: '{root}' has no free joint, so motion cannot move it");
        readiness.add(
            Severity::CannotTrain,
            problem,
            "give its root a <freejoint/>, or simulate it under torques and targets",
        );
    }
    let legs = Anatomy::legs(character);
    if legs > 2 {
        let problem = format!("it has {legs} legs: it can be simulated, and motion and plans here are for two");
        readiness.add(Severity::Warning, problem, "expect no policy that walks");
    }
    let loops = character.equalities.iter().filter(|e| e.active).count();
    if loops > 0 && character.root_joint().is_some() {
        let problem =
            format!("{loops} equality constraints hold its bodies together: retargeted motion does not know them");
        readiness.add(Severity::Warning, problem, "use motion that keeps to them");
    }
}

/// Checks ground contact: of anything, and of the feet.
fn contact(robot: &Robot, shapes: Shapes, readiness: &mut Readiness) {
    let character = &robot.character;
    let touching: Vec<bool> = touching(character, shapes);
    let geoms = character.geoms.iter().filter(|g| g.body != 0).count();
    if !touching.contains(&true) {
        let other = character.geoms.iter().filter(|g| g.body != 0 && meets_ground(character, g)).count();
        let why = match (geoms, other) {
            (0, _) => "it has no geoms".to_string(),
            (_, 0) if !character.pairs.is_empty() => {
                "its contacts are pairs (<pair>), which act in MuJoCo alone (--engine mujoco)".to_string()
            }
            (_, 0) => format!(
                "none of its {geoms} geoms collides (contype and conaffinity do not match the ground's, or they are meshes)"
            ),
            (_, n) => format!("{n} geoms would collide, but their shapes are meshes, planes or height fields"),
        };
        let remedy = "give its feet geoms of type box, sphere or capsule with contype and conaffinity 1";
        readiness.add(Severity::CannotTrain, format!("nothing of it can touch the ground: {why}"), remedy);
        return;
    }
    if robot.anatomy.soles.is_empty() {
        let remedy = "name them in its profile: [anatomy] left_foot = \"...\", right_foot = \"...\"";
        readiness.add(Severity::Warning, "no feet were found".into(), remedy);
        return;
    }
    let touches = |body: usize| (0..touching.len()).any(|b| touching[b] && character.is_below(b, body));
    let bare: Vec<&str> = robot
        .anatomy
        .soles
        .values()
        .map(|s| s.body)
        .filter(|&b| !touches(rigid(character, b)))
        .map(|b| name(character, b))
        .collect();
    if bare.is_empty() {
        return;
    }
    let problem = format!("no geom of its feet ({}) can touch the ground", bare.join(", "));
    let remedy = "give them geoms of type box, sphere or capsule with contype and conaffinity 1";
    let severity = if bare.len() == robot.anatomy.soles.len() { Severity::CannotTrain } else { Severity::Warning };
    readiness.add(severity, problem, remedy);
}

/// Returns the body that a body is fixed to, of which both are one rigid part: itself where it has a joint.
fn rigid(character: &Character, mut body: usize) -> usize {
    while !character.joints.iter().any(|joint| joint.body == body) && character.bodies[body].parent != 0 {
        body = character.bodies[body].parent;
    }
    body
}

fn mass(character: &Character, readiness: &mut Readiness) {
    let mass = character.mass();
    if mass.is_nan() || mass < MIN_MASS {
        let problem = format!("it weighs {mass} kg");
        readiness.add(Severity::CannotTrain, problem, "give its bodies <inertial> (kg), or its geoms mass or density");
    } else if mass > MAX_MASS {
        readiness.add(Severity::Warning, format!("it weighs {mass:.0} kg"), "masses are kg, and lengths m");
    }
}

/// Checks the strength of the legs against the weight, and joints without any.
fn torque(robot: &Robot, readiness: &mut Readiness) {
    let character = &robot.character;
    let joints = || robot.actuators.joints.iter().zip(&robot.actuators.parameters).zip(character.scalar_joints());
    let idle = |p: &ActuatorParameters| p.torque_max <= 0.0 && p.kp > 0.0;
    let weak: Vec<&str> = joints().filter(|((_, p), _)| idle(p)).map(|((name, _), _)| name.as_str()).collect();
    let needed = guess::standing_loads(character, &robot.anatomy);
    // A servo cannot ask for more than its gain gives over the joint's whole range.
    let strength = |p: &ActuatorParameters, joint: &Joint| {
        let span = joint.range.map_or(PI, |(low, high)| high - low);
        (p.torque_max.min(p.kp * span), p.kp * span < p.torque_max)
    };
    let shares = joints().zip(needed).filter_map(|(((name, p), joint), load)| {
        let (torque, soft) = strength(p, joint);
        Some((name, torque, torque / load?, load?, soft))
    });
    let strongest = shares.max_by(|a, b| a.2.total_cmp(&b.2));
    if let Some((name, torque, share, load, soft)) = strongest.filter(|s| s.2 < LOW_TORQUE) {
        let severity = if share < MIN_TORQUE { Severity::CannotTrain } else { Severity::Warning };
        let (what, remedy) = match soft {
            _ if torque <= 0.0 => ("its legs have no motors", "give them actuators, or torque_max in its profile"),
            true => (
                "the gains of its legs are too soft",
                "check kp in its profile, or kp and gear of its actuators (N m/rad)",
            ),
            false => ("its legs are too weak", TORQUE_REMEDY),
        };
        let problem =
            format!("{what}: the strongest joint, '{name}', has {torque:.3} N m where standing takes {load:.3}");
        readiness.add(severity, problem, remedy);
    } else if !weak.is_empty() {
        readiness.add(Severity::Warning, format!("joints without torque: {}", weak.join(", ")), TORQUE_REMEDY);
    }
}

/// Flags the bodies that have a geom that touches the ground.
fn touching(character: &Character, shapes: Shapes) -> Vec<bool> {
    let mut touching = vec![false; character.bodies.len()];
    let is_paired =
        |g: &Geom| shapes == Shapes::All && g.body != 0 && character.pairs.iter().any(|p| p.contains(&g.name));
    for geom in character.geoms.iter().filter(|g| meets_ground(character, g) || is_paired(g)) {
        let primitive = !matches!(geom.shape, GeomShape::Mesh(_) | GeomShape::HeightField(_) | GeomShape::Plane);
        touching[geom.body] |= primitive || shapes == Shapes::All;
    }
    touching
}

/// Returns whether a geom of the robot can collide with the ground (the model's own, or MuJoCo's default), by masks and
/// exclusions.
fn meets_ground(character: &Character, geom: &Geom) -> bool {
    let excluded = character.excludes.iter().any(|pair| [(0, geom.body), (geom.body, 0)].contains(pair));
    let meets = |contype: u32, conaffinity: u32| geom.contype & conaffinity != 0 || contype & geom.conaffinity != 0;
    let mut ground = character.geoms.iter().filter(|g| g.body == 0 && g.collides()).peekable();
    let met = if ground.peek().is_none() { meets(1, 1) } else { ground.any(|g| meets(g.contype, g.conaffinity)) };
    geom.body != 0 && character.is_own(geom.body) && !excluded && met
}

fn name(character: &Character, body: usize) -> &str {
    &character.bodies[body].name
}
