//! Parts of a motion that are given before it is made: its beginning, some of its columns throughout, or poses at moments.

use super::Generator;
use crate::diffusion::Known;
use crate::representation::{FeatureMatrix, RepresentationSpec};
use crate::{FromInput, GenerationError};

/// Parts of a motion that are given before it is made.
#[derive(Debug, Clone, PartialEq)]
pub enum Given {
    /// Its first rows.
    Beginning(FeatureMatrix),
    /// Columns of its rows: those of another motion that is at least as long.
    Columns {
        /// The other motion.
        motion: FeatureMatrix,
        /// The columns: height, velocity, yaw rate and up axis of the root, then joint angles, then their velocities.
        columns: Vec<usize>,
    },
    /// Poses at moments, in which it stands still.
    Poses(Vec<Pose>),
}

/// A pose at a moment.
#[derive(Debug, Clone, PartialEq)]
pub struct Pose {
    /// The moment (s).
    pub seconds: f64,
    /// A row of a motion: its height, up axis and joint angles count.
    pub row: Vec<f32>,
}

impl Given {
    /// Returns these joints of a motion as given, and its root where asked for.
    ///
    /// # Errors
    /// [`GenerationError::Input`] for a joint that the rows have not.
    pub fn joints(
        motion: FeatureMatrix,
        spec: &RepresentationSpec,
        joints: &[String],
        root: bool,
    ) -> Result<Self, GenerationError> {
        let mut columns: Vec<usize> = if root { (0..spec.angles().start).collect() } else { Vec::new() };
        for name in joints {
            let joint = spec.joint_names.iter().position(|own| own == name);
            let joint =
                joint.ok_or_else(|| GenerationError::mismatch("given joint", spec.joint_names.join(", "), name))?;
            columns.extend([spec.angles().start + joint, spec.velocities().start + joint]);
        }
        Ok(Self::Columns { motion, columns })
    }

    /// Returns it in the standardized tokens of a motion of that number of rows.
    pub(super) fn known(&self, generator: &Generator, rows: usize) -> Result<Known, GenerationError> {
        let (space, standardizer) = (generator.space(), generator.standardizer());
        let standardized = |mut tokens: Vec<f32>| {
            standardizer.standardize(&mut tokens);
            Known::nothing(tokens, space.width())
        };
        match self {
            Self::Beginning(beginning) => {
                let (tokens, settled) = space.beginning(beginning, rows)?;
                Ok(standardized(tokens).prefix(settled))
            }
            Self::Columns { motion, columns } => {
                if motion.n < rows {
                    let expected = format!("at least {rows} rows (the length asked for)");
                    return Err(GenerationError::mismatch("motion whose columns are given", expected, motion.n));
                }
                let part = FeatureMatrix::new(motion.rows[..rows * motion.width].to_vec(), motion.width)?;
                Ok(standardized(space.encode(&part)?).columns(columns))
            }
            Self::Poses(poses) => {
                let nothing = Known::nothing(vec![0.0; space.tokens(rows) * space.width()], space.width());
                poses.iter().try_fold(nothing, |known, pose| pose.add_to(known, generator, rows))
            }
        }
    }

    /// Puts given columns into rows as they are: control points only come near.
    pub(super) fn put(&self, rows: &mut FeatureMatrix) {
        let Self::Columns { motion, columns } = self else { return };
        for (row, given) in rows.rows.chunks_exact_mut(rows.width).zip(motion.rows.chunks_exact(motion.width)) {
            columns.iter().for_each(|&column| row[column] = given[column]);
        }
    }
}

impl Pose {
    /// Returns what is known with this pose.
    fn add_to(&self, known: Known, generator: &Generator, rows: usize) -> Result<Known, GenerationError> {
        let space = generator.space();
        let spec = space.spec();
        let row = (self.seconds * spec.fps).round();
        if !(row >= 0.0 && row < rows as f64) {
            let last = (rows - 1) as f64 / spec.fps;
            let expected = format!("0 to {last} s, the motion's duration");
            return Err(GenerationError::mismatch("time of a pose", expected, format!("{} s", self.seconds)));
        }
        if self.row.len() != spec.width() {
            return Err(GenerationError::mismatch("numbers of a pose", spec.width(), self.row.len()));
        }
        let mut token = self.row[..space.width()].to_vec();
        // It stands: velocity and yaw rate of the root, and of the joints where a token has them.
        token[RepresentationSpec::VELOCITY.start..=RepresentationSpec::YAW_RATE].fill(0.0);
        if let Some(rates) = token.get_mut(spec.velocities()) {
            rates.fill(0.0);
        }
        generator.standardizer().standardize(&mut token);
        Ok(known.tokens(space.around(row as usize, rows), &token))
    }
}

