//! The environments in which tracking policies learn.

use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};

use lifelike_robot::{ActionSpec, ReferenceLibrary, clips};
use lifelike_sim::SimulationSpec;
use lifelike_tracking::{Environment, TrackerPlan};
use lifelike_train::StepOutcome;
use numpy::ToPyArray;
use pyo3::prelude::*;

use crate::arrays::{Floats, Numbers, numbers, view};
use crate::clip::Clip;
use crate::error::{Error, Raise};
use crate::robot::{Robot, RobotLike};

/// Per environment: rewards, episodes that failed, episodes that were cut.
type Step<'py> = (Bound<'py, PyAny>, Bound<'py, PyAny>, Bound<'py, PyAny>);

/// Many robots that each follow a reference: the environments of `lifelike train tracker`.
///
/// `plan` is a built-in plan or a plan's file, `changes` are its keys such as `episode.seconds=5` (`lifelike train tracker
/// --keys` lists all). `robot` and `clips` replace the plan's. `seed` addresses all randomness; results do not depend on `threads`.
/// An episode that ends begins anew within the same step. The curriculum and the choice of starts follow the steps made.
/// Raises `Error` for plans, robots and clips that do not fit each other.
#[pyclass(module = "lifelike")]
pub struct TrackingEnvironment {
    /// The lock makes the class `Sync`; Python's own borrow is the one that excludes other threads.
    inner: Mutex<Environment>,
    outcome: StepOutcome,
    robot: Arc<lifelike_robot::Robot>,
    library: Arc<ReferenceLibrary>,
    plan: TrackerPlan,
    threads: usize,
    steps: usize,
}

impl TrackingEnvironment {
    /// Returns rows of an environment as a view, `[N, width]`.
    fn rows<'py>(slf: Bound<'py, Self>, of: impl Fn(&Environment) -> &[f32]) -> PyResult<Floats<'py>> {
        let this = slf.try_borrow()?;
        let inner = this.inner.lock().unwrap_or_else(PoisonError::into_inner);
        let values = of(&inner);
        // SAFETY: the rows are allocated with the environment and only replaced by `Environment::load`, which nothing
        // here calls; the environment itself is never replaced.
        unsafe { view(slf.clone().into_any(), values, &[inner.len(), values.len() / inner.len()]) }
    }

    fn build(
        plan: TrackerPlan,
        robot: Arc<lifelike_robot::Robot>,
        library: Arc<ReferenceLibrary>,
        threads: usize,
    ) -> PyResult<Self> {
        let spec = SimulationSpec { threads, ..SimulationSpec::new(plan.ppo.environments) };
        let simulation = spec.build(Arc::clone(&robot)).or_raise()?;
        let inner = Environment::new(&plan, Arc::clone(&robot), Arc::clone(&library), simulation).or_raise()?;
        let (inner, outcome) = (Mutex::new(inner), StepOutcome::default());
        Ok(Self { inner, outcome, robot, library, plan, threads, steps: 0 })
    }

    fn inner(&mut self) -> &mut Environment {
        self.inner.get_mut().unwrap_or_else(PoisonError::into_inner)
    }
}

#[pymethods]
impl TrackingEnvironment {
    #[new]
    #[pyo3(signature = (plan="track".into(), environments=None, *, robot=None, clips=None, seed=None, threads=0, changes=vec![]))]
    #[allow(clippy::too_many_arguments)]
    fn new(
        py: Python<'_>,
        plan: std::path::PathBuf,
        environments: Option<usize>,
        robot: Option<RobotLike<'_>>,
        clips: Option<Vec<PyRef<'_, Clip>>>,
        seed: Option<u64>,
        threads: usize,
        changes: Vec<String>,
    ) -> PyResult<Self> {
        let mut plan: TrackerPlan = lifelike::plans::load(&plan, &changes).or_raise()?;
        plan.check().or_raise()?;
        if !plan.teachers.is_empty() || plan.prior.is_some() || plan.terrain.is_some() {
            let text =
                "plan: expected none of teachers, prior and terrain, which only `lifelike train tracker` sets up";
            return Err(Error::new_err(text));
        }
        plan.ppo.environments = environments.unwrap_or(plan.ppo.environments);
        plan.seed = seed.unwrap_or(plan.seed);
        if plan.ppo.environments == 0 {
            return Err(Error::new_err("environments: expected at least 1, got 0"));
        }
        let robot = robot.map_or_else(|| RobotLike::Name(Path::new(&plan.robot).into()).load(), RobotLike::load)?;
        let given = clips.map(|clips| clips.iter().map(|clip| clip.0.clone()).collect::<Vec<_>>());
        py.detach(|| {
            let clips = match given {
                Some(clips) => clips,
                None => clips::load(&plan.clips, &robot).and_then(|loaded| loaded.all()).or_raise()?,
            };
            let clips = if plan.mirror { clips::with_mirror_images(clips, &robot).or_raise()? } else { clips };
            let library = Arc::new(ReferenceLibrary::new(&robot, &clips, None).or_raise()?);
            Self::build(plan, robot, library, threads)
        })
    }

