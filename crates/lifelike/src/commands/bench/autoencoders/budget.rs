//! Budget of each run.

use lifelike_nn::adam::Rule;
use lifelike_representation::spline_transformer::SequencePlan;

/// A plan for each experiment; methods never differ by it.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum Budget {
    /// Seconds: tiny networks, 40 iterations. Its errors say nothing about the methods.
    Smoke,
    /// Minutes a run on two cores: the thesis' networks and optimizer, batches of 32, some thousands of iterations at a rate of 0.01 after
    /// a warm-up, with which all three methods learn faster than with the thesis' rates of 0.001 and less.
    #[default]
    Cpu,
    /// Thesis Table A.1 with its batches; 50,000 iterations (the thesis does not say how many).
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

    /// A row of Table A.1 within the budget. `iterations` are the cpu budget's.
    pub fn training(self, thesis: SequencePlan, iterations: u64) -> SequencePlan {
        match self {
            Self::Smoke => {
                let sizes = SequencePlan { layers: 1, heads: 2, width: 16, optimizer: Rule::Adam, ..thesis };
                SequencePlan { batch: 16, part: 8, iterations: 40, validate_every: 10, ..sizes }
            }
            // Small parts: each goes through the network on one core, and what it needs stays in the core's cache.
            Self::Cpu => {
                let rate = SequencePlan { learning_rate: 1e-2, warmup: iterations / 20, ..thesis };
                SequencePlan { batch: 32, part: 4, iterations, validate_every: 250, ..rate }
            }
            Self::Thesis => thesis,
        }
    }
}
