//! Postures as motion of a robot.

use std::path::Path;

use lifelike_motion::edit::{Compose, Length, compose, joints_of, trim};
use lifelike_motion::retarget::retarget;
use lifelike_motion::{MotionClip, keyframes};

use super::generator::{GRAVITY, Generator};
use super::perform::ARMS_UP;
use super::score::{Score, Step};
use super::spans::repeated;
use super::table::Acts;
use crate::checks::{Fact, Finding, Tracks};
use crate::error::LanguageError;
use crate::facts::{Action, Mood, Side};
use crate::posture::{Arm, Foot, Posture, Turn};
use crate::touch::LEG;

/// Time before the first movement and after the last (s).
const BEFORE: f64 = 0.3;
const AFTER: f64 = 0.5;
/// Time that every way takes, and more of it for each degree (s).
const WAY: f64 = 0.55;
const PER_DEGREE: f64 = 0.0045;
/// Time in which the weight goes to the other foot, and in which a foot swings (s).
const SHIFT: f64 = 1.1;
const SWING: f64 = 0.8;
/// Spread of free arms on one foot (degrees).
const BALANCE: f64 = 38.0;
/// Depth of the pelvis on one foot (m, of the keyframed figure).
const BENT_KNEE: f64 = 0.02;
/// Trunk angles from which a motion is measured and made again (degrees), and the gains of that.
const MEASURED: f64 = 8.0;
const GAINS: [f64; 2] = [0.6, 2.4];
/// Time of the ways of arms to a posture and back (s).
const BOTH_WAYS: f64 = 2.2;
/// Shares of the trunk's rotation that chest and pelvis do.
const CHEST: f64 = 0.7;
const PELVIS: f64 = 0.4;
/// Depth of a pelvis that rolls, for each radian (m, of the keyframed figure): one leg has farther to go.
const LOWER: f64 = 0.16;
/// Time in which the pelvis is lowered before steps, and raised after them (s).
const LOWERED: f64 = 0.3;
/// Height of a step on the ground (m, of the keyframed figure).
const STEP: f64 = 0.09;
/// Lift from which an arm is not lifted farther for a trunk that leans (degrees).
const OVERHEAD: f64 = 165.0;
/// Shortest way that may be asked for (s).
const SHORTEST: f64 = 0.2;
/// Factor of the time of what is done slowly.
const SLOW: f64 = 2.4;
/// Bend of knees that is added until legs reach, at once and at most (m, of the keyframed figure).
const DEEPER: f64 = 0.03;
const DEEPEST: f64 = 0.18;
/// Largest error of an arm's angle (degrees).
const ANGLE: f64 = 20.0;
/// Most by which an arm is lifted for a body that tilts (degrees).
const LEVEL: f64 = 40.0;
/// Elbow from which an arm's angle is not measured at its hand (degrees).
const BENT: f64 = 40.0;
/// Share of a foot's height that must be reached.
const HEIGHT: f64 = 0.4;

/// Times of a posture (s): arrival, and end of the hold.
#[derive(Debug, Clone, Copy)]
struct Times {
    arrive: f64,
    leave: f64,
}

/// A figure that holds a posture.
#[derive(Debug, Clone, Copy)]
struct Figure {
    arms: [Arm; 2],
    /// True for arms whose hand touches the body: their angles are seen from the trunk, others' from the vertical.
    touches: [bool; 2],
    head: Turn,
    trunk: Turn,
    feet: [Foot; 2],
    sink: f64,
}

impl Figure {
    const STANDING: Self = Self {
        arms: [Arm::HANGING; 2],
        touches: [false; 2],
        head: Turn { pitch: 0.0, roll: 0.0, yaw: 0.0 },
        trunk: Turn { pitch: 0.0, roll: 0.0, yaw: 0.0 },
        feet: [Foot::STANDING; 2],
        sink: 0.0,
    };

