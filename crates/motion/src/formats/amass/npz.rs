//! NumPy's `.npz`: a zip of arrays, each a `.npy` file.
//!
//! Only numbers are read, never pickled objects. A header has three keys, so it is read here: the crates that do it bring
//! a parser generator and, for the zip, C libraries.

use std::io::{BufReader, Cursor, Read};
use std::path::Path;

use zip::ZipArchive;
use zip::read::ZipFile;

use crate::error::MotionError;

/// The first bytes of a `.npy` file.
const MAGIC: &[u8] = b"\x93NUMPY";
/// No header of numbers is longer (bytes).
const LONGEST_HEADER: usize = 1 << 16;
/// No angle (rad), length (m) or rate is larger; anything beyond is a broken file.
const LARGEST: f64 = 1e6;
/// Arrays that a message lists.
const LISTED: usize = 12;

/// Returns whether these are the first bytes of a zip of arrays, or of one array.
pub(super) fn is_start(start: &[u8]) -> bool {
    // A zip begins with its first entry: 30 bytes, the 27th and 28th of which are the length of the name after them.
    let name = start.strip_prefix(b"PK\x03\x04").and_then(|rest| {
        let length = usize::from(u16::from_le_bytes([*rest.get(22)?, *rest.get(23)?]));
        rest.get(26..26 + length)
    });
    start.starts_with(MAGIC) || name.is_some_and(|name| name.ends_with(b".npy"))
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
                let got = "one array (.npy), such as HumanML3D's processed joints: no motion of AMASS";
                Err(wrong(file, "a zip of arrays (.npz)".to_owned(), got.to_owned()))
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
    pub(super) fn array(&mut self, name: &'static str) -> Result<Array<'_, 'a>, MotionError> {
        let file = self.file;
        let broken = |got: String| wrong(file, format!("array '{name}' as NumPy writes it"), got);
        let entry = self.zip.by_name(&format!("{name}.npy")).map_err(|e| broken(shortened(&e.to_string())))?;
        let mut values = BufReader::new(entry);
        let header = Header::read(&mut values).map_err(broken)?;
        Ok(Array { file, name, header, values })
    }

    pub(super) fn wrong(&self, expected: String, got: String) -> MotionError {
        wrong(self.file, expected, got)
    }
}

/// An array whose numbers are still to be read.
pub(super) struct Array<'z, 'a> {
    file: &'a Path,
    name: &'static str,
    header: Header,
    values: BufReader<ZipFile<'z, Cursor<&'a [u8]>>>,
}

impl Array<'_, '_> {
    pub(super) fn shape(&self) -> &[usize] {
        &self.header.shape
    }

    /// Returns an error about the shape, which is another than `expected`.
    pub(super) fn wrong_shape(&self, expected: &str) -> MotionError {
        wrong(self.file, format!("array '{}' {expected}", self.name), format!("{:?}", self.header.shape))
    }

    /// Reads a table, or a single number as a table of one: the first `columns` of each row, row after row. Memory grows
    /// with what is there, not with what the header says.
    pub(super) fn rows(mut self, columns: usize) -> Result<Vec<f64>, MotionError> {
        let (rows, width) = match *self.header.shape.as_slice() {
            [rows, width] => (rows, width),
            _ => (1, 1),
        };
        let Some(count) = rows.checked_mul(width) else { return Err(self.wrong_shape("that fits into memory")) };
        let mut kept = Vec::new();
        for at in 0..count {
            let value = self.next_value(|| format!("the end after {at} of {count} numbers"))?;
            let (row, column) = if self.header.fortran { (at % rows, at / rows) } else { (at / width, at % width) };
            if column >= columns {
                continue;
            }
            if value.is_nan() || value.abs() > LARGEST {
                let expected = format!("array '{}' of finite numbers below a million", self.name);
                return Err(wrong(self.file, expected, format!("{value} in row {row}, column {column}")));
            }
            kept.push(value);
        }
        // Reading to the end is what makes the zip check its sum.
        let after = self.values.read(&mut [0]).map_err(|e| self.broken(shortened(&e.to_string())))?;
        if after > 0 {
            return Err(self.broken(format!("more than {count} numbers")));
        }
        if self.header.fortran && rows > 0 {
            let columns = kept.len() / rows;
            return Ok((0..kept.len()).map(|at| kept[at % columns * rows + at / columns]).collect());
        }
        Ok(kept)
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

/// What an array's numbers are, as NumPy's `descr` says after the order of bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    F4,
    F8,
    I4,
    I8,
}

impl Kind {
    fn size(self) -> usize {
        match self {
            Self::F4 | Self::I4 => 4,
            Self::F8 | Self::I8 => 8,
        }
    }

    /// Returns the number that these bytes are; there are [`Self::size`] of them.
    fn value(self, bytes: &[u8], big_endian: bool) -> f64 {
        let bits = |all: u64, byte: &u8| (all << 8) | u64::from(*byte);
        let bits = if big_endian { bytes.iter().fold(0, bits) } else { bytes.iter().rev().fold(0, bits) };
        match self {
            Self::F4 => f64::from(f32::from_bits(bits as u32)),
            Self::F8 => f64::from_bits(bits),
            Self::I4 => f64::from(bits as u32 as i32),
            Self::I8 => bits as i64 as f64,
        }
    }
}

/// The header of an array.
struct Header {
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
        let number = match letters {
            "f4" => Kind::F4,
            "f8" => Kind::F8,
            "i4" => Kind::I4,
            "i8" => Kind::I8,
            _ => return Err(format!("values of type '{}', not f4, f8, i4 or i8", shortened(kind))),
        };
        let fortran = value("fortran_order").ok_or_else(odd)?.starts_with("True");
        let shape = value("shape").and_then(|s| s.strip_prefix('(')?.split_once(')')).ok_or_else(odd)?.0;
        // Python 2 wrote 100L.
        let sizes = shape.split(',').map(|size| size.trim().trim_end_matches('L')).filter(|size| !size.is_empty());
        let shape: Result<Vec<usize>, _> = sizes.map(str::parse).collect();
        Ok(Self { kind: number, big_endian: order == ">", fortran, shape: shape.map_err(|_| odd())? })
    }
}

fn wrong(file: &Path, expected: String, got: String) -> MotionError {
    MotionError::Container { file: file.to_path_buf(), expected, got }
}

/// Returns the beginning of a text, so that no message carries a whole file.
fn shortened(text: &str) -> String {
    text.chars().take(80).collect()
}
