//! Motion of a robot: loading, retargeting, arrays.

use std::path::PathBuf;

use lifelike::overrides;
use lifelike_character::rotation::from_wxyz;
use lifelike_motion::formats::{self, FileMotion, ReadOptions};
use lifelike_motion::retarget::source_of_robot;
use lifelike_motion::{MotionClip, container};
use lifelike_robot::clips;
use pyo3::prelude::*;

use crate::arrays::{Doubles, Numbers, array, numbers, plain};
use crate::error::{Error, Raise};
use crate::robot::RobotLike;

/// A motion of one robot at a constant rate. `T` frames, `J` joints by name.
///
/// Arguments: `root_position [T, 3]` (m), `root_orientation [T, 4]` (`wxyz`), `joints [T, J]` (rad), `joint_names`,
/// `fps` (Hz). Arrays are copied. Raises `Error` for shapes that do not fit, numbers that are not finite and quaternions
/// of length zero.
#[pyclass(frozen, module = "lifelike")]
pub struct Clip(pub MotionClip);

#[pymethods]
impl Clip {
    #[new]
    #[pyo3(signature = (name, fps, joint_names, root_position, root_orientation, joints))]
    fn new(
        name: String,
        fps: f64,
        joint_names: Vec<String>,
        root_position: Numbers<'_, f64>,
        root_orientation: Numbers<'_, f64>,
        joints: Numbers<'_, f64>,
    ) -> PyResult<Self> {
        use numpy::PyUntypedArrayMethods;
        let frames = root_position.shape().first().copied().unwrap_or(0);
        let position = numbers("root_position", &root_position, &[frames, 3])?;
        let orientation = numbers("root_orientation", &root_orientation, &[frames, 4])?;
        let joints = numbers("joints", &joints, &[frames, joint_names.len()])?;
        let turn = |(frame, q): (usize, &[f64; 4])| {
            let unusable = || Error::new_err(format!("root_orientation: frame {frame} is no quaternion: {q:?}"));
            from_wxyz(*q).ok_or_else(unusable)
        };
        let clip = MotionClip {
            name,
            fps,
            joint_names,
            root_position: position.as_chunks::<3>().0.iter().map(|p| (*p).into()).collect(),
            root_orientation: orientation.as_chunks().0.iter().enumerate().map(turn).collect::<PyResult<_>>()?,
            joints,
            contacts: None,
            cyclic: false,
            provenance: Default::default(),
        };
        clip.check().or_raise()?;
        Ok(Self(clip))
    }

    /// Reads a `*.motion.safetensors` file. Raises `Error` where it cannot be read.
    #[staticmethod]
    fn load(path: PathBuf) -> PyResult<Self> {
        Ok(Self(container::read(&path).or_raise()?))
    }

    /// Writes a `*.motion.safetensors` file. Raises `Error` where it cannot be written.
    fn save(&self, path: PathBuf) -> PyResult<()> {
        container::write(&path, &self.0).or_raise()
    }

    fn __len__(&self) -> usize {
        self.0.len()
    }

    fn __repr__(&self) -> String {
        format!(
            "Clip('{}', {:.2} s at {} Hz, {} joints)",
            self.0.name,
            self.0.seconds(),
            self.0.fps,
            self.0.joint_names.len()
        )
    }

    /// Name, unique within a data set.
    #[getter]
    fn name(&self) -> &str {
        &self.0.name
    }

    /// Frames per second.
    #[getter]
    fn fps(&self) -> f64 {
        self.0.fps
    }

    /// Duration from the first to the last frame (s).
    #[getter]
    fn seconds(&self) -> f64 {
        self.0.seconds()
    }

    /// Names of the joints, `[J]`.
    #[getter]
    fn joint_names(&self) -> Vec<String> {
        self.0.joint_names.clone()
    }

