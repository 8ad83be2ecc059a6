//! Changes of a repair.

use lifelike_character::{Kinematics, Vec3};

use super::pace::Pace;
use crate::clip::MotionClip;
use crate::edit::poses::positions;
use crate::error::MotionError;
use crate::feasibility::Feasibility;
use crate::resample::locate;
use crate::retarget::rig::Rig;
use crate::retarget::{Gather, Spread};

/// A repaired clip: what was found, what is still found, and what it took.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Repaired {
    /// The clip.
    pub clip: String,
    /// Findings before.
    pub before: Feasibility,
    /// Findings now.
    pub after: Feasibility,
    /// Changes made.
    pub change: Change,
}

/// Distance of a motion from the one it was, frame by frame at the times to which they were moved.
#[derive(Debug, Clone, Copy, PartialEq, Default, serde::Serialize)]
pub struct Change {
    /// Root (m).
    pub root: Spread,
    /// Middle of the soles (m).
    pub feet: Spread,
    /// Joints of the legs (rad).
    pub legs: Spread,
    /// Other joints (rad).
    pub others: Spread,
    /// Longer by so much (s).
    pub longer: f64,
    /// The most that a moment is earlier or later (s).
    pub moved: f64,
}

impl Change {
    /// Returns the change of `old`, whose frames come at `pace`'s times in `new`.
    pub(super) fn between(old: &MotionClip, new: &MotionClip, pace: &Pace, rig: &Rig) -> Result<Self, MotionError> {
        let (was, is) = (positions(old, rig.character)?, positions(new, rig.character)?);
        let [mut root, mut feet, mut legs, mut others] = [(); 4].map(|()| Gather::default());
        let (mut before, mut after) = (Kinematics::new(rig.character), Kinematics::new(rig.character));
        let at = rig.root.q_index;
        for (t, q) in was.iter().enumerate() {
            let (frame, share) = locate(pace.times[t] * new.fps, new.len());
            let (a, b) = (&is[frame], &is[(frame + 1).min(is.len() - 1)]);
            let mixed: Vec<f64> = a.iter().zip(b).map(|(a, b)| a + (b - a) * share).collect();
            let place = |q: &[f64]| Vec3::new(q[at], q[at + 1], q[at + 2]);
            root.add((place(&mixed) - place(q)).norm());
            for axis in &rig.axes {
                let spread = if axis.leg { &mut legs } else { &mut others };
                spread.add((mixed[axis.q] - q[axis.q]).abs());
            }
            before.update(rig.character, q);
            after.update(rig.character, &mixed);
            for leg in &rig.legs {
                let middle = |k: &Kinematics| k.point(leg.foot.body, &leg.foot.under);
                feet.add((middle(&after) - middle(&before)).norm());
            }
        }
        let late = pace.times.iter().enumerate().map(|(t, time)| (time - t as f64 / old.fps).abs());
        Ok(Self {
            root: root.spread(),
            feet: feet.spread(),
            legs: legs.spread(),
            others: others.spread(),
            longer: new.seconds() - old.seconds(),
            moved: late.fold(0.0, f64::max),
        })
    }
}
