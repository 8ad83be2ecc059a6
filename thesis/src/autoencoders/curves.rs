//! `lifelike-thesis curves`: plane curves (thesis 3.3.1, Table 3.1; 3.3.5).

use crate::sequences::SequencesError;
use crate::sequences::{CurveSequences, CurvesPlan, Family};
use lifelike_report::Panel;

use super::args::Shared;
use super::budget::Budget;
use super::{Column, Experiment, Shown, Words, driver};
use lifelike::CliError;
use lifelike::Output;

/// Train the Spline-based Transformer and its baselines on families of plane curves, and print thesis Table 3.1 with ours below it.
///
/// Methods of one family meet the same curves in the same order, with the same settings. Errors are mean squared errors of (x, y) over
/// test curves (10,000 but for the smoke budget) that no run is ever trained on. Each run has its folder; the same command goes on
/// with what was stopped and leaves alone what is done. The folder gets curves.json and report.html: the loss of validation against
/// iterations and time, and test curves with their reconstructions.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  lifelike-thesis curves --budget smoke -o runs/smoke   # a minute: does it work at all?
  lifelike-thesis curves -o runs/curves   # 64 points, 84 minutes of one core
  lifelike-thesis curves --families bezier-2 --methods spline,alibi --iterations 500 -o runs/bezier
  # an hour each; again for another hour
  lifelike-thesis curves --budget thesis --families lissajous --minutes 60 -o runs/long
  # which suits which?
  lifelike-thesis curves --families lissajous --rates 1e-3,1e-2 --warmup 50 --iterations 500 \\
      -o runs/rates
  lifelike-thesis curves --families lissajous --rate spline=1e-2,alibi=3e-3 --warmup 200 \\
      -o runs/chosen
  # mean and half the range of three
  lifelike-thesis curves --families lissajous --seed 0,1,2 -o runs/seeds
  lifelike-thesis curves -o runs/other training.batch=64 training.max_gradient_norm=1.0

Families: lissajous, hypotrochoids, bezier-2, bezier-64. Methods: spline, alibi, alibi-cat, alibi-cat-wide
(a decoder twice as wide, which the thesis' text says of ALiBi-Cat).
With --rates the learning rate is swept (thesis 3.3.5, Fig. 3.7b). Errors are then those of validation, so that the test set is
not used to choose a rate. --warmup 0,50 runs each rate without and with a linear rise over 50 iterations.")]
pub struct Args {
    /// Families of curves; all where not given.
    #[arg(long, value_delimiter = ',')]
    families: Vec<Family>,
    #[command(flatten)]
    shared: Shared,
    /// Changes to the plan of all runs, by dotted path.
    #[arg(value_name = "KEY=VALUE")]
    overrides: Vec<String>,
}

/// Runs the command.
pub fn run(args: &Args, output: &Output) -> Result<(), CliError> {
    driver::run(&Curves { families: &args.families }, &args.shared, &args.overrides, output)
}

struct Curves<'a> {
    families: &'a [Family],
}

/// Thesis Table 3.1: ALiBi, ALiBi-Cat, Spline.
fn thesis(family: Family) -> [f64; 3] {
    match family {
        Family::Lissajous => [1e-4, 8e-4, 3e-5],
        Family::Hypotrochoids => [2e-3, 5.3e-3, 1.4e-3],
        Family::Bezier2 => [1.76e-2, 1.78e-2, 2e-6],
        Family::Bezier64 => [3.88e-3, 3.89e-3, 3.87e-3],
    }
}

fn plan(budget: Budget, family: Family) -> CurvesPlan {
    let plan = CurvesPlan::new(family);
    let plan = CurvesPlan { training: budget.training(plan.training), ..plan };
    match budget {
        Budget::Smoke => CurvesPlan { samples: 16, validation: 32, test: 64, ..plan },
        Budget::Cpu => CurvesPlan { samples: 64, ..plan },
        Budget::Thesis => plan,
    }
}

