//! A building block's trace as the network sees it.

use lifelike_sim::trace::{BlockTrace, Columns, Selected};

use super::frame::{Frame, vectors};
use crate::{AugmentationError, FromInput};

/// Origin of a number of a row.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Field {
    /// A column of the simulated state.
    State(String),
    /// A column of the constraint forces.
    Force(String),
    /// A column of the references.
    Reference(String),
    /// A reference less the state of the same name.
    Error(String),
    /// The change of a reference since the step before (per s).
    Change(String),
    /// The play operator of a state's column, with half its width: hysteresis.
    StatePlay(String, f32),
    /// The play operator of a reference's column.
    ReferencePlay(String, f32),
}

/// One step of the play operator (Prandtl and Ishlinskii): a slider that a rod of half the length `radius` drags
/// along. Its end tells from which side, and from how far, something came, however long ago; friction and play in a
/// gear remember no less.
pub fn drag(slider: f32, x: f32, radius: f32) -> f32 {
    slider.clamp(x - radius, x + radius)
}

impl Field {
    /// Returns the column's name.
    pub fn name(&self) -> &str {
        match self {
            Self::State(name) | Self::Force(name) | Self::Reference(name) | Self::Error(name) | Self::Change(name) => {
                name
            }
            Self::StatePlay(name, _) | Self::ReferencePlay(name, _) => name,
        }
    }
}

/// Names of what the network reads and predicts for a class of building blocks.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Inputs {
    /// The class.
    pub class: String,
    /// Rows per second (Hz).
    pub rate: f64,
    /// Numbers of a row.
    pub fields: Vec<Field>,
    /// Measured and predicted columns, with S.
    pub selection: Vec<Selected>,
    /// Axes of bodies.
    #[serde(default)]
    pub frame: Frame,
}

/// Factors of what goes in and comes out.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scales {
    /// Mean of each field.
    pub mean: Vec<f32>,
    /// Standard deviation of each field.
    pub std: Vec<f32>,
    /// Root mean square of each Δs̄: Δs is predicted in units of it, and none is predicted as 0.
    pub error: Vec<f32>,
}

/// One building block's rows, in units of the scales.
#[derive(Debug, Clone, PartialEq)]
pub struct Sequence {
    /// `run/block`.
    pub name: String,
    /// `[steps, inputs]`.
    pub rows: Vec<f32>,
    /// Δs̄, `[steps, outputs]`; empty where nothing was measured.
    pub error: Vec<f32>,
}

impl Inputs {
    /// Returns everything that blocks like this one offer: state, forces, references, how far the state is from its reference, how
    /// fast references change; of what has a reference, play operators of some radii. The predicted columns are those of `outputs`, all
    /// that are measured where it is empty.
    ///
    /// # Errors
    /// [`AugmentationError::Input`] where an output is not measured, or nothing is.
    pub fn of(block: &BlockTrace, rate: f64, outputs: &[String], radii: &[f64]) -> Result<Self, AugmentationError> {
        let mut fields: Vec<Field> = block.simulated.names.iter().cloned().map(Field::State).collect();
        fields.extend(block.force.names.iter().cloned().map(Field::Force));
        for name in &block.reference.names {
            fields.push(Field::Reference(name.clone()));
            if block.simulated.index(name).is_some() {
                fields.extend([Field::Error(name.clone()), Field::Change(name.clone())]);
                for radius in radii.iter().map(|radius| *radius as f32) {
                    fields.extend([Field::StatePlay(name.clone(), radius), Field::ReferencePlay(name.clone(), radius)]);
                }
            }
        }
        if let Some(name) = outputs.iter().find(|name| block.measured.index(name).is_none()) {
            let got = format!("'{name}'");
            return Err(AugmentationError::mismatch("outputs", format!("some of {:?}", block.measured.names), got));
        }
        let wanted = |row: &&Selected| outputs.is_empty() || outputs.contains(&row.measured);
        let selection: Vec<Selected> = block.selection.iter().filter(wanted).cloned().collect();
        if selection.is_empty() {
            return Err(AugmentationError::mismatch(
                format!("block '{}'", block.name),
                "something measured",
                "nothing",
            ));
        }
        Ok(Self { class: block.class.clone(), rate, fields, selection, frame: Frame::World })
    }

