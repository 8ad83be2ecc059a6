//! A controller on many simulated robots in lockstep, each with a reference of its own.

use lifelike_checkpoint::FromInput;
use lifelike_robot::controller::{History, ObservationScratch, PolicyWorkspace};
use lifelike_robot::{Alignment, ClipPlayer, Controller, GetUp, MeasuredState, ReferenceLibrary, ReferenceStream};
use lifelike_sim::{BatchState, Drive, Ground, IntegrationState, Simulation};

use super::episode::EpisodeConditions;
use super::error::EvaluationError;

/// End of an episode that is no fall.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Ended {
    /// The simulated state became non-finite or absurd.
    Diverged,
    /// The reference is at the last frame of its clip.
    ClipOver,
}

/// One robot at one moment, and the reference that it should be at.
pub struct Moment<'a> {
    /// State of all environments.
    pub state: &'a BatchState,
    /// Environment of the robot.
    pub i: usize,
    /// Ground below it.
    pub ground: &'a Ground,
    /// The present frame of the library.
    pub frame: usize,
    /// Place of the reference's world in the robot's.
    pub alignment: Alignment,
}

/// One robot's run.
struct Run<'a> {
    history: History,
    player: ClipPlayer<&'a ReferenceLibrary>,
}

/// Saved robots between two steps: simulation, histories and frames of the reference.
pub(super) struct Runs {
    simulation: IntegrationState,
    runs: Vec<(History, usize)>,
}

/// The robots between two steps.
pub(super) struct Runner<'a> {
    controller: &'a Controller,
    library: &'a ReferenceLibrary,
    simulation: Box<dyn Simulation>,
    ground: Ground,
    runs: Vec<Run<'a>>,
    scratch: ObservationScratch,
    work: PolicyWorkspace,
    /// Observations, outputs and joint targets of all environments, in use or not: the same product each step.
    rows: Vec<f32>,
    outputs: Vec<f32>,
    targets: Vec<f32>,
}

impl<'a> Runner<'a> {
    pub(super) fn new(
        controller: &'a Controller,
        library: &'a ReferenceLibrary,
        simulation: Box<dyn Simulation>,
    ) -> Result<Self, EvaluationError> {
        let (robot, n) = (controller.robot(), simulation.len());
        if simulation.robot().layout != robot.layout {
            let expected = format!("those of robot '{}'", robot.name);
            let got = format!("those of '{}'", simulation.robot().name);
            return Err(EvaluationError::mismatch("joints and end effectors of the simulation", expected, got));
        }
        Ok(Self {
            ground: Ground::of(simulation.as_ref(), robot),
            runs: Vec::new(),
            scratch: ObservationScratch::new(controller),
            work: PolicyWorkspace::batched(),
            rows: vec![0.0; n * controller.observation().size()],
            outputs: vec![0.0; n * robot.joints()],
            targets: controller.actions().default_pose.repeat(n),
            controller,
            library,
            simulation,
        })
    }

    /// Begins an episode in each of the first environments: at a frame of the library, in its state, under its conditions.
    pub(super) fn begin(&mut self, frames: &[usize], conditions: &[EpisodeConditions]) -> Result<(), EvaluationError> {
        let joints = self.controller.robot().joints();
        let run = |frame: &usize| Run { history: History::new(joints), player: ClipPlayer::new(self.library, *frame) };
        self.runs = frames.iter().map(run).collect();
        let starts: Vec<(usize, usize)> = frames.iter().copied().enumerate().collect();
        self.reset(&starts, conditions)
    }

    /// Begins another episode in environment `i`, which has one.
    pub(super) fn restart(
        &mut self,
        i: usize,
        frame: usize,
        conditions: &EpisodeConditions,
    ) -> Result<(), EvaluationError> {
        self.reset(&[(i, frame)], std::slice::from_ref(conditions))
    }

