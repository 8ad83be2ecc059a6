//! A keyframed text as numbers that can be changed: repeated, faster, larger, in another mood, with other steps.

use std::collections::BTreeMap;
use std::fmt::Write;

use serde::Deserialize;

use crate::error::LanguageError;

/// Half of the distance between the feet of the keyframed figure (m).
const HALF_STANCE: f64 = 0.09;

/// Largest angle of an arm that hangs (degrees).
const HANGS: f64 = 32.0;
/// Largest lift of an arm that is made larger (degrees).
const OVERHEAD: f64 = 165.0;
/// Angle from which an arm is lifted (degrees).
const LIFTED: f64 = 40.0;

/// The standing pose: what is not keyed.
fn standing(axis: &str) -> f64 {
    match axis {
        "aside" => 8.0,
        "elbow" => 15.0,
        _ => 0.0,
    }
}

/// A step of one foot.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct Step {
    foot: String,
    start: f64,
    end: f64,
    to: [f64; 2],
    #[serde(default)]
    yaw: f64,
    #[serde(default = "default_height")]
    height: f64,
    #[serde(default)]
    via: Vec<Via>,
}

/// A place on a foot's way through the air.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct Via {
    time: f64,
    to: [f64; 2],
    height: f64,
}

impl Via {
    fn later(&self, by: f64) -> Self {
        Self { time: self.time + by, ..self.clone() }
    }
}

/// A jump of both feet, or of the one that is named.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct Jump {
    foot: Option<String>,
    start: f64,
    height: f64,
    #[serde(default)]
    by: [f64; 2],
    #[serde(default)]
    apart: f64,
    #[serde(default = "default_height")]
    tuck: f64,
}

fn default_height() -> f64 {
    0.05
}

/// A row of steps.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct Gait {
    foot: String,
    start: f64,
    steps: i64,
    period: f64,
    swing: f64,
    by: [f64; 2],
    #[serde(default = "default_height")]
    height: f64,
    #[serde(default)]
    ahead: f64,
    #[serde(default)]
    aside: f64,
    #[serde(default)]
    out: f64,
    #[serde(default)]
    early: f64,
}

/// A stretch of time that repeats: poses after `from` up to `from + period` are the pattern, of which the text has
/// `count`.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Cycle {
    /// Start of the first (s).
    pub from: f64,
    /// Duration of one (s).
    pub period: f64,
    /// Number of them in the text.
    pub count: u32,
}

/// Poses and steps of a keyframed clip; angles in degrees as in the text.
#[derive(Debug, Clone, PartialEq)]
pub struct Score {
    /// Duration (s).
    pub seconds: f64,
    cyclic: bool,
    arm_swing: f64,
    /// Keys of every channel (part, axis), in the order of time.
    keys: BTreeMap<(String, String), Vec<(f64, f64)>>,
    steps: Vec<Step>,
    gaits: Vec<Gait>,
    jumps: Vec<Jump>,
    gravity: f64,
}

#[derive(Deserialize)]
struct Text {
    seconds: f64,
    #[serde(default)]
    cyclic: bool,
    #[serde(default)]
    arm_swing: f64,
    #[serde(default)]
    pose: Vec<BTreeMap<String, toml::Value>>,
    #[serde(default)]
    step: Vec<Step>,
    #[serde(default)]
    gait: Vec<Gait>,
    #[serde(default)]
    jump: Vec<Jump>,
    #[serde(default = "on_earth")]
    gravity: f64,
}

fn on_earth() -> f64 {
    9.81
}

fn number(value: &toml::Value) -> Option<f64> {
    value.as_float().or_else(|| value.as_integer().map(|v| v as f64))
}

