//! Many environments of one robot in physics, their outputs as numpy views.

use std::sync::{Arc, Mutex, PoisonError};

use lifelike_robot::nearest::hint;
use lifelike_robot::{FromInput, Robot as Character, RobotError};
use lifelike_sim::{BatchState, Drive, EnvironmentParameters, IntegrationState, SimulationSpec};
use numpy::{Element, PyArrayDyn};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arrays::{Floats, Numbers, numbers, vector, view};
use crate::error::{Error, Raise};
use crate::robot::{Robot, RobotLike};

/// `environments` copies of a robot, stepped together at the policy's rate.
///
/// The arrays of the state are read-only views over the engine's memory, float32, one row per environment. Every step and
/// reset writes new values into them; copy what has to stay. A view keeps its simulation alive.
/// `engine` is `lifelike`, or `mujoco` after `lifelike fetch mujoco`. `threads` 0 is one per processor; results do not depend on it.
///
/// Methods release the GIL while physics runs. A second thread that uses the same object meanwhile gets `RuntimeError`.
/// Views that it already has may then be read, but mix values of two steps.
/// Raises `Error` for a robot that the engine cannot simulate.
#[pyclass(module = "lifelike")]
pub struct Simulation {
    /// The lock makes the class `Sync`; Python's own borrow is the one that excludes other threads.
    inner: Mutex<Box<dyn lifelike_sim::Simulation>>,
    robot: Arc<Character>,
    environments: usize,
}

/// Saved state of a simulation.
#[pyclass(frozen, module = "lifelike")]
pub struct SavedState(IntegrationState);

impl Simulation {
    fn inner(&mut self) -> &mut Box<dyn lifelike_sim::Simulation> {
        self.inner.get_mut().unwrap_or_else(PoisonError::into_inner)
    }

    /// Returns an output as a view. Its rows are split by `tail`: `[N, width]` for none, else `[N, width / tail, tail]`.
    fn output<'py, T: Element>(
        slf: Bound<'py, Self>,
        of: impl Fn(&BatchState) -> &[T],
        tail: Option<usize>,
    ) -> PyResult<Bound<'py, PyArrayDyn<T>>> {
        let this = slf.try_borrow()?;
        let inner = this.inner.lock().unwrap_or_else(PoisonError::into_inner);
        let values = of(inner.state());
        let width = values.len() / this.environments;
        let shape = match tail {
            None => vec![this.environments, width],
            Some(tail) => vec![this.environments, width / tail, tail],
        };
        // SAFETY: a simulation's state is allocated with it and never resized (`Batched`), and the box never changes.
        unsafe { view(slf.clone().into_any(), values, &shape) }
    }

    fn environment(&self, index: usize) -> PyResult<usize> {
        let n = self.environments;
        if index < n {
            Ok(index)
        } else {
            Err(Error::new_err(format!("environment: expected 0 to {}, got {index}", n - 1)))
        }
    }
}

#[pymethods]
impl Simulation {
    #[new]
    #[pyo3(signature = (robot, environments=1, *, engine="lifelike", threads=0))]
    fn new(py: Python<'_>, robot: RobotLike<'_>, environments: usize, engine: &str, threads: usize) -> PyResult<Self> {
        if environments == 0 {
            return Err(Error::new_err("environments: expected at least 1, got 0"));
        }
        let robot = robot.load()?;
        let spec = SimulationSpec { engine: engine.parse().or_raise()?, environments, threads, terrain: None };
        let inner = py.detach(|| spec.build(Arc::clone(&robot))).or_raise()?;
        Ok(Self { inner: Mutex::new(inner), robot, environments })
    }

    fn __len__(&self) -> usize {
        self.environments
    }

    /// Robot of the simulation.
    #[getter]
    fn robot(&self) -> Robot {
        Robot(Arc::clone(&self.robot))
    }

