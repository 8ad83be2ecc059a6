//! The messages of an ONNX file, as far as policies use them (onnx.proto, ONNX 1.19, Apache-2.0).
//!
//! Field numbers and types are the published ones. Fields that are not here are skipped in reading.

use prost::Message;

/// A file.
#[derive(Clone, PartialEq, Message)]
pub struct Model {
    /// Version of the format.
    #[prost(int64, optional, tag = "1")]
    pub ir_version: Option<i64>,
    /// The program that wrote it.
    #[prost(string, optional, tag = "2")]
    pub producer_name: Option<String>,
    /// Its version.
    #[prost(string, optional, tag = "3")]
    pub producer_version: Option<String>,
    /// The network.
    #[prost(message, optional, tag = "7")]
    pub graph: Option<Graph>,
    /// Versions of the operators.
    #[prost(message, repeated, tag = "8")]
    pub opset_import: Vec<OperatorSet>,
    /// Named texts.
    #[prost(message, repeated, tag = "14")]
    pub metadata_props: Vec<Property>,
}

/// A set of operators.
#[derive(Clone, PartialEq, Message)]
pub struct OperatorSet {
    /// Empty: ONNX's own.
    #[prost(string, optional, tag = "1")]
    pub domain: Option<String>,
    /// Its version.
    #[prost(int64, optional, tag = "2")]
    pub version: Option<i64>,
}

/// A named text.
#[derive(Clone, PartialEq, Message)]
pub struct Property {
    /// Name.
    #[prost(string, optional, tag = "1")]
    pub key: Option<String>,
    /// Text.
    #[prost(string, optional, tag = "2")]
    pub value: Option<String>,
}

/// A network.
#[derive(Clone, PartialEq, Message)]
pub struct Graph {
    /// Operations, each after those that it needs.
    #[prost(message, repeated, tag = "1")]
    pub node: Vec<Node>,
    /// Its name.
    #[prost(string, optional, tag = "2")]
    pub name: Option<String>,
    /// Constants.
    #[prost(message, repeated, tag = "5")]
    pub initializer: Vec<Tensor>,
    /// Inputs.
    #[prost(message, repeated, tag = "11")]
    pub input: Vec<Value>,
    /// Outputs.
    #[prost(message, repeated, tag = "12")]
    pub output: Vec<Value>,
}

/// An operation.
#[derive(Clone, PartialEq, Message)]
pub struct Node {
    /// Names of its inputs; empty: left out.
    #[prost(string, repeated, tag = "1")]
    pub input: Vec<String>,
    /// Names of its outputs.
    #[prost(string, repeated, tag = "2")]
    pub output: Vec<String>,
    /// Its name.
    #[prost(string, optional, tag = "3")]
    pub name: Option<String>,
    /// Operator.
    #[prost(string, optional, tag = "4")]
    pub op_type: Option<String>,
    /// Settings.
    #[prost(message, repeated, tag = "5")]
    pub attribute: Vec<Attribute>,
}

/// A setting of an operation.
#[derive(Clone, PartialEq, Message)]
pub struct Attribute {
    /// Its name.
    #[prost(string, optional, tag = "1")]
    pub name: Option<String>,
    /// A number.
    #[prost(float, optional, tag = "2")]
    pub f: Option<f32>,
    /// A whole number.
    #[prost(int64, optional, tag = "3")]
    pub i: Option<i64>,
    /// An array.
    #[prost(message, optional, tag = "5")]
    pub t: Option<Tensor>,
    /// Whole numbers.
    #[prost(int64, repeated, packed = "false", tag = "8")]
    pub ints: Vec<i64>,
    /// Which of them: 1 `f`, 2 `i`, 4 `t`, 7 `ints`.
    #[prost(int32, optional, tag = "20")]
    pub kind: Option<i32>,
}

/// An array.
#[derive(Clone, PartialEq, Message)]
pub struct Tensor {
    /// Its shape.
    #[prost(int64, repeated, packed = "false", tag = "1")]
    pub dims: Vec<i64>,
    /// [`FLOAT`], [`INT64`] or [`DOUBLE`].
    #[prost(int32, optional, tag = "2")]
    pub data_type: Option<i32>,
    /// Numbers, if not raw.
    #[prost(float, repeated, tag = "4")]
    pub float_data: Vec<f32>,
    /// Whole numbers, if not raw.
    #[prost(int64, repeated, tag = "7")]
    pub int64_data: Vec<i64>,
    /// Its name.
    #[prost(string, optional, tag = "8")]
    pub name: Option<String>,
    /// Little-endian numbers.
    #[prost(bytes = "vec", optional, tag = "9")]
    pub raw_data: Option<Vec<u8>>,
    /// 1: the numbers are in another file.
    #[prost(int32, optional, tag = "14")]
    pub data_location: Option<i32>,
}

