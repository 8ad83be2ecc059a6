//! Numbers that no robot has: other units, gravity along another axis, joints that hardly move or turn too far.

use std::f64::consts::PI;

use lifelike_character::{Body, Character, Joint, JointKind, Kinematics};

use super::{Readiness, Severity};
use crate::guess;

/// Mass by the cube of the reach (kg/m³) of robots from 0.4 to 2 m is 80 to 400. Grams give 1000 times as much, millimetres a
/// billionth.
const DENSITY: std::ops::Range<f64> = 0.05..20_000.0;
/// Angles that no limited joint of a robot has (rad), from two turns up; what is beyond means no limit.
const DEGREES: std::ops::Range<f64> = 4.0 * PI..1000.0;
/// Speed from which a limit is none of a joint behind its gear (rad/s); small servos reach 15, legs of robots 40.
const DEGREES_PER_SECOND: f64 = 150.0;
/// Range below which a joint hardly moves (rad).
const MIN_RANGE: f64 = 0.12;
/// Share of gravity that must point down.
const DOWN: f64 = 0.9;
/// Gravity anywhere on the earth (m/s2), with room for rounding.
const EARTH: std::ops::RangeInclusive<f64> = 9.7..=9.9;

/// Adds what it finds, the cause before its consequences.
pub(super) fn check(character: &Character, readiness: &mut Readiness) {
    units(character, readiness);
    inertias(character, readiness);
    gravity(character, readiness);
    ranges(character, readiness);
    speeds(character, readiness);
}

/// Compares speed limits with what degrees per second give.
fn speeds(character: &Character, readiness: &mut Readiness) {
    let is_fast = |limit: &f64| (DEGREES_PER_SECOND..1e6).contains(limit);
    let text = |joint: &Joint| joint.velocity_limit.filter(is_fast).map(|v| format!("{} ({v} rad/s)", joint.name));
    let fast: Vec<String> =
        character.joints.iter().filter(|joint| joint.kind == JointKind::Hinge).filter_map(text).collect();
    if !fast.is_empty() {
        let problem =
            format!("speed limits that no joint reaches, which look like degrees per second: {}", fast.join(", "));
        readiness.add(Severity::Warning, problem, "write them in rad/s");
    }
}

fn units(character: &Character, readiness: &mut Readiness) {
    let reach = guess::reach(character, &Kinematics::new(character));
    let mass = character.mass();
    if !(reach > 0.0 && mass > 0.0) || DENSITY.contains(&(mass / reach.powi(3))) {
        return;
    }
    let heavy = mass / reach.powi(3) >= DENSITY.end;
    let what = if heavy {
        "its masses look like grams, or its lengths like kilometres"
    } else {
        "its lengths look like millimetres"
    };
    let problem = format!("{what}: it weighs {mass:.6} kg, and its parts are up to {reach:.6} m from its root");
    readiness.add(Severity::CannotTrain, problem, "write masses in kg and lengths in m");
}

/// Compares moments of inertia with those of a body as large as the whole robot. Beyond that no body has its mass.
fn inertias(character: &Character, readiness: &mut Readiness) {
    let square = guess::reach(character, &Kinematics::new(character)).powi(2);
    let own = character.bodies.iter().enumerate().filter(|(i, body)| character.is_own(*i) && body.inertial.mass > 0.0);
    let wide: Vec<_> = own.map(|(_, b)| b).filter(|b| b.inertial.diagonal.max() > b.inertial.mass * square).collect();
    if square == 0.0 || wide.is_empty() {
        return;
    }
    let text = |body: &&Body| {
        let (mass, moment) = (body.inertial.mass, body.inertial.diagonal.max());
        format!(
            "{} ({moment} kg m2 with {mass} kg: a radius of gyration of {:.3} m)",
            body.name,
            (moment / mass).sqrt()
        )
    };
    let whole = character.mass() * square;
    let is_vain = wide.iter().any(|body| body.inertial.diagonal.max() > whole);
    let severity = if is_vain { Severity::CannotTrain } else { Severity::Warning };
    let problem = format!(
        "inertias of bodies wider than the whole robot, which look like kg mm2 or kg cm2: {}",
        wide.iter().map(text).collect::<Vec<_>>().join(", ")
    );
    readiness.add(severity, problem, "write inertias in kg m2");
}

fn gravity(character: &Character, readiness: &mut Readiness) {
    let gravity = character.gravity;
    if gravity.norm() > 0.0 && -gravity.z < DOWN * gravity.norm() {
        let problem = format!("its gravity is {} {} {} m/s2: not down, and z is up", gravity.x, gravity.y, gravity.z);
        let remedy = "turn the robot until z is up, and set <option gravity=\"0 0 -9.81\"/>";
        readiness.add(Severity::CannotTrain, problem, remedy);
    } else if !EARTH.contains(&gravity.norm()) {
        let problem = format!("its gravity is {} {} {} m/s2, not the earth's", gravity.x, gravity.y, gravity.z);
        let remedy = "set <option gravity=\"0 0 -9.81\"/>, unless it is meant for another place";
        readiness.add(Severity::Warning, problem, remedy);
    }
}

/// Compares the ranges of hinges with what degrees taken for radians give, and the reverse.
fn ranges(character: &Character, readiness: &mut Readiness) {
    let hinges = || character.joints.iter().filter(|j| j.kind == JointKind::Hinge);
    let limited: Vec<(&str, f64, f64)> =
        hinges().filter_map(|j| j.range.map(|(l, h)| (j.name.as_str(), l, h))).collect();
    let list = |chosen: &[&(&str, f64, f64)]| {
        let text = |(name, low, high): &&(&str, f64, f64)| format!("{name} ({low:.4} to {high:.4} rad)");
        chosen.iter().map(text).collect::<Vec<_>>().join(", ")
    };
    let mut judge = |chosen: Vec<&(&str, f64, f64)>, what: &str, remedy: &str| {
        if chosen.is_empty() {
            return;
        }
        let severity = if 2 * chosen.len() > limited.len() { Severity::CannotTrain } else { Severity::Warning };
        readiness.add(severity, format!("{what}: {}", list(&chosen)), remedy);
    };
    judge(
        limited.iter().filter(|(_, low, high)| DEGREES.contains(&low.abs().max(high.abs()))).collect(),
        "ranges of more than two turns, which look like degrees taken for radians",
        "write them in radians (MJCF: or set <compiler angle=\"degree\"/>)",
    );
    judge(
        limited.iter().filter(|(_, low, high)| high - low < MIN_RANGE).collect(),
        "joints that can hardly move (radians taken for degrees?)",
        "write them in degrees, or set <compiler angle=\"radian\"/>",
    );
}