    /// Root position, `[N, 3]` (m, world); a view.
    #[getter]
    fn root_position(slf: Bound<'_, Self>) -> PyResult<Floats<'_>> {
        Self::output(slf, |state| &state.root_position, None)
    }

    /// Root orientation, `[N, 4]` (`wxyz`); a view.
    #[getter]
    fn root_orientation(slf: Bound<'_, Self>) -> PyResult<Floats<'_>> {
        Self::output(slf, |state| &state.root_orientation, None)
    }

    /// Root linear velocity, `[N, 3]` (m/s, world); a view.
    #[getter]
    fn linear_velocity_w(slf: Bound<'_, Self>) -> PyResult<Floats<'_>> {
        Self::output(slf, |state| &state.linear_velocity_w, None)
    }

    /// Root angular velocity, `[N, 3]` (rad/s, world); a view.
    #[getter]
    fn angular_velocity_w(slf: Bound<'_, Self>) -> PyResult<Floats<'_>> {
        Self::output(slf, |state| &state.angular_velocity_w, None)
    }

    /// Joint positions, `[N, J]` (rad); a view.
    #[getter]
    fn joint_position(slf: Bound<'_, Self>) -> PyResult<Floats<'_>> {
        Self::output(slf, |state| &state.joint_position, None)
    }

    /// Joint velocities, `[N, J]` (rad/s); a view.
    #[getter]
    fn joint_velocity(slf: Bound<'_, Self>) -> PyResult<Floats<'_>> {
        Self::output(slf, |state| &state.joint_velocity, None)
    }

    /// End effectors, then key bodies, `[N, P, 3]` (m, world); a view.
    #[getter]
    fn site_position(slf: Bound<'_, Self>) -> PyResult<Floats<'_>> {
        Self::output(slf, |state| &state.site_position, Some(3))
    }

    /// Body positions, `[N, B, 3]` (m, world); a view.
    #[getter]
    fn body_position(slf: Bound<'_, Self>) -> PyResult<Floats<'_>> {
        Self::output(slf, |state| &state.body_position, Some(3))
    }

    /// Body orientations, `[N, B, 4]` (`wxyz`); a view.
    #[getter]
    fn body_orientation(slf: Bound<'_, Self>) -> PyResult<Floats<'_>> {
        Self::output(slf, |state| &state.body_orientation, Some(4))
    }

    /// Actuator torque at the last substep, `[N, J]` (N m); a view.
    #[getter]
    fn torque(slf: Bound<'_, Self>) -> PyResult<Floats<'_>> {
        Self::output(slf, |state| &state.torque, None)
    }

    /// Normal ground force on each foot at the last substep, `[N, F]` (N); a view.
    #[getter]
    fn foot_force(slf: Bound<'_, Self>) -> PyResult<Floats<'_>> {
        Self::output(slf, |state| &state.foot_force, None)
    }

    /// Environments that diverged in the last step, `[N]` bool; they are frozen until a reset. A view.
    #[getter]
    fn diverged(slf: Bound<'_, Self>) -> PyResult<Bound<'_, PyAny>> {
        Self::output(slf, |state| &state.diverged, None)?.call_method1("reshape", (-1,))
    }

    /// Puts environments into a state and clears pushes. Without arguments all of them get the default pose at rest.
    ///
    /// `environments` are indices, `[K]`; all where not given. `qpos [K, nq]` and `qvel [K, nv]` are in MuJoCo's layout.
    /// Raises `Error` for other shapes, unknown indices and numbers that are not finite.
    #[pyo3(signature = (environments=None, qpos=None, qvel=None))]
    fn reset(
        &mut self,
        py: Python<'_>,
        environments: Option<Vec<usize>>,
        qpos: Option<Numbers<'_, f64>>,
        qvel: Option<Numbers<'_, f64>>,
    ) -> PyResult<()> {
        let ids = environments.unwrap_or_else(|| (0..self.environments).collect());
        let (nq, nv) = (self.robot.character.nq, self.robot.character.nv);
        let qpos = match qpos {
            Some(qpos) => numbers("qpos", &qpos, &[ids.len(), nq])?,
            None => self.robot.default_position().repeat(ids.len()),
        };
        let qvel = match qvel {
            Some(qvel) => numbers("qvel", &qvel, &[ids.len(), nv])?,
            None => vec![0.0; ids.len() * nv],
        };
        let inner = self.inner();
        py.detach(|| inner.reset(&ids, &qpos, &qvel)).or_raise()
    }

    /// Makes one policy step under joint targets `[N, J]` (rad), or under joint torques `[N, J]` (N m).
    ///
    /// Raises `Error` for another shape, and unless exactly one of them is given.
    #[pyo3(signature = (targets=None, *, torques=None))]
    fn step(
        &mut self,
        py: Python<'_>,
        targets: Option<Numbers<'_, f32>>,
        torques: Option<Numbers<'_, f32>>,
    ) -> PyResult<()> {
        let shape = [self.environments, self.robot.joints()];
        let inner = self.inner.get_mut().unwrap_or_else(PoisonError::into_inner);
        match (targets, torques) {
            (Some(targets), None) => {
                let targets = numbers("targets", &targets, &shape)?;
                py.detach(|| inner.step(Drive::Targets(&targets))).or_raise()
            }
            (None, Some(torques)) => {
                let torques = numbers("torques", &torques, &shape)?;
                py.detach(|| inner.step(Drive::Torques(&torques))).or_raise()
            }
            _ => Err(Error::new_err("step: expected either targets or torques")),
        }
    }

    /// Applies a force and a torque (N, N m, world) to a body's centre of mass until `clear_pushes`.
    ///
    /// Raises `Error` for an unknown environment or body.
    #[pyo3(signature = (environment, body, force, torque=None))]
    fn push(
        &mut self,
        environment: usize,
        body: &str,
        force: Numbers<'_, f32>,
        torque: Option<Numbers<'_, f32>>,
    ) -> PyResult<()> {
        let bodies = &self.robot.character.bodies;
        let unknown = || {
            RobotError::mismatch(
                "body",
                format!("one of robot '{}'", self.robot.name),
                format!("'{body}'{}", hint(body, bodies.iter().map(|body| body.name.as_str()))),
            )
        };
        let body = bodies.iter().position(|known| known.name == body).ok_or_else(unknown).or_raise()?;
        let force = vector("force", &force)?;
        let torque = torque.map_or(Ok([0.0; 3]), |torque| vector("torque", &torque))?;
        self.inner().push(environment, body, force, torque).or_raise()
    }

    /// Ends all pushes on an environment.
    fn clear_pushes(&mut self, environment: usize) -> PyResult<()> {
        let environment = self.environment(environment)?;
        self.inner().clear_pushes(environment);
        Ok(())
    }

    /// Changes parameters of an environment, such as `mass_scale=[...]`, `ground_friction=0.6` or `gravity=[0, 0, -9]`.
    ///
    /// The names are those of the Rust type `EnvironmentParameters`; all others return to the model's values.
    /// Raises `Error` for unknown names, wrong lengths and values out of range.
    #[pyo3(signature = (environment, **parameters))]
    fn set_parameters(
        &mut self,
        py: Python<'_>,
        environment: usize,
        parameters: Option<Bound<'_, PyDict>>,
    ) -> PyResult<()> {
        let parameters = parameters.unwrap_or_else(|| PyDict::new(py));
        let text: String = py.import("json")?.call_method1("dumps", (parameters,))?.extract()?;
        let parameters: EnvironmentParameters = serde_json::from_str(&text).or_raise()?;
        let inner = self.inner();
        py.detach(|| inner.set_parameters(environment, parameters)).or_raise()
    }

    /// Returns everything from which the simulation continues bit for bit.
    fn save(&mut self) -> SavedState {
        SavedState(self.inner().save())
    }

    /// Returns to a saved state. Raises `Error` for a state of another engine, robot or number of environments.
    fn restore(&mut self, py: Python<'_>, state: &SavedState) -> PyResult<()> {
        let inner = self.inner();
        py.detach(|| inner.restore(&state.0)).or_raise()
    }
}
