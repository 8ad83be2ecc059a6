//! A clip as segments of control points, and the clip that they make.

use lifelike_motion::resample::locate;
use lifelike_motion::{Contacts, MotionClip};
use lifelike_nn::transformer::Sampling;

use super::model::MotionSpline;
use super::poses::Poses;
use crate::RepresentationError;
use lifelike_train::limits::{range, wrong};

/// Share of a segment over which it gives way to the next, at least.
const OVERLAP: f64 = 0.125;

/// One curve.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Segment {
    /// Start time (s since the clip's begin).
    pub start: f64,
    /// `[control points][latent]`.
    pub control_points: Vec<Vec<f32>>,
}

/// Reconstruction errors of a clip from control points alone, without the detail that editing carries along.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct ClipErrors {
    /// The clip.
    pub clip: String,
    /// Frames.
    pub frames: usize,
    /// Root mean square error of joints (deg).
    pub joints_deg: f64,
    /// Of the root's height (mm).
    pub height_mm: f64,
    /// Of the velocity over the ground (m/s).
    pub velocity: f64,
}

/// Options for playing control points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Playing {
    /// Frames per second of the result; the curves are sampled as densely as that asks for (super-sampling).
    pub fps: f64,
    /// 2 plays in half of the time.
    pub speed: f64,
    /// Adds the detail that control points leave out of the clip. With it, unchanged control points give
    /// the very clip; without, what the network makes of them.
    pub detail: bool,
}

/// A clip as control points.
#[derive(Debug, Clone)]
pub struct SplinedClip {
    clip: MotionClip,
    poses: Poses,
    segments: Vec<Segment>,
    /// Detail: the poses less the segments as they were encoded, at the clip's rate.
    detail: Poses,
}

impl Segment {
    /// Returns the curve in the latent space at `samples` places, evenly from its begin to its end.
    ///
    /// # Shapes
    /// `[samples][latent]`.
    ///
    /// # Errors
    /// A segment of another model.
    pub fn curve(&self, model: &MotionSpline, samples: usize) -> Result<Vec<Vec<f32>>, RepresentationError> {
        let numbers: Vec<f32> = self.control_points.iter().flatten().copied().collect();
        if numbers.len() != model.control_points() * model.latent() {
            let expected = format!("{} control points of {} numbers", model.control_points(), model.latent());
            return Err(wrong("segment", &expected, format!("{} numbers", numbers.len())).into());
        }
        Ok(model.curve(&numbers, samples)?.chunks_exact(model.latent()).map(<[f32]>::to_vec).collect())
    }
}

impl SplinedClip {
    /// Segments overlap and lie evenly over the clip; a clip shorter than one is held at its last pose.
    ///
    /// # Errors
    /// A clip of other joints than the model's, or one that is broken.
    pub fn encode(model: &MotionSpline, clip: &MotionClip) -> Result<Self, RepresentationError> {
        let plan = model.plan();
        let (poses, coarse) = (model.poses(clip, clip.fps)?, model.poses(clip, plan.frame_rate)?);
        let starts = starts(coarse.len(), plan.frames);
        let mut rows = vec![0.0; starts.len() * plan.frames * coarse.width()];
        let frames = starts.iter().flat_map(|start| (0..plan.frames).map(move |i| (start + i) as f64));
        rows.chunks_exact_mut(coarse.width()).zip(frames).for_each(|(row, frame)| coarse.write_at(frame, row));
        let points = model.control(&rows)?;
        let segments = points.chunks_exact(model.control_points() * model.latent()).zip(&starts);
        let segments: Vec<Segment> = segments
            .map(|(points, start)| Segment {
                start: *start as f64 / plan.frame_rate,
                control_points: points.chunks_exact(model.latent()).map(<[f32]>::to_vec).collect(),
            })
            .collect();
        let mut this = Self { clip: clip.clone(), detail: poses.clone(), poses, segments };
        let made = this.made(model, &Playing { fps: clip.fps, speed: 1.0, detail: false })?;
        this.detail.rows.iter_mut().zip(&made.rows).for_each(|(detail, made)| *detail -= made);
        Ok(this)
    }

