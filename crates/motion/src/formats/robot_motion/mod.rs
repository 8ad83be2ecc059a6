//! Layouts in which other programs keep the motion of robots, read and written.
//!
//! A [`Layout`] is one constant: its name, a test of the content, a reader into [`RobotMotion`] and a writer from a
//! [`MotionClip`]. [`LAYOUTS`] is the one list; a new layout is one file and its name there. The layout of a file is
//! found from its content. If two fit, the file is refused with the option that decides.

mod arrays;
mod bones;
mod bvh;
mod encode;
mod glb;
mod gmr;
mod holosoma;
mod kinematics;
mod mjlab;
mod named;
mod own;
mod pickle;
mod protomotions;
mod quaternions;
mod rows;
mod table;

use std::path::Path;

use lifelike_character::{Character, Quat, Vec3};

use super::format::Sample;
use super::{Format, ReadOptions, Reader};
use crate::clip::{Contacts, MotionClip, Provenance};
use crate::{FromInput, MotionError};
use kinematics::Bodies;
pub use kinematics::{States as BodyStates, Traversal, states as body_states};

use arrays::Arrays;
pub(super) use pickle::Pickle;
use table::Table;

/// Every layout.
pub const LAYOUTS: &[&Layout] = &[
    &rows::LAFAN1,
    &rows::KIMODO,
    &bones::BONES_SEED,
    &named::CSV,
    &mjlab::MJLAB,
    &mjlab::BEYONDMIMIC,
    &mjlab::WBC,
    &holosoma::HOLOSOMA,
    &gmr::GMR,
    &protomotions::PROTOMOTIONS,
    &own::MOTION,
    &bvh::BVH,
    &glb::GLB,
];

/// All layouts as one format, for the table of all.
pub const FORMAT: Format = Format {
    name: "motion of robots from other programs",
    suffixes: &[],
    shared_suffixes: &[".csv", ".npz", ".pkl", ".motion"],
    companion: "",
    not_motion: &[],
    clip_name: |_| None,
    sniff,
    reader: Reader::Robot(|bytes, file, options| read(bytes, file, options)?.into_one(file)),
};

/// Rates that a file may have (frames per second).
const RATES: std::ops::RangeInclusive<f64> = 1.0..=1000.0;
/// Option that names the robot of a file.
const ROBOT: &str = "--robot ROBOT (for `motion retarget`: --source-robot)";
/// Joints of Unitree's G1 with 29, in MuJoCo's order, without their ending `_joint`.
const G1: &str = "left_hip_pitch left_hip_roll left_hip_yaw left_knee left_ankle_pitch left_ankle_roll \
    right_hip_pitch right_hip_roll right_hip_yaw right_knee right_ankle_pitch right_ankle_roll \
    waist_yaw waist_roll waist_pitch \
    left_shoulder_pitch left_shoulder_roll left_shoulder_yaw left_elbow left_wrist_roll left_wrist_pitch left_wrist_yaw \
    right_shoulder_pitch right_shoulder_roll right_shoulder_yaw right_elbow right_wrist_roll right_wrist_pitch \
    right_wrist_yaw";

/// A layout of robot motion in a file.
#[derive(Debug)]
pub struct Layout {
    /// Name, as `--layout` and `--to` take it.
    pub name: &'static str,
    /// Title, as messages write it.
    pub title: &'static str,
    /// Endings of its files; the first is written.
    pub endings: &'static [&'static str],
    /// Rate of its files.
    pub rate: Rate,
    /// Parts of a clip that it holds beside root, joints and rate.
    pub holds: &'static [Part],
    /// Flag of a layout that is written with poses of bodies, for which the robot is needed.
    pub needs_robot: bool,
    fits: fn(&mut Content<'_>, &Context<'_>) -> Result<Fit, MotionError>,
    read: fn(&mut Content<'_>, &Context<'_>) -> Result<RobotMotion, MotionError>,
    write: fn(&MotionClip, &Context<'_>) -> Result<Vec<u8>, MotionError>,
}

/// Rate of a layout's files.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Rate {
    /// The file has no rate; its readers take this one (frames per second).
    Fixed(f64),
    /// The file has a rate, but its players step through the frames at this one.
    Usual(f64),
    /// The file has a rate, which its readers use.
    Stated,
}

