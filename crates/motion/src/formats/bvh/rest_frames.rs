//! Frames of the rest pose beside and inside of a motion, as `MotionBuilder`, `SlimeVR` and others write them.

use lifelike_character::{Quat, Vec3};

/// Longest rest pose that is looked for (s).
const LONGEST: f64 = 1.0;
/// Longest gap that is interpolated (s).
const LONGEST_GAP: f64 = 0.25;
/// Largest change of a joint while a pose is held (rad).
const HELD: f64 = 0.01;
/// Smallest jump from a rest pose into the motion (rad).
const JUMP: f64 = 0.3;
/// The jump against the largest change of the frames after it: from a pose of zero rotations, and from any other.
const FACTORS: [f64; 2] = [1.5, 4.0];

/// Places of the root and rotations of all joints, a row per frame.
pub(super) struct Frames<'a> {
    pub places: &'a mut Vec<Vec3>,
    pub rotations: &'a mut Vec<Vec<Quat>>,
    pub fps: f64,
    pub notes: &'a mut Vec<String>,
}

impl Frames<'_> {
    /// Removes rest poses at both ends, and interpolates between the frames around those inside.
    ///
    /// # Errors
    /// The frames (from 1) of a gap that is too long to be interpolated.
    pub(super) fn without_rest_poses(mut self) -> Result<(), String> {
        let before = self.rotations.len();
        let lead = self.lead(false);
        if let Some((count, jump)) = lead {
            self.places.drain(..count);
            self.rotations.drain(..count);
            self.say(1, count, "that the motion leaves", jump);
        }
        self.reverse();
        let tail = self.lead(true);
        if let Some((count, jump)) = tail {
            self.places.drain(..count);
            self.rotations.drain(..count);
            self.say(before + 1 - count, before, "that the motion enters", jump);
        }
        self.reverse();
        self.fill_gaps(lead.map_or(0, |(count, _)| count))
    }

    fn say(&mut self, first: usize, last: usize, side: &str, jump: f64) {
        let jump = jump.to_degrees();
        let what = format!("frames {first} to {last} are a rest pose {side} by a jump of {jump:.0} degrees");
        self.notes.push(format!("{what}: they were left out"));
    }

    fn reverse(&mut self) {
        self.places.reverse();
        self.rotations.reverse();
    }

    /// Returns the largest change of a joint from a frame to the next (rad).
    fn change(&self, t: usize) -> f64 {
        let pairs = self.rotations[t].iter().zip(&self.rotations[t + 1]);
        pairs.map(|(a, b)| a.angle_to(b)).fold(0.0, f64::max)
    }

    fn is_zero(&self, t: usize) -> bool {
        self.rotations[t].iter().skip(1).all(|turn| turn.angle() < HELD)
    }

    /// Finds a pose that is held at the start and left by a jump that no later frame makes: its frames, and the jump (rad).
    fn lead(&self, only_zeros: bool) -> Option<(usize, f64)> {
        let last = self.rotations.len() - 1;
        let longest = ((LONGEST * self.fps) as usize).max(1).min(last);
        let at = (0..longest).find(|&t| self.change(t) > HELD)?;
        let after = (at + 1..last.min(at + 1 + longest.max(10))).map(|t| self.change(t)).fold(0.0, f64::max);
        let is_zero = self.is_zero(at);
        let factor = FACTORS[usize::from(!is_zero)];
        let is_short = last < at + 3 || self.change(at) < JUMP.max(factor * after) || (only_zeros && !is_zero);
        (!is_short).then(|| (at + 1, self.change(at)))
    }

    /// Interpolates over frames of zero rotations that the motion enters and leaves by a jump.
    fn fill_gaps(&mut self, dropped: usize) -> Result<(), String> {
        let frames = self.rotations.len();
        let mut t = 1;
        while t + 1 < frames {
            let end = (t..frames).find(|&t| !self.is_zero(t)).unwrap_or(frames);
            if end == t || end == frames || self.change(t - 1) < JUMP || self.change(end - 1) < JUMP {
                t = end.max(t + 1);
                continue;
            }
            let name = format!("frames {} to {}", t + 1 + dropped, end + dropped);
            if (end - t) as f64 > (LONGEST_GAP * self.fps).max(1.0) {
                return Err(name);
            }
            self.notes.push(format!("{name} have no rotations, a gap in the capture: they were interpolated"));
            for at in t..end {
                let part = (at + 1 - t) as f64 / (end + 1 - t) as f64;
                self.places[at] = self.places[t - 1].lerp(&self.places[end], part);
                let turn = |(a, b): (&Quat, &Quat)| a.try_slerp(b, part, 1e-9).unwrap_or(*a);
                self.rotations[at] = self.rotations[t - 1].iter().zip(&self.rotations[end]).map(turn).collect();
            }
            t = end;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    /// Sixty frames at 30 per second: the root travels along x, the other joint is raised by 1 rad and swings.
    fn motion() -> (Vec<Vec3>, Vec<Vec<Quat>>) {
        let frame = |t: usize| {
            let angle = 1.0 + 0.2 * (t as f64 * 0.2).sin();
            (Vec3::new(t as f64, 0.0, 0.0), vec![Quat::identity(), Quat::from_euler_angles(angle, 0.0, 0.0)])
        };
        (0..60).map(frame).unzip()
    }

    fn cleaned(places: &mut Vec<Vec3>, rotations: &mut Vec<Vec<Quat>>) -> Result<Vec<String>, String> {
        let mut notes = Vec::new();
        Frames { places, rotations, fps: 30.0, notes: &mut notes }.without_rest_poses()?;
        Ok(notes)
    }

    #[test]
    fn motion_without_rest_poses_stays_as_it_is() {
        let (mut places, mut rotations) = motion();
        assert_eq!(cleaned(&mut places, &mut rotations), Ok(vec![]));
        assert_eq!((places, rotations), motion());
    }

    #[test]
    fn rest_poses_at_both_ends_are_left_out() {
        let (places, rotations) = motion();
        let rest = vec![Quat::identity(); 2];
        let mut framed = [vec![rest.clone(); 10], rotations.clone(), vec![rest; 2]].concat();
        let mut at = [vec![Vec3::zeros(); 10], places.clone(), vec![Vec3::zeros(); 2]].concat();
        let notes = cleaned(&mut at, &mut framed).unwrap();
        assert_eq!((at, framed), (places, rotations));
        assert!(notes[0].starts_with("frames 1 to 10 are a rest pose that the motion leaves"), "{notes:?}");
        assert!(notes[1].starts_with("frames 71 to 72 are a rest pose that the motion enters"), "{notes:?}");
    }

    #[test]
    fn short_gaps_are_interpolated_and_long_ones_refused() {
        let with_gap = |gap: std::ops::Range<usize>| {
            let (mut places, mut rotations) = motion();
            for t in gap {
                (places[t], rotations[t]) = (Vec3::zeros(), vec![Quat::identity(); 2]);
            }
            let notes = cleaned(&mut places, &mut rotations)?;
            Ok((places, rotations, notes))
        };
        let (places, rotations, notes) = with_gap(30..33).unwrap();
        assert!(notes[0].starts_with("frames 31 to 33 have no rotations"), "{notes:?}");
        let (expected, turns) = motion();
        // The root travels evenly. The swing, 0.2 sin(0.2 t) rad, bends by at most 0.2 (0.2)^2 4^2 / 8 over the gap.
        assert!(places.iter().zip(&expected).all(|(a, b)| (a - b).norm() < 1e-9));
        let apart = rotations.iter().zip(&turns).map(|(a, b)| a[1].angle_to(&b[1])).fold(0.0, f64::max);
        assert!(apart < 0.016, "{apart}");
        assert_eq!(with_gap(20..40), Err("frames 21 to 40".to_owned()));
    }
}
