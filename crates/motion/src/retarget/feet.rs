//! Targets of the feet: contacts of the human, targets in the character's size, locks while a foot stands.

use lifelike_character::rotation::heading;
use lifelike_character::{Kinematics, Quat, Vec3};

use super::human::Human;
use super::options::RetargetOptions;
use super::rig::Rig;
use crate::contacts::{ContactOptions, clean, free_fall, point_contacts, runs, speeds};

/// Toes and heel of one foot: which of them touch at each frame.
#[derive(Debug, Clone)]
pub(super) struct Stance {
    /// `[toe, heel][frame]`.
    pub down: [Vec<bool>; 2],
}

/// Targets of one foot at one frame.
#[derive(Debug, Clone, Copy)]
pub(super) struct FootTarget {
    /// Toe and heel of the sole (m, world).
    pub ends: [Vec3; 2],
    /// Weight of each (0: in the air, 1: locked).
    pub hold: [f64; 2],
    /// Orientation of the foot.
    pub orientation: Quat,
    /// Direction of the foot's left side, level, and its weight while only one end stands.
    pub left: Vec3,
    pub turn_hold: f64,
}

impl FootTarget {
    /// Returns whether it stands, wholly or with one end.
    pub fn stands(&self) -> bool {
        self.hold[0].max(self.hold[1]) > 0.99
    }
}

impl Stance {
    /// Returns whether the foot touches at all.
    pub fn any(&self, t: usize) -> bool {
        self.down[0][t] || self.down[1][t]
    }

    fn flags(&self) -> Vec<bool> {
        (0..self.down[0].len()).map(|t| self.any(t)).collect()
    }
}

/// Contacts of the human's feet, left and right.
pub(super) fn detect(human: &Human, fps: f64, options: &ContactOptions) -> [Stance; 2] {
    let options = options.scaled(human.leg_length);
    let size = human.leg_length / 0.9;
    let paths: [[Vec<Vec3>; 2]; 2] = [0, 1].map(|side| {
        [
            human.frames.iter().map(|f| f.legs[side].toe).collect(),
            human.frames.iter().map(|f| f.legs[side].heel).collect(),
        ]
    });
    let mut feet = [0, 1]
        .map(|side| Stance { down: [0, 1].map(|end: usize| point_contacts(&paths[side][end], 0.0, fps, &options)) });
    let flying = in_flight(human, fps);
    let fast: [[Vec<f64>; 2]; 2] = [0, 1].map(|side: usize| [0, 1].map(|end: usize| speeds(&paths[side][end], fps)));
    for t in 0..human.frames.len() {
        if flying[t] || feet.iter().any(|f| f.any(t)) {
            continue;
        }
        // Something carries the person. If an end of a foot is near the ground and not fast, it is that.
        let cost = |side: usize, end: usize| {
            let (height, speed) = (paths[side][end][t].z / size, fast[side][end][t] / size);
            let upright = human.frames[t].legs[side].is_upright();
            (upright && height < 0.15 && speed < 1.5).then_some(height / 0.05 + speed / 0.5)
        };
        let all = (0..2).flat_map(|side| (0..2).map(move |end| (side, end)));
        let best = all.filter_map(|(s, e)| cost(s, e).map(|c| (c, s, e))).min_by(|a, b| a.0.total_cmp(&b.0));
        if let Some((_, side, end)) = best {
            feet[side].down[end][t] = true;
        }
    }
    for (foot, paths) in feet.iter_mut().zip(&paths) {
        for (end, path) in paths.iter().enumerate() {
            clean(&mut foot.down[end], fps, &options);
            step_when_drifting(foot, end, path, 0.05 * size, fps);
        }
    }
    feet
}

/// Returns the frames in which nothing holds the body: its hips fall freely.
pub(super) fn in_flight(human: &Human, fps: f64) -> Vec<bool> {
    let heights: Vec<f64> = human.frames.iter().map(|frame| frame.hips.z).collect();
    free_fall(&heights, fps)
}

/// A foot that creeps further than `far` (m) in one contact makes a small step instead: a cut in its contact.
fn step_when_drifting(foot: &mut Stance, end: usize, path: &[Vec3], far: f64, fps: f64) {
    let gap = ((0.08 * fps).round() as usize).max(1);
    let shortest = ((0.1 * fps).round() as usize).max(2);
    for (start, stop) in runs(&foot.down[end], true) {
        let mut from = start;
        let mut sum = Vec3::zeros();
        let mut t = start;
        while t < stop {
            sum += path[t];
            let mean = sum / (t - from + 1) as f64;
            if (path[t] - mean).xy().norm() > far {
                if t - from > shortest && stop - t > 2 * gap {
                    for flags in &mut foot.down {
                        flags[t - gap / 2..t + gap].fill(false);
                    }
                    t += gap;
                }
                from = t;
                sum = Vec3::zeros();
                if t < stop {
                    sum = path[t];
                }
            }
            t += 1;
        }
    }
}

