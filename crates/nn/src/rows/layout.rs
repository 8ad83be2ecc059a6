//! Parameters of a network in one row of numbers, by name.

use std::collections::BTreeMap;
use std::ops::Range;

use lifelike_checkpoint::{Checkpoint, CheckpointError, rng};

use crate::init::{normal, uniform_by_fan_in};

/// Initial values of a parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Init {
    /// The same number everywhere.
    Constant(f32),
    /// Uniform in ± this number.
    Uniform(f64),
    /// Normal of mean 0 and this standard deviation.
    Normal(f64),
}

/// A parameter.
#[derive(Debug, Clone, PartialEq)]
pub struct Entry {
    /// Name.
    pub name: String,
    /// Shape, row-major; weights are `[inputs, outputs]`.
    pub shape: Vec<usize>,
    /// Initial values.
    pub init: Init,
}

impl Entry {
    /// Returns weight and bias of a linear map as PyTorch initializes them: uniform in ± 1/√inputs.
    pub fn linear(name: &str, inputs: usize, outputs: usize) -> [Self; 2] {
        let init = Init::Uniform((inputs.max(1) as f64).powf(-0.5));
        [
            Self { name: format!("{name}.weight"), shape: vec![inputs, outputs], init },
            Self { name: format!("{name}.bias"), shape: vec![outputs], init },
        ]
    }
}

/// Names, shapes and places of a network's parameters.
#[derive(Debug, Clone, PartialEq)]
pub struct Layout {
    entries: Vec<Entry>,
    ranges: BTreeMap<String, Range<usize>>,
    total: usize,
}

impl Layout {
    /// Returns the layout of these parameters, one after the other.
    pub fn new(entries: Vec<Entry>) -> Self {
        let (mut ranges, mut total) = (BTreeMap::new(), 0);
        for entry in &entries {
            let count: usize = entry.shape.iter().product();
            ranges.insert(entry.name.clone(), total..total + count);
            total += count;
        }
        Self { entries, ranges, total }
    }

    /// Returns the layout of parameters of these names and shapes, all zero at first.
    pub fn of_shapes(named: Vec<(String, Vec<usize>)>) -> Self {
        let init = Init::Constant(0.0);
        Self::new(named.into_iter().map(|(name, shape)| Entry { name, shape, init }).collect())
    }

    /// Returns the number of parameters.
    pub fn len(&self) -> usize {
        self.total
    }

    /// Returns whether there is no parameter.
    pub fn is_empty(&self) -> bool {
        self.total == 0
    }

    /// Returns the parameters in their order.
    pub fn entries(&self) -> &[Entry] {
        &self.entries
    }

    /// Returns the place of a parameter; an empty one for a name that there is not.
    pub fn range(&self, name: &str) -> Range<usize> {
        self.ranges.get(name).cloned().unwrap_or(0..0)
    }

    /// Returns the place of all parameters whose names begin with a prefix; they are neighbours.
    pub fn range_under(&self, prefix: &str) -> Range<usize> {
        let mut places =
            self.entries.iter().filter(|entry| entry.name.starts_with(prefix)).map(|e| self.range(&e.name));
        let first = places.next().unwrap_or(0..0);
        first.start..places.next_back().map_or(first.end, |last| last.end)
    }

    /// Returns initial values, each parameter from the stream `(seed, purpose.NAME, 0, 0)`.
    pub fn init(&self, seed: u64, purpose: &str) -> Vec<f32> {
        let mut out = Vec::with_capacity(self.total);
        for Entry { name, shape, init } in &self.entries {
            let count = shape.iter().product();
            let mut rng = rng::stream(seed, &format!("{purpose}.{name}"), 0, 0);
            match *init {
                Init::Constant(value) => out.resize(out.len() + count, value),
                // The bound is gain √3 for one input.
                Init::Uniform(bound) => out.extend(uniform_by_fan_in(&mut rng, count, 1, bound / 3.0_f64.sqrt())),
                Init::Normal(std) => out.extend(normal(&mut rng, count, std)),
            }
        }
        out
    }

    /// Saves values as `prefix.NAME`.
    ///
    /// # Errors
    /// A name is taken.
    pub fn save_into(&self, checkpoint: &mut Checkpoint, prefix: &str, values: &[f32]) -> Result<(), CheckpointError> {
        for entry in &self.entries {
            let values = values[self.range(&entry.name)].to_vec();
            checkpoint.put_f32(&format!("{prefix}.{}", entry.name), &entry.shape, values)?;
        }
        Ok(())
    }

    /// Returns the values saved as `prefix.NAME`.
    ///
    /// # Errors
    /// Every missing parameter at once; an entry under `prefix` that the layout does not have; a parameter of another shape.
    pub fn load_from(&self, checkpoint: &Checkpoint, prefix: &str) -> Result<Vec<f32>, CheckpointError> {
        let wanted: Vec<String> = self.entries.iter().map(|entry| format!("{prefix}.{}", entry.name)).collect();
        let missing: Vec<String> = wanted.iter().filter(|name| !checkpoint.contains(name)).cloned().collect();
        if !missing.is_empty() {
            return Err(CheckpointError::Missing { path: checkpoint.origin().to_owned(), names: missing });
        }
        let under = format!("{prefix}.");
        let known = |name: &&String| !name.starts_with(&under) || wanted.contains(name);
        let unexpected: Vec<String> = checkpoint.entries().keys().filter(|name| !known(name)).cloned().collect();
        if !unexpected.is_empty() {
            return Err(CheckpointError::Unexpected { path: checkpoint.origin().to_owned(), names: unexpected });
        }
        let mut out = Vec::with_capacity(self.total);
        for (entry, name) in self.entries.iter().zip(&wanted) {
            out.extend(checkpoint.f32s(name, &entry.shape)?);
        }
        Ok(out)
    }
}
