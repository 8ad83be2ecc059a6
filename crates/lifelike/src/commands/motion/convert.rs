//! `lifelike motion convert`: the motion of a robot in another layout, or at another rate.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use lifelike_character::anatomy::Overrides;
use lifelike_character::{Anatomy, Character};
use lifelike_motion::MotionClip;
use lifelike_motion::formats::ReadOptions;
use lifelike_motion::formats::robot_motion::{self, Layout, Rate, Reading};
use lifelike_motion::resample::resample;
use lifelike_robot::Robot;
use serde::Serialize;

use super::{fetched_g1, motion_files, robot_of};
use crate::destination;
use crate::error::CliError;
use crate::output::{Output, table};

/// Convert the motion of robots: to the layout of another program, to a table, or to another rate.
///
/// The layout of an input is found from its content and printed. Losses of the new layout are printed too.
/// Velocities and poses of bodies are computed anew, as the programs compute them.
#[derive(Debug, clap::Args)]
#[command(after_help = after_help())]
pub struct Args {
    /// A file and the file to write; with --output files, folders of them, or patterns.
    #[arg(required = true, value_name = "A B")]
    pub inputs: Vec<PathBuf>,
    /// Folder of the results, for any number of inputs.
    #[arg(short, long, value_parser = crate::destination::folder)]
    pub output: Option<PathBuf>,
    /// Layout of the results; by the ending of B or `motion` where not given.
    #[arg(long, value_name = "LAYOUT", value_parser = robot_motion::by_name)]
    pub to: Option<&'static Layout>,
    /// Layout of the inputs; found from their content where not given.
    #[arg(long, value_name = "LAYOUT", value_parser = robot_motion::by_name)]
    pub layout: Option<&'static Layout>,
    /// Frames per second of the results; the layout's own where not given, else as they are.
    #[arg(long, value_name = "RATE", allow_negative_numbers = true)]
    pub fps: Option<f64>,
    /// Frames per second of the inputs, where they say nothing or something wrong.
    #[arg(long, value_name = "RATE", allow_negative_numbers = true)]
    pub input_fps: Option<f64>,
    /// The robot: a name, or an MJCF or URDF file; the clip's, or a fetched G1, where not given.
    #[arg(short, long)]
    pub robot: Option<String>,
}

/// Examples, and the layouts.
fn after_help() -> String {
    let layouts = robot_motion::LAYOUTS.iter().map(|layout| format!("  {:14} {}", layout.name, layout.title));
    format!(
        "\
Examples:
  # the layout of dance.csv is printed
  lifelike motion convert dance.csv dance.motion.safetensors
  lifelike motion convert dance.csv dance.npz --to mjlab --robot g1
  lifelike motion convert dance.csv dance.npz --layout kimodo --to holosoma --robot g1 --fps 50
  lifelike motion convert motions/lima --fps 100 -o motions/lima-100
  lifelike motion convert wave.motion.safetensors --to csv -o tables

Layouts:
{}",
        layouts.collect::<Vec<_>>().join("\n")
    )
}

/// A clip that was written.
#[derive(Debug, Serialize)]
struct Done {
    clip: String,
    /// Layout of the input, and its features.
    read_as: String,
    fps: f64,
    frames: usize,
    layout: &'static str,
    file: PathBuf,
    /// Losses of the result, and other remarks on it.
    notes: Vec<String>,
}

/// Runs the command.
pub fn run(args: &Args, output: &Output) -> Result<(), CliError> {
    crate::bounds::frame_rate("--fps", args.fps)?;
    crate::bounds::frame_rate("--input-fps", args.input_fps)?;
    let own = args.robot.as_deref().map(Robot::load).transpose()?.map(|robot| robot.character);
    let reader = own.clone().or_else(|| fetched_g1().map(|robot| robot.character));
    let options = ReadOptions { fps: args.input_fps, layout: args.layout, robot: reader, ..ReadOptions::default() };
    let done = match &args.output {
        None => vec![one(args, &options, own.as_deref())?],
        Some(folder) => all(args, folder, &options, own.as_deref())?,
    };
    output.result(&done, || text(&done))
}

