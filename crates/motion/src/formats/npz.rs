//! NumPy's `.npz`: a zip of arrays, each a `.npy` file.
//!
//! Numbers and texts are read; lists of texts that NumPy pickled go through [`Pickle`], which executes nothing. A
//! header has three keys, so it is read here: the crates that do it bring a parser generator and, for the zip, C
//! libraries.

use std::io::{BufReader, Cursor, Read, Write};
use std::path::Path;

use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipArchive, ZipWriter};

use super::robot_motion::Pickle;
use crate::{FromInput, MotionError};

/// The first bytes of a `.npy` file.
const MAGIC: &[u8] = b"\x93NUMPY";
/// No header of numbers is longer (bytes).
const LONGEST_HEADER: usize = 1 << 16;
/// No angle (rad), length (m) or rate is larger; anything beyond is a broken file.
const LARGEST: f64 = 1e6;
/// Arrays that a message lists.
const LISTED: usize = 12;
/// Numbers that are kept of one array: five hours of a robot's bodies at 50 frames per second.
const MOST_NUMBERS: usize = 1 << 26;
/// Bytes of the texts of one array.
const MOST_TEXT: u64 = 1 << 22;

/// Returns whether these are the first bytes of a zip of arrays, or of one array.
pub(super) fn is_start(start: &[u8]) -> bool {
    // A zip begins with its first entry: 30 bytes, the 27th and 28th of which are the length of the name after them.
    let name = start.strip_prefix(b"PK\x03\x04").and_then(|rest| {
        let length = usize::from(u16::from_le_bytes([*rest.get(22)?, *rest.get(23)?]));
        rest.get(26..26 + length)
    });
    start.starts_with(MAGIC) || name.is_some_and(|name| name.ends_with(b".npy"))
}

/// Returns whether one of these arrays is among the files in a zip.
pub(super) fn has_any(entries: &[String], names: &[&str]) -> bool {
    entries.iter().any(|entry| entry.strip_suffix(".npy").is_some_and(|name| names.contains(&name)))
}

/// A file with named arrays.
pub(super) struct Archive<'a> {
    zip: ZipArchive<Cursor<&'a [u8]>>,
    file: &'a Path,
}

impl<'a> Archive<'a> {
    pub(super) fn open(bytes: &'a [u8], file: &'a Path) -> Result<Self, MotionError> {
        match ZipArchive::new(Cursor::new(bytes)) {
            Ok(zip) => Ok(Self { zip, file }),
            Err(_) if bytes.starts_with(MAGIC) => {
                let shape = single(bytes, file)?.header.shape;
                let got =
                    format!("one array (.npy) of shape {shape:?}; HumanML3D's are [frames, 263] or [frames, 22, 3]");
                Err(wrong(file, "a zip of arrays (.npz)".to_owned(), got))
            }
            Err(error) => Err(wrong(file, "a zip of arrays (.npz)".to_owned(), shortened(&error.to_string()))),
        }
    }

    pub(super) fn has(&self, name: &str) -> bool {
        self.zip.index_for_name(&format!("{name}.npy")).is_some()
    }

    /// Returns the names of the arrays, for messages.
    pub(super) fn listed(&self) -> String {
        let mut names: Vec<&str> = self.zip.file_names().map(|n| n.strip_suffix(".npy").unwrap_or(n)).collect();
        names.sort_unstable();
        match names.as_slice() {
            [] => "no array".to_owned(),
            [name] => format!("array {}", shortened(name)),
            names => {
                let some: Vec<String> = names.iter().take(LISTED).map(|name| shortened(name)).collect();
                let more = if names.len() > LISTED { ", ..." } else { "" };
                format!("arrays {}{more}", some.join(", "))
            }
        }
    }

    /// Opens an array and reads its header.
    pub(super) fn array<'n>(&mut self, name: &'n str) -> Result<Array<'_, 'a, 'n>, MotionError> {
        let file = self.file;
        let broken = |got: String| wrong(file, format!("array '{name}' as NumPy writes it"), got);
        let entry = self.zip.by_name(&format!("{name}.npy")).map_err(|e| broken(shortened(&e.to_string())))?;
        let mut values: BufReader<Box<dyn Read>> = BufReader::new(Box::new(entry));
        let header = Header::read(&mut values).map_err(broken)?;
        Ok(Array { file, name, header, values })
    }

    pub(super) fn wrong(&self, expected: String, got: String) -> MotionError {
        wrong(self.file, expected, got)
    }
}

