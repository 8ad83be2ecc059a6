//! Physical plausibility of a clip, measured from kinematics alone: what generated motion is compared by.
//!
//! Skating, penetration and floating are those of PhysDiff (Yuan et al. 2023), the share of skating frames that of GMD
//! (Karunratanakul et al. 2023), for a character of any size. There are no torques in it: of a floating base they depend
//! on how the ground shares its force; [`crate::feasibility`] tells what force that would have to be.

mod collisions;

use lifelike_character::anatomy::lowest;
use lifelike_character::{Anatomy, Character, Geom, Kinematics, Vec3};

use crate::clip::MotionClip;
use crate::error::MotionError;
use crate::feasibility::{self, Feasibility, TOUCH};
use crate::retarget::shapes::Shapes;

pub use collisions::{Collision, collisions};

/// A sole that touches and moves faster than this skates (m/s). GMD's 2.5 cm in a twentieth of a second are 0.5 m/s,
/// of a person with legs of 0.9 m. Our robots' legs are half as long.
pub const SKATING: f64 = 0.25;
/// Overlap of two parts from which a frame counts as a collision (m): shapes are padded by as much.
pub const OVERLAP: f64 = 0.005;

/// Plausibility of a clip. All numbers are better when lower; 0 is perfect.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Plausibility {
    /// Duration (s).
    pub seconds: f64,
    /// Mean speed over the ground of soles that touch it (m/s).
    pub skate: f64,
    /// Share of steps between frames in which a sole that touches is faster than [`SKATING`].
    pub skating: f64,
    /// Mean depth of the deepest point in the ground (m).
    pub penetration: f64,
    /// Largest depth in the ground (m).
    pub deepest: f64,
    /// Mean height of the lowest point above the ground (m). A jump counts too.
    pub floating: f64,
    /// Share of frames in which two parts overlap by more than [`OVERLAP`].
    pub self_collision: f64,
    /// Share of joint angles out of their range, over joints and frames.
    pub angle_violations: f64,
    /// Largest angle out of its range (rad or m).
    pub angle_excess: f64,
    /// Share of joint speeds above their limit, over joints and steps.
    pub speed_violations: f64,
    /// Share of the time for which [`feasibility::check`] finds something that no ground force could explain.
    pub unexplained: f64,
}

/// Names of [`Plausibility::cells`], with units.
pub const HEAD: [&str; 9] = [
    "skate (mm/s)",
    "skating (%)",
    "penetration (mm)",
    "floating (mm)",
    "self-collision (%)",
    "angle limits (%)",
    "speed limits (%)",
    "unexplained (%)",
    "seconds",
];

impl Plausibility {
    /// Measures a clip. `speeds` are the largest speeds of the character's scalar joints, in its order (rad/s or m/s;
    /// infinite where there is none to exceed).
    ///
    /// # Errors
    /// As [`feasibility::check`].
    pub fn of(
        clip: &MotionClip,
        character: &Character,
        anatomy: &Anatomy,
        speeds: &[f64],
    ) -> Result<Self, MotionError> {
        let feasibility = feasibility::check(clip, character, anatomy, speeds)?;
        let columns = clip.columns_for(character)?;
        let shapes = Shapes::new(character);
        let ranges: Vec<Option<(f64, f64)>> = character.scalar_joints().map(|joint| joint.range).collect();
        let mut kinematics = Kinematics::new(character);
        let mut q = character.reference_position();
        let mut soles = SoleSpeeds::new(clip.fps);
        let (mut depths, mut heights, mut collisions) = (Vec::new(), 0.0, 0_usize);
        let (mut out, mut excess, mut fast) = (0_usize, 0.0_f64, 0_usize);
        for frame in 0..clip.len() {
            clip.write_position(character, &columns, frame, &mut q);
            kinematics.update(character, &q);
            let low = lowest_point(character, anatomy, &kinematics);
            depths.push((-low).max(0.0));
            heights += low.max(0.0);
            collisions += usize::from(shapes.self_penetration(&kinematics) > OVERLAP);
            soles.add(anatomy, &kinematics);
            let angles = clip.joints_at(frame);
            for (column, range) in columns.iter().zip(&ranges) {
                let beyond = range.map_or(0.0, |(low, high)| (low - angles[*column]).max(angles[*column] - high));
                // Written and read back, an angle at its limit may be a bit beyond.
                out += usize::from(beyond > 1e-6);
                excess = excess.max(beyond);
            }
            if let Some(before) = frame.checked_sub(1).map(|frame| clip.joints_at(frame)) {
                let speed = |column: usize| (angles[column] - before[column]).abs() * clip.fps;
                fast += columns.iter().zip(speeds).filter(|(c, most)| speed(**c) > **most * (1.0 + 1e-9)).count();
            }
        }
        let frames = clip.len() as f64;
        let share = |count: usize, of: f64| if of > 0.0 { count as f64 / of } else { 0.0 };
        let joints = columns.len() as f64;
        Ok(Self {
            seconds: clip.seconds(),
            skate: soles.mean(),
            skating: soles.share(),
            penetration: depths.iter().sum::<f64>() / frames,
            deepest: depths.iter().copied().fold(0.0, f64::max),
            floating: heights / frames,
            self_collision: share(collisions, frames),
            angle_violations: share(out, frames * joints),
            angle_excess: excess.max(0.0),
            speed_violations: share(fast, (frames - 1.0) * joints),
            unexplained: unexplained(&feasibility, clip),
        })
    }

