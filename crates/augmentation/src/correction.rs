//! An augmentation in a running simulation: [`lifelike_sim::Augmented`] asks it at every step.

use lifelike_robot::Robot;
use lifelike_sim::StateCorrection;
use lifelike_sim::augmented::{CorrectionStep, HistorySize};

use crate::AugmentationError;
use crate::augmentation::{Augmentation, Feedback};
use crate::model::{Field, Stream};

/// What a step of a simulation tells of an actuator.
#[derive(Debug, Clone, Copy)]
enum Source {
    Position,
    Velocity,
    Load,
    Target,
    /// Target less position.
    Error,
    /// Change of the target since the step before (per s).
    Change,
    /// 1: the motor is on.
    Enabled,
}

/// What a correction writes.
#[derive(Debug, Clone, Copy)]
enum Output {
    Position,
    Velocity,
}

/// One augmentation that serves every joint of its class: joints are rows of one batch, each with its own history.
pub struct ActuatorCorrection {
    augmentation: Augmentation,
    stream: Stream,
    feedback: Feedback,
    name: String,
    /// Numbers of its joints among the robot's scalar joints.
    joints: Vec<usize>,
    sources: Vec<Source>,
    outputs: Vec<(Output, f32)>,
}

impl ActuatorCorrection {
    /// Corrects some of a robot's joints, by name; all of them where none is named.
    ///
    /// # Errors
    /// [`AugmentationError::Mismatch`] for a joint that there is not, another rate than the robot's, and for an augmentation that
    /// reads or predicts what a simulation does not tell of an actuator; measurements cannot be fed back.
    pub fn new(
        augmentation: Augmentation,
        robot: &Robot,
        joints: &[String],
        feedback: Feedback,
    ) -> Result<Self, AugmentationError> {
        let inputs = &augmentation.header().inputs;
        if (inputs.rate - robot.control_hz).abs() > 1e-6 * robot.control_hz {
            let what = format!("rate of the augmentation of '{}' on '{}'", inputs.class, robot.name);
            let got = format!("{} Hz (make the traces at the robot's rate)", inputs.rate);
            return Err(AugmentationError::mismatch(what, format!("{} Hz", robot.control_hz), got));
        }
        if feedback == Feedback::Measured {
            return Err(AugmentationError::mismatch("feedback in a simulation", "none or predictions", "measurements"));
        }
        let index = |name: &String| {
            robot.layout.joints.iter().position(|own| own == name).ok_or_else(|| {
                AugmentationError::mismatch("joints", format!("some of {:?}", robot.layout.joints), format!("'{name}'"))
            })
        };
        let joints = match joints {
            [] => (0..robot.joints()).collect(),
            names => names.iter().map(index).collect::<Result<Vec<_>, _>>()?,
        };
        let source = |field: &Field| match field {
            Field::State(name) if name == "position" => Ok(Source::Position),
            Field::State(name) if name == "velocity" => Ok(Source::Velocity),
            Field::Force(name) if name == "load" => Ok(Source::Load),
            Field::Reference(name) if name == "position" => Ok(Source::Target),
            Field::Reference(name) if name == "enabled" => Ok(Source::Enabled),
            Field::Error(name) if name == "position" => Ok(Source::Error),
            Field::Change(name) if name == "position" => Ok(Source::Change),
            other => Err(AugmentationError::mismatch(
                format!("inputs of the augmentation of '{}'", inputs.class),
                "what a simulation tells of an actuator: position, velocity, load and target (leave_out of the plan)",
                format!("{other:?}"),
            )),
        };
        let sources = inputs.fields.iter().map(source).collect::<Result<Vec<_>, _>>()?;
        let output = |row: &lifelike_sim::trace::Selected| match &row.state[..] {
            [(name, factor)] if name == "position" => Ok((Output::Position, *factor)),
            [(name, factor)] if name == "velocity" => Ok((Output::Velocity, *factor)),
            other => {
                let got = format!("{other:?}");
                Err(AugmentationError::mismatch("outputs of the augmentation", "position and velocity", got))
            }
        };
        let outputs = inputs.selection.iter().map(output).collect::<Result<Vec<_>, _>>()?;
        let (stream, name) = (augmentation.stream(), format!("augmentation of {}", inputs.class));
        Ok(Self { augmentation, stream, feedback, name, joints, sources, outputs })
    }

    /// Numbers of one joint's record: the network's, and the target.
    fn width(&self) -> usize {
        self.stream.record_width() + 1
    }

    /// The network's row of a joint, in units of the scales.
    fn row(&self, step: &CorrectionStep<'_>, slot: usize, out: &mut Vec<f32>) {
        let joint = self.joints[slot];
        let (position, target) = (step.simulated.joint_position[joint], step.drive.values()[joint]);
        let before = step.history.last().map_or(target, |record| record[(slot + 1) * self.width() - 1]);
        let header = self.augmentation.header();
        let number = |source: &Source| match source {
            Source::Position => position,
            Source::Velocity => step.simulated.joint_velocity[joint],
            Source::Load => -step.wrenches.joint_load[joint],
            Source::Target => target,
            Source::Error => target - position,
            Source::Change => (target - before) * header.inputs.rate as f32,
            Source::Enabled => 1.0,
        };
        let first = out.len();
        out.extend(self.sources.iter().map(number));
        header.scales.standardize(&mut out[first..]);
    }
}

impl StateCorrection for ActuatorCorrection {
    fn name(&self) -> &str {
        &self.name
    }

    fn history(&self, _: &Robot) -> HistorySize {
        HistorySize { steps: self.stream.history(), width: self.joints.len() * self.width() }
    }

    fn needs_wrenches(&self) -> bool {
        self.sources.iter().any(|source| matches!(source, Source::Load))
    }

    fn correct(&mut self, environments: &mut [CorrectionStep<'_>]) {
        let (count, width, outputs) = (self.joints.len(), self.width(), self.outputs.len());
        if count == 0 {
            return;
        }
        let mut rows = Vec::with_capacity(environments.len() * count * self.sources.len());
        for step in &*environments {
            (0..count).for_each(|slot| self.row(step, slot, &mut rows));
        }
        let mut records = vec![0.0; environments.len() * count * (width - 1)];
        let own = &*environments;
        let past = |row: usize| {
            let slot = row % count;
            own[row / count].history.records().map(move |record| &record[slot * width..(slot + 1) * width - 1])
        };
        let out = self.augmentation.step(&self.stream, &rows, self.feedback, past, &mut records);
        let scales = &self.augmentation.header().scales.error;
        for (i, step) in environments.iter_mut().enumerate() {
            for (slot, joint) in self.joints.iter().enumerate() {
                let row = i * count + slot;
                let errors = out[row * outputs..][..outputs].iter().zip(scales);
                for ((x, scale), (output, factor)) in errors.zip(&self.outputs) {
                    let delta = x * scale / factor;
                    match output {
                        Output::Position => step.corrected.joint_position[*joint] += delta,
                        Output::Velocity => step.corrected.joint_velocity[*joint] += delta,
                    }
                }
                let record = &mut step.record[slot * width..(slot + 1) * width];
                record[..width - 1].copy_from_slice(&records[row * (width - 1)..][..width - 1]);
                record[width - 1] = step.drive.values()[*joint];
            }
        }
    }
}
