//! A controller, and one robot's run of it.

use std::path::PathBuf;
use std::sync::Arc;

use lifelike::commands::controller_file::Loaded;
use lifelike_robot::controller::PolicyWorkspace;
use lifelike_robot::{ClipPlayer, ControllerState, MeasuredState, ReferenceLibrary};
use numpy::PyUntypedArrayMethods;
use pyo3::prelude::*;

use crate::arrays::{Doubles, Floats, Numbers, array, numbers, vector};
use crate::clip::Clip;
use crate::error::{Error, Raise, show_warnings};
use crate::robot::{Robot, RobotLike};

/// A trained controller for one robot. It never changes; `follow` begins a run of it.
///
/// `policy` is the name of a controller that comes with the package (`lima`, `humanoid`, `g1`, `toddlerbot`), or a
/// path. It leads to a `*.controller.safetensors` file, or to the folder of a training run. Without `robot` it is for
/// the robot that it was trained for. Raises `Error` where the golden vectors of the file are not reproduced, and for another robot.
#[pyclass(frozen, module = "lifelike")]
pub struct Controller(pub Arc<Loaded>);

#[pymethods]
impl Controller {
    #[new]
    #[pyo3(signature = (policy, robot=None))]
    fn new(py: Python<'_>, policy: PathBuf, robot: Option<RobotLike<'_>>) -> PyResult<Self> {
        show_warnings();
        let loaded = match robot {
            None => py.detach(|| Loaded::load(&policy, None, None)),
            Some(robot) => {
                let robot = robot.load()?;
                py.detach(|| Loaded::for_robot(&policy, &robot, None))
            }
        };
        Ok(Self(Arc::new(loaded.or_raise()?)))
    }

    fn __repr__(&self) -> String {
        let header = self.0.controller.header();
        format!("Controller for '{}', {} inputs at {} Hz", header.robot, header.observation.size(), header.control_hz)
    }

    /// Robot of the controller, its joints in the controller's order.
    #[getter]
    fn robot(&self) -> Robot {
        Robot(Arc::clone(self.0.controller.robot()))
    }

    /// Length of an observation O.
    #[getter]
    fn observation_size(&self) -> usize {
        self.0.controller.observation().size()
    }

    /// Parts of an observation with their sizes, in order.
    #[getter]
    fn observation_parts(&self) -> Vec<(String, usize)> {
        self.0.controller.header().parts.clone()
    }

    /// Returns the policy's outputs, `[N, J]`, for observations `[N, O]` that are not normalised.
    ///
    /// Raises `Error` for another shape.
    fn outputs<'py>(&self, py: Python<'py>, observations: Numbers<'py, f32>) -> PyResult<Floats<'py>> {
        let controller = &self.0.controller;
        let rows = observations.shape().first().copied().unwrap_or(0);
        let mut observations = numbers("observations", &observations, &[rows, controller.observation().size()])?;
        let mut outputs = vec![0.0; rows * controller.robot().joints()];
        py.detach(|| controller.outputs(&mut observations, &mut PolicyWorkspace::batched(), &mut outputs));
        array(py, &outputs, &[rows, controller.robot().joints()])
    }

    /// Begins a run that follows a clip from a time on (s). Raises `Error` for a clip of another robot or a time outside of it.
    #[pyo3(signature = (clip, start=0.0))]
    fn follow(&self, py: Python<'_>, clip: &Clip, start: f64) -> PyResult<ControllerRun> {
        let controller = &self.0.controller;
        let clips = std::slice::from_ref(&clip.0);
        let library = py.detach(|| ReferenceLibrary::new(controller.robot(), clips, self.0.encoder())).or_raise()?;
        let library = Arc::new(library);
        let frame = (start * controller.robot().control_hz).round();
        if !(frame >= 0.0 && frame < library.len() as f64) {
            return Err(Error::new_err(format!("start: expected 0 to {:.2} s, got {start}", clip.0.seconds())));
        }
        Ok(ControllerRun {
            loaded: Arc::clone(&self.0),
            state: ControllerState::new(controller),
            player: ClipPlayer::new(Arc::clone(&library), frame as usize),
            library,
            targets: vec![0.0; controller.robot().joints()],
        })
    }
}