/// Converts A to B.
fn one(args: &Args, options: &ReadOptions, robot: Option<&Character>) -> Result<Done, CliError> {
    let [input, file] = args.inputs.as_slice() else {
        return Err(CliError::Usage("expected A B, or inputs and --output FOLDER".into()));
    };
    let layout = args.to.map_or_else(|| robot_motion::by_ending(file).map_err(CliError::Input), Ok)?;
    keep(input, file)?;
    check_ending(file, layout)?;
    let mut reading = robot_motion::open(input, options)?;
    let (Some(mut clip), true) = (reading.clips.pop(), reading.clips.is_empty()) else {
        let message = format!("{}: a bundle of clips; -o FOLDER writes each into a file of its own", input.display());
        return Err(CliError::Input(message));
    };
    clip.name = lifelike_motion::formats::clip_name(file);
    convert(&clip, &reading, layout, file.clone(), args.fps, robot)
}

/// Converts every clip of the inputs into a file of the folder.
fn all(args: &Args, folder: &Path, options: &ReadOptions, robot: Option<&Character>) -> Result<Vec<Done>, CliError> {
    let layout = args.to.map_or_else(|| robot_motion::by_name("motion").map_err(CliError::Failed), Ok)?;
    let ending = layout.endings.first().copied().unwrap_or_default();
    let files = motion_files(&args.inputs, |format| !format.is_source())?;
    // What is refused is refused before the first file is written.
    let mut taken: BTreeMap<PathBuf, &Path> = BTreeMap::new();
    for input in &files {
        for clip in robot_motion::open(input, options)?.clips {
            let file = destination::named(folder, &clip.name, ending)?;
            keep(input, &file)?;
            check_joints(&clip, robot)?;
            if let Some(other) = taken.insert(file, input) {
                let (other, input, name) = (other.display(), input.display(), &clip.name);
                let message = format!(
                    "{other} and {input}: both clips are named '{name}'; convert one into another folder (--output), or \
                     to a file of another name (`convert A B`)"
                );
                return Err(CliError::Input(message));
            }
        }
    }
    std::fs::create_dir_all(folder).map_err(CliError::write(folder))?;
    let mut done = Vec::new();
    for input in &files {
        let reading = robot_motion::open(input, options)?;
        for clip in &reading.clips {
            let file = destination::named(folder, &clip.name, ending)?;
            done.push(convert(clip, &reading, layout, file, args.fps, robot)?);
        }
    }
    Ok(done)
}

/// Checks that a clip has the joints of the robot that was given.
fn check_joints(clip: &MotionClip, robot: Option<&Character>) -> Result<(), CliError> {
    robot.map_or(Ok(()), |robot| clip.columns_for(robot).map(drop).map_err(CliError::from))
}

/// Checks that a file has a name, which does not end as those of other layouts alone.
fn check_ending(file: &Path, layout: &Layout) -> Result<(), CliError> {
    let name = file.to_string_lossy().to_ascii_lowercase();
    if name == "-" {
        return Err(CliError::Input("expected a file, got '-': results are files, which are not printed".into()));
    }
    let ends = |layout: &Layout| layout.endings.iter().any(|ending| name.ends_with(ending));
    if !ends(layout) && robot_motion::LAYOUTS.iter().any(|other| ends(other)) {
        let (file, to, endings) = (file.display(), layout.name, layout.endings.join(" or "));
        return Err(CliError::Input(format!("{file}: expected a name that ends in {endings}, as --to {to} writes")));
    }
    Ok(())
}

/// Checks that a result does not replace its input.
fn keep(input: &Path, file: &Path) -> Result<(), CliError> {
    let is_same = file.canonicalize().is_ok_and(|file| input.canonicalize().is_ok_and(|input| input == file));
    if is_same {
        return Err(CliError::Input(format!("{}: expected another file than the input", file.display())));
    }
    Ok(())
}

