//! The gap report as tables and as a page.

use std::path::Path;

use lifelike_augmentation::gap::{ColumnGap, Gap};
use lifelike_report::{Cell, Column, Curve, ReportBuilder, Table};
use lifelike_sim::trace::Trace;

use crate::error::CliError;

/// Runs whose signals are drawn.
const DRAWN: usize = 12;

/// Returns the unit that a column's numbers are shown in: factor and unit.
fn shown(column: &str) -> (f64, &'static str) {
    match column {
        "position" | "orientation" => (180.0 / std::f64::consts::PI, "deg"),
        "velocity" => (180.0 / std::f64::consts::PI, "deg/s"),
        "current" => (1.0, "A"),
        "voltage" => (1.0, "V"),
        name if name.starts_with("position_") => (1e3, "mm"),
        _ => (1.0, "SI"),
    }
}

/// Returns the summary as a table.
pub fn summary(columns: &[ColumnGap]) -> Table {
    let mut table = Table::new(
        "Mean over blocks and runs (± standard deviation)",
        vec![
            Column::text("column"),
            Column::text("unit"),
            Column::number("MAE", ""),
            Column::number("largest", ""),
            Column::number("CCC", ""),
            Column::number("of", ""),
        ],
    );
    for own in columns {
        let (factor, unit) = shown(&own.column);
        let spread = |[mean, deviation]: [f64; 2], factor: f64, digits: usize| {
            Cell::text(format!("{:.digits$} ± {:.digits$}", factor * mean, factor * deviation))
        };
        table.rows.push(vec![
            Cell::text(own.column.clone()),
            Cell::text(unit),
            spread(own.mae, factor, 2),
            spread(own.max, factor, 2),
            spread(own.ccc, 1.0, 3),
            Cell::number(own.count as f64, 0),
        ]);
    }
    table
}

/// Writes gap.json and report.html.
pub fn save(
    folder: &Path,
    value: &serde_json::Value,
    traces: &[(&str, Vec<Trace>)],
    measured: &[(&str, Vec<Gap>)],
) -> Result<(), CliError> {
    std::fs::create_dir_all(folder).map_err(CliError::write(folder))?;
    crate::output::write_json(&folder.join("gap.json"), value)?;
    let mut report = ReportBuilder::new("Simulation and measurement");
    for (name, gaps) in measured {
        let mut own = summary(&lifelike_augmentation::gap::summary(gaps));
        own.title = format!("{name}: {}", own.title);
        report = report.table(own);
    }
    for (name, gaps) in measured {
        report = report.table(each(name, gaps)).table(places(name, gaps)).table(spectra(name, gaps));
    }
    let report = report.curves(curves(traces)).curves_first().measured();
    Ok(report.write(&folder.join("report.html"))?)
}

/// Blocks that a terminal shows.
const WORST: usize = 8;

/// Returns the blocks whose positions differ most, as a table.
pub fn worst(name: &str, gaps: &[Gap]) -> Table {
    let mut own: Vec<Gap> = gaps.iter().filter(|gap| gap.column == "position").cloned().collect();
    own.sort_by(|a, b| b.mae.total_cmp(&a.mae));
    own.truncate(WORST);
    let mut table = each(name, &own);
    table.title = format!("{name}: largest differences");
    table
}

fn each(name: &str, gaps: &[Gap]) -> Table {
    let mut table = Table::new(
        &format!("{name}: every block"),
        vec![
            Column::text("run"),
            Column::text("block"),
            Column::text("column"),
            Column::text("unit"),
            Column::number("MAE", ""),
            Column::number("largest", ""),
            Column::number("mean", ""),
            Column::number("CCC", ""),
            Column::number("delay", "ms"),
        ],
    );
    table.rows = gaps
        .iter()
        .map(|gap| {
            let (factor, unit) = shown(&gap.column);
            vec![
                Cell::text(gap.run.clone()),
                Cell::text(gap.block.clone()),
                Cell::text(gap.column.clone()),
                Cell::text(unit),
                Cell::number(factor * gap.mae, 3),
                Cell::number(factor * gap.max, 3),
                Cell::number(factor * gap.bias, 3),
                Cell::number(gap.ccc, 3),
                Cell::number(1e3 * gap.delay, 1),
            ]
        })
        .collect();
    table
}