/// Opens a file of one array (`.npy`).
pub(super) fn single<'a>(bytes: &'a [u8], file: &'a Path) -> Result<Array<'a, 'a, 'static>, MotionError> {
    let name = "file";
    let broken = |got: String| wrong(file, "an array as NumPy writes it (.npy)".to_owned(), got);
    let mut values: BufReader<Box<dyn Read>> = BufReader::new(Box::new(bytes));
    let header = Header::read(&mut values).map_err(broken)?;
    Ok(Array { file, name, header, values })
}

/// An array whose numbers are still to be read.
pub(super) struct Array<'z, 'a, 'n> {
    file: &'a Path,
    name: &'n str,
    header: Header,
    values: BufReader<Box<dyn Read + 'z>>,
}

impl Array<'_, '_, '_> {
    pub(super) fn shape(&self) -> &[usize] {
        &self.header.shape
    }

    /// Returns an error about the shape, which is another than `expected`.
    pub(super) fn wrong_shape(&self, expected: &str) -> MotionError {
        wrong(self.file, format!("array '{}' {expected}", self.name), format!("{:?}", self.header.shape))
    }

    /// Reads a table, or a single number as a table of one: the first `columns` of each row, row after row.
    pub(super) fn rows(self, columns: usize) -> Result<Vec<f64>, MotionError> {
        self.select(|_, column| column < columns)
    }

    /// Reads the numbers of these rows and columns, row after row: all axes after the first are columns. Memory grows
    /// with the numbers that are in the file, not with the header's shape.
    pub(super) fn select(mut self, keep: impl Fn(usize, usize) -> bool) -> Result<Vec<f64>, MotionError> {
        let shape = &self.header.shape;
        let rows = shape.first().copied().unwrap_or(1);
        let width = shape.iter().skip(1).try_fold(1, |product: usize, size| product.checked_mul(*size));
        let Some((width, count)) = width.and_then(|width| Some((width, rows.checked_mul(width)?))) else {
            return Err(self.wrong_shape("that fits into memory"));
        };
        if matches!(self.header.kind, Kind::Text(_) | Kind::Object) {
            return Err(
                self.broken(format!("values of type '{}', not f2, f4, f8, i1 to i8 or u1 to u8", self.header.descr))
            );
        }
        let shape = shape.clone();
        let fortran = if self.header.fortran { Some(self.values_in_a_row(count)?) } else { None };
        let mut kept = Vec::new();
        for at in 0..count {
            let value = match &fortran {
                Some(values) => values[fortran_place(&shape, at)],
                None => self.next_value(|| format!("the end after {at} of {count} numbers"))?,
            };
            let (row, column) = (at / width, at % width);
            if !keep(row, column) {
                continue;
            }
            if value.is_nan() || value.abs() > LARGEST {
                let expected = format!("array '{}' of finite numbers below a million", self.name);
                return Err(wrong(self.file, expected, format!("{value} in row {row}, column {column}")));
            }
            if kept.len() >= MOST_NUMBERS {
                return Err(self.broken(format!("more than {MOST_NUMBERS} numbers, which is the limit")));
            }
            kept.push(value);
        }
        // Reading to the end is what makes the zip check its sum.
        let after = self.values.read(&mut [0]).map_err(|e| self.broken(shortened(&e.to_string())))?;
        if after > 0 {
            return Err(self.broken(format!("more than {count} numbers")));
        }
        Ok(kept)
    }

    /// Reads all numbers in the order of the file.
    fn values_in_a_row(&mut self, count: usize) -> Result<Vec<f64>, MotionError> {
        if count > MOST_NUMBERS {
            return Err(self.broken(format!("more than {MOST_NUMBERS} numbers, which is the limit")));
        }
        let mut values = Vec::new();
        for at in 0..count {
            values.push(self.next_value(|| format!("the end after {at} of {count} numbers"))?);
        }
        Ok(values)
    }

    /// Reads texts: of fixed width, or a list that NumPy pickled.
    pub(super) fn texts(mut self) -> Result<Vec<String>, MotionError> {
        let mut bytes = Vec::new();
        let read = (&mut self.values).take(MOST_TEXT).read_to_end(&mut bytes);
        read.map_err(|e| self.broken(shortened(&e.to_string())))?;
        match self.header.kind {
            Kind::Text(width) if width > 0 => {
                let big_endian = self.header.big_endian;
                let letter = |c: &[u8; 4]| if big_endian { u32::from_be_bytes(*c) } else { u32::from_le_bytes(*c) };
                let letters: Vec<u32> = bytes.as_chunks::<4>().0.iter().map(letter).collect();
                let text = |text: &[u32]| text.iter().filter(|c| **c != 0).filter_map(|c| char::from_u32(*c)).collect();
                Ok(letters.chunks_exact(width).map(text).collect())
            }
            Kind::Object => Pickle::parse(&bytes, self.file)?.top_texts(),
            _ => Err(self.broken("numbers where texts are expected".to_owned())),
        }
    }

    fn next_value(&mut self, at_end: impl Fn() -> String) -> Result<f64, MotionError> {
        let mut bytes = [0; 8];
        let bytes = &mut bytes[..self.header.kind.size()];
        match self.values.read_exact(bytes) {
            Ok(()) => Ok(self.header.kind.value(bytes, self.header.big_endian)),
            Err(e) if e.kind() == std::io::ErrorKind::UnexpectedEof => Err(self.broken(at_end())),
            Err(e) => Err(self.broken(shortened(&e.to_string()))),
        }
    }

    fn broken(&self, got: String) -> MotionError {
        wrong(self.file, format!("array '{}' of shape {:?}", self.name, self.header.shape), got)
    }
}

