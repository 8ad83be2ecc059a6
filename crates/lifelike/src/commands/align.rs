//! `lifelike align`: a generator brought closer to what a policy can execute (thesis 5.2.2).

use std::path::{Path, PathBuf};

use lifelike_generation::align::{AlignMarks, AlignPlan, AlignTrainer, PhysicsJudge};
use lifelike_generation::critic::Critic;
use lifelike_generation::data::CaptionedMotion;
use lifelike_generation::generator::{FILE, Generator};
use lifelike_robot::Robot;
use lifelike_train::TrainingTask;
use serde_json::json;

use crate::commands::controller_file::Loaded;
use crate::commands::eval::Job;
use crate::commands::judge::Judge;
use crate::commands::physics::{self, Physics};
use crate::commands::train::driver::Driver;
use crate::commands::train::keys;
use crate::commands::train::source::Source;
use crate::error::CliError;
use crate::next::NextCommand;
use crate::output::Output;
use crate::shipped::{self, Kind};

/// The built-in plan that is taken where none is named.
const PLAN: &str = "align";

/// Align a generator with a critic: fine-tune it so that what it makes is motion that the critic's policy can execute.
///
/// The loss is the generator's own minus beta times the critic's values (RobotMDM). At every validation, the plan's
/// policy executes motion of validation sentences in physics. The weights with the fewest falls and the smallest errors
/// of thesis Table 5.3 are kept. The run stops when the generator's own validation loss rises beyond the plan's
/// tolerance. Without a policy, the critic's mean value (Realism) selects the weights, which an alignment can exploit.
/// Ctrl-C saves; --resume continues.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  lifelike align --generator runs/generator/motion.generator.safetensors \\
      --critic runs/critic/motion.critic.safetensors \\
      'clips=[\"data/grammar\"]' -o runs/aligned
  lifelike align --resume -o runs/aligned")]
pub struct Args {
    /// The generator to begin with; the plan's where not given.
    #[arg(long)]
    pub generator: Option<PathBuf>,
    /// The critic, frozen; the plan's where not given.
    #[arg(long)]
    pub critic: Option<PathBuf>,
    /// The policy that chooses the weights in physics (controller, policy or run); the plan's where not given.
    #[arg(long)]
    pub policy: Option<PathBuf>,
    /// Plan and folder.
    #[command(flatten)]
    pub source: Source,
    /// Engine and threads.
    #[command(flatten)]
    pub physics: Physics,
}

/// Runs the command.
pub fn run(args: &Args, output: &Output) -> Result<(), CliError> {
    if keys::describe::<AlignPlan>(&args.source, output)? {
        return Ok(());
    }
    let mut source = args.source.clone();
    if !source.resume {
        source.plan.get_or_insert_with(|| PLAN.into());
        for (key, path) in [("generator", &args.generator), ("critic", &args.critic), ("policy", &args.policy)] {
            source.overrides.extend(path.iter().map(|path| format!("{key}={}", path.display())));
        }
    }
    let folder = source.folder()?;
    let plan: AlignPlan = source.fixed(&folder)?;
    let robot = Robot::load(&plan.robot)?;
    let generator = Generator::load(&shipped::file(&plan.generator, Kind::Generator)?)?;
    let critic = Critic::load(&shipped::file(&plan.critic, Kind::Critic)?)?;
    let motions = CaptionedMotion::load(&plan.clips, &robot, generator.header().max_seconds)?;
    physics::available(&args.physics.engine)?;
    let loaded = plan.policy.as_deref().map(|policy| Loaded::load(policy, Some(&plan.robot), None)).transpose()?;
    if loaded.is_none() {
        tracing::warn!(
            "no policy judges in physics: the critic chooses the weights, which an alignment can exploit (policy=FILE)"
        );
    }
    let judge = loaded.as_ref().map(|loaded| {
        let job = Job { loaded, physics: &args.physics };
        Box::new(Judge::of(job, &motions, plan.judge, plan.seed)) as Box<dyn PhysicsJudge>
    });
    let mut trainer = AlignTrainer::new(&plan, &robot, generator, critic, &motions, judge)?;
    drop(motions);
    let run = source.run(&folder, &plan)?;
    let summary = Driver::of(&source, &run, output).train(&mut trainer, |now| {
        format!("loss {:.4}  Realism {:.3}", now.metrics.step.loss, now.metrics.realism.unwrap_or(f64::NAN))
    })?;
    let Some(summary) = summary else { return Ok(()) };
    let (path, [before, best]) = (folder.join(FILE), trainer.marks());
    let value = json!({
        "run": folder, "generator": path, "iterations": trainer.iteration(), "stopped_by_guard": trainer.stopped(),
        "loss": [before.loss, best.loss], "realism": [before.realism, best.realism],
        "physics": [before.physics, best.physics], "interrupted": summary.interrupted,
    });
    output.result(&value, || report(&trainer, &path, before, best, &plan.robot))?;
    if summary.interrupted {
        let next = NextCommand::new("align").word("--resume").path("-o", &folder);
        return Err(CliError::Interrupted(format!("go on with {next}")));
    }
    Ok(())
}

fn report(trainer: &AlignTrainer<'_>, path: &Path, before: AlignMarks, best: AlignMarks, robot: &str) -> String {
    let end = if trainer.stopped() { ", ended by the guard" } else { "" };
    format!(
        "{} iterations{end}; the loss is that on motion not trained on\nbefore:    {}\nbest:      {}\ngenerator: {}\nnext:      {}\n",
        trainer.iteration(),
        before.words(),
        best.words(),
        path.display(),
        NextCommand::new("generate")
            .word("a person walks")
            .path("--generator", path)
            .robot(robot)
            .word("-o")
            .word("walk.motion.safetensors")
    )
}
