//! The text of a keyframed clip, checked number by number.

use std::ops::Range;
use std::path::Path;

use serde::Deserialize;
use toml::Spanned;

use super::feet::{self, Place, Step};
use super::{balance, flight};
use crate::error::MotionError;

/// No clip is longer (s), has a higher rate, more poses or more steps: so a small text cannot ask for a huge motion.
const LONGEST: f64 = 600.0;
const MOST_STEPS: usize = 2000;

/// One number that changes over time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(usize)]
pub(super) enum Channel {
    PelvisX,
    PelvisY,
    PelvisZ,
    PelvisPitch,
    PelvisRoll,
    PelvisYaw,
    ChestPitch,
    ChestRoll,
    ChestYaw,
    HeadPitch,
    HeadRoll,
    HeadYaw,
    LeftRaise,
    LeftAside,
    LeftTurn,
    LeftElbow,
    LeftTwist,
    RightRaise,
    RightAside,
    RightTurn,
    RightElbow,
    RightTwist,
    LeftHeel,
    RightHeel,
}

impl Channel {
    pub(super) const COUNT: usize = Self::RightHeel as usize + 1;
    /// Raise, aside, turn, elbow, twist of both arms.
    pub(super) const ARMS: [[Self; 5]; 2] = [
        [Self::LeftRaise, Self::LeftAside, Self::LeftTurn, Self::LeftElbow, Self::LeftTwist],
        [Self::RightRaise, Self::RightAside, Self::RightTurn, Self::RightElbow, Self::RightTwist],
    ];

    pub(super) fn is_length(self) -> bool {
        matches!(self, Self::PelvisX | Self::PelvisY | Self::PelvisZ)
    }

    /// Returns the value in standing (degrees or m).
    fn standing(at: usize) -> f64 {
        let is = |channels: [Self; 2]| channels.iter().any(|c| *c as usize == at);
        if is([Self::LeftAside, Self::RightAside]) {
            8.0
        } else if is([Self::LeftElbow, Self::RightElbow]) {
            15.0
        } else {
            0.0
        }
    }
}

/// A checked script.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Script {
    pub about: String,
    pub seconds: f64,
    pub fps: f64,
    pub cyclic: bool,
    /// Degrees of shoulder per metre by which the other foot is ahead.
    pub arm_swing: f64,
    /// Gravity in the figure's metres (m/s^2).
    pub gravity: f64,
    /// Time (s) and value (degrees or m) per channel; at least one each, times rising.
    pub keys: [Vec<(f64, f64)>; Channel::COUNT],
    /// In order of time; two at once only in a flight.
    pub steps: Vec<Step>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ScriptText {
    #[serde(default)]
    about: String,
    seconds: Spanned<f64>,
    #[serde(default)]
    fps: Option<Spanned<f64>>,
    #[serde(default)]
    cyclic: bool,
    #[serde(default)]
    arm_swing: Option<Spanned<f64>>,
    #[serde(default)]
    gravity: Option<Spanned<f64>>,
    #[serde(default)]
    pose: Vec<PoseText>,
    #[serde(default)]
    step: Vec<StepText>,
    #[serde(default)]
    gait: Vec<GaitText>,
    #[serde(default)]
    jump: Vec<JumpText>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct PoseText {
    time: Spanned<f64>,
    #[serde(default)]
    pelvis: PelvisText,
    #[serde(default)]
    chest: TurnText,
    #[serde(default)]
    head: TurnText,
    #[serde(default)]
    arms: ArmText,
    #[serde(default)]
    left_arm: ArmText,
    #[serde(default)]
    right_arm: ArmText,
    #[serde(default)]
    feet: FootText,
    #[serde(default)]
    left_foot: FootText,
    #[serde(default)]
    right_foot: FootText,
}

type Number = Option<Spanned<f64>>;

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields, default)]
struct PelvisText {
    x: Number,
    y: Number,
    z: Number,
    pitch: Number,
    roll: Number,
    yaw: Number,
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields, default)]
struct TurnText {
    pitch: Number,
    roll: Number,
    yaw: Number,
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields, default)]
struct ArmText {
    raise: Number,
    aside: Number,
    turn: Number,
    elbow: Number,
    twist: Number,
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields, default)]
struct FootText {
    heel: Number,
}

impl ArmText {
    fn numbers(&self) -> [&Number; 5] {
        [&self.raise, &self.aside, &self.turn, &self.elbow, &self.twist]
    }
}

#[derive(Deserialize, Clone, Copy)]
#[serde(rename_all = "lowercase")]
enum Side {
    Left,
    Right,
}

