//! Linear probes of the near future: what a code knows of it that the present frame does not.
//!
//! A policy that sees m_t and z_t can gain by z_t only what m_t leaves open. The probe predicts the joint positions a
//! while ahead by ridge regression, fitted to some clips and measured on others. Its inputs are each of those of
//! thesis Table 4.3, and controls.

use nalgebra::linalg::Cholesky;
use nalgebra::{DMatrix, DVector};

use super::comparison::Encoded;
use crate::{FromInput, RepresentationError};
use lifelike_checkpoint::rng::stream;
use lifelike_motion::FeatureLayout;
use lifelike_report::{Cell, Column, Table};
use rand::seq::SliceRandom;

/// Times ahead that are predicted (s).
pub const AHEAD: [f64; 4] = [0.1, 0.2, 0.3, 0.5];
/// Penalty of the regression, per row and standardized feature.
const PENALTY: f64 = 1e-3;

/// Input of a probe.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Input {
    /// Joint positions now, taken as the prediction: nothing is fitted.
    Persistence,
    /// The frame m_t (input M of Table 4.3).
    Frame,
    /// The code z_t (L).
    Code,
    /// Both (LM).
    Both,
    /// The frame and the code of another frame, drawn at random: a control with as many numbers.
    Permuted,
}

impl Input {
    /// All inputs, in the table's order.
    pub const ALL: [Self; 5] = [Self::Persistence, Self::Frame, Self::Code, Self::Both, Self::Permuted];

    /// Returns its name in tables.
    pub fn words(self) -> &'static str {
        match self {
            Self::Persistence => "pose stays",
            Self::Frame => "M: frame",
            Self::Code => "L: code",
            Self::Both => "LM: frame and code",
            Self::Permuted => "frame and permuted code",
        }
    }
}

/// Errors of one input.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Probe {
    /// Name of the codes.
    pub codes: String,
    /// The input.
    pub input: Input,
    /// Mean absolute error of the joint positions on the clips that were not fitted, after each time of [`AHEAD`] (deg).
    pub joints_deg: [f64; AHEAD.len()],
}

/// Returns the probes of one space of codes, fitted to `fitted` and measured on `tested`.
///
/// # Errors
/// Features that are not those of the codes, or clips shorter than the longest time ahead.
pub fn probes(
    fitted: &Encoded,
    tested: &Encoded,
    layout: &FeatureLayout,
    seed: u64,
) -> Result<Vec<Probe>, RepresentationError> {
    let mut probes: Vec<Probe> = Input::ALL
        .map(|input| Probe { codes: fitted.name.clone(), input, joints_deg: [f64::NAN; AHEAD.len()] })
        .to_vec();
    for (at, seconds) in AHEAD.into_iter().enumerate() {
        let train = Pairs::new(fitted, layout, seconds, seed)?;
        let test = Pairs::new(tested, layout, seconds, seed + 1)?;
        for probe in &mut probes {
            let predicted = match probe.input {
                Input::Persistence => test.present.clone(),
                input => Regression::fit(&train.input(input), &train.future).predict(&test.input(input)),
            };
            probe.joints_deg[at] = (predicted - &test.future).abs().mean().to_degrees();
        }
    }
    Ok(probes)
}

/// Returns the probes as a table.
pub fn table(probes: &[Probe]) -> Table {
    let ahead = AHEAD.map(|seconds| Column::number(&format!("after {seconds} s"), "deg"));
    let columns = [Column::text("codes"), Column::text("input")].into_iter().chain(ahead).collect();
    let mut table = Table::new("Linear probes of the near future", columns);
    table.caption = "Mean absolute error of joint positions on clips that the regression was not fitted to. A policy that sees the \
                     frame can gain by a code what LM predicts better than M."
        .into();
    let row = |probe: &Probe| {
        let errors = probe.joints_deg.iter().map(|error| Cell::number(*error, 2));
        [Cell::text(&probe.codes), Cell::text(probe.input.words())].into_iter().chain(errors).collect()
    };
    table.rows = probes.iter().map(row).collect();
    table
}

