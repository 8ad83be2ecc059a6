//! Named arrays, whichever file they are in: NumPy's `.npz`, a pickled dict, or `torch.save`.

use std::io::{Cursor, Read};
use std::path::Path;

use zip::{CompressionMethod, ZipArchive};

use super::pickle::{Numbers, Pickle, Tensor};
use crate::formats::npz::{Archive, fortran_place, shortened};
use crate::{FromInput, MotionError};

/// No length (m), angle (rad) or rate is larger; anything beyond is a broken file.
const LARGEST: f64 = 1e6;
/// First bytes of PyTorch's older format: a pickled integer of ten bytes.
const OLD_TORCH: &[u8] = &[0x80, 2, 0x8a, 10];
/// The pickle in a zip of PyTorch.
const TORCH_PICKLE: &str = "/data.pkl";

/// Named arrays of a file.
pub(super) struct Arrays<'a> {
    source: Source<'a>,
    file: &'a Path,
}

enum Source<'a> {
    Npz(Archive<'a>),
    Pickle(Pickle),
    Torch { pickle: Pickle, zip: ZipArchive<Cursor<&'a [u8]>>, prefix: String },
}

/// Returns whether a zip with these files is one of PyTorch.
pub(super) fn is_torch(mut entries: impl Iterator<Item = impl AsRef<str>>) -> bool {
    entries.any(|entry| entry.as_ref().ends_with(TORCH_PICKLE))
}

impl<'a> Arrays<'a> {
    /// Opens a file that begins as a zip or a pickle.
    pub(super) fn open(bytes: &'a [u8], file: &'a Path) -> Result<Self, MotionError> {
        if bytes.starts_with(OLD_TORCH) {
            let got = "the format of PyTorch before 1.6 (load it, and torch.save it anew)".to_owned();
            return Err(wrong(file, "a zip of torch.save", got));
        }
        if Pickle::is_start(bytes) {
            return Ok(Self { source: Source::Pickle(Pickle::parse(bytes, file)?), file });
        }
        if let Ok(zip) = ZipArchive::new(Cursor::new(bytes)) {
            let prefix = zip.file_names().find_map(|name| name.strip_suffix(TORCH_PICKLE)).map(str::to_owned);
            if let Some(prefix) = prefix {
                return Self::open_torch(zip, prefix, file);
            }
        }
        Ok(Self { source: Source::Npz(Archive::open(bytes, file)?), file })
    }

    fn open_torch(mut zip: ZipArchive<Cursor<&'a [u8]>>, prefix: String, file: &'a Path) -> Result<Self, MotionError> {
        let order = stored(&mut zip, &format!("{prefix}/byteorder"), file).unwrap_or_else(|_| b"little".to_vec());
        if order != b"little" {
            return Err(wrong(file, "numbers with the lowest byte first", "another order of bytes".to_owned()));
        }
        let program = stored(&mut zip, &format!("{prefix}{TORCH_PICKLE}"), file)?;
        Ok(Self { source: Source::Torch { pickle: Pickle::parse(&program, file)?, zip, prefix }, file })
    }

    /// Returns the file's kind, as messages write it.
    pub(super) fn kind(&self) -> Kind {
        match self.source {
            Source::Npz(_) => Kind::Npz,
            Source::Pickle(_) => Kind::Pickle,
            Source::Torch { .. } => Kind::Torch,
        }
    }

    /// Returns whether the file has all of these.
    pub(super) fn has_all(&self, names: &[&str]) -> bool {
        names.iter().all(|name| self.has(name))
    }

    pub(super) fn has(&self, name: &str) -> bool {
        match &self.source {
            Source::Npz(archive) => archive.has(name),
            Source::Pickle(pickle) | Source::Torch { pickle, .. } => pickle.keys().any(|key| key == name),
        }
    }

    /// Returns the names, for messages.
    pub(super) fn listed(&self) -> String {
        match &self.source {
            Source::Npz(archive) => archive.listed(),
            Source::Pickle(pickle) | Source::Torch { pickle, .. } => {
                let keys: Vec<String> = pickle.keys().take(12).map(shortened).collect();
                if keys.is_empty() { "no dict".to_owned() } else { format!("entries {}", keys.join(", ")) }
            }
        }
    }

    /// Returns the shape of an array; none of a single number.
    pub(super) fn shape(&mut self, name: &str) -> Result<Vec<usize>, MotionError> {
        match &mut self.source {
            Source::Npz(archive) => Ok(archive.array(name)?.shape().to_vec()),
            Source::Pickle(pickle) | Source::Torch { pickle, .. } => Ok(match pickle.numbers(name) {
                Some(Numbers::Array { shape, .. }) => shape.to_vec(),
                Some(Numbers::Tensor(tensor)) => tensor.shape.clone(),
                Some(Numbers::One(_)) => Vec::new(),
                None => return Err(self.missing(name)),
            }),
        }
    }

    /// Reads the numbers of these rows and columns, row after row; all axes after the first are columns.
    pub(super) fn select(&mut self, name: &str, keep: impl Fn(usize, usize) -> bool) -> Result<Vec<f64>, MotionError> {
        let file = self.file;
        let broken = |got: String| wrong(file, &format!("'{name}' as an array of finite numbers below a million"), got);
        let numbers = match &mut self.source {
            Source::Npz(archive) => return archive.array(name)?.select(keep),
            Source::Pickle(pickle) => pickle.numbers(name),
            Source::Torch { pickle, zip, prefix } => match pickle.numbers(name) {
                Some(Numbers::Tensor(tensor)) => {
                    let bytes = stored(zip, &format!("{prefix}/data/{}", tensor.key), file)?;
                    let view =
                        tensor_view(tensor, &bytes).ok_or_else(|| broken("a view beyond its storage".to_owned()))?;
                    return collect(&tensor.shape, view, keep).map_err(broken);
                }
                numbers => numbers,
            },
        };
        match numbers {
            Some(Numbers::One(value)) => collect(&[], |_| value, keep).map_err(broken),
            Some(Numbers::Array { kind, big_endian, fortran, shape, bytes }) => {
                let count = shape.iter().try_fold(1, |product: usize, size| product.checked_mul(*size));
                let expected = count.and_then(|count| count.checked_mul(kind.size()));
                if kind.size() == 0 || expected != Some(bytes.len()) {
                    return Err(broken(format!("{} bytes for the shape {shape:?}", bytes.len())));
                }
                let place = |at: usize| if fortran { fortran_place(shape, at) } else { at };
                let value = |at: usize| kind.value(&bytes[place(at) * kind.size()..][..kind.size()], big_endian);
                collect(shape, value, keep).map_err(broken)
            }
            _ => Err(self.missing(name)),
        }
    }

    /// Reads an array of `columns` numbers a row, for a number of rows.
    pub(super) fn table(&mut self, name: &str, rows: usize, columns: usize) -> Result<Vec<f64>, MotionError> {
        let shape = self.shape(name)?;
        if shape != [rows, columns] {
            return Err(self.wrong_shape(name, &format!("[{rows}, {columns}]"), &shape));
        }
        self.select(name, |_, _| true)
    }

    /// Returns an error about an array's shape.
    pub(super) fn wrong_shape(&self, name: &str, expected: &str, got: &[usize]) -> MotionError {
        wrong(self.file, &format!("'{name}' of shape {expected}"), format!("{got:?}"))
    }

    /// Reads a single number, such as the rate.
    pub(super) fn number(&mut self, name: &str) -> Result<f64, MotionError> {
        let shape = self.shape(name)?;
        if shape.iter().product::<usize>() != 1 {
            return Err(self.wrong_shape(name, "[1]", &shape));
        }
        let numbers = self.select(name, |_, _| true)?;
        numbers.first().copied().ok_or_else(|| self.missing(name))
    }

    /// Reads texts, of an array or a list.
    pub(super) fn texts(&mut self, name: &str) -> Result<Vec<String>, MotionError> {
        match &mut self.source {
            Source::Npz(archive) => archive.array(name)?.texts(),
            Source::Pickle(pickle) | Source::Torch { pickle, .. } => pickle
                .texts(name)
                .ok_or_else(|| wrong(self.file, &format!("'{name}' as texts"), "something else".to_owned())),
        }
    }

    fn missing(&self, name: &str) -> MotionError {
        let got = if self.has(name) { "another value of that name, such as a list".to_owned() } else { self.listed() };
        wrong(self.file, &format!("an array of numbers '{name}'"), got)
    }
}

/// A kind of file with named arrays.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Npz,
    Pickle,
    Torch,
}

