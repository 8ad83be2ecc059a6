//! Many environments in which a policy follows references: what PPO collects experience in.
//!
//! Time: the state at t is compared with frame t. The policy sees the state at t and frame t+1 (and z_{t+1}), acts, the
//! simulation goes one step, and the reward compares the state at t+1 with frame t+1.

use std::sync::Arc;

use lifelike_nn::checkpoint::Checkpoint;
use lifelike_nn::rng::stream;
use lifelike_robot::{ActionMap, ActionSpec, ObservationSpec, Robot};
use lifelike_sim::randomization::{PushSchedule, RandomizationSpec};
use lifelike_sim::{BatchState, Drive, IntegrationState, Simulation};
use rand::Rng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use rayon::prelude::*;

use super::alignment::Alignment;
use super::episode::{self, Episode};
use super::errors::root;
use super::ground::{Ground, Start};
use super::judge::{Judge, Scratch};
use super::library::ReferenceLibrary;
use super::observe::Observer;
use super::plan::{Termination, TrackerPlan};
use super::rewards::Reward;
use super::senses::Senses;
use super::starts::{Coverage, StartSampler};
use super::tally::Tally;
use crate::error::LearnError;

/// Environments that one thread takes at a time.
const CHUNK: usize = 16;

/// The environments, between two steps.
pub struct Environment {
    plan: TrackerPlan,
    /// Number of the first environment among those of all processes: what its randomness is addressed by.
    first: usize,
    processes: usize,
    robot: Arc<Robot>,
    library: Arc<ReferenceLibrary>,
    simulation: Box<dyn Simulation>,
    observer: Observer,
    ground: Ground,
    actions: ActionMap,
    divisor: Vec<f32>,
    sampler: StartSampler,
    senses: Senses,
    /// Randomisation, limits and the factor on penalties at this stage of the curriculum.
    randomization: RandomizationSpec,
    limits: Termination,
    smoothness: f32,
    /// One per environment where the plan has pushes, else none.
    pushes: Vec<PushSchedule>,
    episodes: Vec<Episode>,
    targets: Vec<f32>,
    actor: Vec<f32>,
    critic: Vec<f32>,
    steps: u64,
    tally: Tally,
}

/// What a step gave, `N` environments.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Outcome {
    /// Reward, `[N]`.
    pub rewards: Vec<f32>,
    /// The episode failed, `[N]`: nothing follows.
    pub terminated: Vec<bool>,
    /// The episode was cut, `[N]`: something would follow.
    pub truncated: Vec<bool>,
    /// What the value function would see in the cut environments, in their order, `[cut, P]`: their rows of
    /// [`Environment::critic_rows`] already belong to the next episode.
    pub final_critic_rows: Vec<f32>,
}

impl Environment {
    /// Environments in fresh episodes.
    ///
    /// # Errors
    /// The library or the simulation is of another robot or size than the plan says.
    pub fn new(
        plan: &TrackerPlan,
        robot: Arc<Robot>,
        library: Arc<ReferenceLibrary>,
        simulation: Box<dyn Simulation>,
    ) -> Result<Self, LearnError> {
        Self::among(plan, robot, library, simulation, (0, 1))
    }

