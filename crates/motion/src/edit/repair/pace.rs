//! Time: a jump that was shrunk onto a small robot falls too slowly, and a joint may have too little time.

use super::{FALLING, Needs};
use crate::clip::MotionClip;
use crate::contacts::runs;
use crate::edit::joints::{column, set_column};
use crate::edit::warp::{Warp, warp};
use crate::error::MotionError;
use crate::feasibility::{Feasibility, Kind};
use crate::retarget::rig::Rig;
use crate::retarget::smooth::{limit_speed, smooth};

/// The pace changes around what needs another (s): dilated by so much, and smoothed by so much.
const AROUND: f64 = 0.12;
const SMOOTH: f64 = 0.06;
/// The largest factor on the speed, and one over the least.
const MOST: f64 = 2.0;
/// Joints get so much more time than the limit asks for.
const SLACK: f64 = 1.05;

/// When each frame of the clip comes now (s).
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Pace {
    pub times: Vec<f64>,
}

impl Pace {
    /// The clip's own.
    pub fn of(clip: &MotionClip) -> Self {
        Self { times: (0..clip.len()).map(|t| t as f64 / clip.fps).collect() }
    }

    /// Returns one at which what is in the air falls as things do and no joint is too fast. `None` if the clip's own
    /// is that.
    pub fn better(clip: &MotionClip, needs: &Needs, found: &Feasibility) -> Option<Self> {
        let faster = wanted(clip, needs, found);
        if faster.iter().all(|x| *x == 0.0) {
            return None;
        }
        let rate = smooth(&around(&faster, (AROUND * clip.fps).round() as usize), SMOOTH * clip.fps);
        let mut time = 0.0;
        let mut times = Vec::with_capacity(clip.len());
        for pair in rate.iter().zip(rate.iter().skip(1).chain(rate.last())) {
            times.push(time);
            time += 1.0 / (clip.fps * (0.5 * (pair.0 + pair.1)).exp());
        }
        Some(Self { times })
    }

    /// Returns the clip at this pace; a joint that is too fast for it, an arm in a jump, does as much as it can.
    pub fn applied(&self, clip: &MotionClip, rig: &Rig) -> Result<MotionClip, MotionError> {
        let keys = self.times.iter().enumerate().map(|(t, to)| (t as f64 / clip.fps, *to));
        let mut out = warp(clip, &Warp::Keys(keys.collect()))?;
        for (axis, joint) in rig.axes.iter().zip(rig.character.scalar_joints()) {
            let Some(at) = out.joint_names.iter().position(|own| *own == joint.name) else { continue };
            let mut values = column(&out, at);
            limit_speed(&mut values, axis.speed / out.fps);
            set_column(&mut out, at, &values);
        }
        Ok(out)
    }
}

/// Returns for each frame the logarithm of how many times as fast it is to be.
fn wanted(clip: &MotionClip, needs: &Needs, found: &Feasibility) -> Vec<f64> {
    let mut faster = vec![0.0_f64; clip.len()];
    let unsupported = |(start, end): (usize, usize)| {
        let of = |f: &&crate::feasibility::Finding| f.kind == Kind::Unsupported;
        let within = |f: &crate::feasibility::Finding| {
            let from = (f.from * clip.fps).round() as usize;
            from >= start && from < end
        };
        found.findings.iter().filter(of).any(|f| within(f) && f.rules_out())
    };
    for (start, end) in needs.airborne() {
        let Some(fall) = needs.falls((start, end), clip.fps) else { continue };
        if fall > FALLING * needs.gravity && unsupported((start, end)) {
            let factor = (needs.gravity / fall).sqrt().clamp(1.0, MOST);
            faster[start..end].fill(factor.ln());
        }
    }
    for finding in found.findings.iter().filter(|f| f.kind == Kind::TooFast) {
        let start = (finding.from * clip.fps).round() as usize;
        let end = (start + (finding.seconds * clip.fps).round() as usize).min(clip.len());
        let factor = -(finding.worst * SLACK).min(MOST).ln();
        faster[start.min(end)..end].fill(factor);
    }
    faster
}

/// Spreads what stretches want to the frames before and after them.
fn around(faster: &[f64], reach: usize) -> Vec<f64> {
    let flags: Vec<bool> = faster.iter().map(|x| *x != 0.0).collect();
    let mut wide = faster.to_vec();
    for (start, end) in runs(&flags, true) {
        for t in start.saturating_sub(reach)..(end + reach).min(wide.len()) {
            if !flags[t] {
                wide[t] = if t < start { faster[start] } else { faster[end - 1] };
            }
        }
    }
    wide
}
