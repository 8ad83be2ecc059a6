//! Checkpoints: named tensors and JSON metadata in one safetensors file with a digest.
//!
//! A checkpoint holds everything a run needs to continue bit for bit. [`Checkpoint::save`] replaces the file
//! atomically. [`Checkpoint::load`] refuses a file with a single changed bit.

mod entry;
mod error;
mod file;

use std::collections::BTreeMap;

use serde::Serialize;
use serde::de::DeserializeOwned;

pub use entry::{Entry, Kind};
pub use error::CheckpointError;

/// Named tensors and metadata in memory.
///
/// ```
/// use lifelike_checkpoint::Checkpoint;
///
/// let mut checkpoint = Checkpoint::new();
/// checkpoint.put_f32("weight", &[2, 1], vec![0.5, -1.0])?;
/// checkpoint.set_meta("steps", &12)?;
/// let path = std::env::temp_dir().join(format!("doctest-{}.safetensors", std::process::id()));
/// checkpoint.save(&path)?;
///
/// let loaded = Checkpoint::load(&path)?;
/// assert_eq!(loaded.f32s("weight", &[2, 1])?, [0.5, -1.0]);
/// assert_eq!(loaded.meta::<u64>("steps")?, 12);
/// assert!(loaded.f32s("weight", &[1, 2]).is_err(), "another shape is refused");
/// # std::fs::remove_file(&path).ok();
/// # Ok::<(), lifelike_checkpoint::CheckpointError>(())
/// ```
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Checkpoint {
    entries: BTreeMap<String, Entry>,
    metadata: BTreeMap<String, serde_json::Value>,
    origin: String,
}

impl Checkpoint {
    /// Returns an empty checkpoint.
    pub fn new() -> Self {
        Self { origin: "checkpoint in memory".to_owned(), ..Self::default() }
    }

    /// Adds an entry.
    ///
    /// # Errors
    /// The name is taken, or the shape does not hold as many numbers as given.
    pub fn put(&mut self, name: &str, entry: Entry) -> Result<(), CheckpointError> {
        let (expected, got) = (entry.shape().iter().product::<usize>(), entry.count());
        if expected != got {
            return Err(self.mismatch(name, &format!("{expected} numbers for shape {:?}", entry.shape()), got));
        }
        if self.entries.contains_key(name) {
            return Err(CheckpointError::Duplicate { name: name.to_owned() });
        }
        self.entries.insert(name.to_owned(), entry);
        Ok(())
    }

    /// Adds f32 numbers in row-major order.
    pub fn put_f32(&mut self, name: &str, shape: &[usize], values: Vec<f32>) -> Result<(), CheckpointError> {
        self.put(name, Entry::F32(shape.to_vec(), values))
    }

    /// Adds f64 numbers in row-major order.
    pub fn put_f64(&mut self, name: &str, shape: &[usize], values: Vec<f64>) -> Result<(), CheckpointError> {
        self.put(name, Entry::F64(shape.to_vec(), values))
    }

    /// Adds u64 numbers in row-major order.
    pub fn put_u64(&mut self, name: &str, shape: &[usize], values: Vec<u64>) -> Result<(), CheckpointError> {
        self.put(name, Entry::U64(shape.to_vec(), values))
    }

    /// Adds bytes.
    pub fn put_u8(&mut self, name: &str, shape: &[usize], values: Vec<u8>) -> Result<(), CheckpointError> {
        self.put(name, Entry::U8(shape.to_vec(), values))
    }

    /// Returns whether there is an entry of this name.
    pub fn contains(&self, name: &str) -> bool {
        self.entries.contains_key(name)
    }

    /// Returns all entries, by name.
    pub fn entries(&self) -> &BTreeMap<String, Entry> {
        &self.entries
    }

    /// Returns an entry.
    ///
    /// # Errors
    /// There is none of this name.
    pub fn entry(&self, name: &str) -> Result<&Entry, CheckpointError> {
        self.entries
            .get(name)
            .ok_or_else(|| CheckpointError::Missing { path: self.origin.clone(), names: vec![name.to_owned()] })
    }

    /// Returns the f32 numbers of an entry of exactly this shape.
    pub fn f32s(&self, name: &str, shape: &[usize]) -> Result<Vec<f32>, CheckpointError> {
        match self.shaped(name, shape)? {
            Entry::F32(_, v) => Ok(v.clone()),
            other => Err(self.wrong_kind(name, Kind::F32, other)),
        }
    }

    /// Returns the f64 numbers of an entry of exactly this shape.
    pub fn f64s(&self, name: &str, shape: &[usize]) -> Result<Vec<f64>, CheckpointError> {
        match self.shaped(name, shape)? {
            Entry::F64(_, v) => Ok(v.clone()),
            other => Err(self.wrong_kind(name, Kind::F64, other)),
        }
    }

    /// Returns the u64 numbers of an entry of exactly this shape.
    pub fn u64s(&self, name: &str, shape: &[usize]) -> Result<Vec<u64>, CheckpointError> {
        match self.shaped(name, shape)? {
            Entry::U64(_, v) => Ok(v.clone()),
            other => Err(self.wrong_kind(name, Kind::U64, other)),
        }
    }

    /// Returns the bytes of an entry of exactly this shape.
    pub fn u8s(&self, name: &str, shape: &[usize]) -> Result<Vec<u8>, CheckpointError> {
        match self.shaped(name, shape)? {
            Entry::U8(_, v) => Ok(v.clone()),
            other => Err(self.wrong_kind(name, Kind::U8, other)),
        }
    }

    /// Sets a metadata value (a plan, names, counters, ...).
    ///
    /// # Errors
    /// The value cannot be written as JSON. Non-finite numbers become `null`: keep numbers that matter in entries.
    pub fn set_meta<T: Serialize>(&mut self, key: &str, value: &T) -> Result<(), CheckpointError> {
        let value = serde_json::to_value(value).map_err(|e| CheckpointError::Metadata {
            path: self.origin.clone(),
            key: key.to_owned(),
            why: e.to_string(),
        })?;
        self.metadata.insert(key.to_owned(), value);
        Ok(())
    }

    /// Returns all metadata, by key.
    pub fn metadata(&self) -> &BTreeMap<String, serde_json::Value> {
        &self.metadata
    }

    /// Reads a metadata value.
    pub fn meta<T: DeserializeOwned>(&self, key: &str) -> Result<T, CheckpointError> {
        let fail = |why: String| CheckpointError::Metadata { path: self.origin.clone(), key: key.to_owned(), why };
        let value = self.metadata.get(key).ok_or_else(|| fail("is missing".to_owned()))?;
        serde_json::from_value(value.clone()).map_err(|e| fail(e.to_string()))
    }

    /// Returns the file that this checkpoint was read from, for messages.
    pub fn origin(&self) -> &str {
        &self.origin
    }

    fn shaped(&self, name: &str, shape: &[usize]) -> Result<&Entry, CheckpointError> {
        let entry = self.entry(name)?;
        if entry.shape() == shape {
            return Ok(entry);
        }
        Err(self.mismatch(name, &format!("shape {shape:?}"), format!("{:?}", entry.shape())))
    }

    fn wrong_kind(&self, name: &str, expected: Kind, got: &Entry) -> CheckpointError {
        self.mismatch(name, &format!("{expected:?}"), format!("{:?}", got.kind()))
    }

    fn mismatch(&self, name: &str, expected: &str, got: impl ToString) -> CheckpointError {
        CheckpointError::Mismatch {
            path: self.origin.clone(),
            name: name.to_owned(),
            expected: expected.to_owned(),
            got: got.to_string(),
        }
    }
}