/// Gathers the numbers that are kept.
fn collect(
    shape: &[usize],
    value: impl Fn(usize) -> f64,
    keep: impl Fn(usize, usize) -> bool,
) -> Result<Vec<f64>, String> {
    let rows = shape.first().copied().unwrap_or(1);
    let width: usize = shape.iter().skip(1).product();
    let mut kept = Vec::new();
    for at in (0..rows * width).filter(|at| keep(at / width, at % width)) {
        let value = value(at);
        if value.is_nan() || value.abs() > LARGEST {
            return Err(format!("{value} in row {}, column {}", at / width, at % width));
        }
        kept.push(value);
    }
    Ok(kept)
}

/// Returns a tensor's numbers by their place in C order: none if they reach beyond the storage, or repeat what is
/// there.
fn tensor_view<'t>(tensor: &'t Tensor, bytes: &'t [u8]) -> Option<impl Fn(usize) -> f64 + use<'t>> {
    let size = tensor.kind.size();
    let count = tensor.shape.iter().try_fold(1, |product: usize, size| product.checked_mul(*size))?;
    let stored = bytes.len() / size.max(1);
    let axes = || tensor.shape.iter().zip(&tensor.strides);
    let last = axes().try_fold(tensor.offset, |last, (size, stride)| {
        last.checked_add(size.saturating_sub(1).checked_mul(*stride)?)
    })?;
    if size == 0 || count > stored || (count > 0 && last >= stored) {
        return None;
    }
    Some(move |at: usize| {
        let mut rest = at;
        let mut place = tensor.offset;
        for (size, stride) in tensor.shape.iter().zip(&tensor.strides).rev() {
            place += rest % size * stride;
            rest /= size;
        }
        tensor.kind.value(&bytes[place * size..][..size], false)
    })
}

/// Returns a file of a zip that is not compressed, so that it is no larger than the zip.
fn stored(zip: &mut ZipArchive<Cursor<&[u8]>>, name: &str, file: &Path) -> Result<Vec<u8>, MotionError> {
    let broken = |got: String| wrong(file, &format!("'{}' as torch.save writes it", shortened(name)), got);
    let mut entry = zip.by_name(name).map_err(|e| broken(shortened(&e.to_string())))?;
    if entry.compression() != CompressionMethod::Stored {
        return Err(broken("a compressed file".to_owned()));
    }
    let mut bytes = Vec::new();
    entry.read_to_end(&mut bytes).map_err(|e| broken(shortened(&e.to_string())))?;
    Ok(bytes)
}

fn wrong(file: &Path, expected: &str, got: String) -> MotionError {
    MotionError::format(file.display(), expected, got)
}