    /// Returns the figure as it is written: free arms keep the balance on one foot.
    fn balanced(&self) -> Self {
        let mut out = *self;
        let hangs = self.arms.map(|arm| arm == Arm::HANGING);
        for (arm, _) in out.arms.iter_mut().zip(self.touches).filter(|(_, touches)| !*touches) {
            arm.raise = (arm.raise + self.trunk.pitch.max(0.0)).min(OVERHEAD.max(arm.raise));
        }
        if self.feet.iter().any(|foot| foot.height > 0.0) {
            out.sink = self.sink.max(BENT_KNEE);
            for (arm, _) in out.arms.iter_mut().zip(hangs).filter(|(_, hangs)| *hangs) {
                arm.aside = BALANCE;
            }
        }
        out
    }

    /// Returns the figure after a posture. A foot that rises puts the other one down.
    fn after(&self, posture: &Posture) -> Self {
        let [left, right] = [posture.left_foot, posture.right_foot].map(|foot| foot.is_some_and(|f| f.height > 0.0));
        let stays = |foot: Foot| if foot.height > 0.0 { Foot::STANDING } else { foot };
        let moved = [posture.left_arm.is_some(), posture.right_arm.is_some()];
        let touch = [posture.left_touches.or(posture.touches).is_some(), posture.touches.is_some()];
        Self {
            touches: [0, 1].map(|side| if moved[side] { touch[side] } else { self.touches[side] }),
            arms: [posture.left_arm.unwrap_or(self.arms[0]), posture.right_arm.unwrap_or(self.arms[1])],
            head: posture.head.unwrap_or(self.head),
            trunk: posture.trunk.unwrap_or(self.trunk),
            feet: [
                posture.left_foot.unwrap_or(if right { stays(self.feet[0]) } else { self.feet[0] }),
                posture.right_foot.unwrap_or(if left { stays(self.feet[1]) } else { self.feet[1] }),
            ],
            sink: posture.sink.unwrap_or(self.sink),
        }
    }

    /// Returns the time of the way to another figure (s), without that of the feet.
    fn way(&self, other: &Self) -> f64 {
        let arm = |a: &Arm, b: &Arm| {
            [a.raise - b.raise, a.aside - b.aside, a.turn - b.turn, a.elbow - b.elbow]
                .map(f64::abs)
                .into_iter()
                .fold(0.0, f64::max)
        };
        let turn = |a: &Turn, b: &Turn| {
            2.0 * [a.pitch - b.pitch, a.roll - b.roll, a.yaw - b.yaw].map(f64::abs).into_iter().fold(0.0, f64::max)
        };
        let arms = arm(&self.arms[0], &other.arms[0]).max(arm(&self.arms[1], &other.arms[1]));
        let turned = turn(&self.head, &other.head).max(turn(&self.trunk, &other.trunk));
        WAY + PER_DEGREE * arms.max(turned)
    }
}

/// Writes a text of keyframes: the figure at times, and its steps.
struct Writer {
    figures: Vec<(f64, Figure)>,
    steps: Vec<Step>,
    times: Vec<Times>,
    end: f64,
}

