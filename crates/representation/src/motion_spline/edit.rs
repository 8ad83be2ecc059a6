//! Edits of control points (thesis 3.3.3: "closer or further away from the end-points", "toned down or amplified").

use super::model::{MotionSpline, Usual};
use super::splined::{Segment, SplinedClip};
use crate::RepresentationError;
use lifelike_train::limits::{range, wrong};

/// A change of control points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Edit {
    /// Inner points further from (above 1) or closer to (below 1) the end point that is nearer along the curve. The
    /// way between them, on average over the training motion, is not scaled. With 0 each segment only goes from its
    /// first latent code to its last one, as segments usually go. Without that way, the numbers of the progress along
    /// the segment would stand still and then leap in the middle, and the motion with them.
    Reach(f64),
    /// Every point further from (above 1) or closer to (below 1) where that point lies on average over the training motion:
    /// exaggerates what makes this motion differ from others, or tones it down. Not the segment's own mean: some numbers of a
    /// trained space only say how far along the segment one is, and those must stay.
    Gain(f64),
    /// One number of one control point changed.
    Move {
        /// The control point, from 0.
        point: usize,
        /// Its number, from 0.
        number: usize,
        /// By how many of the standard deviations that it has over the training motion: numbers of latent spaces have
        /// no size of their own.
        by: f64,
    },
}

impl SplinedClip {
    /// Applies a change to some segments, or to all where none are named.
    ///
    /// # Errors
    /// A segment, point or number that is not there; a factor below 0 or above 10.
    pub fn edit(&mut self, model: &MotionSpline, edit: Edit, segments: &[usize]) -> Result<(), RepresentationError> {
        let count = self.segments().len();
        if let Some(beyond) = segments.iter().find(|k| **k >= count) {
            return Err(wrong("segment", &format!("0 to {}", count - 1), beyond).into());
        }
        match edit {
            Edit::Reach(factor) => range("reach", factor, 0.0, 10.0)?,
            Edit::Gain(factor) => range("gain", factor, 0.0, 10.0)?,
            Edit::Move { point, number, by } => {
                let points = self.segments().first().map_or(&[][..], |s| &s.control_points);
                let numbers = points.first().map_or(0, Vec::len);
                if point >= points.len() || number >= numbers {
                    let expected = format!("a point below {} and a number below {numbers}", points.len());
                    return Err(wrong("move", &expected, format!("{point}:{number}")).into());
                }
                range("move", by, -1e3, 1e3)?;
            }
        }
        let chosen = |k: &usize| segments.is_empty() || segments.contains(k);
        self.segments_mut()
            .iter_mut()
            .enumerate()
            .filter(|(k, _)| chosen(k))
            .for_each(|(_, s)| edit.apply(s, model.usual()));
        Ok(())
    }
}

impl Edit {
    fn apply(self, segment: &mut Segment, usual: &Usual) {
        let points = &mut segment.control_points;
        let count = points.len();
        match self {
            Self::Reach(factor) => {
                let (first, last) = (points[0].clone(), points[count - 1].clone());
                for (i, (point, mean)) in points.iter_mut().zip(&usual.mean).enumerate() {
                    let (end, usual_end) =
                        if 2 * i < count { (&first, &usual.mean[0]) } else { (&last, &usual.mean[count - 1]) };
                    let way = mean.iter().zip(usual_end).map(|(mean, end)| mean - end);
                    let centre: Vec<f32> = end.iter().zip(way).map(|(end, way)| end + way).collect();
                    away(point, &centre, factor);
                }
            }
            Self::Gain(factor) => {
                points.iter_mut().zip(&usual.mean).for_each(|(point, mean)| away(point, mean, factor))
            }
            Self::Move { point, number, by } => points[point][number] += by as f32 * usual.deviation[point][number],
        }
    }
}

/// Moves a point along the line from `centre`.
fn away(point: &mut [f32], centre: &[f32], factor: f64) {
    point.iter_mut().zip(centre).for_each(|(x, c)| *x = c + (factor as f32) * (*x - c));
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::super::testing::{model, walk};
    use super::*;

    fn segment() -> Segment {
        Segment { start: 0.0, control_points: vec![vec![0.0, 1.0], vec![1.0, 1.0], vec![2.0, 3.0], vec![4.0, 3.0]] }
    }

    fn edited(edit: Edit) -> Vec<Vec<f32>> {
        let mut segment = segment();
        let mean = vec![vec![1.0, 1.0], vec![1.0, 1.5], vec![1.5, 2.0], vec![2.0, 2.0]];
        let deviation = vec![vec![1.0, 1.0], vec![1.0, 1.0], vec![1.0, 3.0], vec![1.0, 1.0]];
        edit.apply(&mut segment, &Usual { mean, deviation });
        segment.control_points
    }

    #[test]
    fn by_hand() {
        // Inner points usually lie (0, 0.5) from the first and (-0.5, 0) from the last.
        assert_eq!(edited(Edit::Reach(0.0)), [[0.0, 1.0], [0.0, 1.5], [3.5, 3.0], [4.0, 3.0]]);
        assert_eq!(edited(Edit::Reach(0.5)), [[0.0, 1.0], [0.5, 1.25], [2.75, 3.0], [4.0, 3.0]]);
        assert_eq!(edited(Edit::Reach(1.0)), segment().control_points);
        assert_eq!(edited(Edit::Gain(2.0)), [[-1.0, 1.0], [1.0, 0.5], [2.5, 4.0], [6.0, 4.0]]);
        assert_eq!(edited(Edit::Gain(0.0)), [[1.0, 1.0], [1.0, 1.5], [1.5, 2.0], [2.0, 2.0]]);
        assert_eq!(edited(Edit::Gain(1.0)), segment().control_points);
        let moved = edited(Edit::Move { point: 2, number: 1, by: -0.5 });
        assert_eq!(moved, [[0.0, 1.0], [1.0, 1.0], [2.0, 1.5], [4.0, 3.0]]);
    }

    #[test]
    fn only_chosen_segments_change_and_what_is_not_there_is_refused() {
        let model = model();
        let mut clip = SplinedClip::encode(&model, &walk("walk", 300, 50.0)).unwrap();
        let before = clip.segments().to_vec();
        assert!(before.len() >= 3);
        clip.edit(&model, Edit::Gain(1.5), &[1]).unwrap();
        for (k, (a, b)) in before.iter().zip(clip.segments()).enumerate() {
            assert_eq!(a != b, k == 1);
        }
        let error = |clip: &mut SplinedClip, edit, segments: &[usize]| {
            clip.edit(&model, edit, segments).unwrap_err().to_string()
        };
        let last = before.len() - 1;
        assert_eq!(error(&mut clip, Edit::Gain(1.0), &[9]), format!("plan: segment: expected 0 to {last}, got 9"));
        assert!(error(&mut clip, Edit::Reach(f64::NAN), &[]).contains("reach"));
        let nowhere = Edit::Move { point: 4, number: 0, by: 1.0 };
        assert!(error(&mut clip, nowhere, &[]).contains("a point below 4"));
    }
}
