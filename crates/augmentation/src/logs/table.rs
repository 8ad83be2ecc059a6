//! Tables of a robot's joints (CSV with a header, or a bag of ROS 2), with a small map of their columns.
//!
//! ```toml
//! time = "t"                       # the column of seconds
//! rate = 250.0                     # Hz; what the time stamps must be, within a tenth of a step
//!
//! [block.left_knee]
//! class = "xm430"
//! reference.position = { column = "left_knee_goal", unit = "deg" }
//! measured.position = { column = "left_knee", unit = "ticks4096" }
//! measured.current = { column = "left_knee_mA", unit = "mA" }
//! ```
//!
//! Of a bag ([`super::bag`]) the time is `stamp`, and a column is `left_knee.position`.

use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::path::Path;

use lifelike_sim::trace::{BlockTrace, Columns, Trace};

use super::clock::Clock;
use super::{bag, table_checks};
use crate::{AugmentationError, FromInput};

/// A map of a table's columns.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TableMap {
    /// Column of the time (s).
    pub time: String,
    /// Rows per second (Hz).
    pub rate: f64,
    /// The building blocks by name.
    pub block: BTreeMap<String, BlockMap>,
}

/// Columns of one building block.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BlockMap {
    /// Class: blocks of one class are alike.
    pub class: String,
    /// Commands by name.
    #[serde(default)]
    pub reference: BTreeMap<String, ColumnMap>,
    /// Measured columns, by name.
    #[serde(default)]
    pub measured: BTreeMap<String, ColumnMap>,
}

/// One column.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ColumnMap {
    /// Its header.
    pub column: String,
    /// Its unit.
    #[serde(default)]
    pub unit: Unit,
}

/// Units that are turned into SI.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize)]
pub enum Unit {
    /// SI already (rad, rad/s, A, V, N m, m, ...).
    #[default]
    #[serde(rename = "si")]
    Si,
    /// Degrees.
    #[serde(rename = "deg")]
    Degrees,
    /// Degrees per second.
    #[serde(rename = "deg/s")]
    DegreesPerSecond,
    /// Turns per minute.
    #[serde(rename = "rpm")]
    Rpm,
    /// 4096ths of a turn from 2048 on (Dynamixel).
    #[serde(rename = "ticks4096")]
    Ticks,
    /// Thousandths of an ampere.
    #[serde(rename = "mA")]
    Milliampere,
    /// Thousandths of a volt.
    #[serde(rename = "mV")]
    Millivolt,
    /// Thousandths of a metre.
    #[serde(rename = "mm")]
    Millimetre,
}

impl Unit {
    fn to_si(self, x: f64) -> f64 {
        match self {
            Self::Si => x,
            Self::Degrees | Self::DegreesPerSecond => x.to_radians(),
            Self::Rpm => x * TAU / 60.0,
            Self::Ticks => (x - 2048.0) * TAU / 4096.0,
            Self::Milliampere | Self::Millivolt | Self::Millimetre => x * 1e-3,
        }
    }
}

/// Numbers beyond any joint, in SI: beyond it the unit is wrong.
const LARGEST: [(&str, f64, &str); 4] = [
    ("position", 4.0 * TAU, "rad (degrees, or raw ticks?)"),
    ("velocity", 200.0, "rad/s (degrees or rpm?)"),
    ("current", 100.0, "A (mA?)"),
    ("voltage", 200.0, "V (mV?)"),
];

/// Columns of numbers, whatever file they come from.
struct Table {
    time: Vec<f64>,
    columns: BTreeMap<String, Vec<f64>>,
    /// Lines of the file, row by row; none where rows are messages.
    lines: Vec<u64>,
}

impl Table {
    fn place(&self, row: usize, column: &str) -> String {
        match self.lines.get(row) {
            Some(line) => format!("line {line}, column '{column}'"),
            None => format!("row {}, column '{column}'", row + 1),
        }
    }