impl Score {
    /// Reads a keyframed text (see [`lifelike_motion::keyframes`]).
    ///
    /// # Errors
    /// [`LanguageError::Grammar`] for a text that is none.
    pub fn parse(name: &str, content: &str) -> Result<Self, LanguageError> {
        let bad = |message: String| LanguageError::Grammar(format!("clip '{name}': {message}"));
        let text: Text = toml::from_str(content).map_err(|e| bad(e.to_string()))?;
        let mut keys: BTreeMap<(String, String), Vec<(f64, f64)>> = BTreeMap::new();
        for pose in &text.pose {
            let time = pose.get("time").and_then(number).ok_or_else(|| bad("a pose has no time".into()))?;
            for (part, axes) in pose.iter().filter(|(part, _)| *part != "time") {
                let axes = axes.as_table().ok_or_else(|| bad(format!("'{part}' at {time} s is no table")))?;
                for (axis, value) in axes {
                    let value = number(value).ok_or_else(|| bad(format!("'{part}.{axis}' is no number")))?;
                    let parts = match part.as_str() {
                        "arms" => vec!["left_arm", "right_arm"],
                        "feet" => vec!["left_foot", "right_foot"],
                        part => vec![part],
                    };
                    for part in parts {
                        keys.entry((part.into(), axis.clone())).or_default().push((time, value));
                    }
                }
            }
        }
        keys.values_mut().for_each(|keys| keys.sort_by(|a, b| a.0.total_cmp(&b.0)));
        let Text { seconds, cyclic, arm_swing, step, gait, jump, gravity, .. } = text;
        Ok(Self { seconds, cyclic, arm_swing, keys, steps: step, gaits: gait, jumps: jump, gravity })
    }

    /// Returns a text in which nothing moves for so long (s).
    pub fn empty(seconds: f64) -> Self {
        let (keys, gravity) = (BTreeMap::new(), on_earth());
        Self { seconds, cyclic: false, arm_swing: 0.0, keys, steps: vec![], gaits: vec![], jumps: vec![], gravity }
    }

    /// Adds a key after the others of its channel.
    pub fn key(&mut self, part: &str, axis: &str, time: f64, value: f64) {
        self.keys.entry((part.into(), axis.into())).or_default().push((time, value));
    }

    /// Adds a step.
    pub fn step(&mut self, step: &Step) {
        self.steps.push(step.clone());
    }

    /// Sets the gravity of flights (m/s^2, in the figure's metres): that of a robot of another size.
    pub fn fall(&mut self, gravity: f64) {
        self.gravity = gravity;
    }

    /// Repeats a cycle `times` instead of as often as the text does; gaits that walk through it take more or fewer
    /// steps. Steps and jumps inside of it are done again, from where the feet are by then.
    pub fn repeat(&mut self, cycle: &Cycle, times: u32) {
        let &Cycle { from, period, count } = cycle;
        let longer = (f64::from(times) - f64::from(count)) * period;
        let end = from + f64::from(count) * period;
        for keys in self.keys.values_mut() {
            let before = keys.iter().copied().filter(|k| k.0 <= from);
            let pattern: Vec<_> = keys.iter().copied().filter(|k| k.0 > from && k.0 <= from + period + 1e-9).collect();
            let again = (0..times).flat_map(|i| pattern.iter().map(move |k| (k.0 + f64::from(i) * period, k.1)));
            let after = keys.iter().copied().filter(|k| k.0 > end + 1e-9).map(|k| (k.0 + longer, k.1));
            *keys = before.chain(again).chain(after).collect();
        }
        for gait in &mut self.gaits {
            gait.steps += (longer / gait.period).round() as i64;
        }
        let way = ["left", "right"].map(|foot| {
            let (a, b) = (self.place(foot, from), self.place(foot, from + period));
            [b[0] - a[0], b[1] - a[1]]
        });
        let again = f64::from(times) - f64::from(count);
        let in_cycle = |time: f64| time > from && time <= from + period + 1e-9;
        // A foot that is up all the time stays up for longer, and goes on its way in the air again.
        for step in self.steps.iter_mut().filter(|step| step.start < from - 1e-9 && step.end > end - 1e-9) {
            // As far on as the foot that hops meanwhile.
            let hops = way[usize::from(step.foot != "right")].map(|v| v * again);
            let on = |to: [f64; 2]| [to[0] + hops[0], to[1] + hops[1]];
            (step.end, step.to) = (step.end + longer, on(step.to));
            let pattern: Vec<Via> = step.via.iter().filter(|via| in_cycle(via.time)).cloned().collect();
            step.via.retain(|via| via.time <= from || via.time > end + 1e-9);
            for via in step.via.iter_mut().filter(|via| via.time > end + 1e-9) {
                (via.time, via.to) = (via.time + longer, on(via.to));
            }
            let again = (0..times).flat_map(|k| pattern.iter().map(move |via| via.later(f64::from(k) * period)));
            step.via.extend(again);
            step.via.sort_by(|a, b| a.time.total_cmp(&b.time));
        }
        let way_of = |foot: &str| way[usize::from(foot == "right")];
        let again = again_of(from, period, end, times);
        let steps = self.steps.iter().flat_map(|step| again(step.start).into_iter().map(move |k| (k, step)));
        self.steps = steps.map(|(k, step)| step.later(k * period, way_of(&step.foot).map(|v| v * k))).collect();
        let jumps = self.jumps.iter().flat_map(|jump| again(jump.start).into_iter().map(move |k| (k, jump)));
        self.jumps = jumps.map(|(k, jump)| Jump { start: jump.start + k * period, ..jump.clone() }).collect();
        self.seconds += longer;
    }

