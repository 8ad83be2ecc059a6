//! `lifelike cotrain`: generator, tracker and critic improve each other (thesis 5.3.3).

mod measure;
pub(crate) mod plan;
mod progress;
mod stages;

use std::path::Path;

use serde_json::json;

use self::plan::CotrainPlan;
use self::progress::Done;
use self::stages::Stages;
use crate::commands::physics::Physics;
use crate::commands::train::keys;
use crate::commands::train::source::Source;
use crate::error::CliError;
use crate::next::NextCommand;
use crate::output::Output;

/// The built-in plan that is taken where none is named.
const PLAN: &str = "cotrain";

/// The best generator in a run's folder.
const BEST: &str = "best.generator.safetensors";

/// Let generator, tracker and critic improve each other, round after round.
///
/// Each round has four stages. The generator makes motion of sentences. The tracker continues to learn from it and from
/// its own clips. A critic is trained on the new tracker. The generator is aligned with the new critic.
///
/// A plan without the table tracker keeps the tracker as it is. A critic that learned from generated motion is harder to
/// exploit. Every tracker then executes the motion of every generator on sentences of another split. The round with the
/// fewest falls and the smallest errors is the result. The run's folder has a folder for each stage of each round.
/// Ctrl-C saves, and --resume continues in the middle of a stage.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  lifelike cotrain 'dataset=data/lima/grammar' 'clips=[\"data/lima/keys\"]' -o runs/cotrain
  lifelike cotrain --plan my.toml rounds=3 'tracker.keys=[\"budget.minutes=60\"]' -o runs/cotrain
  lifelike cotrain --resume -o runs/cotrain
  lifelike plans cotrain                                          # the plan, to copy")]
pub struct Args {
    /// Plan and folder.
    #[command(flatten)]
    pub source: Source,
    /// Engine, threads, and where networks learn.
    #[command(flatten)]
    pub physics: Physics,
}

/// Runs the command.
pub fn run(args: &Args, output: &Output) -> Result<(), CliError> {
    if keys::describe::<CotrainPlan>(&args.source, output)? {
        return Ok(());
    }
    let mut source = args.source.clone();
    if !source.resume {
        source.plan.get_or_insert_with(|| PLAN.into());
    }
    let folder = source.folder()?;
    let plan: CotrainPlan = source.fixed(&folder)?;
    plan.check()?;
    let run = source.run(&folder, &plan)?;
    if run.is_rehearsal() {
        return rehearse(&plan, output);
    }
    let mut stages =
        Stages { plan: &plan, folder: &folder, physics: &args.physics, output, done: Done::read(&folder)? };
    stages.all().map_err(|error| in_loop(error, &folder))?;
    let rows = &stages.done.measured;
    let (last, best) = (plan.rounds, stages.best());
    let generator = folder.join(BEST);
    std::fs::copy(stages.generator(best), &generator).map_err(CliError::write(&generator))?;
    let value = json!({ "run": folder, "rounds": last, "best_round": best, "generator": generator, "measured": rows });
    output.result(&value, || {
        let (tracker, critic) = (stages.policy(last), stages.critic(last));
        format!(
            "{}\nbest:      round {best}, by physics on the split {}\ngenerator: {}\ntracker:   {}\ncritic:    {}\n",
            crate::output::fitted(&measure::table(rows)),
            plan.judge.split.name(),
            generator.display(),
            tracker.display(),
            critic.display()
        )
    })
}

/// Prints the resolved plan of a dry run. Its stages are trainings of their own, of which each is timed by its own command.
fn rehearse(plan: &CotrainPlan, output: &Output) -> Result<(), CliError> {
    let text = toml::to_string_pretty(plan).map_err(|e| CliError::Failed(e.to_string()))?;
    let value = json!({ "plan": text, "rounds": plan.rounds });
    output.result(&value, || {
        format!(
            "{text}\nrounds:  {}, each of several trainings; --dry-run of `train tracker`, `train critic` and `align` times them\n\
             Nothing was written. Run the same without --dry-run to train.\n",
            plan.rounds
        )
    })
}

/// An interrupted stage goes on by this command, not by its own.
fn in_loop(error: CliError, folder: &Path) -> CliError {
    match error {
        CliError::Interrupted(_) => {
            let next = NextCommand::new("cotrain").word("--resume").path("-o", folder);
            CliError::Interrupted(format!("go on with {next}"))
        }
        other => other,
    }
}