fn convert(
    clip: &MotionClip,
    reading: &Reading,
    layout: &'static Layout,
    file: PathBuf,
    fps: Option<f64>,
    robot: Option<&Character>,
) -> Result<Done, CliError> {
    check_joints(clip, robot)?;
    let rate = fps.unwrap_or_else(|| layout.rate.written(clip.fps));
    let resampled = resample(clip, rate)?;
    let known = if robot.is_none() { robot_of(clip) } else { None };
    let robot = robot.or(known.as_ref().map(|robot| robot.character.as_ref()));
    let bytes = robot_motion::write(&resampled, layout, robot)?;
    crate::output::write(&file, bytes)?;
    let mut notes = notes(clip, reading, layout, rate);
    notes.extend(mistakes(clip, reading, robot));
    let (clip, frames) = (resampled.name, resampled.root_position.len());
    Ok(Done { clip, read_as: reading.said.clone(), fps: rate, frames, layout: layout.name, file, notes })
}

fn notes(clip: &MotionClip, reading: &Reading, layout: &Layout, rate: f64) -> Vec<String> {
    let mut notes = Vec::new();
    if rate != clip.fps {
        notes.push(format!("resampled from {} to {rate} frames per second", clip.fps));
    }
    match layout.rate {
        Rate::Fixed(own) | Rate::Usual(own) if own != rate => {
            notes.push(format!("players of {} take {own} frames per second, this is at {rate}", layout.title));
        }
        _ => {}
    }
    if !reading.left_out.is_empty() {
        notes.push(format!("not kept of the input, or computed anew: {}", reading.left_out.join(", ")));
    }
    let lost = robot_motion::lost(clip, layout);
    if !lost.is_empty() {
        notes.push(format!("not held by {}: {}", layout.title, lost.join(", ")));
    }
    notes
}

/// Returns a sentence on the mistakes of convention in a clip of another program.
fn mistakes(clip: &MotionClip, reading: &Reading, robot: Option<&Character>) -> Option<String> {
    let robot = robot.filter(|_| reading.layout.name != "motion")?;
    let anatomy = Anatomy::guess(robot, &Overrides::default()).ok()?;
    let (_, flaws) = lifelike_motion::lint::lint(clip, robot, &anatomy).ok()?;
    let words: Vec<String> = flaws.iter().map(|flaw| flaw.mistake.words()).collect();
    (!words.is_empty()).then(|| format!("warning: {}; `lifelike motion lint` has evidence and --fix", words.join("; ")))
}

fn text(done: &[Done]) -> String {
    let row = |one: &Done| {
        let Done { clip, fps, frames, layout, file, .. } = one;
        vec![clip.clone(), fps.to_string(), frames.to_string(), (*layout).to_owned(), file.display().to_string()]
    };
    let rows: Vec<Vec<String>> = done.iter().map(row).collect();
    let mut text = table(&["clip", "frames/s", "frames", "layout", "file"], &rows);
    // Files of one data set have the same to say, so each sentence comes once.
    let mut said = BTreeSet::new();
    let sentences =
        done.iter().flat_map(|one| std::iter::once(format!("read as {}", one.read_as)).chain(one.notes.clone()));
    for sentence in sentences.filter(|sentence| said.insert(sentence.clone())) {
        text += &format!("{sentence}\n");
    }
    text
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use lifelike_character::{Quat, Vec3};
    use lifelike_motion::Provenance;

    #[test]
    fn a_table_has_a_head_and_a_row_per_frame() {
        let clip = MotionClip {
            name: "c".into(),
            fps: 4.0,
            joint_names: vec!["knee".into(), "a,b".into()],
            root_position: vec![Vec3::new(1.0, 2.0, 0.1), Vec3::zeros()],
            root_orientation: vec![Quat::identity(); 2],
            joints: vec![0.5, -0.25, 1.0, 2.0],
            contacts: None,
            cyclic: false,
            provenance: Provenance::default(),
        };
        let bytes = robot_motion::write(&clip, robot_motion::by_name("csv").unwrap(), None).unwrap();
        let text = String::from_utf8(bytes).unwrap();
        let lines: Vec<&str> = text.lines().collect();
        assert!(lines[0].ends_with("root_qz,knee,\"a,b\""));
        assert_eq!(lines[1], "0,1,2,0.1,1,0,0,0,0.5,-0.25");
        assert_eq!(lines[2], "0.25,0,0,0,1,0,0,0,1,2");
    }
}
