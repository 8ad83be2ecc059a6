//! `lifelike motion edit`: motion changed by the control points of its latent curves (thesis 3.3.3).

mod page;
mod points;

use std::path::{Path, PathBuf};
use std::str::FromStr;

use lifelike_motion::MotionClip;
use lifelike_motion::edit::settle;
use lifelike_representation::latent::footing::{Footing, footing};
use lifelike_representation::motion_spline::{Edit, MotionSpline, Playing, SplinedClip};
use serde::Serialize;
use serde_json::json;

use super::direct::{Common, Stage};
use crate::error::CliError;
use crate::next::NextCommand;
use crate::output::{Output, table};
use crate::shipped::{self, Kind};

/// Edit a clip by the control points of its latent curves: exaggerate, tone down, move, retime, super-sample, blend.
///
/// A trained motion spline (`lifelike train spline`) encodes every two seconds of motion as four control points. The
/// command changes these points and decodes them. The reconstruction error of the clip is added again (unless --bare),
/// so a clip without changes stays as it is. Joints are clamped to their ranges, and standing feet are put back on the
/// ground.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  lifelike motion edit builtin:walk --gain 1.4 -o data/edited --name big_walk --look
  lifelike motion edit builtin:sway_dance --reach 0.3 -o data/edited --name calm_dance
  lifelike motion edit builtin:wave --move 1:1=1.5 --segments 0,1 -o data/edited
  lifelike motion edit builtin:march --speed 0.7 -o data/edited --name slow_march
  lifelike motion edit builtin:walk --sample 4 -o data/edited --name walk_200hz
  lifelike motion edit builtin:walk --blend builtin:march --weight 0.5 -o data/edited
  # change bow.json, then:
  lifelike motion edit builtin:bow --save-points bow.json -o data/edited
  lifelike motion edit builtin:bow --points bow.json -o data/edited --name my_bow

Changes are made in this order: --points, --blend, --reach, --gain, --move; then the curves are played with --speed and --sample.
Results are called NAME-edited where no --name is given.")]
pub struct Args {
    /// The clip; anything but *.motion.safetensors is retargeted first.
    pub clip: PathBuf,
    /// The motion spline of the clip's robot; where not given, the one that comes with the program for its joints.
    #[arg(long)]
    pub spline: Option<PathBuf>,
    /// Move all control points away from (above 1) or towards (below 1) their average over the training motion.
    #[arg(long, value_name = "FACTOR")]
    pub gain: Option<f64>,
    /// Move inner control points away from (above 1) or towards (below 1) the nearer end of their segment.
    #[arg(long, value_name = "FACTOR")]
    pub reach: Option<f64>,
    /// Change one number of one control point, both counted from 0, by so many of its standard deviations over the training motion; may be
    /// repeated.
    #[arg(long = "move", value_name = "POINT:NUMBER=BY")]
    pub moves: Vec<Shift>,
    /// Segments, from 0, that --gain, --reach and --move are for; all where not given.
    #[arg(long, value_delimiter = ',')]
    pub segments: Vec<usize>,
    /// Mix in another clip's control points; it is stretched to this one's time.
    #[arg(long, value_name = "CLIP")]
    pub blend: Option<PathBuf>,
    /// Share of the other clip, from 0 to 1.
    #[arg(long, default_value_t = 0.5, requires = "blend")]
    pub weight: f64,
    /// Play the curves so many times as fast.
    #[arg(long, default_value_t = 1.0)]
    pub speed: f64,
    /// So many times as many frames per second, by sampling the curves more densely.
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=16))]
    pub sample: u32,
    /// Control points alone, without what they leave out of the clip.
    #[arg(long)]
    pub bare: bool,
    /// Take the control points from a file that --save-points wrote.
    #[arg(long, value_name = "FILE")]
    pub points: Option<PathBuf>,
    /// Write the control points, after all changes, as JSON.
    #[arg(long, value_name = "FILE")]
    pub save_points: Option<PathBuf>,
    /// Write report.html: before and after to play, latent curves with control points, joints over time.
    #[arg(long)]
    pub look: bool,
    /// Folder, name and robot of the result.
    #[command(flatten)]
    pub common: Common,
}

/// POINT:NUMBER=BY.
#[derive(Debug, Clone, Copy)]
pub struct Shift {
    point: usize,
    number: usize,
    by: f64,
}

