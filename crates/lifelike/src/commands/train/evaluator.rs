//! `lifelike train evaluator`: encoders of sentences and motions, by which text to motion is measured.

use lifelike_generation::data::CaptionedMotion;
use lifelike_generation::evaluator::{EvaluatorData, EvaluatorTrainer, EvaluatorTrainingPlan};
use lifelike_generation::metrics::{HEAD, Scores};
use lifelike_generation::representation::RepresentationSpec;
use lifelike_language::{CaptionedSet, Split};
use lifelike_robot::Robot;
use serde_json::{Map, json};

use super::driver::Driver;
use super::keys;
use super::source::Source;
use crate::error::CliError;
use crate::next::NextCommand;
use crate::output::{Output, table};

/// Pools that each number is measured over, as Guo et al. repeat their evaluation.
const REPETITIONS: u64 = 20;

/// Train an evaluator of text to motion: encoders of sentences and motions, near where they belong together.
///
/// R-precision, FID, MM-dist, diversity and multimodality are taken on its embeddings. The run is a folder: plan.toml,
/// metrics.jsonl, checkpoints, and at the end motion.evaluator.safetensors, of the best validation. Ctrl-C saves and stops.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  lifelike train evaluator --plan evaluator dataset=data/captioned/lima
  lifelike train evaluator --plan evaluator -o runs/small dataset=DATA evaluator.channels=32 \\
      evaluator.iterations=500
  lifelike train evaluator -o runs/small --resume

A plan names a robot and the folder of its captioned clips (dataset.jsonl and *.motion.safetensors), and under [evaluator]
whatever differs from the defaults. The table at the end is of clips never trained on: what real motion reaches, and so what
generated motion is measured against.")]
pub struct Args {
    /// Plan and folder.
    #[command(flatten)]
    pub source: Source,
}

/// Runs the command.
pub fn run(args: &Args, output: &Output) -> Result<(), CliError> {
    if keys::describe::<EvaluatorTrainingPlan>(&args.source, output)? {
        return Ok(());
    }
    let folder = args.source.folder()?;
    let plan: EvaluatorTrainingPlan = args.source.fixed(&folder)?;
    plan.evaluator.check()?;
    let robot = Robot::load(&plan.robot)?;
    let spec = RepresentationSpec::of(&robot.layout);
    let set = CaptionedSet::read(&plan.dataset)?;
    let data = EvaluatorData::read(&set, &spec)?;
    let motions = data.training.len();
    let run = args.source.run_or_resume(&folder, &plan)?;
    let seed = plan.evaluator.seed;
    let mut trainer = EvaluatorTrainer::new(plan.evaluator, spec.clone(), data)?;
    let summary =
        Driver::of(&args.source, &run, output).train(&mut trainer, |now| format!("loss {:.3}", now.metrics.loss))?;
    let Some(summary) = summary else { return Ok(()) };
    let evaluator = trainer.evaluator();
    let mut scores: Vec<(&str, Scores)> = Vec::new();
    for split in Split::ALL {
        let items = CaptionedMotion::read(&set, set.of(split), &spec)?;
        scores.extend(evaluator.scores(&items, REPETITIONS, seed)?.map(|found| (split.name(), found)));
    }
    let path = folder.join("motion.evaluator.safetensors");
    let splits: Map<String, serde_json::Value> =
        scores.iter().map(|(name, found)| ((*name).to_string(), json!(found))).collect();
    let value = json!({
        "run": folder, "evaluator": path, "iterations": summary.iteration, "parameters": trainer.parameters(),
        "training_motions": motions, "scores": splits,
    });
    let file = folder.join("scores.json");
    crate::output::write_json(&file, &value)?;
    output.result(&value, || {
        format!(
            "{} iterations, {} parameters, {motions} motions; real motion under its own sentences:\n\n{}\nevaluator: {}\n",
            summary.iteration,
            trainer.parameters(),
            text_of(&scores),
            path.display()
        )
    })?;
    if summary.interrupted {
        let next = NextCommand::new("train evaluator").word("--resume").path("-o", &folder);
        return Err(CliError::Interrupted(format!("go on with {next}")));
    }
    Ok(())
}

fn text_of(scores: &[(&str, Scores)]) -> String {
    let cells = |(split, found): &(&str, Scores)| {
        let first = [(*split).to_string(), found.motions.to_string(), found.pool.to_string()];
        first.into_iter().chain(found.cells()).collect::<Vec<_>>()
    };
    let head: Vec<&str> = ["split", "motions", "pool"].into_iter().chain(HEAD).collect();
    table(&head, &scores.iter().map(cells).collect::<Vec<_>>())
}