    /// Returns new environments with the same plan, robot and clips, and another seed.
    fn with_seed(&self, py: Python<'_>, seed: u64) -> PyResult<Self> {
        let plan = TrackerPlan { seed, ..self.plan.clone() };
        let (robot, library) = (Arc::clone(&self.robot), Arc::clone(&self.library));
        py.detach(|| Self::build(plan, robot, library, self.threads))
    }

    fn __len__(&mut self) -> usize {
        self.inner().len()
    }

    /// Robot of the environments.
    #[getter]
    fn robot(&self) -> Robot {
        Robot(Arc::clone(&self.robot))
    }

    /// Length of a policy's observation O.
    #[getter]
    fn observation_size(&mut self) -> usize {
        self.inner().actor_size()
    }

    /// Length of a value function's observation P.
    #[getter]
    fn critic_observation_size(&mut self) -> usize {
        self.inner().critic_size()
    }

    /// Length of an action J.
    #[getter]
    fn action_size(&self) -> usize {
        self.robot.joints()
    }

    /// Largest absolute action; the environments clamp to it.
    #[getter]
    fn action_limit(&self) -> f64 {
        ActionSpec::OUTPUT_LIMIT
    }

    /// Longest episode (steps).
    #[getter]
    fn max_episode_steps(&mut self) -> u64 {
        self.inner().longest_episode()
    }

    /// Observations of the policy, `[N, O]` float32, not normalised; a read-only view that the next step overwrites.
    #[getter]
    fn observations(slf: Bound<'_, Self>) -> PyResult<Floats<'_>> {
        Self::rows(slf, Environment::actor_rows)
    }

    /// Observations of the value function, `[N, P]`: the policy's without noise, and more. A view as `observations`.
    #[getter]
    fn critic_observations(slf: Bound<'_, Self>) -> PyResult<Floats<'_>> {
        Self::rows(slf, Environment::critic_rows)
    }

    /// Begins new episodes in some environments, in all where no indices are given.
    ///
    /// Raises `Error` for an unknown index.
    #[pyo3(signature = (environments=None))]
    fn reset(&mut self, py: Python<'_>, environments: Option<Vec<usize>>) -> PyResult<()> {
        let inner = self.inner();
        let n = inner.len();
        let ids = environments.unwrap_or_else(|| (0..n).collect());
        if let Some(id) = ids.iter().find(|id| **id >= n) {
            return Err(Error::new_err(format!("environment: expected 0 to {}, got {id}", n - 1)));
        }
        py.detach(|| inner.reset(&ids, None)).or_raise()
    }

    /// Makes one step with the policy's outputs, `[N, J]` (clamped by the environments).
    ///
    /// Returns `(rewards, terminated, truncated)`: new arrays, `[N]` float32, bool, bool. Raises `Error` for another shape.
    fn step<'py>(&mut self, py: Python<'py>, actions: Numbers<'py, f32>) -> PyResult<Step<'py>> {
        let actions = numbers("actions", &actions, &[self.inner().len(), self.robot.joints()])?;
        self.steps += 1;
        // As often as a training refreshes its curriculum and the choice of starts.
        let is_due = self.steps.is_multiple_of(self.plan.ppo.steps);
        let Self { inner, outcome, .. } = self;
        let inner = inner.get_mut().unwrap_or_else(PoisonError::into_inner);
        py.detach(|| {
            inner.step(&actions, outcome)?;
            if is_due {
                inner.refresh();
            }
            Ok::<(), lifelike_tracking::TrackerError>(())
        })
        .or_raise()?;
        let StepOutcome { rewards, terminated, truncated, .. } = &*outcome;
        Ok((
            rewards.to_pyarray(py).into_any(),
            terminated.to_pyarray(py).into_any(),
            truncated.to_pyarray(py).into_any(),
        ))
    }

    /// Returns the value function's observations at the ends of the episodes that the last step truncated, `[truncated, P]`.
    ///
    /// The rows are in the order of the environments. `critic_observations` already belongs to the next episodes.
    fn final_critic_observations<'py>(&mut self, py: Python<'py>) -> PyResult<Floats<'py>> {
        let width = self.inner().critic_size();
        let rows = &self.outcome.final_critic_observations;
        crate::arrays::array(py, rows, &[rows.len() / width, width])
    }
}