/// Lays postures out in time; the last is followed by standing.
fn laid_out(postures: &[Posture]) -> Writer {
    let mut now = BEFORE;
    let mut figure = Figure::STANDING;
    let mut out = Writer { figures: vec![(now, figure)], steps: Vec::new(), times: Vec::new(), end: 0.0 };
    let mut open: [Option<Step>; 2] = [const { None }; 2];
    let last = Posture {
        left_foot: Some(Foot::STANDING),
        right_foot: Some(Foot::STANDING),
        left_arm: Some(Arm::HANGING),
        right_arm: Some(Arm::HANGING),
        head: Some(Turn::default()),
        trunk: Some(Turn::default()),
        sink: Some(0.0),
        ..Posture::default()
    };
    for posture in postures.iter().chain([&last]) {
        let next = figure.after(posture);
        let start = now;
        let usual = figure.way(&next) * if posture.slow { SLOW } else { 1.0 };
        let mut arrive = start + posture.way.map_or(usual, |way| way.max(SHORTEST));
        // First the foot that comes down, then the one that rises.
        let mut from = start;
        for foot in [0, 1] {
            let (old, new) = (figure.feet[foot], next.feet[foot]);
            if new.height > 0.0 || old == new {
                continue;
            }
            let mut step = open[foot].take().unwrap_or_else(|| Step::new(foot, from + 0.5 * SHIFT, STEP));
            let end = step.begin().max(from) + SWING;
            step.land(end, new.to);
            out.steps.push(step);
            from = end + 0.3 * SHIFT;
            arrive = arrive.max(end);
        }
        for foot in [0, 1].into_iter().filter(|foot| next.feet[*foot].height > 0.0) {
            let new = next.feet[foot];
            let is_new = open[foot].is_none();
            let step = open[foot].get_or_insert_with(|| Step::new(foot, from + SHIFT, STEP));
            if is_new {
                arrive = arrive.max(step.begin() + SWING);
            }
            step.via(arrive, new.to, new.height);
            step.via(arrive + posture.hold.max(0.1), new.to, new.height);
        }
        // Feet that go far on the ground need bent knees from their first step to their last.
        let steps = |foot: usize| figure.feet[foot] != next.feet[foot] && next.feet[foot].height == 0.0;
        let mut settled = arrive;
        if steps(0) || steps(1) {
            let low = Figure { sink: figure.sink.max(next.sink), ..figure };
            out.figures.push((start + LOWERED, low.balanced()));
            out.figures.push((arrive, Figure { sink: low.sink, ..next }.balanced()));
            settled = arrive + LOWERED;
        }
        let leave = settled + posture.hold.max(0.1);
        figure = next;
        out.figures.extend([(settled, figure.balanced()), (leave, figure.balanced())]);
        out.times.push(Times { arrive, leave });
        now = leave;
    }
    out.times.pop();
    out.end = now + AFTER;
    out
}

/// Returns a posture with the knees bent farther (m, of the keyframed figure) where it moves a foot away or leans, or bends them
/// already.
fn lowered(posture: &Posture, by: f64) -> Posture {
    let feet = [posture.left_foot, posture.right_foot];
    let leans = posture.trunk.is_some_and(|turn| turn.pitch.abs() >= MEASURED);
    let is_away = leans || feet.iter().flatten().any(|foot| *foot != Foot::STANDING);
    let returns = !is_away && (posture.trunk.is_some() || feet.iter().any(Option::is_some));
    let sink = match posture.sink {
        _ if by == 0.0 => posture.sink,
        None if returns => Some(0.0),
        None if !is_away => None,
        sink => Some(sink.unwrap_or(0.0) + by),
    };
    Posture { sink, ..posture.clone() }
}

/// An arm of a posture as it was made: angles from hanging down (degrees).
struct Lifted {
    posture: usize,
    side: usize,
    arm: Arm,
    wanted: f64,
    got: f64,
}

/// Returns the frame in the middle of each posture's hold.
fn held_at(tracks: &Tracks, postures: &[Posture]) -> Vec<usize> {
    let last = tracks.len().saturating_sub(1);
    let frame = |times: &Times| ((0.5 * (times.arrive + times.leave) * tracks.fps).round() as usize).min(last);
    laid_out(postures).times.iter().map(frame).collect()
}

/// Measures the arms that postures move: straight ones whose hand touches nothing.
fn lifted(tracks: &Tracks, postures: &[Posture]) -> Vec<Lifted> {
    let mut out = Vec::new();
    for (number, (posture, frame)) in postures.iter().zip(held_at(tracks, postures)).enumerate() {
        for (side, arm) in [posture.left_arm, posture.right_arm].into_iter().enumerate() {
            let Some(arm) = arm.filter(|arm| arm.elbow < BENT && posture.touches.is_none()) else { continue };
            let ends = tracks.hands[side].get(frame).zip(tracks.shoulders[side].get(frame));
            let Some(way) = ends.map(|(hand, shoulder)| hand - shoulder) else { continue };
            let got = way.x.hypot(way.y).atan2(-way.z).to_degrees();
            out.push(Lifted { posture: number, side, arm, wanted: arm.elevation(), got });
        }
    }
    out
}

/// Returns postures of the arms alone.
fn arms_of(postures: &[Posture]) -> Vec<Posture> {
    let arms = |posture: &Posture| Posture { head: None, trunk: None, sink: None, ..posture.clone() };
    postures.iter().map(arms).collect()
}

