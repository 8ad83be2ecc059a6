//! Clauses of a script as motion of a robot: by the rules of the grammar, exact where something is counted.

use lifelike_checkpoint::rng::stream;
use lifelike_motion::MotionClip;
use lifelike_motion::edit::{Compose, Length, Part, compose, joints_of, sequence, trim};
use rand::Rng;

use super::draw::{Carriage, PartDraw};
use super::generator::Generator;
use super::spans::{held, reached, repeated, rise_of, still_seconds, stillest, walked};
use super::table::{Acts, Show, Synth, Tempo, Verb};
use crate::checks::{Fact, Finding, SIMULATED, SignalName, Tracks, check, measure};
use crate::error::LanguageError;
use crate::facts::{Action, Direction, Facts, Mood, Side, Size, Speed};
use crate::script::Clause;

/// Cross-fade between two clauses (s).
pub const FADE: f64 = 0.4;
/// Tempos that a duration may ask for, beside the natural one.
pub(super) const TEMPO: [f64; 2] = [0.6, 1.6];
/// Tempos in which a pose is taken.
const RISES: [f64; 2] = [0.15, 1.6];
/// Largest error of a duration, as a share.
const DURATION: f64 = 0.1;
/// The same in physics, which takes a moment to begin and to end.
const SIMULATED_DURATION: f64 = 0.2;
/// Least time between two gestures on legs that last (s).
const PAUSE: f64 = 2.5;
/// Corrections of a bend to an angle, and the sizes that it may have, beside the natural one.
const BENDS: u32 = 2;
const BEND: [f64; 2] = [0.2, 2.5];
/// Least length of a step in any mood, as a share of the usual one.
const SHORTEST: f64 = 0.8;
/// Angle of a turn of which none is said (degrees).
const QUARTER: f64 = 90.0;
/// Draws of tempo and amplitude until one can be performed.
const TRIES: u64 = 8;
/// Factor by which tempo and size are exaggerated where what was said is not seen, and the most of it.
const MORE_EMPHASIS: f64 = 1.2;
/// Factor of the same where the robot's legs cannot do it.
pub(super) const LESS_EMPHASIS: f64 = 0.88;
const MOST_EMPHASIS: f64 = 1.5;
/// Low poses on whose way a gesture is done: a punch lands with the foot.
const ON_THE_WAY: [&str; 4] = ["lunge", "lunge_side", "lunge_back", "curtsy"];
/// Shortest stillness of arms that is a pose to be kept (s), and the time they take to get there and back.
const KEPT: f64 = 0.6;
pub(super) const ARMS_UP: f64 = 1.0;
/// Share of a pose's clip in which it is still.
const POSED: f64 = 0.15;
/// Most cycles that a duration may ask for.
pub(super) const MAX_CYCLES: u32 = 30;

/// The motion of a clause.
#[derive(Debug, Clone)]
pub struct Performed {
    /// The motion.
    pub clip: MotionClip,
    /// Facts that were checked on it.
    pub findings: Vec<Finding>,
}