impl Rate {
    /// Returns the rate at which a clip is written where nothing else is said.
    pub fn written(self, clip: f64) -> f64 {
        match self {
            Self::Fixed(rate) | Self::Usual(rate) => rate,
            Self::Stated => clip,
        }
    }
}

/// A part of a clip that not every layout holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part {
    /// Names of the joints.
    Names,
    /// Contacts with the ground.
    Contacts,
    /// Cycle, captions, source and licence.
    Origin,
}

/// Fit of a layout to a file.
enum Fit {
    Yes,
    /// Another layout may fit as well: the reason.
    Doubtful(String),
    No,
    /// The layout's arrays are there, but the values contradict it for this reason.
    Wrong(String),
}

/// Content of a file.
enum Content<'a> {
    Table(Table),
    Arrays(Arrays<'a>),
}

/// Surroundings of a file that is read or written.
struct Context<'a> {
    file: &'a Path,
    robot: Option<&'a Character>,
}

impl Context<'_> {
    fn expected(&self, expected: &str) -> MotionError {
        container(self.file, expected.to_owned(), "another content".to_owned())
    }
}

/// Motion as a layout holds it: what every reader makes.
#[derive(Debug, Clone, Default)]
struct RobotMotion {
    /// Frames per second, where the file says it.
    fps: Option<f64>,
    root_position: Vec<Vec3>,
    root_orientation: Vec<Quat>,
    joint_names: Vec<String>,
    /// Row after row.
    joints: Vec<f64>,
    contacts: Option<Contacts>,
    /// Name of the robot, where the file says it.
    robot: String,
    /// Name, first frame and number of frames of each clip in the file; none for a file of one.
    segments: Vec<(String, usize, usize)>,
    /// Features that identify the layout, for the sentence said aloud.
    said: String,
    /// Arrays that a clip does not hold.
    left_out: Vec<String>,
    /// Places of bodies, which the joints must agree with.
    bodies: Bodies,
}

impl RobotMotion {
    fn into_clip(self, context: &Context<'_>, fps: f64) -> MotionClip {
        let is_of = |names: Vec<String>| {
            names.len() == self.joint_names.len() && names.iter().all(|name| self.joint_names.contains(name))
        };
        let character = match context.robot.filter(|robot| is_of(names_of(robot))) {
            Some(robot) => robot.name.clone(),
            None if self.robot.is_empty() && is_of(g1_names()) => "g1".to_owned(),
            None => self.robot,
        };
        MotionClip {
            name: super::clip_name(context.file),
            fps: self.fps.unwrap_or(fps),
            joint_names: self.joint_names,
            root_position: self.root_position,
            root_orientation: self.root_orientation,
            joints: self.joints,
            contacts: self.contacts,
            cyclic: false,
            provenance: Provenance { character, ..Provenance::default() },
        }
    }
}

/// A file that was read.
#[derive(Debug)]
pub struct Reading {
    /// Its layout.
    pub layout: &'static Layout,
    /// Layout, features and rate as a sentence.
    pub said: String,
    /// Its clips: one, or the segments of a bundle.
    pub clips: Vec<MotionClip>,
    /// Arrays that a clip does not hold.
    pub left_out: Vec<String>,
}

impl Reading {
    fn into_one(self, file: &Path) -> Result<MotionClip, MotionError> {
        <[MotionClip; 1]>::try_from(self.clips).map(|[clip]| clip).map_err(|clips| {
            let cure = "`lifelike motion convert FILE -o FOLDER` writes each into a file of its own";
            container(file, format!("one clip ({cure})"), format!("a bundle of {}", clips.len()))
        })
    }
}

/// Returns the layout of this name.
///
/// # Errors
/// A message with all names.
pub fn by_name(name: &str) -> Result<&'static Layout, String> {
    let names = || LAYOUTS.iter().map(|layout| layout.name).collect::<Vec<_>>().join(", ");
    let found = LAYOUTS.iter().find(|layout| layout.name == name);
    found.copied().ok_or_else(|| format!("expected one of {}, got '{name}'", names()))
}

