//! A robot by name or file.

use std::path::PathBuf;
use std::sync::Arc;

use lifelike_robot::ActuatorParameters;
use pyo3::prelude::*;

use crate::arrays::{Doubles, Numbers, array, numbers, plain};
use crate::error::{Raise, show_warnings};

/// A robot, ready to be simulated, trained and run. It never changes.
///
/// `name` is a built-in robot (`lima`, `humanoid`), a fetched one (`g1`), or the path of an MJCF or URDF file.
/// Raises `Error` for anything else, with the nearest name, and for files that cannot be read.
#[pyclass(frozen, module = "lifelike")]
pub struct Robot(pub Arc<lifelike_robot::Robot>);

/// A robot, or its name or file.
#[derive(FromPyObject)]
pub enum RobotLike<'py> {
    /// A robot.
    Robot(PyRef<'py, Robot>),
    /// Its name or file.
    Name(PathBuf),
}

impl RobotLike<'_> {
    /// Returns the robot, loaded where it is only named.
    pub fn load(self) -> PyResult<Arc<lifelike_robot::Robot>> {
        show_warnings();
        match self {
            Self::Robot(robot) => Ok(Arc::clone(&robot.0)),
            Self::Name(name) => Ok(Arc::new(lifelike_robot::Robot::load(&name.to_string_lossy()).or_raise()?)),
        }
    }
}

impl Robot {
    /// Returns a number of each actuator, `[J]`.
    fn of_actuators<'py>(
        &self,
        py: Python<'py>,
        value: impl Fn(usize, &ActuatorParameters) -> f64,
    ) -> PyResult<Doubles<'py>> {
        let parameters = self.0.actuators.parameters.iter().enumerate();
        let values: Vec<f64> = parameters.map(|(joint, actuator)| value(joint, actuator)).collect();
        array(py, &values, &[values.len()])
    }
}

#[pymethods]
impl Robot {
    #[new]
    fn new(name: PathBuf) -> PyResult<Self> {
        RobotLike::Name(name).load().map(Self)
    }

    fn __repr__(&self) -> String {
        format!("Robot('{}', {} joints, {:.2} kg)", self.0.name, self.0.joints(), self.0.character.mass())
    }

    /// Name of the robot.
    #[getter]
    fn name(&self) -> &str {
        &self.0.name
    }

    /// Names of the scalar joints, `[J]`: the order of every array with a joint axis.
    #[getter]
    fn joint_names(&self) -> Vec<String> {
        self.0.layout.joints.clone()
    }

    /// Names of the bodies, `[B]`; the world is first.
    #[getter]
    fn body_names(&self) -> Vec<String> {
        self.0.character.bodies.iter().map(|body| body.name.clone()).collect()
    }

    /// Names of the end effectors.
    #[getter]
    fn end_effectors(&self) -> Vec<String> {
        self.0.layout.end_effectors.clone()
    }

