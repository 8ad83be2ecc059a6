//! AMC (Acclaim motion capture): the degrees of freedom of an ASF's bones, frame by frame.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use lifelike_character::{Quat, Role, Vec3};

use super::asf::{AsfSkeleton, Dof};
use super::raw::{self, RawClip};
use super::standing::Known;
use super::text::{self, Lines};
use super::{Format, ReadOptions, Reader, asf, clip_name, rest};
use crate::roles::{self, Tree};
use crate::source::SourceClip;
use crate::{FromInput, MotionError};

/// Rates that a file may state (frames per second).
const RATES: std::ops::RangeInclusive<f64> = 1.0..=10_000.0;
/// Rate of the CMU's files, which do not state it, but for a few at 60.
const USUAL_FPS: f64 = 120.0;

/// The format, for the table of all.
pub const FORMAT: Format = Format {
    name: "ASF/AMC",
    suffixes: &[".amc"],
    shared_suffixes: &[],
    companion: "its .asf",
    not_motion: &[],
    clip_name: |_| None,
    sniff: |sample| sample.start.starts_with(b"#!OML:ASF"),
    reader: Reader::Source(read),
};

/// Reads a motion with its skeleton, which the options name or which lies beside it.
fn read(bytes: &[u8], file: &Path, options: &ReadOptions) -> Result<SourceClip, MotionError> {
    let asf = match &options.skeleton {
        Some(asf) => asf.clone(),
        None => skeleton_beside(file)?,
    };
    let skeleton = asf::parse(&text::read_bytes(&asf)?, &asf)?;
    parse(bytes, file, &skeleton, options)
}

/// Returns the ASF that belongs to an AMC: `SS.asf` for `SS_TT.amc`, or else the only ASF in the folder.
///
/// # Errors
/// [`MotionError::Input`] for a folder that cannot be listed, or when it holds none or several.
pub fn skeleton_beside(amc: &Path) -> Result<PathBuf, MotionError> {
    let folder = amc.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let stem = clip_name(amc);
    let subject = folder.join(stem.split('_').next().unwrap_or_default()).with_extension("asf");
    if subject.is_file() {
        return Ok(subject);
    }
    let io = MotionError::io(folder);
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(io)? {
        let path = entry.map_err(io)?.path();
        if path.extension().is_some_and(|e| e.eq_ignore_ascii_case("asf")) {
            found.push(path);
        }
    }
    match found.as_slice() {
        [only] => Ok(only.clone()),
        _ => Err(MotionError::format(
            amc.display(),
            format!("its skeleton {} (or one ASF only) beside it", subject.display()),
            format!("{} ASF files there", found.len()),
        )),
    }
}

/// Reads a motion of an Acclaim skeleton. `file` is for names and messages only.
///
/// # Errors
/// [`MotionError::Parse`] with the line: a bone missing in a frame, unknown or twice, a number missing or too many,
/// frames that do not count up by one.
pub fn parse(
    bytes: &[u8],
    file: &Path,
    skeleton: &AsfSkeleton,
    options: &ReadOptions,
) -> Result<SourceClip, MotionError> {
    let mut lines = Lines::new(text::decode(bytes, file)?, file);
    let mut reader = FrameReader::new(skeleton);
    let mut stated_fps = None;
    while let Some(line) = lines.next_line() {
        match line.as_bytes()[0] {
            b'#' => {}
            b':' if reader.root_position.is_empty() && reader.number.is_none() => {
                let mut words = line.split_ascii_whitespace();
                match words.next().unwrap_or_default().to_ascii_uppercase().as_str() {
                    ":DEGREES" => reader.angle = 1.0_f64.to_radians(),
                    ":RADIANS" => reader.angle = 1.0,
                    ":FULLY-SPECIFIED" => {}
                    ":SAMPLES-PER-SECOND" => {
                        let rate = lines.number_in(words.next(), "frames per second")?;
                        if !RATES.contains(&rate) {
                            return Err(lines.error("1 to 10000 frames per second", line));
                        }
                        stated_fps = Some(rate);
                    }
                    _ => return Err(lines.error(":FULLY-SPECIFIED, :DEGREES, :RADIANS or :SAMPLES-PER-SECOND", line)),
                }
            }
            b'0'..=b'9' => {
                reader.end_frame(&lines)?;
                reader.start_frame(&lines, line)?;
            }
            _ => reader.bone(&lines, line)?,
        }
    }
    reader.end_frame(&lines)?;
    if reader.root_position.is_empty() {
        return Err(lines.error("at least one frame", "none"));
    }
    let bones = &skeleton.bones;
    let leaves = (0..bones.len()).filter(|b| !bones.iter().any(|c| c.parent == Some(*b)));
    let names: Vec<String> = bones.iter().map(|b| b.name.clone()).collect();
    let raw = RawClip {
        name: clip_name(file),
        provenance: "ASF/AMC: CMU Graphics Lab Motion Capture Database (mocap.cs.cmu.edu, NSF EIA-0196217), free for \
                     research, not for resale"
            .to_owned(),
        fps: options.fps.or(stated_fps).unwrap_or(USUAL_FPS),
        cyclic: false,
        hints: rest::Hints { elbow_tilt: elbow_tilt(skeleton, &names), ..Default::default() },
        names,
        parents: bones.iter().map(|b| b.parent).collect(),
        offsets: bones.iter().map(|b| b.parent.map_or_else(Vec3::zeros, |p| bones[p].vector)).collect(),
        ends: leaves.map(|b| (b, bones[b].vector)).collect(),
        known: Some(Known { basis: raw::from_y_up_z_forward(), rest: vec![Quat::identity(); bones.len()] }),
        root_position: reader.root_position,
        rotations: reader.rotations,
        notes: Vec::new(),
    };
    raw.finish(options)
}

