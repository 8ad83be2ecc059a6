//! How episodes begin: where, in which state, in which world.

use std::sync::Arc;

use lifelike_checkpoint::rng::stream;
use lifelike_robot::{Alignment, ReferenceLibrary};
use lifelike_sim::randomization::PushSchedule;
use rand::Rng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use super::Environment;
use crate::TrackerError;
use crate::episode::Episode;
use crate::errors::root;
use crate::ground::Start;
use crate::judge::Scratch;
use crate::observe::Observed;

impl Environment {
    /// Begins episodes: as `given`, else where the sampler says.
    ///
    /// # Errors
    /// The simulation refuses.
    pub fn reset(&mut self, ids: &[usize], given: Option<&[Start]>) -> Result<(), TrackerError> {
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
            if let Some(spec) = &self.plan.randomization.pushes {
                self.pushes[i] = PushSchedule::new(spec, self.robot.control_hz, &mut rng);
            }
            let mut late = |greatest: u32| if greatest > 0 { u64::from(rng.random_range(0..=greatest)) } else { 0 };
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
        let (state, library) = (self.simulation.state(), &*self.library);
        scratch.read(state, i, &self.robot, library, &self.ground);
        let (a, c) = (self.observer.actor_size(), self.observer.critic_size());
        self.observer.write(
            &Observed { state, i, episode: &self.episodes[i], library, features: &scratch.features },
            &mut self.actor[i * a..(i + 1) * a],
            &mut self.critic[i * c..(i + 1) * c],
        );
    }

    /// Generalised position and velocity of a frame at a place of the simulated world, with noise.
    fn write_start(&self, frame: usize, spot: [f64; 2], rng: &mut ChaCha8Rng, q: &mut [f64], v: &mut [f64]) {
        let (library, starts) = (&self.library, self.plan.starts);
        library.write_state(frame, &self.robot, spot, self.ground.lift(spot), q, v);
        let mut noise = |deviation: f32| {
            let z: f64 = StandardNormal.sample(rng);
            z * f64::from(deviation)
        };
        for joint in &self.robot.character.joints {
            if joint.kind == lifelike_character::JointKind::Free {
                for k in 0..3 {
                    v[joint.v_index + k] += noise(starts.velocity_noise);
                    v[joint.v_index + 3 + k] += noise(starts.velocity_noise);
                }
            } else if joint.kind.nq() == 1 {
                q[joint.q_index] += noise(starts.joint_noise);
            }
        }
    }

    /// Last actions that fit the pose in which an episode begins.
    fn rest(&mut self, i: usize) {
        let joints = self.robot.joints();
        let episode = &mut self.episodes[i];
        let reference = self.library.joints_at(self.library.ahead(episode.frame, 1));
        let q = &self.simulation.state().joint_position[i * joints..(i + 1) * joints];
        self.actions.holding(q, reference, &mut episode.last);
        episode.before.copy_from_slice(&episode.last);
        episode.oldest.copy_from_slice(&episode.last);
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
