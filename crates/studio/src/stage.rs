//! A robot, its controller and its physics: all that a scene is performed with.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use lifelike_generation::generator::Generator;
use lifelike_representation::MotionPrior;
use lifelike_representation::motion_spline::MotionSpline;
use lifelike_robot::{Controller, ReferenceLibrary, Robot};
use lifelike_sim::SimulationSpec;

use crate::StudioError;
use crate::performer::{Events, Fall, Performer};
use crate::scene::Scene;
use crate::workshop::{Built, Workshop};

/// All that a scene is performed with.
#[derive(Clone)]
pub struct Stage {
    /// Controller, which has its robot.
    pub controller: Arc<Controller>,
    /// Generator of motion from sentences, where there is one for the robot.
    pub generator: Option<Arc<Generator>>,
    /// Motion spline whose control points are edited, where there is one for the robot.
    pub spline: Option<Arc<MotionSpline>>,
    /// Motion prior by whose codes clips are found, where there is one for the robot.
    pub prior: Option<Arc<MotionPrior>>,
    /// Folder below which clips are read.
    pub folder: PathBuf,
    /// Policies that may take over.
    pub policies: Policies,
}

/// Returns a policy by its name; without one the best for the robot.
type Load = dyn Fn(Option<&str>) -> Result<Arc<Controller>, String> + Send + Sync;

/// Policies by name.
#[derive(Clone, Default)]
pub struct Policies {
    /// Their names.
    pub names: Vec<String>,
    /// Reads one; none: there is only the policy of the stage.
    pub load: Option<Arc<Load>>,
}

impl Policies {
    /// Reads the policy of this name.
    ///
    /// # Errors
    /// [`StudioError::Operation`] for a name that is not among them, or a policy that does not fit the robot.
    pub fn find(&self, name: Option<&str>) -> Result<Arc<Controller>, StudioError> {
        let known = name.is_none_or(|name| self.names.iter().any(|one| one == name));
        match (&self.load, known) {
            (Some(load), true) => load(name).map_err(StudioError::Operation),
            _ => {
                let (known, name) = (self.names.join(", "), name.unwrap_or("the best"));
                Err(StudioError::Operation(format!("expected a policy of {known}, got '{name}'")))
            }
        }
    }
}

impl Stage {
    /// Returns the robot.
    pub fn robot(&self) -> &Arc<Robot> {
        self.controller.robot()
    }

    /// Returns the number of frames by which a policy sees its reference before it is there.
    pub(crate) fn looks_ahead(&self) -> usize {
        let reference = &self.controller.observation().reference;
        let window = reference.window.iter().map(|offset| offset.unsigned_abs() as usize);
        let frames = reference.future.iter().map(|frame| *frame as usize).chain(window).max().unwrap_or(0);
        let seconds = self.controller.prior().map_or(0.0, |prior| prior.header().window_seconds);
        // The target is one frame ahead, and velocities are differences of neighbours.
        frames.max((seconds * self.robot().control_hz).ceil() as usize) + 3
    }

    /// Returns the stage with the policy that a scene names; as it is where it has one policy only.
    ///
    /// # Errors
    /// As [`Policies::find`].
    pub(crate) fn for_scene(&self, scene: &Scene) -> Result<Self, StudioError> {
        let mut stage = self.clone();
        if self.policies.load.is_some() {
            stage.controller = self.policies.find(scene.policy.as_deref())?;
        }
        Ok(stage)
    }

    /// Returns a maker of motion.
    pub fn workshop(&self) -> Workshop {
        let robot = Arc::clone(self.robot());
        Workshop::new(robot, self.generator.clone(), self.spline.clone(), self.folder.clone())
    }

    /// Returns the motion as a reference.
    ///
    /// # Errors
    /// A motion that does not fit the robot.
    pub fn reference(&self, built: &Built) -> Result<Arc<ReferenceLibrary>, StudioError> {
        Ok(Arc::new(ReferenceLibrary::new(self.robot(), std::slice::from_ref(&built.clip), None)?))
    }