    /// Returns the clip that was encoded.
    pub fn clip(&self) -> &MotionClip {
        &self.clip
    }

    /// Returns the curves, in the order of their time.
    pub fn segments(&self) -> &[Segment] {
        &self.segments
    }

    /// Puts other control points in their place, as from a file.
    ///
    /// # Errors
    /// Another number of segments, points or numbers; a number that is not finite.
    pub fn set_segments(&mut self, segments: Vec<Segment>) -> Result<(), RepresentationError> {
        if segments.len() != self.segments.len() {
            return Err(wrong("segments", &self.segments.len().to_string(), segments.len()).into());
        }
        let shape = |s: &Segment| s.control_points.iter().map(Vec::len).collect::<Vec<_>>();
        let mut pairs = self.segments.iter().zip(&segments).map(|(own, new)| (shape(own), shape(new))).enumerate();
        if let Some((k, (own, new))) = pairs.find(|(_, (own, new))| own != new) {
            let key = format!("numbers of the control points of segment {k}");
            return Err(wrong(&key, &format!("{own:?}"), format!("{new:?}")).into());
        }
        let numbers = |s: &Segment| s.control_points.iter().flatten().all(|x| x.is_finite());
        if let Some(broken) = segments.iter().position(|s| !numbers(s)) {
            return Err(wrong("segments", "finite numbers", format!("one that is not in segment {broken}")).into());
        }
        for (own, new) in self.segments.iter_mut().zip(segments) {
            own.control_points = new.control_points;
        }
        Ok(())
    }

    pub(super) fn segments_mut(&mut self) -> &mut [Segment] {
        &mut self.segments
    }

    /// Mixes in another clip's control points and detail: `weight` 0 is this one, 1 the other. The other's motion is
    /// stretched to this one's time.
    ///
    /// # Errors
    /// A weight outside of 0 to 1, or a clip that the model cannot encode.
    pub fn blend(&mut self, model: &MotionSpline, other: &MotionClip, weight: f64) -> Result<(), RepresentationError> {
        range("weight", weight, 0.0, 1.0)?;
        let (own, others) = (self.clip.seconds(), other.seconds());
        if !(own > 0.0 && others > 0.0) {
            return Err(wrong("clips to blend", "two frames or more", "one").into());
        }
        // As many frames, played in the same time.
        let stretched = MotionClip { fps: other.fps * others / own, ..other.clone() };
        let other = Self::encode(model, &stretched)?;
        if self.segments.len() != other.segments.len() {
            // Clips as long as each other have as many segments, unless rounding says otherwise.
            return Err(wrong("segments to blend", &self.segments.len().to_string(), other.segments.len()).into());
        }
        let mix = |a: f64, b: f64| a + weight * (b - a);
        let pairs = self.segments.iter_mut().zip(&other.segments);
        for (a, b) in pairs.flat_map(|(a, b)| a.control_points.iter_mut().zip(&b.control_points)) {
            a.iter_mut().zip(b).for_each(|(a, b)| *a = mix(f64::from(*a), f64::from(*b)) as f32);
        }
        let width = self.detail.width();
        let mut row = vec![0.0; width];
        for (frame, detail) in self.detail.rows.chunks_exact_mut(width).enumerate() {
            other.detail.write_at(frame as f64 / self.clip.fps * stretched.fps, &mut row);
            detail.iter_mut().zip(&row).for_each(|(a, b)| *a = mix(*a, *b));
        }
        Ok(())
    }