    /// Puts environments into states of the library: number and frame of each.
    fn reset(&mut self, starts: &[(usize, usize)], conditions: &[EpisodeConditions]) -> Result<(), EvaluationError> {
        let robot = self.controller.robot();
        let (nq, nv) = (robot.character.nq, robot.character.nv);
        let (mut positions, mut velocities) = (vec![0.0; starts.len() * nq], vec![0.0; starts.len() * nv]);
        for (k, (&(i, frame), conditions)) in starts.iter().zip(conditions).enumerate() {
            let place = conditions.position;
            let mut history = History::new(robot.joints());
            let [x, y, _] = self.library.position_at(frame);
            history.alignment = Alignment { yaw: 0.0, from: [x, y], to: place.map(|p| p as f32) };
            if !conditions.parameters.joint_offset.is_empty() {
                history.joint_offset.clone_from(&conditions.parameters.joint_offset);
            }
            self.runs[i] = Run { history, player: ClipPlayer::new(self.library, frame) };
            self.simulation.set_parameters(i, conditions.parameters.clone())?;
            self.simulation.clear_pushes(i);
            let (q, v) = (&mut positions[k * nq..(k + 1) * nq], &mut velocities[k * nv..(k + 1) * nv]);
            self.library.write_state(frame, robot, place, self.ground.lift(place), q, v);
        }
        let ids: Vec<usize> = starts.iter().map(|(i, _)| *i).collect();
        self.simulation.reset(&ids, &positions, &velocities)?;
        for i in ids {
            let measured = measured(self.simulation.as_ref(), &self.ground, self.controller, i);
            let run = &mut self.runs[i];
            self.controller.rest(&mut run.history, &measured, &run.player)?;
        }
        Ok(())
    }

    /// Drops all robots from given states (MuJoCo's layout); for `steps` motors only brake. The reference is laid where
    /// each has come to lie.
    pub(super) fn drop(&mut self, positions: &[f64], velocities: &[f64], steps: usize) -> Result<(), EvaluationError> {
        let ids: Vec<usize> = (0..self.runs.len()).collect();
        self.simulation.reset(&ids, positions, velocities)?;
        for _ in 0..steps {
            // Targets where the joints are leave the damping alone.
            self.targets.copy_from_slice(&self.simulation.state().joint_position);
            self.simulation.step(Drive::Targets(&self.targets))?;
        }
        ids.into_iter().try_for_each(|i| self.take_over(i))
    }

    /// Lays the reference where robot `i` is, and takes as last actions those that hold its pose.
    pub(super) fn take_over(&mut self, i: usize) -> Result<(), EvaluationError> {
        self.jump(i, self.runs[i].player.frame());
        let measured = measured(self.simulation.as_ref(), &self.ground, self.controller, i);
        let run = &mut self.runs[i];
        Ok(self.controller.rest(&mut run.history, &measured, &run.player)?)
    }

    /// Lets a script drive robot `i` in the next step, unless that is on its feet; returns whether it is.
    pub(super) fn get_up(&mut self, i: usize, script: &mut GetUp) -> bool {
        let measured = measured(self.simulation.as_ref(), &self.ground, self.controller, i);
        let joints = measured.joint_position.len();
        let is_up = script.is_on_its_feet(&measured);
        if !is_up {
            script.step(&measured, &mut self.targets[i * joints..(i + 1) * joints]);
        }
        is_up
    }

    /// From one moment to the next, robot `i` is asked to go on from another frame of the library, laid where it is.
    pub(super) fn jump(&mut self, i: usize, frame: usize) {
        let run = &mut self.runs[i];
        run.player.seek(frame);
        let there = run.player.present_root();
        let here = measured(self.simulation.as_ref(), &self.ground, self.controller, i);
        let place = here.root_position.unwrap_or(there.position);
        run.history.alignment = Alignment::between(there.position, there.orientation, place, here.root_orientation);
    }

    /// One step of all robots; only those `in_use` are told what to do, the others keep their targets.
    pub(super) fn step(&mut self, in_use: impl Fn(usize) -> bool) -> Result<(), EvaluationError> {
        self.step_with(in_use, |_, _| {})
    }

