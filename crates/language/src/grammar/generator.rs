//! Clips of the grammar for one robot.

use std::path::Path;

use lifelike_character::{Anatomy, Character};
use lifelike_checkpoint::rng::stream;
use lifelike_motion::clip::{Caption, Provenance};
use lifelike_motion::edit::{Compose, Length, Part, compose, joints_of, mirror, sequence, trim};
use lifelike_motion::retarget::{RetargetOptions, retarget};
use lifelike_motion::{MotionClip, keyframes};
use rand::{Rng, RngCore};

use super::draw::{Carriage, Draw, PartDraw, draw};
use super::score::{Cycle, Score};
use super::table::{Acts, Grammar, Synth};
use super::words::captions;
use crate::checks::{Finding, Tracks, check, measure};
use crate::dataset::Entry;
use crate::error::LanguageError;
use crate::facts::{HeldOut, Mood, Nominal, Relation, Side, Size};
use crate::touch::{LEG, Touching, leg_length};

/// Shortest and longest clip (s).
const SECONDS: [f64; 2] = [2.0, 10.0];
/// Captions of a clip.
const CAPTIONS: usize = 5;
/// Terms of what the grammar makes.
const LICENCE: &str = "MIT OR Apache-2.0";
/// Cross-fade between two actions (s).
const FADE: f64 = 0.4;
/// Radius of a curve (m, of the keyframed figure).
const RADIUS: f64 = 1.3;
/// Time for which a head that glances looks to one side (s).
const GLANCE: f64 = 0.9;
/// Radii that a curve may have (m, of the keyframed figure).
const RADII: [f64; 2] = [0.45, 6.0];
/// Gravity (m/s^2).
pub(super) const GRAVITY: f64 = 9.81;
/// Length of a step to the side (m, of the keyframed figure).
const SIDE_STEP: f64 = 0.17;
/// Factor of the lift of arms whose gesture is small.
const NEAR: f64 = 0.8;
/// Factor of a step aside that stays the only one.
const ONE_WIDE: f64 = 1.5;
/// Depth of the pelvis in one giant step (m, of the keyframed figure).
const DEEP: f64 = 0.12;

/// Makes clips with captions and facts of a grammar, for one robot.
pub struct Generator<'a> {
    grammar: &'a Grammar,
    character: &'a Character,
    anatomy: &'a Anatomy,
    options: RetargetOptions,
    /// Times by which the robot is smaller than the keyframed figure.
    smaller: f64,
    /// Places that its hands can touch.
    touching: Option<Touching>,
    /// Scores of all verbs.
    scores: Vec<Score>,
    /// Normal values of each verb, by the side as written; none of those that this robot cannot do.
    nominal: Vec<Option<Nominal>>,
    usable: Vec<usize>,
    /// The verbs that this robot cannot do, and why.
    pub left_out: Vec<(String, String)>,
}

/// A clip of the grammar.
#[derive(Debug, Clone)]
pub struct Made {
    /// The clip, with its captions.
    pub clip: MotionClip,
    /// Its line of the index.
    pub entry: Entry,
    /// Results of the checks.
    pub findings: Vec<Finding>,
}

impl Made {
    /// Returns whether everything that is said is true.
    pub fn is_true(&self) -> bool {
        self.findings.iter().all(|finding| finding.passed)
    }
}

impl<'a> Generator<'a> {
    /// Returns the grammar.
    pub(super) fn grammar(&self) -> &Grammar {
        self.grammar
    }

    /// Returns the robot.
    pub(super) fn character(&self) -> &Character {
        self.character
    }

    /// Returns the robot's anatomy.
    pub(super) fn anatomy(&self) -> &Anatomy {
        self.anatomy
    }

    /// Returns the options of retargeting.
    pub(super) fn options(&self) -> &RetargetOptions {
        &self.options
    }

    /// Returns how many times the robot is smaller than the keyframed figure.
    pub(super) fn smaller(&self) -> f64 {
        self.smaller
    }

    /// Returns the places that its hands can touch; none without hands.
    pub(super) fn touching(&self) -> Option<&Touching> {
        self.touching.as_ref()
    }

    /// Returns what is normal of a verb; nothing where this robot cannot do it.
    pub(super) fn nominal(&self, verb: usize) -> Option<Nominal> {
        self.nominal[verb]
    }

    /// Prepares a grammar for a robot: every verb is made once and measured. `options` are those of retargeting.
    ///
    /// # Errors
    /// [`LanguageError::Grammar`] for a clip that there is not.
    pub fn new(
        grammar: &'a Grammar,
        character: &'a Character,
        anatomy: &'a Anatomy,
        options: RetargetOptions,
    ) -> Result<Self, LanguageError> {
        let verbs: Vec<&str> = grammar.verbs.iter().map(|verb| verb.name.as_str()).collect();
        Self::of_verbs(grammar, character, anatomy, options, &verbs)
    }