/// Kind of an array's numbers, as NumPy's `descr` says after the order of bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    /// Floating-point number of 2, 4 or 8 bytes.
    Float(usize),
    /// Whole number of 1, 2, 4 or 8 bytes.
    Signed(usize),
    /// Likewise without a sign; a flag is one byte.
    Unsigned(usize),
    /// Texts of a fixed number of letters.
    Text(usize),
    /// Pickled objects.
    Object,
}

impl Kind {
    /// Returns the kind of a `descr` without the order of bytes.
    pub(super) fn of(letters: &str) -> Option<Self> {
        Some(match letters {
            "f2" => Self::Float(2),
            "f4" => Self::Float(4),
            "f8" => Self::Float(8),
            "i1" => Self::Signed(1),
            "i2" => Self::Signed(2),
            "i4" => Self::Signed(4),
            "i8" => Self::Signed(8),
            "u1" | "b1" => Self::Unsigned(1),
            "u2" => Self::Unsigned(2),
            "u4" => Self::Unsigned(4),
            "u8" => Self::Unsigned(8),
            "O" | "O8" => Self::Object,
            text => Self::Text(text.strip_prefix('U')?.parse().ok().filter(|width| *width < 1 << 16)?),
        })
    }

    /// Returns the bytes of a number; 0 for texts and objects, which are no numbers.
    pub(super) fn size(self) -> usize {
        match self {
            Self::Float(size) | Self::Signed(size) | Self::Unsigned(size) => size,
            Self::Text(_) | Self::Object => 0,
        }
    }

    /// Returns the number that these bytes are; there are [`Self::size`] of them.
    pub(super) fn value(self, bytes: &[u8], big_endian: bool) -> f64 {
        let bits = |all: u64, byte: &u8| (all << 8) | u64::from(*byte);
        let bits = if big_endian { bytes.iter().fold(0, bits) } else { bytes.iter().rev().fold(0, bits) };
        match self {
            Self::Float(2) => half(bits as u16),
            Self::Float(4) => f64::from(f32::from_bits(bits as u32)),
            Self::Float(_) => f64::from_bits(bits),
            // The sign goes to the top, and comes back down with the number.
            Self::Signed(size) => ((bits << (64 - 8 * size)) as i64 >> (64 - 8 * size)) as f64,
            Self::Unsigned(_) => bits as f64,
            Self::Text(_) | Self::Object => f64::NAN,
        }
    }
}

