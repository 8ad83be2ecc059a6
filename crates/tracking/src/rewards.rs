//! The tracking reward: a sum of terms, each declared once.
//!
//! Two forms, as data: the thesis' weighted squares of normalised errors (eqs. 4.5-4.8), and the exponentials of
//! Peng et al. 2018 (DeepMimic), which learn to walk in minutes on two cores. Both are made of the same terms: [`terms`] is
//! their list and the only file to change when a term is added. [`RewardInputs`] are what a term may read.

mod declare;
pub mod floors;
pub mod inputs;
mod norm;
pub mod terms;
#[cfg(test)]
mod tests;

pub use self::declare::Kernel;
pub use self::floors::Floors;
pub use self::inputs::{ActionCost, RewardInputs, squared_distance, sum};
pub use self::norm::Norm;
pub use self::terms::{ExponentialReward, TERMS, ThesisReward};

/// The value of each term of [`TERMS`], weighted; their sum is the reward.
pub type TermValues = [f32; TERMS.len()];

/// A term, as the metrics and the table of plan keys know it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Term {
    /// Key in the plan, and name in the metrics (`Reward/<name>`).
    pub name: &'static str,
    /// Unit of the error or cost; empty: none.
    pub unit: &'static str,
    /// True for penalties, which the curriculum of smoothness scales.
    pub penalty: bool,
    /// True where the exponential form has a kernel (weight and sharpness), false where it has a weight alone.
    pub kernel: bool,
}

/// One of the two forms.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Reward {
    /// Eqs. 4.5-4.8.
    Thesis(ThesisReward),
    /// Exponentials of squared errors.
    Exponential(ExponentialReward),
}

impl Default for Reward {
    fn default() -> Self {
        Self::Exponential(ExponentialReward::default())
    }
}

impl Reward {
    /// Returns all terms of one step. `inputs.divisor` is [`Floors::apply`]'s; only the thesis' form reads it.
    pub fn terms(&self, inputs: &RewardInputs<'_>) -> TermValues {
        match self {
            Self::Thesis(reward) => reward.terms(inputs),
            Self::Exponential(reward) => reward.terms(inputs),
        }
    }
}

/// Multiplies the penalties among the terms.
pub fn scale_penalties(terms: &mut TermValues, factor: f32) {
    for (value, _) in terms.iter_mut().zip(TERMS).filter(|(_, term)| term.penalty) {
        *value *= factor;
    }
}
