//! An augmentation in a running simulation: [`lifelike_sim::Augmented`] asks it at every step.

use lifelike_robot::Robot;
use lifelike_sim::StateCorrection;
use lifelike_sim::augmented::{CorrectionStep, HistorySize};

use crate::augmentation::{Augmentation, Feedback};
use crate::model::{Field, Stream, drag};
use crate::{AugmentationError, FromInput};

/// A step of a simulation as an actuator sees it.
#[derive(Debug, Clone, Copy)]
enum Source {
    Position,
    Velocity,
    Torque,
    Load,
    Target,
    /// Target less position.
    Error,
    /// Change of the target since the step before (per s).
    Change,
    /// 1: the motor is on.
    Enabled,
    /// Lag behind a slider; its number among the sliders.
    Play(usize),
}

/// A play operator: of the target or of the position, half its width (rad).
#[derive(Debug, Clone, Copy)]
struct Slider {
    of_target: bool,
    radius: f32,
}

/// Columns that a correction writes.
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
    sliders: Vec<Slider>,
    outputs: Vec<(Output, f32)>,
}

impl ActuatorCorrection {
    /// Corrects some of a robot's joints, by name; all of them where none is named.
    ///
    /// # Errors
    /// [`AugmentationError::Input`] for an unknown joint, for another rate than the robot's, and for columns that a
    /// simulation does not tell of an actuator. Measurements cannot be fed back.
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
        let mut sliders = Vec::new();
        let mut slider = |of_target: bool, radius: f32| {
            sliders.push(Slider { of_target, radius });
            Ok(Source::Play(sliders.len() - 1))
        };
        let source = |field: &Field| match field {
            Field::StatePlay(name, radius) if name == "position" => slider(false, *radius),
            Field::ReferencePlay(name, radius) if name == "position" => slider(true, *radius),
            Field::State(name) if name == "position" => Ok(Source::Position),
            Field::State(name) if name == "velocity" => Ok(Source::Velocity),
            Field::State(name) if name == "torque" => Ok(Source::Torque),
            Field::Force(name) if name == "load" => Ok(Source::Load),
            Field::Reference(name) if name == "position" => Ok(Source::Target),
            Field::Reference(name) if name == "enabled" => Ok(Source::Enabled),
            Field::Error(name) if name == "position" => Ok(Source::Error),
            Field::Change(name) if name == "position" => Ok(Source::Change),
            other => Err(AugmentationError::mismatch(
                format!("inputs of the augmentation of '{}'", inputs.class),
                "what a simulation tells of an actuator: position, velocity, torque, load and target (leave_out of the plan)",
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
        Ok(Self { augmentation, stream, feedback, name, joints, sources, sliders, outputs })
    }

    /// Numbers of one joint's record: the network's, the sliders' places, and the target.
    fn width(&self) -> usize {
        self.stream.record_width() + self.sliders.len() + 1
    }

    /// Position and target of a joint.
    fn places(&self, step: &CorrectionStep<'_>, slot: usize) -> [f32; 2] {
        let joint = self.joints[slot];
        [step.simulated.joint_position[joint], step.drive.values()[joint]]
    }

    /// Returns the position of a joint's slider after this step.
    fn slid(&self, step: &CorrectionStep<'_>, slot: usize, number: usize) -> f32 {
        let Slider { of_target, radius } = self.sliders[number];
        let x = self.places(step, slot)[usize::from(of_target)];
        let first = slot * self.width() + self.stream.record_width();
        drag(step.history.last().map_or(x, |record| record[first + number]), x, radius)
    }

    /// The network's row of a joint, in units of the scales.
    fn row(&self, step: &CorrectionStep<'_>, slot: usize, out: &mut Vec<f32>) {
        let joint = self.joints[slot];
        let [position, target] = self.places(step, slot);
        let before = step.history.last().map_or(target, |record| record[(slot + 1) * self.width() - 1]);
        let header = self.augmentation.header();
        let number = |source: &Source| match source {
            Source::Position => position,
            Source::Velocity => step.simulated.joint_velocity[joint],
            Source::Torque => step.simulated.torque[joint],
            Source::Load => -step.wrenches.joint_load[joint],
            Source::Target => target,
            Source::Error => target - position,
            Source::Change => (target - before) * header.inputs.rate as f32,
            Source::Enabled => 1.0,
            Source::Play(number) => {
                let Slider { of_target, radius } = self.sliders[*number];
                (self.places(step, slot)[usize::from(of_target)] - self.slid(step, slot, *number)) / radius
            }
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
        let own_width = self.stream.record_width();
        let mut records = vec![0.0; environments.len() * count * own_width];
        let own = &*environments;
        let past = |row: usize| {
            let slot = row % count;
            own[row / count].history.records().map(move |record| &record[slot * width..][..own_width])
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
                let slid: Vec<f32> = (0..self.sliders.len()).map(|number| self.slid(step, slot, number)).collect();
                let record = &mut step.record[slot * width..(slot + 1) * width];
                record[..own_width].copy_from_slice(&records[row * own_width..][..own_width]);
                record[own_width..width - 1].copy_from_slice(&slid);
                record[width - 1] = step.drive.values()[*joint];
            }
        }
    }
}