    /// Reads these columns of a bag; the time is of the first.
    fn of_bag(path: &Path, time: &str, names: &[&str]) -> Result<Self, AugmentationError> {
        if time != "stamp" {
            return Err(AugmentationError::log(path, "the map", "time = \"stamp\" for a bag", format!("'{time}'")));
        }
        let bytes = std::fs::read(path).map_err(AugmentationError::io(path))?;
        let bag = bag::read(path, &bytes)?;
        let fail = |(expected, got)| AugmentationError::log(path, "MCAP", expected, got);
        let (time, values) = bag.rows(names).map_err(fail)?;
        let table = Self {
            time,
            columns: names.iter().map(|name| (*name).to_string()).zip(values).collect(),
            lines: Vec::new(),
        };
        for (name, values) in &table.columns {
            if let Some(row) = values.iter().position(|x| !x.is_finite()) {
                let got = values[row].to_string();
                return Err(AugmentationError::log(path, table.place(row, name), "a finite number", got));
            }
        }
        Ok(table)
    }

    /// Reads these columns of comma-separated values.
    fn of_csv(path: &Path, time: &str, names: &[&str]) -> Result<Self, AugmentationError> {
        let bad = |error: csv::Error| {
            let line = error.position().map_or(1, csv::Position::line);
            AugmentationError::log(path, format!("line {line}"), "a table of comma-separated values", error)
        };
        let text = std::fs::read_to_string(path).map_err(AugmentationError::io(path))?;
        let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).flexible(true).from_reader(text.as_bytes());
        let header = reader.headers().map_err(bad)?.clone();
        let rows: Vec<csv::StringRecord> = reader.into_records().collect::<Result<_, _>>().map_err(bad)?;
        let lines = rows.iter().map(|row| row.position().map_or(0, csv::Position::line)).collect();
        let mut table = Self { time: Vec::new(), columns: BTreeMap::new(), lines };
        for name in [time].iter().chain(names) {
            if header.iter().filter(|own| own == name).count() > 1 {
                let (expected, got) = (format!("one column '{name}'"), "several of that name");
                return Err(AugmentationError::log(path, "line 1", expected, got));
            }
            let index = header.iter().position(|own| own == *name).ok_or_else(|| {
                let got = header.iter().collect::<Vec<_>>().join(",");
                AugmentationError::log(path, "line 1", format!("a column '{name}'"), got)
            })?;
            let number = |(i, cells): (usize, &csv::StringRecord)| {
                let cell = cells.get(index).unwrap_or("");
                cell.parse::<f64>().ok().filter(|x| x.is_finite()).ok_or_else(|| {
                    AugmentationError::log(path, table.place(i, name), "a finite number", format!("'{cell}'"))
                })
            };
            let values = rows.iter().enumerate().map(number).collect::<Result<Vec<_>, _>>()?;
            table.columns.insert((*name).to_string(), values);
        }
        table.time = table.columns.get(time).cloned().unwrap_or_default();
        Ok(table)
    }
}