    /// The same as that process of so many (counted from 0), which all have as many environments.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn among(
        plan: &TrackerPlan,
        robot: Arc<Robot>,
        library: Arc<ReferenceLibrary>,
        simulation: Box<dyn Simulation>,
        (process, processes): (usize, usize),
    ) -> Result<Self, LearnError> {
        let n = plan.ppo.environments;
        expect("environments of the simulation", n, simulation.len())?;
        expect("latent size of the library", plan.inputs.latent, library.latent)?;
        if simulation.robot().layout != robot.layout || library.layout != robot.layout {
            return Err(LearnError::Mismatch {
                what: "joints and end effectors of simulation and library".into(),
                expected: format!("those of robot '{}'", robot.name),
                got: "others".into(),
            });
        }
        let spec = ObservationSpec::new(&robot, plan.inputs.clone(), plan.anchor);
        let spec = if plan.linear_velocity { spec } else { spec.without_linear_velocity() };
        let observer = Observer::new(&robot, spec);
        let bin = (0.5 * robot.control_hz).round() as usize;
        let divisor = match &plan.reward {
            Reward::Thesis(reward) => reward.floors.apply(&library.layout, &library.deviation),
            Reward::Exponential(_) => Vec::new(),
        };
        let mut environment = Self {
            actions: ActionMap::new(plan.action, &robot),
            divisor,
            sampler: StartSampler::new(plan.starts, &library.starts, bin, 2 * bin),
            senses: Senses::new(plan.senses, observer.spec()),
            randomization: plan.randomization.clone(),
            limits: plan.termination,
            smoothness: 1.0,
            pushes: vec![
                PushSchedule { steps: 0, active: None };
                if plan.randomization.pushes.is_some() { n } else { 0 }
            ],
            episodes: vec![Episode::new(robot.joints()); n],
            targets: vec![0.0; n * robot.joints()],
            actor: vec![0.0; n * observer.actor_size()],
            critic: vec![0.0; n * observer.critic_size()],
            steps: 0,
            tally: Tally::new(library.clips()),
            plan: plan.clone(),
            first: process * n,
            processes,
            ground: Ground::of(simulation.as_ref(), &robot),
            robot,
            library,
            simulation,
            observer,
        };
        environment.advance_curriculum();
        environment.reset(&(0..n).collect::<Vec<_>>(), None)?;
        Ok(environment)
    }

    /// Number of environments N.
    pub fn len(&self) -> usize {
        self.episodes.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.episodes.is_empty()
    }

    /// What the randomness of environment `i` is addressed by.
    pub fn address(&self, i: usize) -> u64 {
        (self.first + i) as u64
    }

    /// The layout of what the policy sees.
    pub fn observation(&self) -> &ObservationSpec {
        self.observer.spec()
    }

    /// Length of a row of [`Self::actor_rows`].
    pub fn actor_size(&self) -> usize {
        self.observer.actor_size()
    }

    /// Length of a row of [`Self::critic_rows`].
    pub fn critic_size(&self) -> usize {
        self.observer.critic_size()
    }

    /// What the policy sees now, `[N, O]`, not normalised.
    pub fn actor_rows(&self) -> &[f32] {
        &self.actor
    }

    /// What the value function sees now, `[N, P]`: the same and more, not normalised.
    pub fn critic_rows(&self) -> &[f32] {
        &self.critic
    }

    /// What they stand on.
    pub fn ground(&self) -> &Ground {
        &self.ground
    }

    /// The simulation, to disturb it.
    pub fn simulation_mut(&mut self) -> &mut dyn Simulation {
        self.simulation.as_mut()
    }

    /// The simulated states.
    pub fn state(&self) -> &BatchState {
        self.simulation.state()
    }

    /// The episodes, with what the last step gave.
    pub fn episodes(&self) -> &[Episode] {
        &self.episodes
    }

    /// What happened since [`Tally::start`].
    pub fn tally(&self) -> &Tally {
        &self.tally
    }

    /// The same, to begin counting anew.
    pub fn tally_mut(&mut self) -> &mut Tally {
        &mut self.tally
    }

    /// How much of the motion was ever seen, and the floor below which no stretch of it is neglected.
    pub fn coverage(&self) -> (Coverage, f64) {
        (self.sampler.coverage(), self.sampler.floor())
    }

    /// Once per iteration: puts what was learnt about hard stretches into force, and the curriculum's next stage.
    pub fn refresh(&mut self) {
        self.sampler.refresh();
        self.advance_curriculum();
    }

    fn advance_curriculum(&mut self) {
        let [share, forgiving, smoothness] = self.plan.curriculum.at(self.steps * (self.len() * self.processes) as u64);
        if self.plan.curriculum.randomization.is_some() {
            self.randomization = self.plan.randomization.scaled(share);
        }
        if self.plan.curriculum.termination.is_some() {
            self.limits = self.plan.termination.scaled(forgiving);
        }
        self.smoothness = smoothness as f32;
    }

    /// One step of all environments with the policy's outputs `[N, J]`. Environments whose episode ends begin another.
    ///
    /// # Errors
    /// `outputs` has the wrong length; the simulation fails as a whole. A single environment that diverges is no error:
    /// its episode ends with no reward, is counted and begun anew.
    pub fn step(&mut self, outputs: &[f32], outcome: &mut Outcome) -> Result<(), LearnError> {
        let joints = self.robot.joints();
        expect("outputs of the policy", self.len() * joints, outputs.len())?;
        self.aim(outputs);
        self.push()?;
        self.simulation.step(Drive::Targets(&self.targets))?;
        self.steps += 1;
        self.judge();
        let width = self.critic_size();
        outcome.rewards.clear();
        outcome.terminated.clear();
        outcome.truncated.clear();
        outcome.final_critic_rows.clear();
        let mut ended = Vec::new();
        for (i, episode) in self.episodes.iter().enumerate() {
            outcome.rewards.push(episode.reward());
            outcome.terminated.push(episode.failed.is_some());
            outcome.truncated.push(episode.cut);
            self.tally.step(episode, self.library.clip_of(episode.frame));
            if episode.cut {
                outcome.final_critic_rows.extend_from_slice(&self.critic[i * width..(i + 1) * width]);
            }
            if let Some((from, to)) = episode.finished {
                self.sampler.record(from, to, false);
            }
            if episode.ended() {
                self.sampler.record(episode.stretch, episode.frame, episode.failed.is_some());
                ended.push(i);
            }
        }
        if ended.is_empty() { Ok(()) } else { self.reset(&ended, None) }
    }

    /// Joint targets from the policy's outputs.
    fn aim(&mut self, outputs: &[f32]) {
        let joints = self.robot.joints();
        let (actions, library) = (&self.actions, &self.library);
        let rows =
            self.episodes.iter_mut().zip(outputs.chunks_exact(joints)).zip(self.targets.chunks_exact_mut(joints));
        for ((episode, output), target) in rows {
            std::mem::swap(&mut episode.before, &mut episode.oldest);
            std::mem::swap(&mut episode.last, &mut episode.before);
            for (last, y) in episode.last.iter_mut().zip(output) {
                // A policy that says NaN says nothing; its environment goes on, and the update will not step with it.
                *last = if y.is_finite() { ActionSpec::clamp_output(*y) } else { 0.0 };
            }
            actions.write(&episode.last, library.joints_at(library.ahead(episode.frame, 1)), target);
            target.iter_mut().zip(&episode.offset).for_each(|(t, o)| *t -= o);
            Senses::delay(target, episode);
        }
    }

    /// Begins and ends random pushes.
    fn push(&mut self) -> Result<(), LearnError> {
        let Some(spec) = &self.randomization.pushes else { return Ok(()) };
        for (i, schedule) in self.pushes.iter_mut().enumerate() {
            let mut rng = stream(self.plan.seed, "push", (self.first + i) as u64, self.steps);
            schedule.advance(spec, self.simulation.as_mut(), i, &mut rng)?;
        }
        Ok(())
    }

    /// Rewards, ends and observations after a step, each environment by itself.
    fn judge(&mut self) {
        let this = Judge {
            plan: &self.plan,
            robot: &self.robot,
            library: &self.library,
            observer: &self.observer,
            ground: &self.ground,
            sampler: &self.sampler,
            senses: &self.senses,
            limits: self.limits,
            smoothness: self.smoothness,
            divisor: &self.divisor,
            state: self.simulation.state(),
            step: self.steps,
            first: self.first,
            longest: (self.plan.episode.seconds * self.robot.control_hz).round().max(1.0) as u64,
        };
        let (a, c) = (self.observer.actor_size(), self.observer.critic_size());
        self.episodes
            .par_chunks_mut(CHUNK)
            .zip(self.actor.par_chunks_mut(CHUNK * a))
            .zip(self.critic.par_chunks_mut(CHUNK * c))
            .enumerate()
            .for_each_init(Scratch::new, |scratch, (chunk, ((episodes, actor), critic))| {
                let rows = episodes.iter_mut().zip(actor.chunks_exact_mut(a)).zip(critic.chunks_exact_mut(c));
                for (k, ((episode, actor), critic)) in rows.enumerate() {
                    this.judge(chunk * CHUNK + k, episode, scratch, actor, critic);
                }
            });
    }

    /// Begins episodes: as `given`, else where the sampler says.
    ///
    /// # Errors
    /// The simulation refuses.
    pub fn reset(&mut self, ids: &[usize], given: Option<&[Start]>) -> Result<(), LearnError> {
        let character = Arc::clone(&self.robot.character);
        let (nq, nv) = (character.nq, character.nv);
        let mut positions = vec![0.0; ids.len() * nq];
        let mut velocities = vec![0.0; ids.len() * nv];
        let starts = self.plan.starts;
        for (k, &i) in ids.iter().enumerate() {
            let mut rng = stream(self.plan.seed, "reset", self.address(i), self.episodes[i].number);
            let start = given.map_or_else(|| Start::at(self.sampler.draw(&mut rng)), |starts| starts[k].clone());
            let frame = start.frame;
            let spot = start.spot.unwrap_or_else(|| self.ground.spot(&mut rng));
            let parameters = start.parameters.unwrap_or_else(|| self.randomization.sample(&self.robot, &mut rng));
            let episode = Episode {
                number: self.episodes[i].number + 1,
                frame,
                stretch: frame,
                alignment: beside(&self.library, frame, spot, starts.path_noise, starts.heading_noise, &mut rng),
                offset: if parameters.joint_offset.is_empty() {
                    vec![0.0; self.robot.joints()]
                } else {
                    parameters.joint_offset.clone()
                },
                ..Episode::new(self.robot.joints())
            };
            self.simulation.set_parameters(i, parameters)?;
            self.simulation.clear_pushes(i);
            if let Some(spec) = &self.randomization.pushes {
                self.pushes[i] = PushSchedule::new(spec, self.robot.control_hz, &mut rng);
            }
            let mut late = |greatest: u32| u64::from(rng.random_range(0..=greatest));
            let senses = self.plan.senses;
            let (observation_delay, action_delay) = (late(senses.observation_delay), late(senses.action_delay));
            let episode = Episode {
                observation_delay,
                action_delay,
                measured: vec![0.0; self.senses.memory()],
                waiting: vec![0.0; senses.action_delay as usize * self.robot.joints()],
                ..episode
            };
            let q = &mut positions[k * nq..(k + 1) * nq];
            let v = &mut velocities[k * nv..(k + 1) * nv];
            self.write_start(frame, spot, &mut rng, q, v);
            self.episodes[i] = episode;
        }
        self.simulation.reset(ids, &positions, &velocities)?;
        let mut scratch = Scratch::new();
        for &i in ids {
            self.rest(i);
            self.observe(i, &mut scratch);
            let episode = &mut self.episodes[i];
            let (number, a) = (episode.number, self.observer.actor_size());
            let rng = || stream(self.plan.seed, "first sense", (self.first + i) as u64, number);
            self.senses.tell(&mut self.actor[i * a..(i + 1) * a], episode, rng);
        }
        Ok(())
    }

    /// From one moment to the next, environment `i` is asked to go on from another frame of the library, laid where its
    /// robot is.
    pub fn jump(&mut self, i: usize, frame: usize) {
        let (position, orientation) = root(self.simulation.state(), i);
        let clip = (self.library.position_at(frame), self.library.orientation_at(frame));
        let episode = &mut self.episodes[i];
        episode.frame = frame;
        episode.stretch = frame;
        episode.alignment = Alignment::between(clip.0, clip.1, position, orientation);
        self.observe(i, &mut Scratch::new());
    }

    /// What policy and value function see of environment `i` in its present state.
    fn observe(&mut self, i: usize, scratch: &mut Scratch) {
        let episode = &self.episodes[i];
        let next = self.library.ahead(episode.frame, 1);
        scratch.read(self.simulation.state(), i, &self.robot, &self.library, &self.ground);
        let (a, c) = (self.observer.actor_size(), self.observer.critic_size());
        self.observer.write(
            self.simulation.state(),
            i,
            episode,
            &self.library,
            next,
            &scratch.features,
            &mut self.actor[i * a..(i + 1) * a],
            &mut self.critic[i * c..(i + 1) * c],
        );
    }

    /// Generalised position and velocity of a frame at a place of the simulated world, with noise.
    fn write_start(&self, frame: usize, spot: [f64; 2], rng: &mut ChaCha8Rng, q: &mut [f64], v: &mut [f64]) {
        let (library, starts) = (&self.library, self.plan.starts);
        let mut noise = |deviation: f32| {
            let z: f64 = StandardNormal.sample(rng);
            z * f64::from(deviation)
        };
        let w = library.orientation_at(frame);
        let root = lifelike_character::rotation::from_wxyz(w.map(f64::from)).unwrap_or_default();
        let linear = library.linear_velocity_at(frame).map(f64::from);
        let angular = library.angular_velocity_at(frame).map(f64::from);
        let angular_b = root.inverse() * lifelike_character::Vec3::from(angular);
        q.copy_from_slice(&self.robot.default_position());
        let (joints, rates) = (library.joints_at(frame), library.joint_velocities_at(frame));
        let mut scalar = 0;
        for joint in &self.robot.character.joints {
            let (at, rate) = (joint.q_index, joint.v_index);
            if joint.kind == lifelike_character::JointKind::Free {
                // Two millimetres of air: a foot that begins in the ground is thrown out of it.
                let height = f64::from(library.position_at(frame)[2]) + self.ground.lift(spot) + 0.002;
                q[at..at + 3].copy_from_slice(&[spot[0], spot[1], height]);
                q[at + 3..at + 7].copy_from_slice(&lifelike_character::rotation::to_wxyz(&root));
                for k in 0..3 {
                    v[rate + k] = linear[k] + noise(starts.velocity_noise);
                    v[rate + 3 + k] = angular_b[k] + noise(starts.velocity_noise);
                }
            } else if joint.kind.nq() == 1 {
                q[at] = f64::from(joints[scalar]) + noise(starts.joint_noise);
                v[rate] = f64::from(rates[scalar]);
                scalar += 1;
            }
        }
    }

    /// Last actions that fit the pose in which an episode begins.
    fn rest(&mut self, i: usize) {
        let joints = self.robot.joints();
        let episode = &mut self.episodes[i];
        let reference = self.library.joints_at(self.library.ahead(episode.frame, 1));
        let q = &self.simulation.state().joint_position[i * joints..(i + 1) * joints];
        for j in 0..joints {
            let y = match self.plan.action {
                ActionSpec::Absolute => q[j],
                ActionSpec::DefaultPose { scale } => (q[j] - self.actions.default_pose[j]) / scale as f32,
                ActionSpec::Reference { scale } => (q[j] - reference[j]) / scale as f32,
            };
            episode.last[j] = ActionSpec::clamp_output(y);
            episode.before[j] = episode.last[j];
            episode.oldest[j] = episode.last[j];
        }
    }

    /// Writes everything needed to go on bit for bit.
    ///
    /// # Errors
    /// Two entries of one name.
    pub fn save_into(&self, checkpoint: &mut Checkpoint, prefix: &str) -> Result<(), LearnError> {
        let n = self.len();
        let key = |name: &str| format!("{prefix}.{name}");
        let integration = self.simulation.save();
        checkpoint.set_meta(&key("engine"), &integration.engine)?;
        checkpoint.set_meta(&key("parameters"), &integration.parameters)?;
        checkpoint.set_meta(&key("pushes"), &self.pushes)?;
        checkpoint.put_u64(&key("counters"), &[2], vec![self.steps, integration.width as u64])?;
        checkpoint.put_f64(&key("simulation"), &[n, integration.width], integration.values)?;
        // The outputs of the last step (forces) are not part of the integration state, but of what was observed.
        checkpoint.put_f32(&key("actor_rows"), &[n, self.actor_size()], self.actor.clone())?;
        checkpoint.put_f32(&key("critic_rows"), &[n, self.critic_size()], self.critic.clone())?;
        let starts = self.sampler.save();
        checkpoint.put_f64(&key("starts"), &[starts.len()], starts)?;
        let (recent, survival) = self.tally.save();
        checkpoint.put_f64(&key("recent"), &[recent.len()], recent)?;
        checkpoint.put_f64(&key("survival"), &[survival.len()], survival)?;
        episode::save(&self.episodes, checkpoint, &key("episodes"))?;
        Ok(())
    }

    /// Goes on from a checkpoint.
    ///
    /// # Errors
    /// The checkpoint is of another plan, library or engine.
    pub fn load(&mut self, checkpoint: &Checkpoint, prefix: &str) -> Result<(), LearnError> {
        let n = self.len();
        let key = |name: &str| format!("{prefix}.{name}");
        let counters = checkpoint.u64s(&key("counters"), &[2])?;
        let width = counters[1] as usize;
        let integration = IntegrationState {
            engine: checkpoint.meta(&key("engine"))?,
            width,
            values: checkpoint.f64s(&key("simulation"), &[n, width])?,
            parameters: checkpoint.meta(&key("parameters"))?,
        };
        self.simulation.restore(&integration)?;
        self.steps = counters[0];
        self.pushes = checkpoint.meta(&key("pushes"))?;
        self.actor = checkpoint.f32s(&key("actor_rows"), &[n, self.actor_size()])?;
        self.critic = checkpoint.f32s(&key("critic_rows"), &[n, self.critic_size()])?;
        let numbers = |name: &str| {
            let shape = checkpoint.entry(&key(name))?.shape().to_vec();
            checkpoint.f64s(&key(name), &shape)
        };
        let starts = numbers("starts")?;
        self.sampler = self.sampler.clone().restored(&starts).ok_or_else(|| LearnError::Mismatch {
            what: "clips of the checkpoint".into(),
            expected: "those of the plan".into(),
            got: format!("{} numbers of start statistics", starts.len()),
        })?;
        self.advance_curriculum();
        self.tally = Tally::restored(&numbers("recent")?, numbers("survival")?);
        self.episodes = episode::load(checkpoint, &key("episodes"), &self.episodes, self.robot.joints())?;
        Ok(())
    }
}

/// The clip's world laid so that the robot, which begins at `spot` facing as in the clip, is a little off.
fn beside(
    library: &ReferenceLibrary,
    frame: usize,
    spot: [f64; 2],
    path: f32,
    heading: f32,
    rng: &mut ChaCha8Rng,
) -> Alignment {
    let mut noise = |deviation: f32| {
        let z: f32 = StandardNormal.sample(rng);
        z * deviation
    };
    let p = library.position_at(frame);
    Alignment { yaw: noise(heading), from: [p[0], p[1]], to: spot.map(|s| s as f32 + noise(path)) }
}

fn expect(what: &str, expected: usize, got: usize) -> Result<(), LearnError> {
    if expected == got {
        return Ok(());
    }
    Err(LearnError::Mismatch { what: what.into(), expected: expected.to_string(), got: got.to_string() })
}