    /// Returns where a foot stands, from where it stood first (m), after the steps and jumps that begin before a time.
    fn place(&self, foot: &str, time: f64) -> [f64; 2] {
        let steps = self.steps.iter().filter(|s| s.foot == foot && s.start < time - 1e-9);
        let last = steps.max_by(|a, b| a.start.total_cmp(&b.start));
        let (from, mut place) = last.map_or((f64::NEG_INFINITY, [0.0, 0.0]), |step| (step.start, step.to));
        let out = if foot == "left" { 1.0 } else { -1.0 };
        let by_foot = |jump: &&Jump| jump.foot.as_ref().is_none_or(|named| named == foot);
        for jump in self.jumps.iter().filter(by_foot).filter(|j| j.start > from && j.start < time - 1e-9) {
            place = [place[0] + jump.by[0], place[1] + jump.by[1] + out * jump.apart];
        }
        place
    }

    /// Makes everything faster by this factor.
    pub fn faster(&mut self, times: f64) {
        self.keys.values_mut().flatten().for_each(|key| key.0 /= times);
        for step in &mut self.steps {
            step.start /= times;
            step.end /= times;
            step.via.iter_mut().for_each(|via| via.time /= times);
        }
        // A flight lasts as long as gravity says.
        self.jumps.iter_mut().for_each(|jump| jump.start /= times);
        for gait in &mut self.gaits {
            gait.start /= times;
            gait.period /= times;
            gait.swing /= times;
            gait.early /= times;
        }
        self.seconds /= times;
    }

    /// Enlarges movements: of every channel around its standing value, or, inside of a cycle, around the cycle's mean.
    pub fn larger(&mut self, gain: f64, cycle: Option<&Cycle>) {
        for ((_, axis), keys) in &mut self.keys {
            let inside = |time: f64| {
                cycle.is_none_or(|c| time > c.from && time <= c.from + f64::from(c.count) * c.period + 1e-9)
            };
            let within: Vec<f64> = keys.iter().filter(|k| inside(k.0)).map(|k| k.1).collect();
            let rest = standing(axis);
            // What a cycle brings back to standing, such as the pelvis in a squat, stands at its end in every size.
            let returns = within.last().is_some_and(|last| (last - rest).abs() < 1e-6);
            let centre = match cycle {
                Some(_) if !returns => within.iter().sum::<f64>() / within.len().max(1) as f64,
                _ => rest,
            };
            for key in keys.iter_mut().filter(|k| inside(k.0)) {
                let larger = centre + gain * (key.1 - centre);
                // An arm that is up already goes no farther.
                key.1 = if axis == "raise" { larger.min(key.1.max(OVERHEAD)) } else { larger };
            }
        }
    }

    /// Lowers the pelvis so that its lowest key is at a depth (m).
    pub fn deeper(&mut self, depth: f64) {
        let Some(keys) = self.keys.get_mut(&("pelvis".to_string(), "z".to_string())) else { return };
        let lowest = keys.iter().map(|key| key.1).fold(0.0, f64::min);
        if lowest < 0.0 && lowest > -depth {
            keys.iter_mut().for_each(|key| key.1 *= -depth / lowest);
        }
    }

