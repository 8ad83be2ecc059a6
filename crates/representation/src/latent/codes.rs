//! Codes of clips, whoever made them.

use std::ops::Range;

use lifelike_motion::FeatureLayout;

use crate::{FromInput, RepresentationError};
use crate::{MotionPrior, PriorClip};

/// One code per frame of some clips: a motion prior's, or those of an encoder that was trained together with a policy.
#[derive(Debug, Clone, PartialEq)]
pub struct Codes {
    names: Vec<String>,
    starts: Vec<usize>,
    rows: Vec<f32>,
    dimension: usize,
    fps: f64,
}

impl Codes {
    /// Codes, clip after clip: `starts` are the first row of each clip, and T at the end (as in a reference library).
    /// `fps` is the number of codes per second.
    ///
    /// # Shapes
    /// `rows: [T, dimension]`.
    ///
    /// # Errors
    /// Numbers of names, starts and rows that do not fit together, a rate that is not positive, and codes that are not
    /// finite.
    pub fn new(
        names: Vec<String>,
        starts: Vec<usize>,
        rows: Vec<f32>,
        dimension: usize,
        fps: f64,
    ) -> Result<Self, RepresentationError> {
        let wrong = |what: &str, expected: String, got: String| {
            Err(RepresentationError::mismatch(format!("latent codes: {what}"), expected, got))
        };
        if dimension == 0 {
            return wrong("dimension", "at least 1".into(), "0".into());
        }
        if !(fps.is_finite() && fps > 0.0) {
            return wrong("rate", "codes per second above 0".into(), fps.to_string());
        }
        if starts.len() != names.len() + 1 || starts[0] != 0 || starts.windows(2).any(|w| w[1] < w[0]) {
            let expected = format!("{} ascending row numbers from 0", names.len() + 1);
            return wrong("clip boundaries", expected, format!("{} of them, from {:?}", starts.len(), starts.first()));
        }
        let frames = starts[names.len()];
        if frames.checked_mul(dimension) != Some(rows.len()) {
            return wrong("rows", format!("{frames} x {dimension} numbers"), rows.len().to_string());
        }
        if let Some(at) = rows.iter().position(|x| !x.is_finite()) {
            return wrong("rows", "finite numbers".into(), format!("{} in row {}", rows[at], at / dimension));
        }
        Ok(Self { names, starts, rows, dimension, fps })
    }

    /// Encodes clips at the prior's frame rate.
    ///
    /// # Errors
    /// A clip that does not fit the prior.
    pub fn of_prior(prior: &MotionPrior, clips: &[PriorClip]) -> Result<Self, RepresentationError> {
        let (mut rows, mut starts) = (Vec::new(), vec![0]);
        for clip in clips {
            clip.check(prior.layout())?;
            rows.extend(prior.encode_clip(&clip.frames)?);
            starts.push(rows.len() / prior.latent_size());
        }
        let names = clips.iter().map(|c| c.name.clone()).collect();
        Self::new(names, starts, rows, prior.latent_size(), prior.windows().frame_rate)
    }

    /// Returns the number of codes T.
    pub fn len(&self) -> usize {
        self.rows.len() / self.dimension
    }

    /// Returns whether there are none.
    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// Returns d_z.
    pub fn dimension(&self) -> usize {
        self.dimension
    }

    /// Codes per second.
    pub fn fps(&self) -> f64 {
        self.fps
    }

    /// Names of the clips.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// Returns the rows of each clip.
    pub fn clips(&self) -> impl Iterator<Item = Range<usize>> {
        self.starts.windows(2).map(|w| w[0]..w[1])
    }

    /// Returns all codes, `[T, d]`.
    pub fn rows(&self) -> &[f32] {
        &self.rows
    }

    /// Returns one code, `[d]`.
    pub fn row(&self, frame: usize) -> &[f32] {
        &self.rows[frame * self.dimension..(frame + 1) * self.dimension]
    }
}

/// Features of every frame in its own heading frame (eq. 4.1), in SI units: the state that codes are compared with.
///
/// # Shapes
/// `[T, F]`, clip after clip.
pub fn features_of(clips: &[PriorClip], layout: &FeatureLayout) -> Result<Vec<f32>, RepresentationError> {
    let mut row = vec![0.0; layout.size()];
    let mut out = Vec::new();
    for clip in clips {
        clip.check(layout)?;
        for frame in &clip.frames {
            frame.write_features(&frame.root_orientation, &mut row);
            out.extend(row.iter().map(|x| *x as f32));
        }
    }
    Ok(out)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn rows_belong_to_clips() {
        let names = || vec!["a".to_string(), "b".to_string()];
        let codes = Codes::new(names(), vec![0, 1, 3], vec![1.0, 2.0, 3.0, 4.0, 5.0, 6.0], 2, 50.0).unwrap();
        assert_eq!((codes.len(), codes.row(2)), (3, &[5.0, 6.0][..]));
        assert_eq!(codes.clips().collect::<Vec<_>>(), [0..1, 1..3]);
        let wrong = |starts: Vec<usize>, rows: Vec<f32>, dimension, fps| {
            Codes::new(names(), starts, rows, dimension, fps).unwrap_err().to_string()
        };
        assert!(wrong(vec![0, 3], vec![0.0; 6], 2, 50.0).contains("boundaries"));
        assert!(wrong(vec![0, 4, 3], vec![0.0; 6], 2, 50.0).contains("boundaries"));
        assert!(wrong(vec![0, 1, 3], vec![0.0; 5], 2, 50.0).contains("3 x 2"));
        assert!(wrong(vec![0, 1, 3], vec![0.0; 6], 2, 0.0).contains("rate"));
        assert!(wrong(vec![0, 1, 3], vec![], 0, 50.0).contains("dimension"));
        assert!(wrong(vec![0, 1, 3], vec![0.0, 0.0, f32::NAN, 0.0, 0.0, 0.0], 2, 50.0).contains("row 1"));
    }
}