/// Returns the name of the arms that postures move, for what composes motion; nothing where they move none.
fn limbs_of(postures: &[Posture]) -> &'static str {
    let moved = |arm: fn(&Posture) -> Option<Arm>| postures.iter().any(|posture| arm(posture).is_some());
    match (moved(|posture| posture.left_arm), moved(|posture| posture.right_arm)) {
        (true, true) => "arms",
        (true, false) => "left_arm",
        (false, true) => "right_arm",
        (false, false) => "",
    }
}

impl Writer {
    /// Returns the keyframed text.
    fn score(&self) -> Score {
        let mut score = Score::empty(self.end);
        for (time, figure) in &self.figures {
            for (name, arm) in ["left_arm", "right_arm"].into_iter().zip(&figure.arms) {
                for (axis, value) in
                    [("raise", arm.raise), ("aside", arm.aside), ("turn", arm.turn), ("elbow", arm.elbow)]
                {
                    score.key(name, axis, *time, value);
                }
            }
            for (name, turn, share) in
                [("head", figure.head, 1.0), ("chest", figure.trunk, CHEST), ("pelvis", figure.trunk, PELVIS)]
            {
                for (axis, value) in [("pitch", turn.pitch), ("roll", turn.roll), ("yaw", turn.yaw)] {
                    score.key(name, axis, *time, share * value);
                }
            }
            let tilted = LOWER * (PELVIS * figure.trunk.roll).to_radians().abs();
            score.key("pelvis", "z", *time, -figure.sink - tilted);
        }
        self.steps.iter().for_each(|step| score.step(step));
        score
    }
}

