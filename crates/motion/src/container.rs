//! Our motion container: `NAME.motion.safetensors`.
//!
//! A [safetensors](https://github.com/huggingface/safetensors) file, so any language reads it and nothing in it can be
//! executed. Arrays (`T` frames, `J` joints, `P` places that may touch the ground):
//!
//! | array | shape | content |
//! | --- | --- | --- |
//! | `root_position` | `[T, 3]` f64 | m, world |
//! | `root_orientation` | `[T, 4]` f64 | unit quaternion, `wxyz` |
//! | `joints` | `[T, J]` f64 | rad or m, in the order of the header's `joint_names` |
//! | `contacts` | `[T, P]` u8 | 0 or 1, in the order of the header's `contact_names`; absent where unknown |
//!
//! The entry `motion` of the file's metadata is the header as JSON: version, names, rate, conventions, provenance, digest.
//! Arrays may also be f32 when others write such a file.
//!
//! Version 2 has a digest, `sha256`: of the header's text with 64 zeros in its place, then of each array's name, shape
//! and bytes. Arrays are sorted by name. Version 1 is the same without a digest, for other programs.

use std::collections::HashMap;
use std::fs;
use std::path::Path;

use lifelike_character::rotation::to_wxyz;
use lifelike_character::{Quat, Vec3};
use lifelike_checkpoint::write_file;
use safetensors::tensor::TensorView;
use safetensors::{Dtype, SafeTensors};
use sha2::{Digest, Sha256};

use crate::clip::{Contacts, MotionClip, Provenance};
use crate::formats::{Format, Reader};
use crate::{FromInput, MotionError};

/// Ending of our motion files' names.
pub const EXTENSION: &str = ".motion.safetensors";

/// The format, for the table of all.
pub const FORMAT: Format = Format {
    name: "lifelike's motion of a robot",
    suffixes: &[EXTENSION],
    shared_suffixes: &[],
    companion: "",
    not_motion: &[],
    clip_name: |_| None,
    // No text has the zeros of a safetensors file's first number; the header that follows says what it is.
    sniff: |sample| sample.start.contains(&0) && sample.start.windows(ID.len()).any(|w| w == ID.as_bytes()),
    reader: Reader::Robot(|bytes, file, _| from_bytes(bytes, file)),
};

const KEY: &str = "motion";
const ID: &str = "lifelike-motion";
const VERSION: u32 = 2;
/// The version without a digest.
const WITHOUT_DIGEST: u32 = 1;
/// Stands for the digest while it is computed.
const NO_DIGEST: &str = "0000000000000000000000000000000000000000000000000000000000000000";
const UNITS: &str = "SI: m, rad, s";
const CONVENTION: &str = "right-handed, z up, x forward, y left; quaternions wxyz; root pose in the world";

#[derive(serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct Header {
    format: String,
    version: u32,
    name: String,
    fps: f64,
    units: String,
    convention: String,
    joint_names: Vec<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    contact_names: Option<Vec<String>>,
    cyclic: bool,
    provenance: Provenance,
    /// Of version 2 on.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    sha256: Option<String>,
}

/// The part of the header that is read first: a newer version may have fields that we do not know.
#[derive(serde::Deserialize)]
struct Version {
    format: String,
    version: u32,
}

