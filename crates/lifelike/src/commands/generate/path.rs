//! A path on the ground as a script: turn to the next point, walk there.

use std::f64::consts::PI;
use std::str::FromStr;

use lifelike_character::Vec3;
use lifelike_character::rotation::heading_angle;
use lifelike_language::facts::{Action, Direction};
use lifelike_language::grammar::{Acts, Grammar};
use lifelike_language::script::{Clause, Script};
use lifelike_motion::MotionClip;

use crate::error::CliError;

/// Smallest turn that is worth steps (degrees), and the shortest way (m).
const TURN: f64 = 5.0;
const WAY: f64 = 0.1;

/// Points on the ground (m): ahead and to the left of where the robot begins.
#[derive(Debug, Clone, PartialEq)]
pub struct Path(pub Vec<[f64; 2]>);

impl FromStr for Path {
    type Err = String;

    /// Reads `1,0 1,1`.
    fn from_str(text: &str) -> Result<Self, String> {
        let point = |pair: &str| {
            let numbers: Vec<f64> = pair.split(',').filter_map(|number| number.parse().ok()).collect();
            match numbers.as_slice() {
                [x, y] if x.is_finite() && y.is_finite() && pair.matches(',').count() == 1 => Ok([*x, *y]),
                _ => {
                    Err(format!("expected points such as '1,0 1,1.5' (metres ahead, metres to the left), got '{pair}'"))
                }
            }
        };
        let points = text.split_whitespace().map(point).collect::<Result<Vec<_>, _>>()?;
        if points.is_empty() {
            return Err("expected at least one point such as '1,0', got none".into());
        }
        Ok(Self(points))
    }
}

impl Path {
    /// Returns the script that goes along it. The gait is the script's, where it is a single gait; a gesture is done on the way.
    ///
    /// # Errors
    /// [`CliError::Input`] for points that are the same, and for a script that cannot be done on the way.
    pub fn script(&self, script: &Script, grammar: &Grammar) -> Result<Script, CliError> {
        let (gesture, gait) = on_the_way(script, grammar)?;
        let (mut at, mut heading) = ([0.0, 0.0], 0.0);
        let mut out = Script { notes: script.notes.clone(), unknown: script.unknown.clone(), ..Script::default() };
        for point in &self.0 {
            let way: [f64; 2] = [point[0] - at[0], point[1] - at[1]];
            let metres = way[0].hypot(way[1]);
            if metres < WAY {
                let text = format!(
                    "--path: expected points at least {WAY} m apart, got {},{} after {},{}",
                    point[0], point[1], at[0], at[1]
                );
                return Err(CliError::Input(text));
            }
            let turn = wrapped(way[1].atan2(way[0]) - heading).to_degrees();
            if turn.abs() >= TURN {
                let degrees = turn.abs().round();
                let direction = Some(if turn > 0.0 { Direction::Left } else { Direction::Right });
                let action = Action { direction, degrees: Some(degrees as u32), ..Action::of("turn") };
                out.clauses.push(Clause::new(vec![action]));
                heading = wrapped(heading + (degrees * turn.signum()).to_radians());
            }
            let walk = Action { metres: Some((1e3 * metres).round() / 1e3), ..gait.clone() };
            let actions = gesture.iter().cloned().chain([walk]).collect();
            out.clauses.push(Clause::new(actions));
            at = *point;
        }
        Ok(out)
    }

    /// Returns the distance from each point to the nearest place of a motion's root (m), seen from where it begins.
    pub fn misses(&self, clip: &MotionClip) -> Vec<f64> {
        let (Some(first), Some(turn)) = (clip.root_position.first(), clip.root_orientation.first()) else {
            return Vec::new();
        };
        let (sin, cos) = heading_angle(turn).sin_cos();
        let from = |p: &Vec3| {
            let way = p - first;
            [cos * way.x + sin * way.y, cos * way.y - sin * way.x]
        };
        let places: Vec<[f64; 2]> = clip.root_position.iter().map(from).collect();
        let miss = |point: &[f64; 2]| {
            places.iter().map(|place| (place[0] - point[0]).hypot(place[1] - point[1])).fold(f64::INFINITY, f64::min)
        };
        self.0.iter().map(miss).collect()
    }

    /// Returns a line on how near a motion comes to the points.
    pub fn line(&self, clip: &MotionClip, place: &str) -> String {
        let misses = self.misses(clip);
        let worst = misses.iter().copied().fold(0.0, f64::max);
        format!("path{place}: {} points, the farthest missed by {worst:.2} m", misses.len())
    }
}

/// Returns what is done on the way: a gesture, and the gait.
fn on_the_way(script: &Script, grammar: &Grammar) -> Result<(Option<Action>, Action), CliError> {
    let walk = || Action { direction: Some(Direction::Forward), ..Action::of("walk") };
    let goes = |action: &Action| {
        let verb = grammar.verb(&action.verb)?;
        Ok::<bool, CliError>(
            verb.acts == Acts::Feet && verb.cycle.is_some() && action.direction == Some(Direction::Forward),
        )
    };
    let hands = |action: &Action| {
        let verb = grammar.verb(&action.verb)?;
        Ok::<bool, CliError>(matches!(verb.acts, Acts::Hand | Acts::Hands | Acts::Head))
    };
    let clauses: Vec<&[Action]> = script.clauses.iter().map(|clause| clause.actions.as_slice()).collect();
    match clauses.as_slice() {
        [] => Ok((None, walk())),
        [[gait]] if goes(gait)? => Ok((None, gait.clone())),
        [[gesture]] if hands(gesture)? => Ok((Some(gesture.clone()), walk())),
        [[gesture, gait]] if goes(gait)? => Ok((Some(gesture.clone()), gait.clone())),
        _ => Err(CliError::Input(format!(
            "--path: expected a gait that goes forward, a gesture, or both at once, got '{script}'"
        ))),
    }
}

/// Returns an angle between -π and π.
fn wrapped(angle: f64) -> f64 {
    (angle + PI).rem_euclid(2.0 * PI) - PI
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use lifelike_language::script::Reader;

    use super::*;

    #[test]
    fn points_become_turns_and_ways() {
        let grammar = Grammar::builtin().unwrap();
        let reader = Reader::new(&grammar).unwrap();
        let path: Path = "1,0 1,1 0,1".parse().unwrap();
        let script = path.script(&reader.read("wave with the left hand"), &grammar).unwrap();
        let walk = "wave, left side while: walk, forward, 1 m";
        let turn = "turn, to the left, 90 degrees";
        assert_eq!(script.to_string(), format!("{walk}; then {turn}; then {walk}; then {turn}; then {walk}"));
        let back: Path = "-1,0.01".parse().unwrap();
        let script = back.script(&reader.read("sneak"), &grammar).unwrap();
        assert_eq!(script.to_string(), "turn, to the left, 179 degrees; then sneak, forward, 1 m");
        assert!(path.script(&reader.read("sit down"), &grammar).unwrap_err().to_string().contains("got 'sit'"));
        for (text, part) in [("", "got none"), ("1;0", "got '1;0'"), ("1,2,3", "got '1,2,3'"), ("nan,0", "got 'nan,0'")]
        {
            assert!(text.parse::<Path>().unwrap_err().contains(part), "{text}");
        }
        let near: Path = "1,0 1,0.01".parse().unwrap();
        assert!(near.script(&Script::default(), &grammar).is_err());
    }
}
