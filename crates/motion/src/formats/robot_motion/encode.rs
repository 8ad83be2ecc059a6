//! Pickles that Python reads: dicts of numbers, texts, arrays of NumPy and tensors of PyTorch.

use crate::formats::npz::{Written, zipped};

/// Name of a zip's folder, as `torch.save` writes it.
const ARCHIVE: &str = "archive";

/// A value of a dict.
pub(super) enum Entry<'a> {
    None,
    Float(f64),
    Texts(&'a [String]),
    /// An array of NumPy or a tensor of PyTorch, with its kind of number.
    Array(Written),
}

/// Returns a pickle of a dict, with arrays of NumPy.
pub(super) fn pickle(entries: &[(&str, Entry<'_>)]) -> Vec<u8> {
    dict(4, entries, |program, array, _| numpy(program, array))
}

/// Returns a dict as `torch.save` writes it: a zip of a pickle and storages.
pub(super) fn torch(entries: &[(&str, Entry<'_>)]) -> std::io::Result<Vec<u8>> {
    let program = dict(2, entries, tensor);
    let arrays = entries.iter().filter_map(|(_, entry)| match entry {
        Entry::Array(array) => Some(array.bytes.clone()),
        _ => None,
    });
    let storages = arrays.enumerate().map(|(key, bytes)| (format!("{ARCHIVE}/data/{key}"), bytes));
    let head = [("data.pkl", program), ("byteorder", b"little".to_vec())];
    let head = head.into_iter().map(|(name, bytes)| (format!("{ARCHIVE}/{name}"), bytes));
    zipped(head.chain(storages).chain([(format!("{ARCHIVE}/version"), b"3\n".to_vec())]))
}

fn dict(protocol: u8, entries: &[(&str, Entry<'_>)], array: impl Fn(&mut Vec<u8>, &Written, usize)) -> Vec<u8> {
    let mut program = vec![0x80, protocol, b'}', b'('];
    let mut arrays = 0;
    for (name, entry) in entries {
        text(&mut program, name);
        match entry {
            Entry::None => program.push(b'N'),
            Entry::Float(value) => {
                program.push(b'G');
                program.extend(value.to_be_bytes());
            }
            Entry::Texts(texts) => {
                program.extend(b"](");
                texts.iter().for_each(|one| text(&mut program, one));
                program.push(b'e');
            }
            Entry::Array(written) => {
                array(&mut program, written, arrays);
                arrays += 1;
            }
        }
    }
    program.extend(b"u.");
    program
}

fn text(program: &mut Vec<u8>, text: &str) {
    program.push(b'X');
    program.extend((text.len() as u32).to_le_bytes());
    program.extend(text.bytes());
}

fn integer(program: &mut Vec<u8>, value: usize) {
    program.push(b'J');
    program.extend((value as i32).to_le_bytes());
}

fn tuple(program: &mut Vec<u8>, values: impl Iterator<Item = usize>) {
    program.push(b'(');
    values.for_each(|value| integer(program, value));
    program.push(b't');
}

/// Writes `numpy.core.multiarray._reconstruct(numpy.ndarray, (0,), b"b")` and the array's state.
fn numpy(program: &mut Vec<u8>, array: &Written) {
    program.extend(b"cnumpy.core.multiarray\n_reconstruct\ncnumpy\nndarray\nK\x00\x85C\x01b\x87R(K\x01");
    tuple(program, array.shape.iter().copied());
    program.extend(b"cnumpy\ndtype\n");
    text(program, array.descr.trim_start_matches('<'));
    program.extend(b"\x89\x88\x87R(K\x03");
    text(program, "<");
    program.extend(b"NNNJ\xff\xff\xff\xffJ\xff\xff\xff\xffK\x00tb\x89B");
    program.extend((array.bytes.len() as u32).to_le_bytes());
    program.extend(&array.bytes);
    program.extend(b"tb");
}

/// Writes `torch._utils._rebuild_tensor_v2(storage, 0, shape, strides, False, OrderedDict())`.
fn tensor(program: &mut Vec<u8>, array: &Written, key: usize) {
    let (class, size) = if array.descr == "|b1" { ("BoolStorage", 1) } else { ("FloatStorage", 4) };
    program.extend(b"ctorch._utils\n_rebuild_tensor_v2\n((");
    text(program, "storage");
    program.extend(format!("ctorch\n{class}\n").bytes());
    text(program, &key.to_string());
    text(program, "cpu");
    integer(program, array.bytes.len() / size);
    program.extend(b"tQK\x00");
    tuple(program, array.shape.iter().copied());
    tuple(program, (0..array.shape.len()).map(|axis| array.shape[axis + 1..].iter().product()));
    program.extend(b"\x89ccollections\nOrderedDict\n)RtR");
}
