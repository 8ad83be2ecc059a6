//! `lifelike train get-up`: keyframes by which a robot gets up.

use std::sync::Arc;

use lifelike_robot::Robot;
use lifelike_tracking::get_up::{FILE, GetUpPlan, GetUpSearch};
use serde_json::json;

use super::driver::Driver;
use super::keys;
use super::source::Source;
use crate::commands::script;
use crate::error::CliError;
use crate::next::NextCommand;
use crate::output::Output;

/// Search the keyframes of a get-up script by the cross-entropy method, on the nominal robot and on twins at once.
///
/// The search begins around a script, and keeps how that one lies down. Poses and times of its other stages are drawn, tried in
/// physics and drawn again around the best. The run is a folder: plan.toml, metrics.jsonl, checkpoints, and get-up.toml, the
/// script of the present means. Ctrl-C saves and stops.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  lifelike train get-up --plan get-up -o runs/get-up
  lifelike train get-up --plan get-up -o runs/g1 --robot g1 script=g1.get-up.toml
  lifelike train get-up -o runs/get-up --resume
  # how often does it work, on a twin that it was not searched on?
  lifelike bench get-up --policy lima-blind --script runs/get-up/get-up.toml --twin 1 -o out")]
pub struct Args {
    /// Plan and folder.
    #[command(flatten)]
    pub source: Source,
    /// Threads of the physics; one per processor where not given. Results do not depend on it.
    #[arg(long, default_value_t = 0, value_parser = crate::bounds::threads)]
    pub threads: usize,
}

/// Runs the command.
///
/// # Errors
/// Plan or script are wrong, the robot cannot be simulated, or a file cannot be written.
pub fn run(args: &Args, output: &Output) -> Result<(), CliError> {
    if keys::describe::<GetUpPlan>(&args.source, output)? {
        return Ok(());
    }
    let folder = args.source.folder()?;
    let plan: GetUpPlan = args.source.fixed(&folder)?;
    let robot = Arc::new(Robot::load(&plan.robot)?);
    let mut search = GetUpSearch::new(&plan, &robot, script::read(&plan.script)?, args.threads)?;
    let run = args.source.run_or_resume(&folder, &plan)?;
    let summary = Driver::of(&args.source, &run, output).train(&mut search, |now| {
        let [roll, rise] = now.metrics.success().map(|share| format!("{:.0}%", 100.0 * share));
        format!("worst robot: roll {roll}, rise {rise}")
    })?;
    let Some(summary) = summary else { return Ok(()) };
    let path = folder.join(FILE);
    let value = json!({ "run": folder, "script": path, "iterations": summary.iteration, "seconds": summary.seconds,
        "interrupted": summary.interrupted });
    output.result(&value, || {
        let minutes = summary.seconds / 60.0;
        format!("{} iterations, {minutes:.1} min\nscript: {}\n", summary.iteration, path.display())
    })?;
    if summary.interrupted {
        let next = NextCommand::new("train get-up").word("--resume").path("-o", &folder);
        return Err(CliError::Interrupted(format!("go on with {next}")));
    }
    Ok(())
}
