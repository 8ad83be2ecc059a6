//! `lifelike-thesis curves`, `images`, `strands` and `reconstruction`: the Spline-based Transformer and its baselines
//! on four kinds of sequences (thesis 3.3). One frame for all: an [`Experiment`] (a file each) says what its columns,
//! plans, data and pictures are. [`driver`] trains, [`results`] measures networks and plain baselines alike,
//! [`tables`] and [`page`] show.

mod args;
mod budget;
pub mod control_points;
pub mod curves;
mod driver;
pub mod images;
mod page;
pub mod reconstruction;
mod results;
pub mod strands;
mod tables;

use crate::sequences::DataPlan;
use crate::sequences::SequencesError;
use lifelike_report::Panel;
use lifelike_representation::spline_transformer::{HeldOut, Sequences};

use budget::Budget;
use lifelike::CliError;
use lifelike::Output;

/// A comparison of methods: columns, plans, data and drawings.
pub trait Experiment {
    /// A run's plan: what plan.toml holds.
    type Plan: DataPlan;
    /// Data that all runs have in common, read once.
    type Source;
    /// Data of one run.
    type Data: Sequences;

    /// Words of its tables and messages.
    const WORDS: Words;
    /// Mean squared errors of the network times this are the tables', where [`Self::error`] is not another one.
    const SCALE: f64 = 1.0;

    /// The columns asked for.
    fn columns(&self, budget: Budget) -> Vec<Column<Self::Plan>>;

    /// Reads what is to be read, after all plans have been checked.
    ///
    /// # Errors
    /// Files that are not what they should be.
    fn read(&self, output: &Output) -> Result<Self::Source, CliError>;

    /// The sequences of a plan.
    ///
    /// # Errors
    /// A plan that does not fit the source.
    fn data(source: &Self::Source, plan: &Self::Plan) -> Result<Self::Data, SequencesError>;

    /// A test sequence and what came back of it, both `[tokens, width]`.
    fn shown(data: &Self::Data, x: &[f32], y: &[f32]) -> Shown;

    /// Error of a test sequence, in the table's unit: `x` and what came back of it, both `[tokens, width]`.
    fn error(_data: &Self::Data, x: &[f32], y: &[f32]) -> f64 {
        let squares: f64 = x.iter().zip(y).map(|(x, y)| f64::from(x - y).powi(2)).sum();
        Self::SCALE * squares / x.len() as f64
    }

    /// Further measures of a test sequence, by name with unit: the tables have their means.
    fn also(_data: &Self::Data, _x: &[f32], _y: &[f32]) -> Vec<(&'static str, f64)> {
        Vec::new()
    }
}

/// Words of an experiment.
#[derive(Debug, Clone, Copy)]
pub struct Words {
    /// Of the command and of the results' file.
    pub name: &'static str,
    /// Of the page.
    pub title: &'static str,
    /// Below it.
    pub subtitle: &'static str,
    /// Of the table.
    pub table: &'static str,
    /// Below it: what is measured, and what cannot be compared with the thesis.
    pub caption: &'static str,
    /// Name of what the columns differ by.
    pub column: &'static str,
    /// Unit of the errors; may be empty.
    pub unit: &'static str,
    /// Unit of errors of validation, which are the network's own.
    pub validation_unit: &'static str,
    /// Name of a sequence's elements.
    pub tokens: &'static str,
    /// Name of test sequences.
    pub items: &'static str,
    /// Title of the drawings.
    pub drawing: &'static str,
}

/// A column of the table.
#[derive(Debug, Clone)]
pub struct Column<P> {
    /// In names of folders and in files.
    pub key: String,
    /// On the page.
    pub title: String,
    /// The thesis' errors of ALiBi, ALiBi-Cat and Spline; none where it has no such column.
    pub thesis: Option<[f64; 3]>,
    /// The plan, but for method, seed, rate and warm-up.
    pub plan: P,
    /// True where each method keeps as many numbers of a sequence as the spline of this plan.
    pub equal: bool,
}

/// A test sequence in pictures.
#[derive(Debug, Clone)]
pub struct Shown {
    /// The sequence itself, where it stands beside what came back, not behind it.
    pub truth: Option<Panel>,
    /// Reconstruction.
    pub back: Panel,
}

/// Errors of the tables.
const TABLE: HeldOut = HeldOut::Test;

/// Columns that differ by the latent dimension: those chosen, or all of the thesis' table.
fn latent_columns<P>(chosen: &[usize], thesis: &[(usize, [f64; 3])], plan: impl Fn(usize) -> P) -> Vec<Column<P>> {
    let all: Vec<usize> = thesis.iter().map(|(latent, _)| *latent).collect();
    let chosen = if chosen.is_empty() { &all } else { chosen };
    let column = |latent: &usize| Column {
        key: format!("{latent}d"),
        title: format!("{latent}D"),
        thesis: thesis.iter().find(|(l, _)| l == latent).map(|(_, errors)| *errors),
        plan: plan(*latent),
        equal: false,
    };
    chosen.iter().map(column).collect()
}

/// Every budget's plans are in range, and the thesis' budget is the thesis' plans.
#[cfg(test)]
#[track_caller]
fn check_budgets<E: Experiment>(experiment: &E, thesis: &[E::Plan]) {
    let plans = |budget| experiment.columns(budget).into_iter().map(|column| column.plan).collect::<Vec<_>>();
    for plan in [Budget::Smoke, Budget::Cpu, Budget::Thesis].into_iter().flat_map(plans) {
        assert!(plan.check().is_ok(), "{}", toml::to_string(&plan).unwrap_or_default());
    }
    assert!(plans(Budget::Thesis) == thesis);
}