/// Returns the clip as bytes of the container.
///
/// # Errors
/// [`MotionError::Unfit`] when the clip is not consistent (see [`MotionClip::check`]).
pub fn to_bytes(clip: &MotionClip) -> Result<Vec<u8>, MotionError> {
    clip.check()?;
    let (frames, joints) = (clip.len(), clip.joint_names.len());
    let position = bytes_of(clip.root_position.iter().flat_map(|p| [p.x, p.y, p.z]));
    let orientation = bytes_of(clip.root_orientation.iter().flat_map(to_wxyz));
    let values = bytes_of(clip.joints.iter().copied());
    let flags: Option<Vec<u8>> = clip.contacts.as_ref().map(|c| c.flags.iter().map(|f| u8::from(*f)).collect());
    let header = Header {
        format: ID.into(),
        version: VERSION,
        name: clip.name.clone(),
        fps: clip.fps,
        units: UNITS.into(),
        convention: CONVENTION.into(),
        joint_names: clip.joint_names.clone(),
        contact_names: clip.contacts.as_ref().map(|c| c.names.clone()),
        cyclic: clip.cyclic,
        provenance: clip.provenance.clone(),
        sha256: Some(NO_DIGEST.into()),
    };
    let unfit =
        |why: String| MotionError::Unfit { clip: clip.name.clone(), message: format!("cannot be written: {why}") };
    let header = serde_json::to_string(&header).map_err(|e| unfit(e.to_string()))?;
    let view = |dtype, shape: Vec<usize>, data| TensorView::new(dtype, shape, data).map_err(|e| unfit(e.to_string()));
    let mut arrays = vec![
        ("root_position", view(Dtype::F64, vec![frames, 3], &position)?),
        ("root_orientation", view(Dtype::F64, vec![frames, 4], &orientation)?),
        ("joints", view(Dtype::F64, vec![frames, joints], &values)?),
    ];
    if let (Some(contacts), Some(flags)) = (&clip.contacts, &flags) {
        arrays.push(("contacts", view(Dtype::U8, vec![frames, contacts.names.len()], flags)?));
    }
    let of_all = digest(&header, arrays.iter().map(|(name, view)| (*name, view)));
    let metadata = HashMap::from([(KEY.to_string(), header.replacen(NO_DIGEST, &of_all, 1))]);
    safetensors::serialize(arrays, Some(metadata)).map_err(|e| unfit(e.to_string()))
}

