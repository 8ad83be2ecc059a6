//! The contract of every engine: N environments of one robot, stepped together.

use std::sync::Arc;

use lifelike_robot::Robot;

use crate::batch::{BatchState, EnvironmentParameters, IntegrationState};
use crate::constraint_wrenches::ConstraintWrenches;
use crate::error::SimError;
use crate::terrain::Terrain;

/// Joint commands of one step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Drive<'a> {
    /// Joint targets (rad), `[N, J]`; the engine evaluates the actuator model (eqs. 4.9-4.11) at every physics substep.
    Targets(&'a [f32]),
    /// Joint torques (N m), `[N, J]`, applied as they are.
    Torques(&'a [f32]),
}

impl<'a> Drive<'a> {
    /// Returns the numbers, whatever they mean.
    pub fn values(&self) -> &'a [f32] {
        match self {
            Self::Targets(values) | Self::Torques(values) => values,
        }
    }

    /// Returns other numbers of the same meaning, such as those of one environment.
    #[must_use]
    pub fn with_values<'b>(&self, values: &'b [f32]) -> Drive<'b> {
        match self {
            Self::Targets(_) => Drive::Targets(values),
            Self::Torques(_) => Drive::Torques(values),
        }
    }
}

/// N environments of one robot on level or uneven ground.
///
/// Every method that takes environments by index gives the same result for any number of threads.
///
/// ```
/// use std::sync::Arc;
/// use lifelike_robot::Robot;
/// use lifelike_sim::{Drive, Simulation, SimulationSpec};
///
/// let robot = Arc::new(Robot::load("lima")?);
/// let mut simulation = SimulationSpec::new(4).build(robot.clone())?;
/// let targets: Vec<f32> = robot.default_pose.iter().map(|&q| q as f32).collect();
/// simulation.push(2, 1, [20.0, 0.0, 0.0], [0.0; 3])?;
/// for _ in 0..10 {
///     simulation.step(Drive::Targets(&targets.repeat(4)))?;
/// }
/// let saved = simulation.save();
/// assert!(simulation.state().root_position[3 * 2] > simulation.state().root_position[0]);
///
/// // Restoring continues bit for bit.
/// simulation.step(Drive::Targets(&targets.repeat(4)))?;
/// let expected = simulation.state().clone();
/// simulation.restore(&saved)?;
/// simulation.step(Drive::Targets(&targets.repeat(4)))?;
/// assert_eq!(*simulation.state(), expected);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub trait Simulation: Send {
    /// Returns the engine's name, such as `mujoco`: saved states carry it.
    fn engine(&self) -> &str;

    /// Returns the robot.
    fn robot(&self) -> &Arc<Robot>;

    /// Returns the number of environments N.
    fn len(&self) -> usize;

    /// Returns the uneven ground that all of them stand on; `None`: level ground at height 0.
    fn terrain(&self) -> Option<&Arc<Terrain>> {
        None
    }

    /// Returns true when there are no environments.
    fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Returns the state after the last step or reset.
    fn state(&self) -> &BatchState;

    /// Puts some environments into given states and clears forces, warm starts and divergence.
    ///
    /// # Shapes
    /// `positions: [ids, nq]`, `velocities: [ids, nv]` in MuJoCo's layout (see `character::model`).
    ///
    /// # Errors
    /// Another number of values, an environment that does not exist, values that are not finite.
    fn reset(&mut self, ids: &[usize], positions: &[f64], velocities: &[f64]) -> Result<(), SimError>;

    /// Changes the parameters of one environment, from the next step on.
    ///
    /// # Errors
    /// Lists of the wrong length and factors out of range; nothing changes then.
    fn set_parameters(&mut self, id: usize, parameters: EnvironmentParameters) -> Result<(), SimError>;

    /// Applies a force (N, world) and torque (N m, world) to the centre of mass of a body until changed again: a push.
    ///
    /// # Errors
    /// An environment or a body that does not exist, and values that are not finite.
    fn push(&mut self, id: usize, body: usize, force_w: [f32; 3], torque_w: [f32; 3]) -> Result<(), SimError>;

    /// Ends all pushes on one environment.
    fn clear_pushes(&mut self, id: usize);

    /// Makes one policy step, `robot.substeps` physics steps, of every environment that is not frozen.
    ///
    /// # Errors
    /// [`SimError::Length`] for a drive of another size.
    fn step(&mut self, drive: Drive<'_>) -> Result<(), SimError>;

    /// Returns the forces that hold the bodies together in the present state under a drive. They are those of MuJoCo's
    /// `mj_rnePostConstraint` after `mj_forward` (damping is not yet taken implicitly): what a trace for thesis
    /// chapter 2 records beside [`Self::state`]. Nothing changes.
    ///
    /// # Errors
    /// [`SimError::Length`] for a drive of another size.
    fn constraint_wrenches(&mut self, drive: Drive<'_>) -> Result<ConstraintWrenches, SimError>;

    /// Returns everything needed to continue bit for bit.
    fn save(&self) -> IntegrationState;

    /// Goes back to a saved state; [`Self::state`] is as it was then, except the outputs of the last step (torques, forces).
    ///
    /// # Errors
    /// A state of another engine, robot or number of environments.
    fn restore(&mut self, state: &IntegrationState) -> Result<(), SimError>;
}

impl<S: Simulation + ?Sized> Simulation for Box<S> {
    fn engine(&self) -> &str {
        (**self).engine()
    }
    fn robot(&self) -> &Arc<Robot> {
        (**self).robot()
    }
    fn len(&self) -> usize {
        (**self).len()
    }
    fn terrain(&self) -> Option<&Arc<Terrain>> {
        (**self).terrain()
    }
    fn state(&self) -> &BatchState {
        (**self).state()
    }
    fn reset(&mut self, ids: &[usize], positions: &[f64], velocities: &[f64]) -> Result<(), SimError> {
        (**self).reset(ids, positions, velocities)
    }
    fn set_parameters(&mut self, id: usize, parameters: EnvironmentParameters) -> Result<(), SimError> {
        (**self).set_parameters(id, parameters)
    }
    fn push(&mut self, id: usize, body: usize, force_w: [f32; 3], torque_w: [f32; 3]) -> Result<(), SimError> {
        (**self).push(id, body, force_w, torque_w)
    }
    fn clear_pushes(&mut self, id: usize) {
        (**self).clear_pushes(id);
    }
    fn step(&mut self, drive: Drive<'_>) -> Result<(), SimError> {
        (**self).step(drive)
    }
    fn constraint_wrenches(&mut self, drive: Drive<'_>) -> Result<ConstraintWrenches, SimError> {
        (**self).constraint_wrenches(drive)
    }
    fn save(&self) -> IntegrationState {
        (**self).save()
    }
    fn restore(&mut self, state: &IntegrationState) -> Result<(), SimError> {
        (**self).restore(state)
    }
}
