//! `lifelike-thesis reconstruction`: captured people as joint rotations (thesis 3.3.3, Table 3.4).

use std::path::{Path, PathBuf};

use crate::sequences::SequencesError;
use crate::sequences::humans::{self, FPS, SEGMENTS, WIDTH};
use crate::sequences::{HumansPlan, PeopleWindows};
use lifelike_character::Role;
use lifelike_character::rotation::from_6d;
use lifelike_motion::dataset;
use lifelike_motion::formats::{self, Format, ReadOptions};
use lifelike_report::Panel;
use lifelike_representation::spline_transformer::Recording;
use rayon::prelude::*;
use tracing::info;

use super::args::{Latents, Shared};
use super::budget::Budget;
use super::{Column, Experiment, Shown, Words, driver, latent_columns};
use lifelike::CliError;
use lifelike::Output;

/// Train the Spline-based Transformer and its baselines on captured motion of people, and print thesis Table 3.4 with ours below it.
///
/// Clips (BVH, AMC, DeepMimic) become rows of joint rotations of fifteen segments at 30 Hz. Each rotation is six
/// normalised numbers relative to its parent segment; the pelvis' heading is removed. Sequences are windows of 64
/// frames. Subjects are split, never windows. CMU's 07, 10 and 12 and some kinds of Bandai-Namco's motion are for tests
/// (`test` and `validation` of the plan). Errors are means of the angle between true and reconstructed rotation (deg)
/// and of its square (deg²). Each run has its folder; the same command resumes stopped runs and skips finished ones.
/// The folder gets reconstruction.json and report.html.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  # a minute: does it work at all?
  lifelike-thesis reconstruction mocap --budget smoke -o runs/smoke
  # 16, 32 and 64 latent dimensions
  lifelike-thesis reconstruction mocap/cmu mocap/bandai mocap/deepmimic -o runs/motion
  lifelike-thesis reconstruction 'cmu/**/*.bvh' --latents 16 --methods spline,alibi \\
      --iterations 500 -o runs/short
  lifelike-thesis reconstruction mocap --budget thesis --latents 32 --minutes 60 -o runs/long
  lifelike-thesis reconstruction mocap --latents 16 --methods spline --rates 1e-4,1e-3,1e-2 \\
      -o runs/rates
  # anna_walk.bvh, ben_run.bvh, ...
  lifelike-thesis reconstruction mine 'test=[\"anna\"]' 'validation=[\"ben\"]' -o runs/mine

A recording's group is what stands before the first underscore of its name; Bandai-Namco's is content_style.")]
pub struct Args {
    /// Clips: files, folders, patterns, or @list.txt with one of them per line; and changes to the plan of all runs, by dotted path.
    #[arg(value_name = "CLIPS | KEY=VALUE", required = true)]
    inputs: Vec<PathBuf>,
    #[command(flatten)]
    latents: Latents,
    #[command(flatten)]
    shared: Shared,
}

/// Runs the command.
pub fn run(args: &Args, output: &Output) -> Result<(), CliError> {
    let (changes, clips): (Vec<_>, Vec<_>) = args.inputs.iter().cloned().partition(|input| is_change(input));
    if clips.is_empty() {
        return Err(CliError::Usage("expected clips (files, folders, patterns), got none".into()));
    }
    let changes: Vec<String> = changes.iter().map(|change| change.to_string_lossy().into_owned()).collect();
    let people = People { clips: &clips, latents: &args.latents.latents };
    driver::run(&people, &args.shared, &changes, output)
}

/// `training.batch=64` is a change of the plan, unless there is a file of that name.
fn is_change(input: &Path) -> bool {
    let key = input.to_str().and_then(|text| text.split_once('=')).map(|(key, _)| key.trim());
    key.is_some_and(|key| key.chars().all(|c| c.is_ascii_lowercase() || c == '_' || c == '.')) && !input.exists()
}

/// Thesis Table 3.4: ALiBi, ALiBi-Cat, Spline.
const THESIS: [(usize, [f64; 3]); 3] =
    [(16, [0.151, 0.153, 0.054]), (32, [0.103, 0.103, 0.022]), (64, [0.059, 0.051, 0.006])];

struct People<'a> {
    clips: &'a [PathBuf],
    latents: &'a [usize],
}

fn plan(budget: Budget, latent: usize) -> HumansPlan {
    let plan = HumansPlan::new(latent);
    let plan = HumansPlan { training: budget.training(plan.training), ..plan };
    match budget {
        Budget::Smoke => HumansPlan { window: 16, ..plan },
        Budget::Cpu | Budget::Thesis => plan,
    }
}

