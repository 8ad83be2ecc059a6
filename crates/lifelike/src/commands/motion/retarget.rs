//! `lifelike motion retarget`: captured motion onto a robot.

mod summary;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;
use std::time::Instant;

use lifelike_evaluation::Verdict;
use lifelike_motion::edit::{self, repair::Change};
use lifelike_motion::formats::robot_motion::Layout;
use lifelike_motion::formats::{self, Angles, Axis, CaptionTable, FileMotion, Format, ReadOptions};
use lifelike_motion::retarget::{Correspondence, RetargetOptions, RetargetReport, retarget, source_of_robot};
use lifelike_motion::{MotionError, SourceClip, container, feasibility};
use lifelike_report::{Playback, ReportBuilder};
use lifelike_robot::Robot;
use rayon::prelude::*;

use super::{container_in, fetched_g1, motion_files, robot_of};
use crate::commands::clips;
use crate::error::CliError;
use crate::output::Output;
use crate::progress::Progress;
use crate::{interrupt, overrides};

/// Clips that `--look` shows: a page with all of a data set would be too large for a browser.
const LOOK_CLIPS: usize = 24;

/// Retarget captured human motion, or the motion of another robot, to a robot.
///
/// Every clip is either converted or refused with the reason. Clips come out as *.motion.safetensors together with
/// retarget.json, the report of all of them.
#[derive(Debug, clap::Args)]
#[command(after_help = after_help())]
pub struct Args {
    /// Files, folders of them, or patterns; then options as key=value.
    #[arg(required = true, value_name = "INPUT|KEY=VALUE")]
    pub inputs: Vec<String>,
    /// A robot's name, or its MJCF or URDF file.
    #[arg(short, long, default_value = "lima")]
    pub robot: String,
    /// Folder of the results.
    #[arg(short, long, value_parser = crate::destination::folder)]
    pub output: PathBuf,
    /// Options in a TOML file: rates, limits, contact detection, [correspondence.roles] of the source's joints.
    #[arg(long)]
    pub options: Option<PathBuf>,
    /// Skeleton of the inputs: the .asf of .amc files, the character file of DeepMimic clips.
    #[arg(long)]
    pub skeleton: Option<PathBuf>,
    /// Metres per unit of length of BVH files, where the guess (m, cm, mm, the CMU's unit) is wrong.
    #[arg(long, value_name = "METRES")]
    pub scale: Option<f64>,
    /// Frames per second of the inputs, where the files say nothing (AMC: 120) or something wrong.
    #[arg(long, alias = "amc-fps", value_name = "RATE", allow_negative_numbers = true)]
    pub fps: Option<f64>,
    /// Axis of the inputs that is up: x, y, z, -x, -y or -z; found from rest pose and motion where not given.
    #[arg(long, value_name = "AXIS", allow_hyphen_values = true)]
    pub up: Option<Axis>,
    /// Axis that the inputs' rest pose (or else the motion at first) faces; found where not given.
    #[arg(long, value_name = "AXIS", allow_hyphen_values = true)]
    pub forward: Option<Axis>,
    /// Unit of the angles of BVH files, degrees or radians; degrees where the motion does not show radians.
    #[arg(long, value_name = "UNIT")]
    pub angles: Option<Angles>,
    /// Joints that names do not tell: ROLE=JOINT,... (roles as in [correspondence.roles], left_toe, right_toe).
    #[arg(long, value_name = "ROLE=JOINT,...")]
    pub roles: Option<Correspondence>,
    /// Robot of inputs that are a robot's motion: a name, or an MJCF or URDF file; the inputs' own where not given.
    #[arg(long, value_name = "ROBOT")]
    pub source_robot: Option<String>,
    /// Layout of inputs that are a robot's motion (see `lifelike motion convert --help`); found where not given.
    #[arg(long, value_name = "LAYOUT", value_parser = formats::robot_motion::by_name)]
    pub layout: Option<&'static Layout>,
    /// A table of captions (tab-separated) that are kept with the clips.
    #[arg(long)]
    pub captions: Option<PathBuf>,
    /// Clips at a time; one per processor where not given.
    #[arg(long, value_parser = crate::bounds::threads)]
    pub threads: Option<usize>,
    /// Repair what the robot could not execute, as `lifelike motion repair` does, and refuse what cannot be repaired.
    #[arg(long)]
    pub feasible: bool,
    /// Write report.html, where the first clips can be played and looked at from all sides.
    #[arg(long)]
    pub look: bool,
    /// Fail (exit code 3) when any clip is refused, not only when all are.
    #[arg(long)]
    pub strict: bool,
}

