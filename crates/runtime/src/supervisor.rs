//! The controller, the state machine and the gate as one function of time, packets and requests.

use std::sync::Arc;

use lifelike_robot::{Alignment, Controller, ControllerState, GetUpScript, MeasuredState, ReferenceStream, RobotError};

use crate::bus::Measurement;
use crate::config::Config;
use crate::error::RuntimeError;
use crate::estimator::StateEstimator;
use crate::gate::{Gate, Intent, Limits, Mode, SafeCommand, Trip};
use crate::motions::Playlist;
use crate::phase::{Phase, Request, Situation};
use crate::rescue::{Rescue, is_still};

/// One run of a controller. The same calls give the same commands, bit for bit.
pub struct Supervisor {
    controller: Arc<Controller>,
    state: ControllerState,
    motions: Playlist,
    config: Config,
    gate: Gate,
    phase: Phase,
    /// Time at which the phase began (ns).
    since: u64,
    ticks_per_step: usize,
    /// Ticks since the last policy step.
    tick: usize,
    /// Targets of the policy: those before its last step, and those of it, `[J]`.
    before: Vec<f32>,
    after: Vec<f32>,
    /// Targets of this tick, and the pose that is blended from or to, `[J]`.
    targets: Vec<f32>,
    pose: Vec<f32>,
    steps: u64,
    failed: Option<RobotError>,
    /// Estimator of the root's state, where the policy sees it.
    estimator: Option<StateEstimator>,
    /// Script that gets up after a fall, where there is one.
    rescue: Option<Rescue>,
}

impl Supervisor {
    /// A run before its first tick.
    ///
    /// # Errors
    /// The settings are out of range or do not fit the controller's rate.
    pub fn new(controller: Arc<Controller>, motions: Playlist, config: Config) -> Result<Self, RuntimeError> {
        config.check()?;
        let robot = controller.robot();
        let joints = robot.joints();
        let estimates = config.estimate_root && StateEstimator::is_needed_by(&controller);
        Ok(Self {
            estimator: if estimates { StateEstimator::new(robot) } else { None },
            state: ControllerState::new(&controller),
            gate: Gate::new(Limits::of(robot, config.limits.clone())?, config.command_hz),
            ticks_per_step: config.ticks_per_step(robot.control_hz)?,
            motions,
            config,
            phase: Phase::Idle,
            since: 0,
            tick: 0,
            before: vec![0.0; joints],
            after: vec![0.0; joints],
            targets: vec![0.0; joints],
            pose: vec![0.0; joints],
            steps: 0,
            failed: None,
            rescue: None,
            controller,
        })
    }

    /// Returns the run with a script by which the robot gets up after a fall, and goes on.
    ///
    /// # Errors
    /// The script is of another robot.
    pub fn with_get_up(self, script: &GetUpScript) -> Result<Self, RuntimeError> {
        let rescue = Some(Rescue::new(script, self.controller.robot())?);
        Ok(Self { rescue, ..self })
    }

    /// Returns the controller.
    pub fn controller(&self) -> &Arc<Controller> {
        &self.controller
    }

    /// Returns the settings.
    pub fn config(&self) -> &Config {
        &self.config
    }

    /// Returns the motion.
    pub fn motions(&self) -> &Playlist {
        &self.motions
    }

    /// Returns the gate.
    pub fn gate(&self) -> &Gate {
        &self.gate
    }

    /// Returns the present phase.
    pub fn phase(&self) -> Phase {
        self.phase
    }

    /// Returns the reason for which the gate brakes, where it does.
    pub fn trip(&self) -> Option<Trip> {
        self.gate.trip()
    }

    /// Returns the error of the policy that ended the run, where one did.
    pub fn failed(&self) -> Option<&RobotError> {
        self.failed.as_ref()
    }

    /// Returns the number of falls after which the robot tried to get up.
    pub fn falls(&self) -> u32 {
        self.rescue.as_ref().map_or(0, |rescue| rescue.falls)
    }

    /// Returns the number of policy steps.
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// Returns whether the policy made a step in the last tick.
    pub fn has_stepped(&self) -> bool {
        matches!(self.phase, Phase::BlendIn | Phase::Run | Phase::BlendOut) && self.tick == 1
    }

    /// Returns the policy's last targets, `[J]` (rad).
    pub fn policy_targets(&self) -> &[f32] {
        &self.after
    }

    /// Takes a packet that arrived at `now` (ns).
    pub fn receive(&mut self, now: u64, packet: &Measurement) {
        if self.gate.receive(now, packet)
            && let Some(estimator) = self.estimator.as_mut().filter(|_| packet.external.is_none())
        {
            estimator.receive(packet);
        }
    }