    /// Root position, `[T, 3]` (m, world); a copy.
    #[getter]
    fn root_position<'py>(&self, py: Python<'py>) -> PyResult<Doubles<'py>> {
        let values: Vec<f64> = self.0.root_position.iter().flat_map(|p| [p.x, p.y, p.z]).collect();
        array(py, &values, &[self.0.len(), 3])
    }

    /// Root orientation, `[T, 4]` (`wxyz`); a copy.
    #[getter]
    fn root_orientation<'py>(&self, py: Python<'py>) -> PyResult<Doubles<'py>> {
        let values: Vec<f64> = self.0.root_orientation.iter().flat_map(|q| [q.w, q.i, q.j, q.k]).collect();
        array(py, &values, &[self.0.len(), 4])
    }

    /// Joint positions, `[T, J]` (rad); a copy.
    #[getter]
    fn joints<'py>(&self, py: Python<'py>) -> PyResult<Doubles<'py>> {
        array(py, &self.0.joints, &[self.0.len(), self.0.joint_names.len()])
    }

    /// Origin: `character`, `source`, `licence` and `captions`, as a dictionary.
    #[getter]
    fn provenance<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        plain(py, &self.0.provenance)
    }
}

/// Files, folders, patterns or `builtin` clips, as the commands take them.
#[derive(FromPyObject)]
pub enum Inputs {
    /// One of them.
    One(PathBuf),
    /// Several.
    Many(Vec<PathBuf>),
}

/// Loads clips for a robot, sorted by name. Human motion is retargeted on the way.
///
/// `inputs` is a file, folder, pattern, `@list.txt`, `builtin`, `builtin:all` or `builtin:NAME`, or a list of them.
/// Raises `Error` where a file is of no use, with the reason for each.
#[pyfunction]
#[pyo3(signature = (inputs, robot))]
pub fn load_clips(py: Python<'_>, inputs: Inputs, robot: RobotLike<'_>) -> PyResult<Vec<Clip>> {
    let robot = robot.load()?;
    let inputs = match inputs {
        Inputs::One(input) => vec![input],
        Inputs::Many(inputs) => inputs,
    };
    let clips = py.detach(|| clips::load(&inputs, &robot).and_then(|loaded| loaded.all())).or_raise()?;
    Ok(clips.into_iter().map(Clip).collect())
}

/// Retargets captured motion to a robot. Returns the clip and its quality, the `report` of `lifelike motion retarget`.
///
/// `path` is a BVH, ASF/AMC, AMASS, DeepMimic or keyframe file, or motion of `source_robot`. `changes` are options such
/// as `fps=30` or `smoothing=0.03`. Raises `Error` for a file that cannot be read or a motion beyond the bounds.
#[pyfunction]
#[pyo3(signature = (path, robot, *, source_robot=None, changes=vec![]))]
pub fn retarget<'py>(
    py: Python<'py>,
    path: PathBuf,
    robot: RobotLike<'py>,
    source_robot: Option<RobotLike<'py>>,
    changes: Vec<String>,
) -> PyResult<(Clip, Bound<'py, PyAny>)> {
    let (robot, other) = (robot.load()?, source_robot.map(RobotLike::load).transpose()?);
    let mut options = overrides::apply(clips::retarget_options(&robot), &changes).or_raise()?;
    clips::limit_speeds(&mut options, &robot);
    let reading = ReadOptions {
        correspondence: options.correspondence.clone(),
        robot: other.as_ref().map(|other| other.character.clone()),
        ..ReadOptions::default()
    };
    let (clip, report) = py.detach(|| {
        let mut source = match (formats::read(&path, &reading).or_raise()?, &other) {
            (FileMotion::Source(source), _) => source,
            (FileMotion::Robot(clip), Some(other)) => {
                let (source, roles) = source_of_robot(&clip, &other.character, &other.anatomy).or_raise()?;
                options.correspondence.merge(&roles);
                source
            }
            (FileMotion::Robot(clip), None) => {
                let (file, robot) = (path.display(), &clip.provenance.character);
                return Err(Error::new_err(format!("{file}: motion of robot '{robot}': expected source_robot")));
            }
        };
        source.name = formats::clip_name(&path);
        lifelike_motion::retarget::retarget(&source, &robot.character, &robot.anatomy, &options).or_raise()
    })?;
    Ok((Clip(clip), plain(py, &report)?))
}
