//! Rollouts of a frozen controller in a tracker plan's environments, for commands.

use std::path::Path;
use std::sync::Arc;

use lifelike_generation::critic::RewardRecords;
use lifelike_generation::representation::{FeatureMatrix, RepresentationSpec};
use lifelike_motion::MotionClip;
use lifelike_robot::{Controller, LatentEncoder, ReferenceLibrary, Robot};
use lifelike_tracking::plan::EpisodeSpec;
use lifelike_tracking::{Environment, TrackerPlan};
use rayon::prelude::*;
use sha2::{Digest, Sha256};

use crate::commands::export::Source;
use crate::commands::physics::Physics;
use crate::error::CliError;
use crate::output::Output;
use crate::plans;
use crate::progress::Progress;

/// A tracker's training, by its plan's name or file, whose reward, terminations, randomisation and pushes hold.
pub fn tracker_plan(name: &Path, robot: &str, seed: u64) -> Result<TrackerPlan, CliError> {
    // The plan's own clips and networks are not needed, wherever they are.
    let mut plan: TrackerPlan = plans::load(name, &["clips=[\"builtin\"]".into()])?;
    (plan.robot, plan.seed) = (robot.into(), seed);
    (plan.prior, plan.init) = (None, None);
    Ok(plan)
}

/// Returns the plan of the environment that a controller was trained in: the one named, else the one in its file.
///
/// # Errors
/// [`CliError::Input`] where there is none, or a plan of another version.
pub fn environment_of(
    named: Option<&Path>,
    file: &Path,
    controller: &Controller,
    robot: &str,
    seed: u64,
) -> Result<TrackerPlan, CliError> {
    if let Some(name) = named {
        return tracker_plan(name, robot, seed);
    }
    let shown = file.display();
    let text = controller.header().environment.as_ref().ok_or_else(|| {
        CliError::Input(format!(
            "{shown}: expected the plan of the environment that it was trained in, got a file without one; name it with \
             environment=PLAN (a file, or a name of `lifelike plans`)"
        ))
    })?;
    let plan: TrackerPlan =
        toml::from_str(text).map_err(|e| CliError::Input(format!("{shown}: plan of its environment: {e}")))?;
    Ok(TrackerPlan { robot: robot.into(), seed, ..plan })
}

/// A controller among clips.
pub struct Rollouts<'a> {
    /// The frozen controller.
    pub controller: &'a Controller,
    /// Clips to follow.
    pub clips: &'a [MotionClip],
    /// The environments' plan.
    pub tracker: &'a TrackerPlan,
    /// Physics engine.
    pub physics: &'a Physics,
}

impl Rollouts<'_> {
    /// Makes that number of environments whose episodes take this course.
    pub fn environment(&self, episode: EpisodeSpec, environments: usize) -> Result<Environment, CliError> {
        let robot = Arc::clone(self.controller.robot());
        let encoder = self.controller.prior().map(|prior| prior as &dyn LatentEncoder);
        let library = ReferenceLibrary::new(&robot, self.clips, encoder)?;
        let terrain = self.tracker.terrain.map(|terrain| terrain.build()).transpose()?.map(Arc::new);
        let simulation = self.physics.simulate(terrain, &robot, environments)?;
        let plan = TrackerPlan { episode, ..self.tracker.frozen(self.controller, environments) };
        Ok(Environment::new(&plan, robot, Arc::new(library), simulation)?)
    }

    /// Lets the controller act in environments for a number of control steps of each.
    pub fn record(&self, mut environment: Environment, steps: u64, output: &Output) -> Result<RewardRecords, CliError> {
        let mut progress = Progress::new(output, "rollouts", steps);
        let records = environment.record(self.controller, steps, |done| progress.update(done, steps, String::new))?;
        progress.finish();
        Ok(records)
    }
}

/// Rows of clips in thesis 5.2's representation.
pub fn rows_of(clips: &[MotionClip], robot: &Robot) -> Result<(RepresentationSpec, Vec<FeatureMatrix>), CliError> {
    let spec = RepresentationSpec::of(&robot.layout);
    let rows = clips.par_iter().map(|clip| FeatureMatrix::from_clip(clip, &spec)).collect::<Result<Vec<_>, _>>()?;
    Ok((spec, rows))
}

/// SHA-256 of a controller, of the policy where it is a run; hexadecimal.
pub fn digest_of(path: &Path) -> Result<String, CliError> {
    let path = &Source::of(path)?.policy;
    let bytes = std::fs::read(path).map_err(|e| CliError::Input(format!("{}: {e}", path.display())))?;
    Ok(Sha256::digest(&bytes).iter().map(|byte| format!("{byte:02x}")).collect())
}
