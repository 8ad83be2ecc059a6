//! One named array of a checkpoint.

/// Type of an entry's numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// 32-bit floating point.
    F32,
    /// 64-bit floating point.
    F64,
    /// 64-bit unsigned integers.
    U64,
    /// Bytes.
    U8,
}

/// Shape and numbers, row-major.
#[derive(Debug, Clone, PartialEq)]
pub enum Entry {
    /// 32-bit floating point.
    F32(Vec<usize>, Vec<f32>),
    /// 64-bit floating point.
    F64(Vec<usize>, Vec<f64>),
    /// 64-bit unsigned integers.
    U64(Vec<usize>, Vec<u64>),
    /// Bytes.
    U8(Vec<usize>, Vec<u8>),
}

impl Entry {
    /// Returns the type of the numbers.
    pub fn kind(&self) -> Kind {
        match self {
            Self::F32(..) => Kind::F32,
            Self::F64(..) => Kind::F64,
            Self::U64(..) => Kind::U64,
            Self::U8(..) => Kind::U8,
        }
    }

    /// Returns the extent of each dimension.
    pub fn shape(&self) -> &[usize] {
        match self {
            Self::F32(s, _) | Self::F64(s, _) | Self::U64(s, _) | Self::U8(s, _) => s,
        }
    }

    /// Returns the number of its numbers.
    pub fn count(&self) -> usize {
        match self {
            Self::F32(_, v) => v.len(),
            Self::F64(_, v) => v.len(),
            Self::U64(_, v) => v.len(),
            Self::U8(_, v) => v.len(),
        }
    }

    /// Returns little-endian bytes.
    pub(super) fn to_bytes(&self) -> Vec<u8> {
        match self {
            Self::F32(_, v) => v.iter().flat_map(|x| x.to_le_bytes()).collect(),
            Self::F64(_, v) => v.iter().flat_map(|x| x.to_le_bytes()).collect(),
            Self::U64(_, v) => v.iter().flat_map(|x| x.to_le_bytes()).collect(),
            Self::U8(_, v) => v.clone(),
        }
    }

    /// Reads little-endian bytes; the length was checked against the shape by the safetensors reader.
    pub(super) fn from_bytes(kind: Kind, shape: Vec<usize>, bytes: &[u8]) -> Self {
        fn numbers<const N: usize, T>(bytes: &[u8], read: fn([u8; N]) -> T) -> Vec<T> {
            bytes.as_chunks::<N>().0.iter().map(|c| read(*c)).collect()
        }
        match kind {
            Kind::F32 => Self::F32(shape, numbers(bytes, f32::from_le_bytes)),
            Kind::F64 => Self::F64(shape, numbers(bytes, f64::from_le_bytes)),
            Kind::U64 => Self::U64(shape, numbers(bytes, u64::from_le_bytes)),
            Kind::U8 => Self::U8(shape, bytes.to_vec()),
        }
    }
}
