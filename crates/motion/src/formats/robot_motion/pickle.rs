//! Pickles of NumPy and PyTorch, read without executing anything.
//!
//! A pickle is a program for a stack machine that may call any function. This reader knows the operations that build
//! numbers, texts, lists, dicts and arrays, and a fixed list of names ([`Global::of`]). Each name is data here: no
//! function is called. Any other operation or name is refused.
//!
//! Values are in one arena and refer to each other by index. A repeated value is therefore there once, nesting costs
//! no stack, and memory is at most proportional to the file.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use crate::formats::npz::{Kind, shortened};
use crate::{FromInput, MotionError};

/// Operations that are read at most.
const MOST_OPERATIONS: usize = 4_000_000;
/// Bytes of the texts of one list at most.
const MOST_TEXT: usize = 1 << 22;
/// Axes of an array at most.
const MOST_AXES: usize = 8;

/// A value's place in the arena.
type Id = usize;

/// A name that a pickle may mention.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Global {
    /// `numpy.core.multiarray._reconstruct`: an empty array, filled by its state.
    Reconstruct,
    /// `numpy.core.numeric._frombuffer`: an array of protocol 5.
    FromBuffer,
    /// `numpy.core.multiarray.scalar`.
    Scalar,
    Ndarray,
    Dtype,
    /// `_codecs.encode`: bytes in protocol 2.
    Encode,
    OrderedDict,
    /// `torch._utils._rebuild_tensor_v2`.
    Tensor,
    /// A class of storages, of this kind of number.
    Storage(Kind),
}

impl Global {
    fn of(module: &str, name: &str) -> Option<Self> {
        let module = module.replace("numpy._core.", "numpy.core.");
        Some(match (module.as_str(), name) {
            ("numpy.core.multiarray", "_reconstruct") => Self::Reconstruct,
            ("numpy.core.multiarray", "scalar") => Self::Scalar,
            ("numpy.core.numeric", "_frombuffer") => Self::FromBuffer,
            ("numpy", "ndarray") => Self::Ndarray,
            ("numpy", "dtype") => Self::Dtype,
            ("_codecs", "encode") => Self::Encode,
            ("collections", "OrderedDict") => Self::OrderedDict,
            ("torch._utils", "_rebuild_tensor_v2") => Self::Tensor,
            ("torch", "FloatStorage") => Self::Storage(Kind::Float(4)),
            ("torch", "HalfStorage") => Self::Storage(Kind::Float(2)),
            ("torch", "DoubleStorage") => Self::Storage(Kind::Float(8)),
            ("torch", "IntStorage") => Self::Storage(Kind::Signed(4)),
            ("torch", "LongStorage") => Self::Storage(Kind::Signed(8)),
            ("torch", "ByteStorage" | "BoolStorage") => Self::Storage(Kind::Unsigned(1)),
            _ => return None,
        })
    }
}

/// A value.
#[derive(Debug, Clone)]
enum Value {
    None,
    Int(i64),
    Float(f64),
    Text(String),
    Bytes(Vec<u8>),
    /// A list or tuple.
    List(Vec<Id>),
    Dict(Vec<(Id, Id)>),
    Global(Global),
    Dtype(Kind, bool),
    Array(Array),
    Storage {
        kind: Kind,
        key: String,
    },
    Tensor(Tensor),
}

/// An array of NumPy.
#[derive(Debug, Clone)]
struct Array {
    kind: Kind,
    big_endian: bool,
    fortran: bool,
    shape: Vec<usize>,
    /// Its bytes, or the list of its objects.
    data: Id,
}

/// A view into a storage of PyTorch.
#[derive(Debug, Clone)]
pub(super) struct Tensor {
    pub(super) kind: Kind,
    /// Name of the storage in the zip.
    pub(super) key: String,
    pub(super) offset: usize,
    pub(super) shape: Vec<usize>,
    pub(super) strides: Vec<usize>,
}

/// Numbers of a shape, or where PyTorch keeps them.
pub(super) enum Numbers<'a> {
    Array { kind: Kind, big_endian: bool, fortran: bool, shape: &'a [usize], bytes: &'a [u8] },
    Tensor(&'a Tensor),
    One(f64),
}

/// A value in a pickle.
#[derive(Debug)]
pub struct Pickle {
    values: Vec<Value>,
    top: Id,
    file: PathBuf,
}

impl Pickle {
    /// Returns whether these bytes begin as a pickle of protocol 2 to 5.
    pub(super) fn is_start(start: &[u8]) -> bool {
        matches!(start, [0x80, 2..=5, ..])
    }