impl Side {
    fn index(self) -> usize {
        match self {
            Self::Left => feet::LEFT,
            Self::Right => 1 - feet::LEFT,
        }
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct StepText {
    foot: Side,
    start: Spanned<f64>,
    end: Spanned<f64>,
    to: Spanned<[f64; 2]>,
    #[serde(default)]
    yaw: Number,
    #[serde(default)]
    height: Number,
    #[serde(default)]
    via: Vec<ViaText>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ViaText {
    time: Spanned<f64>,
    to: Spanned<[f64; 2]>,
    height: Spanned<f64>,
}

/// Feet that jump; both where none is named.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct JumpText {
    #[serde(default)]
    foot: Option<Side>,
    start: Spanned<f64>,
    height: Spanned<f64>,
    #[serde(default)]
    by: Option<Spanned<[f64; 2]>>,
    #[serde(default)]
    apart: Number,
    #[serde(default)]
    tuck: Number,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct GaitText {
    foot: Side,
    start: Spanned<f64>,
    steps: Spanned<u32>,
    period: Spanned<f64>,
    swing: Spanned<f64>,
    by: Spanned<[f64; 2]>,
    #[serde(default)]
    height: Number,
    #[serde(default)]
    ahead: Number,
    #[serde(default)]
    aside: Number,
    #[serde(default)]
    out: Number,
    #[serde(default)]
    early: Number,
}

/// Names the line of every complaint.
struct Checker<'a> {
    content: &'a str,
    file: &'a Path,
}

impl Checker<'_> {
    fn error(&self, span: Range<usize>, expected: impl Into<String>, got: impl Into<String>) -> MotionError {
        let before = self.content.get(..span.start).unwrap_or_default();
        MotionError::Parse {
            file: self.file.to_path_buf(),
            line: before.matches('\n').count() + 1,
            expected: expected.into(),
            got: got.into(),
        }
    }

    fn within(
        &self,
        number: &Spanned<f64>,
        range: std::ops::RangeInclusive<f64>,
        what: &str,
    ) -> Result<f64, MotionError> {
        let value = *number.get_ref();
        if range.contains(&value) {
            return Ok(value);
        }
        let expected = format!("{what} from {} to {}", range.start(), range.end());
        Err(self.error(number.span(), expected, value.to_string()))
    }

    fn optional(
        &self,
        number: &Number,
        range: std::ops::RangeInclusive<f64>,
        what: &str,
        default: f64,
    ) -> Result<f64, MotionError> {
        number.as_ref().map_or(Ok(default), |n| self.within(n, range, what))
    }

    fn place(&self, place: &Spanned<[f64; 2]>) -> Result<[f64; 2], MotionError> {
        let value = *place.get_ref();
        if value.iter().all(|v| v.abs() <= 100.0) {
            return Ok(value);
        }
        Err(self.error(place.span(), "a place within 100 m", format!("{value:?}")))
    }
}

impl Script {
    /// Reads and checks a text. `file` is for messages only.
    pub(super) fn parse(content: &str, file: &Path) -> Result<Self, MotionError> {
        let check = Checker { content, file };
        let text: ScriptText = toml::from_str(content).map_err(|e| {
            let message = e.message().trim().replace('\n', "; ");
            check.error(e.span().unwrap_or(0..0), "a keyframed clip", message)
        })?;
        let seconds = check.within(&text.seconds, 0.1..=LONGEST, "a length in seconds")?;
        let mut steps = Vec::new();
        for step in &text.step {
            steps.push(single(&check, step, seconds)?);
        }
        for gait in &text.gait {
            row(&check, gait, seconds, &mut steps)?;
        }
        let gravity = check.optional(&text.gravity, 1.0..=100.0, "metres per second squared", balance::GRAVITY)?;
        let mut jumps: Vec<&JumpText> = text.jump.iter().collect();
        jumps.sort_by(|a, b| a.start.get_ref().total_cmp(b.start.get_ref()));
        for jump in jumps {
            leap(&check, jump, (seconds, gravity), &mut steps)?;
        }
        if let (true, Some((_, span))) = (text.cyclic, steps.first()) {
            return Err(check.error(span.clone(), "no steps in a cyclic clip", "a step"));
        }
        Ok(Self {
            about: text.about,
            seconds,
            fps: check.optional(&text.fps, 10.0..=240.0, "frames per second", 60.0)?,
            cyclic: text.cyclic,
            arm_swing: check.optional(&text.arm_swing, -200.0..=200.0, "degrees per metre", 0.0)?,
            gravity,
            keys: keys(&check, &text.pose, seconds, text.cyclic)?,
            steps: in_order(&check, steps)?,
        })
    }
}

/// Returns the keys of all channels, with standing where the first or last pose says nothing.
fn keys(
    check: &Checker<'_>,
    poses: &[PoseText],
    seconds: f64,
    cyclic: bool,
) -> Result<[Vec<(f64, f64)>; Channel::COUNT], MotionError> {
    let mut keys: [Vec<(f64, f64)>; Channel::COUNT] = std::array::from_fn(|_| Vec::new());
    let mut before = -1.0;
    for pose in poses {
        let time = check.within(&pose.time, 0.0..=seconds, "a time within the clip")?;
        if time <= before {
            return Err(check.error(pose.time.span(), format!("a time after {before}"), time.to_string()));
        }
        if cyclic && time >= seconds {
            let expected = "a time before the end of the cycle, where the first pose stands again";
            return Err(check.error(pose.time.span(), expected, time.to_string()));
        }
        before = time;
        let mut said: Vec<(usize, &Number)> = Vec::new();
        let p = &pose.pelvis;
        let body = [&p.x, &p.y, &p.z, &p.pitch, &p.roll, &p.yaw];
        let turns = [&pose.chest, &pose.head].map(|t| [&t.pitch, &t.roll, &t.yaw]);
        said.extend(body.into_iter().chain(turns.into_iter().flatten()).enumerate());
        for (side, own) in [&pose.left_arm, &pose.right_arm].into_iter().enumerate() {
            for (at, channel) in Channel::ARMS[side].into_iter().enumerate() {
                let (own, both) = (own.numbers()[at], pose.arms.numbers()[at]);
                said.push((channel as usize, if own.is_some() { own } else { both }));
            }
        }
        for (channel, own) in [(Channel::LeftHeel, &pose.left_foot), (Channel::RightHeel, &pose.right_foot)] {
            said.push((channel as usize, if own.heel.is_some() { &own.heel } else { &pose.feet.heel }));
        }
        for (channel, number) in said {
            let Some(number) = number else { continue };
            let is_length = channel < Channel::PelvisPitch as usize;
            let value = if is_length {
                check.within(number, -1.0..=1.0, "metres")?
            } else {
                check.within(number, -360.0..=360.0, "degrees")?
            };
            keys[channel].push((time, value));
        }
    }
    for (channel, keys) in keys.iter_mut().enumerate() {
        let standing = Channel::standing(channel);
        if keys.is_empty() || (!cyclic && keys[0].0 > 0.0) {
            keys.insert(0, (0.0, standing));
        }
        if !cyclic && keys.len() > 1 && keys.last().is_some_and(|last| last.0 < seconds) {
            keys.push((seconds, standing));
        }
    }
    Ok(keys)
}

fn single(check: &Checker<'_>, step: &StepText, seconds: f64) -> Result<(Step, Range<usize>), MotionError> {
    let start = check.within(&step.start, 0.0..=seconds, "a time within the clip")?;
    let end = check.within(&step.end, start + 0.05..=seconds, "a time at least 0.05 s after the start")?;
    let foot = step.foot.index();
    let [x, y] = check.place(&step.to)?;
    let yaw = check.optional(&step.yaw, -360.0..=360.0, "degrees", 0.0)?.to_radians();
    let home = Place::standing(foot);
    let to = Place { x: home.x + x, y: home.y + y, yaw };
    let height = check.optional(&step.height, 0.0..=0.5, "metres", 0.05)?;
    let mut via: Vec<[f64; 4]> = Vec::new();
    for place in &step.via {
        let after = via.last().map_or(start, |before| before[0]);
        let time = check.within(&place.time, after + 0.02..=end - 0.02, "a time within the step, in order")?;
        let [x, y] = check.place(&place.to)?;
        let height = check.within(&place.height, 0.0..=0.8, "metres")?;
        via.push([time, home.x + x, home.y + y, height]);
    }
    Ok((Step { foot, start, end, to, height, via, flies: false }, step.start.span()))
}

/// Returns the steps of a gait, and the one that closes up.
fn row(
    check: &Checker<'_>,
    gait: &GaitText,
    seconds: f64,
    steps: &mut Vec<(Step, Range<usize>)>,
) -> Result<(), MotionError> {
    let start = check.within(&gait.start, 0.0..=seconds, "a time within the clip")?;
    let period = check.within(&gait.period, 0.1..=10.0, "seconds")?;
    // Longer than the period: a run, whose feet are both in the air in between.
    let swing = check.within(&gait.swing, 0.05..=1.8 * period, "seconds, no more than 1.8 periods")?;
    let height = check.optional(&gait.height, 0.0..=0.5, "metres", 0.05)?;
    let by = check.place(&gait.by)?;
    let [ahead, aside, out] =
        [&gait.ahead, &gait.aside, &gait.out].map(|n| check.optional(n, -0.5..=0.5, "metres", 0.0));
    let (ahead, aside, out) = (ahead?, aside?, out?);
    let early =
        check.optional(&gait.early, 0.0..=(period - swing).max(0.0), "seconds, no more than both feet stand", 0.0)?;
    let count = *gait.steps.get_ref();
    let closing = by != [0.0, 0.0];
    let end = start + period * f64::from(count - count.min(1)) + if closing { period } else { 0.0 } + swing;
    if count == 0 || count as usize > MOST_STEPS || end > seconds {
        let expected = format!("1 to {MOST_STEPS} steps that end within the clip's {seconds} s");
        return Err(check.error(gait.steps.span(), expected, format!("{count} steps until {end:.2} s")));
    }
    let first = gait.foot.index();
    let last = count + u32::from(closing);
    for at in 0..last {
        let foot = if at % 2 == 0 { first } else { 1 - first };
        let home = Place::standing(foot);
        // A foot's last step brings it back to its own line.
        let place = |at: u32| {
            let far = f64::from((at + 1).min(count));
            let side = if at + 2 < last { home.y.signum() * out } else { 0.0 };
            Place { x: home.x + far * by[0], y: home.y + far * by[1] + side, yaw: 0.0 }
        };
        let (from, to) = (at.checked_sub(2).map_or(home, place), place(at));
        let start = start + period * f64::from(at) - if at % 2 == 1 { early } else { 0.0 };
        let via = if ahead == 0.0 && aside == 0.0 {
            Vec::new()
        } else {
            let (x, y) = (0.5 * (from.x + to.x) + ahead, 0.5 * (from.y + to.y) + home.y.signum() * aside);
            vec![[start + 0.5 * swing, x, y, height]]
        };
        let flies = swing > period + 1e-9;
        steps.push((Step { foot, start, end: start + swing, to, height, via, flies }, gait.start.span()));
    }
    Ok(())
}

/// Returns the steps of a jump, which go on from where the feet stand then.
fn leap(
    check: &Checker<'_>,
    jump: &JumpText,
    (seconds, gravity): (f64, f64),
    steps: &mut Vec<(Step, Range<usize>)>,
) -> Result<(), MotionError> {
    let start = check.within(&jump.start, 0.0..=seconds, "a time within the clip")?;
    let height = check.within(&jump.height, 0.005..=0.5, "metres")?;
    let end = start + flight::seconds(height, gravity);
    if end > seconds {
        return Err(check.error(jump.start.span(), "a jump that ends within the clip", format!("{end:.2} s")));
    }
    let [x, y] = jump.by.as_ref().map_or(Ok([0.0, 0.0]), |by| check.place(by))?;
    let apart = check.optional(&jump.apart, -1.0..=1.0, "metres", 0.0)?;
    let tuck = check.optional(&jump.tuck, 0.0..=0.5, "metres", 0.05)?;
    let is_up = |foot: usize| steps.iter().any(|(s, _)| s.foot == foot && s.start < start + 1e-4 && s.end > end - 1e-4);
    if jump.foot.is_some_and(|side| !is_up(1 - side.index())) {
        let expected = format!("a step that has the other foot up from {start:.2} to {end:.2} s");
        return Err(check.error(jump.start.span(), expected, "none"));
    }
    steps.sort_by(|a, b| a.0.start.total_cmp(&b.0.start));
    let before: Vec<Step> = steps.iter().map(|(step, _)| step.clone()).collect();
    for foot in (0..2).filter(|foot| jump.foot.is_none_or(|side| side.index() == *foot)) {
        let from = feet::standing_place(&before, foot, start);
        let out = if foot == feet::LEFT { apart } else { -apart };
        let to = Place { x: from.x + x, y: from.y + y + out, ..from };
        steps.push((Step { foot, start, end, to, height: tuck, via: Vec::new(), flies: true }, jump.start.span()));
    }
    Ok(())
}

/// Sorts by time, and checks that one foot is always on the ground, but for flights.
fn in_order(check: &Checker<'_>, mut steps: Vec<(Step, Range<usize>)>) -> Result<Vec<Step>, MotionError> {
    steps.sort_by(|a, b| a.0.start.total_cmp(&b.0.start));
    for (at, (after, span)) in steps.iter().enumerate() {
        let meets = |before: &&(Step, Range<usize>)| {
            let in_flight = before.0.foot != after.foot && (before.0.flies || after.flies);
            after.start < before.0.end && !in_flight
        };
        if let Some((before, _)) = steps[..at].iter().find(meets) {
            let expected = format!("a step that starts after the one before has ended ({:.2} s)", before.end);
            return Err(check.error(span.clone(), expected, format!("one at {:.2} s", after.start)));
        }
    }
    Ok(steps.into_iter().map(|(step, _)| step).collect())
}
