//! `lifelike train generator`: text to motion of a robot (thesis chapter 5).

use lifelike_generation::data::CaptionedMotion;
use lifelike_generation::generator::FILE;
use lifelike_generation::training::{GeneratorPlan, GeneratorTrainer, TrainingData};
use lifelike_robot::Robot;
use serde_json::json;

use super::driver::Driver;
use super::keys;
use super::source::Source;
use crate::error::CliError;
use crate::next::NextCommand;
use crate::output::Output;

/// Train a generator of motion from text (thesis chapter 5): a diffusion model over captioned motion of a robot.
///
/// The plan names robot, captioned motion, the space of the network's tokens (rows at 20 Hz, or control points of
/// splines) and sizes. The run is a folder: plan.toml, metrics.jsonl, checkpoints, and at the end
/// motion.generator.safetensors for `lifelike generate`. Ctrl-C saves and stops; --resume goes on as if nothing had
/// happened.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  # a folder with a dataset.jsonl
  lifelike train generator --plan generator 'clips=[\"data/grammar\"]'
  lifelike train generator --plan generator -o runs/small width=64 layers=2 minutes=10
  lifelike train generator -o runs/small --resume

Clips without a dataset.jsonl are captioned by their own container, or by their name.")]
pub struct Args {
    /// Plan and folder.
    #[command(flatten)]
    pub source: Source,
}

/// Runs the command.
pub fn run(args: &Args, output: &Output) -> Result<(), CliError> {
    if keys::describe::<GeneratorPlan>(&args.source, output)? {
        return Ok(());
    }
    let folder = args.source.folder()?;
    let plan: GeneratorPlan = args.source.fixed(&folder)?;
    plan.check()?;
    let robot = Robot::load(&plan.robot)?;
    let motions = CaptionedMotion::load(&plan.clips, &robot, plan.max_seconds)?;
    let data = TrainingData::new(&plan, &robot, &motions)?;
    drop(motions);
    let run = args.source.run(&folder, &plan)?;
    let mut trainer = GeneratorTrainer::new(plan, &robot, data)?;
    let summary = Driver::of(&args.source, &run, output)
        .train(&mut trainer, |now| format!("loss {:.4}", now.metrics.step.loss))?;
    let Some(summary) = summary else { return Ok(()) };
    let path = folder.join(FILE);
    let validation = trainer.validation_loss()?;
    let value = json!({
        "run": folder, "generator": path, "iterations": trainer.iteration(), "parameters": trainer.parameters(),
        "data": trainer.data().describe(), "validation_loss": validation, "interrupted": summary.interrupted,
    });
    output.result(&value, || {
        format!(
            "{} iterations, {} parameters, {}\n\
             loss:      {validation:.4} (variances, on what is not trained on where there is some)\n\
             generator: {}\nnext:      {}\n",
            trainer.iteration(),
            trainer.parameters(),
            trainer.data().describe(),
            path.display(),
            NextCommand::new("generate")
                .word("a person waves with the right hand")
                .path("--generator", &path)
                .robot(&robot.name)
                .word("-o")
                .word("wave.motion.safetensors")
        )
    })?;
    if summary.interrupted {
        let next = NextCommand::new("train generator").word("--resume").path("-o", &folder);
        return Err(CliError::Interrupted(format!("go on with {next}")));
    }
    Ok(())
}
