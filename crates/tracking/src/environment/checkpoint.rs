//! Checkpoints of the environments: everything that a run goes on from, bit for bit.

use lifelike_checkpoint::Checkpoint;
use lifelike_sim::IntegrationState;

use super::Environment;
use super::statistics::EpisodeStatistics;
use crate::{FromInput, TrackerError, episode};

impl Environment {
    /// Writes everything needed to go on bit for bit.
    ///
    /// # Errors
    /// Two entries of one name.
    pub fn save_into(&self, checkpoint: &mut Checkpoint, prefix: &str) -> Result<(), TrackerError> {
        let n = self.len();
        let key = |name: &str| format!("{prefix}.{name}");
        let integration = self.simulation.save();
        checkpoint.set_meta(&key("engine"), &integration.engine)?;
        checkpoint.set_meta(&key("parameters"), &integration.parameters)?;
        checkpoint.set_meta(&key("pushes"), &self.pushes)?;
        checkpoint.put_u64(&key("counters"), &[2], vec![self.steps, integration.width as u64])?;
        checkpoint.put_f64(&key("simulation"), &[n, integration.width], integration.values)?;
        // The outputs of the last step (forces) are not part of the integration state, but of what was observed.
        checkpoint.put_f32(&key("actor_rows"), &[n, self.actor_size()], self.rows.actor.clone())?;
        checkpoint.put_f32(&key("critic_rows"), &[n, self.critic_size()], self.rows.critic.clone())?;
        let starts = self.rsi.save();
        checkpoint.put_f64(&key("starts"), &[starts.len()], starts)?;
        let (recent, survival) = self.statistics.save();
        checkpoint.put_f64(&key("recent"), &[recent.len()], recent)?;
        checkpoint.put_f64(&key("survival"), &[survival.len()], survival)?;
        episode::save(&self.episodes, checkpoint, &key("episodes"))?;
        Ok(())
    }

    /// Goes on from a checkpoint.
    ///
    /// # Errors
    /// The checkpoint is of another plan, library or engine.
    pub fn load(&mut self, checkpoint: &Checkpoint, prefix: &str) -> Result<(), TrackerError> {
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
        self.rows.actor = checkpoint.f32s(&key("actor_rows"), &[n, self.actor_size()])?;
        self.rows.critic = checkpoint.f32s(&key("critic_rows"), &[n, self.critic_size()])?;
        let numbers = |name: &str| {
            let shape = checkpoint.entry(&key(name))?.shape().to_vec();
            checkpoint.f64s(&key(name), &shape)
        };
        let starts = numbers("starts")?;
        self.rsi = self.rsi.clone().restored(&starts).ok_or_else(|| {
            TrackerError::mismatch(
                "clips of the checkpoint",
                "those of the plan",
                format!("{} numbers of failure statistics", starts.len()),
            )
        })?;
        self.advance_curriculum();
        self.statistics = EpisodeStatistics::restored(&numbers("recent")?, numbers("survival")?);
        let sizes = (self.setup.robot.joints(), self.setup.observer.remembered());
        self.episodes = episode::load(checkpoint, &key("episodes"), &self.episodes, sizes)?;
        Ok(())
    }
}