    /// Expresses bodies in another frame.
    ///
    /// # Errors
    /// [`AugmentationError::Input`] for outputs that are single coordinates of a body: they cannot be turned.
    pub fn in_frame(self, frame: Frame) -> Result<Self, AugmentationError> {
        let names: Vec<&str> = self.outputs();
        let is_body = self.fields.iter().any(|field| field.name() == "position_x");
        if frame == Frame::Parent && is_body && 3 * vectors(&names).len() != names.len() {
            let expected = "x, y and z of each vector, side by side (or augmentation.frame='world')";
            return Err(AugmentationError::mismatch("outputs in the parent's frame", expected, format!("{names:?}")));
        }
        Ok(Self { frame, ..self })
    }

    /// Returns the names of the predicted columns.
    pub fn outputs(&self) -> Vec<&str> {
        self.selection.iter().map(|row| row.measured.as_str()).collect()
    }

    /// Returns the numbers of a row, in SI units, of all steps.
    ///
    /// # Errors
    /// [`AugmentationError::Input`] for a block that lacks a column.
    pub fn rows(&self, block: &BlockTrace) -> Result<Vec<f32>, AugmentationError> {
        let block = &self.frame.of(block)?;
        let columns = self.fields.iter().map(|field| self.column(block, field)).collect::<Result<Vec<_>, _>>()?;
        let rows = columns.first().map_or(0, Vec::len);
        Ok((0..rows).flat_map(|row| columns.iter().map(move |column| column[row])).collect())
    }

    fn column(&self, block: &BlockTrace, field: &Field) -> Result<Vec<f32>, AugmentationError> {
        let of = |part: &str, columns: &Columns, name: &String| -> Result<Vec<f32>, AugmentationError> {
            columns.column(name).map(Iterator::collect).ok_or_else(|| {
                let what = format!("{part} of '{}', class '{}'", block.name, self.class);
                AugmentationError::mismatch(what, format!("a column '{name}'"), format!("{:?}", columns.names))
            })
        };
        match field {
            Field::State(name) => of("state", &block.simulated, name),
            Field::Force(name) => of("forces", &block.force, name),
            Field::Reference(name) => of("references", &block.reference, name),
            Field::Error(name) => {
                let state = of("state", &block.simulated, name)?;
                let reference = of("references", &block.reference, name)?;
                Ok(reference.iter().zip(state).map(|(r, s)| r - s).collect())
            }
            Field::Change(name) => {
                let reference = of("references", &block.reference, name)?;
                let steps = reference.windows(2).map(|pair| (pair[1] - pair[0]) * self.rate as f32);
                Ok(std::iter::once(0.0).take(reference.len().min(1)).chain(steps).collect())
            }
            Field::StatePlay(name, radius) => Ok(play(&of("state", &block.simulated, name)?, *radius)),
            Field::ReferencePlay(name, radius) => Ok(play(&of("references", &block.reference, name)?, *radius)),
        }
    }

    /// Returns Δs̄ of the predicted columns, in SI units; empty where nothing was measured.
    ///
    /// # Errors
    /// [`AugmentationError::Input`] for a block that measured other things.
    pub fn error(&self, block: &BlockTrace) -> Result<Vec<f32>, AugmentationError> {
        if block.measured.names.is_empty() {
            return Ok(Vec::new());
        }
        let block = &self.frame.of(block)?;
        let columns = self.selection.iter().map(|row| block.measured.index(&row.measured).ok_or(row));
        let columns = columns.collect::<Result<Vec<_>, _>>().map_err(|row| {
            let what = format!("measured of '{}'", block.name);
            AugmentationError::mismatch(what, format!("'{}'", row.measured), format!("{:?}", block.measured.names))
        })?;
        let (error, width) = (block.error(), block.measured.names.len());
        Ok(error.chunks_exact(width).flat_map(|row| columns.iter().map(|i| row[*i])).collect())
    }

