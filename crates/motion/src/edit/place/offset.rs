//! Offsets of a point from the clip's own path, over time.

use lifelike_character::{Kinematics, Vec3};

use super::{Key, Target};
use crate::clip::MotionClip;
use crate::edit::story::unfit;
use crate::error::MotionError;
use crate::keyframes::curve::Curve;
use crate::retarget::rig::{Rig, Spot};

/// When and how far a point is moved.
#[derive(Debug, Clone, Copy)]
pub(super) struct Hit {
    /// Index of the key.
    pub key: usize,
    pub frame: usize,
    /// From where the clip has it (m, world).
    pub offset: Vec3,
}

/// The keys of one point.
#[derive(Debug)]
pub(super) struct Track {
    pub spot: Spot,
    /// In the order of time.
    pub hits: Vec<Hit>,
    curves: [Curve; 3],
    /// Times between which the point deviates (s).
    windows: Vec<(f64, f64)>,
}

impl Track {
    /// Gathers keys by point.
    ///
    /// # Errors
    /// As [`super::place`], as far as numbers are concerned.
    pub fn of_keys(
        clip: &MotionClip,
        rig: &Rig,
        poses: &[Vec<f64>],
        keys: &[Key],
        spots: &[Spot],
    ) -> Result<Vec<Self>, MotionError> {
        let mut kinematics = Kinematics::new(rig.character);
        let mut groups: Vec<(Spot, Vec<Hit>)> = Vec::new();
        for (index, (key, spot)) in keys.iter().zip(spots).enumerate() {
            check(clip, key)?;
            let frame = ((key.time * clip.fps).round() as usize).min(clip.len() - 1);
            kinematics.update(rig.character, &poses[frame]);
            let offset = match key.target {
                Target::At(place) => place - kinematics.point(spot.body, &spot.point),
                Target::By(offset) => offset,
            };
            let hit = Hit { key: index, frame, offset };
            match groups.iter_mut().find(|(s, _)| s.body == spot.body && s.point == spot.point) {
                Some((_, group)) => group.push(hit),
                None => groups.push((*spot, vec![hit])),
            }
        }
        groups.into_iter().map(|(spot, group)| Self::new(clip, spot, group, keys)).collect()
    }

    fn new(clip: &MotionClip, spot: Spot, mut hits: Vec<Hit>, keys: &[Key]) -> Result<Self, MotionError> {
        hits.sort_by_key(|hit| hit.frame);
        if let Some(pair) = hits.windows(2).find(|pair| pair[0].frame == pair[1].frame) {
            let name = &keys[pair[0].key].body;
            return Err(unfit(clip, format!("expected one place for '{name}' in frame {}, got two", pair[0].frame)));
        }
        let mut knots: Vec<(f64, Vec3)> = Vec::new();
        let mut windows: Vec<(f64, f64)> = Vec::new();
        for hit in &hits {
            let time = hit.frame as f64 / clip.fps;
            let (start, end) = (time - keys[hit.key].before, time + keys[hit.key].after);
            match windows.last_mut() {
                // The one before is not over yet: from place to place, without going back in between.
                Some(last) if start <= last.1 => {
                    knots.pop();
                    last.1 = end;
                }
                _ => {
                    knots.push((start, Vec3::zeros()));
                    windows.push((start, end));
                }
            }
            knots.push((time, hit.offset));
            knots.push((end, Vec3::zeros()));
        }
        let curves = [0, 1, 2].map(|axis: usize| {
            Curve::new(&knots.iter().map(|(time, offset)| (*time, offset[axis])).collect::<Vec<_>>(), None)
        });
        Ok(Self { spot, hits, curves, windows })
    }

    /// Returns the offset at a time (m, world); `None` outside of all windows.
    pub fn at(&self, time: f64) -> Option<Vec3> {
        let within = self.windows.iter().any(|(start, end)| *start < time && time < *end);
        within.then(|| Vec3::from_fn(|axis, _| self.curves[axis].at(time)))
    }
}