/// One robot that follows a clip: history of actions, alignment of the reference, present frame.
#[pyclass(module = "lifelike")]
pub struct ControllerRun {
    loaded: Arc<Loaded>,
    state: ControllerState,
    library: Arc<ReferenceLibrary>,
    player: ClipPlayer<Arc<ReferenceLibrary>>,
    targets: Vec<f32>,
}

#[pymethods]
impl ControllerRun {
    /// Returns joint targets, `[J]` (rad), for a measured state, and advances the reference by one step.
    ///
    /// `joint_position [J]` (rad), `joint_velocity [J]` (rad/s), `root_orientation [4]` (`wxyz`),
    /// `angular_velocity_w [3]` (rad/s, world), `root_position [3]` (m, world), `linear_velocity_w [3]` (m/s, world).
    /// The first step places the clip at the robot. Raises `Error` for other shapes, and where the policy needs
    /// a quantity that is not given.
    #[pyo3(signature = (joint_position, joint_velocity, root_orientation, angular_velocity_w, root_position=None, linear_velocity_w=None))]
    #[allow(clippy::too_many_arguments)]
    fn step<'py>(
        &mut self,
        py: Python<'py>,
        joint_position: Numbers<'py, f32>,
        joint_velocity: Numbers<'py, f32>,
        root_orientation: Numbers<'py, f32>,
        angular_velocity_w: Numbers<'py, f32>,
        root_position: Option<Numbers<'py, f32>>,
        linear_velocity_w: Option<Numbers<'py, f32>>,
    ) -> PyResult<Floats<'py>> {
        let joints = [self.targets.len()];
        let measured = MeasuredState {
            joint_position: &numbers("joint_position", &joint_position, &joints)?,
            joint_velocity: &numbers("joint_velocity", &joint_velocity, &joints)?,
            root_orientation: vector("root_orientation", &root_orientation)?,
            angular_velocity_w: vector("angular_velocity_w", &angular_velocity_w)?,
            root_position: root_position.map(|p| vector("root_position", &p)).transpose()?,
            linear_velocity_w: linear_velocity_w.map(|v| vector("linear_velocity_w", &v)).transpose()?,
            root_height: None,
            key_bodies_w: None,
        };
        let Self { loaded, state, player, targets, .. } = self;
        loaded.controller.step(state, &measured, player, targets).or_raise()?;
        array(py, targets, &joints)
    }

    /// Returns the state of the present frame in MuJoCo's layout, `[nq]` and `[nv]`, to begin physics in.
    ///
    /// The root is above the origin, as in `lifelike eval`.
    fn reference_state<'py>(&self, py: Python<'py>) -> PyResult<(Doubles<'py>, Doubles<'py>)> {
        let robot = self.loaded.controller.robot();
        let (mut q, mut v) = (vec![0.0; robot.character.nq], vec![0.0; robot.character.nv]);
        self.library.write_state(self.player.frame(), robot, [0.0; 2], 0.0, &mut q, &mut v);
        Ok((array(py, &q, &[q.len()])?, array(py, &v, &[v.len()])?))
    }

    /// Joint positions of the present frame of the reference, `[J]` (rad).
    #[getter]
    fn reference_joints<'py>(&self, py: Python<'py>) -> PyResult<Floats<'py>> {
        let joints = self.library.joints_at(self.player.frame());
        array(py, joints, &[joints.len()])
    }

    /// Last observation, normalised, `[O]`.
    #[getter]
    fn observation<'py>(&self, py: Python<'py>) -> PyResult<Floats<'py>> {
        let row = self.state.observation();
        array(py, row, &[row.len()])
    }

    /// Present frame of the clip at the policy's rate.
    #[getter]
    fn frame(&self) -> usize {
        self.player.frame()
    }

    /// True at the last frame of the clip.
    #[getter]
    fn is_over(&self) -> bool {
        self.player.is_over()
    }
}