/// Returns the digest of a header and arrays (hexadecimal).
fn digest<'a, 'v, V>(header: &str, arrays: impl Iterator<Item = (&'a str, V)>) -> String
where
    V: std::borrow::Borrow<TensorView<'v>>,
{
    let mut arrays: Vec<_> = arrays.collect();
    arrays.sort_by_key(|(name, _)| *name);
    let mut hash = Sha256::new();
    hash.update(header);
    for (name, view) in arrays {
        let view = view.borrow();
        hash.update(format!("{name} {:?} {:?}", view.dtype(), view.shape()));
        hash.update(view.data());
    }
    hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
}

/// Writes the clip. The file appears under its name only when it is complete.
///
/// # Errors
/// As [`to_bytes`], and [`MotionError::Input`].
pub fn write(path: &Path, clip: &MotionClip) -> Result<(), MotionError> {
    let bytes = to_bytes(clip)?;
    let io = MotionError::io(path);
    if let Some(folder) = path.parent().filter(|f| !f.as_os_str().is_empty()) {
        fs::create_dir_all(folder).map_err(io)?;
    }
    write_file(path, &bytes).map_err(io)
}

/// Reads a clip.
///
/// # Errors
/// [`MotionError::Input`] for a file that cannot be read, or is not what the container should hold;
/// [`MotionError::Unfit`] for contents that contradict each other.
pub fn read(path: &Path) -> Result<MotionClip, MotionError> {
    let bytes = fs::read(path).map_err(MotionError::io(path))?;
    from_bytes(&bytes, path)
}

/// Reads a clip from bytes; `file` is only named in errors.
///
/// # Errors
/// As [`read`], less the reading.
pub fn from_bytes(bytes: &[u8], file: &Path) -> Result<MotionClip, MotionError> {
    let error = |expected: String, got: String| MotionError::format(file.display(), expected, got);
    let broken = |e: safetensors::SafeTensorError| error("a safetensors file".into(), e.to_string());
    let (_, metadata) = SafeTensors::read_metadata(bytes).map_err(broken)?;
    let arrays = SafeTensors::deserialize(bytes).map_err(broken)?;
    let header = metadata
        .metadata()
        .as_ref()
        .and_then(|m| m.get(KEY))
        .ok_or_else(|| error(format!("a motion file, with the entry '{KEY}' in its metadata"), "none".into()))?;
    let bad_json = |e: serde_json::Error| error("a header of our format".into(), e.to_string());
    let version: Version = serde_json::from_str(header).map_err(bad_json)?;
    if version.format != ID || ![WITHOUT_DIGEST, VERSION].contains(&version.version) {
        let got = format!("'{}' version {}", version.format, version.version);
        return Err(error(format!("'{ID}' version {VERSION}"), got));
    }
    let text = header;
    let header: Header = serde_json::from_str(text).map_err(bad_json)?;
    if version.version != WITHOUT_DIGEST {
        let written = header.sha256.as_deref().unwrap_or_default();
        let got = digest(&text.replacen(written, NO_DIGEST, 1), arrays.iter());
        if got != written {
            return Err(error(
                format!("contents of digest '{written}', as its header says"),
                format!("'{got}': the file is damaged"),
            ));
        }
    }
    for (what, expected, got) in [("units", UNITS, &header.units), ("convention", CONVENTION, &header.convention)] {
        if expected != got {
            return Err(error(format!("{what} '{expected}'"), format!("'{got}'")));
        }
    }

    let array = |name: &str, columns: usize| numbers(&arrays, name, columns).map_err(|(e, g)| error(e, g));
    let position = array("root_position", 3)?;
    let orientation = array("root_orientation", 4)?;
    let joints = array("joints", header.joint_names.len())?;
    let mut turns = Vec::with_capacity(orientation.len() / 4);
    for (frame, q) in orientation.chunks_exact(4).enumerate() {
        let q = nalgebra::Quaternion::new(q[0], q[1], q[2], q[3]);
        let norm = q.norm();
        // f32 files are unit to 1e-7; what is further off, or not a number, is no orientation.
        if norm.is_nan() || (norm - 1.0).abs() > 1e-3 {
            return Err(error(
                format!("unit quaternions in 'root_orientation', frame {frame}"),
                format!("norm {norm}"),
            ));
        }
        // Our own files come back bit for bit.
        let exact = (norm - 1.0).abs() < 1e-14;
        turns.push(if exact { Quat::new_unchecked(q) } else { Quat::new_normalize(q) });
    }
    let contacts = match header.contact_names {
        None => None,
        Some(names) => {
            let flags = contact_flags(&arrays, names.len()).map_err(|(e, g)| error(e, g))?;
            Some(Contacts { names, flags })
        }
    };
    let clip = MotionClip {
        name: header.name,
        fps: header.fps,
        joint_names: header.joint_names,
        root_position: position.chunks_exact(3).map(|p| Vec3::new(p[0], p[1], p[2])).collect(),
        root_orientation: turns,
        joints,
        contacts,
        cyclic: header.cyclic,
        provenance: header.provenance,
    };
    clip.check().map_err(|e| error("a consistent clip".into(), e.to_string()))?;
    Ok(clip)
}

fn bytes_of(values: impl Iterator<Item = f64>) -> Vec<u8> {
    values.flat_map(f64::to_le_bytes).collect()
}

type ExpectedGot = (String, String);

fn shaped<'a>(arrays: &SafeTensors<'a>, name: &str, columns: usize) -> Result<TensorView<'a>, ExpectedGot> {
    let view = arrays.tensor(name).map_err(|e| (format!("an array '{name}'"), e.to_string()))?;
    match view.shape() {
        [_, width] if *width == columns => Ok(view),
        shape => Err((format!("'{name}' of shape [frames, {columns}]"), format!("{shape:?}"))),
    }
}

fn numbers(arrays: &SafeTensors<'_>, name: &str, columns: usize) -> Result<Vec<f64>, ExpectedGot> {
    let view = shaped(arrays, name, columns)?;
    match view.dtype() {
        Dtype::F64 => Ok(view.data().as_chunks::<8>().0.iter().map(|c| f64::from_le_bytes(*c)).collect()),
        Dtype::F32 => Ok(view.data().as_chunks::<4>().0.iter().map(|c| f64::from(f32::from_le_bytes(*c))).collect()),
        other => Err((format!("'{name}' as F64 or F32"), format!("{other:?}"))),
    }
}