/// Returns the number that 16 bits are: a sign, 5 bits of exponent, 10 of fraction (IEEE 754).
fn half(bits: u16) -> f64 {
    let (exponent, fraction) = (i32::from(bits >> 10 & 31), f64::from(bits & 1023));
    let size = match exponent {
        0 => fraction * 2f64.powi(-24),
        31 if fraction == 0.0 => f64::INFINITY,
        31 => f64::NAN,
        _ => (1024.0 + fraction) * 2f64.powi(exponent - 25),
    };
    if bits >> 15 == 0 { size } else { -size }
}

/// The header of an array.
struct Header {
    /// Kind of numbers as the file writes it.
    descr: String,
    kind: Kind,
    big_endian: bool,
    /// The first index runs fastest, not the last.
    fortran: bool,
    shape: Vec<usize>,
}

impl Header {
    /// Reads it, or says what is there instead.
    fn read(from: &mut impl Read) -> Result<Self, String> {
        let cut = |e: std::io::Error| format!("a header that breaks off ({})", shortened(&e.to_string()));
        let mut start = [0; 8];
        from.read_exact(&mut start).map_err(cut)?;
        if !start.starts_with(MAGIC) {
            return Err("something that is no .npy".to_owned());
        }
        let mut length = [0; 4];
        let digits = if start[6] == 1 { 2 } else { 4 };
        from.read_exact(&mut length[..digits]).map_err(cut)?;
        let length = u32::from_le_bytes(length) as usize;
        if length > LONGEST_HEADER {
            return Err(format!("a header of {length} bytes"));
        }
        let mut text = vec![0; length];
        from.read_exact(&mut text).map_err(cut)?;
        Self::parse(&String::from_utf8_lossy(&text))
    }

    /// Reads `{'descr': '<f8', 'fortran_order': False, 'shape': (100, 156), }`.
    fn parse(text: &str) -> Result<Self, String> {
        let odd = || format!("the header {}", shortened(text.trim()));
        let value = |key: &str| {
            let quoted = [format!("'{key}'"), format!("\"{key}\"")];
            let after = quoted.iter().find_map(|quoted| text.split_once(quoted.as_str()))?.1;
            Some(after.trim_start().strip_prefix(':')?.trim_start())
        };
        let kind = value("descr").ok_or_else(odd)?;
        let kind = kind.strip_prefix(['\'', '"']).and_then(|kind| kind.split(['\'', '"']).next()).ok_or_else(odd)?;
        let (order, letters) = kind.split_at_checked(1).ok_or_else(odd)?;
        let number = Kind::of(letters);
        let number = number
            .ok_or_else(|| format!("values of type '{}', not f2, f4, f8, i1 to i8 or u1 to u8", shortened(kind)))?;
        let fortran = value("fortran_order").ok_or_else(odd)?.starts_with("True");
        let shape = value("shape").and_then(|s| s.strip_prefix('(')?.split_once(')')).ok_or_else(odd)?.0;
        // Python 2 wrote 100L.
        let sizes = shape.split(',').map(|size| size.trim().trim_end_matches('L')).filter(|size| !size.is_empty());
        let shape: Result<Vec<usize>, _> = sizes.map(str::parse).collect();
        Ok(Self {
            descr: shortened(kind),
            kind: number,
            big_endian: order == ">",
            fortran,
            shape: shape.map_err(|_| odd())?,
        })
    }
}

/// Returns the place in Fortran order (the first index runs fastest) of a place in C order (the last one does).
pub(super) fn fortran_place(shape: &[usize], at: usize) -> usize {
    let mut stride: usize = shape.iter().product();
    let (mut rest, mut place) = (at, 0);
    for size in shape.iter().rev().map(|size| (*size).max(1)) {
        stride /= size;
        place += rest % size * stride;
        rest /= size;
    }
    place
}

/// An array to be written, in C order and with the lowest byte first.
pub(super) struct Written {
    pub(super) name: &'static str,
    /// NumPy's `descr`.
    pub(super) descr: String,
    pub(super) shape: Vec<usize>,
    pub(super) bytes: Vec<u8>,
}

impl Written {
    /// Returns an array of 32-bit numbers.
    pub(super) fn f32(name: &'static str, shape: &[usize], values: &[f64]) -> Self {
        let bytes = values.iter().flat_map(|value| (*value as f32).to_le_bytes()).collect();
        Self { name, descr: "<f4".to_owned(), shape: shape.to_vec(), bytes }
    }

