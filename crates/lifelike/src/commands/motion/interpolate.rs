//! `lifelike motion interpolate`: a motion between two others, through the latent space (thesis 4.3.2).

use std::path::{Path, PathBuf};

use lifelike_motion::{MotionClip, Provenance, container};
use lifelike_report::{Playback, ReportBuilder};
use lifelike_representation::MotionPrior;
use lifelike_representation::latent::Codes;
use lifelike_representation::latent::footing::{Footing, footing};
use lifelike_representation::latent::interpolation::{Blend, interpolate};
use lifelike_representation::latent::unroll::Unrolled;
use lifelike_robot::Robot;
use serde::Serialize;
use serde_json::json;

use super::file_of;
use crate::commands::{clips, prior_file};
use crate::destination;
use crate::error::CliError;
use crate::output::{Output, table};

/// Make a motion between two clips: their latent codes are interpolated, and every code's window is decoded.
///
/// The middle frames of the decoded windows become a clip. The path on the ground is integrated from the decoded
/// velocities, and joints are clamped to their ranges. The result is kinematic: feet may slide, and the table reports
/// how much, beside the originals and their reconstructions.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  lifelike motion interpolate walk.motion.safetensors run.motion.safetensors \\
      --prior lima --weight 0.5 -o motions/between
  lifelike motion interpolate walk.bvh kick.bvh --prior lima --ramp -o between --look

Motions may be *.motion.safetensors, or captured motion and keyframes, which are retargeted on the way.")]
pub struct Args {
    /// The first clip.
    pub first: PathBuf,
    /// The second clip.
    pub second: PathBuf,
    /// Layout of the motion.
    #[command(flatten)]
    pub layout: clips::LayoutArgument,
    /// The motion prior whose latent space is crossed.
    #[arg(long)]
    pub prior: PathBuf,
    /// Share of the second clip, from 0 to 1.
    #[arg(long, default_value_t = 0.5, conflicts_with = "ramp")]
    pub weight: f64,
    /// From the first clip at the begin to the second at the end.
    #[arg(long)]
    pub ramp: bool,
    /// Folder of the result, or its file (NAME.motion.safetensors).
    #[arg(short, long, value_parser = crate::destination::motion)]
    pub output: PathBuf,
    /// Write report.html, where clips and result can be played and looked at from all sides.
    #[arg(long)]
    pub look: bool,
    /// The robot: a name, or an MJCF or URDF file.
    #[arg(short, long, default_value = "lima")]
    pub robot: String,
}

/// A motion in numbers.
#[derive(Debug, Serialize)]
struct Row {
    motion: String,
    seconds: f64,
    path_m: f64,
    footing: Footing,
    /// Share of joint values that the decoder put beyond their range, and how far at most; both are within it in the clip.
    clamped: Option<f64>,
    beyond_deg: Option<f64>,
}

/// Runs the command.
pub fn run(args: &Args, output: &Output) -> Result<(), CliError> {
    if !(0.0..=1.0).contains(&args.weight) {
        return Err(CliError::Usage(format!("--weight: expected a number from 0 to 1, got {}", args.weight)));
    }
    let robot = Robot::load(&args.robot)?;
    let prior = prior_file::load_for(&args.prior, &robot)?;
    let (first, second) = (
        clips::load_one_as(&args.first, args.layout.layout, &robot)?,
        clips::load_one_as(&args.second, args.layout.layout, &robot)?,
    );
    let (a, b) = (codes(&prior, &robot, &first)?, codes(&prior, &robot, &second)?);
    let between = |how| interpolate(&prior, &robot.character, a.rows(), b.rows(), how);
    let how = if args.ramp { Blend::Ramp } else { Blend::Constant(args.weight) };
    let mut made = named(between(how)?, &first, &second, args);
    let path = file_of(&args.output, &mut made.clip)?;
    container::write(&path, &made.clip)?;
    let rows = [
        row(&robot, first.name.clone(), &first, None)?,
        decoded(&robot, &first.name, &between(Blend::Constant(0.0))?)?,
        row(&robot, second.name.clone(), &second, None)?,
        decoded(&robot, &second.name, &between(Blend::Constant(1.0))?)?,
        row(&robot, made.clip.name.clone(), &made.clip, Some(&made))?,
    ];
    if args.look {
        let beside = || path.with_file_name(format!("{}-look", made.clip.name));
        let folder = if destination::is_motion(&args.output) { beside() } else { args.output.clone() };
        look(&folder, &robot, [&first, &second, &made.clip])?;
    }
    output.result(&json!({ "clip": made.clip.name, "file": path, "motions": rows }), || text(&rows, &path))
}

