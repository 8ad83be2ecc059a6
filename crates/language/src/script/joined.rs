//! Two actions at once, or one after the other.

use super::limbs::is_above;
use super::reader::{Reader, name};
use super::said::said;
use super::split::{Join, is_participle};
use super::{Clause, Script};
use crate::facts::{Action, Direction, Side};
use crate::grammar::{Acts, Verb};
use crate::posture::{Posture, Turn};

/// Gestures that nobody does while walking up to something.
const STANDING: [&str; 13] = [
    "shake_hands",
    "knock",
    "high_five",
    "press_button",
    "drink",
    "eat",
    "pour",
    "give",
    "hug",
    "pray",
    "open_door",
    "pick_up",
    "namaste",
];

/// Movements of the body on the spot that go on, and low poses.
const SWAYING: [&str; 10] = [
    "twist",
    "balance",
    "sway",
    "bounce",
    "shift_weight",
    "hip_circles",
    "step_touch",
    "hold_squat",
    "kneel",
    "crouch",
];
/// Lean of a trunk that is bent or thrown back while the robot walks, and the most of it (degrees).
const LEAN: f64 = 25.0;
const MOST_LEAN: f64 = 35.0;
const LEAN_BACK: f64 = 12.0;
/// Lean (degrees) and depth (m, of the keyframed figure) of somebody who walks crouched.
const CROUCH: (f64, f64) = (15.0, 0.1);
/// Repetitions of "some squats".
const SOME: u32 = 3;