/// Returns the tilt of the left elbow's hinge (see [`rest::Hints`]), if that is a joint with one rotation.
fn elbow_tilt(skeleton: &AsfSkeleton, names: &[String]) -> f64 {
    let parents: Vec<Option<usize>> = skeleton.bones.iter().map(|bone| bone.parent).collect();
    let offsets = vec![Vec3::zeros(); names.len()];
    let tree = Tree { names, parents: &parents, offsets: &offsets };
    let Some(fore) = roles::find(tree, &BTreeMap::new()).get(Role::LeftForearm) else { return 0.0 };
    let bone = &skeleton.bones[fore];
    let [Dof::Rotation(axis)] = bone.dofs.as_slice() else { return 0.0 };
    let mut hinge = Vec3::zeros();
    hinge[*axis] = 1.0;
    let hinge = raw::from_y_up_z_forward() * (bone.axis * hinge);
    if hinge.z.abs() < 0.1 { 0.0 } else { (-hinge.x / hinge.z).atan() }
}

/// The frames so far, and the one under way.
struct FrameReader<'a> {
    skeleton: &'a AsfSkeleton,
    /// Radians per unit.
    angle: f64,
    /// The frame number under way.
    number: Option<u64>,
    position: Vec3,
    frame: Vec<Quat>,
    given: Vec<bool>,
    root_position: Vec<Vec3>,
    rotations: Vec<Vec<Quat>>,
}

impl<'a> FrameReader<'a> {
    fn new(skeleton: &'a AsfSkeleton) -> Self {
        let n = skeleton.bones.len();
        Self {
            skeleton,
            angle: skeleton.angle,
            number: None,
            position: Vec3::zeros(),
            frame: vec![Quat::identity(); n],
            given: vec![false; n],
            root_position: Vec::new(),
            rotations: Vec::new(),
        }
    }

    fn start_frame(&mut self, lines: &Lines<'_>, line: &str) -> Result<(), MotionError> {
        let number: u64 = line.parse().map_err(|_| lines.error("a frame's number", line))?;
        if let Some(before) = self.number
            && before.checked_add(1) != Some(number)
        {
            return Err(lines.error(format!("a frame that follows {before}"), line));
        }
        self.number = Some(number);
        self.given.fill(false);
        self.position = Vec3::zeros();
        self.frame.fill(Quat::identity());
        Ok(())
    }

    fn end_frame(&mut self, lines: &Lines<'_>) -> Result<(), MotionError> {
        let Some(number) = self.number else { return Ok(()) };
        let missing =
            self.skeleton.bones.iter().zip(&self.given).find(|(bone, given)| !*given && !bone.dofs.is_empty());
        if let Some((bone, _)) = missing {
            let expected = format!("bone '{}' in frame {number} before this line", bone.name);
            return Err(lines.error(expected, "the frame's end"));
        }
        self.root_position.push(self.position);
        self.rotations.push(self.frame.clone());
        Ok(())
    }

    fn bone(&mut self, lines: &Lines<'_>, line: &str) -> Result<(), MotionError> {
        if self.number.is_none() {
            return Err(lines.error("a frame's number before its bones", line));
        }
        let mut tokens = line.split_ascii_whitespace();
        let name = tokens.next().unwrap_or_default();
        let Some(index) = self.skeleton.bones.iter().position(|b| b.name == name) else {
            return Err(lines.error("a bone of the ASF", name));
        };
        if std::mem::replace(&mut self.given[index], true) {
            return Err(lines.error("each bone once per frame", name));
        }
        let bone = &self.skeleton.bones[index];
        let mut rotation = Quat::identity();
        let mut moved = Vec3::zeros();
        for dof in &bone.dofs {
            let value = lines.number_in(tokens.next(), "a number for each degree of freedom")?;
            match dof {
                Dof::Translation(axis) => moved[*axis] = value * self.skeleton.scale,
                Dof::Rotation(axis) => rotation = raw::about(*axis, value * self.angle) * rotation,
            }
        }
        if let Some(extra) = tokens.next() {
            return Err(lines.error(format!("{} numbers for '{name}'", bone.dofs.len()), extra));
        }
        self.frame[index] = bone.axis * rotation * bone.axis.inverse();
        if index == 0 {
            self.frame[index] = bone.axis * rotation;
            self.position = self.skeleton.root_position + moved;
        }
        Ok(())
    }
}