impl Generator<'_> {
    /// Makes the motion of a clause by rule. Seeds vary tempo and amplitude where nothing is said of them.
    ///
    /// # Errors
    /// [`LanguageError::Grammar`] for a verb that this robot cannot do; as retargeting and editing.
    pub fn perform(&self, clause: &Clause, seed: u64, index: u64) -> Result<Performed, LanguageError> {
        let once = |attempt: u64, emphasis: f64| {
            let mut rng = stream(seed, "clause", index, attempt);
            let clip = match clause.actions.as_slice() {
                [action] if clause.is_only_postures() => self.postured(&clause.postures, action.mood),
                [action] if !clause.postures.is_empty() => {
                    let part = self.part_of(action, emphasis, &mut rng)?;
                    let part = PartDraw { carriage: Carriage::of(&clause.postures[0]), ..part };
                    let below = self.timed(part, action, clause.seconds, &mut rng)?;
                    self.held_during(&clause.postures, &action.verb, below)
                }
                [action] if clause.rise.is_some() => self.rising(action, clause.rise, emphasis, &mut rng),
                [action] => self.alone(action, clause.seconds, emphasis, &mut rng),
                [gesture, legs] => self.at_once(gesture, legs, clause.seconds, emphasis, &mut rng),
                _ => Err(LanguageError::Grammar("expected one action or two, got others".into())),
            }?;
            let findings = self.findings(&clip, clause)?;
            Ok(Performed { clip, findings })
        };
        let is_manner = |f: &&Finding| matches!(f.fact, Fact::Speed | Fact::Size) && !f.passed;
        let unseen = |made: &Performed| made.findings.iter().filter(is_manner).count();
        let mut best = once(0, 1.0);
        let mut emphasis = 1.0;
        for attempt in 1..TRIES {
            match &best {
                // A draw may ask for steps that are too long for the legs; another one, or less of it, does not.
                Err(LanguageError::Motion(_)) => {
                    emphasis *= LESS_EMPHASIS;
                    best = once(attempt, emphasis);
                }
                // What is said must be seen: more of it.
                Ok(made) if unseen(made) > 0 && (1.0..MOST_EMPHASIS).contains(&emphasis) => {
                    emphasis *= MORE_EMPHASIS;
                    let next = once(attempt, emphasis);
                    if next.as_ref().is_ok_and(|next| unseen(next) < unseen(made)) {
                        best = next;
                    }
                }
                _ => break,
            }
        }
        let Performed { clip, findings } = best?;
        let clip = match clause.times {
            0 | 1 => clip,
            n => {
                let parts: Vec<Part<'_>> = (0..n).map(|_| Part::from(&clip)).collect();
                sequence(&parts, FADE)?
            }
        };
        Ok(Performed { clip, findings })
    }

    /// Checks the facts of a clause on a clip of it, with what is normal on this robot.
    ///
    /// # Errors
    /// [`LanguageError::Grammar`] for a verb that the grammar has not.
    pub fn findings(&self, clip: &MotionClip, clause: &Clause) -> Result<Vec<Finding>, LanguageError> {
        let tracks = Tracks::of(clip, self.character(), self.anatomy())?;
        if clause.is_only_postures() {
            return Ok(self.findings_of_postures(&tracks, &clause.postures));
        }
        self.checked(&tracks, clause)
    }

    fn checked(&self, tracks: &Tracks, clause: &Clause) -> Result<Vec<Finding>, LanguageError> {
        let mut found = check(tracks, self.grammar(), &self.measurable(clause))?;
        let is_of_hands = |finding: &Finding| {
            self.grammar().verb(&finding.verb).is_ok_and(|verb| matches!(verb.acts, Acts::Hand | Acts::Hands))
        };
        // Beside an arm that a posture moves, a gesture's hand is not the one that moves most.
        if clause.postures.iter().any(|posture| posture.left_arm.is_some() || posture.right_arm.is_some()) {
            found.retain(|finding| finding.fact != Fact::Limb || !is_of_hands(finding));
        }
        Ok(found)
    }

    /// Checks whether a motion lasts as long as was asked for; nothing where no duration was. Of a pose its hold counts,
    /// of a gesture its repetitions, of a walk its steps: the way there and back is beside what lasts.
    ///
    /// # Errors
    /// As [`Self::findings`].
    pub fn lasting(&self, clip: &MotionClip, clause: &Clause) -> Result<Option<Finding>, LanguageError> {
        let tracks = Tracks::of(clip, self.character(), self.anatomy())?;
        self.lasting_within(clip, &tracks, clause, DURATION)
    }

    fn lasting_within(
        &self,
        clip: &MotionClip,
        tracks: &Tracks,
        clause: &Clause,
        share: f64,
    ) -> Result<Option<Finding>, LanguageError> {
        if let (Some(wanted), Some(action)) = (clause.rise, clause.actions.first()) {
            let got = rise_of(clip).unwrap_or(0.0);
            return Ok(Some(Finding {
                verb: action.verb.clone(),
                fact: Fact::Seconds,
                expected: format!("there after {wanted} s, within {:.0}%", 200.0 * share),
                got: format!("{got:.1} s"),
                passed: (got / wanted - 1.0).abs() <= 2.0 * share,
            }));
        }
        // Of two actions at once, the legs' or what the other one is done with.
        let (Some(wanted), Some(action)) = (clause.seconds, clause.actions.last()) else { return Ok(None) };
        let verb = self.grammar().verb(&action.verb)?;
        let alone = clause.times <= 1;
        let (what, got) = match verb.cycle {
            None if alone && verb.shows.contains(&Show::FootHeld) => {
                ("the foot up for ", measure::held_up(tracks, action.side))
            }
            None if alone
                && verb.is_pose()
                && self.number(&verb.name).map_or(Ok(true), |verb| self.is_held(verb))? =>
            {
                ("held for ", still_seconds(clip))
            }
            Some(_) if alone && verb.acts != Acts::Feet => {
                let count = verb.count.and_then(|rule| measure::count(tracks, &rule, action.side));
                let period = measure::tempo(tracks, verb, action.side);
                match (verb.tempo, count, period) {
                    (Tempo::Period, Some(count), Some(period)) => ("repeated for ", count as f64 * period),
                    _ => ("", clip.seconds()),
                }
            }
            _ if alone && verb.acts == Acts::Feet => ("walked for ", walked(tracks)),
            _ => ("", clip.seconds()),
        };
        Ok(Some(Finding {
            verb: action.verb.clone(),
            fact: Fact::Seconds,
            expected: format!("{what}{wanted} s, within {:.0}%", 100.0 * share),
            got: format!("{got:.1} s"),
            passed: (got / wanted - 1.0).abs() <= share,
        }))
    }

    /// Checks the facts of a clause on what physics made of its motion: soles rock, so a step is a higher lift.
    ///
    /// # Errors
    /// As [`Self::findings`].
    pub fn findings_in_physics(&self, clip: &MotionClip, clause: &Clause) -> Result<Vec<Finding>, LanguageError> {
        let tracks = Tracks { lift: SIMULATED, ..Tracks::of(clip, self.character(), self.anatomy())? };
        if clause.is_only_postures() {
            return Ok(self.findings_of_postures(&tracks, &clause.postures));
        }
        // Steps of physics are compared one by one by the evaluation's verdict.
        let steps = |verb: &Verb| verb.count.is_some_and(|rule| rule.signal == SignalName::Steps);
        let mut findings = self.checked(&tracks, clause)?;
        findings.retain(|f| f.fact != Fact::Count || !self.grammar().verb(&f.verb).is_ok_and(steps));
        findings.extend(self.lasting_within(clip, &tracks, clause, SIMULATED_DURATION)?);
        Ok(findings)
    }

    /// Returns the facts of a clause, with what speed, size and mood are relative to.
    pub fn measurable(&self, clause: &Clause) -> Facts {
        let mut facts = clause.facts();
        for action in &mut facts.actions {
            if action.speed.is_some() || action.size.is_some() || action.mood.is_some() {
                action.nominal = self.number(&action.verb).and_then(|number| self.nominal(number));
            }
            // A farther turn lasts longer.
            let is_turn = self.grammar().verb(&action.verb).is_ok_and(|verb| verb.synth == Some(Synth::Turn));
            if let (Some(nominal), Some(degrees), true) = (&mut action.nominal, action.degrees, is_turn) {
                nominal.tempo *= f64::from(degrees) / QUARTER;
            }
        }
        facts
    }

    /// Returns whether a verb without repetitions is a pose that is held, by its own clip: a dance of stops is none.
    fn is_held(&self, verb: usize) -> Result<bool, LanguageError> {
        let known = &self.grammar().verbs[verb];
        let part = PartDraw {
            verb,
            mirrored: false,
            cycles: 0,
            degrees: 0.0,
            speed: 1.0,
            gain: 1.0,
            action: Action::of(&known.name),
            carriage: Carriage::default(),
        };
        let clip = self.part(&part, None)?;
        let still = still_seconds(&clip);
        Ok(known.shows.contains(&Show::FootHeld) || still >= KEPT && still >= POSED * clip.seconds())
    }

    fn number(&self, verb: &str) -> Option<usize> {
        self.grammar().verbs.iter().position(|known| known.name == verb)
    }

    /// Makes one action.
    fn alone(
        &self,
        action: &Action,
        seconds: Option<f64>,
        emphasis: f64,
        rng: &mut impl Rng,
    ) -> Result<MotionClip, LanguageError> {
        self.timed(self.part_of(action, emphasis, rng)?, action, seconds, rng)
    }

    /// Makes one action as far and for as long as was asked for.
    fn timed(
        &self,
        mut part: PartDraw,
        action: &Action,
        seconds: Option<f64>,
        rng: &mut impl Rng,
    ) -> Result<MotionClip, LanguageError> {
        let is_arc = self.grammar().verbs[part.verb].synth == Some(Synth::Curve);
        if let Some(metres) = action.metres.filter(|_| !is_arc) {
            return match action.count {
                Some(_) => self.in_steps(part, metres, rng),
                None => self.as_far(part, metres, seconds, rng),
            };
        }
        let Some(wanted) = seconds else { return self.shortened(self.part(&part, Some(rng))?) };
        let verb = &self.grammar().verbs[part.verb];
        let natural =
            |part: &PartDraw| -> Result<f64, LanguageError> { Ok(self.shortened(self.part(part, None)?)?.seconds()) };
        // A tempo that was said stays.
        let own = if action.speed.is_some() { part.speed } else { 1.0 };
        part.speed = own;
        let natural_clip = self.shortened(self.part(&part, None)?)?;
        let length = natural_clip.seconds();
        let even = verb.is_even();
        if verb.is_pose() {
            let clip = self.shortened(self.part(&part, Some(rng))?)?;
            // What hardly stands still, such as a dance, is done again.
            if self.is_held(part.verb)? {
                // Of a foot that is up the whole time in the air counts.
                let tracks = Tracks::of(&clip, self.character(), self.anatomy())?;
                let is_up = verb.shows.contains(&Show::FootHeld);
                let up = if is_up { measure::held_up(&tracks, action.side) } else { 0.0 };
                return Ok(held(&clip, wanted - (up - still_seconds(&clip)).max(0.0)));
            }
            let times = ((wanted + FADE) / (clip.seconds() - FADE).max(0.5)).round().max(1.0) as usize;
            let parts: Vec<Part<'_>> = (0..times.min(MAX_CYCLES as usize)).map(|_| Part::from(&clip)).collect();
            return Ok(sequence(&parts, FADE)?);
        }
        // Of a walk the time from the first step to the last one counts.
        let walked = walked(&Tracks::of(&natural_clip, self.character(), self.anatomy())?);
        let wanted = wanted + if verb.acts == Acts::Feet && walked > 0.0 { length - walked } else { 0.0 };
        let mut active = length;
        if verb.cycle.is_some() && action.count.is_none() {
            let one = natural(&PartDraw { cycles: part.cycles + 1, ..part.clone() })? - length;
            let least = verb.cycles.map_or(0, |[fewest, _]| fewest).max(1);
            // Steps are the whole of a walk; a gesture's way up and down is beside its repetitions.
            let ramps = match verb.count {
                _ if verb.acts == Acts::Feet => length - f64::from(part.cycles) * one,
                Some(rule) => f64::from(rule.extra) / f64::from(rule.per_cycle.max(1)) * one,
                None => 0.0,
            };
            let cycles = ((wanted - ramps) / one.max(1e-6)).round();
            part.cycles = cycles.clamp(f64::from(least), f64::from(MAX_CYCLES)) as u32;
            active = f64::from(part.cycles) * one + ramps;
        }
        let range = match action.speed {
            _ if even => [0.3, 3.0],
            Some(_) => [0.95, 1.05],
            None => TEMPO,
        };
        part.speed = own * (active / wanted).clamp(range[0], range[1]);
        let clip = self.shortened(self.part(&part, Some(rng))?)?;
        let is_longer = even && clip.seconds() > wanted + 0.1;
        Ok(if is_longer { trim(&clip, Some(0.0), Some(wanted))? } else { clip })
    }

    /// Goes to a pose and back in a tempo in which the way there takes so long (s).
    fn rising(
        &self,
        action: &Action,
        rise: Option<f64>,
        emphasis: f64,
        rng: &mut impl Rng,
    ) -> Result<MotionClip, LanguageError> {
        let mut part = self.part_of(action, emphasis, rng)?;
        part.speed = 1.0;
        let natural = rise_of(&self.part(&part, None)?);
        if let Some((natural, wanted)) = natural.zip(rise) {
            part.speed = (natural / wanted).clamp(RISES[0], RISES[1]);
        }
        self.shortened(self.part(&part, Some(rng))?)
    }

    /// Composes a gesture's arms on walking legs, both repeated until they last as long.
    fn at_once(
        &self,
        gesture: &Action,
        legs: &Action,
        seconds: Option<f64>,
        emphasis: f64,
        rng: &mut impl Rng,
    ) -> Result<MotionClip, LanguageError> {
        let arms_part = self.part_of(gesture, emphasis, rng)?;
        let verb = &self.grammar().verbs[arms_part.verb];
        let arms = self.part(&arms_part, Some(rng))?;
        let arms = trim(&arms, Some(0.3), Some(arms.seconds() - 0.2))?;
        let wanted = seconds.unwrap_or(arms.seconds() + 0.6).max(arms.seconds() + 0.6);
        let below = self.part_of(legs, emphasis, rng)?;
        let long = self.shortened(self.part(&below, None)?)?.seconds() >= wanted;
        let is_arc = self.grammar().verbs[below.verb].synth == Some(Synth::Curve);
        let legs_clip = if let Some(metres) = legs.metres.filter(|_| !is_arc) {
            self.as_far(below, metres, seconds, rng)?
        } else if seconds.is_some() && self.grammar().verbs[below.verb].shows.contains(&Show::FootHeld) {
            self.alone(legs, seconds, emphasis, rng)?
        } else if long || legs.count.is_some() || legs.degrees.is_some() {
            let clip = self.shortened(self.part(&below, Some(rng))?)?;
            // Legs that are counted may be shorter than the gesture: they walk slower.
            let short = clip.seconds() < wanted;
            let slower = PartDraw { speed: below.speed * (clip.seconds() / wanted).max(TEMPO[0]), ..below.clone() };
            if short { self.shortened(self.part(&slower, Some(rng))?)? } else { clip }
        } else {
            self.alone(legs, Some(wanted), emphasis, rng)?
        };
        // What repeats goes on for as long as the legs do.
        let spare = legs_clip.seconds() - arms.seconds();
        let period = verb.cycle.filter(|_| gesture.count.is_none()).map(|cycle| cycle.period / arms_part.speed);
        let more = period.map_or(0, |period| (spare / period).floor().clamp(0.0, f64::from(MAX_CYCLES)) as u32);
        let arms = match more {
            0 => arms,
            _ => {
                let longer = PartDraw { cycles: arms_part.cycles + more, ..arms_part.clone() };
                let arms = self.part(&longer, Some(rng))?;
                trim(&arms, Some(0.3), Some(arms.seconds() - 0.2))?
            }
        };
        let low = self.low_pose(legs)? && !ON_THE_WAY.contains(&legs.verb.as_str());
        let poses = matches!(verb.acts, Acts::Hand | Acts::Hands) && verb.is_pose() && still_seconds(&arms) >= KEPT;
        let (arms, legs_clip) = match poses && !low {
            true => self.kept(arms, &legs.verb, legs_clip, seconds)?,
            false => (arms, legs_clip),
        };
        let names = match (verb.acts, gesture.side) {
            (Acts::Head, _) => "head",
            (_, Some(Side::Left)) => "left_arm",
            (_, Some(Side::Right)) => "right_arm",
            _ => "arms",
        };
        let joints = joints_of(self.character(), self.anatomy(), &[names.into()])?;
        if low && poses {
            return self.with_pose(&legs_clip, &arms, joints, seconds);
        }
        if low {
            return self.during_hold(&legs_clip, &arms, joints, seconds);
        }
        let spare = (legs_clip.seconds() - arms.seconds()).max(0.0);
        // On legs that last the gesture is done now and then, where nobody says how often.
        let again =
            if gesture.count.is_some() || gesture.speed.is_some() { 0.0 } else { spare / (arms.seconds() + PAUSE) };
        let times = again.floor() as usize + 1;
        let mut clip = legs_clip;
        for time in 0..times {
            let middle = clip.seconds() * (time as f64 + 0.5) / times as f64;
            let offset = middle - 0.5 * arms.seconds();
            let options =
                Compose { joints: joints.clone(), offset: offset.max(0.0), length: Length::Return, fade: 0.35 };
            clip = compose(&clip, &arms, &options)?;
        }
        Ok(clip)
    }

    /// Returns whether an action goes down to a pose of the legs that is held: what else is said is done there.
    pub(super) fn low_pose(&self, legs: &Action) -> Result<bool, LanguageError> {
        let Some(number) = self.number(&legs.verb) else { return Ok(false) };
        Ok(self.grammar().verbs[number].is_low_pose() && self.is_held(number)?)
    }

    /// Moves some joints of a pose as another clip does, from where the pose is reached; it is held for as long as that takes.
    pub(super) fn during_hold(
        &self,
        pose: &MotionClip,
        moving: &MotionClip,
        joints: Vec<String>,
        seconds: Option<f64>,
    ) -> Result<MotionClip, LanguageError> {
        let longest = moving.seconds().max(seconds.unwrap_or_else(|| still_seconds(pose)));
        let clip = held(pose, longest);
        let options = Compose { joints, offset: reached(pose), length: Length::Return, fade: 0.35 };
        Ok(compose(&clip, moving, &options)?)
    }

    /// Holds arms in a pose while the legs are in theirs. They are there when the legs are: "duck, hands on your head".
    fn with_pose(
        &self,
        low: &MotionClip,
        arms: &MotionClip,
        joints: Vec<String>,
        seconds: Option<f64>,
    ) -> Result<MotionClip, LanguageError> {
        let hold = seconds.unwrap_or_else(|| still_seconds(low)).max(still_seconds(arms));
        let ahead = reached(low) - reached(arms);
        let options = Compose { joints, offset: ahead.max(0.0), length: Length::Return, fade: 0.35 };
        Ok(compose(&held(low, hold + (-ahead).max(0.0)), &held(arms, hold), &options)?)
    }

    /// Keeps a pose of arms until the legs below are done. They are there before a body on the spot goes down.
    fn kept(
        &self,
        arms: MotionClip,
        legs: &str,
        clip: MotionClip,
        seconds: Option<f64>,
    ) -> Result<(MotionClip, MotionClip), LanguageError> {
        let below = self.grammar().verb(legs)?;
        let on_the_spot = matches!(below.acts, Acts::Body | Acts::Foot) && seconds.is_none();
        let clip = match on_the_spot {
            true => {
                let frames = (ARMS_UP * clip.fps).round() as usize;
                repeated(&repeated(&clip, clip.len() - 1, frames), 0, frames)
            }
            false => clip,
        };
        let spare = (clip.seconds() - 0.1 - arms.seconds()).max(0.0);
        let arms = match stillest(&arms) {
            Some(at) => repeated(&arms, at, (spare * arms.fps) as usize),
            None => arms,
        };
        Ok((arms, clip))
    }

    /// Returns an action as it is to be made. `emphasis`: the factor by which what was said is exaggerated.
    fn part_of(&self, action: &Action, emphasis: f64, rng: &mut impl Rng) -> Result<PartDraw, LanguageError> {
        let missing =
            || LanguageError::Grammar(format!("expected a verb that this robot can do, got '{}'", action.verb));
        let number = self.number(&action.verb).ok_or_else(missing)?;
        if self.nominal(number).is_none() {
            return Err(missing());
        }
        let verb = &self.grammar().verbs[number];
        let mirrored = is_mirrored(verb, action);
        let usual = verb.cycles.map_or(0, |[fewest, most]| (fewest + 1).min(most));
        let cycles = match (action.count, verb.count) {
            (Some(n), Some(rule)) => n.saturating_sub(rule.extra) / rule.per_cycle.max(1),
            (Some(n), None) => n,
            (None, _) => usual,
        };
        let degrees = match verb.synth {
            Some(Synth::Turn) => action.degrees.map_or(QUARTER, f64::from),
            Some(Synth::Curve) => action.degrees.map_or_else(|| rng.random_range(60.0..100.0), f64::from),
            _ => 0.0,
        };
        let [as_fast, as_large] = action.mood.map(Mood::manner).map_or([1.0; 2], |manner| [manner.speed, manner.size]);
        let speed = match action.speed {
            Some(Speed::Slow) => rng.random_range(0.62..0.74) / emphasis,
            // A spin is faster than a walk.
            Some(Speed::Fast) if verb.synth == Some(Synth::Turn) => rng.random_range(1.75..1.9) * emphasis,
            Some(Speed::Fast) => rng.random_range(1.35..1.5) * emphasis,
            None => as_fast * rng.random_range(0.9..1.1),
        };
        let gain = match action.size {
            // Feet that hardly move shuffle in physics.
            Some(Size::Small) if verb.acts == Acts::Feet => rng.random_range(0.64..0.74) / emphasis,
            Some(Size::Small) if verb.is_free_gesture() => rng.random_range(0.4..0.5) / emphasis,
            Some(Size::Small) => rng.random_range(0.5..0.65) / emphasis,
            Some(Size::Big) => rng.random_range(1.32..1.45) * emphasis,
            // Steps of fear are still steps.
            None if verb.acts == Acts::Feet => as_large.max(SHORTEST) * rng.random_range(0.9..1.1),
            None => as_large * rng.random_range(0.9..1.1),
        };
        let carriage = Carriage::default();
        let part = PartDraw { verb: number, mirrored, cycles, degrees, speed, gain, action: action.clone(), carriage };
        match action.degrees.filter(|_| verb.bends) {
            Some(degrees) => self.bent_by(part, f64::from(degrees)),
            None => Ok(part),
        }
    }

    /// Changes the size of a bend until the trunk reaches an angle (degrees).
    fn bent_by(&self, mut part: PartDraw, degrees: f64) -> Result<PartDraw, LanguageError> {
        part.gain = 1.0;
        for _ in 0..BENDS {
            let tracks = Tracks::of(&self.part(&part, None)?, self.character(), self.anatomy())?;
            part.gain = (part.gain * degrees / measure::bent(&tracks).max(1.0)).clamp(BEND[0], BEND[1]);
        }
        Ok(part)
    }

    /// Cuts most of the standing before and after.
    pub(super) fn shortened(&self, clip: MotionClip) -> Result<MotionClip, LanguageError> {
        let spare = clip.seconds() - 1.2;
        if spare < 0.4 { Ok(clip) } else { Ok(trim(&clip, Some(0.2), Some(clip.seconds() - 0.1))?) }
    }
}

