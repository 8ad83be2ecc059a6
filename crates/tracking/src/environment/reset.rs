//! The beginning of episodes: frame, place, parameters and simulated state.

use std::sync::Arc;

use lifelike_robot::{Alignment, ReferenceLibrary};
use lifelike_sim::fallen;
use lifelike_sim::randomization::PushSchedule;
use rand::Rng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use super::Environment;
use super::setup::Setup;
use super::start::Start;
use super::state::write_features;
use crate::TrackerError;
use crate::observe::Observed;

impl Environment {
    /// Begins episodes: as `given`, else where the sampler says.
    ///
    /// # Errors
    /// The simulation refuses.
    pub fn reset(&mut self, ids: &[usize], given: Option<&[Start]>) -> Result<(), TrackerError> {
        let (robot, library) = (Arc::clone(&self.setup.robot), Arc::clone(&self.setup.library));
        let character = &robot.character;
        let (nq, nv) = (character.nq, character.nv);
        let mut positions = vec![0.0; ids.len() * nq];
        let mut velocities = vec![0.0; ids.len() * nv];
        let (rsi, sensors) = (self.setup.plan.rsi, self.setup.plan.sensors);
        let grace = (self.setup.plan.episode.grace_seconds * robot.control_hz).round() as u64;
        for (k, &i) in ids.iter().enumerate() {
            let mut rng = self.setup.stream("reset", i, self.episodes[i].number);
            let start = given.map_or_else(|| Start::at(self.draw(i, &mut rng)), |starts| starts[k].clone());
            let frame = start.frame;
            let other = given.is_none() && rsi.random_start_share > 0.0;
            let pose = (other && rng.random_bool(rsi.random_start_share)).then(|| self.draw(i, &mut rng));
            let position = start.position.unwrap_or_else(|| self.setup.ground.spot(&mut rng));
            let parameters = start.parameters.unwrap_or_else(|| self.stage.randomization.sample(&robot, &mut rng));
            let episode = &mut self.episodes[i];
            episode.begin(frame);
            episode.alignment = beside(&library, frame, position, rsi.path_noise, rsi.heading_noise, &mut rng);
            if let Some(pose) = pose {
                let root = |frame: usize| (library.position_at(frame), library.orientation_at(frame));
                let ((p, q), (at, facing)) = (root(frame), root(pose));
                episode.alignment.yaw += Alignment::between(p, q, at, facing).yaw;
                episode.grace = grace;
            }
            if !parameters.joint_offset.is_empty() {
                episode.offset.copy_from_slice(&parameters.joint_offset);
            }
            self.simulation.set_parameters(i, parameters)?;
            self.simulation.clear_pushes(i);
            if let Some(spec) = &self.setup.plan.randomization.pushes {
                self.pushes[i] = PushSchedule::new(spec, robot.control_hz, &mut rng);
            }
            let mut late = |greatest: u32| if greatest > 0 { u64::from(rng.random_range(0..=greatest)) } else { 0 };
            (episode.observation_delay, episode.action_delay) =
                (late(sensors.observation_delay), late(sensors.action_delay));
            episode.past_measurements.resize(self.setup.sensors.history(), 0.0);
            episode.past_targets.resize(sensors.action_delay as usize * robot.joints(), 0.0);
            let q = &mut positions[k * nq..(k + 1) * nq];
            let v = &mut velocities[k * nv..(k + 1) * nv];
            self.write_start(pose.unwrap_or(frame), position, &mut rng, q, v);
            if given.is_none() && rsi.fallen_share > 0.0 && rng.random_bool(rsi.fallen_share) {
                let ground = self.setup.ground.lift(position);
                let depth = rng.random();
                fallen::lay_down(character, ground, depth, &mut rng, q, v);
            }
        }
        self.simulation.reset(ids, &positions, &velocities)?;
        for &i in ids {
            self.set_last_actions(i);
            self.observe(i);
            let episode = &mut self.episodes[i];
            let (number, a) = (episode.number, self.setup.observer.actor_size());
            let rng = || self.setup.stream("first sense", i, number);
            let row = &mut self.rows.actor[i * a..(i + 1) * a];
            self.setup.sensors.measure(row, episode, rng);
            self.setup.observer.recall(&mut episode.memory, row);
        }
        Ok(())
    }

    /// Writes the observations of environment `i` in its present state.
    fn observe(&mut self, i: usize) {
        let (setup, state) = (&self.setup, self.simulation.state());
        let features = &mut self.rows.features[..setup.library.layout.size()];
        let heading = write_features(state, i, setup, features);
        let (a, c) = (setup.observer.actor_size(), setup.observer.critic_size());
        let (episode, library) = (&self.episodes[i], &*setup.library);
        setup.observer.write(
            &Observed { state, i, episode, library, features, heading },
            &mut self.rows.actor[i * a..(i + 1) * a],
            &mut self.rows.critic[i * c..(i + 1) * c],
        );
    }

    /// Writes generalised position and velocity of a frame at a place of the simulated world, with noise.
    fn write_start(&self, frame: usize, position: [f64; 2], rng: &mut ChaCha8Rng, q: &mut [f64], v: &mut [f64]) {
        let Setup { plan, robot, library, ground, .. } = &self.setup;
        let rsi = plan.rsi;
        library.write_state(frame, robot, position, ground.lift(position), q, v);
        let mut noise = |deviation: f32| {
            let z: f64 = StandardNormal.sample(rng);
            z * f64::from(deviation)
        };
        for joint in &robot.character.joints {
            if joint.kind == lifelike_character::JointKind::Free {
                for k in 0..3 {
                    v[joint.v_index + k] += noise(rsi.velocity_noise);
                    v[joint.v_index + 3 + k] += noise(rsi.velocity_noise);
                }
            } else if joint.is_scalar() {
                q[joint.q_index] += noise(rsi.joint_noise);
            }
        }
        robot.character.follow(q, v);
    }

    /// Sets last actions that fit the pose in which an episode begins.
    fn set_last_actions(&mut self, i: usize) {
        let Setup { robot, library, actions, .. } = &self.setup;
        let joints = robot.joints();
        let episode = &mut self.episodes[i];
        let next = library.ahead(episode.frame, 1);
        episode.asked = [next; 2];
        let reference = library.joints_at(next);
        let q = &self.simulation.state().joint_position[i * joints..(i + 1) * joints];
        actions.holding(q, reference, &mut episode.last);
        episode.before.copy_from_slice(&episode.last);
        episode.oldest.copy_from_slice(&episode.last);
    }
}

/// Draws an alignment by which the robot, which begins at `position` facing as in the clip, is a little off.
fn beside(
    library: &ReferenceLibrary,
    frame: usize,
    position: [f64; 2],
    path: f32,
    heading: f32,
    rng: &mut ChaCha8Rng,
) -> Alignment {
    let mut noise = |deviation: f32| {
        let z: f32 = StandardNormal.sample(rng);
        z * deviation
    };
    let p = library.position_at(frame);
    Alignment { yaw: noise(heading), from: [p[0], p[1]], to: position.map(|s| s as f32 + noise(path)) }
}