impl Generator<'_> {
    /// Makes the motion of postures. A body on one foot tilts: arms that are held out to a side are measured then, and made
    /// again with the angle that they lack.
    pub(super) fn postured(&self, postures: &[Posture], mood: Option<Mood>) -> Result<MotionClip, LanguageError> {
        let (mut postures, clip) = self.leaning(postures, mood)?;
        let is_up = |foot: Option<Foot>| foot.is_some_and(|foot| foot.height > 0.0);
        if !postures.iter().any(|posture| is_up(posture.left_foot) || is_up(posture.right_foot)) {
            return Ok(clip);
        }
        let tracks = Tracks::of(&clip, self.character(), self.anatomy())?;
        for Lifted { posture, side, arm, wanted, got } in lifted(&tracks, &postures) {
            let level = Arm { aside: arm.aside + (wanted - got).clamp(-LEVEL, LEVEL), ..arm };
            let posture = &mut postures[posture];
            let limb = if side == 0 { &mut posture.left_arm } else { &mut posture.right_arm };
            *limb = limb.map(|arm| if arm.aside > arm.raise.abs() { level } else { arm });
        }
        Ok(self.within_reach(&postures, mood).map_or(clip, |(_, level)| level))
    }

    /// Makes the motion of postures. A trunk that leans is measured, and made again with the angle that it lacks.
    fn leaning(&self, postures: &[Posture], mood: Option<Mood>) -> Result<(Vec<Posture>, MotionClip), LanguageError> {
        let (postures, clip) = self.within_reach(postures, mood)?;
        let most = |angle: fn(&Turn) -> f64| {
            let angles = postures.iter().filter_map(|posture| posture.trunk.as_ref()).map(|turn| angle(turn).abs());
            angles.fold(0.0, f64::max)
        };
        let (pitch, roll) = (most(|turn| turn.pitch), most(|turn| turn.roll));
        if pitch.max(roll) < MEASURED {
            return Ok((postures, clip));
        }
        let tracks = Tracks::of(&clip, self.character(), self.anatomy())?;
        let reached = |values: &[f64]| values.iter().map(|angle| angle.to_degrees().abs()).fold(0.0, f64::max);
        let gain = |wanted: f64, values: &[f64]| match wanted < MEASURED || values.is_empty() {
            true => 1.0,
            false => (wanted / reached(values).max(1.0)).clamp(GAINS[0], GAINS[1]),
        };
        let (pitch, roll) = (gain(pitch, &tracks.chest), gain(roll, &tracks.chest_lean));
        let scaled = |turn: Turn| Turn { pitch: pitch * turn.pitch, roll: roll * turn.roll, ..turn };
        let again: Vec<Posture> =
            postures.iter().map(|posture| Posture { trunk: posture.trunk.map(scaled), ..posture.clone() }).collect();
        // More than the legs can carry stays as it was.
        Ok(self.within_reach(&again, mood).unwrap_or((postures, clip)))
    }

    /// Makes the motion of postures, with knees bent as far as it takes for legs to reach where feet are put.
    fn within_reach(
        &self,
        postures: &[Posture],
        mood: Option<Mood>,
    ) -> Result<(Vec<Posture>, MotionClip), LanguageError> {
        let leans = |posture: &Posture| posture.trunk.is_some_and(|turn| turn.pitch.abs() >= MEASURED);
        let moves_foot = |posture: &Posture| !posture.is_empty() && !posture.leaves_feet();
        let may_bend = postures.iter().any(|posture| leans(posture) || moves_foot(posture));
        let mut deeper = 0.0;
        loop {
            let lower: Vec<Posture> = postures.iter().map(|posture| lowered(posture, deeper)).collect();
            match self.keyframed(&lower, mood) {
                Err(LanguageError::Motion(_)) if may_bend && deeper < DEEPEST => deeper += DEEPER,
                made => return made.map(|clip| (lower, clip)),
            }
        }
    }

    /// Makes the motion of postures as they are written.
    fn keyframed(&self, postures: &[Posture], mood: Option<Mood>) -> Result<MotionClip, LanguageError> {
        let mut score = laid_out(postures).score();
        if let Some(manner) = mood.map(Mood::manner) {
            score.offset("chest", "pitch", manner.chest);
            score.offset("head", "pitch", manner.head);
            score.faster(manner.speed);
        }
        score.fall(GRAVITY * self.smaller());
        let source = keyframes::parse(score.to_text().as_bytes(), Path::new("posture.keys.toml"))?;
        let (mut clip, _) = retarget(&source, self.character(), self.anatomy(), self.options())?;
        for posture in postures {
            let (Some(touch), Some(touching)) = (posture.touches, self.touching()) else { continue };
            let side = match (posture.left_arm, posture.right_arm) {
                (Some(_), None) => Side::Left,
                (None, Some(_)) => Side::Right,
                // Of arms that differ, the bent one touches.
                (Some(left), Some(right)) if left.elbow > right.elbow + BENT => Side::Left,
                (Some(left), Some(right)) if right.elbow > left.elbow + BENT => Side::Right,
                _ => Side::Both,
            };
            let side = if posture.left_touches.is_some() { Side::Right } else { side };
            let left = posture.left_touches.map(|touch| (touch, Side::Left));
            for hand in [(touch, side)].into_iter().chain(left) {
                clip = touching.reached(&clip, (self.character(), self.anatomy()), hand, self.options())?;
            }
        }
        Ok(clip)
    }

    /// Holds the arms of a posture during a motion; on the spot they are there before it begins.
    pub(super) fn held_during(
        &self,
        postures: &[Posture],
        verb: &str,
        below: MotionClip,
    ) -> Result<MotionClip, LanguageError> {
        if limbs_of(postures).is_empty() {
            return Ok(below);
        }
        if self.low_pose(&Action::of(verb))? {
            let arms = self.postured(&arms_of(postures), None)?;
            let joints = joints_of(self.character(), self.anatomy(), &[limbs_of(postures).into()])?;
            return self.during_hold(&below, &trim(&arms, Some(BEFORE), None)?, joints, None);
        }
        let [posture] = postures else {
            let message = format!("expected one posture during '{verb}', got {}", postures.len());
            return Err(LanguageError::Grammar(message));
        };
        let on_the_spot = matches!(self.grammar().verb(verb)?.acts, Acts::Body | Acts::Foot);
        let frames = if on_the_spot { (ARMS_UP * below.fps).round() as usize } else { 0 };
        let below = repeated(&repeated(&below, below.len() - 1, frames), 0, frames);
        let hold = (below.seconds() - BOTH_WAYS).max(0.1);
        let arms = self.postured(&arms_of(&[Posture { hold, ..posture.clone() }]), None)?;
        let arms = trim(&arms, Some(0.2), Some((below.seconds() + 0.1).min(arms.seconds() - 0.1)))?;
        let joints = joints_of(self.character(), self.anatomy(), &[limbs_of(postures).into()])?;
        Ok(compose(&below, &arms, &Compose { joints, offset: 0.0, length: Length::Return, fade: 0.3 })?)
    }

    /// Checks postures on a clip of them: arms by their angle, feet by their height.
    pub(super) fn findings_of_postures(&self, tracks: &Tracks, postures: &[Posture]) -> Vec<Finding> {
        let mut found = Vec::new();
        let arms = lifted(tracks, postures);
        for (number, (posture, frame)) in postures.iter().zip(held_at(tracks, postures)).enumerate() {
            let mut add = |fact: Fact, expected: String, got: String, passed: bool| {
                found.push(Finding { verb: "posture".into(), fact, expected, got, passed });
            };
            for Lifted { side, wanted, got, .. } in arms.iter().filter(|arm| arm.posture == number) {
                let name = if *side == 0 { "left" } else { "right" };
                add(
                    Fact::Degrees,
                    format!("{name} arm {wanted:.0} +- {ANGLE}"),
                    format!("{got:.0}"),
                    (got - wanted).abs() <= ANGLE,
                );
            }
            for (side, foot) in [posture.left_foot, posture.right_foot].into_iter().enumerate() {
                let Some(foot) = foot.filter(|foot| foot.height > 0.0) else { continue };
                let Some(at) = tracks.feet[side].get(frame) else { continue };
                let ground = tracks.feet[side].iter().map(|p| p.z).fold(f64::INFINITY, f64::min);
                let (got, wanted) = (at.z - ground, HEIGHT * foot.height * tracks.leg / LEG);
                let name = if side == 0 { "left" } else { "right" };
                add(
                    Fact::Shape,
                    format!("{name} foot up by {:.0} cm", 100.0 * wanted),
                    format!("{:.0} cm", 100.0 * got),
                    got >= wanted,
                );
            }
        }
        found
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use lifelike_motion::retarget::RetargetOptions;

    use super::*;
    use crate::fixtures;
    use crate::grammar::Grammar;
    use crate::grammar::spans::rise_of;
    use crate::script::{Clause, Script};
    use crate::touch::Touch;

    fn made(postures: &[Posture]) -> (MotionClip, Tracks, Vec<Finding>) {
        made_of(&Clause::of_postures(postures.to_vec()))
    }

    fn made_of(clause: &Clause) -> (MotionClip, Tracks, Vec<Finding>) {
        let (lima, anatomy) = fixtures::lima();
        let grammar = Grammar::builtin().unwrap();
        let options = RetargetOptions::default();
        let generator = Generator::of_verbs(&grammar, &lima, &anatomy, options, &["stand", "squat", "kneel"]).unwrap();
        let made = generator.perform(clause, 1, 0).unwrap();
        let tracks = Tracks::of(&made.clip, &lima, &anatomy).unwrap();
        (made.clip, tracks, made.findings)
    }

    fn arm(raise: f64, aside: f64) -> Option<Arm> {
        Some(Arm { raise, aside, turn: 0.0, elbow: 6.0 })
    }

    #[test]
    fn arms_go_where_they_are_asked_and_stay() {
        let up = Posture { left_arm: arm(162.0, 8.0), hold: 1.0, ..Posture::default() };
        let both = Posture { right_arm: arm(0.0, 90.0), hold: 1.0, ..Posture::default() };
        let (clip, tracks, findings) = made(&[up, both]);
        assert!(findings.len() == 2 && findings.iter().all(|finding| finding.passed), "{findings:?}");
        // Near the end of the second hold the left hand is still up, and the right one out at the shoulder's height.
        let frame = ((clip.seconds() - AFTER - 1.9) * clip.fps) as usize;
        let way = |side: usize| tracks.hands[side][frame] - tracks.shoulders[side][frame];
        assert!(way(0).z > 0.3 * tracks.leg, "{}", way(0));
        assert!(way(1).y < -0.3 * tracks.leg && way(1).z.abs() < 0.2 * tracks.leg, "{}", way(1));
    }

    #[test]
    fn a_foot_stays_up_and_the_trunk_leans_to_its_angle() {
        let knee =
            Posture { left_foot: Some(Foot { to: [0.06, 0.01], height: 0.38 }), hold: 2.0, ..Posture::default() };
        let (clip, tracks, findings) = made(&[knee]);
        assert!(findings.len() == 1 && findings[0].passed, "{findings:?}");
        let ground = tracks.feet[0][0].z;
        let up = tracks.feet[0].iter().filter(|foot| foot.z - ground > 0.3 * tracks.leg).count();
        assert!(up as f64 / clip.fps > 2.0, "{up}");
        // Feet go far apart and come back.
        let [left, right] = [0.11, -0.11].map(|y| Some(Foot { to: [0.0, y], height: 0.0 }));
        let wide = Posture { left_foot: left, right_foot: right, sink: Some(0.09), hold: 1.0, ..Posture::default() };
        let (_, tracks, _) = made(&[wide]);
        let apart = |frame: usize| (tracks.feet[0][frame] - tracks.feet[1][frame]).norm();
        let widest = (0..tracks.len()).map(apart).fold(0.0, f64::max);
        assert!(widest > 1.6 * apart(0) && apart(tracks.len() - 1) < 1.1 * apart(0), "{widest}");
        // As wide with hardly bent knees: they bend as far as it takes.
        let feet = [0.2, -0.2].map(|y| Some(Foot { to: [0.0, y], height: 0.0 }));
        let stiff =
            Posture { left_foot: feet[0], right_foot: feet[1], sink: Some(0.03), hold: 1.0, ..Posture::default() };
        let (_, far, _) = made(&[stiff]);
        let farthest = (0..far.len()).map(|t| (far.feet[0][t] - far.feet[1][t]).norm()).fold(0.0, f64::max);
        assert!(farthest > widest, "{farthest}, {widest}");
        let lean = Posture { trunk: Some(Turn { pitch: 25.0, ..Turn::default() }), hold: 1.0, ..Posture::default() };
        let (_, tracks, _) = made(&[lean]);
        let most = tracks.chest.iter().fold(0.0_f64, |most, angle| most.max(angle.to_degrees()));
        assert!((most - 25.0).abs() < 8.0, "{most}");
        let aside = Posture { trunk: Some(Turn { roll: 15.0, ..Turn::default() }), hold: 1.0, ..Posture::default() };
        let (_, tracks, _) = made(&[aside]);
        let most = tracks.chest_lean.iter().fold(0.0_f64, |most, angle| most.max(angle.to_degrees()));
        assert!((most - 15.0).abs() < 6.0, "{most}");
    }

    #[test]
    fn arms_are_level_on_one_foot() {
        let foot = Some(Foot { to: [0.0, 0.28], height: 0.09 });
        let sides = Posture {
            left_arm: arm(0.0, 88.0),
            right_arm: arm(0.0, 88.0),
            left_foot: foot,
            hold: 3.0,
            ..Posture::default()
        };
        let (_, _, findings) = made(&[sides]);
        assert!(findings.len() == 3 && findings.iter().all(|finding| finding.passed), "{findings:?}");
    }

    #[test]
    fn a_way_takes_its_time_and_arms_are_seen_from_the_vertical() {
        let lift = |way| Posture { left_arm: arm(120.0, 3.0), way: Some(way), hold: 1.0, ..Posture::default() };
        let rise = |clip: &MotionClip| rise_of(clip).unwrap();
        let [fast, slow] = [0.3, 4.0].map(|way| rise(&made(&[lift(way)]).0));
        assert!(fast < 0.6 && (2.5..4.2).contains(&slow), "{fast}, {slow}");
        // A trunk that leans leaves arms level that are to be level.
        let trunk = Some(Turn { pitch: 30.0, ..Turn::default() });
        let level = Posture { left_arm: arm(90.0, 3.0), trunk, hold: 2.0, ..Posture::default() };
        let (clip, tracks, _) = made(&[level]);
        let frame = (0.55 * clip.seconds() * clip.fps) as usize;
        let way = tracks.hands[0][frame] - tracks.shoulders[0][frame];
        assert!(way.z.abs() < 0.2 * way.x, "{way}");
        assert!(tracks.chest[frame].to_degrees() > 20.0, "{}", tracks.chest[frame].to_degrees());
    }

    #[test]
    fn arms_move_in_a_low_pose_after_it_was_reached() {
        let wide = Posture { left_arm: arm(0.0, 90.0), right_arm: arm(0.0, 90.0), hold: 1.0, ..Posture::default() };
        let ahead = Posture { left_arm: arm(90.0, 3.0), right_arm: arm(90.0, 3.0), hold: 1.0, ..Posture::default() };
        let kneel = Action { side: Some(Side::Right), ..Action::of("kneel") };
        let clause = Clause { postures: vec![wide, ahead], ..Clause::new(vec![kneel]) };
        let (_, tracks, _) = made_of(&clause);
        let is_low = |frame: &usize| tracks.root[*frame].z < tracks.root[0].z - 0.2 * tracks.leg;
        let down: Vec<usize> = (0..tracks.len()).filter(is_low).collect();
        let (first, last) = (down[0], down[down.len() - 1]);
        let out = |frame: usize| (tracks.hands[0][frame] - tracks.shoulders[0][frame]).z > -0.15 * tracks.leg;
        let up: Vec<usize> = (0..tracks.len()).filter(|frame| out(*frame)).collect();
        assert!(up.len() as f64 > 2.0 * tracks.fps, "{}", up.len());
        assert!(up.iter().all(|frame| (first..last).contains(frame)), "{first} to {last}, {up:?}");
        // A verb that does not stay down takes only one posture.
        let script = Script { clauses: vec![clause.clone()], ..Script::default() };
        let grammar = Grammar::builtin().unwrap();
        assert!(script.check(&grammar).is_ok());
        let walk = Clause { actions: vec![Action::of("walk")], ..clause };
        let error = Script { clauses: vec![walk], ..Script::default() }.check(&grammar).unwrap_err();
        assert!(error.contains("one posture that moves no foot"), "{error}");
    }

    #[test]
    fn a_hand_that_cannot_reach_leaves_the_body_where_it_stands() {
        let across = Some(Arm { raise: 62.0, aside: -24.0, turn: 40.0, elbow: 95.0 });
        let shoulder = Posture { right_arm: across, touches: Some(Touch::Shoulder), hold: 2.0, ..Posture::default() };
        let (_, tracks, _) = made(&[shoulder]);
        let moved = tracks.root.iter().map(|at| (at - tracks.root[0]).norm()).fold(0.0, f64::max);
        let turned = tracks.yaw.iter().map(|at| (at - tracks.yaw[0]).abs()).fold(0.0, f64::max);
        assert!(moved < 0.02 * tracks.leg && turned.to_degrees() < 2.0, "{moved}, {turned}");
    }

    #[test]
    fn each_hand_touches_its_own_place() {
        let belly = Some(Arm { raise: 14.0, aside: -14.0, turn: 62.0, elbow: 88.0 });
        let crown = Some(Arm { raise: 180.0, aside: 3.0, turn: 101.0, elbow: 57.0 });
        let mut both = Posture { left_arm: crown, touches: Some(Touch::Crown), hold: 2.0, ..Posture::default() };
        both.extend(&Posture { right_arm: belly, touches: Some(Touch::Belly), ..Posture::default() });
        assert_eq!((both.left_touches, both.touches), (Some(Touch::Crown), Some(Touch::Belly)));
        let (clip, tracks, _) = made(&[both]);
        let frame = ((clip.seconds() - AFTER - 2.5) * clip.fps) as usize;
        let height = |side: usize| (tracks.hands[side][frame].z - tracks.shoulders[side][frame].z) / tracks.leg;
        assert!(height(0) > 0.2 && height(1) < -0.2, "{} {}", height(0), height(1));
    }
}