    /// Makes the command of one tick at `now` (ns).
    pub fn tick(&mut self, now: u64, request: Request) -> &SafeCommand {
        let (trip, measured) = (self.gate.trip(), self.gate.measured());
        let (rescue, first_up_b) = (self.rescue.as_mut(), self.motions.first_up_b());
        let (fallen, up) = rescue.map_or((false, false), |rescue| {
            let gets_up = self.phase == Phase::GetUp;
            (
                rescue.may_begin(self.phase, &self.gate, first_up_b),
                gets_up && measured.is_some_and(|measured| rescue.is_up(measured)),
            )
        });
        let situation = Situation {
            request,
            tripped: trip.is_some(),
            measured: measured.is_some(),
            over: self.motions.is_over(),
            fallen,
            still: measured.is_some_and(is_still),
            up,
            elapsed: now.saturating_sub(self.since) as f64 * 1e-9,
        };
        // Phases of no length are passed within one tick.
        for _ in 0..Phase::ALL.len() {
            let elapsed = now.saturating_sub(self.since) as f64 * 1e-9;
            let next = self.phase.next(Situation { elapsed, ..situation }, &self.config.durations);
            if next == self.phase {
                break;
            }
            self.enter(next, now);
        }
        let elapsed = now.saturating_sub(self.since) as f64 * 1e-9;
        let share = |duration: f64| if duration > 0.0 { (elapsed / duration).min(1.0) as f32 } else { 1.0 };
        let durations = self.config.durations;
        let (mut rate, mut up_b, mut compares) = (f32::MAX, Some(self.motions.first_up_b()), false);
        let mode = match self.phase {
            Phase::Idle => Mode::Off,
            Phase::Damp => Mode::Damp,
            Phase::Stand => {
                rate = self.config.stand_rate as f32;
                blend(&self.pose, self.motions.first_joints(), share(durations.stand), &mut self.targets);
                Mode::Position
            }
            Phase::GetUp => {
                if let (Some(rescue), Some(measured)) = (&mut self.rescue, self.gate.measured()) {
                    rescue.write(measured, self.ticks_per_step, &mut self.targets);
                }
                up_b = None;
                Mode::Position
            }
            Phase::BlendIn | Phase::Run | Phase::BlendOut => {
                self.follow();
                up_b = Some(self.motions.up_b());
                compares = true;
                let weight = match self.phase {
                    Phase::BlendIn => share(durations.blend_in),
                    Phase::Run => 1.0,
                    _ => 1.0 - share(durations.blend_out),
                };
                for (target, pose) in self.targets.iter_mut().zip(&self.pose) {
                    *target = if weight < 1.0 { pose + (*target - pose) * weight } else { *target };
                }
                Mode::Position
            }
        };
        let reference = if compares { self.motions.joints() } else { &[] };
        self.gate.pass(now, Intent { mode, targets: &self.targets, rate, reference, up_b })
    }

    fn enter(&mut self, phase: Phase, now: u64) {
        let before = std::mem::replace(&mut self.phase, phase);
        self.since = now;
        match phase {
            Phase::Stand => {
                if let Some(measured) = self.gate.measured() {
                    self.pose.copy_from_slice(&measured.position);
                }
            }
            Phase::BlendIn => {
                self.motions.rewind();
                self.pose.copy_from_slice(self.motions.first_joints());
                self.take_over();
            }
            Phase::GetUp => {
                self.gate.pardon_fall(self.motions.first_up_b());
                if let (Some(rescue), Some(measured)) = (&mut self.rescue, self.gate.measured()) {
                    rescue.begin(&measured.position);
                }
            }
            Phase::Run if before == Phase::GetUp => {
                self.motions.resume();
                self.pose.copy_from_slice(&self.targets);
                self.take_over();
                if let Some(rescue) = &mut self.rescue {
                    rescue.end();
                }
            }
            Phase::BlendOut => self.pose.copy_from_slice(&self.targets),
            Phase::Idle | Phase::Run | Phase::Damp => {}
        }
    }

    /// Begins the policy's steps anew, from the pose.
    fn take_over(&mut self) {
        self.state.history.begun = false;
        self.before.copy_from_slice(&self.pose);
        self.after.copy_from_slice(&self.pose);
        self.tick = 0;
    }

    /// Writes the policy's targets of this tick.
    fn follow(&mut self) {
        if self.tick == self.ticks_per_step {
            self.tick = 0;
        }
        let over = (self.config.interpolation * self.ticks_per_step as f64).max(1.0) as f32;
        if self.tick == 0 {
            self.before.copy_from_slice(&self.after);
            if let Err(error) = self.step() {
                // No number passes the gate, which brakes.
                self.after.fill(f32::NAN);
                self.failed.get_or_insert(error);
            }
        }
        self.tick += 1;
        blend(&self.before, &self.after, (self.tick as f32 / over).min(1.0), &mut self.targets);
    }

    /// Makes one step of the policy.
    fn step(&mut self) -> Result<(), RobotError> {
        let Some(packet) = self.gate.measured() else { return Ok(()) };
        let measured = MeasuredState {
            joint_position: &packet.position,
            joint_velocity: &packet.velocity,
            root_orientation: packet.orientation,
            ..MeasuredState::default()
        };
        let estimate = self.estimator.as_ref().and_then(StateEstimator::estimate);
        let measured = match (packet.external, estimate) {
            (None, Some(estimate)) => MeasuredState {
                root_orientation: estimate.orientation,
                root_position: Some(estimate.position),
                linear_velocity_w: Some(estimate.linear_velocity_w),
                ..measured
            }
            .with_gyroscope(estimate.angular_velocity_b),
            (external, _) => MeasuredState {
                root_position: external.map(|external| external.position),
                linear_velocity_w: external.map(|external| external.linear_velocity_w),
                ..measured
            }
            .with_gyroscope(packet.gyroscope_b),
        };
        if self.motions.next_part() {
            let root = self.motions.player().present_root();
            let place = measured.root_position.unwrap_or(root.position);
            self.state.history.alignment =
                Alignment::between(root.position, root.orientation, place, measured.root_orientation);
        }
        self.steps += 1;
        self.controller.step(&mut self.state, &measured, self.motions.player(), &mut self.after)
    }
}

/// Writes `from` and `to` mixed, `to` with this weight; exactly `to` at 1.
fn blend(from: &[f32], to: &[f32], weight: f32, out: &mut [f32]) {
    for ((out, from), to) in out.iter_mut().zip(from).zip(to) {
        *out = if weight < 1.0 { from + (to - from) * weight } else { *to };
    }
}