/// Returns a motion and the one that goes on from its last `overlap` rows as one: in the overlap the first passes over
/// into the second, evenly.
///
/// # Errors
/// [`GenerationError::Input`] for rows of different widths, or an overlap longer than one of them.
pub fn join(before: &FeatureMatrix, next: &FeatureMatrix, overlap: usize) -> Result<FeatureMatrix, GenerationError> {
    let width = before.width;
    if next.width != width {
        return Err(GenerationError::mismatch("rows that go on", format!("rows of {width}"), next.width));
    }
    if overlap > before.n.min(next.n) {
        let most = before.n.min(next.n);
        return Err(GenerationError::mismatch("overlap", format!("at most {most} rows"), overlap));
    }
    let mut rows = before.rows.clone();
    let common = &mut rows[(before.n - overlap) * width..];
    for (i, (row, next)) in common.chunks_exact_mut(width).zip(next.rows.chunks_exact(width)).enumerate() {
        let share = (i + 1) as f32 / (overlap + 1) as f32;
        row.iter_mut().zip(next).for_each(|(x, next)| *x += share * (next - *x));
    }
    rows.extend_from_slice(&next.rows[overlap * width..]);
    FeatureMatrix::new(rows, width)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::space::{MotionSpace, SpaceKind};

    fn rows(values: &[f32]) -> FeatureMatrix {
        FeatureMatrix::new(values.to_vec(), 1).unwrap()
    }

    #[test]
    fn an_overlap_passes_over_evenly() {
        let all = join(&rows(&[0.0, 0.0, 0.0]), &rows(&[3.0, 3.0, 3.0, 3.0]), 2).unwrap();
        assert_eq!(all.rows, [0.0, 1.0, 2.0, 3.0, 3.0]);
        assert_eq!(join(&rows(&[1.0]), &rows(&[2.0]), 0).unwrap().rows, [1.0, 2.0]);
        assert!(join(&rows(&[1.0]), &rows(&[2.0, 3.0]), 2).unwrap_err().to_string().contains("at most 1"));
    }

    #[test]
    fn a_beginning_settles_the_control_points_of_its_spans() {
        let spec = RepresentationSpec::new(vec!["knee".into()]);
        let space = MotionSpace::new(spec.clone(), SpaceKind::default());
        let curve = |t: f32, c: usize| (1.5 * t + c as f32).sin();
        let values: Vec<f32> =
            (0..61).flat_map(|i| (0..9).map(move |c| (i as f32 / 20.0, c))).map(|(t, c)| curve(t, c)).collect();
        let whole = FeatureMatrix::new(values, 9).unwrap();
        let part = FeatureMatrix::new(whole.rows[..13 * 9].to_vec(), 9).unwrap();
        // 3 s are 15 spans of 0.2 s; 0.6 s are three of them.
        let (tokens, settled) = space.beginning(&part, 61).unwrap();
        assert_eq!((tokens.len(), settled), (18 * 8, 6));
        // What follows does not reach into the beginning.
        let mut other = tokens.clone();
        other[settled * 8..].fill(7.0);
        let back = space.decode(&other, 61).unwrap();
        for (a, b) in back.rows.chunks_exact(9).zip(whole.rows.chunks_exact(9)).take(13) {
            // A cubic spline misses sin(1.5 t) by less than 0.2^4 1.5^4 / 384.
            assert!((0..8).all(|c| (a[c] - b[c]).abs() < 1e-4), "{a:?} for {b:?}");
        }
        let frames = MotionSpace::new(spec, SpaceKind::Frames);
        let (tokens, settled) = frames.beginning(&part, 61).unwrap();
        assert_eq!((&tokens[..13 * 9], settled), (&part.rows[..], 13));
        assert!(space.beginning(&whole, 13).is_err());
    }

    #[test]
    fn given_joints_are_angles_and_velocities_by_name() {
        let spec = RepresentationSpec::new(vec!["hip".into(), "knee".into()]);
        let motion = FeatureMatrix::new(vec![1.0; 22], 11).unwrap();
        let of = |names: &[&str], root| {
            let names: Vec<String> = names.iter().map(|n| (*n).to_string()).collect();
            Given::joints(motion.clone(), &spec, &names, root)
        };
        let Given::Columns { columns, .. } = of(&["knee"], true).unwrap() else { panic!() };
        assert_eq!(columns, [0, 1, 2, 3, 4, 5, 6, 8, 10]);
        assert!(of(&["elbow"], false).is_err());
        let mut rows = FeatureMatrix::new(vec![0.0; 11], 11).unwrap();
        of(&["hip"], false).unwrap().put(&mut rows);
        assert_eq!(rows.rows.iter().sum::<f32>(), 2.0);
    }
}
