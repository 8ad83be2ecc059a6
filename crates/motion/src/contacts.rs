//! Ground contact of a point: low AND slow, with hysteresis.
//!
//! The same rule serves captured humans and characters' clips. Heights of humans are known up to the sole's thickness
//! ([`ground_level`]); sole corners of characters are known exactly.

use lifelike_character::{Anatomy, Character, Kinematics, Role, Vec3};

use crate::clip::{Contacts, MotionClip};
use crate::error::MotionError;

/// Thresholds for a person with 0.9 m from hip to sole; [`ContactOptions::scaled`] adapts them.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ContactOptions {
    /// Below this height (m) contact may begin.
    pub enter_height: f64,
    /// Above this height (m) contact ends.
    pub leave_height: f64,
    /// Below this speed (m/s) contact may begin.
    pub enter_speed: f64,
    /// Above this speed (m/s) contact ends.
    pub leave_speed: f64,
    /// Shorter contacts (s) are dropped.
    pub shortest_contact: f64,
    /// Shorter gaps (s) are closed.
    pub shortest_gap: f64,
}

impl Default for ContactOptions {
    fn default() -> Self {
        Self {
            enter_height: 0.035,
            leave_height: 0.06,
            enter_speed: 0.5,
            leave_speed: 0.85,
            shortest_contact: 0.07,
            shortest_gap: 0.05,
        }
    }
}

impl ContactOptions {
    /// Returns narrower bounds of height, for feet without the noise of capture: one that leaves the ground by a centimetre
    /// steps. Captured feet need the wider bounds, within which a low slow step would be taken for standing.
    #[must_use]
    pub fn without_noise(self) -> Self {
        Self { enter_height: 0.008, leave_height: 0.012, ..self }
    }

    /// Returns the same rule for legs of this length (m).
    pub fn scaled(&self, leg_length: f64) -> Self {
        let scale = leg_length / 0.9;
        Self {
            enter_height: self.enter_height * scale,
            leave_height: self.leave_height * scale,
            enter_speed: self.enter_speed * scale,
            leave_speed: self.leave_speed * scale,
            ..*self
        }
    }
}

/// Returns the speed of a point at each frame (m/s), by central differences.
pub fn speeds(path: &[Vec3], fps: f64) -> Vec<f64> {
    let last = path.len().saturating_sub(1);
    (0..path.len())
        .map(|t| {
            let (a, b) = (t.saturating_sub(1), (t + 1).min(last));
            if a == b { 0.0 } else { (path[b] - path[a]).norm() * fps / (b - a) as f64 }
        })
        .collect()
}

/// Returns the height (m) at which this point rests while it stands: the lower end of the heights it has when it is
/// slow. If it never is slow, that is nearly its lowest height. Only frames that `counts` picks are looked at; `None`
/// when it picks none.
pub fn ground_level(path: &[Vec3], fps: f64, slow: f64, counts: impl Fn(usize) -> bool) -> Option<f64> {
    let speed = speeds(path, fps);
    let pick = |slow: f64| -> Vec<f64> {
        (0..path.len()).filter(|&t| speed[t] < slow && counts(t)).map(|t| path[t].z).collect()
    };
    let (mut heights, mut share) = (pick(slow), 0.1);
    if heights.len() < 5 {
        (heights, share) = (pick(f64::INFINITY), 0.02);
    }
    heights.sort_by(f64::total_cmp);
    heights.get((heights.len() as f64 * share) as usize).copied()
}

/// Returns the contact of one point at each frame, given the height at which it rests (m).
pub fn point_contacts(path: &[Vec3], level: f64, fps: f64, options: &ContactOptions) -> Vec<bool> {
    let speed = speeds(path, fps);
    let mut flags = Vec::with_capacity(path.len());
    let mut down = false;
    for (p, v) in path.iter().zip(&speed) {
        let height = p.z - level;
        down = if down {
            height < options.leave_height && *v < options.leave_speed
        } else {
            height < options.enter_height && *v < options.enter_speed
        };
        flags.push(down);
    }
    // Hysteresis forwards delays the start; backwards it delays the end. A point that came down slowly was down already.
    let mut later = false;
    for t in (0..flags.len()).rev() {
        let height = path[t].z - level;
        later = flags[t] || (later && height < options.enter_height && speed[t] < options.leave_speed);
        flags[t] = later;
    }
    clean(&mut flags, fps, options);
    flags
}

/// Closes short gaps, then drops short contacts.
pub fn clean(flags: &mut [bool], fps: f64, options: &ContactOptions) {
    let frames = flags.len();
    for (value, shortest) in [(false, options.shortest_gap), (true, options.shortest_contact)] {
        for (start, end) in runs(flags, value) {
            // What the clip's ends cut off may have been longer.
            if start > 0 && end < frames && ((end - start) as f64) < shortest * fps {
                flags[start..end].fill(!value);
            }
        }
    }
}