fn contact_flags(arrays: &SafeTensors<'_>, columns: usize) -> Result<Vec<bool>, ExpectedGot> {
    let view = shaped(arrays, "contacts", columns)?;
    if !matches!(view.dtype(), Dtype::U8 | Dtype::BOOL) {
        return Err(("'contacts' as U8 or BOOL".into(), format!("{:?}", view.dtype())));
    }
    let flag = |b: &u8| match b {
        0 => Ok(false),
        1 => Ok(true),
        other => Err(("contacts of 0 or 1".to_string(), other.to_string())),
    };
    view.data().iter().map(flag).collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::clip::Caption;
    use proptest::prelude::*;

    fn clip() -> MotionClip {
        MotionClip {
            name: "wave".into(),
            fps: 29.97,
            joint_names: vec!["elbow".into(), "knee".into()],
            root_position: vec![Vec3::new(0.1, 0.2, 0.3), Vec3::new(1.0 / 3.0, 0.0, -1e-300)],
            root_orientation: vec![Quat::from_euler_angles(0.1, 2.0, 3.0), Quat::from_euler_angles(-1.0, 0.3, 0.9)],
            joints: vec![0.1, -0.2, 1.0 / 7.0, 4.0],
            contacts: Some(Contacts { names: vec!["foot".into()], flags: vec![true, false] }),
            cyclic: true,
            provenance: Provenance {
                character: "lima".into(),
                source: "by hand".into(),
                licence: "MIT".into(),
                captions: vec![Caption { start: 0.0, end: 1.0, text: "waves — “hello”".into() }],
            },
        }
    }

    fn parse(bytes: &[u8]) -> Result<MotionClip, MotionError> {
        from_bytes(bytes, Path::new("x.motion.safetensors"))
    }

    #[test]
    fn what_is_written_is_read_bit_for_bit() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("deep/er/wave.motion.safetensors");
        write(&path, &clip()).unwrap();
        assert_eq!(read(&path).unwrap(), clip());
        assert_eq!(fs::read(&path).unwrap(), to_bytes(&read(&path).unwrap()).unwrap(), "and written again the same");
        assert_eq!(fs::read_dir(path.parent().unwrap()).unwrap().count(), 1, "no partial file is left");
    }

    #[test]
    fn a_file_of_another_hand_may_be_f32() {
        let mut other = clip();
        other.contacts = None;
        let bytes = replaced(&to_bytes(&other).unwrap(), "\\\"version\\\":2", "\\\"version\\\":1");
        let arrays = SafeTensors::deserialize(&bytes).unwrap();
        let narrow: Vec<(String, Vec<usize>, Vec<u8>)> = arrays
            .iter()
            .map(|(name, view)| {
                let values = view.data().as_chunks::<8>().0.iter().map(|c| f64::from_le_bytes(*c) as f32);
                (name.to_string(), view.shape().to_vec(), values.flat_map(f32::to_le_bytes).collect())
            })
            .collect();
        let views = narrow.iter().map(|(n, s, d)| (n.as_str(), TensorView::new(Dtype::F32, s.clone(), d).unwrap()));
        let (_, metadata) = SafeTensors::read_metadata(&bytes).unwrap();
        let back = parse(&safetensors::serialize(views, metadata.metadata().clone()).unwrap()).unwrap();
        assert!((back.joints[2] - 1.0 / 7.0).abs() < 1e-7);
        assert!((back.root_orientation[1].norm() - 1.0).abs() < 1e-15, "normalised");
    }

    /// Returns bytes with the first occurrence of a text replaced.
    fn replaced(bytes: &[u8], from: &str, to: &str) -> Vec<u8> {
        assert_eq!(from.len(), to.len(), "lengths are part of the format");
        let at = bytes.windows(from.len()).position(|w| w == from.as_bytes()).unwrap();
        let mut bytes = bytes.to_vec();
        bytes[at..at + to.len()].copy_from_slice(to.as_bytes());
        bytes
    }

    #[test]
    fn a_file_of_which_any_bit_differs_is_refused() {
        let good = to_bytes(&clip()).unwrap();
        assert_eq!(parse(&good).unwrap(), clip());
        for bit in 0..8 * good.len() {
            let mut damaged = good.clone();
            damaged[bit / 8] ^= 1 << (bit % 8);
            assert!(parse(&damaged).is_err(), "bit {} of byte {}", bit % 8, bit / 8);
        }
        let error = parse(&replaced(&good, "29.97", "29.98")).unwrap_err().to_string();
        assert!(error.contains("the file is damaged"), "{error}");
    }

    #[test]
    fn errors_say_what_was_expected_and_what_came() {
        let message = |bytes: &[u8]| parse(bytes).unwrap_err().to_string();
        assert!(message(b"BVH").contains("safetensors"));
        // Without a digest, as other programs may write: then every part is checked for itself.
        let good = replaced(&to_bytes(&clip()).unwrap(), "\\\"version\\\":2", "\\\"version\\\":1");
        let text = |from: &str, to: &str| message(&replaced(&good, from, to));
        assert!(text("\\\"version\\\":1", "\\\"version\\\":7").contains("version 7"));
        assert!(text("z up", "y up").contains("y up"));
        assert!(text("root_position", "root_positiom").contains("root_position"));
        assert!(text("\\\"fps\\\":29.97", "\\\"fps\\\":-9.97").contains("positive"));
        assert!(text("\\\"knee\\\"", "\\\"k\\\",11").contains("header"));
        let mut bad = clip();
        bad.joints[3] = f64::NAN;
        let error = to_bytes(&bad).unwrap_err().to_string();
        assert!(error.contains("knee") && error.contains("frame 1"), "{error}");
    }

    proptest! {
        #[test]
        fn hostile_bytes_never_panic(bytes in proptest::collection::vec(any::<u8>(), 0..300)) {
            prop_assert!(parse(&bytes).is_err());
        }

        #[test]
        fn damaged_files_never_panic(at in any::<proptest::sample::Index>(), with: u8, cut in any::<proptest::sample::Index>()) {
            let good = to_bytes(&clip()).unwrap();
            let mut bytes = good.clone();
            let at = at.index(bytes.len());
            bytes[at] = with;
            let _ = parse(&bytes);
            let cut = cut.index(good.len());
            prop_assert!(parse(&good[..cut]).is_err(), "cut at {}", cut);
        }

        /// Version 1 has no digest, so what stands in it reaches every check.
        #[test]
        fn spoilt_headers_never_panic(
            spots in proptest::collection::vec((any::<proptest::sample::Index>(), 0..9usize, "[-0-9e,:\"\\[\\]{} a-z]{0,6}"), 1..4),
            at in any::<proptest::sample::Index>(),
            with: u8,
        ) {
            let good = to_bytes(&clip()).unwrap();
            let (_, metadata) = SafeTensors::read_metadata(&good).unwrap();
            let header = &metadata.metadata().as_ref().unwrap()[KEY];
            let mut header: serde_json::Value = serde_json::from_str(header).unwrap();
            header["version"] = WITHOUT_DIGEST.into();
            header.as_object_mut().unwrap().remove("sha256");
            let mut text: Vec<char> = header.to_string().chars().collect();
            for (place, length, put) in spots {
                let from = place.index(text.len());
                text.splice(from..(from + length).min(text.len()), put.chars());
            }
            let text = String::from_iter(text);
            let arrays = SafeTensors::deserialize(&good).unwrap().tensors();
            let mut bytes = safetensors::serialize(arrays, Some(HashMap::from([(KEY.to_string(), text)]))).unwrap();
            let at = at.index(bytes.len());
            bytes[at] = with;
            if let Ok(clip) = parse(&bytes) {
                prop_assert!(clip.check().is_ok() && clip.fps > 0.0);
            }
        }

        #[test]
        fn any_clip_comes_back(values in proptest::collection::vec(-1e3..1e3_f64, 1..40), angle in -3.0..3.0_f64) {
            let mut clip = clip();
            let frames = values.len();
            clip.contacts = None;
            clip.root_position = values.iter().map(|v| Vec3::repeat(*v)).collect();
            clip.root_orientation = values.iter().map(|v| Quat::from_euler_angles(angle, *v, 1.0)).collect();
            clip.joints = values.iter().flat_map(|v| [*v, -v * angle]).collect();
            let back = parse(&to_bytes(&clip).unwrap()).unwrap();
            prop_assert_eq!(back.len(), frames);
            prop_assert_eq!(back, clip);
        }
    }
}
