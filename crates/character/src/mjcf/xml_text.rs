//! Bytes of an XML file as text: encodings, byte order marks, and declarations that do not stand first.

use std::path::Path;

use crate::error::CharacterError;

/// Encodings of which every byte is one character, which Unicode has under the same number.
const ONE_BYTE: [&str; 6] = ["iso-8859-1", "iso8859-1", "latin1", "latin-1", "windows-1252", "iso-8859-15"];

/// Reads a file as text: UTF-8, UTF-16 with a byte order mark, or the one-byte encoding that its declaration names.
pub(crate) fn read(path: &Path) -> Result<String, CharacterError> {
    let bytes = std::fs::read(path).map_err(|source| CharacterError::Io { path: path.to_path_buf(), source })?;
    decode(&bytes, path)
}

fn decode(bytes: &[u8], file: &Path) -> Result<String, CharacterError> {
    let wide = |of: fn([u8; 2]) -> u16| {
        let units: Vec<u16> = bytes[2..].chunks_exact(2).map(|pair| of([pair[0], pair[1]])).collect();
        String::from_utf16_lossy(&units)
    };
    match bytes {
        [0xff, 0xfe, ..] => return Ok(wide(u16::from_le_bytes)),
        [0xfe, 0xff, ..] => return Ok(wide(u16::from_be_bytes)),
        _ => {}
    }
    let error = match std::str::from_utf8(bytes) {
        Ok(text) => return Ok(text.trim_start_matches('\u{feff}').to_string()),
        Err(error) => error,
    };
    let head = String::from_utf8_lossy(&bytes[..bytes.len().min(200)]).to_lowercase();
    let declared = head.split_once("encoding=").and_then(|(_, rest)| rest.get(1..)?.split(['"', '\'']).next());
    if declared.is_some_and(|name| ONE_BYTE.contains(&name)) {
        return Ok(bytes.iter().copied().map(char::from).collect());
    }
    let at = error.valid_up_to();
    let line = bytes[..at].iter().filter(|byte| **byte == b'\n').count() as u32 + 1;
    let message = format!(
        "expected UTF-8, got byte 0x{:02x}: save it as UTF-8, or name its encoding in the first line (encoding=\"ISO-8859-1\")",
        bytes[at]
    );
    Err(CharacterError::Xml { file: file.to_path_buf(), line, message })
}

/// Returns the text without a declaration that stands after blank lines, where no XML reader accepts one. Lines keep their numbers.
pub(crate) fn without_late_declaration(text: &str) -> std::borrow::Cow<'_, str> {
    let trimmed = text.trim_start();
    match trimmed.split_once("?>").filter(|_| trimmed.len() < text.len() && trimmed.starts_with("<?xml ")) {
        None => text.into(),
        Some((declaration, rest)) => {
            let blank = &text[..text.len() - trimmed.len()];
            let lines = blank.chars().chain(declaration.chars()).filter(|c| *c == '\n').count();
            ("\n".repeat(lines) + rest).into()
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn bytes_are_read_by_mark_and_declaration() {
        let of = |bytes: &[u8]| decode(bytes, Path::new("x.urdf"));
        assert_eq!(of(b"\xef\xbb\xbf<a/>").unwrap(), "<a/>");
        assert_eq!(of(b"\xff\xfe<\0a\0/\0>\0").unwrap(), "<a/>");
        assert_eq!(of(b"\xfe\xff\0<\0a\0/\0>").unwrap(), "<a/>");
        assert!(of(b"<?xml version='1.0' encoding='ISO-8859-1'?>\xfc").unwrap().ends_with("?>\u{fc}"));
        let error = of(b"<a>\n\xfc</a>").unwrap_err().to_string();
        assert!(error.starts_with("x.urdf:2: ") && error.contains("0xfc") && error.contains("ISO-8859-1"), "{error}");
    }

    #[test]
    fn a_late_declaration_goes_and_lines_stay() {
        assert_eq!(without_late_declaration("\n <?xml version='1.0'?>\n<a/>"), "\n\n<a/>");
        for text in ["<?xml version='1.0'?><a/>", "\n<a/>", "\n<?xmlish?><a/>"] {
            assert_eq!(without_late_declaration(text), text);
        }
    }
}