    /// One step in which the outputs of each robot's policy are changed before it acts.
    pub(super) fn step_with(
        &mut self,
        in_use: impl Fn(usize) -> bool,
        mut change: impl FnMut(usize, &mut [f32]),
    ) -> Result<(), EvaluationError> {
        let (size, joints) = (self.controller.observation().size(), self.controller.robot().joints());
        for (i, run) in self.runs.iter_mut().enumerate().filter(|(i, _)| in_use(*i)) {
            let measured = measured(self.simulation.as_ref(), &self.ground, self.controller, i);
            let row = &mut self.rows[i * size..(i + 1) * size];
            self.controller.observe(&mut run.history, &mut self.scratch, &measured, &run.player, row)?;
        }
        self.controller.outputs(&mut self.rows, &mut self.work, &mut self.outputs);
        for (i, run) in self.runs.iter_mut().enumerate().filter(|(i, _)| in_use(*i)) {
            let columns = i * joints..(i + 1) * joints;
            let (output, targets) = (&mut self.outputs[columns.clone()], &mut self.targets[columns]);
            change(i, output);
            self.controller.act(&mut run.history, &run.player, output, targets)?;
            run.player.advance();
        }
        self.simulation.step(Drive::Targets(&self.targets))?;
        Ok(())
    }

    /// The end of robot `i`'s episode, where the last step brought it.
    pub(super) fn ended(&self, i: usize) -> Option<Ended> {
        if self.simulation.state().diverged[i] {
            Some(Ended::Diverged)
        } else if self.runs[i].player.is_over() {
            Some(Ended::ClipOver)
        } else {
            None
        }
    }

    /// Robot `i` now.
    pub(super) fn moment(&self, i: usize) -> Moment<'_> {
        Moment {
            state: self.simulation.state(),
            i,
            ground: &self.ground,
            frame: self.runs[i].player.frame(),
            alignment: self.runs[i].history.alignment,
        }
    }

    /// Everything needed to go on from here.
    pub(super) fn save(&self) -> Runs {
        let runs = self.runs.iter().map(|run| (run.history.clone(), run.player.frame())).collect();
        Runs { simulation: self.simulation.save(), runs }
    }

    /// Goes back.
    pub(super) fn restore(&mut self, saved: &Runs) -> Result<(), EvaluationError> {
        for (run, (history, frame)) in self.runs.iter_mut().zip(&saved.runs) {
            run.history.clone_from(history);
            run.player.seek(*frame);
        }
        Ok(self.simulation.restore(&saved.simulation)?)
    }

    /// Every robot goes on from where the one of its place in `parents` is.
    pub(super) fn select(&mut self, parents: &[usize]) -> Result<(), EvaluationError> {
        let now = self.save();
        let width = now.simulation.width;
        let rows = parents.iter().flat_map(|i| now.simulation.values[i * width..(i + 1) * width].iter().copied());
        let simulation = IntegrationState {
            values: rows.collect(),
            parameters: parents.iter().map(|i| now.simulation.parameters[*i].clone()).collect(),
            ..now.simulation.clone()
        };
        let runs = parents.iter().map(|i| now.runs[*i].clone()).collect();
        self.restore(&Runs { simulation, runs })
    }

    /// The simulation, to disturb it.
    pub(super) fn simulation_mut(&mut self) -> &mut dyn Simulation {
        self.simulation.as_mut()
    }
}

/// One robot as it is measured: its true state.
fn measured<'s>(
    simulation: &'s dyn Simulation,
    ground: &Ground,
    controller: &Controller,
    i: usize,
) -> MeasuredState<'s> {
    let measured = simulation.state().measured(i, controller.robot().effectors.len());
    let height = measured.root_position.map(|[x, y, z]| {
        let below = ground.height(f64::from(x), f64::from(y));
        (f64::from(z) - below) as f32
    });
    MeasuredState { root_height: height, ..measured }
}