    /// Returns the motion that the control points make. It begins where the clip begins; whether its end meets its
    /// begin is not known.
    ///
    /// # Errors
    /// A rate or speed out of range.
    pub fn play(&self, model: &MotionSpline, playing: &Playing) -> Result<MotionClip, RepresentationError> {
        range("fps", playing.fps, 1.0, 1000.0)?;
        range("speed", playing.speed, 0.1, 10.0)?;
        let mut poses = self.made(model, playing)?;
        if playing.detail {
            let mut detail = vec![0.0; poses.width()];
            let step = playing.speed * self.clip.fps / playing.fps;
            for (frame, row) in poses.rows.chunks_exact_mut(detail.len()).enumerate() {
                self.detail.write_at(frame as f64 * step, &mut detail);
                row.iter_mut().zip(&detail).for_each(|(x, detail)| *x += detail);
            }
        }
        Ok(MotionClip { cyclic: false, ..self.finished(model, poses, playing) })
    }

    /// Returns the clip itself, played like that: what an edit is to be compared with.
    ///
    /// # Errors
    /// A rate or speed out of range.
    pub fn original(&self, model: &MotionSpline, playing: &Playing) -> Result<MotionClip, RepresentationError> {
        range("fps", playing.fps, 1.0, 1000.0)?;
        range("speed", playing.speed, 0.1, 10.0)?;
        let mut poses = Poses { fps: playing.fps, joints: self.poses.joints, rows: Vec::new() };
        let mut row = vec![0.0; self.poses.width()];
        for frame in 0..self.frames(playing) {
            self.poses.write_at(frame as f64 * playing.speed * self.clip.fps / playing.fps, &mut row);
            poses.rows.extend(&row);
        }
        Ok(self.finished(model, poses, playing))
    }

    fn frames(&self, playing: &Playing) -> usize {
        (self.clip.seconds() / playing.speed * playing.fps + 1e-6).floor() as usize + 1
    }

    /// Rates as the speed makes them, and contacts from the nearest frame.
    fn finished(&self, model: &MotionSpline, mut poses: Poses, playing: &Playing) -> MotionClip {
        let width = poses.width();
        for row in poses.rows.chunks_exact_mut(width) {
            row[Poses::RATES].iter_mut().for_each(|rate| *rate *= playing.speed);
        }
        let mut clip = poses.to_clip(&self.clip);
        clip.joint_names = model.joints().to_vec();
        clip.contacts = self.clip.contacts.as_ref().map(|contacts| {
            let places = contacts.names.len();
            let frame_at = |frame: usize| {
                let (before, share) =
                    locate(frame as f64 * playing.speed * self.clip.fps / playing.fps, self.clip.len());
                if share < 0.5 { before } else { (before + 1).min(self.clip.len() - 1) }
            };
            let flags = (0..clip.len()).flat_map(|f| contacts.flags[frame_at(f) * places..][..places].iter().copied());
            Contacts { names: contacts.names.clone(), flags: flags.collect() }
        });
        clip
    }

    /// Poses of the control points alone, rates as at speed 1.
    fn made(&self, model: &MotionSpline, playing: &Playing) -> Result<Poses, RepresentationError> {
        let (plan, width) = (model.plan(), self.poses.width());
        let (frames, last) = (self.frames(playing), (plan.frames - 1) as f64);
        let mut sums = vec![0.0; frames * width];
        let mut weights = vec![0.0; frames];
        let ends = self.segments.len().saturating_sub(1);
        for (k, segment) in self.segments.iter().enumerate() {
            // In frames of the network since the segment's begin.
            let place = |frame: usize| (frame as f64 / playing.fps * playing.speed - segment.start) * plan.frame_rate;
            // Beyond the last segment, if only by rounding or half a frame, its last pose stands.
            let inside = |p: &f64| (*p >= 0.0 || k == 0) && (*p <= last || k == ends);
            let here: Vec<(usize, f64)> =
                (0..frames).map(|frame| (frame, place(frame))).filter(|(_, p)| inside(p)).collect();
            if here.is_empty() {
                continue;
            }
            let sampling = Sampling::at(here.iter().map(|(_, p)| p.clamp(0.0, last)).collect(), plan.frames);
            let control: Vec<f32> = segment.control_points.iter().flatten().copied().collect();
            let rows = model.poses_at(&control, &sampling)?;
            for ((frame, p), row) in here.into_iter().zip(rows.chunks_exact(width)) {
                let ramp = (OVERLAP * plan.frames as f64).max(1.0);
                let rise = if k == 0 { 1.0 } else { smooth((p + 1.0) / ramp) };
                let fall = if k == ends { 1.0 } else { smooth((last + 1.0 - p) / ramp) };
                weights[frame] += rise * fall;
                sums[frame * width..][..width].iter_mut().zip(row).for_each(|(sum, x)| *sum += rise * fall * x);
            }
        }
        for (row, weight) in sums.chunks_exact_mut(width).zip(&weights) {
            row.iter_mut().for_each(|x| *x /= weight.max(1e-12));
        }
        Ok(Poses { fps: playing.fps, joints: self.poses.joints, rows: sums })
    }