/// A named input or output.
#[derive(Clone, PartialEq, Message)]
pub struct Value {
    /// Its name.
    #[prost(string, optional, tag = "1")]
    pub name: Option<String>,
    /// Its type.
    #[prost(message, optional, tag = "2")]
    pub kind: Option<Type>,
}

/// A type.
#[derive(Clone, PartialEq, Message)]
pub struct Type {
    /// Of an array.
    #[prost(message, optional, tag = "1")]
    pub tensor_type: Option<TensorType>,
}

/// Type of an array.
#[derive(Clone, PartialEq, Message)]
pub struct TensorType {
    /// Type of its numbers.
    #[prost(int32, optional, tag = "1")]
    pub elem_type: Option<i32>,
    /// Its shape.
    #[prost(message, optional, tag = "2")]
    pub shape: Option<Shape>,
}

/// A shape.
#[derive(Clone, PartialEq, Message)]
pub struct Shape {
    /// Its sizes.
    #[prost(message, repeated, tag = "1")]
    pub dim: Vec<Dimension>,
}

/// One size: a number, or a name for any.
#[derive(Clone, PartialEq, Message)]
pub struct Dimension {
    /// The number.
    #[prost(int64, optional, tag = "1")]
    pub dim_value: Option<i64>,
    /// The name.
    #[prost(string, optional, tag = "2")]
    pub dim_param: Option<String>,
}

/// Single precision.
pub const FLOAT: i32 = 1;
/// Whole numbers.
pub const INT64: i32 = 7;
/// Double precision.
pub const DOUBLE: i32 = 11;

impl Tensor {
    /// An array of numbers.
    pub fn floats(name: &str, shape: &[usize], values: &[f32]) -> Self {
        Self {
            dims: shape.iter().map(|&n| n as i64).collect(),
            data_type: Some(FLOAT),
            name: Some(name.into()),
            raw_data: Some(values.iter().flat_map(|x| x.to_le_bytes()).collect()),
            ..Self::default()
        }
    }

    /// An array of whole numbers.
    pub fn whole(name: &str, shape: &[usize], values: &[i64]) -> Self {
        Self {
            dims: shape.iter().map(|&n| n as i64).collect(),
            data_type: Some(INT64),
            name: Some(name.into()),
            raw_data: Some(values.iter().flat_map(|x| x.to_le_bytes()).collect()),
            ..Self::default()
        }
    }

    /// Its shape; none where a size is no length.
    pub fn shape(&self) -> Option<Vec<usize>> {
        self.dims.iter().map(|&n| usize::try_from(n).ok()).collect()
    }

    /// Its numbers; none where they are elsewhere, of another kind, not as many as its shape says, or no numbers.
    pub fn values(&self) -> Option<Vec<f32>> {
        if self.data_location == Some(1) {
            return None;
        }
        let raw = self.raw_data.as_deref();
        let values: Vec<f32> = match (self.data_type?, raw) {
            (FLOAT, Some(raw)) => raw.as_chunks::<4>().0.iter().map(|b| f32::from_le_bytes(*b)).collect(),
            (FLOAT, None) => self.float_data.clone(),
            (DOUBLE, Some(raw)) => raw.as_chunks::<8>().0.iter().map(|b| f64::from_le_bytes(*b) as f32).collect(),
            (INT64, Some(raw)) => raw.as_chunks::<8>().0.iter().map(|b| i64::from_le_bytes(*b) as f32).collect(),
            (INT64, None) => self.int64_data.iter().map(|n| *n as f32).collect(),
            _ => return None,
        };
        let count = self.shape()?.iter().try_fold(1_usize, |count, size| count.checked_mul(*size))?;
        (values.len() == count && values.iter().all(|x| !x.is_nan())).then_some(values)
    }
}

impl Value {
    /// An input or output of numbers; a size of 0 is any.
    pub fn floats(name: &str, shape: &[usize]) -> Self {
        let size = |n: &usize| match n {
            0 => Dimension { dim_param: Some("batch".into()), dim_value: None },
            n => Dimension { dim_value: Some(*n as i64), dim_param: None },
        };
        let shape = Shape { dim: shape.iter().map(size).collect() };
        let tensor_type = TensorType { elem_type: Some(FLOAT), shape: Some(shape) };
        Self { name: Some(name.into()), kind: Some(Type { tensor_type: Some(tensor_type) }) }
    }

    /// Its last size, where it is a number.
    pub fn width(&self) -> Option<usize> {
        let shape = self.kind.as_ref()?.tensor_type.as_ref()?.shape.as_ref()?;
        usize::try_from(shape.dim.last()?.dim_value?).ok()
    }
}