    /// Prepares some verbs of a grammar for a robot; others cannot be drawn or performed.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn of_verbs(
        grammar: &'a Grammar,
        character: &'a Character,
        anatomy: &'a Anatomy,
        options: RetargetOptions,
        verbs: &[&str],
    ) -> Result<Self, LanguageError> {
        // Keyframed feet are exact.
        let options = RetargetOptions { contact: options.contact.without_noise(), ..options };
        let mut scores = Vec::new();
        for verb in &grammar.verbs {
            let found = keyframes::builtin().find(|(name, _)| *name == verb.clip);
            let (name, text) = found.ok_or_else(|| {
                LanguageError::Grammar(format!("verb '{}': expected a keyframed clip, got '{}'", verb.name, verb.clip))
            })?;
            scores.push(Score::parse(name, text)?);
        }
        let mut generator = Self {
            grammar,
            character,
            anatomy,
            options,
            smaller: LEG / leg_length(character, anatomy),
            touching: Touching::of(character, anatomy),
            scores,
            nominal: Vec::new(),
            usable: Vec::new(),
            left_out: Vec::new(),
        };
        for (number, verb) in grammar.verbs.iter().enumerate() {
            if !verbs.contains(&verb.name.as_str()) {
                generator.nominal.push(None);
                continue;
            }
            // At least two repetitions, so that there is a period.
            let normal = verb.cycles.map_or(0, |[fewest, most]| (fewest + 2).min(most));
            let part = PartDraw {
                verb: number,
                mirrored: false,
                cycles: normal,
                degrees: 90.0,
                speed: 1.0,
                gain: 1.0,
                action: crate::facts::Action::of(&verb.name),
                carriage: Carriage::default(),
            };
            let nominal = generator.part(&part, None).and_then(|clip| {
                let tracks = Tracks::of(&clip, character, anatomy)?;
                if verb.acts == Acts::Head && !turns(&tracks.head) {
                    return Err(LanguageError::Grammar("expected a head that turns, got one without joints".into()));
                }
                Ok(measure::nominal(&tracks, verb, verb.side))
            });
            match nominal {
                Ok(nominal) => {
                    generator.usable.push(number);
                    generator.nominal.push(Some(nominal));
                }
                Err(why) => {
                    generator.left_out.push((verb.name.clone(), why.to_string()));
                    generator.nominal.push(None);
                }
            }
        }
        Ok(generator)
    }

    /// Draws what clip `index` is to be.
    pub fn draw(&self, seed: u64, index: u64) -> Option<Draw> {
        let mut drawn = draw(self.grammar, &self.usable, seed, index)?;
        for (action, part) in drawn.facts.actions.iter_mut().zip(&drawn.parts) {
            if action.speed.is_some() || action.size.is_some() || action.mood.is_some() {
                action.nominal = self.nominal[part.verb];
            }
        }
        Some(drawn)
    }

    /// Makes a drawn clip; none where it would be shorter or longer than clips are.
    ///
    /// # Errors
    /// As retargeting and editing.
    pub fn make(&self, drawn: &Draw, seed: u64) -> Result<Option<Made>, LanguageError> {
        let mut rng = stream(seed, "grammar motion", drawn.index, 0);
        let mut clips = Vec::new();
        for part in &drawn.parts {
            clips.push(self.part(part, Some(&mut rng))?);
        }
        let joined = match (drawn.facts.relation, clips.as_slice()) {
            (Relation::Then, [a, b]) => {
                let (a, b) = (self.without_pauses(a, &mut rng)?, self.without_pauses(b, &mut rng)?);
                sequence(&[Part::from(&a), Part::from(&b)], FADE)?
            }
            (Relation::While, [gesture, legs]) => match self.on_legs(gesture, legs, &drawn.parts[0], &mut rng)? {
                Some(clip) => clip,
                None => return Ok(None),
            },
            (_, [clip, ..]) => self.without_pauses(clip, &mut rng)?,
            (_, []) => return Ok(None),
        };
        if !(SECONDS[0]..=SECONDS[1]).contains(&joined.seconds()) {
            return Ok(None);
        }
        self.finish(joined, drawn, seed).map(Some)
    }

    /// Captions, checks, names.
    fn finish(&self, mut clip: MotionClip, drawn: &Draw, seed: u64) -> Result<Made, LanguageError> {
        let tracks = Tracks::of(&clip, self.character, self.anatomy)?;
        let findings = check(&tracks, self.grammar, &drawn.facts)?;
        let new = drawn.facts.held_out == Some(HeldOut::Words);
        let mut rng = stream(seed, "grammar words", drawn.index, 0);
        let texts = captions(self.grammar, &drawn.facts, new, CAPTIONS, &mut rng)?;
        let verbs: Vec<&str> = drawn.facts.actions.iter().map(|action| action.verb.as_str()).collect();
        clip.name = format!("g{:06}_{}", drawn.index, verbs.join("+"));
        let end = clip.seconds();
        let source = format!("grammar, seed {seed}, {}", drawn.index);
        clip.provenance = Provenance {
            character: self.character.name.clone(),
            source: source.clone(),
            licence: LICENCE.into(),
            captions: texts.iter().map(|text| Caption { start: 0.0, end, text: text.clone() }).collect(),
        };
        clip.cyclic = false;
        let entry = Entry {
            file: format!("{}/{}{}", drawn.split.name(), clip.name, lifelike_motion::container::EXTENSION),
            split: drawn.split,
            seconds: end,
            captions: texts,
            source,
            licence: LICENCE.into(),
            facts: Some(drawn.facts.clone()),
        };
        Ok(Made { clip, entry, findings })
    }

    /// Makes one action: the keyframed text, changed, on the robot. Without `rng` it is as written.
    pub(super) fn part(&self, part: &PartDraw, rng: Option<&mut dyn RngCore>) -> Result<MotionClip, LanguageError> {
        let verb = &self.grammar.verbs[part.verb];
        let mut score = self.scores[part.verb].clone();
        let locomotion = verb.acts == Acts::Feet;
        match part.action.degrees.filter(|_| verb.angles) {
            Some(degrees) => score.lift_arms(f64::from(degrees)),
            None if locomotion => {}
            None => score.larger(part.gain, verb.cycle.as_ref()),
        }
        if verb.acts == Acts::Foot && part.action.size.is_some() {
            score.higher_steps(part.gain);
        }
        match part.action.size {
            Some(Size::Big) => score.higher_jumps(part.gain * part.gain),
            Some(Size::Small) => score.higher_jumps(part.gain),
            None => {}
        }
        if part.action.size == Some(Size::Small) && verb.is_free_gesture() {
            // What is small is near the body, too.
            ["left_arm", "right_arm"].iter().for_each(|arm| score.lift_part(arm, NEAR));
        }
        if let Some(cycle) = &verb.cycle {
            score.repeat(cycle, part.cycles);
        }
        match verb.synth {
            Some(Synth::Turn) => score.turn(part.degrees),
            Some(Synth::Curve) => {
                let radius = part.action.metres.map_or(RADIUS, |wide| 0.5 * wide * self.smaller);
                score.curve(radius.clamp(RADII[0], RADII[1]), part.degrees);
            }
            Some(Synth::Sideways) => {
                let size = match (part.action.size, part.action.metres.and(part.action.count)) {
                    (Some(_), _) => part.gain * part.gain,
                    (None, Some(_)) => part.gain,
                    (None, None) => 1.0,
                };
                // One step alone is seen if it is wide.
                let is_free = part.action.size.is_none() && part.action.metres.is_none();
                let wide = if part.cycles == 1 && is_free { ONE_WIDE } else { 1.0 };
                score.sideways(part.cycles, [0.0, SIDE_STEP * size * wide]);
            }
            Some(Synth::Diagonal) => score.sideways(part.cycles, [SIDE_STEP, SIDE_STEP]),
            None => {}
        }
        let is_step = verb.cycle.as_ref().is_some_and(|cycle| cycle.count == 1);
        if locomotion && verb.synth.is_none() && is_step && part.action.size == Some(Size::Big) {
            // One giant step: as far as bent knees reach.
            score.deeper(DEEP);
            score.longer_steps(part.gain);
        } else if locomotion && verb.synth.is_none() {
            score.longer_steps(if part.gain > 1.2 { 1.0 + 0.6 * (part.gain - 1.0) } else { part.gain });
        }
        if let Some(rng) = rng {
            vary(&mut score, verb.cycle.as_ref(), rng);
        }
        if let Some(manner) = part.action.mood.map(Mood::manner) {
            let free: Vec<&str> = ["left_arm", "right_arm"].into_iter().filter(|arm| score.hangs(arm)).collect();
            score.offset("chest", "pitch", manner.chest);
            score.offset("head", "pitch", manner.head);
            for (axis, by) in ["raise", "aside", "elbow"].iter().zip(manner.arms) {
                free.iter().for_each(|arm| score.offset(arm, axis, by));
            }
            if manner.glances > 0.0 && score.leaves("head", "yaw") {
                score.glance(manner.glances, GLANCE);
            }
            if verb.touches.is_none() && matches!(verb.acts, Acts::Hand | Acts::Hands) {
                ["left_arm", "right_arm"].iter().for_each(|arm| score.lift_part(arm, manner.lift));
            }
        }
        carry(&mut score, &part.carriage, if part.mirrored { -1.0 } else { 1.0 });
        score.faster(part.speed);
        score.fall(GRAVITY * self.smaller);
        let source = keyframes::parse(score.to_text().as_bytes(), Path::new(&format!("{}.keys.toml", verb.name)))?;
        let (mut clip, _) = retarget(&source, self.character, self.anatomy, &self.options)?;
        if let (Some(touching), Some(touch)) = (&self.touching, verb.touches) {
            let side = verb.side.unwrap_or(Side::Both);
            clip = touching.reached(&clip, (self.character, self.anatomy), (touch, side), &self.options)?;
        }
        if let Some(side @ (Side::Left | Side::Right)) = part.action.side.filter(|_| verb.is_of_each_hand()) {
            let other = if side == Side::Left { "right_arm" } else { "left_arm" };
            hang(&mut clip, &joints_of(self.character, self.anatomy, &[other.into()])?);
        }
        Ok(if part.mirrored { mirror(&clip, self.character)? } else { clip })
    }

    /// Cuts most of the standing before and after.
    fn without_pauses<R: Rng>(&self, clip: &MotionClip, rng: &mut R) -> Result<MotionClip, LanguageError> {
        let (head, tail) = (rng.random_range(0.1..0.3), rng.random_range(0.05..0.2));
        let spare = clip.seconds() - SECONDS[0];
        if spare < head + tail {
            return Ok(clip.clone());
        }
        Ok(trim(clip, Some(head), Some(clip.seconds() - tail))?)
    }

    /// Composes a gesture's arms on walking legs; none where the gesture does not fit.
    fn on_legs<R: Rng>(
        &self,
        gesture: &MotionClip,
        legs: &MotionClip,
        part: &PartDraw,
        rng: &mut R,
    ) -> Result<Option<MotionClip>, LanguageError> {
        let gesture = trim(gesture, Some(0.3), Some(gesture.seconds() - 0.2))?;
        let spare = legs.seconds() - 0.2 - gesture.seconds();
        if spare < 0.2 {
            return Ok(None);
        }
        let arms = match part.action.side {
            Some(Side::Left) => "left_arm",
            Some(Side::Right) => "right_arm",
            _ => "arms",
        };
        let joints = joints_of(self.character, self.anatomy, &[arms.into()])?;
        let offset = rng.random_range(0.1..=spare);
        Ok(Some(compose(legs, &gesture, &Compose { joints, offset, length: Length::Return, fade: 0.35 })?))
    }
}

