//! Poses that stay: hands that were put somewhere, and a trunk that leans for some seconds.

use super::reader::Reader;
use super::{Clause, Script};
use crate::facts::{Action, Direction, Speed};
use crate::grammar::Acts;
use crate::posture::{Posture, Turn};
use crate::touch::Touch;

/// Poses of hands that people keep while they do something else.
const RESTING: [&str; 7] = [
    "hands_on_hips",
    "hand_on_hip",
    "cross_arms",
    "hands_behind_head",
    "hands_behind_back",
    "hands_on_head",
    "airplane",
];
/// Places at which hands rest so.
const PLACES: [Touch; 5] = [Touch::Hip, Touch::Nape, Touch::Crown, Touch::Back, Touch::OwnShoulder];

/// Movements of legs and body that need the arms.
const OF_ARMS: [&str; 14] = [
    "jumping_jack",
    "tightrope",
    "tree_pose",
    "warrior_pose",
    "crane_kick",
    "touch_toes",
    "touch_knees",
    "cross_toe_touch",
    "torso_twist",
    "elbow_to_knee",
    "bob_weave",
    "fighting_stance",
    "surf",
    "trex_walk",
];
/// Angles of leans that are held, where none is said (degrees).
const FORWARD: f64 = 30.0;
const BACK: f64 = 14.0;

impl Reader<'_> {
    /// Makes a posture of a bend that is held for some seconds: "bend forward 30 degrees and hold for 3 seconds".
    pub(super) fn with_held_leans(&self, mut script: Script) -> Script {
        for clause in &mut script.clauses {
            let ([action], Some(hold), 1) = (&clause.actions[..], clause.seconds, clause.times) else { continue };
            let is_plain = clause.postures.is_empty() && clause.rise.is_none() && action.mood.is_none();
            if !is_plain || !self.grammar.verb(&action.verb).is_ok_and(|verb| verb.bends) {
                continue;
            }
            let angle = action.degrees.map(f64::from);
            let pitch = match action.direction {
                Some(Direction::Backward) => -angle.unwrap_or(BACK),
                _ => angle.unwrap_or(FORWARD),
            };
            let trunk = Some(Turn { pitch, ..Turn::default() });
            let slow = action.speed == Some(Speed::Slow);
            *clause = Clause::of_postures(vec![Posture { trunk, hold, slow, ..Posture::default() }]);
        }
        script
    }

    /// Keeps hands where a clause puts them during the clauses that follow and need no arms.
    pub(super) fn with_kept_hands(&self, mut script: Script) -> Script {
        let mut clauses: Vec<Clause> = Vec::with_capacity(script.clauses.len());
        for mut clause in std::mem::take(&mut script.clauses) {
            let mut is_spent = false;
            if let Some(last) = clauses.last_mut() {
                is_spent = self.keep_pose(last, &mut clause)
                    || self.keep_posture(last, &mut clause) && last.postures.is_empty();
            }
            if is_spent {
                clauses.pop();
            }
            clauses.push(clause);
        }
        script.clauses = clauses;
        script
    }

    /// Does an action in a pose of the hands that the clause before puts them in. Returns whether it does.
    fn keep_pose(&self, before: &Clause, clause: &mut Clause) -> bool {
        let ([pose], [action]) = (&before.actions[..], &clause.actions[..]) else { return false };
        let is_plain = before.postures.is_empty() && before.seconds.is_none() && before.times == 1;
        if !is_plain || !RESTING.contains(&pose.verb.as_str()) || !self.leaves_arms(clause, action) {
            return false;
        }
        let Some(pair) = self.at_once(&before.actions, action, [false; 2]) else { return false };
        clause.actions = pair;
        true
    }

    /// Takes the last posture of a clause over into the next one, where hands rest in it. Returns whether it does.
    fn keep_posture(&self, before: &mut Clause, clause: &mut Clause) -> bool {
        let [action] = &clause.actions[..] else { return false };
        let rests = |posture: &Posture| {
            posture.moves_only_arms() && posture.touches.is_some_and(|touch| PLACES.contains(&touch))
        };
        let is_kept = before.is_only_postures() && before.postures.last().is_some_and(rests);
        if !is_kept || !self.leaves_arms(clause, action) {
            return false;
        }
        clause.postures.extend(before.postures.pop());
        true
    }

    /// Returns whether the one action of a clause needs no arms.
    fn leaves_arms(&self, clause: &Clause, action: &Action) -> bool {
        let is_free = |acts: Acts| matches!(acts, Acts::Feet | Acts::Foot | Acts::Body | Acts::Head);
        let moves = action.verb != "stand" && !OF_ARMS.contains(&action.verb.as_str()) && clause.postures.is_empty();
        moves && self.grammar.verb(&action.verb).is_ok_and(|verb| is_free(verb.acts))
    }
}