/// Targets in the character's size, before anything is locked: the human's soles, scaled about the world's origin,
/// moved sideways by the difference of the hips' widths.
pub(super) fn soft_targets(
    rig: &Rig,
    human: &Human,
    stances: &[Stance; 2],
    options: &RetargetOptions,
    fps: f64,
) -> [Vec<FootTarget>; 2] {
    let scale = rig.leg_length / human.leg_length;
    let aside = rig.hip_half_width - scale * human.hip_half_width;
    [0, 1].map(|side| {
        let foot = &rig.legs[side].foot;
        let out = if side == 0 { aside } else { -aside };
        let holds = [0, 1].map(|end: usize| hold(&stances[side].down[end], fps));
        let from_under = [foot.toe, foot.heel].map(|p| foot.rest * (p - foot.under));
        human
            .frames
            .iter()
            .enumerate()
            .map(|(t, frame)| {
                let leg = &frame.legs[side];
                let hold = [holds[0][t], holds[1][t]];
                let keep = keep_of_tilt(hold, options.heel_rise);
                let level = heading(&leg.foot);
                let orientation = level * (level.inverse() * leg.foot).powf(keep);
                let under = leg.under * scale + heading(&frame.pelvis) * Vec3::new(0.0, out, 0.0);
                let ends = [0, 1].map(|end: usize| {
                    let mut p = under + orientation * from_under[end];
                    p.z = p.z.max(0.0) * (1.0 - hold[end]);
                    p
                });
                FootTarget { ends, hold, orientation, left: level * Vec3::y(), turn_hold: 0.0 }
            })
            .collect()
    })
}

/// Returns the share of a foot's tilt that is kept: none while both ends stand; while only one does, `heel_rise` of it.
pub(super) fn keep_of_tilt(hold: [f64; 2], heel_rise: f64) -> f64 {
    let (both, one) = (hold[0].min(hold[1]), hold[0].max(hold[1]));
    (1.0 - both) * (1.0 + (heel_rise - 1.0) * one)
}

/// Returns 1 in contact, falling to 0 within a tenth of a second outside.
pub(super) fn hold(down: &[bool], fps: f64) -> Vec<f64> {
    let mut hold = vec![0.0; down.len()];
    for (start, end) in runs(down, true) {
        for_ramp(start, end, down.len(), 0.1 * fps, |t, a| hold[t] = f64::max(hold[t], a));
    }
    hold
}

/// Visits a stretch and its surroundings of `blend` frames with a raised-cosine weight.
fn for_ramp(start: usize, end: usize, frames: usize, blend: f64, mut visit: impl FnMut(usize, f64)) {
    let reach = blend.ceil() as usize;
    for t in start.saturating_sub(reach)..(end + reach).min(frames) {
        let away = if t < start { start - t } else { (t + 1).saturating_sub(end) } as f64;
        let a = 0.5 + 0.5 * (std::f64::consts::PI * (away / blend).min(1.0)).cos();
        visit(t, a);
    }
}

/// Turns the soles that a first pass produced into targets that stand still where they stand and clear the ground where
/// they swing.
pub(super) fn locked_targets(
    rig: &Rig,
    poses: &[Vec<f64>],
    soft: &[Vec<FootTarget>; 2],
    stances: &[Stance; 2],
    clearance: f64,
    fps: f64,
) -> [Vec<FootTarget>; 2] {
    let mut kinematics = Kinematics::new(rig.character);
    let mut targets = soft.clone();
    for (t, pose) in poses.iter().enumerate() {
        kinematics.update(rig.character, pose);
        for (leg, targets) in rig.legs.iter().zip(&mut targets) {
            targets[t].ends = [leg.foot.toe, leg.foot.heel].map(|p| kinematics.point(leg.foot.body, &p));
        }
    }
    for (side, targets) in targets.iter_mut().enumerate() {
        let foot = &rig.legs[side].foot;
        lift_swing(targets, &stances[side].flags(), clearance, fps);
        hold_turn(targets, &stances[side].flags(), fps);
        lock(targets, &stances[side], (foot.toe - foot.heel).norm(), fps);
    }
    targets
}

