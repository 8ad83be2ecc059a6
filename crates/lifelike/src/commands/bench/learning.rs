//! `lifelike bench learning`: environment steps per second of a plan, and where the time goes.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

use lifelike_simd::InstructionSet;
use lifelike_tracking::TrackerPlan;
use lifelike_train::collective::Alone;
use serde::Serialize;

use crate::commands::machine::{Machine, peak};
use crate::commands::physics::Physics;
use crate::commands::train;
use crate::error::CliError;
use crate::output::{Output, table};
use crate::plans;

/// Train by a plan for some seconds, and say how fast: environment steps per second, physics and networks apart, and what share
/// of the processor's peak the networks reach.
///
/// Nothing is saved. The networks' operations are counted from their sizes (a multiplication and an addition are two).
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  lifelike bench learning --plan experiments/track-walk.toml
  lifelike bench learning --plan experiments/track-all.toml --seconds 60 ppo.epochs=4 \\
      ppo.minibatch=1536 --json | jq .rate")]
pub struct Args {
    /// The plan: a file, or a built-in one by its name.
    #[arg(long)]
    plan: PathBuf,
    /// Seconds, after a tenth of them that does not count.
    #[arg(long, default_value_t = 20.0)]
    seconds: f64,
    #[command(flatten)]
    physics: Physics,
    /// Changes to the plan, by dotted path.
    #[arg(value_name = "KEY=VALUE")]
    overrides: Vec<String>,
}

#[derive(Debug, Default, Serialize)]
struct Report {
    /// Environment steps per second.
    rate: f64,
    iterations: u64,
    seconds: f64,
    /// Shares of the wall time: environments, the policy's and other work while collecting, gradient steps.
    environments: f64,
    collecting: f64,
    learning: f64,
    /// Operations of the networks per environment step, while collecting and while learning.
    operations_collecting: f64,
    operations_learning: f64,
    /// Operations per second while learning.
    learning_rate: f64,
    /// Reference for the networks.
    peak: Peak,
}

#[derive(Debug, Default, Serialize)]
struct Peak {
    /// Operations per second that one core can do.
    one_core: f64,
    /// Operations per second while learning, all cores together, of what one core can do.
    share_of_one_core: f64,
    machine: Machine,
}

/// Runs the command.
pub fn run(args: &Args, output: &Output) -> Result<(), CliError> {
    if !(args.seconds.is_finite() && args.seconds > 0.0) {
        return Err(CliError::Usage(format!("--seconds: expected a number above 0, got {}", args.seconds)));
    }
    let plan: TrackerPlan = plans::load(&args.plan, &args.overrides)?;
    let mut trainer = train::tracker::prepare(&plan, &args.physics, Arc::new(Alone))?;
    let warm = Instant::now();
    while warm.elapsed().as_secs_f64() < 0.1 * args.seconds {
        trainer.iterate()?;
    }
    let (mut report, began, first) = (Report::default(), Instant::now(), trainer.steps());
    while began.elapsed().as_secs_f64() < args.seconds {
        let iteration = trainer.iterate()?;
        report.iterations += 1;
        report.environments += iteration.stepping;
        report.collecting += iteration.collecting - iteration.stepping;
        report.learning += iteration.learning;
    }
    let seconds = began.elapsed().as_secs_f64();
    let steps = (trainer.steps() - first) as f64;
    let environment = trainer.environment();
    let layers = |inputs: usize, hidden: &[usize], outputs: usize| -> f64 {
        let sizes: Vec<usize> = [inputs].into_iter().chain(hidden.iter().copied()).chain([outputs]).collect();
        sizes.windows(2).map(|pair| (pair[0] * pair[1]) as f64).sum()
    };
    let spec = environment.observation();
    let encoder = plan.network.actor_of(environment).encoder;
    let inputs =
        encoder.as_ref().map_or(environment.actor_size(), |e| environment.actor_size() - e.inputs() + e.outputs());
    let encoding = encoder.map_or(0.0, |encoder| encoder.multiplications() as f64);
    let actor = layers(inputs, &plan.network.actor, spec.joints.len()) + encoding;
    let critic = layers(environment.critic_size(), &plan.network.critic, 1);
    // Forward: one multiplication and one addition for each weight. Backward: the same by weights, and by inputs, but that the
    // first layer's inputs need no gradient; counted as three times forward, which is a little too much.
    report.operations_collecting = 2.0 * (actor + critic);
    let valued = 1.0 + 1.0 / plan.ppo.steps as f64;
    report.operations_learning = 6.0 * (actor + critic) * plan.ppo.epochs as f64 + 2.0 * critic * valued;
    report.rate = steps / seconds;
    report.learning_rate = report.operations_learning * steps / report.learning;
    let one_core = peak::operations(InstructionSet::chosen());
    let share_of_one_core = report.learning_rate / one_core;
    report.peak = Peak { one_core, share_of_one_core, machine: Machine::this() };
    report.seconds = seconds;
    for part in [&mut report.environments, &mut report.collecting, &mut report.learning] {
        *part /= seconds;
    }
    output.result(&report, || text(&report))
}

fn text(r: &Report) -> String {
    let percent = |share: f64| format!("{:.0}%", 100.0 * share);
    let rows = [
        vec!["environments (physics, reward, observation)".into(), percent(r.environments)],
        vec!["policy, noise, storing".into(), percent(r.collecting)],
        vec!["values, advantages, gradient steps".into(), percent(r.learning)],
    ];
    let (Machine { cores, instruction_set, .. }, one) = (&r.peak.machine, r.peak.one_core * 1e-9);
    let share = r.peak.share_of_one_core;
    format!(
        "{:.0} environment steps per second over {:.0} s ({} iterations)\n\n{}\nnetworks: {:.2} million operations a step while collecting, {:.2} while learning\n\
         while learning {:.1} thousand million operations per second, on {cores} cores; one core's peak with {instruction_set} is {one:.1}: {share:.2} of one core\n",
        r.rate,
        r.seconds,
        r.iterations,
        table(&["where the time goes", "share"], &rows),
        r.operations_collecting * 1e-6,
        r.operations_learning * 1e-6,
        r.learning_rate * 1e-9,
    )
}