    /// Returns the reconstruction errors of the clip from its control points alone, at its own rate.
    ///
    /// # Errors
    /// Rows that cannot be made.
    pub fn errors(&self, model: &MotionSpline) -> Result<ClipErrors, RepresentationError> {
        let made = self.made(model, &Playing { fps: self.clip.fps, speed: 1.0, detail: false })?;
        let width = made.width();
        let rms = |columns: std::ops::Range<usize>| {
            let rows = made.rows.chunks_exact(width).zip(self.poses.rows.chunks_exact(width));
            let squares = rows.flat_map(|(a, b)| a[columns.clone()].iter().zip(&b[columns.clone()]));
            let count = (made.len() * columns.len()).max(1) as f64;
            (squares.map(|(a, b)| (a - b).powi(2)).sum::<f64>() / count).sqrt()
        };
        let [height, _, velocity, _] = Poses::KINDS;
        Ok(ClipErrors {
            clip: self.clip.name.clone(),
            frames: self.clip.len(),
            joints_deg: rms(Poses::ROOT..width).to_degrees(),
            height_mm: 1000.0 * rms(height),
            velocity: rms(velocity),
        })
    }
}

/// Returns the first frames of segments that lie evenly over `len` frames and overlap by [`OVERLAP`] or more.
fn starts(len: usize, frames: usize) -> Vec<usize> {
    let beyond = len.saturating_sub(frames);
    let stride = ((1.0 - OVERLAP) * frames as f64).floor().max(1.0);
    let steps = (beyond as f64 / stride).ceil();
    (0..=steps as usize).map(|i| (i as f64 * beyond as f64 / steps.max(1.0)).round() as usize).collect()
}

