//! Controllers: what they see, in which order, of which robot.

use std::path::Path;

use lifelike_checkpoint::Checkpoint;
use lifelike_robot::controller::{ControllerFile, ControllerHeader, KIND};
use lifelike_robot::observation::{ObservationSpec, Source};
use serde_json::{Value, json};

use super::next_steps;
use crate::error::CliError;
use crate::next;
use crate::output::{Output, table};

/// An array that only controllers have with which a training can begin.
const EXPLORATION: &str = "actor.log_std";

/// Prints what a checkpoint holds where it is a controller; nothing where it is none.
pub fn inspect(path: &Path, checkpoint: &Checkpoint, numbers: usize, output: &Output) -> Option<Result<(), CliError>> {
    checkpoint.metadata().contains_key(KIND).then(|| {
        let file = ControllerFile::from_checkpoint(checkpoint, &path.display().to_string())?;
        controller(path, &file, checkpoint.contains(EXPLORATION), numbers, output)
    })
}

/// Prints a controller. Its golden vectors were replayed when it was read.
fn controller(
    path: &Path,
    file: &ControllerFile,
    trainable: bool,
    numbers: usize,
    output: &Output,
) -> Result<(), CliError> {
    let header: &ControllerHeader = file.header();
    let steps = next_steps::of_policy(path, file);
    let layout = layout(&header.observation);
    let robot = file.robot();
    let value = json!({
        "kind": KIND, "numbers": numbers, "header": header, "robot": robot, "trainable": trainable, "observation": layout,
        "next": next::texts(&steps),
    });
    output.result(&value, || {
        let mut text = format!(
            "{}: a controller for '{}' at {} Hz, {} inputs, hidden layers {:?}{}, {} outputs, trained for {} steps\n\
             golden vectors: reproduced\noutput: {}\n",
            path.display(),
            header.robot,
            header.control_hz,
            header.observation.size(),
            header.hidden,
            header.memory.map(|state| format!(", a memory of {state} numbers")).unwrap_or_default(),
            header.observation.joints.len(),
            header.provenance.steps,
            json!(header.action)
        );
        if let Some(prior) = &header.prior {
            let (latent, seconds) = (prior.latent, prior.window_seconds);
            text += &format!("motion prior inside: {latent} numbers for {seconds} s of motion around each frame\n");
        }
        text += &names(&header.observation);
        text += &format!("robot: {} physics steps per policy step, SHA-256 {}\n", robot.substeps, robot.digest);
        text += &format!("from: policy with SHA-256 {}\n", header.provenance.policy);
        if header.prior.is_none() && !header.provenance.prior.is_empty() {
            text += &format!("latent codes of the prior with SHA-256 {}\n", header.provenance.prior);
        }
        if trainable {
            text += "a training can begin with it (init)\n";
        }
        text + &next::lines(&steps)
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
        Source::Past => "the steps before",
    }
}