    /// Reads a pickle.
    ///
    /// # Errors
    /// [`MotionError::Input`] for an operation or a name that is not on the list, and for anything that is
    /// broken.
    pub fn parse(bytes: &[u8], file: &Path) -> Result<Self, MotionError> {
        let mut machine =
            Machine { bytes, at: 0, values: Vec::new(), stack: Vec::new(), marks: Vec::new(), memo: HashMap::new() };
        let top = machine.run().map_err(|got| {
            MotionError::format(
                file.display(),
                "a pickle of numbers, texts, lists and arrays (nothing in a file is executed)",
                format!("{got}, at byte {}", machine.at),
            )
        })?;
        Ok(Self { values: machine.values, top, file: file.to_path_buf() })
    }

    /// Returns the keys of the dict that the pickle is; nothing of anything else.
    pub(super) fn keys(&self) -> impl Iterator<Item = &str> {
        self.items().iter().filter_map(|(key, _)| match &self.values[*key] {
            Value::Text(text) => Some(text.as_str()),
            _ => None,
        })
    }

    /// Returns the numbers under a key: none where there is no such key, or something else.
    pub(super) fn numbers(&self, name: &str) -> Option<Numbers<'_>> {
        Some(match self.value(name)? {
            Value::Int(value) => Numbers::One(*value as f64),
            Value::Float(value) => Numbers::One(*value),
            Value::Tensor(tensor) => Numbers::Tensor(tensor),
            Value::Array(array) => {
                let Value::Bytes(bytes) = &self.values[array.data] else { return None };
                let Array { kind, big_endian, fortran, .. } = *array;
                Numbers::Array { kind, big_endian, fortran, shape: &array.shape, bytes }
            }
            _ => return None,
        })
    }

    /// Returns the texts under a key: of a list, or of an array of objects.
    pub(super) fn texts(&self, name: &str) -> Option<Vec<String>> {
        self.texts_of(self.value(name)?)
    }

    /// Returns the texts that the whole pickle is: a list, an array of objects, or one text.
    ///
    /// # Errors
    /// [`MotionError::Input`] for anything else.
    pub fn top_texts(&self) -> Result<Vec<String>, MotionError> {
        self.texts_of(&self.values[self.top])
            .ok_or_else(|| MotionError::format(self.file.display(), "pickled texts", "other objects"))
    }

    fn texts_of(&self, value: &Value) -> Option<Vec<String>> {
        let items = match value {
            Value::Text(text) => return Some(vec![text.clone()]),
            Value::List(items) => items,
            Value::Array(array) => match &self.values[array.data] {
                Value::List(items) => items,
                _ => return None,
            },
            _ => return None,
        };
        let text = |id: &Id| match &self.values[*id] {
            Value::Text(text) => Some(text.as_str()),
            _ => None,
        };
        // A long text that is repeated would be copied for each mention.
        let length: usize = items.iter().filter_map(text).map(str::len).sum();
        (length < MOST_TEXT).then(|| items.iter().map(|id| text(id).map(str::to_owned)).collect())?
    }

    fn value(&self, name: &str) -> Option<&Value> {
        let is_it = |key: &Id| matches!(&self.values[*key], Value::Text(text) if text == name);
        self.items().iter().rev().find(|(key, _)| is_it(key)).map(|(_, value)| &self.values[*value])
    }

    fn items(&self) -> &[(Id, Id)] {
        match &self.values[self.top] {
            Value::Dict(items) => items,
            _ => &[],
        }
    }
}

/// The stack machine.
struct Machine<'a> {
    bytes: &'a [u8],
    at: usize,
    values: Vec<Value>,
    stack: Vec<Id>,
    marks: Vec<usize>,
    memo: HashMap<usize, Id>,
}

type Step<T> = Result<T, String>;

impl<'a> Machine<'a> {
    /// Runs the program; returns its result, or what is wrong with it.
    fn run(&mut self) -> Step<Id> {
        for _ in 0..MOST_OPERATIONS {
            let operation = self.byte()?;
            if operation == b'.' {
                return self.pop();
            }
            self.step(operation)?;
        }
        Err(format!("more than {MOST_OPERATIONS} operations"))
    }

