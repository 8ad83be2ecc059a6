//! Networks that say what they are: a policy, a motion prior.

use std::path::Path;

use lifelike_checkpoint::Checkpoint;
use lifelike_representation::spline_transformer::SequencePlan;
use lifelike_representation::{MotionPrior, Recipe};
use lifelike_tracking::PolicyHeader;
use serde_json::{Value, json};

use super::next_steps;
use crate::error::CliError;
use crate::next::{self, NextCommand};
use crate::output::{Output, table};

/// Prints what a checkpoint holds where it is a policy or a prior; nothing where it is neither.
pub fn inspect(path: &Path, checkpoint: &Checkpoint, numbers: usize, output: &Output) -> Option<Result<(), CliError>> {
    if let Ok(header) = checkpoint.meta::<PolicyHeader>("policy") {
        return Some(policy(path, &header, numbers, output));
    }
    if MotionPrior::is_in(checkpoint) {
        let print = |loaded| prior(path, &loaded, numbers, output);
        return Some(MotionPrior::load(path).map_err(CliError::from).and_then(print));
    }
    None
}

/// A policy: what it sees, where, and what it says.
fn policy(path: &Path, header: &PolicyHeader, numbers: usize, output: &Output) -> Result<(), CliError> {
    let parts = header.observation.parts();
    let layout: Vec<Value> =
        parts.iter().map(|(name, range)| json!({ "name": name, "start": range.start, "end": range.end })).collect();
    let steps = next_steps::of_policy(path, &header.robot, !header.prior.is_empty());
    let value = json!({
        "kind": "policy", "numbers": numbers, "header": header, "observation": layout, "next": next::texts(&steps),
    });
    output.result(&value, || {
        let mut text = format!(
            "{}: a policy for '{}' at {} Hz, {} inputs, hidden layers {:?}, {} outputs, trained for {} steps\n",
            path.display(),
            header.robot,
            header.control_hz,
            header.observation.size(),
            header.hidden,
            header.observation.joints.len(),
            header.steps
        );
        text += &format!("output: {}\n", json!(header.action));
        if !header.prior.is_empty() {
            text += &format!("latent codes of the prior with SHA-256 {}\n", header.prior);
        }
        let rows: Vec<Vec<String>> = parts
            .iter()
            .map(|(name, r)| vec![name.clone(), r.start.to_string(), r.end.to_string(), r.len().to_string()])
            .collect();
        text += &format!("\n{}", table(&["observation", "from", "to", "numbers"], &rows));
        text += &format!("\njoints, in order: {}\n", header.observation.joints.join(", "));
        if !header.observation.end_effectors.is_empty() {
            text += &format!("end effectors, in order: {}\n", header.observation.end_effectors.join(", "));
        }
        text + &next::lines(&steps)
    })
}

/// A motion prior: what it encodes.
fn prior(path: &Path, prior: &MotionPrior, numbers: usize, output: &Output) -> Result<(), CliError> {
    let (plan, layout, recipe) = (prior.plan(), prior.layout(), prior.recipe());
    let steps = [NextCommand::new("bench latent").path("--prior", path).word("--motions").word("builtin")];
    let value = json!({
        "kind": recipe.kind(), "numbers": numbers, "plan": recipe, "layout": layout, "next": next::texts(&steps),
    });
    let code = match recipe {
        Recipe::Vae(_) => "the mean of a beta-VAE's code".to_owned(),
        Recipe::Spline(plan) => {
            let SequencePlan { method, latent, .. } = plan.training;
            format!("{} control points of {latent}, by their mean and spread ({method})", prior.latent_size() / latent)
        }
    };
    output.result(&value, || {
        format!(
            "{}: a {}, {numbers} numbers\n\
             {} numbers ({code}) for {} s of motion, {} samples of {} features; clips at {} Hz\n\n\
             joints, in order: {}\nend effectors, in order: {}\n{}",
            path.display(),
            recipe.kind(),
            prior.latent_size(),
            plan.window_seconds,
            plan.window().len(),
            layout.size(),
            plan.frame_rate,
            layout.joints.join(", "),
            layout.end_effectors.join(", "),
            next::lines(&steps)
        )
    })
}
