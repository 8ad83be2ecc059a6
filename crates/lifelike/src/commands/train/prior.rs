//! `lifelike train prior`: a latent code for the second of motion around every frame.

use std::path::Path;

use lifelike_motion::MotionClip;
use lifelike_representation::prior::{
    PriorData, PriorTraining, PriorTrainingPlan, ReconstructionReport, WithTrainer, split,
};
use lifelike_representation::{MotionPrior, PriorClip};
use lifelike_robot::Robot;
use serde_json::json;

use super::driver::Driver;
use super::keys;
use super::source::Source;
use crate::commands::reconstruction::{self, HEAD, row};
use crate::commands::{clips, prior_file};
use crate::error::CliError;
use crate::next::NextCommand;
use crate::output::{Output, table};

/// Train a motion prior: a code z_t for the second of motion around every frame.
///
/// The plan's table selects the encoder. The table prior is the convolutional beta-VAE of thesis 4.2.1. The table
/// spline is the Spline-based Transformer of chapter 3 on the same windows; its latent control points are the code. The
/// table pca is principal components, the plain baseline. Every command that takes a motion.prior.safetensors takes all
/// three.
///
/// The run is a folder: plan.toml, metrics.jsonl, TensorBoard events, checkpoints, motion.prior.safetensors and
/// reconstruction.json. Ctrl-C saves and stops; --resume continues with the same results as an uninterrupted run.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  lifelike train prior --plan prior                             # our own clips: needs no data
  lifelike train prior --plan prior -o runs/small prior.channels=32 prior.iterations=1000
  lifelike train prior --plan prior -o runs/mine --robot MY_ROBOT.xml 'clips=[\"data/mine\"]'
  lifelike train prior --plan prior-spline 'clips=[\"data/lima\"]'
  lifelike train prior --plan my-spline.toml -o runs/wide spline.training.width=128 \\
      spline.training.heads=8
  lifelike train prior -o runs/small --resume

A plan names robot and clips. mirror = true adds mirror images. validation = [...] names clips that only measure the
reconstruction, instead of the share held_out. [prior] has the changes to the thesis' settings. Under [spline] instead:
[spline.windows] selects windows (seed, frame_rate, half_width, window_seconds, held_out, floors, as under [prior]), and
[spline.training] the network and its training (latent: numbers of each of the 4 control points; layers, heads, width, batch,
iterations, optimizer, learning_rate, ...). `lifelike inspect motion.prior.safetensors --json` shows all keys of a trained one.")]
pub struct Args {
    /// Plan and folder.
    #[command(flatten)]
    pub source: Source,
}

/// Result of a training.
struct Trained {
    prior: MotionPrior,
    report: ReconstructionReport,
    iterations: u64,
    parameters: usize,
    interrupted: bool,
}

/// The driver of the training, whichever kind of prior it is of.
struct Run<'a>(Driver<'a>);

impl WithTrainer for Run<'_> {
    type Output = Result<Option<Trained>, CliError>;

    /// Trains until the plan is done or Ctrl-C.
    fn run<T: PriorTraining>(self, mut trainer: T) -> Result<Option<Trained>, CliError> {
        let summary = self.0.train(&mut trainer, |now| T::describe(now.metrics))?;
        let Some(summary) = summary else { return Ok(None) };
        let (prior, parameters) = (trainer.prior()?, trainer.parameters());
        let report = prior.reconstruct(trainer.watched())?;
        let (iterations, interrupted) = (summary.iteration, summary.interrupted);
        Ok(Some(Trained { prior, report, iterations, parameters, interrupted }))
    }
}

