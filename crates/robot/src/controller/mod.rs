//! The controller: measured state and a reference in, joint targets out.
//!
//! [`Controller`] is constant and [`ControllerState`] is the state of one run, as in `mj_step(model, data)`. It owns
//! the observation, the history of actions, the normalisation, the frozen policy, and the action map with its clamps.
//! For a policy that reads z_t it also owns the frozen encoder of the motion prior. Training creates it; evaluation,
//! simulation and the robot run it.
//!
//! The main path: [`Controller::load`] → [`Controller::step`], which is [`Controller::observe`] →
//! [`Controller::outputs`] → [`Controller::act`]. For many robots at once call the three directly, with the rows of all
//! robots in the middle. A [`ControllerFile`] is a controller without a robot.

mod description;
mod file;
mod golden;
mod header;
mod policy;
mod prior;
mod state;

use std::path::Path;
use std::sync::Arc;

use crate::action::ActionMap;
use crate::observation::{MeasuredState, ObservationInputs, ObservationSpec};
use crate::reference::{Alignment, ReferenceStream, RootPose};
use crate::robot::Robot;
use crate::{FromInput, RobotError};

pub use description::RobotDescription;
pub use file::{ControllerFile, EXTENSION, KIND};
pub use header::{ControllerHeader, Provenance};
pub use policy::{FrozenPolicy, PolicyWorkspace};
pub use prior::{PriorEncoder, PriorHeader};
pub use state::{ControllerState, History, ObservationScratch};

/// A controller for one robot.
#[derive(Debug, Clone)]
pub struct Controller {
    robot: Arc<Robot>,
    file: ControllerFile,
    actions: ActionMap,
    /// [`ObservationSpec::remembered`] of its layout.
    remembered: Vec<usize>,
}

impl Controller {
    /// Makes a controller for a robot.
    ///
    /// # Errors
    /// Names, order, default pose, rates, gains or limits of the robot are not those that it was trained with.
    pub fn new(file: ControllerFile, robot: Arc<Robot>) -> Result<Self, RobotError> {
        file.check(&robot)?;
        let actions = ActionMap::new(file.header().action, &robot);
        let remembered = file.header().observation.remembered();
        Ok(Self { robot, file, actions, remembered })
    }

    /// Reads a controller.
    ///
    /// # Errors
    /// The file is damaged or no controller, its golden vectors are not reproduced, or it wants latent codes and cannot
    /// make them; or as [`Self::new`].
    pub fn load(path: &Path, robot: Arc<Robot>) -> Result<Self, RobotError> {
        let file = ControllerFile::read(path)?;
        file.check_complete()?;
        Self::new(file, robot)
    }

    /// The robot.
    pub fn robot(&self) -> &Arc<Robot> {
        &self.robot
    }

    /// Networks and names.
    pub fn file(&self) -> &ControllerFile {
        &self.file
    }

    /// Names, layout and provenance.
    pub fn header(&self) -> &ControllerHeader {
        self.file.header()
    }

    /// The layout of its observations.
    pub fn observation(&self) -> &ObservationSpec {
        &self.file.header().observation
    }

    /// The map from outputs to joint targets.
    pub fn actions(&self) -> &ActionMap {
        &self.actions
    }

    /// The frozen encoder of latent codes, where it has one.
    pub fn prior(&self) -> Option<&PriorEncoder> {
        self.file.prior()
    }