/// Frames with their codes, and the joint positions a while later.
struct Pairs {
    frames: DMatrix<f64>,
    codes: DMatrix<f64>,
    permuted: DMatrix<f64>,
    present: DMatrix<f64>,
    future: DMatrix<f64>,
}

impl Pairs {
    fn new(space: &Encoded, layout: &FeatureLayout, seconds: f64, seed: u64) -> Result<Self, RepresentationError> {
        let (codes, width) = (&space.codes, layout.size());
        if space.features.len() != codes.len() * width {
            let (expected, got) = (format!("{} numbers", codes.len() * width), space.features.len().to_string());
            return Err(RepresentationError::mismatch(format!("features of {}", space.name), expected, got));
        }
        let ahead = (seconds * codes.fps()).round() as usize;
        let rows: Vec<usize> = codes.clips().flat_map(|clip| clip.start..clip.end.saturating_sub(ahead)).collect();
        if rows.is_empty() {
            let expected = format!("clips longer than {seconds} s");
            return Err(RepresentationError::mismatch(format!("clips of {}", space.name), expected, "none"));
        }
        let mut others = rows.clone();
        others.shuffle(&mut stream(seed, "latent.probe", 0, 0));
        let feature = |row: usize, column: usize| f64::from(space.features[row * width + column]);
        let joints = layout.joint_positions();
        let code = |of: &[usize]| {
            DMatrix::from_fn(of.len(), codes.dimension(), |i, column| f64::from(codes.row(of[i])[column]))
        };
        Ok(Self {
            frames: DMatrix::from_fn(rows.len(), width, |i, column| feature(rows[i], column)),
            codes: code(&rows),
            permuted: code(&others),
            present: DMatrix::from_fn(rows.len(), joints.len(), |i, joint| feature(rows[i], joints.start + joint)),
            future: DMatrix::from_fn(rows.len(), joints.len(), |i, joint| {
                feature(rows[i] + ahead, joints.start + joint)
            }),
        })
    }

    fn input(&self, input: Input) -> DMatrix<f64> {
        match input {
            Input::Persistence => self.present.clone(),
            Input::Frame => self.frames.clone(),
            Input::Code => self.codes.clone(),
            Input::Both => beside(&self.frames, &self.codes),
            Input::Permuted => beside(&self.frames, &self.permuted),
        }
    }
}

fn beside(a: &DMatrix<f64>, b: &DMatrix<f64>) -> DMatrix<f64> {
    let mut both = a.clone().resize_horizontally(a.ncols() + b.ncols(), 0.0);
    both.columns_mut(a.ncols(), b.ncols()).copy_from(b);
    both
}

/// Ridge regression of many targets on standardized features.
struct Regression {
    mean: DVector<f64>,
    std: DVector<f64>,
    level: DVector<f64>,
    weights: DMatrix<f64>,
}

impl Regression {
    fn fit(rows: &DMatrix<f64>, targets: &DMatrix<f64>) -> Self {
        let n = rows.nrows() as f64;
        let mean = DVector::from_iterator(rows.ncols(), rows.column_iter().map(|column| column.mean()));
        let deviation = rows.column_iter().map(|column| column.variance().sqrt().max(1e-9));
        let std = DVector::from_iterator(rows.ncols(), deviation);
        let level = DVector::from_iterator(targets.ncols(), targets.column_iter().map(|column| column.mean()));
        let standard = standardized(rows, &mean, &std);
        let mut centred = targets.clone();
        centred.column_iter_mut().zip(level.iter()).for_each(|(mut column, level)| column.add_scalar_mut(-level));
        let mut gram = standard.tr_mul(&standard);
        (0..gram.nrows()).for_each(|i| gram[(i, i)] += PENALTY * n);
        let right = standard.tr_mul(&centred);
        // The penalty makes the matrix positive definite.
        let weights = Cholesky::new(gram).map_or_else(|| right.clone() * 0.0, |solver| solver.solve(&right));
        Self { mean, std, level, weights }
    }