    /// Returns an array of 64-bit numbers.
    pub(super) fn f64(name: &'static str, shape: &[usize], values: &[f64]) -> Self {
        let bytes = values.iter().flat_map(|value| value.to_le_bytes()).collect();
        Self { name, descr: "<f8".to_owned(), shape: shape.to_vec(), bytes }
    }

    /// Returns an array of whole numbers.
    pub(super) fn i64(name: &'static str, values: &[i64]) -> Self {
        let bytes = values.iter().flat_map(|value| value.to_le_bytes()).collect();
        Self { name, descr: "<i8".to_owned(), shape: vec![values.len()], bytes }
    }

    /// Returns an array of flags, 0 or 1.
    pub(super) fn flags(name: &'static str, shape: &[usize], bytes: Vec<u8>) -> Self {
        Self { name, descr: "|b1".to_owned(), shape: shape.to_vec(), bytes }
    }

    /// Returns an array of texts.
    pub(super) fn texts(name: &'static str, texts: &[String]) -> Self {
        let width = texts.iter().map(|text| text.chars().count()).max().unwrap_or(0).max(1);
        let letters = |text: &String| -> Vec<u32> {
            text.chars().map(u32::from).chain(std::iter::repeat(0)).take(width).collect()
        };
        let bytes = texts.iter().flat_map(letters).flat_map(u32::to_le_bytes).collect();
        Self { name, descr: format!("<U{width}"), shape: vec![texts.len()], bytes }
    }

    fn npy(&self) -> Vec<u8> {
        let shape: String = self.shape.iter().map(|size| format!("{size}, ")).collect();
        let header =
            format!("{{'descr': '{}', 'fortran_order': False, 'shape': ({}), }}", self.descr, shape.trim_end());
        let padding = 63 - (MAGIC.len() + 4 + header.len()) % 64;
        let header = header + &" ".repeat(padding) + "\n";
        let length = (header.len() as u16).to_le_bytes();
        [MAGIC, &[1, 0], &length, header.as_bytes(), &self.bytes].concat()
    }
}

/// Returns an `.npz` of arrays, as `numpy.savez` writes it.
pub(super) fn npz(arrays: &[Written]) -> std::io::Result<Vec<u8>> {
    zipped(arrays.iter().map(|array| (format!("{}.npy", array.name), array.npy())))
}

/// Returns a zip of files that are not compressed.
pub(super) fn zipped(files: impl Iterator<Item = (String, Vec<u8>)>) -> std::io::Result<Vec<u8>> {
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    let options = SimpleFileOptions::default().compression_method(CompressionMethod::Stored);
    for (name, bytes) in files {
        zip.start_file(name, options)?;
        zip.write_all(&bytes)?;
    }
    Ok(zip.finish()?.into_inner())
}

fn wrong(file: &Path, expected: String, got: String) -> MotionError {
    MotionError::format(file.display(), expected, got)
}

/// Returns the beginning of a text, so that no message carries a whole file.
pub(super) fn shortened(text: &str) -> String {
    text.chars().take(80).collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn an_array_in_fortran_order_is_read_by_its_indices() {
        // NumPy keeps `a[:, [2, 0, 1]]` in this order. The value at [i, j, k] is 100 i + 10 j + k.
        let mut bytes = b"\x93NUMPY\x01\x00\x3c\x00".to_vec();
        bytes.extend(format!("{:59}\n", "{'descr': '<f8', 'fortran_order': True, 'shape': (2, 3, 2)}").bytes());
        let value = |i: u32, j: u32, k: u32| f64::from(100 * i + 10 * j + k);
        for (k, j, i) in (0..2).flat_map(|k| (0..3).flat_map(move |j| (0..2).map(move |i| (k, j, i)))) {
            bytes.extend(value(i, j, k).to_le_bytes());
        }
        let select = |keep: fn(usize, usize) -> bool| single(&bytes, Path::new("a.npy")).unwrap().select(keep).unwrap();
        assert_eq!(select(|_, _| true), [0, 1, 10, 11, 20, 21, 100, 101, 110, 111, 120, 121].map(f64::from));
        assert_eq!(select(|row, _| row == 1), [100, 101, 110, 111, 120, 121].map(f64::from));
        assert_eq!(select(|_, column| column < 2), [0, 1, 100, 101].map(f64::from));
    }
}
