//! `lifelike train tracker`: a policy that follows motion in physics.

use std::path::Path;
use std::sync::Arc;

use lifelike_report::run::RunFolder;
use lifelike_robot::{Controller, ControllerFile, ReferenceLibrary, Robot};
use lifelike_tracking::trainer::Beginning;
use lifelike_tracking::{TrackerMetrics, TrackerPlan, Trainer};
use lifelike_train::Summary;
use lifelike_train::collective::Collective;
use serde_json::json;

use super::driver::Driver;
use super::keys;
use super::processes;
use super::source::Source;
use super::stall::Stall;
use super::watch::Look;
use crate::commands::clips;
use crate::commands::export;
use crate::commands::machine::memory;
use crate::commands::physics;
use crate::commands::physics::Physics;
use crate::commands::prior_file::Prior;
use crate::error::CliError;
use crate::next::NextCommand;
use crate::output::Output;

/// Seconds of standing in the default pose, where a plan names no clips.
const STANDING_SECONDS: f64 = 4.0;

/// Train a policy that follows motion in physics, by PPO.
///
/// The run is a folder: plan.toml, metrics.jsonl, TensorBoard events, checkpoints, and at the end
/// tracker.controller.safetensors. Ctrl-C saves and stops; --resume goes on as if nothing had happened.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  # our own clips: needs no data
  lifelike train tracker --plan track -o runs/first budget.minutes=5
  lifelike train tracker --plan track -o runs/first --watch   # with a page that shows how it goes
  lifelike train tracker --plan track -o runs/mine --robot MY_ROBOT.xml 'clips=[\"data/mine\"]'
  lifelike train tracker --plan my.toml -o runs/other seed=2 ppo.environments=512
  lifelike train tracker --resume -o runs/first budget.minutes=20
  lifelike train tracker --keys                 # every key: default, unit, range, meaning
  lifelike train tracker --schema > tracker.schema.json       # the same for editors
  tensorboard --logdir runs                     # curves, while it runs

`lifelike plans` lists built-in plans. A plan's relative paths are looked for in its folder, in the one above, and where you
are. Clips are files, folders, patterns, @list.txt, or builtin: the program's own keyframed clips.")]
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
    if keys::describe::<TrackerPlan>(&args.source, output)? {
        return Ok(());
    }
    let folder = args.source.folder()?;
    let plan: TrackerPlan = args.source.changeable(&folder)?;
    let Some(summary) = train(&plan, &folder, &args.source, &args.physics, output)? else { return Ok(()) };
    report(&summary, &plan, &folder, output)?;
    if summary.interrupted {
        let next = NextCommand::new("train tracker").word("--resume").path("-o", &folder);
        return Err(CliError::Interrupted(format!("go on with {next}")));
    }
    Ok(())
}

/// Trains by a plan in a run's folder, from its beginning or from its latest checkpoint.
/// Returns nothing after a dry run, and from all processes but the first.
pub fn train(
    plan: &TrackerPlan,
    folder: &Path,
    source: &Source,
    physics: &Physics,
    output: &Output,
) -> Result<Option<Summary<TrackerMetrics>>, CliError> {
    let all = processes::all()?;
    let done = train_distributed(plan, folder, source, physics, output, &all);
    if let (Err(error), true) = (&done, all.size() > 1) {
        tracing::error!("process {} of {}: {error}", all.rank() + 1, all.size());
        all.abort();
    }
    done
}