/// Examples, and the formats as the readers' table has them.
fn after_help() -> String {
    format!(
        "\
Examples:
  lifelike motion retarget walk.bvh --robot lima -o motions/lima
  lifelike motion retarget mocap/cmu 'mocap/bandai/*walk*.bvh' --robot humanoid \\
      -o motions/humanoid
  # human and robot side by side
  lifelike motion retarget mocap/walk.bvh --robot lima -o data/own --look
  lifelike motion retarget mocap/cmu --feasible --robot lima -o motions/lima
  lifelike motion retarget dance.bvh --up z --forward=-y \\
      --roles left_hand=L_Palm,right_hand=R_Palm -o out
  # from one robot to another
  lifelike motion retarget g1_dance.csv --source-robot g1 --robot lima -o out
  lifelike motion retarget dance.amc --skeleton 05.asf --robot my_robot.xml \\
      -o out swing_clearance=0.03

Formats: {}.
--skeleton names the file that would lie beside.
Options such as fps=30, smoothing=0.03, allow_off_ground=true stand at the end; an unknown one lists them all.",
        formats::supported(Format::is_source)
    )
}

/// Outcome of one input file.
#[derive(Debug, serde::Serialize)]
struct Done {
    file: PathBuf,
    #[serde(skip_serializing_if = "Option::is_none")]
    output: Option<PathBuf>,
    #[serde(skip_serializing_if = "Option::is_none")]
    report: Option<RetargetReport>,
    /// Verdict by kinematics and masses.
    #[serde(skip_serializing_if = "Option::is_none")]
    verdict: Option<Verdict>,
    /// Changes by `--feasible`.
    #[serde(skip_serializing_if = "Option::is_none")]
    repaired: Option<Change>,
    #[serde(skip_serializing_if = "Option::is_none")]
    refused: Option<String>,
    /// Reading, converting and writing (s of one core).
    seconds: f64,
}

/// Runs the command.
pub fn run(args: &Args, output: &Output) -> Result<(), CliError> {
    crate::bounds::frame_rate("--fps", args.fps)?;
    let (inputs, changes) = split(&args.inputs);
    let robot = Robot::load(&args.robot)?;
    let other = args.source_robot.as_deref().map(Robot::load).transpose()?;
    let options = options(args, &robot, &changes)?;
    let read = ReadOptions {
        scale: args.scale,
        fps: args.fps,
        up: args.up,
        forward: args.forward,
        angles: args.angles,
        correspondence: options.correspondence.clone(),
        skeleton: args.skeleton.clone(),
        captions: args.captions.as_deref().map(CaptionTable::load).transpose()?,
        layout: args.layout,
        robot: other.as_ref().map(|other| other.character.clone()).or_else(|| Some(fetched_g1()?.character)),
        ..ReadOptions::default()
    };
    let reads = Reads { options: read, robot: &robot, other };
    let files = motion_files(&inputs, |format| format.is_source() || reads.other.is_some())?;
    std::fs::create_dir_all(&args.output).map_err(CliError::write(&args.output))?;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(args.threads.unwrap_or(0)).build();
    let pool = pool.map_err(|e| CliError::Failed(e.to_string()))?;
    let stop = interrupt::flag()?;
    let progress = Progress::new(output, "retargeting", files.len() as u64);
    let bar = progress.shared();
    let work = |(file, name): (&PathBuf, &Result<String, String>)| {
        if stop.load(Ordering::SeqCst) {
            return None;
        }
        let began = Instant::now();
        let converted = match name {
            Ok(name) => convert(file, name, &reads, &options, args),
            Err(why) => Err(why.clone()),
        };
        bar.inc(1);
        let done = Done {
            file: file.clone(),
            output: None,
            report: None,
            verdict: None,
            repaired: None,
            refused: None,
            seconds: 0.0,
        };
        let seconds = began.elapsed().as_secs_f64();
        Some(match converted {
            Ok(made) => {
                let (output, report, verdict) = (Some(made.file), Some(made.report), Some(made.verdict));
                Done { output, report, verdict, repaired: made.repaired, seconds, ..done }
            }
            Err(why) => Done { refused: Some(why), seconds, ..done },
        })
    };
    let began = Instant::now();
    let names = clip_names(&files);
    let done: Vec<Done> = pool.install(|| files.par_iter().zip(&names).filter_map(work).collect());
    progress.finish();
    let summary = summary::Summary::new(&robot.name, &done, began.elapsed().as_secs_f64(), pool.current_num_threads());
    let report = args.output.join("retarget.json");
    let json = serde_json::json!({ "summary": summary, "options": options, "clips": done });
    crate::output::write_json(&report, &json)?;
    let page = args.look.then(|| look(&args.output, &reads, &done)).transpose()?;
    output.result(&json, || summary::text(&summary, &done, (&report, page.as_deref()), &args.robot))?;
    if stop.load(Ordering::SeqCst) {
        return Err(CliError::Interrupted(format!("{} of {} files done", done.len(), files.len())));
    }
    match summary.refused {
        0 => Ok(()),
        n if n == done.len() => Err(CliError::Input("every clip was refused".into())),
        n if args.strict => Err(CliError::Input(format!("{n} clips were refused"))),
        _ => Ok(()),
    }
}

