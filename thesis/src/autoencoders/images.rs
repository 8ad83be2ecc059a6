//! `lifelike-thesis images`: images as sequences of patches (thesis 3.3.2, Table 3.2).

use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::sequences::SequencesError;
use crate::sequences::{ImageFolder, ImageSequences, ImagesPlan};
use lifelike_report::{Panel, Picture};
use tracing::info;

use super::args::{Latents, Shared};
use super::budget::Budget;
use super::{Column, Experiment, Shown, Words, driver, latent_columns};
use lifelike::CliError;
use lifelike::Output;

/// Train the Spline-based Transformer and its baselines on a folder of images, and print thesis Table 3.2 with ours below it.
///
/// The folder has train/ and test/, with PNG or JPEG images of one size at any depth. An image is a sequence of
/// patches, row by row: 64 of 4 x 4 pixels for CIFAR-10. 500 images of train/, evenly spread, are used for validation.
/// Errors are those of test/, of pixels from 0 to 1. Each run has its folder; the same command resumes stopped runs and
/// skips finished ones. The folder gets images.json and report.html, with test images beside their reconstructions.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  lifelike-thesis images cifar10 --budget smoke -o runs/smoke   # a minute: does it work at all?
  lifelike-thesis images cifar10 -o runs/images   # 32, 64 and 128 latent dimensions
  lifelike-thesis images cifar10 --latents 32 --methods spline,alibi --iterations 500 -o runs/short
  lifelike-thesis images cifar10 --budget thesis --latents 64 --minutes 60 -o runs/long
  lifelike-thesis images cifar10 --latents 32 --methods spline --rates 1e-4,1e-3,1e-2 -o runs/rates
  # larger images, larger patches
  lifelike-thesis images faces-128 -o runs/faces patch=32 validation=100

The thesis' numbers are those of CIFAR-10.")]
pub struct Args {
    /// Folder with train/ and test/.
    #[arg(value_name = "DIR")]
    folder: PathBuf,
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
    let images = Images { folder: &args.folder, latents: &args.latents.latents };
    driver::run(&images, &args.shared, &args.overrides, output)
}

/// Thesis Table 3.2, CIFAR-10: ALiBi, ALiBi-Cat, Spline.
const THESIS: [(usize, [f64; 3]); 3] =
    [(32, [0.266, 0.264, 0.107]), (64, [0.178, 0.174, 0.056]), (128, [0.107, 0.108, 0.042])];

struct Images<'a> {
    folder: &'a Path,
    latents: &'a [usize],
}

fn plan(budget: Budget, latent: usize) -> ImagesPlan {
    let plan = ImagesPlan::new(latent);
    let plan = ImagesPlan { training: budget.training(plan.training), ..plan };
    match budget {
        Budget::Smoke => ImagesPlan { validation: 32, test: 64, ..plan },
        Budget::Cpu => ImagesPlan { validation: 250, ..plan },
        Budget::Thesis => plan,
    }
}

impl Experiment for Images<'_> {
    type Plan = ImagesPlan;
    type Source = Arc<ImageFolder>;
    type Data = ImageSequences;

    const WORDS: Words = Words {
        name: "images",
        title: "Images by sequence autoencoders",
        subtitle: "The Spline-based Transformer and its baselines on images cut into patches: same images, same settings, other latent tokens.",
        table: "Reconstruction of images (Table 3.2, CIFAR-10)",
        caption: "Mean squared error of red, green and blue from 0 to 1 over images of test/. The thesis does not state its range of \
                  pixels: the pixels of CIFAR-10 from 0 to 1 have a variance of 0.06, so its 0.266 is of another scale (from -1 to 1 \
                  errors are four times as large, with deviations as unit about sixteen times).",
        column: "latent",
        unit: "",
        validation_unit: "",
        tokens: "patches",
        items: "test images",
        drawing: "An image, and what came back of it.",
    };

    fn columns(&self, budget: Budget) -> Vec<Column<ImagesPlan>> {
        latent_columns(self.latents, &THESIS, |latent| plan(budget, latent))
    }

    fn read(&self, _: &Output) -> Result<Arc<ImageFolder>, CliError> {
        let images = ImageFolder::read(self.folder)?;
        let [rows, columns] = images.size;
        info!("{} images to train on and {} to test, {columns} x {rows}", images.train.len(), images.test.len());
        Ok(Arc::new(images))
    }

    fn data(source: &Arc<ImageFolder>, plan: &ImagesPlan) -> Result<ImageSequences, SequencesError> {
        ImageSequences::new(plan, source.clone())
    }

    fn shown(data: &ImageSequences, x: &[f32], y: &[f32]) -> Shown {
        let [height, width] = data.size();
        let panel = |sequence: &[f32]| {
            let picture = Picture { width, height, rgb: data.picture(sequence) };
            Panel { picture: Some(picture), ..Panel::default() }
        };
        Shown { truth: Some(panel(x)), back: panel(y) }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::super::check_budgets;
    use super::*;

    #[test]
    fn every_budget_can_be_run_and_the_largest_is_the_thesis() {
        check_budgets(
            &Images { folder: Path::new(""), latents: &[] },
            &THESIS.map(|(latent, _)| ImagesPlan::new(latent)),
        );
    }
}
