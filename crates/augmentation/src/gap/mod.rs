//! Differences between simulation and measurement, by block and column.
//!
//! [`Gap`] has the numbers of one measured column of one block; [`ColumnGap`] those of all blocks and runs together.

mod concordance;
mod spectrum;
mod vectors;

pub use concordance::concordance;
pub use spectrum::{Band, spectrum};
pub use vectors::{ORIENTATION, PLACE};

use lifelike_sim::trace::{BlockTrace, Trace};

/// Numbers of one measured column of one block (thesis 2.5.1).
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Gap {
    /// The run.
    pub run: String,
    /// The block.
    pub block: String,
    /// The block's class.
    pub class: String,
    /// The column.
    pub column: String,
    /// Mean absolute error (SI).
    pub mae: f64,
    /// Largest absolute error (SI).
    pub max: f64,
    /// Concordance correlation coefficient of simulated and measured (Lin 1989); 1 is agreement.
    pub ccc: f64,
    /// Mean error: measured less simulated.
    pub bias: f64,
    /// By how much the measured column lags behind the simulated one (s); negative: it leads.
    pub delay: f64,
    /// Mean square of the error by frequency.
    pub spectrum: Vec<Band>,
    /// Mean absolute error where something holds.
    pub places: Vec<Place>,
}

/// Mean absolute error where something holds.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Place {
    /// Name of the part that holds.
    pub place: &'static str,
    /// Share of the time.
    pub share: f64,
    /// Mean absolute error there (SI).
    pub mae: f64,
}

/// A lag beyond this is none (s).
const LONGEST_DELAY: f64 = 0.1;
/// Below this share of its largest value a velocity is slow, a load small.
const LITTLE: f32 = 0.1;
/// Time around a change of direction (s).
const AROUND: f64 = 0.1;

/// Measures all columns of all blocks that were measured.
pub fn gaps(trace: &Trace) -> Vec<Gap> {
    trace.blocks.iter().flat_map(|block| of_block(trace, block)).collect()
}

fn of_block(trace: &Trace, block: &BlockTrace) -> Vec<Gap> {
    let (selected, width) = (block.selected(), block.measured.names.len());
    let places = places(block, trace.rate);
    let column = |values: &[f32], i: usize| values.iter().skip(i).step_by(width).map(|x| f64::from(*x)).collect();
    let gap = |column: String, error: Vec<f64>, ccc: f64, delay: f64| {
        let n = error.len().max(1) as f64;
        let place = |(place, rows): &(&'static str, Vec<bool>)| {
            let there: Vec<f64> = error.iter().zip(rows).filter(|(_, there)| **there).map(|(e, _)| e.abs()).collect();
            let mae = there.iter().sum::<f64>() / there.len().max(1) as f64;
            Place { place, share: there.len() as f64 / n, mae }
        };
        Gap {
            run: trace.name.clone(),
            block: block.name.clone(),
            class: block.class.clone(),
            column,
            mae: error.iter().map(|e| e.abs()).sum::<f64>() / n,
            max: error.iter().fold(0.0, |most, e| most.max(e.abs())),
            ccc,
            bias: error.iter().sum::<f64>() / n,
            delay,
            spectrum: spectrum(&error, trace.rate),
            places: places.iter().map(place).collect(),
        }
    };
    let single = |(i, name): (usize, &String)| {
        let (simulated, measured): (Vec<f64>, Vec<f64>) = (column(&selected, i), column(&block.measured.values, i));
        let error: Vec<f64> = measured.iter().zip(&simulated).map(|(m, s)| m - s).collect();
        let most = (LONGEST_DELAY * trace.rate).ceil() as usize;
        let delay = crate::logs::delay(&simulated, &measured, most) / trace.rate;
        gap(name.clone(), error, concordance(&simulated, &measured), delay)
    };
    let mut out: Vec<Gap> = block.measured.names.iter().enumerate().map(single).collect();
    for (name, error) in vectors::distances(&block.measured.names, &selected, &block.measured.values) {
        // Of a vector as a whole: what its coordinates say in the mean.
        let stem = if name == PLACE { "position_" } else { "orientation_" };
        let own: Vec<&Gap> = out.iter().filter(|gap| gap.column.starts_with(stem) && gap.column != PLACE).collect();
        let mean = |number: fn(&Gap) -> f64| own.iter().map(|gap| number(gap)).sum::<f64>() / own.len().max(1) as f64;
        let (ccc, delay) = (mean(|gap| gap.ccc), mean(|gap| gap.delay));
        out.push(gap(name.into(), error, ccc, delay));
    }
    out
}

/// Rows where something holds, as the simulation has it.
fn places(block: &BlockTrace, rate: f64) -> Vec<(&'static str, Vec<bool>)> {
    let mut out = Vec::new();
    if let Some(velocity) = block.simulated.column("velocity") {
        let velocity: Vec<f32> = velocity.collect();
        out.extend(both(["slow or at rest", "moving"], &velocity));
        let around = (AROUND * rate).ceil() as usize;
        let mut turning = vec![false; velocity.len()];
        for i in 1..velocity.len() {
            if velocity[i - 1] * velocity[i] < 0.0 {
                let last = (i + around).min(velocity.len());
                turning[i.saturating_sub(around)..last].fill(true);
            }
        }
        out.push(("within 0.1 s of a change of direction", turning));
    }
    if let Some(load) = block.force.column("load") {
        out.extend(both(["little load", "under load"], &load.collect::<Vec<_>>()));
    }
    out
}

/// Rows where a number is little beside its largest, and where it is not.
fn both(names: [&'static str; 2], values: &[f32]) -> [(&'static str, Vec<bool>); 2] {
    let most = values.iter().fold(0.0_f32, |most, x| most.max(x.abs()));
    let little: Vec<bool> = values.iter().map(|x| x.abs() <= LITTLE * most).collect();
    let rest = little.iter().map(|little| !little).collect();
    [(names[0], little), (names[1], rest)]
}

/// Numbers of one column over many blocks and runs: mean and spread of theirs, as the thesis' bars have them.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct ColumnGap {
    /// The column.
    pub column: String,
    /// Blocks and runs.
    pub count: usize,
    /// Mean of their mean absolute errors, and its standard deviation (SI).
    pub mae: [f64; 2],
    /// Mean of their largest errors, and its standard deviation (SI).
    pub max: [f64; 2],
    /// Mean of their concordance correlations, and its standard deviation.
    pub ccc: [f64; 2],
}

/// Summarizes gaps column by column, in the order in which columns appear.
pub fn summary(gaps: &[Gap]) -> Vec<ColumnGap> {
    let mut columns: Vec<&String> = Vec::new();
    for gap in gaps.iter().filter(|gap| !gap.column.is_empty()) {
        if !columns.contains(&&gap.column) {
            columns.push(&gap.column);
        }
    }
    let spread = |values: Vec<f64>| {
        let n = values.len().max(1) as f64;
        let mean = values.iter().sum::<f64>() / n;
        [mean, (values.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / n).sqrt()]
    };
    let column = |name: &String| {
        let own: Vec<&Gap> = gaps.iter().filter(|gap| gap.column == *name).collect();
        let of = |number: fn(&Gap) -> f64| spread(own.iter().map(|gap| number(gap)).collect());
        ColumnGap {
            column: name.clone(),
            count: own.len(),
            mae: of(|gap| gap.mae),
            max: of(|gap| gap.max),
            ccc: of(|gap| gap.ccc),
        }
    };
    columns.into_iter().map(column).collect()
}