/// Returns whether an action is the mirror image of its verb's clip.
fn is_mirrored(verb: &Verb, action: &Action) -> bool {
    let sides = matches!((verb.side, action.side), (Some(a @ (Side::Left | Side::Right)), Some(b)) if a != b);
    let is_way = |way: Option<Direction>| matches!(way, Some(Direction::Left | Direction::Right));
    sides || (is_way(verb.direction) && is_way(action.direction) && verb.direction != action.direction)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use lifelike_motion::retarget::RetargetOptions;

    use super::*;
    use crate::fixtures;
    use crate::grammar::Grammar;
    use crate::script::Reader;

    #[test]
    fn what_is_counted_and_measured_is_exact() {
        let (lima, anatomy) = fixtures::lima();
        let grammar = Grammar::builtin().unwrap();
        let generator = Generator::new(&grammar, &lima, &anatomy, RetargetOptions::default()).unwrap();
        let reader = Reader::new(&grammar).unwrap();
        for text in [
            "walk four steps forward",
            "take three steps back",
            "squat twice",
            "nod 4 times",
            "wave six times with the left hand",
            "turn 45 degrees to the left",
            "turn right by 135 degrees",
            "turn around 180 degrees",
            "clap 5 times",
            "walk forward while waving with the right hand",
            "walk backward slowly",
            "nod and clap at the same time",
            "salute while taking four steps back",
            "wave with the left hand while standing on one leg",
            "raise both arms widely",
            "scratch your head and rub your belly at the same time",
            "one hand on the hip, the other waving",
            "bow with your hand on your heart",
            "wave angrily",
            "clap happily",
            "walk fearfully",
            "walk 1 m forward",
            "walk 1.4 m forward while waving with the left hand",
            "walk 1.5 metres backward",
            "sidestep 60 cm to the left",
            "nod tiredly",
            "take two steps to the left",
            "walk diagonally to the right",
            "put your hand on your hip",
            "put your hands behind your head",
            "hold your left arm out to the side at 45 degrees",
            "raise both arms 120 degrees",
            "raise your right arm to shoulder height",
            "stretch both arms out ahead at 60 degrees",
            "bow 50 degrees",
            "lean forward 20 degrees",
            "squat deeply",
            "squat a little",
            "gallop six steps",
        ] {
            let script = reader.read(text);
            for seed in 0..2 {
                let made = generator.perform(&script.clauses[0], seed, 0).unwrap();
                let wrong: Vec<_> = made.findings.iter().filter(|f| !f.passed).collect();
                assert!(wrong.is_empty(), "{text}: {wrong:?}");
                for degrees in made.findings.iter().filter(|f| f.fact == Fact::Degrees) {
                    let [wanted, got] =
                        [&degrees.expected, &degrees.got].map(|t| t.split(' ').next().unwrap().parse::<f64>().unwrap());
                    let error = if text.contains("arm") { 12.0 } else { 5.0 };
                    assert!((wanted - got).abs() <= error, "{text}: {got}");
                }
            }
        }
        // Steps that are counted are as long as the way asks for; what legs cannot make is named.
        for (metres, is_far) in [(0.25, true), (0.7, true), (6.0, false)] {
            let aside = Action { count: Some(4), metres: Some(metres), ..Action::of("walk_sideways") };
            let made = generator.perform(&Clause::new(vec![aside]), 1, 0).unwrap();
            let facts: Vec<_> = made.findings.iter().map(|f| (f.fact, f.passed)).collect();
            assert!(
                facts.contains(&(Fact::Count, true)) && facts.contains(&(Fact::Distance, is_far)),
                "{metres}: {facts:?}"
            );
        }
        let lengths = [
            // So are the first and the last moment of a walk.
            ("walk for four seconds", 4.0, 7.0),
            ("march in place for 7 seconds", 7.0, 11.0),
            ("stand still for 5 seconds", 4.5, 5.5),
            // The way up and down is beside what lasts.
            ("wave for 6 s", 6.0, 9.5),
            ("stand on one leg for 4 s", 5.0, 10.0),
        ];
        for (text, least, most) in lengths {
            let clause = &reader.read(text).clauses[0];
            let made = generator.perform(clause, 1, 0).unwrap();
            let lasting = generator.lasting(&made.clip, clause).unwrap().unwrap();
            assert!(lasting.passed, "{text}: {lasting:?}");
            assert!((least..=most).contains(&made.clip.seconds()), "{text}: {}", made.clip.seconds());
        }
    }

    /// As often as is said, and once more: every verb that is counted.
    #[test]
    fn every_verb_is_done_as_often_as_is_said() {
        let (lima, anatomy) = fixtures::lima();
        let grammar = Grammar::builtin().unwrap();
        let counted: Vec<&Verb> = grammar.verbs.iter().filter(|verb| verb.count.is_some()).collect();
        let names: Vec<&str> = counted.iter().map(|verb| verb.name.as_str()).collect();
        let generator = Generator::of_verbs(&grammar, &lima, &anatomy, RetargetOptions::default(), &names).unwrap();
        let mut wrong = Vec::new();
        for (verb, rule) in counted.iter().filter_map(|verb| verb.count.map(|rule| (verb, rule))) {
            let fewest = verb.cycles.map_or(1, |[fewest, _]| fewest.max(1));
            for cycles in [fewest, fewest + 1] {
                let count = Some(cycles * rule.per_cycle + rule.extra);
                let action = Action { count, side: verb.side, direction: verb.direction, ..Action::of(&verb.name) };
                let made = generator.perform(&Clause::new(vec![action]), 1, 0).unwrap();
                let finding = made.findings.into_iter().find(|finding| finding.fact == Fact::Count).unwrap();
                if !finding.passed {
                    wrong.push(format!("{} {}: {}", verb.name, finding.expected, finding.got));
                }
            }
        }
        assert!(wrong.is_empty(), "{wrong:#?}");
    }

    #[test]
    fn hands_touch_what_their_verbs_say() {
        // Its arms are too short for both shoulders, and for the toes it would sit down on its heels.
        const OUT_OF_REACH: [&str; 3] = ["touch_shoulder", "touch_shoulders", "touch_toes"];
        let (lima, anatomy) = fixtures::lima();
        let grammar = Grammar::builtin().unwrap();
        let touching: Vec<&Verb> = grammar.verbs.iter().filter(|verb| verb.touches.is_some()).collect();
        let names: Vec<&str> = touching.iter().map(|verb| verb.name.as_str()).collect();
        let generator = Generator::of_verbs(&grammar, &lima, &anatomy, RetargetOptions::default(), &names).unwrap();
        for verb in touching {
            let action = Action { side: verb.side, ..Action::of(&verb.name) };
            let clause = Clause::new(vec![action]);
            let made = generator.perform(&clause, 1, 0).unwrap();
            let touch = made.findings.iter().find(|finding| finding.fact == Fact::Touch).unwrap();
            assert_eq!(touch.passed, !OUT_OF_REACH.contains(&verb.name.as_str()), "{}: {}", verb.name, touch.got);
        }
    }
}