fn options(args: &Args, robot: &Robot, changes: &[String]) -> Result<RetargetOptions, CliError> {
    let mut options = match &args.options {
        Some(path) => overrides::load(path, changes)?,
        None => overrides::apply(clips::retarget_options(robot), changes)?,
    };
    if let Some(roles) = &args.roles {
        options.correspondence.merge(roles);
    }
    clips::limit_speeds(&mut options, robot);
    Ok(options)
}

/// Reading of inputs.
struct Reads<'a> {
    options: ReadOptions,
    /// The robot that the motion goes to.
    robot: &'a Robot,
    /// The robot of inputs that are a robot's motion.
    other: Option<Robot>,
}

impl Reads<'_> {
    /// Reads captured motion; or the motion of another robot as a source, with the roles of its joints.
    fn source(&self, file: &Path) -> Result<(SourceClip, Correspondence), CliError> {
        let clip = match formats::read(file, &self.options)? {
            FileMotion::Source(mut source) => {
                if self.other.is_some() || self.options.layout.is_some() {
                    let note = "human motion: --source-robot and --layout are for motion of robots and were ignored";
                    source.notes.push(note.to_owned());
                }
                return Ok((source, Correspondence::default()));
            }
            FileMotion::Robot(clip) => clip,
        };
        let from = |robot: &Robot| Ok(source_of_robot(&clip, &robot.character, &robot.anatomy)?);
        if let Some(other) = &self.other {
            return from(other);
        }
        if clip.columns_for(&self.robot.character).is_ok() {
            let message = format!("{}: motion of {} already: nothing to retarget", file.display(), self.robot.name);
            return Err(CliError::Input(message));
        }
        from(&robot_of(&clip).ok_or_else(|| {
            let robot = &clip.provenance.character;
            CliError::Input(format!("{}: motion of robot '{robot}': expected --source-robot ROBOT", file.display()))
        })?)
    }
}

/// A clip that was written.
struct Converted {
    file: PathBuf,
    report: RetargetReport,
    verdict: Verdict,
    repaired: Option<Change>,
}

/// Converts a file; or says why not.
fn convert(
    file: &Path,
    name: &str,
    reads: &Reads<'_>,
    options: &RetargetOptions,
    args: &Args,
) -> Result<Converted, String> {
    let words = |error: MotionError| error.to_string();
    let robot = reads.robot;
    let (mut source, roles) = reads.source(file).map_err(|error| error.to_string())?;
    source.name = name.to_string();
    let mut options = options.clone();
    options.correspondence.merge(&roles);
    let options = &options;
    let (mut clip, report) = retarget(&source, &robot.character, &robot.anatomy, options).map_err(words)?;
    let mut repaired = None;
    if args.feasible {
        let (made, told) =
            edit::repair(&clip, &robot.character, &robot.anatomy, &robot.speeds(), options).map_err(words)?;
        if let Some(reason) = told.after.reasons().next() {
            return Err(format!("clip '{name}' could not be made feasible: {}", reason.words()));
        }
        if !told.before.trackable {
            (clip, repaired) = (made, Some(told.change));
        }
    }
    let path = container_in(&args.output, &clip.name).map_err(|error| error.to_string())?;
    container::write(&path, &clip).map_err(words)?;
    let found = feasibility::check(&clip, &robot.character, &robot.anatomy, &robot.speeds()).map_err(words)?;
    Ok(Converted { file: path, report, verdict: Verdict::without_physics(&found), repaired })
}