impl Reader<'_> {
    /// Puts a comma before the verb of "while bowing spread your arms".
    pub(super) fn opened(&self, mut words: Vec<String>) -> Vec<String> {
        let opens = matches!(words.as_slice(), [first, second, ..]
            if ["while", "whilst", "when"].contains(&first.as_str()) && is_participle(second));
        let is_main = |word: &String| self.phrases.is_main_verb(word) && !is_participle(word);
        if let Some(at) = words.iter().position(is_main).filter(|_| opens && !words.iter().any(|word| word == ",")) {
            words.insert(at, ",".into());
        }
        // "Walk backwards shaking your head", "walk forward waving with the left hand".
        const OBJECTS: [&str; 12] =
            ["a", "an", "your", "the", "his", "her", "both", "left", "right", "one", "its", "with"];
        const WAYS: [&str; 17] = [
            "left",
            "right",
            "forward",
            "forwards",
            "backward",
            "backwards",
            "around",
            "along",
            "ahead",
            "slowly",
            "place",
            "spot",
            "away",
            "off",
            "in",
            "out",
            "on",
        ];
        const LOOKS: [&str; 4] = ["looking", "glancing", "gazing", "peeking"];
        let is_along = |at: &usize| {
            let looks = LOOKS.contains(&words[*at].as_str());
            is_participle(&words[*at])
                && self.phrases.is_main_verb(&words[*at])
                && (looks || words.get(at + 1).is_some_and(|word| OBJECTS.contains(&word.as_str())))
                && WAYS.contains(&words[at - 1].as_str())
        };
        if let Some(at) = (1..words.len()).find(is_along) {
            words.insert(at, "while".into());
        }
        words
    }

    /// Puts one repetition where nobody says how often, for verbs that people do once.
    pub(super) fn once(&self, mut script: Script) -> Script {
        for clause in script.clauses.iter_mut().filter(|clause| clause.seconds.is_none()) {
            let alone = clause.actions.len() == 1;
            for action in clause.actions.iter_mut().filter(|action| action.count.is_none() && action.metres.is_none()) {
                let Ok(verb) = self.grammar.verb(&action.verb) else { continue };
                // A gesture beside a walk goes on.
                let is_whole = alone || !matches!(verb.acts, Acts::Hand | Acts::Hands);
                if let Some(rule) = verb.count.filter(|_| verb.once && is_whole) {
                    action.count = Some(rule.per_cycle + rule.extra);
                }
            }
        }
        let lacking = script.clauses.iter().flat_map(|clause| &clause.actions);
        let lacking = lacking.filter_map(|action| self.grammar.verb(&action.verb).ok());
        let mut notes: Vec<String> = lacking.filter_map(without).collect();
        notes.dedup();
        script.notes.extend(notes);
        script
    }

    /// Returns how often "a step left", "some squats", "do squats" or "jump up and down" are done, where no number is said.
    pub(super) fn some(&self, verb: &Verb, words: &[String]) -> Option<u32> {
        const DOING: [&str; 9] = ["do", "does", "doing", "some", "several", "few", "perform", "practice", "throw"];
        const LIMBS: [&str; 7] = ["arms", "hands", "legs", "feet", "knees", "toes", "sides"];
        let is_plural =
            |word: &String| word.ends_with('s') && self.phrases.base(word) != *word && !LIMBS.contains(&word.as_str());
        // "Step left, step right": a step each.
        let steps = ["walk_sideways", "step_forward", "step_back"].contains(&verb.name.as_str());
        let is_one = words.iter().any(|word| word == "step") && !words.iter().any(|word| word == "side");
        if steps && is_one && said(words).metres.is_none() {
            return Some(1);
        }
        let is_again = ["up", "down"].iter().all(|way| words.iter().any(|word| word == way));
        if is_again && ["jump", "hop", "bounce"].contains(&verb.name.as_str()) {
            return Some(SOME);
        }
        let does = words.iter().position(|word| DOING.contains(&word.as_str()))?;
        (verb.once && words[does + 1..].iter().any(is_plural)).then_some(SOME)
    }

    /// Returns whether "and" joins a pose of arms that is held: "squat and hold your arms straight out".
    pub(super) fn is_held(&self, verb: &Verb, words: &[String]) -> bool {
        let keeps = words.iter().any(|word| ["hold", "keep"].contains(&self.phrases.base(word).as_str()));
        keeps && verb.is_pose() && matches!(verb.acts, Acts::Hand | Acts::Hands)
    }

    /// Appends an action: to the last clause where it is done at once with it. `free`: nobody said the side of the last
    /// action, and of this one.
    pub(super) fn add(
        &self,
        script: &mut Script,
        join: Join,
        action: Action,
        seconds: Option<f64>,
        times: u32,
        free: [bool; 2],
    ) {
        let with_last = match join {
            Join::While => true,
            // "Walks and waves" is at once; "takes two steps and waves" is not.
            Join::And => script.clauses.last().is_some_and(|last| {
                let open =
                    last.actions.iter().all(|a| a.count.is_none() && a.degrees.is_none()) && last.seconds.is_none();
                let goes = open && self.goes_along(&last.actions, &action) || self.is_round(last, &action);
                goes && times == 1 && action.degrees.is_none() && self.at_once(&last.actions, &action, free).is_some()
            }),
            _ => false,
        };
        let pair = script.clauses.last().filter(|_| with_last).map(|last| self.at_once(&last.actions, &action, free));
        match (pair, script.clauses.last_mut()) {
            (Some(Some(pair)), Some(last)) => {
                last.actions = pair;
                last.seconds = last.seconds.or(seconds);
            }
            (Some(None), Some(last)) if times == 1 && self.turns_between(last, &action, seconds) => {
                // "A U-turn while walking" is between two ways.
                let gait = if self.is_turn(&action) { last.actions[0].clone() } else { action.clone() };
                let turn = if self.is_turn(&action) { action } else { last.actions[0].clone() };
                script.notes.push(format!("'{}' is done between two ways", turn.verb.replace('_', " ")));
                *last = Clause { actions: vec![gait.clone()], ..last.clone() };
                for action in [turn, gait] {
                    script.clauses.push(Clause::new(vec![action]));
                }
            }
            // "Walk bent forward", "lean back while you walk": a bearing of the other one.
            (Some(None), Some(last)) if self.bears(last, &action, times) => {
                let (bearing, borne) = match self.bearing(&action) {
                    Some(bearing) => (bearing, last.actions[0].clone()),
                    None => (self.bearing(&last.actions[0]).unwrap_or_default(), action),
                };
                let seconds = last.seconds.or(seconds);
                *last = Clause { postures: vec![bearing], seconds, ..Clause::new(vec![borne]) };
            }
            // "A heart with the arms over your head": where the hands are.
            (Some(None), Some(last)) if action.verb == "raise_arms" && self.is_of_hands(&last.actions) => {}
            (Some(None), Some(last)) => {
                let text = |action: &Action| action.verb.replace('_', " ");
                let before: Vec<String> = last.actions.iter().map(text).collect();
                script.notes.push(format!(
                    "'{}' cannot be done during '{}': it follows",
                    text(&action),
                    before.join(" and ")
                ));
                script.clauses.push(Clause { seconds, times, ..Clause::new(vec![action]) });
            }
            _ => script.clauses.push(Clause { seconds, times, ..Clause::new(vec![action]) }),
        }
    }

    /// Returns the bearing that a lean or a crouch is for an action of the feet.
    fn bearing(&self, action: &Action) -> Option<Posture> {
        let angle = |usual: f64| action.degrees.map_or(usual, f64::from);
        let bent = |trunk: Turn| Posture { trunk: Some(trunk), ..Posture::default() };
        match action.verb.as_str() {
            "lean_forward" => Some(bent(Turn { pitch: angle(LEAN).min(MOST_LEAN), ..Turn::default() })),
            "lean_backward" => Some(bent(Turn { pitch: -angle(LEAN_BACK).min(LEAN_BACK), ..Turn::default() })),
            "lean_aside" => {
                let way = if action.direction == Some(Direction::Left) { -1.0 } else { 1.0 };
                Some(bent(Turn { roll: way * angle(LEAN_BACK).min(LEAN_BACK), ..Turn::default() }))
            }
            "crouch" | "squat" | "hold_squat" => {
                let trunk = Some(Turn { pitch: CROUCH.0, ..Turn::default() });
                Some(Posture { trunk, sink: Some(CROUCH.1), ..Posture::default() })
            }
            _ => None,
        }
    }

    /// Returns whether one of two actions goes somewhere, and the other is a bearing of it.
    fn bears(&self, last: &Clause, action: &Action, times: u32) -> bool {
        let [before] = &last.actions[..] else { return false };
        let goes = |action: &Action| {
            self.grammar.verb(&action.verb).is_ok_and(|verb| verb.acts == Acts::Feet && !self.is_turn(action))
        };
        let is_free = last.postures.is_empty() && last.times == 1 && times == 1;
        let pair = [before, action];
        is_free && pair.iter().any(|one| self.bearing(one).is_some()) && pair.iter().any(|one| goes(one))
    }

    /// Returns whether actions are gestures of the hands alone.
    fn is_of_hands(&self, actions: &[Action]) -> bool {
        let mut verbs = actions.iter().filter_map(|action| self.grammar.verb(&action.verb).ok());
        verbs.all(|verb| matches!(verb.acts, Acts::Hand | Acts::Hands))
    }

    /// Returns whether "and" is during a whole turn, or more: "turn in a circle and flap your arms".
    fn is_round(&self, last: &Clause, action: &Action) -> bool {
        let [turn] = last.actions.as_slice() else { return false };
        let repeats = |verb: &Verb| verb.cycle.is_some() && matches!(verb.acts, Acts::Hand | Acts::Hands);
        let is_whole = turn.degrees.is_some_and(|degrees| degrees >= 360) && self.is_turn(turn);
        is_whole && action.count.is_none() && self.grammar.verb(&action.verb).is_ok_and(repeats)
    }

    /// Returns whether "and" is at once: a gesture and a walk, or the head and anything.
    fn goes_along(&self, before: &[Action], action: &Action) -> bool {
        let verbs: Vec<&Verb> = before.iter().chain([action]).filter_map(|a| self.grammar.verb(&a.verb).ok()).collect();
        let of_hands = |verb: &Verb| matches!(verb.acts, Acts::Hand | Acts::Hands);
        let travels = verbs.iter().any(|verb| verb.acts == Acts::Feet && verb.direction != Some(Direction::InPlace));
        // What is not made for walking legs, such as a pose of the hips, is done in place.
        let is_carried = |verb: &Verb| verb.arms || verb.cycle.is_some() || !travels;
        let needs_standing = |verb: &Verb| travels && STANDING.contains(&verb.name.as_str());
        let gestures = |verb: &&Verb| of_hands(verb) && is_carried(verb) && !needs_standing(verb);
        let goes_on = |verb: &&Verb| verb.carries || SWAYING.contains(&verb.name.as_str());
        // "Pat your head and rub your tummy".
        let taps = |verb: &&Verb| verb.acts == Acts::Hand && verb.cycle.is_some() && verb.touches.is_some();
        if verbs.len() == 2 && verbs.iter().all(taps) {
            return true;
        }
        verbs.iter().any(|verb| verb.acts == Acts::Head) || verbs.iter().any(goes_on) && verbs.iter().any(gestures)
    }

    /// Returns two actions that other limbs do, the upper one first; nothing where they need the same limb. Of two
    /// gestures, one whose side is free is done with the other hand.
    pub(super) fn at_once(&self, before: &[Action], action: &Action, free: [bool; 2]) -> Option<Vec<Action>> {
        let [one] = before else { return None };
        let verbs = [one, action].map(|a| self.grammar.verb(&a.verb).ok());
        let [Some(a), Some(b)] = verbs else { return None };
        let (mut one, mut action) = (one.clone(), action.clone());
        let of_hands = |verb: &Verb| matches!(verb.acts, Acts::Hand | Acts::Hands);
        if of_hands(a) && of_hands(b) && one.side == action.side {
            match free {
                [_, true] => action.side = action.side.map(Side::mirrored),
                [true, false] => one.side = one.side.map(Side::mirrored),
                _ => {}
            }
        }
        if is_above((a, &one), (b, &action)) {
            return Some(vec![one, action]);
        }
        is_above((b, &action), (a, &one)).then(|| vec![action, one])
    }
}

/// Returns a note on what a robot lacks for a verb.
fn without(verb: &Verb) -> Option<String> {
    let lacks = verb.lacks.as_ref()?;
    Some(format!("'{}' is shown by the arm alone: the robot lacks {lacks}", name(verb)))
}