    /// Default pose, `[J]` (rad).
    #[getter]
    fn default_pose<'py>(&self, py: Python<'py>) -> PyResult<Doubles<'py>> {
        array(py, &self.0.default_pose, &[self.0.joints()])
    }

    /// Generalised position of the default pose, `[nq]`, in MuJoCo's layout (m, quaternion `wxyz`, rad).
    #[getter]
    fn default_qpos<'py>(&self, py: Python<'py>) -> PyResult<Doubles<'py>> {
        array(py, &self.0.default_position(), &[self.0.character.nq])
    }

    /// Proportional gains of the actuators, `[J]` (N m/rad).
    #[getter]
    fn kp<'py>(&self, py: Python<'py>) -> PyResult<Doubles<'py>> {
        self.of_actuators(py, |_, actuator| actuator.kp)
    }

    /// Derivative gains of the actuators, `[J]` (N m s/rad).
    #[getter]
    fn kd<'py>(&self, py: Python<'py>) -> PyResult<Doubles<'py>> {
        self.of_actuators(py, |_, actuator| actuator.kd)
    }

    /// Largest torques, `[J]` (N m).
    #[getter]
    fn torque_limit<'py>(&self, py: Python<'py>) -> PyResult<Doubles<'py>> {
        self.of_actuators(py, |_, actuator| actuator.torque_max)
    }

    /// Largest speeds, `[J]` (rad/s); infinite where nothing limits them.
    #[getter]
    fn velocity_limit<'py>(&self, py: Python<'py>) -> PyResult<Doubles<'py>> {
        self.of_actuators(py, |_, actuator| actuator.velocity_max)
    }

    /// Rotor inertias of the joints, `[J]` (kg m²): those of the profile where it has them, else of the model.
    #[getter]
    fn armature<'py>(&self, py: Python<'py>) -> PyResult<Doubles<'py>> {
        let values: Vec<f64> = self.0.character.scalar_joints().map(|joint| joint.armature).collect();
        array(py, &values, &[values.len()])
    }

    /// Returns the motor torques, `[J]` (N m): a PD controller with the limits of thesis eq. 4.11, without friction.
    ///
    /// All arguments are `[J]`: targets and positions in rad, velocities in rad/s. Raises `Error` for other shapes.
    fn motor_torque<'py>(
        &self,
        py: Python<'py>,
        targets: Numbers<'py, f64>,
        joint_position: Numbers<'py, f64>,
        joint_velocity: Numbers<'py, f64>,
    ) -> PyResult<Doubles<'py>> {
        let shape = [self.0.joints()];
        let targets = numbers("targets", &targets, &shape)?;
        let position = numbers("joint_position", &joint_position, &shape)?;
        let velocity = numbers("joint_velocity", &joint_velocity, &shape)?;
        self.of_actuators(py, |i, actuator| actuator.motor_torque(targets[i], position[i], velocity[i]))
    }

    /// Returns the actuators' friction as damping at these velocities, `[J]` (N m s/rad), to be integrated implicitly.
    ///
    /// Velocities are `[J]` (rad/s). Raises `Error` for another shape.
    fn friction_damping<'py>(&self, py: Python<'py>, joint_velocity: Numbers<'py, f64>) -> PyResult<Doubles<'py>> {
        let velocity = numbers("joint_velocity", &joint_velocity, &[self.0.joints()])?;
        self.of_actuators(py, |i, actuator| actuator.friction_damping(velocity[i]))
    }

    /// Policy rate (Hz).
    #[getter]
    fn control_hz(&self) -> f64 {
        self.0.control_hz
    }

    /// Physics steps per policy step.
    #[getter]
    fn substeps(&self) -> usize {
        self.0.substeps
    }

    /// Physics time step (s).
    #[getter]
    fn timestep(&self) -> f64 {
        self.0.timestep()
    }

    /// Total mass (kg).
    #[getter]
    fn mass(&self) -> f64 {
        self.0.character.mass()
    }

    /// Number of generalised positions.
    #[getter]
    fn nq(&self) -> usize {
        self.0.character.nq
    }

    /// Number of generalised velocities.
    #[getter]
    fn nv(&self) -> usize {
        self.0.character.nv
    }

    /// MJCF text of the model; `None` for a robot from a URDF file.
    #[getter]
    fn mjcf(&self) -> Option<&str> {
        self.0.character.mjcf.as_deref()
    }

    /// Guesses where no profile says otherwise, and repairs of the file; one sentence each.
    #[getter]
    fn notes(&self) -> Vec<String> {
        self.0.notes.iter().chain(&self.0.character.warnings).cloned().collect()
    }

    /// Returns the mistakes of convention in a clip (quaternion order, units, axes, rate), and the corrected clip.
    ///
    /// Each mistake is a dictionary with `mistake`, `evidence` and `confidence`. Raises `Error` for another robot's clip.
    fn lint<'py>(&self, py: Python<'py>, clip: &crate::clip::Clip) -> PyResult<(Bound<'py, PyAny>, crate::clip::Clip)> {
        let (character, anatomy) = (&self.0.character, &self.0.anatomy);
        let (fixed, flaws) = py.detach(|| lifelike_motion::lint::lint(&clip.0, character, anatomy)).or_raise()?;
        Ok((plain(py, &flaws)?, crate::clip::Clip(fixed)))
    }

    /// Returns what rules a clip out without physics: a dictionary with `trackable` and `findings`.
    ///
    /// Raises `Error` for another robot's clip.
    fn check<'py>(&self, py: Python<'py>, clip: &crate::clip::Clip) -> PyResult<Bound<'py, PyAny>> {
        let (robot, speeds) = (&self.0, self.0.speeds());
        let check = || lifelike_motion::feasibility::check(&clip.0, &robot.character, &robot.anatomy, &speeds);
        plain(py, &py.detach(check).or_raise()?)
    }
}