/// Reads a file in any layout.
///
/// # Errors
/// [`MotionError::Input`] where no layout fits or more than one does, with the option that decides; the layout's
/// own errors.
pub fn read(bytes: &[u8], file: &Path, options: &ReadOptions) -> Result<Reading, MotionError> {
    if options.layout.is_none_or(|layout| layout.name == own::MOTION.name) && is_own(bytes) {
        let clip = crate::container::from_bytes(bytes, file)?;
        let said = format!("{}: {} frames per second", own::MOTION.title, clip.fps);
        return Ok(Reading { layout: &own::MOTION, said, clips: vec![clip], left_out: Vec::new() });
    }
    let robot = options.robot.as_deref();
    let context = Context { file, robot };
    let mut content = match bytes {
        [b'P', b'K', 3, 4, ..] | [0x80, ..] => Content::Arrays(Arrays::open(bytes, file)?),
        [b'(', ..] | [b'}', b'q', ..] => {
            let expected = "a pickle of protocol 2 or later (pickle.dump(motion, file, protocol=4))".to_owned();
            return Err(container(file, expected, "protocol 0 or 1, or no motion".to_owned()));
        }
        _ => Content::Table(Table::parse(bytes, file)?),
    };
    let layout = match options.layout {
        Some(layout) => layout,
        None => detect(&mut content, &context)?,
    };
    let mut motion = (layout.read)(&mut content, &context)?;
    let stated = motion.fps;
    motion.fps = Some(rate(stated, layout, options.fps, file)?);
    let fps = motion.fps.unwrap_or_default();
    let from = match (options.fps, stated) {
        (Some(_), _) => " (as given)",
        (None, Some(_)) => "",
        (None, None) => " (the layout's own)",
    };
    let mut said = format!("{}: {}, {fps} frames per second{from}", layout.title, motion.said);
    let (segments, left_out) = (std::mem::take(&mut motion.segments), std::mem::take(&mut motion.left_out));
    let bodies = std::mem::take(&mut motion.bodies);
    let (names, columns) = (motion.joint_names.len(), motion.joints.len() / motion.root_position.len().max(1));
    if names != columns {
        return Err(container(
            file,
            format!("names of {columns} joints, one for each column"),
            format!("{names} names"),
        ));
    }
    let mut clip = motion.into_clip(&context, fps);
    if let Some(contradiction) = bodies.contradiction(&clip, robot) {
        if options.layout.is_none() {
            let cure = "--robot of the file, or --layout {} to read it nevertheless".replace("{}", layout.name);
            let expected = format!("{} whose bodies and joints agree ({cure})", layout.title);
            return Err(container(file, expected, contradiction));
        }
        said += &format!("; but it has {contradiction}");
    }
    clip.provenance.source = format!("{}, read as {said}", file.display());
    clip.check().map_err(|error| container(file, "a consistent motion".to_owned(), error.to_string()))?;
    let clips = if segments.is_empty() { vec![clip] } else { split(&clip, &segments, file)? };
    Ok(Reading { layout, said, clips, left_out })
}

fn is_own(bytes: &[u8]) -> bool {
    (crate::container::FORMAT.sniff)(&Sample { start: bytes[..bytes.len().min(4096)].to_vec(), entries: Vec::new() })
}

/// Reads a file of robot motion: in any layout, or our own container.
///
/// # Errors
/// As [`read`]; [`MotionError::Input`] for human motion.
pub fn open(file: &Path, options: &ReadOptions) -> Result<Reading, MotionError> {
    let bytes = super::text::read_bytes(file)?;
    let is_human = || super::format::of_content(file, &bytes).is_some_and(|format| format.is_source_of(&bytes));
    if options.layout.is_none() && is_human() {
        let cure = "motion of a robot, or --layout NAME; `lifelike motion retarget` reads human motion";
        return Err(container(file, cure.to_owned(), "human motion".to_owned()));
    }
    read(&bytes, file, options)
}

/// Returns the layout that a file's name stands for.
///
/// # Errors
/// A message with the names of layouts that share the ending, or of all.
pub fn by_ending(file: &Path) -> Result<&'static Layout, String> {
    let name = file.file_name().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
    let has_ending = |layout: &&&Layout| layout.endings.iter().any(|ending| name.ends_with(ending));
    let fitting: Vec<&'static Layout> = LAYOUTS.iter().filter(has_ending).copied().collect();
    let names = |layouts: &[&Layout]| layouts.iter().map(|layout| layout.name).collect::<Vec<_>>().join(", ");
    match fitting.as_slice() {
        [layout] => Ok(layout),
        [] => Err(format!("{}: expected --to NAME, one of {}", file.display(), names(LAYOUTS))),
        several => Err(format!("{}: the ending stands for {}; expected --to NAME", file.display(), names(several))),
    }
}

