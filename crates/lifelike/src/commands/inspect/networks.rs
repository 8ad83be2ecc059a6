//! Motion priors, by the training framework.

use std::path::Path;

use lifelike_checkpoint::Checkpoint;
use lifelike_representation::MotionPrior;
use serde_json::json;

use crate::error::CliError;
use crate::next::{self, NextCommand};
use crate::output::Output;

/// Prints what a checkpoint holds where it is a motion prior; nothing where it is none.
pub fn inspect(path: &Path, checkpoint: &Checkpoint, numbers: usize, output: &Output) -> Option<Result<(), CliError>> {
    if !MotionPrior::is_in(checkpoint) {
        return None;
    }
    let print = |loaded| prior(path, &loaded, numbers, output);
    Some(MotionPrior::load(path).map_err(CliError::from).and_then(print))
}

/// Prints what a motion prior encodes.
fn prior(path: &Path, prior: &MotionPrior, numbers: usize, output: &Output) -> Result<(), CliError> {
    let (plan, windows, layout) = (prior.plan(), prior.windows(), prior.layout());
    let steps =
        [NextCommand::new("motion search builtin:wave --at 1").path("--prior", path).word("--motions").word("builtin")];
    let value = json!({
        "kind": plan.kind(), "numbers": numbers, "plan": plan, "layout": layout, "next": next::texts(&steps),
    });
    let code = plan.describe_code();
    output.result(&value, || {
        format!(
            "{}: a {}, {numbers} numbers\n\
             {} numbers ({code}) for {} s of motion, {} samples of {} features; clips at {} Hz\n\n\
             joints, in order: {}\nend effectors, in order: {}\n{}",
            path.display(),
            plan.kind(),
            prior.latent_size(),
            windows.window_seconds,
            windows.window().len(),
            layout.size(),
            windows.frame_rate,
            layout.joints.join(", "),
            layout.end_effectors.join(", "),
            next::lines(&steps)
        )
    })
}
