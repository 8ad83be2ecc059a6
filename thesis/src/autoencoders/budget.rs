//! Budget of each run.

use lifelike_nn::adam::Rule;
use lifelike_representation::spline_transformer::SequencePlan;

/// A plan for each experiment; methods never differ by it.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum Budget {
    /// Seconds: tiny networks, 40 iterations. Its errors say nothing about the methods.
    Smoke,
    /// Seven to fifteen minutes of one core a run: the thesis' networks, but none wider than 64 where that is twice a
    /// control point (of 128 they take half an hour). 10,000 batches of 32, and Muon, whose rate rises over a warm-up
    /// and falls to 0.
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

    /// A row of Table A.1 within the budget.
    pub fn training(self, thesis: SequencePlan) -> SequencePlan {
        match self {
            Self::Smoke => {
                let sizes = SequencePlan { layers: 1, heads: 2, width: 16, optimizer: Rule::Adam, ..thesis };
                SequencePlan { batch: 16, part: 8, iterations: 40, validate_every: 10, ..sizes }
            }
            Self::Cpu => {
                // A token no wider than its control point has room for nothing else: at width 64, vectors of 64 numbers did no better than
                // those of 32 (docs/results/spline-motion.md). Heads of a narrower network have as many numbers as the thesis'.
                let width = if 2 * thesis.latent > WIDTH { thesis.width } else { thesis.width.min(WIDTH) };
                let sizes = SequencePlan { heads: thesis.heads * width / thesis.width, width, ..thesis };
                // The best of three rates for nearly every method on curves, images, strands and people.
                let (optimizer, learning_rate) = (Rule::Muon, 1e-2);
                let rate = SequencePlan { optimizer, learning_rate, warmup: ITERATIONS / 20, ..sizes };
                // Small parts: each goes through the network on one core, and what it needs stays in the core's cache.
                SequencePlan { batch: 32, part: 4, iterations: ITERATIONS, validate_every: 500, ..rate }
            }
            Self::Thesis => thesis,
        }
    }
}

/// The cpu budget's largest width, where it is twice a control point.
const WIDTH: usize = 64;
/// The cpu budget's iterations.
const ITERATIONS: u64 = 10_000;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_token_has_room_for_its_control_point_where_the_thesis_has() {
        let sizes = |latent: usize| {
            let thesis = SequencePlan { latent, heads: 8, width: 128, ..SequencePlan::default() };
            let plan = Budget::Cpu.training(thesis);
            (plan.width, plan.heads)
        };
        assert_eq!([16, 32, 33, 64, 128].map(sizes), [(64, 4), (64, 4), (128, 8), (128, 8), (128, 8)]);
    }
}
