//! One robot that performs a scene in physics, frame by frame; it can go back to a saved frame.

use std::sync::Arc;

use lifelike_character::Kinematics;
use lifelike_evaluation::fall::fallen;
use lifelike_evaluation::{Cause, Failure, Moment, Outcome, Recorder, Rollout};
use lifelike_robot::controller::History;
use lifelike_robot::profile::glob;
use lifelike_robot::{Alignment, ClipPlayer, Controller, ControllerState, MeasuredState, ReferenceLibrary, Robot};
use lifelike_sim::{Drive, EnvironmentParameters, Ground, IntegrationState, Simulation};
use serde::Serialize;

use crate::StudioError;
use crate::scene::{Scene, Switch};

/// Time after a fall at which the robot is put back on its feet (s).
const AFTER_FALL: f64 = 1.2;
/// Frames of a rollout that a live performance keeps: what an explanation of a fall looks at.
const KEPT: usize = 150;

/// A fall.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Fall {
    /// Frame.
    pub frame: usize,
    /// Time in the scene (s).
    pub second: f64,
    /// Sign by which it is known, in words.
    pub cause: String,
    /// Events before it, in words.
    pub why: String,
}

/// Everything that is needed to go on from a frame.
#[derive(Debug, Clone)]
pub struct Saved {
    frame: usize,
    simulation: IntegrationState,
    history: History,
    down: Option<usize>,
}

impl Saved {
    /// Returns the frame.
    pub fn frame(&self) -> usize {
        self.frame
    }
}

/// A force that acts from a frame to another.
#[derive(Debug, Clone, PartialEq)]
pub struct Force {
    /// First frame.
    pub from: usize,
    /// First frame without it.
    pub until: usize,
    /// The body.
    pub body: usize,
    /// Force (N, world).
    pub newtons: [f32; 3],
}

/// Pushes and switches of a scene by frames.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Events {
    /// Pushes.
    pub forces: Vec<Force>,
    /// Frames of switches with the parameters from then on, in the order of time.
    pub parameters: Vec<(usize, EnvironmentParameters)>,
}

impl Events {
    /// Resolves names and times.
    ///
    /// # Errors
    /// [`StudioError::Block`] for a body or joint that the robot has not.
    pub fn of(scene: &Scene, robot: &Robot) -> Result<Self, StudioError> {
        let frame = |at: f64| (at * robot.control_hz).round() as usize;
        let mut events = Self::default();
        for push in &scene.push {
            let body = robot.character.body(&push.body).map_err(StudioError::block(&push.id))?;
            let from = frame(push.at);
            let until = from + frame(push.seconds).max(1);
            events.forces.push(Force { from, until, body, newtons: push.newtons.map(|force| force as f32) });
        }
        let mut switches: Vec<&Switch> = scene.switch.iter().collect();
        switches.sort_by(|a, b| a.at.total_cmp(&b.at));
        let mut now = EnvironmentParameters::default();
        for switch in switches {
            turn(&mut now, switch, robot)?;
            events.parameters.push((frame(switch.at), now.clone()));
        }
        Ok(events)
    }

    /// Returns the first frame whose step differs between two sets of events; none where they are equal.
    pub fn first_difference(&self, other: &Self) -> Option<usize> {
        let only = |a: &Self, b: &Self| {
            let forces = a.forces.iter().filter(|force| !b.forces.contains(force)).map(|force| force.from);
            let switches = a.parameters.iter().filter(|one| !b.parameters.contains(one)).map(|one| one.0);
            forces.chain(switches).min()
        };
        [only(self, other), only(other, self)].into_iter().flatten().min()
    }

    /// Returns the end of the last event (frame).
    pub fn end(&self) -> usize {
        let forces = self.forces.iter().map(|force| if force.until == usize::MAX { force.from } else { force.until });
        forces.chain(self.parameters.iter().map(|one| one.0)).max().unwrap_or(0)
    }
}

fn turn(now: &mut EnvironmentParameters, switch: &Switch, robot: &Robot) -> Result<(), StudioError> {
    if let Some(friction) = switch.friction {
        now.ground_friction = Some(friction as f32);
    }
    if let (Some(load), Some(name)) = (switch.load, &switch.body) {
        let body = robot.character.body(name).map_err(StudioError::block(&switch.id))?;
        let mass = robot.character.bodies[body].inertial.mass;
        if mass <= 0.0 {
            let message = format!("expected a body with mass, got '{name}'");
            return Err(StudioError::Block { id: switch.id.clone(), message });
        }
        now.mass_scale.resize(robot.character.bodies.len(), 1.0);
        now.mass_scale[body] = ((mass + load) / mass) as f32;
    }
    if let (Some(strength), Some(pattern)) = (switch.strength, &switch.joints) {
        let joints = &robot.layout.joints;
        if !joints.iter().any(|joint| glob(pattern, joint)) {
            let message = format!("expected joints of {}, got '{pattern}'", joints.join(", "));
            return Err(StudioError::Block { id: switch.id.clone(), message });
        }
        now.strength_scale.resize(joints.len(), 1.0);
        let chosen = now.strength_scale.iter_mut().zip(joints).filter(|(_, joint)| glob(pattern, joint));
        chosen.for_each(|(scale, _)| *scale = strength as f32);
    }
    Ok(())
}

