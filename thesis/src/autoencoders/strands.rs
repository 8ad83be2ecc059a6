//! `lifelike-thesis strands`: strands of hair (thesis 3.3.4, Table 3.5).

use crate::sequences::SequencesError;
use crate::sequences::{StrandSequences, StrandsPlan};
use lifelike_report::Panel;

use super::args::{Latents, Shared};
use super::budget::Budget;
use super::{Column, Experiment, Shown, Words, driver, latent_columns};
use lifelike::CliError;
use lifelike::Output;

/// Train the Spline-based Transformer and its baselines on strands of hair, and print thesis Table 3.5 with ours below it.
///
/// The thesis' hair models are not at hand, so strands are drawn: 343 hairstyles of 10,000 strands, each 100 points from its root at the
/// origin, with lengths, curls and bending around their hairstyle's. The errors are those of 10 hairstyles that no run is trained on, in
/// m² of a coordinate. Each run has its folder; the same command goes on with what was stopped and leaves alone what is done. The folder
/// gets strands.json and report.html.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  lifelike-thesis strands --budget smoke -o runs/smoke   # a minute: does it work at all?
  lifelike-thesis strands -o runs/strands   # 8, 16 and 32 latent dimensions, batches of 32
  lifelike-thesis strands --latents 8 --methods spline,alibi --iterations 500 -o runs/short
  lifelike-thesis strands --budget thesis --latents 16 --minutes 60 -o runs/long
  lifelike-thesis strands --latents 8 --methods spline --rates 1e-4,1e-3,1e-2 -o runs/rates
  lifelike-thesis strands -o runs/other hairstyles=50 points=50 training.batch=64")]
pub struct Args {
    #[command(flatten)]
    latents: Latents,
    #[command(flatten)]
    shared: Shared,
    /// Changes to the plan of all runs, by dotted path.
    #[arg(value_name = "KEY=VALUE")]
    overrides: Vec<String>,
}

/// Runs the command.
pub fn run(args: &Args, output: &Output) -> Result<(), CliError> {
    driver::run(&Strands { latents: &args.latents.latents }, &args.shared, &args.overrides, output)
}

/// Thesis Table 3.5: ALiBi, ALiBi-Cat, Spline.
const THESIS: [(usize, [f64; 3]); 3] =
    [(8, [4.8e-3, 4.6e-3, 1.09e-3]), (16, [2.0e-3, 1.9e-3, 1.06e-3]), (32, [1.5e-3, 1.2e-3, 9.4e-4])];

struct Strands<'a> {
    latents: &'a [usize],
}

fn plan(budget: Budget, latent: usize) -> StrandsPlan {
    let plan = StrandsPlan::new(latent);
    let plan = StrandsPlan { training: budget.training(plan.training), ..plan };
    match budget {
        Budget::Smoke => StrandsPlan { points: 16, validation: 4, test: 8, ..plan },
        Budget::Cpu => StrandsPlan { test: 500, ..plan },
        Budget::Thesis => plan,
    }
}

impl Experiment for Strands<'_> {
    type Plan = StrandsPlan;
    type Source = ();
    type Data = StrandSequences;

    const WORDS: Words = Words {
        name: "strands",
        title: "Strands of hair by sequence autoencoders",
        subtitle: "The Spline-based Transformer and its baselines on strands of drawn hairstyles: same strands, same settings, other latent tokens.",
        table: "Reconstruction of strands (Table 3.5)",
        caption: "Mean squared error of a coordinate over strands of ten hairstyles that were never trained on. Our hairstyles are drawn; \
                  the thesis' are 343 models, whose unit it does not state: its rows are of the same kind, not of the same data.",
        column: "latent",
        unit: "m²",
        validation_unit: "m²",
        tokens: "points",
        items: "test strands",
        drawing: "From the side; behind, the strand; in front, what came back.",
    };
    const SCALE: f64 = 1.0 / (StrandSequences::PER_METRE * StrandSequences::PER_METRE);

    fn columns(&self, budget: Budget) -> Vec<Column<StrandsPlan>> {
        latent_columns(self.latents, &THESIS, |latent| plan(budget, latent))
    }

    fn read(&self, _: &Output) -> Result<(), CliError> {
        Ok(())
    }

    fn data((): &(), plan: &StrandsPlan) -> Result<StrandSequences, SequencesError> {
        StrandSequences::new(plan)
    }

    fn shown(_: &StrandSequences, x: &[f32], y: &[f32]) -> Shown {
        // x to the right, z up.
        let side = |row: &[f32]| vec![row.as_chunks::<3>().0.iter().map(|[x, _, z]| [*x, *z]).collect()];
        Shown { truth: None, back: Panel { reference: side(x), lines: side(y), ..Panel::default() } }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::super::check_budgets;
    use super::*;

    #[test]
    fn every_budget_can_be_run_and_the_largest_is_the_thesis() {
        check_budgets(&Strands { latents: &[] }, &THESIS.map(|(latent, _)| StrandsPlan::new(latent)));
    }
}