fn codes(prior: &MotionPrior, robot: &Robot, clip: &MotionClip) -> Result<Codes, CliError> {
    let frames = prior_file::frames(std::slice::from_ref(clip), robot, prior.windows().frame_rate)?;
    Ok(Codes::of_prior(prior, &frames)?)
}

/// The result with its name and where it is from: its parents' terms hold for it too.
fn named(mut made: Unrolled, first: &MotionClip, second: &MotionClip, args: &Args) -> Unrolled {
    let how = if args.ramp { "ramp".to_string() } else { args.weight.to_string() };
    made.clip.name = format!("{}+{}-{how}", first.name, second.name);
    let (a, b) = (&first.provenance, &second.provenance);
    let licence = if a.licence == b.licence { a.licence.clone() } else { format!("{}; {}", a.licence, b.licence) };
    let source = format!("latent interpolation of {} and {}", first.name, second.name);
    made.clip.provenance = Provenance { source, licence, ..made.clip.provenance };
    made
}

fn row(robot: &Robot, motion: String, clip: &MotionClip, made: Option<&Unrolled>) -> Result<Row, CliError> {
    Ok(Row {
        motion,
        seconds: clip.seconds(),
        path_m: clip.root_position.windows(2).map(|w| (w[1] - w[0]).xy().norm()).sum(),
        footing: footing(clip, &robot.character, &robot.anatomy)?,
        clamped: made.map(|m| m.clamped),
        beyond_deg: made.map(|m| m.excess.to_degrees()),
    })
}

/// Reconstruction of a clip by the prior alone: an interpolation can be no better.
fn decoded(robot: &Robot, name: &str, made: &Unrolled) -> Result<Row, CliError> {
    row(robot, format!("{name}, decoded"), &made.clip, Some(made))
}

fn look(folder: &Path, robot: &Robot, clips: [&MotionClip; 3]) -> Result<(), CliError> {
    let playbacks = clips
        .iter()
        .map(|clip| Ok(Playback::from_clip(&robot.character, clip)?))
        .collect::<Result<Vec<_>, CliError>>()?;
    let page = ReportBuilder::new(clips[2].name.as_str()).playback(&robot.character, &playbacks);
    Ok(page.write(&folder.join("report.html"))?)
}

fn text(rows: &[Row], path: &Path) -> String {
    let or_dash = |value: Option<f64>| value.map_or_else(|| "-".to_string(), |v| format!("{v:.1}"));
    let cells = |row: &Row| {
        vec![
            row.motion.clone(),
            format!("{:.2}", row.seconds),
            format!("{:.2}", row.path_m),
            format!("{:.1}", 100.0 * row.footing.skate),
            format!("{:.0}", 100.0 * row.footing.bearing),
            format!("{:.1}", 100.0 * row.footing.deepest),
            or_dash(row.clamped.map(|share| 100.0 * share)),
            or_dash(row.beyond_deg),
        ]
    };
    let head = [
        "motion",
        "length (s)",
        "path (m)",
        "skate (cm/s)",
        "in contact (%)",
        "deepest (cm)",
        "clamped (%)",
        "beyond (deg)",
    ];
    let rows: Vec<Vec<String>> = rows.iter().map(cells).collect();
    format!("{}\nclip: {}\n", table(&head, &rows), path.display())
}
