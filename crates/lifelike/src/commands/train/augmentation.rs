//! `lifelike train augmentation`: what a simulation of actuators or bodies lacks, learned from traces.

use std::path::PathBuf;

use lifelike_augmentation::training::{AugmentationPlan, AugmentationTrainer};
use serde::{Deserialize, Serialize};
use serde_json::json;

use super::driver::Driver;
use super::keys;
use super::source::Source;
use crate::commands::augment::traces;
use crate::error::CliError;
use crate::next::NextCommand;
use crate::output::Output;

/// Train a State Augmentation Transformer (thesis chapter 2): it corrects the simulated states of a class of building blocks.
///
/// It learns from traces, which have simulated and measured states side by side (`lifelike augment simulate`). The run is a folder:
/// plan.toml, metrics.jsonl, checkpoints, and at the end CLASS.augmentation.safetensors, the best on the validation traces where
/// there are some. Ctrl-C saves and stops.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  lifelike train augmentation --plan augmentation 'traces=[\"traces/fitted\"]' -o runs/xl330
  lifelike train augmentation --plan augmentation 'traces=[\"a\"]' 'validation=[\"b\"]' \\
      augmentation.iterations=500
  lifelike train augmentation -o runs/xl330 --resume
  # is it right?
  lifelike augment report traces/test --augmentation runs/xl330/xl330.augmentation.safetensors")]
pub struct Args {
    /// Plan and folder.
    #[command(flatten)]
    pub source: Source,
}

/// An augmentation's training, as its TOML file has it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AugmentationTrainingPlan {
    /// Traces to learn from: files, or folders of them.
    pub traces: Vec<PathBuf>,
    /// Traces to choose the best weights on.
    #[serde(default)]
    pub validation: Vec<PathBuf>,
    /// Network and learning.
    #[serde(default)]
    pub augmentation: AugmentationPlan,
}

/// Runs the command.
pub fn run(args: &Args, output: &Output) -> Result<(), CliError> {
    if keys::describe::<AugmentationTrainingPlan>(&args.source, output)? {
        return Ok(());
    }
    let folder = args.source.folder()?;
    let plan: AugmentationTrainingPlan = args.source.fixed(&folder)?;
    let (learn, validation) = (traces(&plan.traces)?, traces(&plan.validation)?);
    let mut trainer = AugmentationTrainer::new(&plan.augmentation, &learn, &validation)?;
    let run = args.source.run_or_resume(&folder, &plan)?;
    let summary =
        Driver::of(&args.source, &run, output).train(&mut trainer, |now| format!("loss {:.4}", now.metrics.loss))?;
    let Some(summary) = summary else { return Ok(()) };
    let path = trainer.path(&folder);
    let [blocks, validated] = trainer.blocks();
    let value = json!({
        "run": folder, "augmentation": path, "iterations": summary.iteration, "parameters": trainer.parameters(),
        "blocks": blocks, "validation_blocks": validated, "seconds": summary.seconds, "interrupted": summary.interrupted,
    });
    output.result(&value, || {
        format!(
            "{} iterations on {blocks} blocks of class '{}', {} parameters, {:.1} min\naugmentation: {}\nnext: {}\n",
            summary.iteration,
            trainer.inputs().class,
            trainer.parameters(),
            summary.seconds / 60.0,
            path.display(),
            NextCommand::new("augment report").word("TRACES").path("--augmentation", &path)
        )
    })?;
    if summary.interrupted {
        let next = NextCommand::new("train augmentation").word("--resume").path("-o", &folder);
        return Err(CliError::Interrupted(format!("go on with {next}")));
    }
    Ok(())
}