impl Experiment for Curves<'_> {
    type Plan = CurvesPlan;
    type Source = ();
    type Data = CurveSequences;

    const WORDS: Words = Words {
        name: "curves",
        title: "Curves by sequence autoencoders",
        subtitle: "The Spline-based Transformer and its baselines on plane curves: same curves, same settings, other latent tokens.",
        table: "Reconstruction of curves (Table 3.1)",
        caption: "Mean squared error of (x, y) over test curves that were never trained on. The thesis does not state the domains of \
                  its curves or the length of its training, so its rows are of the same kind, not of the same data.",
        column: "family",
        unit: "",
        validation_unit: "",
        tokens: "points",
        items: "test curves",
        drawing: "Behind, the curve; in front, what came back.",
    };

    fn columns(&self, budget: Budget) -> Vec<Column<CurvesPlan>> {
        let chosen = Family::ALL.into_iter().filter(|f| self.families.is_empty() || self.families.contains(f));
        let column = |family: Family| Column {
            key: family.name().into(),
            title: family.title().into(),
            thesis: Some(thesis(family)),
            plan: plan(budget, family),
            equal: false,
        };
        chosen.map(column).collect()
    }

    fn read(&self, _: &Output) -> Result<(), CliError> {
        Ok(())
    }

    fn data((): &(), plan: &CurvesPlan) -> Result<CurveSequences, SequencesError> {
        CurveSequences::new(plan)
    }

    fn shown(_: &CurveSequences, x: &[f32], y: &[f32]) -> Shown {
        let line = |row: &[f32]| vec![row.as_chunks::<2>().0.to_vec()];
        Shown { truth: None, back: Panel { reference: line(x), lines: line(y), ..Panel::default() } }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use clap::Parser as _;

    use super::super::check_budgets;
    use super::*;

    #[test]
    fn every_budget_can_be_run_and_the_largest_is_the_thesis() {
        check_budgets(&Curves { families: &[] }, &Family::ALL.map(CurvesPlan::new));
    }

    #[derive(clap::Parser)]
    struct Command {
        #[command(flatten)]
        args: Args,
    }

    /// Names of folders, learning rates and warm-ups.
    fn runs(arguments: &str) -> Vec<(String, f64, u64)> {
        let Args { families, shared, overrides } = Command::parse_from(arguments.split(' ')).args;
        let columns = driver::columns(&Curves { families: &families }, &shared);
        let places = driver::places::<Curves<'_>>(&columns, &shared, &overrides).unwrap();
        places.into_iter().map(|p| (p.name, p.plan.training.learning_rate, p.plan.training.warmup)).collect()
    }

    #[test]
    fn rates_and_warm_ups_are_the_budgets_unless_told() {
        let one = "curves --families bezier-2 --methods spline -o runs";
        let run = |name: &str, rate, warmup| (format!("bezier-2-spline{name}-0"), rate, warmup);
        assert_eq!(runs(one), [run("-warmup-500", 0.01, 500)]);
        assert_eq!(runs(&format!("{one} --budget thesis")), [run("", 0.001, 0)]);
        assert_eq!(runs(&format!("{one} --iterations 100")), [run("-warmup-5", 0.01, 5)], "its share");
        assert_eq!(runs(&format!("{one} --warmup 7 --rate spline=0.1")), [run("-rate-1e-1-warmup-7", 0.1, 7)]);
        assert_eq!(runs(&format!("{one} --rates 0.1")), [run("-rate-1e-1", 0.1, 0)]);
        let seeds: Vec<String> = runs(&format!("{one} --seed 4,2")).into_iter().map(|(name, ..)| name).collect();
        assert_eq!(seeds, ["bezier-2-spline-warmup-500-4", "bezier-2-spline-warmup-500-2"]);
        let both = [run("-rate-1e-1", 0.1, 0), run("-rate-1e-1-warmup-7", 0.1, 7)];
        assert_eq!(runs(&format!("{one} --rates 0.1 --warmup 0,7")), both);
        assert_eq!(runs(&format!("{one} --rates 0.1 --warmup 7")), both[1..]);
    }

    /// Lissajous curves: three numbers for ALiBi and 12 for the spline; with equal numbers 12 for all, and one run of the spline.
    #[test]
    fn equal_numbers_are_the_splines() {
        let text = "curves --families lissajous --methods alibi,alibi-cat-wide,spline --equal-numbers -o runs";
        let Args { families, shared, overrides } = Command::parse_from(text.split(' ')).args;
        let columns = driver::columns(&Curves { families: &families }, &shared);
        let places = driver::places::<Curves<'_>>(&columns, &shared, &overrides).unwrap();
        let of = |place: &super::super::results::Place<CurvesPlan>| {
            let training = &place.plan.training;
            (place.name.clone(), training.method.numbers(training.latent))
        };
        let run = |name: &str, numbers| (format!("lissajous{name}-warmup-500-0"), numbers);
        let found: Vec<_> = places.iter().map(of).collect();
        let own = [run("-alibi", 3), run("-alibi-cat-wide", 3), run("-spline", 12)];
        assert_eq!(found[..3], own);
        assert_eq!(found[3..], [run("-equal-alibi", 12), run("-equal-alibi-cat-wide", 12), run("-spline", 12)]);
    }

    /// Runs that were begun with this plan must go on.
    #[test]
    fn a_plan_stays_what_it_was_in_a_file() {
        let text = "family = \"bezier-64\"\nsamples = 64\nvalidation = 256\ntest = 10000\n\n[training]\nseed = 0\n\
                    method = \"spline\"\nlatent = 64\nlayers = 4\nheads = 4\nwidth = 128\nfactor = 1\nbatch = 32\npart = 4\n\
                    iterations = 10000\noptimizer = \"muon\"\nlearning_rate = 0.01\nwarmup = 500\nvalidate_every = 500\n";
        assert_eq!(toml::to_string(&plan(Budget::Cpu, Family::Bezier64)).unwrap(), text);
    }
}
