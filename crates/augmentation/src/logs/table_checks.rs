//! Angles of a table in a unit that the map does not say: commands, speeds and the joints' ranges are the evidence.

use std::f64::consts::PI;

use lifelike_sim::trace::{BlockTrace, Columns, Trace};

use super::bench_checks::{SAME, fit};
use super::table::{BlockMap, ColumnMap, TableMap, Unit};

/// Radians of a degree, and quotients that are as near to it as noise and filters leave them.
const DEGREE: f64 = PI / 180.0;
const NEAR: std::ops::Range<f64> = 0.7..1.4;
/// Motion as a part of the joint's range: below the first it is doubtful if the numbers, read as radians, are above the
/// second.
const SMALL: f64 = 0.05;
const USUAL: f64 = 0.1;

/// Column, expected, got.
pub(super) type Fault = (String, String, String);

/// Checks that a measured position moves as its command does, and as fast as its speed says.
pub(super) fn agreement(block: &BlockTrace, map: &BlockMap, rate: f64) -> Result<(), Fault> {
    let (Some(position), Some(own)) = (numbers(&block.measured, "position"), map.measured.get("position")) else {
        return Ok(());
    };
    if let (Some(goal), Some(other)) = (numbers(&block.reference, "position"), map.reference.get("position")) {
        let expected = format!("a position that moves as far as '{}'", other.column);
        compare(own, other, fit(&goal, &position), expected)?;
    }
    if let (Some(speed), Some(other)) = (numbers(&block.measured, "velocity"), map.measured.get("velocity")) {
        let rates: Vec<f64> = position.windows(3).map(|p| 0.5 * (p[2] - p[0]) * rate).collect();
        let speed = speed.get(1..speed.len().saturating_sub(1)).unwrap_or_default();
        let expected = format!("a position that moves as fast as '{}' says", other.column);
        compare(own, other, fit(speed, &rates), expected)?;
    }
    Ok(())
}

/// Refuses a position whose slope over another column is that of degrees over radians, or the reverse.
fn compare(own: &ColumnMap, other: &ColumnMap, (slope, same): (f64, f64), expected: String) -> Result<(), Fault> {
    let (small, large) = match slope {
        _ if same < SAME => return Ok(()),
        s if NEAR.contains(&(s / DEGREE)) => (own, other),
        s if NEAR.contains(&(s * DEGREE)) => (other, own),
        _ => return Ok(()),
    };
    let cure = match (small.unit, large.unit) {
        (Unit::Degrees | Unit::DegreesPerSecond, _) => format!("radians? unit = \"si\" for '{}'", small.column),
        (_, Unit::Si) => format!("degrees? unit = \"deg\" or \"deg/s\" for '{}'", large.column),
        _ => "degrees and radians?".to_owned(),
    };
    Err((own.column.clone(), expected, format!("{slope:.4} times that ({cure})")))
}

/// Returns remarks on columns of degrees that hardly move a joint, but would move it as usual if they were radians.
/// `range` is that of a joint (rad).
pub fn small_angles(trace: &Trace, map: &TableMap, range: impl Fn(&str) -> Option<(f64, f64)>) -> Vec<String> {
    let mut remarks = Vec::new();
    for block in &trace.blocks {
        let (Some((low, high)), Some(own)) = (range(&block.name), map.block.get(&block.name)) else { continue };
        let whole = high - low;
        for (columns, maps) in [(&block.reference, &own.reference), (&block.measured, &own.measured)] {
            let Some(column) = maps.get("position").filter(|column| column.unit == Unit::Degrees) else { continue };
            let angles = numbers(columns, "position").unwrap_or_default();
            let least = angles.iter().copied().fold(f64::INFINITY, f64::min);
            let most = angles.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            let (moves, as_radians) = (most - least, (most - least) / DEGREE);
            let fits = least / DEGREE > low - USUAL * whole && most / DEGREE < high + USUAL * whole;
            if moves < SMALL * whole && as_radians > USUAL * whole && fits {
                let (moves, whole) = (moves / DEGREE, whole / DEGREE);
                remarks.push(format!(
                    "column '{}' moves '{}' by {moves:.2} of its {whole:.0} deg; in radians it would fit: unit = \"si\"?",
                    column.column, block.name
                ));
            }
        }
    }
    remarks
}

fn numbers(columns: &Columns, name: &str) -> Option<Vec<f64>> {
    Some(columns.column(name)?.map(f64::from).collect())
}
