//! `lifelike train critic`: the reward that a policy will get for a motion, from the motion alone.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::time::Instant;

use lifelike_checkpoint::Checkpoint;
use lifelike_generation::critic::{CriticData, CriticMetrics, CriticPlan, CriticTrainer, RewardRecords, StepEnd};
use lifelike_motion::MotionClip;
use lifelike_report::run::RunFolder;
use lifelike_robot::Robot;
use lifelike_tracking::TrackerPlan;
use lifelike_tracking::plan::EpisodeSpec;
use lifelike_train::plan;
use serde::{Deserialize, Serialize};
use serde_json::json;

use super::driver::Driver;
use super::keys;
use super::source::Source;
use crate::commands::clips;
use crate::commands::controller_file::Loaded;
use crate::commands::generated;
use crate::commands::physics::Physics;
use crate::commands::rollouts::{Rollouts, digest_of, environment_of, rows_of};
use crate::error::CliError;
use crate::next::NextCommand;
use crate::output::Output;
use crate::progress::duration;

/// Train the critic of a frozen controller: the discounted reward that a motion promises, differentiable by the motion.
///
/// The controller follows the clips in many disturbed environments (thesis Algorithm 1); a network then learns its rewards by the
/// motion alone. The run is a folder: plan.toml, records.safetensors, metrics.jsonl, checkpoints, report.html, and at the end
/// motion.critic.safetensors.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  lifelike train critic --plan critic -o runs/critic
  lifelike train critic --plan critic --controller mine.controller.safetensors \\
      'clips=[\"data/mine\"]' -o runs/mine
  lifelike train critic --resume -o runs/critic
  # motion that it guides
  lifelike generate \"a person walks\" --critic runs/critic/motion.critic.safetensors \\
      -o walk.motion.safetensors")]
pub struct Args {
    /// Plan and folder.
    #[command(flatten)]
    pub source: Source,
    /// The frozen controller (or policy); the plan's where not given.
    #[arg(long)]
    pub controller: Option<PathBuf>,
    /// Engine and threads.
    #[command(flatten)]
    pub physics: Physics,
}

/// A critic's training, as its TOML file has it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CriticTrainingPlan {
    /// Robot: a built-in name, or an MJCF or URDF file.
    pub robot: String,
    /// Frozen controller that is followed.
    pub controller: PathBuf,
    /// Tracker's plan whose reward, terminations, randomization and pushes hold; none: the controller's own.
    ///
    /// A built-in name, or a file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub environment: Option<PathBuf>,
    /// Folders of generated motion, as `cotrain` writes them.
    ///
    /// They are followed too, and their rows before grounding are learned.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub generated: Vec<PathBuf>,
    /// Clips to follow: files, folders, patterns.
    pub clips: Vec<PathBuf>,
    /// Following of the mirror image of every clip too.
    #[serde(default)]
    pub mirror: bool,
    /// Seed of everything random.
    #[serde(default)]
    #[schemars(extend("unit" = "1"))]
    pub seed: u64,
    /// Amount of experience.
    #[serde(default)]
    pub rollouts: RolloutPlan,
    /// Network and learning.
    #[serde(default)]
    pub critic: CriticPlan,
}

/// Amount of experience.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct RolloutPlan {
    /// Number of environments.
    #[schemars(extend("unit" = "1"), range(min = 1, max = 1u64 << 20))]
    pub environments: usize,
    /// Policy steps of each environment.
    #[schemars(extend("unit" = "policy steps"), range(min = 1, max = 1u64 << 32))]
    pub steps: u64,
    /// Longest episode; a clip that ends before is followed by another (s).
    #[schemars(extend("unit" = "s"), range(min = 0.02, max = 1e5))]
    pub seconds: f64,
    /// Share of the steps on generated motion, where the plan names any.
    #[schemars(extend("unit" = "1"), range(min = 0.0, max = 1.0))]
    pub generated_share: f64,
    /// Share of episodes that begin in the state of another frame (thesis Algorithm 1, line 5).
    #[schemars(extend("unit" = "1"), range(min = 0.0, max = 1.0))]
    pub random_start_share: f64,
}