    /// Scales the length of the steps of every gait and step.
    pub fn longer_steps(&mut self, gain: f64) {
        for gait in &mut self.gaits {
            gait.by = gait.by.map(|v| v * gain);
        }
        for step in &mut self.steps {
            step.to = step.to.map(|v| v * gain);
            step.via.iter_mut().for_each(|via| via.to = via.to.map(|v| v * gain));
        }
        for jump in &mut self.jumps {
            jump.by = jump.by.map(|v| v * gain);
        }
    }

    /// Scales the height of every jump of both feet, and how far they are drawn up.
    pub fn higher_jumps(&mut self, gain: f64) {
        for jump in self.jumps.iter_mut().filter(|jump| jump.foot.is_none()) {
            jump.height *= gain;
            jump.tuck *= gain;
        }
    }

    /// Lifts a foot that acts on the spot farther: the height and the way of its steps.
    pub fn higher_steps(&mut self, gain: f64) {
        for step in &mut self.steps {
            step.height *= gain;
            step.to = step.to.map(|v| v * gain);
            step.via.iter_mut().for_each(|via| (via.height, via.to) = (via.height * gain, via.to.map(|v| v * gain)));
        }
    }

    /// Scales all deviations from standing of one part of the body.
    pub fn scale_part(&mut self, part: &str, gain: f64) {
        for ((_, axis), keys) in self.keys.iter_mut().filter(|((of, _), _)| of == part) {
            let rest = standing(axis);
            keys.iter_mut().for_each(|key| key.1 = rest + gain * (key.1 - rest));
        }
    }

    /// Scales how far an arm is lifted, ahead and aside.
    pub fn lift_part(&mut self, arm: &str, gain: f64) {
        let lifts = |axis: &str| axis == "raise" || axis == "aside";
        for ((_, axis), keys) in self.keys.iter_mut().filter(|((part, axis), _)| part == arm && lifts(axis)) {
            let rest = standing(axis);
            keys.iter_mut().for_each(|key| key.1 = rest + gain * (key.1 - rest));
        }
    }

    /// Lifts the arms of a pose to an angle (degrees from hanging down): the axis that lifts them most is scaled.
    pub fn lift_arms(&mut self, degrees: f64) {
        for arm in ["left_arm", "right_arm"] {
            let most = |axis: &str| {
                let keys = self.keys.get(&(arm.to_string(), axis.to_string()));
                keys.into_iter().flatten().map(|key| key.1).fold(0.0, f64::max)
            };
            let (raise, aside) = (most("raise"), most("aside"));
            let (axis, most) = if raise >= aside { ("raise", raise) } else { ("aside", aside) };
            // An arm that only keeps the balance stays.
            if most < LIFTED {
                continue;
            }
            let rest = standing(axis);
            let gain = (degrees - rest) / (most - rest);
            for key in self.keys.get_mut(&(arm.to_string(), axis.to_string())).into_iter().flatten() {
                key.1 = rest + gain * (key.1 - rest);
            }
        }
    }

    /// Adds an angle to a channel between the clip's first and last second, going over within half of one.
    pub fn offset(&mut self, part: &str, axis: &str, by: f64) {
        let (start, end) = (0.9_f64.min(0.25 * self.seconds), self.seconds - 0.9_f64.min(0.25 * self.seconds));
        let keys = self.keys.entry((part.into(), axis.into())).or_default();
        let at = |keys: &[(f64, f64)], t: f64| {
            let next = keys.iter().position(|k| k.0 >= t);
            match (next, keys.last()) {
                (_, None) => standing(axis),
                (Some(0), _) => standing(axis) + (keys[0].1 - standing(axis)) * t / keys[0].0.max(1e-6),
                (Some(i), _) => {
                    let (a, b) = (keys[i - 1], keys[i]);
                    a.1 + (b.1 - a.1) * (t - a.0) / (b.0 - a.0).max(1e-6)
                }
                (None, Some(last)) => last.1,
            }
        };
        let ends = [start, end].map(|t| (t, at(keys, t) + by));
        keys.iter_mut().filter(|k| k.0 > start && k.0 < end).for_each(|k| k.1 += by);
        keys.retain(|k| ends.iter().all(|e| (k.0 - e.0).abs() > 0.15));
        keys.extend(ends);
        let rest = standing(axis);
        for edge in [0.3 * start, self.seconds - 0.3 * start] {
            if keys.iter().all(|k| (k.0 - edge).abs() > 0.15) {
                keys.push((edge, rest));
            }
        }
        keys.sort_by(|a, b| a.0.total_cmp(&b.0));
    }

