//! The frames of an MCAP file, in which messages of ROS 2 are kept: looked at before a reader allocates by what they claim.

/// Bytes that an MCAP file begins with.
const MAGIC: [u8; 8] = [0x89, b'M', b'C', b'A', b'P', 0x30, b'\r', b'\n'];
/// Kind of a record that holds others, compressed.
const CHUNK: u8 = 6;

/// Returns an MCAP file as far as its records are whole. What is no MCAP file is returned as it is, for its reader to refuse.
///
/// # Errors
/// The size that a chunk claims to have (bytes), where it is beyond `largest`.
pub fn whole_records(bytes: &[u8], largest: u64) -> Result<&[u8], u64> {
    if !bytes.starts_with(&MAGIC) {
        return Ok(bytes);
    }
    let number = |at: usize| Some(u64::from_le_bytes(bytes.get(at..at.checked_add(8)?)?.try_into().ok()?));
    let mut at = MAGIC.len();
    while let (Some(kind), Some(length)) = (bytes.get(at), number(at + 1)) {
        let end = usize::try_from(length).ok().and_then(|length| (at + 9).checked_add(length));
        let Some(end) = end.filter(|end| *end <= bytes.len()) else { break };
        // Its times come first.
        if let Some(claimed) = number(at + 9 + 16).filter(|claimed| *kind == CHUNK && *claimed > largest) {
            return Err(claimed);
        }
        at = end;
    }
    Ok(if bytes[at..] == MAGIC { bytes } else { &bytes[..at] })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn records_that_are_cut_off_or_claim_too_much() {
        let record = |kind: u8, content: &[u8]| [&[kind][..], &(content.len() as u64).to_le_bytes(), content].concat();
        let chunk = |size: u64| record(CHUNK, &[&[0; 16][..], &size.to_le_bytes(), &[0; 16]].concat());
        let file = [&MAGIC[..], &record(1, b"header"), &chunk(100), &MAGIC].concat();
        assert_eq!(whole_records(&file, 100), Ok(&file[..]));
        assert_eq!(whole_records(&file, 99), Err(100));
        let first = MAGIC.len() + 9 + 6;
        assert_eq!(whole_records(&file[..first + 20], 99), Ok(&file[..first]));
        let endless = [&MAGIC[..], &[1], &u64::MAX.to_le_bytes()].concat();
        assert_eq!(whole_records(&endless, 99), Ok(&MAGIC[..]));
        assert_eq!(whole_records(b"no bag", 99), Ok(&b"no bag"[..]));
    }
}