/// Rises from 0 to 1 with level ends.
fn smooth(x: f64) -> f64 {
    let x = x.clamp(0.0, 1.0);
    x * x * (3.0 - 2.0 * x)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::super::testing::{model, walk};
    use super::*;

    fn same(a: &MotionClip, b: &MotionClip, tolerance: f64) {
        assert_eq!((a.len(), a.fps, &a.joint_names), (b.len(), b.fps, &b.joint_names));
        for frame in 0..a.len() {
            assert!((a.root_position[frame] - b.root_position[frame]).norm() < tolerance, "place of frame {frame}");
            let turn = a.root_orientation[frame].angle_to(&b.root_orientation[frame]);
            assert!(turn < tolerance.max(1e-6), "turn of frame {frame}");
            let joints = a.joints_at(frame).iter().zip(b.joints_at(frame));
            assert!(joints.clone().all(|(a, b)| (a - b).abs() < tolerance), "joints of frame {frame}");
        }
    }

    #[test]
    fn unchanged_control_points_give_the_clip() {
        let model = model();
        for frames in [20, 50, 51, 130, 400] {
            let clip = walk("walk", frames, 50.0);
            let splined = SplinedClip::encode(&model, &clip).unwrap();
            let playing = Playing { fps: 50.0, speed: 1.0, detail: true };
            same(&splined.play(&model, &playing).unwrap(), &clip, 1e-9);
            assert_eq!(splined.original(&model, &playing).unwrap().contacts, clip.contacts);
            let alone = splined.play(&model, &Playing { detail: false, ..playing }).unwrap();
            assert_eq!(alone.len(), clip.len());
            assert_ne!(alone.joints, clip.joints, "an untrained network makes something else");
        }
    }

    #[test]
    fn twice_the_speed_is_the_same_way_in_half_the_time() {
        let model = model();
        let clip = walk("walk", 201, 50.0);
        let splined = SplinedClip::encode(&model, &clip).unwrap();
        let at = |speed| Playing { fps: 50.0, speed, detail: false };
        let fast = splined.original(&model, &at(2.0)).unwrap();
        assert_eq!(fast.len(), 101);
        // What is the same at every speed: joints, height, tilt. The way over the ground is summed up in other steps.
        for frame in 0..101 {
            let joints = fast.joints_at(frame).iter().zip(clip.joints_at(2 * frame));
            assert!(joints.clone().all(|(a, b)| (a - b).abs() < 1e-9), "frame {frame}");
            assert!((fast.root_position[frame].z - clip.root_position[2 * frame].z).abs() < 1e-9, "frame {frame}");
        }
        let way = |clip: &MotionClip| (clip.root_position[clip.len() - 1] - clip.root_position[0]).norm();
        assert!((way(&fast) / way(&clip) - 1.0).abs() < 0.01, "{} {}", way(&fast), way(&clip));
        // From control points: the same places of the same curves, and nothing else between them.
        let (slow, fast) = (splined.made(&model, &at(1.0)).unwrap(), splined.made(&model, &at(2.0)).unwrap());
        let dense = splined.made(&model, &Playing { fps: 25.0, ..at(1.0) }).unwrap();
        assert_eq!((slow.len(), fast.len(), &fast.rows), (201, 101, &dense.rows));
    }

    #[test]
    fn blending_goes_from_one_to_the_other() {
        let model = model();
        let (a, b) = (walk("a", 150, 50.0), walk("b", 90, 50.0));
        let playing = Playing { fps: 50.0, speed: 1.0, detail: true };
        let blended = |weight| {
            let mut splined = SplinedClip::encode(&model, &a).unwrap();
            splined.blend(&model, &b, weight).unwrap();
            splined.play(&model, &playing).unwrap()
        };
        same(&blended(0.0), &a, 1e-9);
        // The other clip in this one's time: its last joints at its end.
        let whole = blended(1.0);
        let (got, expected) = (whole.joints_at(149), b.joints_at(89));
        assert!(got.iter().zip(expected).all(|(a, b)| (a - b).abs() < 0.02), "{got:?} {expected:?}");
        assert!(SplinedClip::encode(&model, &a).unwrap().blend(&model, &b, 1.5).is_err());
    }

    #[test]
    fn segments_lie_evenly_and_overlap() {
        assert_eq!(starts(10, 50), [0]);
        assert_eq!(starts(50, 50), [0]);
        assert_eq!(starts(51, 50), [0, 1]);
        for len in [51, 93, 94, 137, 1000] {
            let starts = starts(len, 50);
            assert_eq!((starts[0], starts[starts.len() - 1] + 50), (0, len));
            assert!(starts.windows(2).all(|pair| pair[1] - pair[0] <= 44), "{starts:?}");
        }
    }

    #[test]
    fn control_points_of_another_shape_are_refused() {
        let model = model();
        let mut splined = SplinedClip::encode(&model, &walk("walk", 60, 50.0)).unwrap();
        let own = splined.segments().to_vec();
        assert!(splined.set_segments(own.clone()).is_ok());
        let mut broken = own.clone();
        broken[0].control_points[1][2] = f32::NAN;
        assert!(splined.set_segments(broken).unwrap_err().to_string().contains("segment 0"));
        let mut short = own;
        short[0].control_points.pop();
        let error = splined.set_segments(short).unwrap_err().to_string();
        assert!(error.contains("segment 0: expected [5, 5, 5, 5], got [5, 5, 5]"), "{error}");
    }
}