    /// Returns whether nothing moves a channel.
    pub fn leaves(&self, part: &str, axis: &str) -> bool {
        !self.keys.contains_key(&(part.to_string(), axis.to_string()))
    }

    /// Returns whether an arm hangs, or moves no farther than for balance.
    pub fn hangs(&self, arm: &str) -> bool {
        let keys = self.keys.iter().filter(|((part, _), _)| part == arm);
        let far = |axis: &str, value: f64| (value - standing(axis)).abs() > HANGS;
        keys.into_iter().all(|((_, axis), keys)| keys.iter().all(|key| !far(axis, key.1)))
    }

    /// Turns the head to one side and the other (degrees), again and again, each for so long (s).
    pub fn glance(&mut self, degrees: f64, each: f64) {
        let times = ((self.seconds - 1.0) / each).floor().max(1.0) as u32;
        self.key("head", "yaw", 0.3, 0.0);
        for number in 0..times {
            let side = if number.is_multiple_of(2) { degrees } else { -degrees };
            self.key("head", "yaw", 0.3 + each * (f64::from(number) + 0.5), side);
        }
        self.key("head", "yaw", self.seconds - 0.1, 0.0);
    }

    /// Shifts everything after `time` by `by` seconds.
    fn shift_after(&mut self, time: f64, by: f64) {
        self.keys.values_mut().flatten().filter(|k| k.0 >= time).for_each(|k| k.0 += by);
        self.seconds += by;
    }

    /// Replaces the steps by a turn on the spot: pairs of steps of equal angle, no more than 45 degrees each.
    pub fn turn(&mut self, degrees: f64) {
        let (start, pair, each, base_pairs) = (1.1, 1.3, 0.5, 2.0);
        let pairs = (degrees.abs() / 45.0 - 1e-6).ceil().max(1.0);
        self.shift_after(3.0, (pairs - base_pairs) * pair);
        let first = if degrees > 0.0 { ["left", "right"] } else { ["right", "left"] };
        self.steps = (0..pairs as usize)
            .flat_map(|i| {
                let angle = degrees * (i + 1) as f64 / pairs;
                first.iter().enumerate().map(move |(j, foot)| {
                    let begin = start + i as f64 * pair + j as f64 * 0.5 * pair;
                    arc_step(foot, begin, each, 0.0, angle)
                })
            })
            .collect();
    }

    /// Replaces the steps by a walk along an arc to the left: radius (m), and the whole angle (degrees).
    pub fn curve(&mut self, radius: f64, degrees: f64) {
        let (start, period, swing, base) = (1.2, 0.54, 0.42, 11.0);
        let count = (degrees / (9.0 * 1.3 / radius)).round().max(2.0);
        self.shift_after(6.5, (count + 1.0 - base) * period);
        let foot = |i: usize| if i.is_multiple_of(2) { "right" } else { "left" };
        self.steps = (0..=count as usize)
            .map(|i| {
                let angle = degrees * ((i + 1) as f64).min(count) / count;
                arc_step(foot(i), start + i as f64 * period, swing, radius, angle)
            })
            .collect();
    }

    /// Replaces the steps by `pairs` of steps, the right foot first and the left one beside it, each so long (m, ahead
    /// and to the right).
    pub fn sideways(&mut self, pairs: u32, [ahead, right]: [f64; 2]) {
        let (start, each, swing, base) = (1.3, 0.56, 0.44, 5.0);
        self.shift_after(6.5, (f64::from(pairs) - base) * 2.0 * each);
        self.steps = (0..2 * pairs as usize)
            .map(|i| {
                let begin = start + i as f64 * each;
                let foot = if i.is_multiple_of(2) { "right" } else { "left" };
                let to = [ahead, -right].map(|by| by * (i / 2 + 1) as f64);
                Step {
                    foot: foot.into(),
                    start: begin,
                    end: begin + swing,
                    to,
                    yaw: 0.0,
                    height: 0.05,
                    via: Vec::new(),
                }
            })
            .collect();
    }