impl FromStr for Shift {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parse = || {
            let (place, by) = text.split_once('=')?;
            let (point, number) = place.split_once(':')?;
            Some(Self { point: point.parse().ok()?, number: number.parse().ok()?, by: by.parse().ok()? })
        };
        parse().ok_or_else(|| format!("expected POINT:NUMBER=BY, such as 1:5=0.8, got '{text}'"))
    }
}

/// A motion in numbers.
#[derive(Debug, Serialize)]
struct Row {
    motion: String,
    seconds: f64,
    frames: usize,
    path_m: f64,
    /// Root mean square of the change of joints against the first row (deg).
    change_deg: f64,
    /// Root mean squares over joints and frames of finite differences (rad/s and rad/s²; m where a joint slides).
    velocity: f64,
    acceleration: f64,
    footing: Footing,
}

/// Runs the command.
pub fn run(args: &Args, output: &Output) -> Result<(), CliError> {
    let stage = args.common.stage([args.clip.as_path()])?;
    let model = model_for(args.spline.as_deref(), &stage)?;
    let clip = stage.clip(&args.clip)?;
    let before = SplinedClip::encode(&model, &clip)?;
    let after = changed(before.clone(), &model, &stage, args)?;
    if let Some(file) = &args.save_points {
        points::write(file, &after)?;
    }
    let fps = clip.fps * f64::from(args.sample);
    let playing = Playing { fps, speed: args.speed, detail: !args.bare };
    let played = before.original(&model, &playing)?;
    let (character, anatomy) = (&stage.robot.character, &stage.robot.anatomy);
    // Unchanged control points make the clip up to rounding, and there is nothing to put back on the ground.
    let unchanged = playing.detail && after.segments() == before.segments();
    let mut made = if unchanged {
        played.clone()
    } else {
        settle(&played, after.play(&model, &playing)?, character, anatomy, &stage.options)?
    };
    made.name = args.common.name.clone().unwrap_or_else(|| format!("{}-edited", clip.name));
    made.provenance.source = format!("{}, edited by control points", clip.provenance.source);
    let rows = [
        row(&stage, "as it was".into(), &played, &played)?,
        row(
            &stage,
            "control points alone".into(),
            &before.play(&model, &Playing { detail: false, ..playing })?,
            &played,
        )?,
        row(&stage, "edited".into(), &made, &played)?,
    ];
    let page =
        args.look.then(|| page::report(&stage, &model, [&before, &after], [&played, &made], &rows)).transpose()?;
    let written = args.common.write(made, &stage)?;
    if let Some(page) = page {
        page.write(&args.common.output.join("report.html"))?;
    }
    let value = json!({ "made": written, "segments": after.segments().len(), "motions": rows });
    output.result(&value, || format!("{}\n{}", text(&rows), written.text()))
}

/// A motion spline for this robot.
fn model_for(given: Option<&Path>, stage: &Stage) -> Result<MotionSpline, CliError> {
    let path = match given {
        Some(given) => shipped::file(given, Kind::Spline)?,
        None => shipped::of_robot(&stage.robot, Kind::Spline).ok_or_else(|| no_spline(stage))?.file()?,
    };
    let model = MotionSpline::load(&path)?;
    let wanted: Vec<&str> = stage.robot.character.scalar_joints().map(|j| j.name.as_str()).collect();
    let mut own: Vec<&str> = model.joints().iter().map(String::as_str).collect();
    let mut sorted = wanted.clone();
    own.sort_unstable();
    sorted.sort_unstable();
    if own != sorted {
        let (file, robot) = (path.display(), &stage.robot.name);
        let text = format!(
            "{file}: expected a motion spline of '{robot}' with joints {wanted:?}, got one with {:?}",
            model.joints()
        );
        return Err(CliError::Input(text));
    }
    Ok(model)
}

fn no_spline(stage: &Stage) -> CliError {
    CliError::Input(format!(
        "no motion spline for '{}' comes with the program: none has its joints. Train one and name it with --spline:\n\
         \x20 {}",
        stage.robot.name,
        NextCommand::new("train spline").word("--plan").word("spline").word("--robot").word("FILE")
    ))
}