    /// Returns a robot at the start of a reference.
    ///
    /// # Errors
    /// As [`Performer::new`].
    pub fn performer(&self, reference: &Arc<ReferenceLibrary>, whole: bool) -> Result<Performer, StudioError> {
        let spec = SimulationSpec { threads: 1, ..SimulationSpec::new(1) };
        let simulation = spec.build(Arc::clone(self.robot()))?;
        Performer::new(Arc::clone(&self.controller), simulation, Arc::clone(reference), whole)
    }

    /// Performs a scene from its start to its end, without a page.
    ///
    /// # Errors
    /// [`StudioError`] for a block, push or switch that does not fit the robot.
    pub fn perform(&self, scene: &Scene) -> Result<Take, StudioError> {
        let built = self.workshop().build(scene)?;
        let events = Events::of(scene, self.robot())?;
        let reference = self.reference(&built)?;
        let mut performer = self.performer(&reference, true)?;
        let frames = frames(&reference, &events, self.robot().control_hz);
        let mut falls = Vec::new();
        while performer.frame() + 1 < frames {
            falls.extend(performer.step(&events)?);
        }
        Ok(Take { performer, falls, built, robot: Arc::clone(self.robot()) })
    }
}

/// Returns the number of frames of a scene: its motion, and a while after its last event.
pub(crate) fn frames(reference: &ReferenceLibrary, events: &Events, hz: f64) -> usize {
    let after = (AFTER_EVENT * hz) as usize;
    reference.len().max(if events.end() > 0 { events.end() + after } else { 0 })
}

/// Time for which a scene goes on after its last push or switch (s).
const AFTER_EVENT: f64 = 1.5;

/// A performed scene.
pub struct Take {
    performer: Performer,
    /// Falls, in the order of time.
    pub falls: Vec<Fall>,
    /// The motion that was asked for.
    pub built: Built,
    robot: Arc<Robot>,
}

impl Take {
    /// Returns the rollout.
    pub fn rollout(&self) -> &lifelike_evaluation::Rollout {
        self.performer.rollout()
    }

    /// Returns its scores; those after the first fall do not count.
    pub fn evaluation(&self, name: &str) -> lifelike_evaluation::Evaluation {
        let mut rollout = self.rollout().clone();
        rollout.clip = name.into();
        rollout.planned = rollout.simulated.len();
        let score = lifelike_evaluation::EpisodeScore::of(&rollout);
        let seconds = rollout.simulated.len() as f64 / rollout.fps;
        let joints = self.robot.layout.joints.as_slice();
        lifelike_evaluation::Evaluation::new(
            (&self.robot.name, joints),
            "lifelike",
            seconds,
            vec![score],
            vec![rollout],
        )
    }

    /// Returns the motion that physics made of the scene.
    pub fn clip(&self, name: &str) -> lifelike_motion::MotionClip {
        let captions = self.built.clip.provenance.captions.clone();
        let provenance = lifelike_motion::Provenance {
            character: self.robot.name.clone(),
            source: format!("scene '{name}' in physics"),
            licence: self.built.clip.provenance.licence.clone(),
            captions,
        };
        lifelike_motion::MotionClip { name: name.into(), ..self.rollout().played(provenance) }
    }

    /// Returns a page in one file that plays it without a server.
    pub fn page(&self, name: &str) -> lifelike_report::ReportBuilder {
        let evaluation = self.evaluation(name);
        let overall = &evaluation.overall;
        let page = lifelike_report::ReportBuilder::new(name)
            .subtitle("A scene in physics, over its reference.")
            .fact("robot", evaluation.robot.clone())
            .fact("seconds", format!("{:.1}", evaluation.episode_seconds))
            .fact("falls", self.falls.len().to_string())
            .fact("joint error", format!("{:.2} deg", overall.joint_error_deg));
        let page = evaluation.tables().into_iter().fold(page, lifelike_report::ReportBuilder::table);
        page.playback(&self.robot.character, &evaluation.playbacks())
    }
}

/// Returns the name of a scene's file without its suffix.
pub fn name_of(path: &Path) -> String {
    let name = path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
    name.strip_suffix(crate::scene::EXTENSION).map_or(name.clone(), str::to_owned)
}