    fn predict(&self, rows: &DMatrix<f64>) -> DMatrix<f64> {
        let mut out = standardized(rows, &self.mean, &self.std) * &self.weights;
        out.column_iter_mut().zip(self.level.iter()).for_each(|(mut column, level)| column.add_scalar_mut(*level));
        out
    }
}

fn standardized(rows: &DMatrix<f64>, mean: &DVector<f64>, std: &DVector<f64>) -> DMatrix<f64> {
    DMatrix::from_fn(rows.nrows(), rows.ncols(), |i, j| (rows[(i, j)] - mean[j]) / std[j])
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::latent::Codes;

    /// One joint that swings with another frequency in every clip. The present does not tell the future, and a code of
    /// the frequency's phase 0.3 s later does.
    fn space(clips: usize, offset: usize) -> (Encoded, FeatureLayout) {
        let layout = FeatureLayout { joints: vec!["knee".into()], end_effectors: vec![] };
        let (frames, fps) = (200, 50.0);
        let (mut rows, mut features, mut starts) = (Vec::new(), Vec::new(), vec![0]);
        for clip in 0..clips {
            let pulse = |t: f64| ((clip + offset) as f64 * 7.3 + 3.0 * t + (11.0 * t).sin()).sin();
            for frame in 0..frames {
                let t = frame as f64 / fps;
                let mut row = vec![0.0_f32; layout.size()];
                row[13] = pulse(t) as f32;
                features.extend(row);
                rows.push(pulse(t + 0.3) as f32);
            }
            starts.push(rows.len());
        }
        let names = (0..clips).map(|i| format!("clip {i}")).collect();
        (Encoded { name: "pulse".into(), codes: Codes::new(names, starts, rows, 1, fps).unwrap(), features }, layout)
    }

    #[test]
    fn a_code_of_the_future_is_found_and_a_permuted_one_is_worth_nothing() {
        let ((fitted, layout), (tested, _)) = (space(20, 0), space(10, 100));
        let probes = probes(&fitted, &tested, &layout, 3).unwrap();
        let error = |input: Input| probes.iter().find(|p| p.input == input).unwrap().joints_deg[2];
        assert!(error(Input::Code) < 0.1 && error(Input::Both) < 0.1, "{} {}", error(Input::Code), error(Input::Both));
        assert!(error(Input::Frame) > 10.0 && error(Input::Permuted) > 10.0);
        assert!((error(Input::Permuted) / error(Input::Frame) - 1.0).abs() < 0.02);
    }

    #[test]
    fn a_ridge_of_many_targets_by_hand() {
        // x = -1, 1 (std 1), y = 3 x + 2: w = Σxy / (Σx² + n λ) = 6 / (2 + 0.002).
        let rows = DMatrix::from_column_slice(2, 1, &[-1.0, 1.0]);
        let fit = Regression::fit(&rows, &DMatrix::from_column_slice(2, 1, &[-1.0, 5.0]));
        let expected = 2.0 + 6.0 / 2.002;
        assert!((fit.predict(&DMatrix::from_element(1, 1, 1.0))[(0, 0)] - expected).abs() < 1e-12);
    }

    #[test]
    fn clips_that_are_too_short_are_refused() {
        let layout = FeatureLayout { joints: vec!["knee".into()], end_effectors: vec![] };
        let codes = Codes::new(vec!["a".into()], vec![0, 5], vec![0.0; 5], 1, 50.0).unwrap();
        let short = Encoded { name: "short".into(), codes, features: vec![0.0; 5 * layout.size()] };
        let text = probes(&short, &short, &layout, 0).unwrap_err().to_string();
        assert!(text.contains("clips longer than 0.1 s"), "{text}");
    }
}
