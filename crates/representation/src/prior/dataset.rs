//! Clips as a supply of normalised windows.

use lifelike_checkpoint::rng::stream;
use lifelike_motion::window::{WindowSpec, write_window};
use lifelike_motion::{FeatureLayout, Frame};
use rand::Rng;
use rand::seq::SliceRandom;
use sha2::{Digest, Sha256};

use super::statistics::{FeatureStatistics, StdFloors};
use super::window_plan::WindowPlan;
use crate::{FromInput, RepresentationError};

/// A clip of the data set: its name and its frames at the plan's frame rate.
#[derive(Debug, Clone, PartialEq)]
pub struct PriorClip {
    /// Name, for reports and to find a changed data set.
    pub name: String,
    /// Frames at [`WindowPlan::frame_rate`], one after another.
    pub frames: Vec<Frame>,
}

impl PriorClip {
    /// Checks that every frame has the layout's joints and end effectors and nothing but finite numbers.
    ///
    /// # Errors
    /// Names the clip and the first wrong frame.
    pub fn check(&self, layout: &FeatureLayout) -> Result<(), RepresentationError> {
        let mismatch = |what: String, expected: String, got: String| RepresentationError::mismatch(what, expected, got);
        if self.frames.is_empty() {
            return Err(mismatch(format!("clip {}", self.name), "frames".into(), "none".into()));
        }
        match layout.first_misfit(&self.frames) {
            Some((i, expected, got)) => Err(mismatch(format!("clip {}, frame {i}", self.name), expected, got)),
            None => Ok(()),
        }
    }
}

/// Sets part of the clips aside: `(training, held out)`. Which ones depends on the plan's seed and the number of clips.
/// With two clips or more and `held_out > 0` there is at least one on each side.
pub fn split(plan: &WindowPlan, clips: Vec<PriorClip>) -> (Vec<PriorClip>, Vec<PriorClip>) {
    let n = clips.len();
    if n < 2 || plan.held_out <= 0.0 {
        return (clips, Vec::new());
    }
    let count = ((n as f64 * plan.held_out).round() as usize).clamp(1, n - 1);
    let mut order: Vec<usize> = (0..n).collect();
    order.shuffle(&mut stream(plan.seed, "prior.held_out", 0, 0));
    let chosen = &order[..count];
    let (mut train, mut aside) = (Vec::new(), Vec::new());
    for (i, clip) in clips.into_iter().enumerate() {
        if chosen.contains(&i) { aside.push(clip) } else { train.push(clip) }
    }
    (train, aside)
}

/// Clips from which windows are drawn.
#[derive(Debug)]
pub struct Windows {
    clips: Vec<PriorClip>,
    /// Index of each clip's first frame among all frames.
    starts: Vec<usize>,
    frames: usize,
    frame_rate: f64,
    spec: WindowSpec,
    size: usize,
}

impl Windows {
    /// # Errors
    /// A clip that does not fit the layout.
    pub fn new(plan: &WindowPlan, layout: &FeatureLayout, clips: Vec<PriorClip>) -> Result<Self, RepresentationError> {
        let mut starts = Vec::with_capacity(clips.len());
        let mut frames = 0;
        for clip in &clips {
            clip.check(layout)?;
            starts.push(frames);
            frames += clip.frames.len();
        }
        let (frame_rate, spec, size) = (plan.frame_rate, plan.window(), layout.size());
        Ok(Self { clips, starts, frames, frame_rate, spec, size })
    }

    /// As [`Self::new`], of clips that there must be.
    ///
    /// # Errors
    /// No frames, or a clip that does not fit the layout.
    pub(super) fn to_train_on(
        plan: &WindowPlan,
        layout: &FeatureLayout,
        clips: Vec<PriorClip>,
    ) -> Result<Self, RepresentationError> {
        let windows = Self::new(plan, layout, clips)?;
        if windows.is_empty() {
            return Err(RepresentationError::mismatch("training clips", "at least one frame", "none"));
        }
        Ok(windows)
    }

    /// Returns mean and standard deviation of the features of all frames.
    pub(super) fn statistics(&self, layout: &FeatureLayout, floors: &StdFloors) -> FeatureStatistics {
        FeatureStatistics::of(layout, floors, self.clips.iter().flat_map(|c| &c.frames))
    }

    /// Returns the clips.
    pub fn clips(&self) -> &[PriorClip] {
        &self.clips
    }

    /// Frames of all clips, each of which is the centre of a window.
    pub fn len(&self) -> usize {
        self.frames
    }

    /// Returns whether there is nothing to draw from.
    pub fn is_empty(&self) -> bool {
        self.frames == 0
    }

    /// Returns SHA-256 of everything the clips say, to notice a changed data set when resuming.
    pub fn digest(&self) -> String {
        let mut hash = Sha256::new();
        let mut row = vec![0.0; self.size];
        for clip in &self.clips {
            hash.update((clip.name.len() as u64).to_le_bytes());
            hash.update(clip.name.as_bytes());
            for frame in &clip.frames {
                frame.write_features(&frame.root_orientation, &mut row);
                row.iter().for_each(|x| hash.update(x.to_le_bytes()));
                hash.update(frame.root_orientation.coords.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>());
            }
        }
        hash.finalize().iter().map(|b| format!("{b:02x}")).collect()
    }

    /// Draws `count` windows around frames drawn uniformly from all frames of all clips, normalised, row after row.
    ///
    /// # Shapes
    /// `[count, 2W + 1, F]`.
    pub fn sample(
        &self,
        statistics: &FeatureStatistics,
        count: usize,
        rng: &mut impl Rng,
    ) -> Result<Vec<f32>, RepresentationError> {
        self.gather(statistics, &self.draw(count, rng))
    }

    /// Frames drawn uniformly, numbered through all clips.
    pub(super) fn draw(&self, count: usize, rng: &mut impl Rng) -> Vec<usize> {
        (0..count).map(|_| rng.random_range(0..self.frames.max(1))).collect()
    }

    /// Returns the windows around these frames (numbered through all clips), normalised, row after row.
    pub fn gather(&self, statistics: &FeatureStatistics, centres: &[usize]) -> Result<Vec<f32>, RepresentationError> {
        let mut window = vec![0.0; self.spec.len() * self.size];
        let mut out = Vec::with_capacity(centres.len() * window.len());
        for &centre in centres {
            let clip = self.starts.partition_point(|s| *s <= centre).saturating_sub(1);
            let (Some(c), Some(start)) = (self.clips.get(clip), self.starts.get(clip)) else { continue };
            normalized_window(&c.frames, self.frame_rate, centre - start, self.spec, statistics, &mut window)?;
            out.extend(window.iter().map(|x| *x as f32));
        }
        Ok(out)
    }
}

/// Writes one normalised window around a frame.
pub(super) fn normalized_window(
    frames: &[Frame],
    frame_rate: f64,
    centre: usize,
    spec: WindowSpec,
    statistics: &FeatureStatistics,
    out: &mut [f64],
) -> Result<(), RepresentationError> {
    write_window(frames, frame_rate, centre as f64 / frame_rate, spec, out)?;
    statistics.normalize(out);
    Ok(())
}
