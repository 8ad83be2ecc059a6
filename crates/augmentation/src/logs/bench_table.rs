//! A bench's log as a table, of any servo: CSV whose header says each column's unit, after lines that say the rest.
//!
//! ```text
//! # motor = xl330
//! # mass = 0.1 kg
//! # arm_mass = 20 g     ; 0 where not said
//! # length = 15 cm
//! # kp = 400            ; the servo's own unit
//! # vin = 7.5 V
//! time [ms], goal [deg], position [deg], speed [rpm], duty [1]
//! ```
//!
//! Masses are in kg or g, lengths in m, cm or mm, `vin` in V or mV; without a unit in SI. A remark follows a semicolon.
//! `speed` may be missing: it is the change of the position then. So may one of `voltage` and `duty`, `supply` (V) and `enabled` (0 or
//! 1).

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use super::bam::BenchLog;
use crate::AugmentationError;

/// Columns, and the units of each with their factors to SI.
const COLUMNS: [(&str, &[(&str, f64)]); 8] = [
    ("time", &[("s", 1.0), ("ms", 1e-3), ("us", 1e-6)]),
    ("goal", ANGLES),
    ("position", ANGLES),
    ("speed", &[("rad/s", 1.0), ("deg/s", std::f64::consts::PI / 180.0), ("rpm", std::f64::consts::TAU / 60.0)]),
    ("voltage", VOLTS),
    ("duty", &[("1", 1.0), ("%", 0.01)]),
    ("supply", VOLTS),
    ("enabled", &[("1", 1.0)]),
];
const ANGLES: &[(&str, f64)] = &[("rad", 1.0), ("deg", std::f64::consts::PI / 180.0), ("turns", std::f64::consts::TAU)];
const VOLTS: &[(&str, f64)] = &[("V", 1.0), ("mV", 1e-3)];

/// Units of the numbers before the table; SI where none is said.
const UNITS: [(&str, &[(&str, f64)]); 4] = [
    ("mass", &[("kg", 1.0), ("g", 1e-3)]),
    ("arm_mass", &[("kg", 1.0), ("g", 1e-3)]),
    ("length", &[("m", 1.0), ("cm", 1e-2), ("mm", 1e-3)]),
    ("vin", VOLTS),
];