/// Reads a table: a bag of ROS 2 (`*.mcap`), or comma-separated values.
///
/// # Errors [`AugmentationError::Input`]; [`AugmentationError::Log`] with the place: a missing column, a cell that is no
/// finite number, time that does not rise, a gap, a wrong step, an impossible number.
pub fn read(path: &Path, map: &TableMap) -> Result<Trace, AugmentationError> {
    let measured = map.block.values().flat_map(|block| block.measured.values());
    let commands = map.block.values().flat_map(|block| block.reference.values());
    let names: Vec<&str> = measured.chain(commands).map(|column| column.column.as_str()).collect();
    let is_bag = |ending: &std::ffi::OsStr| ["mcap", "db3"].iter().any(|bag| ending.eq_ignore_ascii_case(bag));
    let table = match path.extension().is_some_and(is_bag) {
        true => Table::of_bag(path, &map.time, &names)?,
        false => Table::of_csv(path, &map.time, &names)?,
    };
    let time = &table.time;
    let row = |i: usize| table.place(i, &map.time);
    let clock = Clock::of(time).map_err(|(i, expected, got)| AugmentationError::log(path, row(i), expected, got))?;
    // Rows are taken as equal steps: a clock of another rate would shift them slowly.
    let (step, length) = (1.0 / map.rate, (time.len() - 1) as f64);
    let mean = (time[time.len() - 1] - time[0]) / length;
    if ((mean - step) * length).abs() > step.max(1e-3 * length * step) || clock.jitter > 0.25 * step {
        let got = format!("{:.3} Hz, jitter {:.2} ms", 1.0 / mean, 1e3 * clock.jitter);
        let expected = format!("{} Hz at equal steps (resample the log, or change 'rate')", map.rate);
        return Err(AugmentationError::log(path, row(0), expected, got));
    }
    let columns = |wanted: &BTreeMap<String, ColumnMap>| -> Result<Columns, AugmentationError> {
        let mut named: Vec<(&str, Vec<f64>)> = Vec::new();
        for (name, map) in wanted {
            let raw = table.columns.get(&map.column).map_or(&[][..], Vec::as_slice);
            let values: Vec<f64> = raw.iter().map(|x| map.unit.to_si(*x)).collect();
            let most = LARGEST.iter().find(|(own, ..)| own == name);
            let beyond = most
                .and_then(|(_, most, unit)| values.iter().position(|x| x.abs() > *most).map(|row| (row, most, unit)));
            if let Some((row, most, unit)) = beyond {
                let place = table.place(row, &map.column);
                let expected = format!("at most {most:.1}");
                return Err(AugmentationError::log(path, place, expected, format!("{} {unit}", values[row])));
            }
            named.push((name, values));
        }
        let slices: Vec<(&str, &[f64])> = named.iter().map(|(name, values)| (*name, &values[..])).collect();
        Ok(Columns::new(&slices))
    };
    let mut blocks = Vec::with_capacity(map.block.len());
    for (name, own) in &map.block {
        let (reference, measured) = (columns(&own.reference)?, columns(&own.measured)?);
        let (name, class) = (name.clone(), own.class.clone());
        let mut block = BlockTrace { name, class, reference, measured, ..BlockTrace::default() };
        block.selection = block.by_name();
        let fail = |(column, expected, got): table_checks::Fault| {
            AugmentationError::log(path, format!("column '{column}'"), expected, got)
        };
        table_checks::agreement(&block, own, map.rate).map_err(fail)?;
        blocks.push(block);
    }
    let name = path.file_stem().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    Ok(Trace { name, source: path.display().to_string(), rate: map.rate, blocks })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use std::f32::consts::{FRAC_PI_2, FRAC_PI_4};

    use super::*;

    const MAP: &str = "time = \"t\"\nrate = 100.0\n[block.knee]\nclass = \"xm430\"\n\
        reference.position = { column = \"goal\", unit = \"deg\" }\nmeasured.position = { column = \"ticks\", unit = \"ticks4096\" }\n";

    fn read_text(text: &str) -> Result<Trace, AugmentationError> {
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), text).unwrap();
        read(file.path(), &toml::from_str(MAP).unwrap())
    }

    #[test]
    fn a_table_is_read_in_si() {
        let trace = read_text("t,goal,ticks\n0.00,90,2048\n0.01,-90,3072\n0.02, 45 ,1024\n").unwrap();
        let block = &trace.blocks[0];
        let goal: Vec<f32> = block.reference.column("position").unwrap().collect();
        assert!(goal.iter().zip([FRAC_PI_2, -FRAC_PI_2, FRAC_PI_4]).all(|(a, b)| (a - b).abs() < 1e-5), "{goal:?}");
        let ticks: Vec<f32> = block.measured.column("position").unwrap().collect();
        assert!(ticks.iter().zip([0.0, FRAC_PI_2, -FRAC_PI_2]).all(|(a, b)| (a - b).abs() < 1e-5), "{ticks:?}");
        assert_eq!((trace.rate, block.class.as_str()), (100.0, "xm430"));
        // Nothing is simulated yet: there is nothing to compare, and that is fine.
        trace.check().unwrap();
    }

    /// Radians that a map calls degrees, and the reverse, against a command or a speed of another unit.
    #[test]
    fn angles_of_another_unit_are_refused_with_the_cure() {
        let table = |goal: f64, position: f64, speed: f64| {
            let row = |i: i32| {
                let t = 0.01 * f64::from(i);
                let (g, p) = (goal * (3.0 * t).sin(), position * 0.9 * (3.0 * t - 0.1).sin());
                format!("{t},{g},{p},{}\n", speed * 2.7 * (3.0 * t - 0.1).cos())
            };
            format!("t,goal,angle,speed\n{}", (0..300).map(row).collect::<String>())
        };
        let map = |goal: &str, angle: &str, speed: &str| {
            let measured = format!("measured.position = {{ column = 'angle', unit = '{angle}' }}");
            let [command, rate] = [("reference.position", "goal", goal), ("measured.velocity", "speed", speed)].map(
                |(name, column, unit)| match unit {
                    "" => String::new(),
                    unit => format!("{name} = {{ column = '{column}', unit = '{unit}' }}"),
                },
            );
            format!("time = 't'\nrate = 100.0\n[block.knee]\nclass = 'a'\n{measured}\n{command}\n{rate}\n")
        };
        let told = |text: &str, map: &str| {
            let file = tempfile::NamedTempFile::new().unwrap();
            std::fs::write(file.path(), text).unwrap();
            read(file.path(), &toml::from_str(map).unwrap())
        };
        let (rad, deg) = (1.0, 180.0 / std::f64::consts::PI);
        for (text, map, parts) in [
            (table(deg, rad, rad), map("deg", "deg", ""), ["moves as far as 'goal'", "unit = \"si\" for 'angle'"]),
            (table(rad, deg, rad), map("deg", "deg", ""), ["moves as far as 'goal'", "unit = \"si\" for 'goal'"]),
            (
                table(0.3 * deg, 0.3 * rad, rad),
                map("si", "si", ""),
                ["got 0.01", "unit = \"deg\" or \"deg/s\" for 'goal'"],
            ),
            (table(rad, rad, rad), map("", "deg", "si"), ["as fast as 'speed' says", "unit = \"si\" for 'angle'"]),
            (table(rad, rad, deg), map("si", "si", "si"), ["as fast as 'speed' says", "for 'speed'"]),
        ] {
            let error = told(&text, &map).unwrap_err().to_string();
            assert!(error.contains("column 'angle'") && parts.iter().all(|part| error.contains(part)), "{error}");
        }
        assert!(told(&table(deg, rad, deg), &map("deg", "si", "deg/s")).is_ok());
        // Where all columns are called wrongly, the joint's range tells.
        let wrong = map("deg", "deg", "");
        let trace = told(&table(rad, rad, rad), &wrong).unwrap();
        let remarks =
            |low, high| table_checks::small_angles(&trace, &toml::from_str(&wrong).unwrap(), |_| Some((low, high)));
        let said = remarks(-1.5, 1.5).concat();
        assert!(
            said.contains("column 'goal' moves 'knee' by 2.00 of its 172 deg") && said.contains("'angle'"),
            "{said}"
        );
        assert!(remarks(-0.2, 0.2).is_empty(), "in radians it would not fit");
        let right = told(&table(deg, deg, deg), &wrong).unwrap();
        let map = toml::from_str(&wrong).unwrap();
        assert!(table_checks::small_angles(&right, &map, |_| Some((-1.5, 1.5))).is_empty());
    }

    #[test]
    fn what_is_wrong_is_told_with_line_and_column() {
        for (text, part) in [
            ("t,goal\n0,1\n0.01,1\n", "line 1: expected a column 'ticks'"),
            ("t,goal,ticks,goal\n0,1,2,1\n0.01,1,2,1\n", "line 1: expected one column 'goal', got several"),
            ("t,goal,ticks\n0,1,2048\n0.01,x,2048\n", "line 3, column 'goal': expected a finite number, got 'x'"),
            ("t,goal,ticks\n0,1,2048\n0.01,1,nan\n", "line 3, column 'ticks': expected a finite number, got 'nan'"),
            ("t,goal,ticks\n0,1,2048\n0.01,1\n", "line 3, column 'ticks': expected a finite number, got ''"),
            ("t,goal,ticks\n0,1,2048\n0.01,1,2048\n0.01,1,2048\n", "line 4, column 't': expected a time after 0.01 s"),
            ("t,goal,ticks\n0,1,2048\n0.01,1,2048\n0.02,1,2048\n0.5,1,2048\n", "line 5, column 't': expected no gap"),
            ("t,goal,ticks\n0,1,2048\n0.02,1,2048\n0.04,1,2048\n0.06,1,2048\n", "expected 100 Hz at equal steps"),
            ("t,goal,ticks\n0,1,2048\n0.01,1000000,2048\n", "column 'goal': expected at most 25.1, got 17453"),
        ] {
            let message = read_text(text).unwrap_err().to_string();
            assert!(message.contains(part), "{message}");
        }
    }
}