    fn step(&mut self, operation: u8) -> Step<()> {
        match operation {
            0x80 => drop(self.byte()?),
            0x95 => drop(self.take(8)?),
            b'(' => self.marks.push(self.stack.len()),
            b'0' => drop(self.pop()?),
            b'1' => drop(self.above_mark()?),
            b'N' => self.push(Value::None),
            0x88 => self.push(Value::Int(1)),
            0x89 => self.push(Value::Int(0)),
            b'J' | b'K' | b'M' | 0x8a => self.integer(operation)?,
            b'G' => {
                let bytes = self.array::<8>()?;
                self.push(Value::Float(f64::from_be_bytes(bytes)));
            }
            b'X' | 0x8c | 0x8d => {
                let bytes = self.sized(operation)?;
                let text = String::from_utf8(bytes).map_err(|_| "text that is not UTF-8".to_owned())?;
                self.push(Value::Text(text));
            }
            b'U' | b'T' | b'B' | b'C' | 0x8e | 0x96 => {
                let bytes = self.sized(operation)?;
                self.push(Value::Bytes(bytes));
            }
            b']' | b')' => self.push(Value::List(Vec::new())),
            b't' => {
                let items = self.above_mark()?;
                self.push(Value::List(items));
            }
            0x85..=0x87 => self.tuple(usize::from(operation - 0x84))?,
            b'}' => self.push(Value::Dict(Vec::new())),
            b'a' => {
                let item = self.pop()?;
                self.append(vec![item])?;
            }
            b'e' => {
                let items = self.above_mark()?;
                self.append(items)?;
            }
            b's' => {
                let (value, key) = (self.pop()?, self.pop()?);
                self.set_items(&[key, value])?;
            }
            b'u' => {
                let items = self.above_mark()?;
                self.set_items(&items)?;
            }
            b'h' | b'j' => self.recall(operation)?,
            b'q' | b'r' | 0x94 => self.remember(operation)?,
            b'c' | 0x93 => self.global(operation)?,
            b'R' => self.call()?,
            b'b' => self.build()?,
            b'Q' => self.storage()?,
            other => return Err(format!("operation 0x{other:02x}, which is not on the list")),
        }
        Ok(())
    }

    fn byte(&mut self) -> Step<u8> {
        Ok(self.array::<1>()?[0])
    }