/// A page that plays the first clips beside the humans they come from, with numbers and a verdict for each clip. Returns its
/// path.
fn look(folder: &Path, reads: &Reads<'_>, done: &[Done]) -> Result<PathBuf, CliError> {
    let robot = reads.robot;
    let (character, anatomy) = (&robot.character, &robot.anatomy);
    let mut playbacks = Vec::new();
    for one in done.iter().filter(|one| one.output.is_some()).take(LOOK_CLIPS) {
        let (Some(path), Some(report)) = (&one.output, &one.report) else { continue };
        let clip = container::read(path)?;
        let (source, _) = reads.source(&one.file)?;
        let playback = Playback::from_clip(character, &clip)?.with_contacts(character, anatomy, &clip);
        let playback = playback.beside_source(&source, report.scale, report.tempo);
        let verdict = one.verdict.as_ref().map_or_else(String::new, Verdict::to_string);
        let (position, angle) = summary::errors(report);
        let note = format!("{verdict} · {angle:.1}° · {:.1} cm · {:.1} s", 100.0 * position, report.seconds);
        playbacks.push(Playback { note, ..playback });
    }
    let path = folder.join("report.html");
    ReportBuilder::new(format!("Motion of {}", robot.name))
        .subtitle("Captured motion beside the robot's, both in the robot's size.")
        .playback(character, &playbacks)
        .table(summary::table_of(done))
        .write(&path)?;
    Ok(path)
}

/// Splits arguments into files or folders, and options: options have a `=` and are no file.
fn split(arguments: &[String]) -> (Vec<PathBuf>, Vec<String>) {
    let (changes, inputs): (Vec<&String>, Vec<&String>) =
        arguments.iter().partition(|a| a.contains('=') && !Path::new(a).exists());
    (inputs.into_iter().map(PathBuf::from).collect(), changes.into_iter().cloned().collect())
}

/// A name of its own for each clip: the file's, and where that is taken (a data set in two formats), the format after it.
/// Third ones of a name are refused with the file that has it.
fn clip_names(files: &[PathBuf]) -> Vec<Result<String, String>> {
    let mut taken: BTreeMap<String, &PathBuf> = BTreeMap::new();
    let name = |file: &PathBuf| {
        let stem = formats::clip_name(file);
        let extension = file.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
        (format!("{stem}-{extension}"), stem)
    };
    let mut names = Vec::with_capacity(files.len());
    for file in files {
        let (long, short) = name(file);
        let free = [short, long].into_iter().find(|name| !taken.contains_key(name));
        names.push(match free {
            Some(name) => {
                taken.insert(name.clone(), file);
                Ok(name)
            }
            None => {
                let other = taken.get(&name(file).1).map(|f| f.display().to_string()).unwrap_or_default();
                Err(format!("{other} has the same name; convert them into different folders"))
            }
        });
    }
    names
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn options_stand_among_the_inputs() {
        let arguments = ["a.bvh", "fps=30", "b/*.amc"].map(String::from);
        let (inputs, changes) = split(&arguments);
        assert_eq!(inputs, [PathBuf::from("a.bvh"), PathBuf::from("b/*.amc")]);
        assert_eq!(changes, ["fps=30"]);
    }

    #[test]
    fn no_clip_writes_over_another() {
        let files = ["a/01.amc", "b/01.bvh", "b/02.bvh", "c/01.bvh", "d/02.keys.toml"].map(PathBuf::from);
        let names = clip_names(&files);
        assert_eq!(names[..3], ["01", "01-bvh", "02"].map(|n| Ok(n.to_string())));
        assert!(names[3].as_ref().unwrap_err().contains("a/01.amc"));
        assert_eq!(names[4], Ok("02-toml".to_string()));
    }
}