fn train_distributed(
    plan: &TrackerPlan,
    folder: &Path,
    source: &Source,
    physics: &Physics,
    output: &Output,
    all: &Arc<dyn Collective>,
) -> Result<Option<Summary<TrackerMetrics>>, CliError> {
    if source.dry_run && all.size() > 1 {
        return Err(CliError::Usage(format!("--dry-run: expected one process, got {}", all.size())));
    }
    let mut trainer = prepare(plan, physics, Arc::clone(all))?;
    if let Some(init) = plan.init.as_deref().filter(|_| !source.resume) {
        let beginning;
        (trainer, beginning) = trainer.initialised(init)?;
        tell_beginning(init, &beginning);
    }
    // The first process makes the folder; the others wait for it.
    let first = all.rank() == 0;
    let created = (first && !source.resume).then(|| source.run(folder, plan));
    if all.any(matches!(created, Some(Err(_)))) && !first {
        return Err(CliError::Failed("the first process could not make the run's folder".into()));
    }
    let run = created.unwrap_or_else(|| Ok(RunFolder::open(folder)?.into()))?;
    let look = (source.watch && first).then(|| look(plan, folder, physics)).transpose()?;
    let driver = Driver { collective: all.as_ref(), look: look.as_ref(), ..Driver::of(source, &run, output) };
    let mut stall = Stall::default();
    let summary = driver.train(&mut trainer, |now| {
        let metrics = now.metrics;
        if let Some(warning) = stall.note(now.done, metrics.survival).filter(|_| first) {
            tracing::warn!("{warning}");
        }
        format!(
            "survival {:.0}%  {:.0} steps/s  reward {:.2}  episode {:.1} s  iteration {}",
            100.0 * metrics.survival,
            metrics.steps_per_second,
            metrics.ppo.reward,
            metrics.episode_seconds,
            now.iteration
        )
    })?;
    Ok(summary.filter(|_| first))
}

/// Clips and physics by which the policy is seen at each checkpoint.
fn look<'a>(plan: &'a TrackerPlan, folder: &Path, physics: &'a Physics) -> Result<Look<'a>, CliError> {
    let robot = Arc::new(Robot::load(&plan.robot)?);
    let clips = if plan.clips.is_empty() { clips::builtin(&robot) } else { clips::load(&plan.clips, &robot)? };
    Ok(Look::new(Trainer::policy_path(folder), plan.prior.as_deref(), robot, clips, physics))
}

/// Says what of another training this one begins with.
fn tell_beginning(path: &Path, beginning: &Beginning) {
    let value = if beginning.value_function { " and the value function" } else { " (the value function is fresh)" };
    let new = match beginning.new_parts.as_slice() {
        [] => String::new(),
        parts => format!("; new to it: {}", parts.join(", ")),
    };
    tracing::info!("begins with the policy{value} of {}{new}", path.display());
}

/// Says what the plan's numbers are multiplied with for another robot than they were chosen for.
fn tell_scale(plan: &TrackerPlan, robot: &Robot) {
    let factors = plan.scaling.factors(robot);
    if factors.are_one() {
        return;
    }
    tracing::info!(
        "numbers of the plan go with the size of '{}': lengths x{:.2}, times x{:.2}, forces x{:.2}, sums over joints x{:.2}",
        robot.name,
        factors.length,
        factors.length.sqrt(),
        factors.force,
        factors.joints
    );
}

/// Everything that a plan names, ready to learn.
pub fn prepare(plan: &TrackerPlan, physics: &Physics, all: Arc<dyn Collective>) -> Result<Trainer, CliError> {
    plan.check()?;
    physics::available(&physics.engine)?;
    let robot = Arc::new(Robot::load(&plan.robot)?);
    physics.require_ready(&robot)?;
    if let Some([_, total]) = memory() {
        require_memory(plan, &robot, total)?;
    }
    tell_scale(plan, &robot);
    let prior = plan.prior.as_deref().map(|path| Prior::load_for(path, &robot)).transpose()?;
    let library = if plan.clips.is_empty() {
        ReferenceLibrary::standing(&robot, STANDING_SECONDS)?
    } else {
        let mut clips = clips::load(&plan.clips, &robot)?;
        if plan.mirror {
            clips = clips::with_mirror_images(clips, &robot)?;
        }
        ReferenceLibrary::new(&robot, &clips, prior.as_ref().map(Prior::as_encode))?
    };
    let teachers = plan.teachers.iter().map(|teacher| load_teacher(&teacher.policy, &robot));
    let teachers = teachers.collect::<Result<Vec<_>, _>>()?;
    let terrain = plan.terrain.map(|terrain| terrain.build()).transpose()?.map(Arc::new);
    let simulation = physics.simulate(terrain, &robot, plan.ppo.environments)?;
    let trainer = Trainer::distributed(plan, robot, Arc::new(library), simulation, all)?;
    let trainer = match &prior {
        Some(prior) => trainer.with_prior(prior.digest(), prior.encoder()),
        None => trainer,
    };
    Ok(trainer.taught_by(teachers)?)
}

