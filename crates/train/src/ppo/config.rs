//! Settings of the algorithm and sizes of its networks, as plans have them.

use lifelike_dense::{GruSizes, Sizes};

use crate::VectorEnvironment;
use crate::encoder::EncoderSizes;
use crate::limits::{PlanError, range, whole, wrong};
use crate::networks::ActorSize;
use crate::plan;

/// Proximal policy optimization (Schulman et al. 2017).
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct PpoSpec {
    /// Environments of each process.
    #[schemars(extend("unit" = "1"), range(min = 1, max = 1u64 << 20))]
    pub environments: usize,
    /// Steps of each environment per iteration (policy steps).
    #[schemars(extend("unit" = "policy steps"), range(min = 1, max = 4096))]
    pub steps: usize,
    /// Passes over the rollout.
    #[schemars(extend("unit" = "1"), range(min = 1, max = 100))]
    pub epochs: usize,
    /// Samples per gradient step, at most environments · steps.
    #[schemars(extend("unit" = "samples"), range(min = 2))]
    pub minibatch: usize,
    /// Clip range ε of the surrogate.
    #[schemars(extend("unit" = "1"), range(min = 1e-3, max = 1.0))]
    pub clip: f64,
    /// Discount γ.
    #[schemars(extend("unit" = "1"), range(min = 0.0, max = 1.0))]
    pub gamma: f32,
    /// λ of generalized advantage estimation.
    #[schemars(extend("unit" = "1"), range(min = 0.0, max = 1.0))]
    pub lambda: f32,
    /// KL divergence per iteration that the learning rate is steered to (nat).
    #[schemars(extend("unit" = "nat"), range(min = 1e-6, max = 10.0))]
    pub target_divergence: f64,
    /// First learning rate of the policy.
    #[schemars(extend("unit" = "1"), range(min = 1e-9, max = 1.0))]
    pub learning_rate: f64,
    /// Least and greatest learning rate of the policy.
    #[schemars(extend("unit" = "1"), inner(range(min = 1e-9, max = 1.0)))]
    pub learning_rate_bounds: [f64; 2],
    /// Learning rate of the value function; constant.
    #[schemars(extend("unit" = "1"), range(min = 1e-9, max = 1.0))]
    pub critic_learning_rate: f64,
    /// Collection of the next rollout while the last one is learned from: what acts is one update behind.
    pub overlap: bool,
    /// Weight of the policy's entropy.
    #[schemars(extend("unit" = "1"), range(min = 0.0, max = 1.0))]
    pub entropy: f64,
    /// Share of the iterations so far over which the policy that is written is averaged; 0: the last one as it is.
    #[schemars(extend("unit" = "1"), range(min = 0.0, max = 1.0))]
    pub averaging: f64,
    /// Largest norm of each network's gradient.
    #[schemars(extend("unit" = "1"), range(min = 1e-6, max = 1e6))]
    pub gradient_norm: f64,
    /// Standard deviation of the first policy, in units of its output.
    #[schemars(extend("unit" = "1"), range(min = 1e-6, max = 100.0))]
    pub initial_std: f64,
    /// Least and greatest standard deviation of the policy.
    #[schemars(extend("unit" = "1"), inner(range(min = 1e-6, max = 100.0)))]
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
        plan::check("ppo", p)?;
        whole("ppo.minibatch", p.minibatch as u64, 2, (p.environments * p.steps) as u64)?;
        range("ppo.learning_rate_bounds[1]", p.learning_rate_bounds[1], p.learning_rate_bounds[0], 1.0)?;
        range("ppo.learning_rate", p.learning_rate, p.learning_rate_bounds[0], p.learning_rate_bounds[1])?;
        range("ppo.std_bounds[1]", p.std_bounds[1], p.std_bounds[0], 100.0)?;
        range("ppo.initial_std", p.initial_std, p.std_bounds[0], p.std_bounds[1])
    }
}

/// Sizes of the ELU networks.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct NetworkSpec {
    /// Widths of the policy's hidden layers.
    #[schemars(extend("unit" = "1"), inner(range(min = 1, max = 1u64 << 16)))]
    pub actor: Vec<usize>,
    /// Widths of the value function's hidden layers.
    #[schemars(extend("unit" = "1"), inner(range(min = 1, max = 1u64 << 16)))]
    pub critic: Vec<usize>,
    /// Widths of the hidden layers of an encoder of `inputs.window` that is trained with the policy.
    ///
    /// It reads [`crate::VectorEnvironment::window_size`] numbers.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    #[schemars(extend("unit" = "1"), inner(range(min = 1, max = 1u64 << 16)))]
    pub encoder: Vec<usize>,
    /// Size of that encoder's code.
    #[serde(skip_serializing_if = "is_zero")]
    #[schemars(extend("unit" = "1"), range(min = 0, max = 1u64 << 16))]
    pub code: usize,
    /// Size of the state of a gated recurrent unit that reads `inputs.history`; 0: the policy sees those steps themselves.
    ///
    /// A multiple of 16.
    #[serde(skip_serializing_if = "is_zero")]
    #[schemars(extend("unit" = "1"), range(min = 0, max = 1024))]
    pub memory: usize,
}

#[allow(clippy::trivially_copy_pass_by_ref)] // serde hands out a reference
fn is_zero(n: &usize) -> bool {
    *n == 0
}

impl Default for NetworkSpec {
    fn default() -> Self {
        Self { actor: vec![256, 128], critic: vec![256, 128], encoder: Vec::new(), code: 0, memory: 0 }
    }
}

impl NetworkSpec {
    /// Checks that every size is in its range.
    ///
    /// # Errors
    /// The key, the range and the value.
    pub fn check(&self) -> Result<(), PlanError> {
        plan::check("network", self)?;
        match self.memory % GruSizes::MULTIPLE {
            0 => Ok(()),
            _ => Err(wrong("network.memory", "a multiple of 16", self.memory)),
        }
    }

    /// Returns the encoder of the last numbers of an environment's observation: a recurrent unit over `steps` steps of
    /// them, or a perceptron; none where neither has a size.
    fn encoder_of(&self, window: usize, steps: usize) -> Option<EncoderSizes> {
        if self.memory > 0 && steps > 0 {
            return Some(EncoderSizes::Recurrent(GruSizes { inputs: window / steps, state: self.memory, steps }));
        }
        let widths = [window].into_iter().chain(self.encoder.iter().copied()).chain([self.code]);
        (window > 0).then(|| EncoderSizes::UnitCode(Sizes::new(&widths.collect::<Vec<_>>())))
    }

    /// Returns the sizes of the policy of an environment.
    pub fn actor_of<E: VectorEnvironment>(&self, environment: &E) -> ActorSize<'_> {
        ActorSize {
            inputs: environment.observation_size(),
            encoder: self.encoder_of(environment.window_size(), environment.window_steps()),
            hidden: &self.actor,
            outputs: environment.action_size(),
        }
    }
}