    /// Returns the mean over clips, each weighted by its duration; the largest numbers stay the largest. `None` without
    /// any.
    pub fn mean(all: &[Self]) -> Option<Self> {
        let seconds: f64 = all.iter().map(|one| one.seconds).sum();
        if seconds <= 0.0 {
            return None;
        }
        let mean = |of: fn(&Self) -> f64| all.iter().map(|one| one.seconds * of(one)).sum::<f64>() / seconds;
        let most = |of: fn(&Self) -> f64| all.iter().map(of).fold(0.0, f64::max);
        Some(Self {
            seconds,
            skate: mean(|one| one.skate),
            skating: mean(|one| one.skating),
            penetration: mean(|one| one.penetration),
            deepest: most(|one| one.deepest),
            floating: mean(|one| one.floating),
            self_collision: mean(|one| one.self_collision),
            angle_violations: mean(|one| one.angle_violations),
            angle_excess: most(|one| one.angle_excess),
            speed_violations: mean(|one| one.speed_violations),
            unexplained: mean(|one| one.unexplained),
        })
    }

    /// Returns a table's row under [`HEAD`].
    pub fn cells(&self) -> [String; HEAD.len()] {
        let thousandths = |x: f64| format!("{:.1}", 1e3 * x);
        let percent = |x: f64| format!("{:.2}", 1e2 * x);
        [
            thousandths(self.skate),
            percent(self.skating),
            thousandths(self.penetration),
            thousandths(self.floating),
            percent(self.self_collision),
            percent(self.angle_violations),
            percent(self.speed_violations),
            percent(self.unexplained),
            format!("{:.1}", self.seconds),
        ]
    }
}

/// Returns the share of frames in a stretch that rules the clip out by its momentum.
fn unexplained(feasibility: &Feasibility, clip: &MotionClip) -> f64 {
    use feasibility::Kind::{Slipping, Unbalanced, Unsupported};
    let mut frames = vec![false; clip.len()];
    for finding in feasibility.reasons().filter(|f| matches!(f.kind, Unsupported | Unbalanced | Slipping)) {
        let at = |seconds: f64| (seconds * clip.fps).round() as usize;
        let (first, last) = (at(finding.from).min(clip.len()), at(finding.from + finding.seconds).min(clip.len()));
        frames[first..last].fill(true);
    }
    frames.iter().filter(|found| **found).count() as f64 / clip.len() as f64
}

/// Returns the height of the lowest point that can touch the ground (m): of shapes that collide, or of all shapes of a
/// character without such, and of soles.
pub(crate) fn lowest_point(character: &Character, anatomy: &Anatomy, pose: &Kinematics) -> f64 {
    let solid = |g: &&Geom| g.body != 0 && (g.contype | g.conaffinity) != 0;
    let any = character.geoms.iter().any(|g| solid(&g));
    let shapes = character.geoms.iter().filter(|g| if any { solid(g) } else { g.body != 0 });
    let of_shapes = shapes.flat_map(|geom| lowest(geom, pose)).map(|point| point.z);
    let of_soles = corners(anatomy, pose).into_iter().flatten().map(|corner| corner.z);
    let height = of_shapes.chain(of_soles).fold(f64::INFINITY, f64::min);
    if height.is_finite() { height } else { 0.0 }
}

/// Returns the corners of every sole (m, world).
fn corners(anatomy: &Anatomy, pose: &Kinematics) -> Vec<Vec<Vec3>> {
    anatomy.soles.values().map(|sole| sole.corners.iter().map(|c| pose.point(sole.body, c)).collect()).collect()
}

/// Speeds of soles on the ground, step by step: of each sole the slowest corner that is on the ground before and
/// after. A foot that rolls or turns on a corner therefore does not skate.
struct SoleSpeeds {
    fps: f64,
    before: Option<Vec<Vec<Vec3>>>,
    sum: f64,
    touching: usize,
    skating: usize,
    steps: usize,
}

impl SoleSpeeds {
    fn new(fps: f64) -> Self {
        Self { fps, before: None, sum: 0.0, touching: 0, skating: 0, steps: 0 }
    }

    fn add(&mut self, anatomy: &Anatomy, pose: &Kinematics) {
        let now = corners(anatomy, pose);
        let Some(before) = self.before.replace(now.clone()) else { return };
        let mut skates = false;
        for (before, now) in before.iter().zip(&now) {
            let on_ground = before.iter().zip(now).filter(|(a, b)| a.z < TOUCH && b.z < TOUCH);
            let speeds = on_ground.map(|(a, b)| (b.xy() - a.xy()).norm() * self.fps);
            if let Some(speed) = speeds.min_by(f64::total_cmp) {
                (self.sum, self.touching) = (self.sum + speed, self.touching + 1);
                skates |= speed > SKATING;
            }
        }
        self.steps += 1;
        self.skating += usize::from(skates);
    }

    fn mean(&self) -> f64 {
        self.sum / self.touching.max(1) as f64
    }

    fn share(&self) -> f64 {
        self.skating as f64 / self.steps.max(1) as f64
    }
}

#[cfg(test)]
mod tests;