    /// Returns the keyframed text.
    pub fn to_text(&self) -> String {
        let mut poses: BTreeMap<i64, BTreeMap<&str, BTreeMap<&str, f64>>> = BTreeMap::new();
        for ((part, axis), keys) in &self.keys {
            for (time, value) in keys {
                // Times to a tenth of a millisecond: equal times are one pose again.
                let at = (time.clamp(0.0, self.seconds) * 1e4).round() as i64;
                poses.entry(at).or_default().entry(part).or_default().insert(axis, *value);
            }
        }
        let mut out = format!("seconds = {:.4}\ncyclic = {}\n", self.seconds, self.cyclic);
        let _ = writeln!(out, "arm_swing = {:.3}\ngravity = {:.4}", self.arm_swing, self.gravity);
        for (time, parts) in &poses {
            // Writing to a string cannot fail.
            let _ = write!(out, "[[pose]]\ntime = {:.4}\n", (*time as f64) * 1e-4);
            for (part, axes) in parts {
                let axes: Vec<String> = axes.iter().map(|(axis, value)| format!("{axis} = {value:.5}")).collect();
                let _ = writeln!(out, "{part} = {{ {} }}", axes.join(", "));
            }
        }
        for s in &self.steps {
            let _ = write!(out, "[[step]]\nfoot = \"{}\"\nstart = {:.4}\nend = {:.4}\n", s.foot, s.start, s.end);
            let _ =
                write!(out, "to = [{:.5}, {:.5}]\nyaw = {:.4}\nheight = {:.4}\n", s.to[0], s.to[1], s.yaw, s.height);
            let via = |v: &Via| {
                let Via { time, to: [x, y], height } = v;
                format!("{{ time = {time:.4}, to = [{x:.5}, {y:.5}], height = {height:.4} }}")
            };
            let _ = writeln!(out, "via = [{}]", s.via.iter().map(via).collect::<Vec<_>>().join(", "));
        }
        for j in &self.jumps {
            let _ = write!(out, "[[jump]]\nstart = {:.4}\nheight = {:.5}\ntuck = {:.5}\n", j.start, j.height, j.tuck);
            let _ = write!(out, "by = [{:.5}, {:.5}]\napart = {:.5}\n", j.by[0], j.by[1], j.apart);
            if let Some(foot) = &j.foot {
                let _ = writeln!(out, "foot = \"{foot}\"");
            }
        }
        for g in &self.gaits {
            let _ = write!(out, "[[gait]]\nfoot = \"{}\"\nstart = {:.4}\nsteps = {}\n", g.foot, g.start, g.steps);
            // No flight by a rounding error.
            let swing = if g.swing > 1.001 * g.period { g.swing } else { g.swing.min(g.period) };
            let _ = write!(out, "period = {:.5}\nswing = {:.5}\n", g.period, swing);
            let _ = write!(out, "by = [{:.5}, {:.5}]\nheight = {:.4}\n", g.by[0], g.by[1], g.height);
            let _ = write!(out, "ahead = {:.4}\naside = {:.4}\nout = {:.4}\n", g.ahead, g.aside, g.out);
            let _ = writeln!(out, "early = {:.4}", (g.early - 1e-4).clamp(0.0, (g.period - swing - 2e-4).max(0.0)));
        }
        out
    }
}

impl Step {
    /// Returns a step of the left (0) or the right foot (1) that has not come down yet.
    pub fn new(foot: usize, start: f64, height: f64) -> Self {
        let foot = if foot == 0 { "left" } else { "right" };
        Self { foot: foot.into(), start, end: f64::INFINITY, to: [0.0; 2], yaw: 0.0, height, via: Vec::new() }
    }

    /// Returns when the foot leaves the ground (s).
    pub fn begin(&self) -> f64 {
        self.start
    }

    /// Goes through a place in the air.
    pub fn via(&mut self, time: f64, to: [f64; 2], height: f64) {
        self.via.push(Via { time, to, height });
    }

    /// Comes down.
    pub fn land(&mut self, end: f64, to: [f64; 2]) {
        (self.end, self.to) = (end, to);
    }