/// Runs the command.
pub fn run(args: &Args, output: &Output) -> Result<(), CliError> {
    if keys::describe::<PriorTrainingPlan>(&args.source, output)? {
        return Ok(());
    }
    let folder = args.source.folder()?;
    let plan: PriorTrainingPlan = args.source.fixed(&folder)?;
    plan.prior.check()?;
    let robot = Robot::load(&plan.robot)?;
    let windows = plan.prior.windows();
    let all = clips::load(&plan.clips, &robot)?;
    let frames = |clips: &[MotionClip]| prior_file::frames(clips, &robot, windows.frame_rate);
    let aside = if plan.validation.is_empty() { Vec::new() } else { clips::load(&plan.validation, &robot)? };
    let (all, _): (Vec<_>, Vec<_>) = all.into_iter().partition(|clip| aside.iter().all(|a| a.name != clip.name));
    let (mut training, held_out) = match aside.is_empty() {
        true => split(windows, frames(&all)?),
        false => (frames(&all)?, frames(&aside)?),
    };
    if plan.mirror {
        let is_trained_on = |clip: &MotionClip| training.iter().any(|t| t.name == clip.name);
        let own = all.into_iter().filter(is_trained_on).collect();
        training = frames(&clips::with_mirror_images(own, &robot)?)?;
    }
    let names = |clips: &[PriorClip]| clips.iter().map(|c| c.name.clone()).collect::<Vec<_>>();
    let (trained_on, held_out_names) = (names(&training), names(&held_out));
    let run = args.source.run(&folder, &plan)?;
    let data = PriorData { layout: robot.layout.clone(), training, held_out };
    let driver = Run(Driver::of(&args.source, &run, output));
    let Some(done) = plan.prior.train(data, driver)?? else { return Ok(()) };
    let path = folder.join("motion.prior.safetensors");
    done.prior.save(&path)?;
    let value = json!({
        "run": folder, "prior": path, "interrupted": done.interrupted, "iterations": done.iterations,
        "parameters": done.parameters, "trained_on": trained_on, "held_out": held_out_names,
        "reconstruction": reconstruction::value(&done.report),
    });
    crate::output::write_json(&folder.join("reconstruction.json"), &value)?;
    output.result(&value, || {
        format!(
            "{} iterations, {} parameters, {} clips; reconstruction of {} windows of {}:\n\n{}\nprior: {}\nnext:  {}\n",
            done.iterations,
            done.parameters,
            trained_on.len(),
            done.report.windows,
            if held_out_names.is_empty() { "the training clips" } else { "clips never trained on" },
            reconstruction_table(&done.report),
            path.display(),
            tracker_with(&plan, &path, done.prior.latent_size())
        )
    })?;
    if done.interrupted {
        let next = NextCommand::new("train prior").word("--resume").path("-o", &folder);
        return Err(CliError::Interrupted(format!("go on with {next}")));
    }
    Ok(())
}

/// The command that trains a policy which sees the codes of a prior, on the prior's own clips.
fn tracker_with(plan: &PriorTrainingPlan, prior: &Path, latent: usize) -> NextCommand {
    let clips = toml::Value::from(plan.clips.iter().map(|clip| clip.display().to_string()).collect::<Vec<_>>());
    let words = [
        format!("robot={}", plan.robot),
        format!("clips={clips}"),
        format!("prior={}", prior.display()),
        format!("inputs.latent={latent}"),
    ];
    words.into_iter().fold(NextCommand::new("train tracker").word("--plan").word("track"), NextCommand::word)
}

fn reconstruction_table(report: &ReconstructionReport) -> String {
    let all = [row("whole windows", &report.window), row("their centres", &report.centre)];
    let rows: Vec<Vec<String>> = all.into_iter().chain(report.clips.iter().map(|(name, e)| row(name, e))).collect();
    table(&HEAD, &rows)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use lifelike_representation::PriorPlan;
    use lifelike_representation::prior::vae::VaePlan;

    use super::*;
    use crate::overrides;

    #[test]
    fn values_are_changed_where_the_plan_has_them() {
        let plan: PriorTrainingPlan = toml::from_str("robot = \"lima\"\nclips = []").unwrap();
        let change = |text: &str| overrides::apply(plan.clone(), &[text.to_string()]);
        let expected = VaePlan { channels: 8, ..VaePlan::default() };
        assert_eq!(change("prior.channels=8").unwrap().prior, PriorPlan::Vae(expected));
        let other = change("spline.training.width=8").unwrap_err().to_string();
        assert!(
            other.contains("expected one table of [prior] (a beta-VAE), [spline] (a Spline-based Transformer)"),
            "{other}"
        );
    }
}
