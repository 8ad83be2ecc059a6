//! Settings of the algorithm and sizes of its networks, as plans have them.

use crate::limits::{PlanError, range, whole};

/// Proximal policy optimization (Schulman et al. 2017).
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct PpoSpec {
    /// Environments.
    pub environments: usize,
    /// Steps of each environment per iteration.
    pub steps: usize,
    /// Passes over the rollout.
    pub epochs: usize,
    /// Samples per gradient step.
    pub minibatch: usize,
    /// Clip range ε.
    pub clip: f64,
    /// Discount γ.
    pub gamma: f32,
    /// GAE's λ.
    pub lambda: f32,
    /// KL divergence per iteration that the learning rate is steered to.
    pub target_divergence: f64,
    /// First learning rate of the policy.
    pub learning_rate: f64,
    /// Its bounds.
    pub learning_rate_bounds: [f64; 2],
    /// Learning rate of the value function; constant.
    pub critic_learning_rate: f64,
    /// Collect the next rollout while the last one is learned from: what acts is one update behind.
    pub overlap: bool,
    /// Weight of the entropy.
    pub entropy: f64,
    /// Share of the iterations so far over which the policy that is written is averaged; 0: the last one as it is.
    pub averaging: f64,
    /// Largest norm of each network's gradient.
    pub gradient_norm: f64,
    /// Standard deviation of the first policy, in units of its output.
    pub initial_std: f64,
    /// Bounds of the standard deviation.
    pub std_bounds: [f64; 2],
}

impl Default for PpoSpec {
    fn default() -> Self {
        Self {
            environments: 256,
            steps: 12,
            epochs: 4,
            minibatch: 1536,
            clip: 0.2,
            gamma: 0.97,
            lambda: 0.95,
            target_divergence: 0.05,
            learning_rate: 1e-3,
            learning_rate_bounds: [2e-5, 3e-3],
            critic_learning_rate: 1e-3,
            overlap: false,
            entropy: 0.0,
            averaging: 0.5,
            gradient_norm: 1.0,
            initial_std: 0.4,
            std_bounds: [0.05, 1.6],
        }
    }
}

impl PpoSpec {
    /// Checks that every value is in its range.
    ///
    /// # Errors
    /// The key, the range and the value.
    pub fn check(&self) -> Result<(), PlanError> {
        let p = self;
        whole("ppo.environments", p.environments as u64, 1, 1 << 20)?;
        whole("ppo.steps", p.steps as u64, 1, 4096)?;
        whole("ppo.epochs", p.epochs as u64, 1, 100)?;
        whole("ppo.minibatch", p.minibatch as u64, 2, (p.environments * p.steps) as u64)?;
        range("ppo.clip", p.clip, 1e-3, 1.0)?;
        range("ppo.gamma", p.gamma.into(), 0.0, 1.0)?;
        range("ppo.lambda", p.lambda.into(), 0.0, 1.0)?;
        range("ppo.target_divergence", p.target_divergence, 1e-6, 10.0)?;
        range("ppo.learning_rate_bounds[0]", p.learning_rate_bounds[0], 1e-9, 1.0)?;
        range("ppo.learning_rate_bounds[1]", p.learning_rate_bounds[1], p.learning_rate_bounds[0], 1.0)?;
        range("ppo.learning_rate", p.learning_rate, p.learning_rate_bounds[0], p.learning_rate_bounds[1])?;
        range("ppo.critic_learning_rate", p.critic_learning_rate, 1e-9, 1.0)?;
        range("ppo.entropy", p.entropy, 0.0, 1.0)?;
        range("ppo.averaging", p.averaging, 0.0, 1.0)?;
        range("ppo.gradient_norm", p.gradient_norm, 1e-6, 1e6)?;
        range("ppo.std_bounds[0]", p.std_bounds[0], 1e-6, 100.0)?;
        range("ppo.std_bounds[1]", p.std_bounds[1], p.std_bounds[0], 100.0)?;
        range("ppo.initial_std", p.initial_std, p.std_bounds[0], p.std_bounds[1])
    }
}

/// Sizes of the ELU networks.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct NetworkSpec {
    /// Hidden layers of the policy.
    pub actor: Vec<usize>,
    /// Hidden layers of the value function.
    pub critic: Vec<usize>,
    /// Hidden layers of an encoder of the observation's window ([`crate::VectorEnvironment::window_size`]), trained with the
    /// policy.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub encoder: Vec<usize>,
    /// Size of its code.
    #[serde(skip_serializing_if = "is_zero")]
    pub code: usize,
}

#[allow(clippy::trivially_copy_pass_by_ref)] // serde hands out a reference
fn is_zero(n: &usize) -> bool {
    *n == 0
}

impl Default for NetworkSpec {
    fn default() -> Self {
        Self { actor: vec![256, 128], critic: vec![256, 128], encoder: Vec::new(), code: 0 }
    }
}

impl NetworkSpec {
    /// Checks that every size is in its range.
    ///
    /// # Errors
    /// The key, the range and the value.
    pub fn check(&self) -> Result<(), PlanError> {
        let networks =
            [("network.actor", &self.actor), ("network.critic", &self.critic), ("network.encoder", &self.encoder)];
        for (key, layers) in networks {
            for width in layers {
                whole(key, *width as u64, 1, 1 << 16)?;
            }
        }
        whole("network.code", self.code as u64, 0, 1 << 16)
    }
}