/// Writes a clip in a layout, at the clip's rate.
///
/// # Errors
/// [`MotionError::Unfit`] where the layout needs a robot and none is given; [`MotionError::Mismatch`] where clip and
/// robot differ.
pub fn write(clip: &MotionClip, layout: &Layout, robot: Option<&Character>) -> Result<Vec<u8>, MotionError> {
    clip.check()?;
    if layout.needs_robot && robot.is_none() {
        return Err(unfit(
            clip,
            format!("{} holds poses of bodies: expected the robot (--robot), got none", layout.title),
        ));
    }
    (layout.write)(clip, &Context { file: Path::new(&clip.name), robot })
}

/// Returns the parts of a clip that a layout does not hold.
pub fn lost(clip: &MotionClip, layout: &Layout) -> Vec<&'static str> {
    let provenance = &clip.provenance;
    let origin = !layout.holds.contains(&Part::Origin);
    let parts = [
        (!layout.holds.contains(&Part::Names), "names of joints"),
        (!layout.holds.contains(&Part::Contacts) && clip.contacts.is_some(), "contacts"),
        (matches!(layout.rate, Rate::Fixed(_)), "rate"),
        (origin && clip.cyclic, "flag of a cycle"),
        (origin && !provenance.captions.is_empty(), "captions"),
        (origin && !(provenance.source.is_empty() && provenance.licence.is_empty()), "source and licence"),
    ];
    parts.into_iter().filter(|(is_lost, _)| *is_lost).map(|(_, part)| part).collect()
}

/// Finds the one layout that fits.
fn detect(content: &mut Content<'_>, context: &Context<'_>) -> Result<&'static Layout, MotionError> {
    let (mut fitting, mut doubtful, mut wrong) = (Vec::new(), Vec::new(), Vec::new());
    let mut reason = String::new();
    for &layout in LAYOUTS {
        match (layout.fits)(content, context)? {
            Fit::Yes => fitting.push(layout),
            Fit::Doubtful(why) => {
                doubtful.push(layout);
                reason = format!(" ({why})");
            }
            Fit::Wrong(why) => wrong.push(format!("{}: {why}", layout.title)),
            Fit::No => {}
        }
    }
    if let ([layout], []) = (fitting.as_slice(), doubtful.as_slice()) {
        return Ok(layout);
    }
    let all = [fitting, doubtful].concat();
    if all.is_empty() {
        let titles = LAYOUTS
            .iter()
            .filter(|layout| layout.name != bvh::BVH.name)
            .map(|layout| layout.title)
            .collect::<Vec<_>>()
            .join(", ");
        let got = if wrong.is_empty() { content.described() } else { wrong.join("; ") };
        return Err(container(context.file, format!("robot motion as {titles}"), got));
    }
    let names = all.iter().map(|layout| format!("--layout {}", layout.name)).collect::<Vec<_>>().join(" or ");
    let titles = all.iter().map(|layout| layout.title).collect::<Vec<_>>().join(" and ");
    let robot =
        if context.robot.is_none() { format!(", or {ROBOT}, whose kinematics may decide") } else { String::new() };
    let cure = format!("{names} of `lifelike motion convert`{robot}");
    Err(container(context.file, cure, format!("content that fits {titles}{reason}")))
}

impl Content<'_> {
    fn described(&self) -> String {
        match self {
            Self::Arrays(arrays) => arrays.listed(),
            Self::Table(table) => match &table.header {
                Some(header) => {
                    let names: String = header.iter().take(8).map(|name| format!(" {name}")).collect();
                    format!("{} columns:{}", table.columns(), super::npz::shortened(&names))
                }
                None => format!("{} columns without names, no unit quaternion in columns 4 to 7", table.columns()),
            },
        }
    }
}

/// Test of a file's first bytes, and of the names in a zip.
fn sniff(sample: &Sample) -> bool {
    let has = |names: &[&str]| names.iter().all(|name| sample.entries.iter().any(|entry| entry == name));
    let contains = |text: &[u8]| sample.start.windows(text.len()).any(|window| window == text);
    arrays::is_torch(sample.entries.iter())
        || has(&["joint_pos.npy", "body_pos_w.npy"])
        || (Pickle::is_start(&sample.start) && (contains(b"root_pos") || contains(b"dof_pos")))
        || Table::is_start(&sample.start, |name| bones::is_column(name) || named::is_column(name))
}

