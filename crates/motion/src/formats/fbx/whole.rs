//! A text FBX that is cut off: braces are counted, since the library names only the token at which it gave up.

/// Returns what is missing of a text; `None` for a whole one and for a binary file.
pub(super) fn missing(bytes: &[u8]) -> Option<String> {
    if !bytes.starts_with(b";") {
        return None;
    }
    let (mut open, mut line, mut lines, mut has_connections) = (Vec::new(), 1, 0, false);
    let (mut in_text, mut in_remark) = (false, false);
    let mut begin = 0;
    for (at, byte) in bytes.iter().enumerate() {
        match byte {
            b'\n' => {
                (line, begin, in_remark) = (line + 1, at + 1, false);
            }
            _ if in_remark => {}
            b'"' => in_text = !in_text,
            _ if in_text => {}
            b';' => in_remark = true,
            b'{' => {
                has_connections |= open.is_empty() && bytes[begin..].trim_ascii_start().starts_with(b"Connections:");
                open.push((begin, line));
            }
            b'}' => drop(open.pop()),
            _ => {}
        }
        lines = line;
    }
    match open.last() {
        Some((begin, line)) => {
            let head = bytes[*begin..].trim_ascii_start();
            let name = head.split(|byte| matches!(byte, b':' | b'{' | b'\n')).next().unwrap_or_default();
            let name = String::from_utf8_lossy(&name[..name.len().min(40)]);
            Some(format!("a text that ends in line {lines}, within '{name}' of line {line} (cut off?)"))
        }
        None if !has_connections => Some(format!("a text of {lines} lines without 'Connections' (cut off?)")),
        None => None,
    }
}