/// Returns the frames in which what has these heights (m) falls freely, with about g: nothing holds it.
pub fn free_fall(heights: &[f64], fps: f64) -> Vec<bool> {
    let span = ((0.06 * fps).round() as usize).max(1);
    let falls = |t: usize| {
        let [before, now, after] = [t - span, t, t + span].map(|t| heights[t]);
        (after - 2.0 * now + before) * (fps / span as f64).powi(2) < -5.0
    };
    (0..heights.len()).map(|t| t >= span && t + span < heights.len() && falls(t)).collect()
}

/// Stretches `[start, end)` in which the flag has this value.
pub fn runs(flags: &[bool], value: bool) -> Vec<(usize, usize)> {
    let mut found = Vec::new();
    let mut start = None;
    for (t, &flag) in flags.iter().chain(std::iter::once(&!value)).enumerate() {
        match (flag == value, start) {
            (true, None) => start = Some(t),
            (false, Some(s)) => {
                found.push((s, t));
                start = None;
            }
            _ => {}
        }
    }
    found
}

/// Returns the foot contacts of a character's clip: a foot touches while the lowest corner of its sole is low and slow.
/// Names are those of the foot bodies, left before right.
///
/// # Errors
/// When the clip's joints are not the character's.
pub fn clip_contacts(
    clip: &MotionClip,
    character: &Character,
    anatomy: &Anatomy,
    options: &ContactOptions,
) -> Result<Contacts, MotionError> {
    let columns = clip.columns_for(character)?;
    let feet: Vec<_> = [Role::LeftFoot, Role::RightFoot].iter().filter_map(|r| anatomy.soles.get(r)).collect();
    let mut kinematics = Kinematics::new(character);
    let mut q = character.reference_position();
    let mut paths: Vec<Vec<Vec<Vec3>>> = feet.iter().map(|f| vec![Vec::new(); f.corners.len()]).collect();
    for t in 0..clip.len() {
        clip.write_position(character, &columns, t, &mut q);
        kinematics.update(character, &q);
        for (foot, paths) in feet.iter().zip(&mut paths) {
            for (corner, path) in foot.corners.iter().zip(paths) {
                path.push(kinematics.point(foot.body, corner));
            }
        }
    }
    let flags: Vec<Vec<bool>> = paths
        .iter()
        .map(|corners| {
            let mut any = vec![false; clip.len()];
            for path in corners {
                for (a, b) in any.iter_mut().zip(point_contacts(path, 0.0, clip.fps, options)) {
                    *a |= b;
                }
            }
            any
        })
        .collect();
    Ok(Contacts {
        names: feet.iter().map(|f| character.bodies[f.body].name.clone()).collect(),
        flags: (0..clip.len()).flat_map(|t| flags.iter().map(move |f| f[t])).collect(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn step(t: f64) -> Vec3 {
        // Down for 0.5 s at x = 0, then 0.4 s of swing 0.8 m forward and 8 cm up, then down again.
        let s = ((t - 0.5) / 0.4).clamp(0.0, 1.0);
        let ease = s * s * (3.0 - 2.0 * s);
        Vec3::new(0.8 * ease, 0.0, 0.07 + 0.08 * (std::f64::consts::PI * s).sin())
    }

    #[test]
    fn a_step_is_two_contacts_and_a_swing() {
        let path: Vec<Vec3> = (0..75).map(|i| step(f64::from(i) / 50.0)).collect();
        let level = ground_level(&path, 50.0, 0.2, |_| true).unwrap_or(f64::NAN);
        assert!((level - 0.07).abs() < 1e-6, "{level}");
        let flags = point_contacts(&path, level, 50.0, &ContactOptions::default());
        let down = runs(&flags, true);
        assert_eq!(down.len(), 2, "{down:?}");
        assert!(down[0].1.abs_diff(26) <= 3 && down[1].0.abs_diff(45) <= 3 && down[1].1 == 75, "{down:?}");
    }

    #[test]
    fn low_but_fast_is_no_contact() {
        let path: Vec<Vec3> = (0..50).map(|i| Vec3::new(f64::from(i) * 0.03, 0.0, 0.0)).collect();
        assert!(point_contacts(&path, 0.0, 50.0, &ContactOptions::default()).iter().all(|c| !c));
    }

    #[test]
    fn short_gaps_close_and_short_contacts_go() {
        let options = ContactOptions { shortest_gap: 0.05, shortest_contact: 0.07, ..ContactOptions::default() };
        let mut flags = vec![true, true, true, true, true, false, true, true, true, false, false, false, false, true];
        flags.extend([false, false, false, false]);
        clean(&mut flags, 50.0, &options);
        assert_eq!(runs(&flags, true), vec![(0, 9)]);
    }
}