fn check(clip: &MotionClip, key: &Key) -> Result<(), MotionError> {
    let seconds = clip.seconds();
    let (Target::At(place) | Target::By(place)) = key.target;
    let point = key.point.unwrap_or_else(Vec3::zeros);
    let expected = if !(0.0..=seconds + 0.5 / clip.fps).contains(&key.time) {
        format!("a time in its {seconds:.3} s, got {} s", key.time)
    } else if !place.iter().chain(point.iter()).all(|v| v.is_finite() && v.abs() < 1e6) {
        format!("a place in metres, got {:?} (point {:?})", place.as_slice(), point.as_slice())
    } else if let Some(window) = [key.before, key.after].into_iter().find(|w| !(w.is_finite() && *w >= 1.0 / clip.fps))
    {
        format!("windows of a frame ({} s) or more, got {window} s", 1.0 / clip.fps)
    } else {
        return Ok(());
    };
    Err(unfit(clip, format!("key of '{}': expected {expected}", key.body)))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::fixtures::clip;

    fn key(time: f64, before: f64, after: f64) -> Key {
        Key { body: "arm".into(), point: None, time, target: Target::By(Vec3::x()), before, after }
    }

    fn track(keys: &[Key], offsets: &[f64]) -> Result<Track, MotionError> {
        let c = clip(101, |_| [0.0, 0.0]);
        let frame = |time: f64| (time * c.fps).round() as usize;
        let hit = |(key, k): (usize, &Key)| Hit { key, frame: frame(k.time), offset: Vec3::x() * offsets[key] };
        let spot = Spot { body: 2, point: Vec3::zeros() };
        Track::new(&c, spot, keys.iter().enumerate().map(hit).collect(), keys)
    }

    #[test]
    fn an_offset_comes_and_goes_within_its_window() {
        let track = track(&[key(1.0, 0.4, 0.2)], &[0.1]).unwrap();
        let x = |time: f64| track.at(time).map(|o| o.x);
        assert_eq!((x(0.6), x(1.0), x(1.2)), (None, Some(0.1), None));
        // The middle of a quintic that rests at both ends.
        assert!((x(0.8).unwrap() - 0.05).abs() < 1e-12 && (x(1.1).unwrap() - 0.05).abs() < 1e-12);
    }

    #[test]
    fn keys_that_meet_are_joined_and_keys_apart_are_not() {
        // Opposite order of time on purpose.
        let near = track(&[key(1.2, 0.4, 0.2), key(1.0, 0.4, 0.2)], &[0.1, 0.1]).unwrap();
        assert_eq!(near.at(1.1).map(|o| o.x), Some(0.1), "held in between");
        assert!(near.at(0.7).is_some() && near.at(1.4).is_none());
        let apart = track(&[key(0.4, 0.2, 0.2), key(1.6, 0.2, 0.2)], &[0.1, -0.1]).unwrap();
        assert!(apart.at(1.0).is_none() && apart.at(1.5).unwrap().x < 0.0);
        let twice = track(&[key(1.0, 0.2, 0.2), key(1.004, 0.2, 0.2)], &[0.1, 0.2]).unwrap_err().to_string();
        assert!(twice.contains("frame 50"), "{twice}");
    }

    #[test]
    fn numbers_that_are_none_are_refused() {
        let c = clip(101, |_| [0.0, 0.0]);
        assert!(check(&c, &key(2.0, 0.1, 0.1)).is_ok());
        for (time, before, after) in [(2.1, 0.1, 0.1), (-0.1, 0.1, 0.1), (1.0, 0.0, 0.1), (1.0, 0.1, f64::NAN)] {
            assert!(check(&c, &key(time, before, after)).is_err(), "{time} {before} {after}");
        }
        let nowhere = Key { target: Target::At(Vec3::new(f64::NAN, 0.0, 0.0)), ..key(1.0, 0.1, 0.1) };
        assert!(check(&c, &nowhere).is_err());
    }
}