impl Experiment for People<'_> {
    type Plan = HumansPlan;
    type Source = Vec<Recording>;
    type Data = PeopleWindows;

    const WORDS: Words = Words {
        name: "reconstruction",
        title: "Human motion by sequence autoencoders",
        subtitle: "The Spline-based Transformer and its baselines on joint rotations of captured people: same windows, same settings, other latent tokens.",
        table: "Reconstruction of human motion (Table 3.4)",
        caption: "Mean squared angle between the true and the reconstructed rotation of a segment, over windows of subjects that were never \
                  trained on. The thesis measures joint angles of SMPL bodies of HumanML3D and does not say how angles become numbers, so \
                  its rows are of the same kind, not of the same data.",
        column: "latent",
        unit: "deg²",
        validation_unit: "normalised",
        tokens: "frames",
        items: "test windows",
        drawing: "Against time, from the top: left thigh and left shank about the axis across the body (hip and knee bend), right upper \
                  arm about the axis ahead (the arm comes down), right forearm about the T-pose's vertical (the elbow bends); behind, as \
                  captured; in front, what came back.",
    };
    fn columns(&self, budget: Budget) -> Vec<Column<HumansPlan>> {
        latent_columns(self.latents, &THESIS, |latent| plan(budget, latent))
    }

    fn read(&self, _: &Output) -> Result<Vec<Recording>, CliError> {
        let files = dataset::find_motion(self.clips, Format::is_source)?;
        let read = |file: &PathBuf| -> Result<Recording, CliError> {
            let clip = formats::read_source(file, &ReadOptions::default())?;
            humans::recording(&clip).map_err(|e| CliError::Input(format!("{}: {e}", file.display())))
        };
        let recordings: Vec<Recording> = files.par_iter().map(read).collect::<Result<_, _>>()?;
        let frames: usize = recordings.iter().map(|r| r.rows.len() / WIDTH).sum();
        info!("{} clips, {:.1} minutes", recordings.len(), frames as f64 / FPS / 60.0);
        Ok(recordings)
    }

    fn data(source: &Vec<Recording>, plan: &HumansPlan) -> Result<PeopleWindows, SequencesError> {
        plan.windows(source.clone())
    }

    fn shown(data: &PeopleWindows, x: &[f32], y: &[f32]) -> Shown {
        let lines = |rows: &[f32]| {
            let rows = data.rotations(rows);
            DRAWN.iter().enumerate().map(|(i, number)| line(&rows, *number, i)).collect()
        };
        Shown { truth: None, back: Panel { reference: lines(x), lines: lines(y), ..Panel::default() } }
    }

    fn error(data: &PeopleWindows, x: &[f32], y: &[f32]) -> f64 {
        mean(humans::angles(&data.rotations(x), &data.rotations(y)).map(|angle| angle.to_degrees().powi(2)))
    }

    fn also(data: &PeopleWindows, x: &[f32], y: &[f32]) -> Vec<(&'static str, f64)> {
        vec![(
            "mean joint error [deg]",
            mean(humans::angles(&data.rotations(x), &data.rotations(y)).map(f64::to_degrees)),
        )]
    }
}

fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0), |(sum, count), value| (sum + value, count + 1));
    sum / f64::from(count)
}

/// Segments that are drawn, and which number of their rotation vector.
const DRAWN: [(Role, usize); 4] =
    [(Role::LeftThigh, 1), (Role::LeftShank, 1), (Role::RightUpperArm, 0), (Role::RightForearm, 2)];

/// One number of a segment's rotation vector over time, as the `place`-th line from the top: a second is as wide as three radians are high.
fn line(rows: &[f32], (segment, number): (Role, usize), place: usize) -> Vec<[f32; 2]> {
    let first = SEGMENTS.iter().position(|(role, _)| *role == segment).map_or(0, |i| 6 * (1 + i));
    let angle = |row: &[f32]| {
        let numbers = row[first..].first_chunk::<6>().map(|numbers| numbers.map(f64::from));
        numbers.and_then(from_6d).map_or(0.0, |rotation| rotation.scaled_axis()[number] as f32)
    };
    let point = |(t, row): (usize, &[f32])| [3.0 * t as f32 / FPS as f32, angle(row) - 1.6 * place as f32];
    rows.chunks_exact(WIDTH).enumerate().map(point).collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::super::check_budgets;
    use super::*;

    #[test]
    fn every_budget_can_be_run_and_the_largest_is_the_thesis() {
        check_budgets(&People { clips: &[], latents: &[] }, &THESIS.map(|(latent, _)| HumansPlan::new(latent)));
    }

    #[test]
    fn clips_and_changes_are_told_apart() {
        let changes = ["training.batch=64", "window = 32", "test=[\"a/b\"]"];
        assert!(changes.iter().all(|text| is_change(Path::new(text))));
        let clips = ["mocap", "a/b=c.bvh", "Take=1.bvh", "@list.txt"];
        assert!(!clips.iter().any(|text| is_change(Path::new(text))));
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("take=one.bvh");
        std::fs::write(&file, "").unwrap();
        assert!(!is_change(&file));
    }
}