    /// Writes the controller as one file.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn save(&self, path: &Path) -> Result<(), RobotError> {
        Ok(self.file.to_checkpoint()?.save(path)?)
    }

    /// Begins an episode: lays the reference's world under the robot, and takes as its last actions those that fit the
    /// pose in which it is.
    ///
    /// # Errors
    /// The reference has other names, or arrays have the wrong length.
    pub fn begin(
        &self,
        state: &mut ControllerState,
        measured: &MeasuredState<'_>,
        reference: &dyn ReferenceStream,
    ) -> Result<(), RobotError> {
        let RootPose { position, orientation } = reference.present_root();
        let here = measured.root_position.unwrap_or(position);
        state.history.alignment = Alignment::between(position, orientation, here, measured.root_orientation);
        self.rest(&mut state.history, measured, reference)
    }

    /// Takes as last actions those that hold the pose in which the robot is.
    ///
    /// # Errors
    /// As [`Self::begin`].
    pub fn rest(
        &self,
        history: &mut History,
        measured: &MeasuredState<'_>,
        reference: &dyn ReferenceStream,
    ) -> Result<(), RobotError> {
        let (got, expected) = (reference.layout(), &self.robot.layout);
        if got != expected {
            return Err(RobotError::mismatch(
                format!("joints and end effectors of the reference for robot '{}'", self.robot.name),
                format!("{} and {}", expected.joints.join(", "), expected.end_effectors.join(", ")),
                format!("{} and {}", got.joints.join(", "), got.end_effectors.join(", ")),
            ));
        }
        let joints = self.robot.joints();
        if measured.joint_position.len() != joints {
            return Err(RobotError::mismatch("length of joint positions", joints, measured.joint_position.len()));
        }
        self.actions.holding(measured.joint_position, self.target_joints(reference), &mut history.last);
        history.before.copy_from_slice(&history.last);
        history.memory.clear();
        history.begun = true;
        Ok(())
    }

    /// One step: joint targets (rad, `[J]`) for the present state and reference, which goes on by one step. The first
    /// begins an episode ([`Self::begin`]). Allocates nothing from the second step on.
    ///
    /// # Errors
    /// An array has the wrong length, or the policy sees something that was not measured.
    pub fn step(
        &self,
        state: &mut ControllerState,
        measured: &MeasuredState<'_>,
        reference: &mut dyn ReferenceStream,
        targets: &mut [f32],
    ) -> Result<(), RobotError> {
        if !state.history.begun {
            self.begin(state, measured, reference)?;
        }
        let ControllerState { history, scratch, policy, observation, outputs } = state;
        self.observe(history, scratch, measured, reference, observation)?;
        self.outputs(observation, policy, outputs);
        self.act(history, reference, outputs, targets)?;
        reference.advance();
        Ok(())
    }

    /// Writes the observation of the present state, not normalised, `[O]`, and takes note of it where the policy sees its past.
    ///
    /// # Errors
    /// As [`Self::step`].
    pub fn observe(
        &self,
        history: &mut History,
        scratch: &mut ObservationScratch,
        measured: &MeasuredState<'_>,
        reference: &dyn ReferenceStream,
        row: &mut [f32],
    ) -> Result<(), RobotError> {
        let spec = self.observation();
        let ObservationScratch { prior, key_bodies } = scratch;
        let mut measured = *measured;
        if !spec.key_bodies.is_empty() && measured.key_bodies_w.is_none() {
            measured.key_bodies_w = Some(key_bodies.places(&self.robot, &measured, &history.joint_offset));
        }
        let latent = match (spec.reference.latent, reference.latent(), self.prior()) {
            (0, ..) => &[][..],
            (_, Some(latent), _) => latent,
            (_, None, Some(encoder)) => encoder.encode_around(reference, prior),
            (wanted, None, None) => {
                let expected = format!("{wanted} numbers, or a controller with the encoder of its motion prior");
                return Err(RobotError::mismatch("latent code of the reference", expected, "none"));
            }
        };
        spec.write(
            &ObservationInputs {
                past: history.memory.past(),
                measured: &measured,
                joint_offset: &history.joint_offset,
                last_action: &history.last,
                action_before: &history.before,
                reference,
                alignment: history.alignment,
                latent,
            },
            row,
        )?;
        history.memory.recall(spec, &self.remembered, row);
        Ok(())
    }

    /// Writes the policy's outputs `[N, J]` for observations `[N, O]`, which are normalised in place.
    ///
    /// # Panics
    /// `rows` is no multiple of the observation's length, or `out` has the wrong length.
    pub fn outputs(&self, rows: &mut [f32], work: &mut PolicyWorkspace, out: &mut [f32]) {
        self.file.policy().outputs(rows, work, out);
    }

    /// Writes joint targets (rad, `[J]`) for the policy's output, and remembers it.
    ///
    /// # Errors
    /// An array has the wrong length.
    pub fn act(
        &self,
        history: &mut History,
        reference: &dyn ReferenceStream,
        output: &[f32],
        targets: &mut [f32],
    ) -> Result<(), RobotError> {
        let joints = self.robot.joints();
        if output.len() != joints || targets.len() != joints {
            let expected = format!("{joints} and {joints}");
            let got = format!("{} and {}", output.len(), targets.len());
            return Err(RobotError::mismatch("lengths of outputs and joint targets", expected, got));
        }
        history.remember(self.actions.spec, output);
        self.actions.write(&history.last, self.target_joints(reference), targets);
        targets.iter_mut().zip(&history.joint_offset).for_each(|(target, offset)| *target -= offset);
        Ok(())
    }

    /// Joint positions of the frame to reach.
    fn target_joints<'a>(&self, reference: &'a dyn ReferenceStream) -> &'a [f32] {
        let frame = reference.around(0);
        frame.get(self.robot.layout.joint_positions()).unwrap_or_default()
    }
}