impl Default for RolloutPlan {
    fn default() -> Self {
        Self { environments: 1024, steps: 20_000, seconds: 20.0, generated_share: 0.5, random_start_share: 0.2 }
    }
}

impl CriticTrainingPlan {
    /// Checks that every value is in its range.
    pub fn check(&self) -> Result<(), CliError> {
        Ok(plan::check("", self)?)
    }

    /// Reads its clips, the generated ones last, and returns the number of the others with them.
    pub fn motions(&self, robot: &Robot) -> Result<(Vec<MotionClip>, usize), CliError> {
        let mut clips = clips::load(&self.clips, robot)?;
        if self.mirror {
            clips = clips::with_mirror_images(clips, robot)?;
        }
        let own = clips.len();
        if !self.generated.is_empty() {
            clips.extend(clips::load(&self.generated, robot)?);
        }
        let mut names = BTreeSet::new();
        match clips.iter().find(|clip| !names.insert(clip.name.as_str())) {
            Some(clip) => Err(CliError::Input(format!(
                "generated: expected names that no clip has, got '{}' in clips too",
                clip.name
            ))),
            None => Ok((clips, own)),
        }
    }

    /// Returns the records of a run.
    pub fn records(folder: &Path) -> Result<RewardRecords, CliError> {
        Ok(RewardRecords::load(&Checkpoint::load(&folder.join(RECORDS))?, KEY)?)
    }
}

/// In a run's folder.
const RECORDS: &str = "records.safetensors";
const KEY: &str = "records";

/// Runs the command.
pub fn run(args: &Args, output: &Output) -> Result<(), CliError> {
    if keys::describe::<CriticTrainingPlan>(&args.source, output)? {
        return Ok(());
    }
    let mut source = args.source.clone();
    if let (Some(path), false) = (&args.controller, source.resume) {
        source.overrides.push(format!("controller={}", path.display()));
    }
    let folder = source.folder()?;
    let plan: CriticTrainingPlan = source.fixed(&folder)?;
    plan.check()?;
    let loaded = Loaded::load(&plan.controller, Some(&plan.robot), None)?;
    let robot = loaded.controller.robot();
    args.physics.require_ready(robot)?;
    let (clips, own) = plan.motions(robot)?;
    let named = plan.environment.as_deref();
    let mut tracker = environment_of(named, &plan.controller, &loaded.controller, &plan.robot, plan.seed)?;
    tracker.rsi.random_start_share = plan.rollouts.random_start_share;
    let run = source.run(&folder, &plan)?;
    if run.is_rehearsal() {
        return rehearse(&plan, &run, &loaded, &tracker, (&clips, own), args, output);
    }
    let records = if folder.join(RECORDS).exists() {
        CriticTrainingPlan::records(&folder)?
    } else {
        record(&plan, &loaded, &tracker, (&clips, own), args, &folder, output)?
    };
    let failures = records.end.iter().filter(|end| **end == StepEnd::Failed).count();
    let (steps, reward) = (records.len(), records.reward.iter().sum::<f32>() / records.len() as f32);
    let (representation, motions) = rows_of(&clips, robot)?;
    let others = generated::rows_of(&plan.generated, &representation, &clips)?;
    let controller = digest_of(&plan.controller)?;
    let data = CriticData { robot: robot.name.clone(), controller, representation, motions, others, records };
    let mut trainer = CriticTrainer::new(&plan.critic, plan.seed, data)?;
    let summary = Driver::of(&source, &run, output).train(&mut trainer, |now| {
        let CriticMetrics { step, target } = now.metrics;
        format!("epoch {}  loss {:.4}  mean target {target:.2}", now.iteration, step.loss)
    })?;
    let Some(summary) = summary else { return Ok(()) };
    let path = CriticTrainer::critic_path(&folder);
    let validation = trainer.validate_once();
    let value = json!({
        "run": folder, "critic": path, "interrupted": summary.interrupted, "epochs": summary.iteration,
        "clips": clips.len(), "control_steps": steps, "failures": failures, "mean_reward": reward,
        "explained_variance": validation.map(|v| v[0]), "seconds": summary.seconds,
    });
    output.result(&value, || {
        let explained = validation.map_or(String::new(), |v| format!("; {:.2} of the variance explained on clips held out", v[0]));
        format!(
            "{steps} control steps on {} clips, {failures} failures, mean reward {reward:.3}; {} epochs in {:.1} min{explained}\n\
             critic: {}\nnext:   {}\n",
            clips.len(),
            summary.iteration,
            summary.seconds / 60.0,
            path.display(),
            NextCommand::new("generate")
                .word("a person walks")
                .path("--critic", &path)
                .word("--robot")
                .word(&plan.robot)
                .word("-o")
                .word("walk.motion.safetensors")
        )
    })?;
    if summary.interrupted {
        let next = NextCommand::new("train critic").word("--resume").path("-o", &folder);
        return Err(CliError::Interrupted(format!("go on with {next}")));
    }
    Ok(())
}