/// Refuses a plan whose samples of one iteration do not fit into the memory of a machine (bytes).
fn require_memory(plan: &TrackerPlan, robot: &Robot, total: u64) -> Result<(), CliError> {
    // A sample has at least the motion's features, as the policy and as the value function sees them, and three numbers a joint.
    let numbers = 2 * robot.layout.size() + 3 * robot.joints();
    let (environments, steps) = (plan.ppo.environments, plan.ppo.steps);
    let needed = 4.0 * environments as f64 * steps as f64 * numbers as f64;
    if needed <= total as f64 {
        return Ok(());
    }
    Err(CliError::Input(format!(
        "ppo.environments x ppo.steps: {environments} x {steps} samples of at least {numbers} numbers need {:.0} GB, this machine \
         has {:.0} GB",
        needed / 1e9,
        total as f64 / 1e9
    )))
}

/// Reads a teacher from its file, or from the folder of its run.
fn load_teacher(path: &Path, robot: &Arc<Robot>) -> Result<Controller, CliError> {
    // A teacher with latent codes gets those of the plan's prior, from the library.
    let file = ControllerFile::read(&export::Source::of(path)?.policy)?;
    Ok(Controller::new(file, Arc::clone(robot))?)
}

/// The command that evaluates a plan's policy on its own clips.
fn evaluation_of(plan: &TrackerPlan, policy: &Path, folder: &Path) -> NextCommand {
    let eval = NextCommand::new("eval").path("--policy", policy).robot(&plan.robot);
    eval.motions(&plan.clips).path("-o", &folder.join("evaluation"))
}

fn report(
    summary: &Summary<TrackerMetrics>,
    plan: &TrackerPlan,
    folder: &Path,
    output: &Output,
) -> Result<(), CliError> {
    let policy = Trainer::policy_path(folder);
    let last = summary.metrics;
    let value = json!({
        "run": folder, "policy": policy, "interrupted": summary.interrupted,
        "next": evaluation_of(plan, &policy, folder).to_string(),
        "iterations": last.map(|_| summary.iteration), "steps": last.map(|_| summary.done),
        "seconds": last.map(|_| summary.seconds), "survival": last.map(|m| m.survival),
        "reward": last.map(|m| m.ppo.reward), "steps_per_second": last.map(|m| m.steps_per_second),
    });
    output.result(&value, || {
        let mut text = String::new();
        if let Some(metrics) = last {
            text += &format!(
                "{} iterations, {} steps in {:.1} min; survival in training {:.0}%, reward {:.3} per step\n",
                summary.iteration,
                summary.done,
                summary.seconds / 60.0,
                100.0 * metrics.survival,
                metrics.ppo.reward
            );
        }
        text + &format!(
            "policy: {}\ncurves: {}\nnext:   {}\n",
            policy.display(),
            folder.join("report.html").display(),
            evaluation_of(plan, &policy, folder)
        )
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn a_plan_that_no_memory_holds_is_refused_with_its_product() {
        let robot = Robot::load("lima").unwrap();
        let mut plan: TrackerPlan = crate::plans::load(Path::new("track"), &[]).unwrap();
        assert!(require_memory(&plan, &robot, 1 << 30).is_ok());
        (plan.ppo.environments, plan.ppo.steps) = (1 << 20, 4096);
        let error = require_memory(&plan, &robot, 24 << 30).unwrap_err().to_string();
        assert!(error.contains("1048576 x 4096") && error.ends_with("has 26 GB"), "{error}");
    }
}