    /// Returns the step later (s), and farther (m).
    fn later(&self, by: f64, [x, y]: [f64; 2]) -> Self {
        let moved = |to: [f64; 2]| [to[0] + x, to[1] + y];
        let via = self.via.iter().map(|via| Via { to: moved(via.to), ..via.later(by) });
        Self {
            start: self.start + by,
            end: self.end + by,
            to: moved(self.to),
            via: via.collect(),
            foot: self.foot.clone(),
            ..*self
        }
    }
}

/// Returns how many periods later something is done that begins at a time, when the cycles from `from` to `end` are done
/// `times` times: what is before the cycle once as it is, of the cycle the first repetition again and again.
fn again_of(from: f64, period: f64, end: f64, times: u32) -> impl Fn(f64) -> Vec<f64> + Copy {
    let count = ((end - from) / period).round();
    move |start: f64| match () {
        () if start < from - 1e-9 => vec![0.0],
        () if start < from + period - 1e-9 => (0..times).map(f64::from).collect(),
        () if start < end - 1e-9 => Vec::new(),
        () => vec![f64::from(times) - count],
    }
}

/// Returns a step onto an arc to the left around `[0, radius]`, at an angle (degrees) from the start.
fn arc_step(foot: &str, start: f64, swing: f64, radius: f64, degrees: f64) -> Step {
    let offset = if foot == "left" { HALF_STANCE } else { -HALF_STANCE };
    let (sin, cos) = degrees.to_radians().sin_cos();
    let own = radius - offset;
    let to = [own * sin, radius - own * cos - offset];
    Step { foot: foot.into(), start, end: start + swing, to, yaw: degrees, height: 0.05, via: Vec::new() }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn a_larger_cycle_still_stands_at_its_end_and_arms_stop_overhead() {
        let text = "seconds = 4.0\n[[pose]]\ntime = 1.0\npelvis = { z = -0.2 }\nleft_arm = { raise = 150 }\n\
                    [[pose]]\ntime = 3.0\npelvis = { z = 0 }\nleft_arm = { raise = 100 }";
        let mut score = Score::parse("x", text).unwrap();
        score.larger(1.5, Some(&Cycle { from: 0.5, period: 3.0, count: 1 }));
        let keys_of = |part: &str, axis: &str| score.keys[&(part.to_string(), axis.to_string())].clone();
        let depths: Vec<f64> = keys_of("pelvis", "z").iter().map(|key| (100.0 * key.1).round()).collect();
        assert_eq!(depths, [-30.0, 0.0]);
        let lifts: Vec<f64> = keys_of("left_arm", "raise").iter().map(|key| key.1).collect();
        assert_eq!(lifts, [162.5, 87.5], "around the mean of a cycle that does not return");
        let mut score = Score::parse("x", text).unwrap();
        score.larger(1.5, None);
        assert_eq!(score.keys[&("left_arm".to_string(), "raise".to_string())][0].1, OVERHEAD);
    }

    #[test]
    fn steps_and_jumps_of_a_cycle_are_done_again_from_where_the_feet_are() {
        let text = "seconds = 9.0\n[[jump]]\nstart = 1.2\nheight = 0.05\nby = [0.1, 0.0]\n\
                    [[step]]\nfoot = \"left\"\nstart = 1.5\nend = 1.9\nto = [0.4, 0.0]\n\
                    via = [{ time = 1.7, to = [0.2, 0.0], height = 0.2 }]\n\
                    [[step]]\nfoot = \"left\"\nstart = 7.0\nend = 7.4\nto = [0.5, 0.0]";
        let mut score = Score::parse("x", text).unwrap();
        score.repeat(&Cycle { from: 1.0, period: 2.0, count: 1 }, 3);
        let starts: Vec<f64> = score.jumps.iter().map(|jump| jump.start).collect();
        assert_eq!(starts, [1.2, 3.2, 5.2]);
        let places: Vec<f64> = score.steps.iter().map(|step| (10.0 * step.to[0]).round() / 10.0).collect();
        assert_eq!(places, [0.4, 0.8, 1.2, 1.3], "each 0.4 m on; what is after it as far from the end");
        assert!((score.steps[1].via[0].time - 3.7).abs() < 1e-12 && (score.steps[3].start - 11.0).abs() < 1e-12);
        assert_eq!(Score::parse("x", &score.to_text()).unwrap().jumps.len(), 3);
    }
}