    /// Returns a block in units of the scales.
    ///
    /// # Errors
    /// [`AugmentationError::Input`] for a block of another class or with other columns.
    pub fn sequence(&self, run: &str, block: &BlockTrace, scales: &Scales) -> Result<Sequence, AugmentationError> {
        if block.class != self.class {
            let what = format!("class of '{}'", block.name);
            return Err(AugmentationError::mismatch(what, format!("'{}'", self.class), format!("'{}'", block.class)));
        }
        let mut rows = self.rows(block)?;
        scales.standardize(&mut rows);
        let mut error = self.error(block)?;
        let scale = &scales.error;
        error.chunks_exact_mut(scale.len()).for_each(|row| row.iter_mut().zip(scale).for_each(|(x, s)| *x /= s));
        Ok(Sequence { name: format!("{run}/{}", block.name), rows, error })
    }
}

impl Scales {
    /// Below this a number hardly changes, and is not blown up.
    const FLOOR: f32 = 1e-6;

    /// Measures the scales of blocks. Columns that are the coordinates of one vector (`NAME_x`, `NAME_y`, `NAME_z`) have one scale
    /// (thesis 2.4.1).
    ///
    /// # Errors
    /// As [`Inputs::rows`]; no block.
    pub fn of(inputs: &Inputs, blocks: &[&BlockTrace]) -> Result<Self, AugmentationError> {
        let (width, outputs) = (inputs.fields.len(), inputs.selection.len());
        let (mut sums, mut squares, mut rows) = (vec![0.0_f64; width], vec![0.0_f64; width], 0.0);
        let (mut errors, mut measured) = (vec![0.0_f64; outputs], 0.0);
        for block in blocks {
            for row in inputs.rows(block)?.chunks_exact(width) {
                rows += 1.0;
                for ((x, sum), square) in row.iter().zip(&mut sums).zip(&mut squares) {
                    *sum += f64::from(*x);
                    *square += f64::from(*x).powi(2);
                }
            }
            for row in inputs.error(block)?.chunks_exact(outputs) {
                measured += 1.0;
                row.iter().zip(&mut errors).for_each(|(x, sum)| *sum += f64::from(*x).powi(2));
            }
        }
        if rows == 0.0 || measured == 0.0 {
            return Err(AugmentationError::mismatch("blocks to learn from", "some that were measured", blocks.len()));
        }
        let mut mean: Vec<f64> = sums.iter().map(|sum| sum / rows).collect();
        let mut variance: Vec<f64> =
            squares.iter().zip(&mean).map(|(square, mean)| square / rows - mean * mean).collect();
        let names: Vec<String> = inputs.fields.iter().map(|field| vector_of(&format!("{field:?}"))).collect();
        share(&names, &mut mean);
        share(&names, &mut variance);
        let mut error: Vec<f64> = errors.iter().map(|sum| sum / measured).collect();
        let names: Vec<String> = inputs.selection.iter().map(|row| vector_of(&row.measured)).collect();
        share(&names, &mut error);
        let root = |x: &f64| (x.max(0.0).sqrt() as f32).max(Self::FLOOR);
        Ok(Self {
            mean: mean.iter().map(|x| *x as f32).collect(),
            std: variance.iter().map(root).collect(),
            error: error.iter().map(root).collect(),
        })
    }

    /// Brings rows into units of the scales.
    pub fn standardize(&self, rows: &mut [f32]) {
        for row in rows.chunks_exact_mut(self.mean.len()) {
            row.iter_mut().zip(&self.mean).zip(&self.std).for_each(|((x, mean), std)| *x = (*x - mean) / std);
        }
    }
}

/// Returns the lag behind the slider, in radii, at every step; it begins with the column.
fn play(column: &[f32], radius: f32) -> Vec<f32> {
    let mut slider = column.first().copied().unwrap_or(0.0);
    let step = |x: &f32| {
        slider = drag(slider, *x, radius);
        (x - slider) / radius
    };
    column.iter().map(step).collect()
}