fn rate(stated: Option<f64>, layout: &Layout, given: Option<f64>, file: &Path) -> Result<f64, MotionError> {
    let own = match layout.rate {
        Rate::Fixed(rate) => Some(rate),
        Rate::Usual(_) | Rate::Stated => None,
    };
    let rate = given.or(stated).or(own);
    let got = || rate.map_or_else(|| "none".to_owned(), |rate| rate.to_string());
    rate.filter(|rate| RATES.contains(rate)).ok_or_else(|| {
        container(
            file,
            "1 to 1000 frames per second, or --fps RATE (for `motion convert`: --input-fps)".to_owned(),
            got(),
        )
    })
}

/// Cuts a bundle into its clips.
fn split(clip: &MotionClip, segments: &[(String, usize, usize)], file: &Path) -> Result<Vec<MotionClip>, MotionError> {
    let one = |(name, first, frames): &(String, usize, usize)| {
        let end = first.checked_add(*frames).filter(|end| *frames > 0 && *end <= clip.len());
        let expected = format!("segments within {} frames", clip.len());
        let end = end.ok_or_else(|| container(file, expected, format!("{frames} frames from {first} on")))?;
        let width = clip.joint_names.len();
        Ok(MotionClip {
            name: name.clone(),
            root_position: clip.root_position[*first..end].to_vec(),
            root_orientation: clip.root_orientation[*first..end].to_vec(),
            joints: clip.joints[first * width..end * width].to_vec(),
            ..clip.clone()
        })
    };
    // Segments that overlap would multiply a small file.
    let total = segments.iter().fold(0_usize, |total, (_, _, frames)| total.saturating_add(*frames));
    if total > clip.len() {
        return Err(container(file, format!("segments of {} frames in all", clip.len()), total.to_string()));
    }
    segments.iter().map(one).collect()
}

/// Returns the names of a robot's joints, in the order of the model.
fn names_of(robot: &Character) -> Vec<String> {
    robot.scalar_joints().map(|joint| joint.name.clone()).collect()
}

/// Returns the names of the G1's joints.
fn g1_names() -> Vec<String> {
    G1.split_whitespace().map(|name| format!("{name}_joint")).collect()
}

/// Returns the names of joints that come without: those of the robot where the number is right, else the G1's.
fn joint_names(count: usize, context: &Context<'_>) -> Result<Vec<String>, MotionError> {
    let robot = context.robot.map(names_of).filter(|names| names.len() == count);
    robot.or_else(|| Some(g1_names()).filter(|names| names.len() == count)).ok_or_else(|| {
        let of = context
            .robot
            .filter(|robot| robot.scalar_joints().count() != 29)
            .map(|robot| format!("{} of {}, or ", robot.scalar_joints().count(), robot.name));
        let expected =
            format!("{}29 joints of the G1; --robot ROBOT names the joints of another", of.unwrap_or_default());
        container(context.file, expected, format!("{count} joints without names"))
    })
}

/// Returns the clip's columns in the order of the robot, or of the G1 where no robot is given.
fn in_order(clip: &MotionClip, context: &Context<'_>) -> Result<Vec<usize>, MotionError> {
    if let Some(robot) = context.robot {
        return clip.columns_for(robot);
    }
    let names = g1_names();
    let columns = names.iter().map(|name| clip.joint_names.iter().position(|joint| joint == name));
    let columns: Option<Vec<usize>> = columns.collect();
    columns.filter(|columns| columns.len() == clip.joint_names.len()).ok_or_else(|| {
        unfit(
            clip,
            "the layout has joints in the robot's order: expected --robot ROBOT or the G1's 29 joints".to_owned(),
        )
    })
}

/// Returns rows of three numbers as vectors.
fn vectors(numbers: &[f64]) -> Vec<Vec3> {
    numbers.as_chunks::<3>().0.iter().map(|row| Vec3::from(*row)).collect()
}

fn container(file: &Path, expected: String, got: String) -> MotionError {
    MotionError::format(file.display(), expected, got)
}

fn unfit(clip: &MotionClip, message: String) -> MotionError {
    MotionError::Unfit { clip: clip.name.clone(), message }
}