/// Mean over all runs of what every run says by itself, column by column.
fn mean_of<'a, T: 'a>(
    gaps: &'a [Gap],
    column: &str,
    parts: impl Fn(&'a Gap) -> &'a [T],
    numbers: impl Fn(&T) -> [f64; 2],
) -> Vec<[f64; 2]> {
    let own: Vec<&[T]> = gaps.iter().filter(|gap| gap.column == column).map(parts).collect();
    let count = own.iter().map(|parts| parts.len()).min().unwrap_or(0);
    let mean = |i: usize| {
        let all: Vec<[f64; 2]> = own.iter().map(|parts| numbers(&parts[i])).collect();
        [0, 1].map(|which| all.iter().map(|numbers| numbers[which]).sum::<f64>() / all.len() as f64)
    };
    (0..count).map(mean).collect()
}

fn names(gaps: &[Gap]) -> Vec<&String> {
    let mut names: Vec<&String> = Vec::new();
    gaps.iter().for_each(|gap| {
        if !names.contains(&&gap.column) {
            names.push(&gap.column)
        }
    });
    names
}

fn places(name: &str, gaps: &[Gap]) -> Table {
    let mut table = Table::new(
        &format!("{name}: where it happens (mean over blocks and runs)"),
        vec![
            Column::text("column"),
            Column::text("where"),
            Column::number("of the time", "%"),
            Column::number("MAE", ""),
            Column::text("unit"),
        ],
    );
    for column in names(gaps) {
        let (factor, unit) = shown(column);
        let means = mean_of(gaps, column, |gap| &gap.places[..], |place| [place.share, place.mae]);
        let first = gaps.iter().find(|gap| gap.column == *column);
        for (place, [share, mae]) in first.iter().flat_map(|gap| &gap.places).zip(means) {
            table.rows.push(vec![
                Cell::text(column.clone()),
                Cell::text(place.place),
                Cell::number(100.0 * share, 0),
                Cell::number(factor * mae, 3),
                Cell::text(unit),
            ]);
        }
    }
    table
}

fn spectra(name: &str, gaps: &[Gap]) -> Table {
    let mut table = Table::new(
        &format!("{name}: the error by frequency (root mean square, mean over blocks and runs)"),
        vec![Column::text("column"), Column::text("band"), Column::number("error", ""), Column::text("unit")],
    );
    for column in names(gaps) {
        let (factor, unit) = shown(column);
        let means = mean_of(gaps, column, |gap| &gap.spectrum[..], |band| [band.rms, 0.0]);
        let first = gaps.iter().find(|gap| gap.column == *column);
        for (band, [rms, _]) in first.iter().flat_map(|gap| &gap.spectrum).zip(means) {
            table.rows.push(vec![
                Cell::text(column.clone()),
                Cell::text(format!("{} to {} Hz", band.from, band.to)),
                Cell::number(factor * rms, 3),
                Cell::text(unit),
            ]);
        }
    }
    table
}

/// Measured, simulated and corrected numbers over time, of the first runs.
fn curves(traces: &[(&str, Vec<Trace>)]) -> Vec<Curve> {
    let mut curves = Vec::new();
    for (which, (name, traces)) in traces.iter().enumerate() {
        for trace in traces.iter().take(DRAWN) {
            for block in &trace.blocks {
                let width = block.measured.names.len();
                let selected = block.selected();
                let x: Vec<f64> = (0..trace.len()).map(|row| row as f64 / trace.rate).collect();
                for (i, column) in block.measured.names.iter().enumerate().take(1) {
                    let (factor, unit) = shown(column);
                    let y = |values: &[f32]| -> Vec<f64> {
                        values.iter().skip(i).step_by(width).map(|v| factor * f64::from(*v)).collect()
                    };
                    let panel = format!("{} over time (s)/{} {column} ({unit})", trace.name, block.name);
                    let mut push = |series: &str, y: Vec<f64>| {
                        curves.push(Curve { name: panel.clone(), series: series.into(), x: x.clone(), y });
                    };
                    if which == 0 {
                        push("measured", y(&block.measured.values));
                    }
                    push(name, y(&selected));
                }
            }
        }
    }
    curves
}