/// Returns the name of the vector that a coordinate belongs to; other names as they are.
fn vector_of(name: &str) -> String {
    let trimmed = name.trim_end_matches(['"', ')']);
    match trimmed.strip_suffix(['x', 'y', 'z']).and_then(|name| name.strip_suffix('_')) {
        Some(vector) => vector.into(),
        None => name.into(),
    }
}

/// Gives numbers of one name their mean.
fn share(names: &[String], numbers: &mut [f64]) {
    let own = numbers.to_vec();
    for (name, number) in names.iter().zip(numbers) {
        let same = || names.iter().zip(&own).filter(|(other, _)| *other == name).map(|(_, x)| *x);
        *number = same().sum::<f64>() / same().count() as f64;
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn block() -> BlockTrace {
        let mut block = BlockTrace {
            name: "knee".into(),
            class: "servo".into(),
            simulated: Columns::new(&[("position", &[0.0, 1.0, 2.0]), ("velocity", &[1.0, 1.0, 1.0])]),
            force: Columns::new(&[("f_x", &[3.0, 5.0, 3.0]), ("f_y", &[0.0, 0.0, 3.0])]),
            reference: Columns::new(&[("position", &[0.5, 1.0, 1.25])]),
            measured: Columns::new(&[("position", &[0.0, 1.5, 2.5])]),
            ..BlockTrace::default()
        };
        block.selection = block.by_name();
        block
    }

    #[test]
    fn rows_have_state_forces_references_and_how_far_and_fast_these_are() {
        let inputs = Inputs::of(&block(), 10.0, &[], &[]).unwrap();
        assert_eq!(inputs.fields.len(), 7);
        let rows = inputs.rows(&block()).unwrap();
        assert_eq!(rows[7..14], [1.0, 1.0, 5.0, 0.0, 1.0, 0.0, 5.0]);
        assert_eq!(inputs.error(&block()).unwrap(), [0.0, 0.5, 0.5]);
    }

    #[test]
    fn sliders_remember_where_something_came_from() {
        assert_eq!(play(&[0.0, 1.0, 5.0, 4.5, 4.5, 4.5, 0.0], 2.0), [0.0, 0.5, 1.0, 0.75, 0.75, 0.75, -1.0]);
        let inputs = Inputs::of(&block(), 10.0, &[], &[0.5, 2.0]).unwrap();
        assert_eq!(inputs.fields.len(), 7 + 4);
        assert_eq!(inputs.rows(&block()).unwrap()[11 + 7..11 + 11], [1.0, 1.0, 0.5, 0.25]);
    }

    #[test]
    fn coordinates_of_a_vector_share_a_scale() {
        let inputs = Inputs::of(&block(), 10.0, &[], &[]).unwrap();
        let scales = Scales::of(&inputs, &[&block()]).unwrap();
        // Variances 8/9 and 2 of the two coordinates.
        assert!((f64::from(scales.std[2]) - ((8.0_f64 / 9.0 + 2.0) / 2.0).sqrt()).abs() < 1e-6);
        assert_eq!((scales.std[2], scales.mean[2]), (scales.std[3], scales.mean[3]));
        assert_eq!(scales.std[1], Scales::FLOOR, "what does not change is not blown up");
        assert!((scales.error[0] - (0.5_f32 / 3.0).sqrt()).abs() < 1e-6);
    }

    #[test]
    fn another_class_and_missing_columns_are_refused() {
        let inputs = Inputs::of(&block(), 10.0, &[], &[]).unwrap();
        let scales = Scales::of(&inputs, &[&block()]).unwrap();
        let other = BlockTrace { class: "body".into(), ..block() };
        assert!(inputs.sequence("run", &other, &scales).unwrap_err().to_string().contains("'servo', got 'body'"));
        let poor = BlockTrace { force: Columns::default(), ..block() };
        assert!(inputs.sequence("run", &poor, &scales).unwrap_err().to_string().contains("a column 'f_x'"));
        assert!(Inputs::of(&block(), 10.0, &["current".into()], &[]).is_err());
    }
}