    fn take(&mut self, count: usize) -> Step<&'a [u8]> {
        let end = self.at.checked_add(count).filter(|end| *end <= self.bytes.len());
        let end = end.ok_or_else(|| "the end of the file".to_owned())?;
        let taken = &self.bytes[self.at..end];
        self.at = end;
        Ok(taken)
    }

    fn array<const N: usize>(&mut self) -> Step<[u8; N]> {
        let mut array = [0; N];
        array.copy_from_slice(self.take(N)?);
        Ok(array)
    }

    fn push(&mut self, value: Value) {
        self.values.push(value);
        self.stack.push(self.values.len() - 1);
    }

    fn pop(&mut self) -> Step<Id> {
        let floor = self.marks.last().copied().unwrap_or(0);
        if self.stack.len() <= floor {
            return Err("an operation without its operand".to_owned());
        }
        self.stack.pop().ok_or_else(|| "an empty stack".to_owned())
    }

    fn above_mark(&mut self) -> Step<Vec<Id>> {
        let mark = self.marks.pop().ok_or_else(|| "an operation without its mark".to_owned())?;
        Ok(self.stack.split_off(mark.min(self.stack.len())))
    }

    fn top(&self) -> Step<Id> {
        self.stack.last().copied().ok_or_else(|| "an empty stack".to_owned())
    }

    fn integer(&mut self, operation: u8) -> Step<()> {
        let value = match operation {
            b'J' => i64::from(i32::from_le_bytes(self.array()?)),
            b'K' => i64::from(self.byte()?),
            b'M' => i64::from(u16::from_le_bytes(self.array()?)),
            _ => {
                let length = usize::from(self.byte()?);
                let bytes = self.take(length)?;
                let sign = if bytes.last().is_some_and(|byte| byte & 0x80 != 0) { 0xff } else { 0 };
                let mut wide = [sign; 8];
                if length > wide.len() {
                    return Err(format!("an integer of {length} bytes"));
                }
                wide[..length].copy_from_slice(bytes);
                i64::from_le_bytes(wide)
            }
        };
        self.push(Value::Int(value));
        Ok(())
    }

    /// Reads a length, then as many bytes. Nothing is allocated for bytes that are not there.
    fn sized(&mut self, operation: u8) -> Step<Vec<u8>> {
        let length = match operation {
            b'U' | b'C' | 0x8c => usize::from(self.byte()?),
            b'X' | b'T' | b'B' => u32::from_le_bytes(self.array()?) as usize,
            _ => usize::try_from(u64::from_le_bytes(self.array()?)).unwrap_or(usize::MAX),
        };
        Ok(self.take(length)?.to_vec())
    }

    fn tuple(&mut self, count: usize) -> Step<()> {
        let mut items = Vec::with_capacity(count);
        for _ in 0..count {
            items.push(self.pop()?);
        }
        items.reverse();
        self.push(Value::List(items));
        Ok(())
    }

    fn append(&mut self, items: Vec<Id>) -> Step<()> {
        let top = self.top()?;
        let Value::List(list) = &mut self.values[top] else { return Err("items for something that is no list".into()) };
        list.extend(items);
        Ok(())
    }

    fn set_items(&mut self, items: &[Id]) -> Step<()> {
        let top = self.top()?;
        let Value::Dict(dict) = &mut self.values[top] else {
            return Err("entries for something that is no dict".into());
        };
        dict.extend(items.as_chunks::<2>().0.iter().map(|[key, value]| (*key, *value)));
        Ok(())
    }

    fn recall(&mut self, operation: u8) -> Step<()> {
        let at = if operation == b'h' { usize::from(self.byte()?) } else { u32::from_le_bytes(self.array()?) as usize };
        let id = self.memo.get(&at).copied().ok_or_else(|| format!("memo {at}, which was never set"))?;
        self.stack.push(id);
        Ok(())
    }

    fn remember(&mut self, operation: u8) -> Step<()> {
        let at = match operation {
            b'q' => usize::from(self.byte()?),
            b'r' => u32::from_le_bytes(self.array()?) as usize,
            _ => self.memo.len(),
        };
        let top = self.top()?;
        self.memo.insert(at, top);
        Ok(())
    }

    fn global(&mut self, operation: u8) -> Step<()> {
        let (module, name) = if operation == b'c' {
            (self.line()?, self.line()?)
        } else {
            let (name, module) = (self.pop()?, self.pop()?);
            (self.text(module)?.to_owned(), self.text(name)?.to_owned())
        };
        let global = Global::of(&module, &name);
        let refused = || format!("the name {}.{}, which is not on the list", shortened(&module), shortened(&name));
        self.push(Value::Global(global.ok_or_else(refused)?));
        Ok(())
    }

    fn line(&mut self) -> Step<String> {
        let rest = &self.bytes[self.at..];
        let length = rest.iter().take(256).position(|byte| *byte == b'\n').ok_or("a name without an end")?;
        let text = String::from_utf8_lossy(&rest[..length]).into_owned();
        self.at += length + 1;
        Ok(text)
    }

    fn text(&self, id: Id) -> Step<&str> {
        match &self.values[id] {
            Value::Text(text) => Ok(text),
            _ => Err("something else where a text is expected".to_owned()),
        }
    }

    fn list(&self, id: Id) -> Step<&[Id]> {
        match &self.values[id] {
            Value::List(items) => Ok(items),
            _ => Err("something else where a tuple is expected".to_owned()),
        }
    }

    fn size(&self, id: Id) -> Step<usize> {
        match &self.values[id] {
            Value::Int(value) => usize::try_from(*value).map_err(|_| format!("the size {value}")),
            _ => Err("something else where a size is expected".to_owned()),
        }
    }

    fn shape(&self, id: Id) -> Step<Vec<usize>> {
        let sizes = self.list(id)?;
        if sizes.len() > MOST_AXES {
            return Err(format!("an array of {} axes", sizes.len()));
        }
        sizes.iter().map(|id| self.size(*id)).collect()
    }

    /// Makes what a function on the list would return.
    fn call(&mut self) -> Step<()> {
        let (arguments, function) = (self.pop()?, self.pop()?);
        let arguments = self.list(arguments)?.iter().copied().take(8).collect::<Vec<_>>();
        let Value::Global(global) = self.values[function] else {
            return Err("a call of something that is no name".into());
        };
        let argument =
            |at: usize| arguments.get(at).copied().ok_or_else(|| format!("{global:?} without its arguments"));
        let value = match global {
            Global::Reconstruct => self.empty_array(),
            Global::OrderedDict => Value::Dict(Vec::new()),
            Global::Dtype => self.dtype(argument(0)?)?,
            Global::Encode => Value::Bytes(self.encoded(argument(0)?)?),
            Global::Scalar => self.scalar(argument(0)?, argument(1)?)?,
            Global::FromBuffer => {
                let (kind, big_endian) = self.dtype_of(argument(1)?)?;
                let fortran = matches!(self.text(argument(3)?), Ok("F"));
                Value::Array(Array { kind, big_endian, fortran, shape: self.shape(argument(2)?)?, data: argument(0)? })
            }
            Global::Tensor => self.tensor(&arguments)?,
            Global::Ndarray | Global::Storage(_) => return Err(format!("a call of {global:?}")),
        };
        self.push(value);
        Ok(())
    }

    fn empty_array(&self) -> Value {
        // The state follows; until then the array has no bytes that could be read.
        Value::Array(Array { kind: Kind::Object, big_endian: false, fortran: false, shape: vec![0], data: 0 })
    }

    fn dtype(&self, id: Id) -> Step<Value> {
        let text = self.text(id)?;
        let (order, letters) = match text.strip_prefix(['<', '>', '|', '=']) {
            Some(letters) => (text.starts_with('>'), letters),
            None => (false, text),
        };
        let kind = Kind::of(letters).ok_or_else(|| format!("numbers of type {}", shortened(text)))?;
        Ok(Value::Dtype(kind, order))
    }

    fn dtype_of(&self, id: Id) -> Step<(Kind, bool)> {
        match self.values[id] {
            Value::Dtype(kind, big_endian) => Ok((kind, big_endian)),
            _ => Err("an array without a type".to_owned()),
        }
    }

    /// Returns the bytes that a text of Latin letters stands for. The text is used up: repeated, it would be copied
    /// each time.
    fn encoded(&mut self, id: Id) -> Step<Vec<u8>> {
        let bytes = self.text(id)?.chars().map(|c| u8::try_from(c).map_err(|_| "bytes of no Latin letters".to_owned()));
        let bytes = bytes.collect::<Step<Vec<u8>>>()?;
        self.values[id] = Value::None;
        Ok(bytes)
    }

    fn scalar(&self, dtype: Id, bytes: Id) -> Step<Value> {
        let (kind, big_endian) = self.dtype_of(dtype)?;
        match &self.values[bytes] {
            Value::Bytes(bytes) if kind.size() > 0 && bytes.len() == kind.size() => {
                Ok(Value::Float(kind.value(bytes, big_endian)))
            }
            _ => Err("a number of the wrong size".to_owned()),
        }
    }

    /// Fills an array, or sets the byte order of a type.
    fn build(&mut self) -> Step<()> {
        let state = self.pop()?;
        let target = self.top()?;
        let value = match &self.values[target] {
            Value::Array(_) => {
                let &[_, shape, dtype, fortran, data] = self.list(state)? else {
                    return Err("an array without its state".to_owned());
                };
                let (kind, big_endian) = self.dtype_of(dtype)?;
                Value::Array(Array {
                    kind,
                    big_endian,
                    fortran: self.size(fortran)? != 0,
                    shape: self.shape(shape)?,
                    data,
                })
            }
            Value::Dtype(kind, _) => {
                let kind = *kind;
                let order = self.list(state)?.get(1).copied().ok_or("a type without its order of bytes")?;
                Value::Dtype(kind, self.text(order)? == ">")
            }
            // PyTorch gives its dicts attributes, which hold nothing of use.
            Value::Dict(_) => return Ok(()),
            _ => return Err("a state for something that has none".to_owned()),
        };
        self.values[target] = value;
        Ok(())
    }

    /// Makes `('storage', torch.FloatStorage, key, device, size)` a storage.
    fn storage(&mut self) -> Step<()> {
        let parts = self.pop()?;
        let &[_, class, key, ..] = self.list(parts)? else { return Err("a storage without its parts".to_owned()) };
        let Value::Global(Global::Storage(kind)) = self.values[class] else {
            return Err("a storage of no class".into());
        };
        let key = shortened(self.text(key)?);
        self.push(Value::Storage { kind, key });
        Ok(())
    }

    fn tensor(&self, arguments: &[Id]) -> Step<Value> {
        let &[storage, offset, shape, strides, ..] = arguments else {
            return Err("a tensor without its parts".to_owned());
        };
        let Value::Storage { kind, key } = &self.values[storage] else {
            return Err("a tensor without a storage".into());
        };
        let (shape, strides) = (self.shape(shape)?, self.shape(strides)?);
        if shape.len() != strides.len() {
            return Err("a tensor with other strides than axes".to_owned());
        }
        Ok(Value::Tensor(Tensor { kind: *kind, key: key.clone(), offset: self.size(offset)?, shape, strides }))
    }
}
