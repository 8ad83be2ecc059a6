//! How much is spent on each run.

use lifelike_learn::representation::spline_transformer::{CurvesPlan, Family, SequencePlan};
use lifelike_nn::adam::Rule;

/// A plan for each family; methods never differ by it.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum Budget {
    /// Seconds: tiny networks, few short curves. Its errors say nothing about the methods.
    Smoke,
    /// Minutes on two cores: the thesis' networks on 64 points instead of 256, batches of 32, 1000 iterations of Adam.
    #[default]
    Cpu,
    /// Thesis Table A.1: 256 points, batches of 256 or 1024, RAdam; 50,000 iterations (the thesis does not say how many).
    Thesis,
}

impl Budget {
    /// As it is called on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Smoke => "smoke",
            Self::Cpu => "cpu",
            Self::Thesis => "thesis",
        }
    }

    /// The plan of a run, but for method, seed, rate and warm-up.
    pub fn plan(self, family: Family) -> CurvesPlan {
        let plan = CurvesPlan::new(family);
        let short = SequencePlan { optimizer: Rule::Adam, ..plan.training.clone() };
        match self {
            Self::Smoke => {
                let sizes = SequencePlan { layers: 1, heads: 2, width: 16, ..short };
                let training = SequencePlan { batch: 16, part: 16, iterations: 40, validate_every: 10, ..sizes };
                CurvesPlan { samples: 16, validation: 32, test: 64, training, ..plan }
            }
            Self::Cpu => {
                let training = SequencePlan { batch: 32, part: 32, iterations: 1000, validate_every: 50, ..short };
                CurvesPlan { samples: 64, training, ..plan }
            }
            Self::Thesis => plan,
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn every_budget_is_a_plan_that_can_be_run() {
        for family in Family::ALL {
            for budget in [Budget::Smoke, Budget::Cpu, Budget::Thesis] {
                budget.plan(family).check().unwrap();
            }
            assert_eq!(Budget::Thesis.plan(family), CurvesPlan::new(family));
        }
    }
}
