//! Tokens of the denoiser: rows of the representation, or control points of splines through them.
//!
//! Both are linear, so [`MotionSpace::transposed`] turns a gradient by rows into one by tokens.

mod basis;

use crate::representation::{FeatureMatrix, RepresentationSpec};
use crate::{FromInput, GenerationError};
use basis::Basis;

/// The kind of tokens.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields, tag = "kind")]
pub enum SpaceKind {
    /// Every row is a token (MDM).
    Frames,
    /// Control points of cubic B-splines, fitted by least squares.
    Spline {
        /// Time between knots, stretched a little so that a motion is a whole number of spans (s).
        #[schemars(extend("unit" = "s"), range(min = 0.05, max = 2.0))]
        knot_seconds: f64,
    },
}

impl Default for SpaceKind {
    /// Splines with a knot every 0.2 s: a fourth of the rows.
    fn default() -> Self {
        Self::Spline { knot_seconds: 0.2 }
    }
}

/// Rows as tokens, and back.
#[derive(Debug, Clone, PartialEq)]
pub struct MotionSpace {
    spec: RepresentationSpec,
    kind: SpaceKind,
}

impl MotionSpace {
    /// Returns a space of these rows.
    pub fn new(spec: RepresentationSpec, kind: SpaceKind) -> Self {
        Self { spec, kind }
    }

    /// Returns the layout of the rows.
    pub fn spec(&self) -> &RepresentationSpec {
        &self.spec
    }

    /// Returns the kind of its tokens.
    pub fn kind(&self) -> SpaceKind {
        self.kind
    }

    /// Returns the numbers of a token. Control points leave out joint velocities, which are the curve's derivative.
    pub fn width(&self) -> usize {
        match self.kind {
            SpaceKind::Frames => self.spec.width(),
            SpaceKind::Spline { .. } => 7 + self.spec.joints(),
        }
    }

    /// Returns the number of tokens for a number of rows.
    pub fn tokens(&self, rows: usize) -> usize {
        match self.basis(rows) {
            None => rows,
            Some(basis) => basis.control_points(),
        }
    }

    fn basis(&self, rows: usize) -> Option<Basis> {
        match self.kind {
            SpaceKind::Frames => None,
            SpaceKind::Spline { knot_seconds } => Some(Basis::new(rows, self.spec.fps, knot_seconds)),
        }
    }

    /// Returns a motion's tokens, `[tokens, width]`.
    ///
    /// # Errors
    /// [`GenerationError::Input`] for rows of another width, or none.
    pub fn encode(&self, motion: &FeatureMatrix) -> Result<Vec<f32>, GenerationError> {
        self.check(motion)?;
        let Some(basis) = self.basis(motion.n) else { return Ok(motion.rows.clone()) };
        let curves = 7 + self.spec.joints();
        let rows = motion.rows.chunks_exact(motion.width).flat_map(|row| &row[..curves]);
        Ok(basis.fit(&rows.map(|x| f64::from(*x)).collect::<Vec<_>>(), curves))
    }

    /// Returns the tokens of a motion of that length which begins with these rows, and how many of them the beginning settles.
    /// The others are what it leads to by itself, to be replaced.
    ///
    /// # Errors
    /// [`GenerationError::Input`] for rows of another width, none, or more than the motion has.
    pub fn beginning(&self, rows: &FeatureMatrix, of: usize) -> Result<(Vec<f32>, usize), GenerationError> {
        self.check(rows)?;
        if rows.n > of {
            return Err(GenerationError::mismatch("rows that a motion begins with", format!("at most {of}"), rows.n));
        }
        let Some(basis) = self.basis(of) else {
            let mut tokens = rows.rows.clone();
            tokens.resize(of * self.width(), 0.0);
            return Ok((tokens, rows.n));
        };
        let curves = self.width();
        let numbers = rows.rows.chunks_exact(rows.width).flat_map(|row| &row[..curves]);
        let tokens = basis.fit(&numbers.map(|x| f64::from(*x)).collect::<Vec<_>>(), curves);
        Ok((tokens, basis.settled(rows.n)))
    }

    /// Returns the tokens that alone decide a row of a motion of that length.
    pub fn around(&self, row: usize, rows: usize) -> std::ops::Range<usize> {
        match self.basis(rows) {
            None => row..row + 1,
            Some(basis) => basis.around(row),
        }
    }

    /// Returns the rows of tokens.
    ///
    /// # Errors
    /// [`GenerationError::Input`] for another number of tokens than these rows have.
    pub fn decode(&self, tokens: &[f32], rows: usize) -> Result<FeatureMatrix, GenerationError> {
        let expected = self.tokens(rows) * self.width();
        if rows == 0 || tokens.len() != expected {
            let what = format!("tokens of {rows} rows");
            return Err(GenerationError::mismatch(what, format!("{expected} numbers"), tokens.len()));
        }
        let Some(basis) = self.basis(rows) else { return FeatureMatrix::new(tokens.to_vec(), self.width()) };
        let (curves, width) = (self.width(), self.spec.width());
        let [values, rates] = [0, 1].map(|derivative| basis.evaluate(tokens, curves, derivative));
        let mut out = Vec::with_capacity(rows * width);
        for (values, rates) in values.chunks_exact(curves).zip(rates.chunks_exact(curves)) {
            out.extend_from_slice(values);
            out.extend_from_slice(&rates[7..]);
        }
        FeatureMatrix::new(out, width)
    }

    /// Returns the gradient by tokens from the one by rows: the transpose of [`Self::decode`].
    ///
    /// # Errors
    /// [`GenerationError::Input`] for rows of another width, or none.
    pub fn transposed(&self, gradient: &FeatureMatrix) -> Result<Vec<f32>, GenerationError> {
        self.check(gradient)?;
        let Some(basis) = self.basis(gradient.n) else { return Ok(gradient.rows.clone()) };
        let curves = self.width();
        let (mut values, mut rates) = (Vec::new(), Vec::new());
        for row in gradient.rows.chunks_exact(gradient.width) {
            values.extend_from_slice(&row[..curves]);
            rates.extend([0.0; 7]);
            rates.extend_from_slice(&row[curves..]);
        }
        let mut out = basis.transposed(&values, curves, 0);
        out.iter_mut().zip(basis.transposed(&rates, curves, 1)).for_each(|(out, x)| *out += x);
        Ok(out)
    }

    fn check(&self, motion: &FeatureMatrix) -> Result<(), GenerationError> {
        if motion.n > 0 && motion.width == self.spec.width() && motion.rows.len() == motion.n * motion.width {
            return Ok(());
        }
        let got = format!("{} of {}", motion.n, motion.width);
        Err(GenerationError::mismatch("rows of a motion", format!("some of {}", self.spec.width()), got))
    }
}
