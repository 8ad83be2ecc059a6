//! Networks: a policy, a motion prior, or any other checkpoint.

use std::path::Path;

use lifelike_checkpoint::Checkpoint;
use lifelike_representation::MotionPrior;
use lifelike_robot::controller::PolicyHeader;
use lifelike_robot::observation::Part;
use serde_json::{Value, json};

use crate::error::CliError;
use crate::output::{Output, table};

/// Prints what a checkpoint holds.
pub fn inspect(path: &Path, output: &Output) -> Result<(), CliError> {
    let checkpoint = Checkpoint::load(path)?;
    let numbers: usize = checkpoint.entries().values().map(|e| e.count()).sum();
    if let Ok(header) = checkpoint.meta::<PolicyHeader>("policy") {
        return policy(path, &header, numbers, output);
    }
    if MotionPrior::is_in(&checkpoint) {
        return prior(path, &MotionPrior::load(path)?, numbers, output);
    }
    let arrays: Vec<Value> = checkpoint
        .entries()
        .iter()
        .map(|(name, e)| json!({ "name": name, "shape": e.shape(), "type": format!("{:?}", e.kind()) }))
        .collect();
    let value =
        json!({ "kind": "checkpoint", "numbers": numbers, "metadata": checkpoint.metadata(), "arrays": arrays });
    output.result(&value, || {
        let mut text = format!("{}: a checkpoint of {numbers} numbers in {} arrays\n\n", path.display(), arrays.len());
        for (key, value) in checkpoint.metadata() {
            text += &format!("{key} = {value}\n");
        }
        let rows: Vec<Vec<String>> = checkpoint
            .entries()
            .iter()
            .map(|(name, e)| vec![name.clone(), format!("{:?}", e.shape()), format!("{:?}", e.kind())])
            .collect();
        text + "\n" + &table(&["array", "shape", "type"], &rows)
    })
}

/// A policy: what it sees, where, and what it says.
fn policy(path: &Path, header: &PolicyHeader, numbers: usize, output: &Output) -> Result<(), CliError> {
    let parts = header.observation.parts();
    let layout: Vec<Value> =
        parts.iter().map(|p| json!({ "name": p.name, "start": p.range.start, "end": p.range.end })).collect();
    let value = json!({ "kind": "policy", "numbers": numbers, "header": header, "observation": layout });
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
            .map(|Part { name, range: r, .. }| {
                vec![name.clone(), r.start.to_string(), r.end.to_string(), r.len().to_string()]
            })
            .collect();
        text += &format!("\n{}", table(&["observation", "from", "to", "numbers"], &rows));
        text += &format!("\njoints, in order: {}\n", header.observation.joints.join(", "));
        if !header.observation.end_effectors.is_empty() {
            text += &format!("end effectors, in order: {}\n", header.observation.end_effectors.join(", "));
        }
        text
    })
}

/// A motion prior: what it encodes.
fn prior(path: &Path, prior: &MotionPrior, numbers: usize, output: &Output) -> Result<(), CliError> {
    let (plan, windows, layout) = (prior.plan(), prior.windows(), prior.layout());
    let value = json!({ "kind": plan.kind(), "numbers": numbers, "plan": plan, "layout": layout });
    let code = plan.describe_code();
    output.result(&value, || {
        format!(
            "{}: a {}, {numbers} numbers\n\
             {} numbers ({code}) for {} s of motion, {} samples of {} features; clips at {} Hz\n\n\
             joints, in order: {}\nend effectors, in order: {}\n",
            path.display(),
            plan.kind(),
            prior.latent_size(),
            windows.window_seconds,
            windows.window().len(),
            layout.size(),
            windows.frame_rate,
            layout.joints.join(", "),
            layout.end_effectors.join(", ")
        )
    })
}