fn changed(mut clip: SplinedClip, model: &MotionSpline, stage: &Stage, args: &Args) -> Result<SplinedClip, CliError> {
    if let Some(file) = &args.points {
        points::read(file, &mut clip)?;
    }
    if let Some(other) = &args.blend {
        clip.blend(model, &stage.clip(other)?, args.weight)?;
    }
    let factors = [args.reach.map(Edit::Reach), args.gain.map(Edit::Gain)];
    let moves = args.moves.iter().map(|m| Edit::Move { point: m.point, number: m.number, by: m.by });
    for edit in factors.into_iter().flatten().chain(moves) {
        clip.edit(model, edit, &args.segments)?;
    }
    Ok(clip)
}

fn row(stage: &Stage, motion: String, clip: &MotionClip, played: &MotionClip) -> Result<Row, CliError> {
    let columns = played.columns_for(&stage.robot.character)?;
    let own = clip.columns_for(&stage.robot.character)?;
    let squares: f64 = (0..clip.len())
        .flat_map(|f| own.iter().zip(&columns).map(move |(a, b)| clip.joints_at(f)[*a] - played.joints_at(f)[*b]))
        .map(|change| change * change)
        .sum();
    Ok(Row {
        motion,
        seconds: clip.seconds(),
        frames: clip.len(),
        path_m: clip.root_position.windows(2).map(|w| (w[1] - w[0]).xy().norm()).sum(),
        change_deg: (squares / clip.joints.len().max(1) as f64).sqrt().to_degrees(),
        velocity: difference(&clip.joints, clip.joint_names.len(), &[-1.0, 1.0]) * clip.fps,
        acceleration: difference(&clip.joints, clip.joint_names.len(), &[1.0, -2.0, 1.0]) * clip.fps.powi(2),
        footing: footing(clip, &stage.robot.character, &stage.robot.anatomy)?,
    })
}

/// Root mean square over `joints` and frames of a sum of neighbouring frames.
fn difference(values: &[f64], joints: usize, weights: &[f64]) -> f64 {
    let count = (values.len() + joints).saturating_sub(weights.len() * joints);
    let at = |i: usize| weights.iter().enumerate().map(|(k, weight)| weight * values[i + k * joints]).sum::<f64>();
    ((0..count).map(|i| at(i).powi(2)).sum::<f64>() / count.max(1) as f64).sqrt()
}

fn text(rows: &[Row]) -> String {
    let cells = |row: &Row| {
        vec![
            row.motion.clone(),
            format!("{:.2}", row.seconds),
            row.frames.to_string(),
            format!("{:.2}", row.path_m),
            format!("{:.2}", row.change_deg),
            format!("{:.3}", row.velocity),
            format!("{:.1}", row.acceleration),
            format!("{:.1}", 100.0 * row.footing.skate),
            format!("{:.0}", 100.0 * row.footing.bearing),
        ]
    };
    let head = [
        "motion",
        "length (s)",
        "frames",
        "path (m)",
        "joints change (deg)",
        "velocity (rad/s)",
        "acceleration (rad/s²)",
        "skate (cm/s)",
        "in contact (%)",
    ];
    table(&head, &rows.iter().map(cells).collect::<Vec<_>>())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn differences_by_hand() {
        // Two joints over three frames: 0, 1, 4 and 0, 0, 2.
        let values = [0.0, 0.0, 1.0, 0.0, 4.0, 2.0];
        assert!((difference(&values, 2, &[-1.0, 1.0]) - (14.0_f64 / 4.0).sqrt()).abs() < 1e-12);
        assert!((difference(&values, 2, &[1.0, -2.0, 1.0]) - 2.0).abs() < 1e-12);
        assert!(difference(&values[..4], 2, &[1.0, -2.0, 1.0]).abs() < 1e-12, "too short to say");
    }

    #[test]
    fn shifts_are_read() {
        let shift: Result<Shift, String> = "1:5=-0.8".parse();
        assert!(matches!(shift, Ok(Shift { point: 1, number: 5, by }) if (by + 0.8).abs() < 1e-12), "{shift:?}");
        for wrong in ["", "1", "1:5", "a:5=1", "1:5=x", "1=5:2"] {
            let error = wrong.parse::<Shift>().err();
            assert!(error.is_some_and(|e| e.contains("POINT:NUMBER=BY")), "{wrong}");
        }
    }
}