/// Raises the soles of a swinging foot to at least `clearance`, from nothing at the ends of the swing.
fn lift_swing(targets: &mut [FootTarget], down: &[bool], clearance: f64, fps: f64) {
    for (start, end) in runs(down, false) {
        let open = |t: usize| {
            let before = if start == 0 { usize::MAX } else { t + 1 - start };
            let after = if end == down.len() { usize::MAX } else { end - t };
            before.min(after) as f64 / (0.14 * fps)
        };
        for (t, target) in targets.iter_mut().enumerate().take(end).skip(start) {
            let phase = (std::f64::consts::FRAC_PI_2 * open(t).min(1.0)).sin();
            let least = clearance * phase * phase;
            for p in &mut target.ends {
                // A smooth maximum.
                let d = p.z - least;
                p.z = least
                    + 0.5 * (d + (d * d + 0.25 * clearance * clearance).sqrt()) * phase
                    + d.max(0.0) * (1.0 - phase);
            }
        }
    }
}

/// Holds the yaw of a foot through each contact in which it hardly turns. A foot that stands on its toes alone
/// therefore does not swivel by accident. Contacts in which it turns on purpose are left alone.
fn hold_turn(targets: &mut [FootTarget], down: &[bool], fps: f64) {
    let frames = targets.len();
    let along: Vec<Vec3> = targets.iter().map(|t| t.ends[0] - t.ends[1]).map(|v| Vec3::new(v.x, v.y, 0.0)).collect();
    for (start, end) in runs(down, true) {
        let Some(mean) = along[start..end].iter().sum::<Vec3>().try_normalize(1e-6) else { continue };
        if along[start..end].iter().any(|a| a.angle(&mean) > 0.35) {
            continue;
        }
        let left = Vec3::new(-mean.y, mean.x, 0.0);
        for_ramp(start, end, frames, 0.1 * fps, |t, a| {
            let both = targets[t].hold[0].min(targets[t].hold[1]);
            if a * (1.0 - both) > targets[t].turn_hold {
                targets[t].turn_hold = a * (1.0 - both);
                targets[t].left = left;
            }
        });
    }
}

/// Replaces the ends' targets in and around each contact by one fixed place.
fn lock(targets: &mut [FootTarget], stance: &Stance, length: f64, fps: f64) {
    let frames = targets.len();
    let spans = [0, 1].map(|end: usize| runs(&stance.down[end], true));
    let mean = |end: usize, (a, b): (usize, usize)| {
        let sum: Vec3 = targets[a..b].iter().map(|f| f.ends[end]).sum();
        let p = sum / (b - a) as f64;
        Vec3::new(p.x, p.y, 0.0)
    };
    let mut places: [Vec<Option<Vec3>>; 2] = [vec![None; spans[0].len()], vec![None; spans[1].len()]];
    // Where both ends stand the sole is rigid: one place and one yaw for both.
    for (i, &toe) in spans[0].iter().enumerate() {
        for (k, &heel) in spans[1].iter().enumerate() {
            let both = (toe.0.max(heel.0), toe.1.min(heel.1));
            if both.0 >= both.1 {
                continue;
            }
            let (front, back) = (mean(0, both), mean(1, both));
            let Some(along) = (front - back).try_normalize(1e-6) else { continue };
            let middle = 0.5 * (front + back);
            match (places[0][i], places[1][k]) {
                (None, None) => {
                    places[0][i] = Some(middle + along * (0.5 * length));
                    places[1][k] = Some(middle - along * (0.5 * length));
                }
                (Some(p), None) => places[1][k] = Some(p - along * length),
                (None, Some(p)) => places[0][i] = Some(p + along * length),
                (Some(_), Some(_)) => {}
            }
        }
    }
    let fixed: Vec<(usize, (usize, usize), Vec3)> = (0..2)
        .flat_map(|end| spans[end].iter().enumerate().map(move |(i, &span)| (end, i, span)))
        .map(|(end, i, span)| (end, span, places[end][i].unwrap_or_else(|| mean(end, span))))
        .collect();
    // Between two contacts both places pull, the nearer more, so the target never jumps from one to the other.
    let mut pull = vec![[(Vec3::zeros(), 0.0, 0.0_f64); 2]; frames];
    for (end, (start, stop), place) in fixed {
        // One frame more than the contact: the smoothing that follows mixes neighbours.
        for_ramp(start.saturating_sub(1), (stop + 1).min(frames), frames, 0.12 * fps, |t, a| {
            let share = a / (1.0 + 1e-9 - a);
            let (sum, weight, hold) = &mut pull[t][end];
            *sum += place * share;
            *weight += share;
            *hold = hold.max(a);
        });
    }
    for (target, pull) in targets.iter_mut().zip(&pull) {
        for (end, (sum, weight, hold)) in pull.iter().enumerate().filter(|(_, p)| p.1 > 0.0) {
            target.ends[end] = target.ends[end].lerp(&(sum / *weight), *hold);
            target.hold[end] = *hold;
        }
    }
}