/// Control steps of a dry run.
const REHEARSED: u64 = 50;

/// Prints the resolved plan, and what its rollouts take on this machine.
fn rehearse(
    plan: &CriticTrainingPlan,
    run: &RunFolder,
    loaded: &Loaded,
    tracker: &TrackerPlan,
    clips: (&[MotionClip], usize),
    args: &Args,
    output: &Output,
) -> Result<(), CliError> {
    let short = RolloutPlan { steps: plan.rollouts.steps.min(REHEARSED), ..plan.rollouts };
    let begun = Instant::now();
    let records = record(
        &CriticTrainingPlan { rollouts: short, ..plan.clone() },
        loaded,
        tracker,
        clips,
        args,
        run.path(),
        output,
    )?;
    let rate = records.len() as f64 / begun.elapsed().as_secs_f64().max(1e-9);
    let total = plan.rollouts.environments as u64 * plan.rollouts.steps;
    let seconds = total as f64 / rate;
    let text = toml::to_string_pretty(plan).map_err(|e| CliError::Failed(e.to_string()))?;
    let value = json!({ "plan": text, "control_steps": total, "per_second": rate, "rollout_seconds": seconds });
    output.result(&value, || {
        format!(
            "{text}\nspeed:    {rate:.0} control steps per second (measured here, now)\n\
             rollouts: {total} control steps, {}; learning from them comes on top\n\
             Nothing was written. Run the same without --dry-run to train.\n",
            duration(seconds)
        )
    })
}

/// Removes the records of a run whose critic is complete.
pub fn discard_records(folder: &Path) -> Result<(), CliError> {
    let path = folder.join(RECORDS);
    if path.exists() { std::fs::remove_file(&path).map_err(CliError::write(&path)) } else { Ok(()) }
}

/// Collects the records of a run, and keeps them in its folder.
fn record(
    plan: &CriticTrainingPlan,
    loaded: &Loaded,
    tracker: &TrackerPlan,
    (clips, own): (&[MotionClip], usize),
    args: &Args,
    folder: &Path,
    output: &Output,
) -> Result<RewardRecords, CliError> {
    let rollouts = Rollouts { controller: &loaded.controller, clips, tracker, physics: &args.physics };
    let episode = EpisodeSpec { seconds: plan.rollouts.seconds, switch_clips: true, ..tracker.episode };
    let mut environment = rollouts.environment(episode, plan.rollouts.environments)?;
    let made: Vec<bool> = (0..clips.len()).map(|clip| clip >= own).collect();
    environment.reserve(&made, plan.rollouts.generated_share)?;
    let records = rollouts.record(environment, plan.rollouts.steps, output)?;
    let mut file = Checkpoint::new();
    records.save_into(&mut file, KEY)?;
    file.save(&folder.join(RECORDS))?;
    Ok(records)
}
