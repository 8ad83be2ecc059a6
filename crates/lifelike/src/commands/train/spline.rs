//! `lifelike train spline`: a robot's motion as a few control points, for `lifelike motion edit`.

use std::path::PathBuf;

use lifelike_representation::motion_spline::{
    ClipErrors, MotionSpline, MotionSplinePlan, SplinedClip, SplitClips, WindowErrors,
};
use lifelike_representation::spline_transformer::SequenceTrainer;
use lifelike_robot::Robot;
use serde_json::json;

use super::driver::Driver;
use super::keys;
use super::source::Source;
use crate::commands::clips;
use crate::error::CliError;
use crate::next::NextCommand;
use crate::output::{Output, table};

/// Train a Spline-based Transformer on a robot's motion (thesis chapter 3): what `lifelike motion edit` edits with.
///
/// Windows of some seconds become four control points of a latent curve, and again motion. The run is a folder: plan.toml,
/// metrics.jsonl, checkpoints, and at the end motion.spline.safetensors with a table of how well clips come back. Ctrl-C saves
/// and stops; the same command goes on.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  lifelike train spline --plan spline                           # our own clips: needs no data
  lifelike train spline --plan spline -o runs/mine --robot MY_ROBOT.xml 'clips=[\"data/mine\"]'
  lifelike train spline --plan spline -o runs/small training.width=32 training.iterations=1000
  lifelike train spline -o runs/small --resume

A plan names robot, clips, clips for validation and for testing, and under [training] whatever differs from the defaults.
Clips of other robots are refused; captured motion and keyframes are retargeted on the way.")]
pub struct Args {
    /// Plan and folder.
    #[command(flatten)]
    pub source: Source,
}

/// Runs the command.
pub fn run(args: &Args, output: &Output) -> Result<(), CliError> {
    if keys::describe::<MotionSplinePlan>(&args.source, output)? {
        return Ok(());
    }
    let folder = args.source.folder()?;
    let plan: MotionSplinePlan = args.source.fixed(&folder)?;
    plan.check()?;
    let robot = Robot::load(&plan.robot)?;
    let training = clips::load(&plan.clips, &robot)?;
    // Nothing has to be held out.
    let held_out = |inputs: &[PathBuf]| if inputs.is_empty() { Ok(Vec::new()) } else { clips::load(inputs, &robot) };
    let clips = SplitClips {
        training: if plan.mirror { clips::with_mirror_images(training, &robot)? } else { training },
        validation: held_out(&plan.validation)?,
        test: held_out(&plan.test)?,
    };
    apart(&clips)?;
    let (data, space) = MotionSpline::data(&plan, &clips)?;
    let windows = data.training_len();
    let total = plan.training.iterations;
    let run = args.source.run_or_resume(&folder, &plan)?;
    let mut trainer = SequenceTrainer::new(plan.training.clone(), data)?;
    let summary =
        Driver::of(&args.source, &run, output).train(&mut trainer, |now| format!("error {:.3}", now.metrics.loss))?;
    let Some(summary) = summary else { return Ok(()) };
    let (robot_name, clip) = (plan.robot.clone(), plan.clips.first().cloned().unwrap_or_default());
    // A folder or pattern has many clips; `motion edit` takes one.
    let clip = if clip.is_file() { clip } else { "builtin:march".into() };
    let windows_of_test = WindowErrors::all(&trainer, &space)?;
    let model = MotionSpline::new(plan, space, &trainer)?;
    let path = folder.join("motion.spline.safetensors");
    model.save(&path)?;
    let (of, judged) = if clips.test.is_empty() {
        ("training clips", &clips.training)
    } else {
        ("test clips, never trained on", &clips.test)
    };
    let errors = judged.iter().map(|clip| SplinedClip::encode(&model, clip)?.errors(&model));
    let mut errors = errors.collect::<Result<Vec<_>, _>>()?;
    errors.sort_by(|a, b| b.joints_deg.total_cmp(&a.joints_deg));
    let value = json!({
        "run": folder, "model": path, "iterations": trainer.iteration(), "parameters": trainer.parameters(),
        "training_clips": clips.training.len(), "training_windows": windows, "judged_on": of, "clips": errors,
        "mean": mean(&errors), "test_windows": windows_of_test,
    });
    crate::output::write_json(&folder.join("reconstruction.json"), &value)?;
    output.result(&value, || {
        format!(
            "{} of {total} iterations, {} parameters, {} clips with {windows} windows; from control points alone, {} {of}:\n\n{}\n{}model: {}\nnext:  {}\n",
            trainer.iteration(),
            trainer.parameters(),
            clips.training.len(),
            errors.len(),
            text_of(&errors),
            beside_plain(&windows_of_test),
            path.display(),
            NextCommand::new("motion edit")
                .word(clip.display())
                .path("--spline", &path)
                .robot(&robot_name)
                .word("--gain")
                .word("1.5")
                .path("-o", &folder.join("edited"))
                .word("--look")
        )
    })?;
    if summary.interrupted {
        let next = NextCommand::new("train spline").word("--resume").path("-o", &folder);
        return Err(CliError::Interrupted(format!("go on with {next}")));
    }
    Ok(())
}

/// No clip may be both trained on and tested on.
fn apart(clips: &SplitClips) -> Result<(), CliError> {
    for (what, aside) in [("validation", &clips.validation), ("test", &clips.test)] {
        if let Some(both) = aside.iter().find(|clip| clips.training.iter().any(|own| own.name == clip.name)) {
            return Err(CliError::Input(format!("{what}: clip '{}' is also among the clips to train on", both.name)));
        }
    }
    Ok(())
}

/// Root mean square over all frames.
fn mean(errors: &[ClipErrors]) -> ClipErrors {
    let frames: usize = errors.iter().map(|e| e.frames).sum();
    let rms = |of: fn(&ClipErrors) -> f64| {
        (errors.iter().map(|e| e.frames as f64 * of(e).powi(2)).sum::<f64>() / frames.max(1) as f64).sqrt()
    };
    ClipErrors {
        clip: "all".into(),
        frames,
        joints_deg: rms(|e| e.joints_deg),
        height_mm: rms(|e| e.height_mm),
        velocity: rms(|e| e.velocity),
    }
}

/// The network beside what the same number of numbers says without one.
fn beside_plain(errors: &[WindowErrors]) -> String {
    if errors.is_empty() {
        return String::new();
    }
    let cells = |e: &WindowErrors| vec![e.name.into(), e.numbers.to_string(), format!("{:.2}", e.joints_deg)];
    let rows: Vec<Vec<String>> = errors.iter().map(cells).collect();
    format!("windows of the test clips, end to end:\n\n{}\n", table(&["kept as", "numbers", "joints (deg)"], &rows))
}

fn text_of(errors: &[ClipErrors]) -> String {
    // The worst are what one has to know.
    const SHOWN: usize = 8;
    let cells = |e: &ClipErrors| {
        vec![
            e.clip.clone(),
            e.frames.to_string(),
            format!("{:.2}", e.joints_deg),
            format!("{:.1}", e.height_mm),
            format!("{:.3}", e.velocity),
        ]
    };
    let mut rows = vec![cells(&mean(errors))];
    rows.extend(errors.iter().take(SHOWN).map(cells));
    table(&["clip", "frames", "joints (deg)", "height (mm)", "velocity (m/s)"], &rows)
}
