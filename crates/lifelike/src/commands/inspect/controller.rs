//! Controllers and policies: what they see, in which order, of which robot.

use std::path::Path;

use lifelike_checkpoint::Checkpoint;
use lifelike_robot::controller::{ControllerFile, ControllerHeader, KIND, PolicyHeader, RobotDescription};
use lifelike_robot::observation::{ObservationSpec, Source};
use serde_json::{Value, json};

use super::next_steps;
use crate::error::CliError;
use crate::next;
use crate::output::{Output, table};

/// Prints what a checkpoint holds where it is a controller or a policy; nothing where it is neither.
pub fn inspect(path: &Path, checkpoint: &Checkpoint, numbers: usize, output: &Output) -> Option<Result<(), CliError>> {
    if checkpoint.metadata().contains_key(KIND) {
        let file = ControllerFile::from_checkpoint(checkpoint, &path.display().to_string());
        return Some(file.map_err(CliError::from).and_then(|file| controller(path, &file, numbers, output)));
    }
    let header: PolicyHeader = checkpoint.meta("policy").ok()?;
    let file = ControllerFile::from_policy(checkpoint, None).map_err(CliError::from);
    Some(file.and_then(|file| policy(path, &file, &header, numbers, output)))
}

/// Prints a controller. Its golden vectors were replayed when it was read.
fn controller(path: &Path, file: &ControllerFile, numbers: usize, output: &Output) -> Result<(), CliError> {
    let header: &ControllerHeader = file.header();
    let steps = next_steps::of_policy(path, file, false);
    let layout = layout(&header.observation);
    let robot = file.robot();
    let value = json!({
        "kind": KIND, "numbers": numbers, "header": header, "robot": robot, "observation": layout,
        "next": next::texts(&steps),
    });
    output.result(&value, || {
        let mut text = format!(
            "{}: a controller for '{}' at {} Hz, {} inputs, hidden layers {:?}, {} outputs, trained for {} steps\n\
             golden vectors: reproduced\noutput: {}\n",
            path.display(),
            header.robot,
            header.control_hz,
            header.observation.size(),
            header.hidden,
            header.observation.joints.len(),
            header.provenance.steps,
            json!(header.action)
        );
        if let Some(prior) = &header.prior {
            let (latent, seconds) = (prior.latent, prior.window_seconds);
            text += &format!("motion prior inside: {latent} numbers for {seconds} s of motion around each frame\n");
        }
        text += &names(&header.observation);
        if let Some(RobotDescription { digest, substeps, .. }) = robot {
            text += &format!("robot: {substeps} physics steps per policy step, SHA-256 {digest}\n");
        }
        text += &format!("from: policy with SHA-256 {}\n", header.provenance.policy);
        text + &next::lines(&steps)
    })
}

/// Prints a policy as training writes it.
fn policy(
    path: &Path,
    file: &ControllerFile,
    header: &PolicyHeader,
    numbers: usize,
    output: &Output,
) -> Result<(), CliError> {
    let steps = next_steps::of_policy(path, file, !header.prior.is_empty());
    let layout = layout(&header.observation);
    let value = json!({
        "kind": "policy", "numbers": numbers, "header": header, "observation": layout, "next": next::texts(&steps),
    });
    output.result(&value, || {
        let mut text = format!(
            "{}: a policy for '{}' at {} Hz, {} inputs, hidden layers {:?}, {} outputs, trained for {} steps\n\
             output: {}\n",
            path.display(),
            header.robot,
            header.control_hz,
            header.observation.size(),
            header.hidden,
            header.observation.joints.len(),
            header.steps,
            json!(header.action)
        );
        if !header.prior.is_empty() {
            text += &format!("latent codes of the prior with SHA-256 {}\n", header.prior);
        }
        text + &names(&header.observation) + &next::lines(&steps)
    })
}

/// The layout for scripts.
fn layout(observation: &ObservationSpec) -> Vec<Value> {
    let parts = observation.parts();
    parts.iter().map(|p| json!({ "name": p.name, "start": p.range.start, "end": p.range.end })).collect()
}

/// The layout, joints and end effectors for people.
fn names(observation: &ObservationSpec) -> String {
    let rows: Vec<Vec<String>> = observation
        .parts()
        .iter()
        .map(|part| {
            let (r, origin) = (&part.range, origin(part.source));
            vec![part.name.clone(), r.start.to_string(), r.end.to_string(), r.len().to_string(), origin.into()]
        })
        .collect();
    let mut text = format!("\n{}", table(&["observation", "from", "to", "numbers", "origin"], &rows));
    text += &format!("\njoints, in order: {}\n", observation.joints.join(", "));
    if !observation.end_effectors.is_empty() {
        text += &format!("end effectors, in order: {}\n", observation.end_effectors.join(", "));
    }
    text
}

/// The origin of a part, in words.
fn origin(source: Source) -> &'static str {
    match source {
        Source::Measured(sensor) if sensor.is_on_board() => "on-board sensors",
        Source::Measured(_) => "a state estimator",
        Source::Action => "the controller's own outputs",
        Source::Reference => "the motion to follow",
    }
}