/// A robot that performs.
pub struct Performer {
    controller: Arc<Controller>,
    simulation: Box<dyn Simulation>,
    ground: Ground,
    state: ControllerState,
    library: Arc<ReferenceLibrary>,
    kinematics: Kinematics,
    targets: Vec<f32>,
    frame: usize,
    down: Option<usize>,
    rollout: Rollout,
    whole: bool,
}

impl Performer {
    /// Puts a robot at the first frame of a reference. With `whole` all frames of the rollout are kept.
    ///
    /// # Errors
    /// The reference does not fit the controller, which must have its own encoder of latent codes.
    pub fn new(
        controller: Arc<Controller>,
        simulation: Box<dyn Simulation>,
        library: Arc<ReferenceLibrary>,
        whole: bool,
    ) -> Result<Self, StudioError> {
        let robot = controller.robot();
        let rollout = Recorder::new(robot, &library, &[]).begin(0, library.len());
        let mut performer = Self {
            ground: Ground::of(simulation.as_ref(), robot),
            state: ControllerState::new(&controller),
            kinematics: Kinematics::new(&robot.character),
            targets: vec![0.0; robot.joints()],
            simulation,
            library,
            frame: 0,
            down: None,
            rollout,
            whole,
            controller,
        };
        performer.restart(&Arc::clone(&performer.library))?;
        Ok(performer)
    }