/// Reads a table.
pub(super) fn read(text: &str, path: &Path) -> Result<BenchLog, AugmentationError> {
    let fail = |place: String, expected: String, got: String| AugmentationError::log(path, place, expected, got);
    let mut said = BTreeMap::new();
    let mut header: Option<Vec<(&str, f64)>> = None;
    let mut columns: BTreeMap<&str, Vec<f64>> = BTreeMap::new();
    for (i, line) in text.lines().enumerate().map(|(i, line)| (i + 1, line.trim())).filter(|(_, line)| !line.is_empty())
    {
        if let Some(comment) = line.strip_prefix('#') {
            said.extend(comment.split_once('=').map(|(key, value)| (key.trim(), value.trim())));
            continue;
        }
        let cells: Vec<&str> = line.split(',').map(str::trim).collect();
        let Some(names) = &header else {
            let names = cells.into_iter().map(column).collect::<Result<Vec<_>, _>>();
            let names = names.map_err(|(expected, got)| fail(format!("line {i}"), expected, got))?;
            let mut known = BTreeSet::new();
            if let Some((name, _)) = names.iter().find(|(name, _)| !known.insert(*name)) {
                return Err(fail(format!("line {i}"), "each column once".into(), format!("'{name}' twice")));
            }
            header = Some(names);
            continue;
        };
        if cells.len() != names.len() {
            return Err(fail(format!("line {i}"), format!("{} numbers", names.len()), cells.len().to_string()));
        }
        for ((name, factor), cell) in names.iter().zip(cells) {
            let number: f64 = cell
                .parse()
                .map_err(|_| fail(format!("line {i}, column '{name}'"), "a number".into(), format!("'{cell}'")))?;
            columns.entry(name).or_default().push(number * factor);
        }
    }
    let mut take = |name: &str| columns.remove(name);
    let needed = |name: &str, column: Option<Vec<f64>>| {
        column.ok_or_else(|| fail("header".into(), format!("a column '{name}'"), "none".into()))
    };
    let (time, goal, position) =
        (needed("time", take("time"))?, needed("goal", take("goal"))?, needed("position", take("position"))?);
    let number = |key: &str, otherwise: Option<f64>| {
        let Some(value) = said.get(key) else {
            return otherwise.ok_or_else(|| fail("header".into(), format!("a line '# {key} = NUMBER'"), "none".into()));
        };
        let units = UNITS.into_iter().find(|(known, _)| *known == key).map_or(&[][..], |(_, units)| units);
        // A remark may follow after a semicolon; that of `kp` is free, since its unit is the servo's own.
        let mut words = value.split(';').next().unwrap_or_default().split_whitespace();
        let number: Option<f64> = words.next().and_then(|word| word.parse().ok());
        let factor = match words.next() {
            Some(unit) if !units.is_empty() => {
                units.iter().find(|(known, _)| *known == unit).map(|(_, factor)| *factor)
            }
            _ => Some(1.0),
        };
        let list = || units.iter().map(|(unit, _)| *unit).collect::<Vec<_>>().join(", ");
        let expected = || if units.is_empty() { "a number".into() } else { format!("a number in {}", list()) };
        let product = number.zip(factor).map(|(number, factor)| number * factor);
        product.ok_or_else(|| fail(format!("'# {key}'"), expected(), format!("'{value}'")))
    };
    let supply = number("vin", None)?;
    let supplies = take("supply").unwrap_or_else(|| vec![supply; time.len()]);
    let duty = take("duty").map(|duty| duty.iter().zip(&supplies).map(|(duty, supply)| duty * supply).collect());
    Ok(BenchLog {
        motor: said.get("motor").unwrap_or(&"").to_string(),
        trajectory: said.get("trajectory").unwrap_or(&"").to_string(),
        mass: number("mass", None)?,
        arm_mass: number("arm_mass", Some(0.0))?,
        arm: number("length", None)?,
        gain: number("kp", None)?,
        supply,
        velocity: take("speed").unwrap_or_else(|| rates(&time, &position)),
        voltage: take("voltage").or(duty),
        enabled: take("enabled").map_or_else(|| vec![true; time.len()], |on| on.iter().map(|on| *on != 0.0).collect()),
        time,
        goal,
        position,
        ..BenchLog::default()
    })
}

/// Returns a column's name and the factor of its unit, from `name [unit]`.
fn column(cell: &str) -> Result<(&'static str, f64), (String, String)> {
    let (name, unit) = cell.trim_end_matches(']').split_once('[').unwrap_or((cell, ""));
    let (name, unit) = (name.trim(), unit.trim());
    let Some((name, units)) = COLUMNS.into_iter().find(|(known, _)| *known == name) else {
        let known = COLUMNS.map(|(known, _)| known).join(", ");
        return Err((
            format!("a column's name and unit, such as 'position [deg]'; names are {known}"),
            format!("'{cell}'"),
        ));
    };
    let factor = units.iter().find(|(known, _)| *known == unit).map(|(_, factor)| *factor);
    let list = || units.iter().map(|(unit, _)| *unit).collect::<Vec<_>>().join(", ");
    factor
        .map(|factor| (name, factor))
        .ok_or_else(|| (format!("'{name} [UNIT]' with one of {}", list()), format!("'{cell}'")))
}

/// Returns the change of a position in time, by the neighbours of each row.
fn rates(time: &[f64], position: &[f64]) -> Vec<f64> {
    let last = time.len().saturating_sub(1);
    let rate = |i: usize| {
        let (before, after) = (i.saturating_sub(1), (i + 1).min(last));
        if time[after] > time[before] {
            (position[after] - position[before]) / (time[after] - time[before])
        } else {
            0.0
        }
    };
    (0..time.len()).map(rate).collect()
}