/// Keeps joints as they are in the first frame.
fn hang(clip: &mut MotionClip, joints: &[String]) {
    let width = clip.joint_names.len();
    let columns: Vec<usize> = (0..width).filter(|column| joints.contains(&clip.joint_names[*column])).collect();
    let first = clip.joints_at(0).to_vec();
    for frame in clip.joints.chunks_exact_mut(width.max(1)) {
        columns.iter().for_each(|column| frame[*column] = first[*column]);
    }
}

/// Returns whether a head moves at all.
fn turns(head: &[[f64; 2]]) -> bool {
    let Some(first) = head.first() else { return false };
    head.iter().any(|at| (0..2).any(|k| (at[k] - first[k]).abs() > 0.02))
}

/// Small differences that no sentence says.
fn vary(score: &mut Score, cycle: Option<&Cycle>, rng: &mut dyn RngCore) {
    for part in ["left_arm", "right_arm"] {
        score.scale_part(part, rng.random_range(0.94..1.07));
    }
    // Of what repeats, posture only: angles of the trunk are small.
    if cycle.is_none() || rng.random_bool(0.5) {
        score.scale_part("chest", rng.random_range(0.8..1.25));
        score.scale_part("head", rng.random_range(0.85..1.15));
    }
    score.offset("chest", "pitch", rng.random_range(-1.5..2.0));
}

/// Holds trunk, head and knees in a bearing; `way` is -1 where the mirror image is taken afterwards.
fn carry(score: &mut Score, carriage: &Carriage, way: f64) {
    let Carriage { trunk, head, sink } = carriage;
    let channels = [
        ("chest", "pitch", trunk.pitch),
        ("chest", "roll", way * trunk.roll),
        ("chest", "yaw", way * trunk.yaw),
        ("head", "pitch", head.pitch),
        ("head", "yaw", way * head.yaw),
        ("pelvis", "z", -sink),
    ];
    for (part, axis, by) in channels.into_iter().filter(|(_, _, by)| *by != 0.0) {
        score.offset(part, axis, by);
    }
}