    /// Puts the robot at the first frame of a reference.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn restart(&mut self, library: &Arc<ReferenceLibrary>) -> Result<(), StudioError> {
        self.library = Arc::clone(library);
        (self.frame, self.down) = (0, None);
        self.simulation.set_parameters(0, EnvironmentParameters::default())?;
        self.stand([0.0; 2])?;
        self.rollout = Recorder::new(self.controller.robot(), library, &[]).begin(0, library.len());
        self.record();
        Ok(())
    }

    /// Returns the present frame.
    pub fn frame(&self) -> usize {
        self.frame
    }

    /// Returns the rollout: all of it, or the last frames.
    pub fn rollout(&self) -> &Rollout {
        &self.rollout
    }

    /// Goes on by one frame under events. Returns the fall where one is seen for the first time.
    ///
    /// # Errors
    /// The simulation fails as a whole.
    pub fn step(&mut self, events: &Events) -> Result<Option<Fall>, StudioError> {
        let hz = self.controller.robot().control_hz;
        if self.down.is_some_and(|down| self.frame >= down + (AFTER_FALL * hz) as usize) {
            let [x, y, _] = self.simulation.state().measured(0, 0).root_position.unwrap_or_default().map(f64::from);
            self.stand(if x.is_finite() && y.is_finite() { [x, y] } else { [0.0; 2] })?;
            self.down = None;
        }
        if let Some((_, parameters)) = events.parameters.iter().rev().find(|one| one.0 == self.frame) {
            self.simulation.set_parameters(0, parameters.clone())?;
        }
        self.simulation.clear_pushes(0);
        let acts = |force: &&Force| (force.from..force.until).contains(&self.frame);
        let acting: Vec<&Force> = events.forces.iter().filter(acts).collect();
        for force in &acting {
            let same = acting.iter().filter(|other| other.body == force.body);
            let sum = same.fold([0.0_f32; 3], |sum, one| [0, 1, 2].map(|axis| sum[axis] + one.newtons[axis]));
            self.simulation.push(0, force.body, sum, [0.0; 3])?;
        }
        let mut player = ClipPlayer::new(Arc::clone(&self.library), self.reference_frame());
        let measured = measured(self.simulation.as_ref(), &self.ground, &self.controller);
        self.controller.step(&mut self.state, &measured, &mut player, &mut self.targets)?;
        self.simulation.step(Drive::Targets(&self.targets))?;
        self.frame += 1;
        self.record();
        Ok(self.look_for_fall(hz))
    }

    /// Returns everything that is needed to go on from here.
    pub fn save(&self) -> Saved {
        let (simulation, history) = (self.simulation.save(), self.state.history.clone());
        Saved { frame: self.frame, simulation, history, down: self.down }
    }

    /// Goes back to a frame, and on from there along a reference that may differ from then on.
    ///
    /// # Errors
    /// A state of another robot or engine.
    pub fn restore(&mut self, saved: &Saved, library: &Arc<ReferenceLibrary>) -> Result<(), StudioError> {
        self.simulation.restore(&saved.simulation)?;
        self.state.history.clone_from(&saved.history);
        (self.frame, self.down) = (saved.frame, saved.down);
        self.library = Arc::clone(library);
        self.rollout = Recorder::new(self.controller.robot(), library, &[]).begin(self.reference_frame(), 0);
        self.record();
        Ok(())
    }

    fn reference_frame(&self) -> usize {
        self.frame.min(self.library.len() - 1)
    }

    /// Puts the robot into the present frame of the reference, at a place on the ground (m).
    fn stand(&mut self, place: [f64; 2]) -> Result<(), StudioError> {
        let (robot, frame) = (Arc::clone(self.controller.robot()), self.reference_frame());
        let (mut q, mut v) = (vec![0.0; robot.character.nq], vec![0.0; robot.character.nv]);
        self.library.write_state(frame, &robot, place, self.ground.lift(place), &mut q, &mut v);
        self.simulation.reset(&[0], &q, &v)?;
        let [x, y, _] = self.library.position_at(frame);
        let mut history = History::new(robot.joints());
        history.alignment = Alignment { yaw: 0.0, from: [x, y], to: place.map(|p| p as f32) };
        let player = ClipPlayer::new(Arc::clone(&self.library), frame);
        let measured = measured(self.simulation.as_ref(), &self.ground, &self.controller);
        self.controller.rest(&mut history, &measured, &player)?;
        self.state.history = history;
        Ok(())
    }

    fn record(&mut self) {
        let (controller, library) = (Arc::clone(&self.controller), Arc::clone(&self.library));
        let frame = self.reference_frame();
        let moment = Moment {
            state: self.simulation.state(),
            i: 0,
            ground: &self.ground,
            frame,
            alignment: self.state.history.alignment,
        };
        let recorder = Recorder::new(controller.robot(), &library, &[]);
        recorder.record(&mut self.rollout, &moment, &mut self.kinematics);
        if !self.whole && self.rollout.simulated.len() > 2 * KEPT {
            forget(&mut self.rollout, KEPT);
        }
    }

    fn look_for_fall(&mut self, hz: f64) -> Option<Fall> {
        let (reference, simulated) = (self.rollout.reference.last()?, self.rollout.simulated.last()?);
        let cause = match self.simulation.state().diverged[0] {
            true => Some(Cause::Diverged),
            false => fallen(reference, simulated),
        };
        let cause = cause.filter(|_| self.down.is_none())?;
        self.down = Some(self.frame);
        let outcome = Outcome::Fell { frame: self.rollout.simulated.len() - 1, cause };
        let failure = Failure::of(&Rollout { outcome, ..self.rollout.clone() });
        if self.rollout.outcome == Outcome::Survived {
            self.rollout.outcome = outcome;
        }
        if !self.whole {
            self.rollout.outcome = Outcome::Survived;
        }
        // Times count from the start of the scene, also where only the last frames are kept.
        let dropped = (self.frame + 1 - self.rollout.simulated.len()) as f64 / hz;
        let why = failure.map_or_else(String::new, |mut failure| {
            failure.first_body.iter_mut().for_each(|body| body.second += dropped);
            failure.why()
        });
        Some(Fall { frame: self.frame, second: self.frame as f64 / hz, cause: cause.words().into(), why })
    }
}

/// Drops the first frames of a rollout.
fn forget(rollout: &mut Rollout, frames: usize) {
    let (joints, feet) = (rollout.names.joints.len(), rollout.names.feet.len());
    rollout.reference.drain(..frames);
    rollout.simulated.drain(..frames);
    rollout.torque_share.drain(..frames * joints);
    rollout.heat.drain(..frames * joints);
    rollout.foot_force.drain(..frames * feet);
    rollout.sole_speed.drain(..frames * feet);
    rollout.planned_contact.drain(..frames * feet);
}

fn measured<'s>(simulation: &'s dyn Simulation, ground: &Ground, controller: &Controller) -> MeasuredState<'s> {
    let measured = simulation.state().measured(0, controller.robot().effectors.len());
    let height = measured.root_position.map(|[x, y, z]| z - ground.height(f64::from(x), f64::from(y)) as f32);
    MeasuredState { root_height: height, ..measured }
}
