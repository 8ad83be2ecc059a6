//! Files that the commands read: traces, logs, servos.

use std::path::{Path, PathBuf};

use lifelike_augmentation::identification::Servo;
use lifelike_augmentation::logs::table::{self, TableMap};
use lifelike_augmentation::logs::{BenchLog, small_angles};
use lifelike_robot::Robot;
use lifelike_sim::trace::{Trace, container};

use crate::error::CliError;

/// Reads traces: files, and folders of them, in the order of their names; also records of `lifelike run`.
pub fn traces(paths: &[PathBuf]) -> Result<Vec<Trace>, CliError> {
    let files = files(paths, &[container::EXTENSION])?;
    let read = |file: &PathBuf| match file.extension().is_some_and(|ending| ending == "mcap") {
        true => super::records::trace(file),
        false => Ok(container::load(file)?),
    };
    files.iter().map(read).collect()
}

/// Reads logs of a bench: files, and folders of them.
pub fn bench_logs(paths: &[PathBuf]) -> Result<Vec<BenchLog>, CliError> {
    let files = files(paths, &[".json", ".csv"])?;
    let logs = files.iter().map(|file| BenchLog::read(file)).collect::<Result<Vec<_>, _>>()?;
    for log in &logs {
        log.notes.iter().for_each(|note| tracing::warn!("{}: {note}", log.name));
    }
    Ok(logs)
}

/// Reads the tables of a robot's joints, and warns of columns that hardly move them.
pub fn tables(paths: &[PathBuf], map: &Path, robot: &Robot) -> Result<Vec<Trace>, CliError> {
    let columns: TableMap = described(map)?;
    let range = |joint: &str| robot.character.joints[robot.character.joint(joint).ok()?].range;
    let mut traces = Vec::new();
    for file in files(paths, &[".csv", ".mcap"])? {
        let trace = table::read(&file, &columns)?;
        let remarks = small_angles(&trace, &columns, range);
        remarks.iter().for_each(|remark| tracing::warn!("{}: {remark}", file.display()));
        traces.push(trace);
    }
    Ok(traces)
}

/// Returns a servo by name, or what a file of `lifelike augment identify` says; where none is named, the one that the logs name.
pub fn servo(name: Option<&str>, logs: &[BenchLog]) -> Result<Servo, CliError> {
    let known = Servo::NAMES.join(", ");
    let Some(name) = name else {
        let motor = logs.first().map_or("", |log| log.motor.as_str());
        if let Some(other) = logs.iter().find(|log| log.motor != motor) {
            return Err(CliError::Input(format!(
                "{}: expected logs of one servo ({motor}), got one of {}; name a model with --servo",
                other.name, other.motor
            )));
        }
        return Servo::built_in(motor).ok_or_else(|| {
            CliError::Input(format!(
                "the logs are of a servo '{motor}': expected one of {known}, or --servo with one of them or a file"
            ))
        });
    };
    if let Some(servo) = Servo::built_in(name) {
        return Ok(servo);
    }
    let path = Path::new(name);
    if !path.is_file() {
        return Err(CliError::Input(format!("--servo: expected a file, or one of {known}, got '{name}'")));
    }
    described(path)
}

/// Reads what a TOML file describes: a servo, a map of columns, a twin.
pub fn described<T: serde::de::DeserializeOwned>(path: &Path) -> Result<T, CliError> {
    let text =
        std::fs::read_to_string(path).map_err(|error| CliError::Input(format!("{}: {error}", path.display())))?;
    toml::from_str(&text).map_err(|error| CliError::Input(format!("{}: {error}", path.display())))
}

/// Returns files, and those of folders that have one of the `endings`, in the order of their names.
pub fn files(paths: &[PathBuf], endings: &[&str]) -> Result<Vec<PathBuf>, CliError> {
    let mut files = Vec::new();
    for path in paths {
        if path.is_dir() {
            let entries = std::fs::read_dir(path).map_err(CliError::write(path))?;
            let mut inside: Vec<PathBuf> = entries
                .map(|entry| Ok(entry.map_err(CliError::write(path))?.path()))
                .collect::<Result<Vec<_>, CliError>>()?;
            inside.retain(|file| endings.iter().any(|ending| file.to_string_lossy().ends_with(ending)));
            inside.sort();
            if inside.is_empty() {
                let expected = endings.join(" or ");
                return Err(CliError::Input(format!(
                    "{}: expected files ending in {expected}, got none",
                    path.display()
                )));
            }
            files.extend(inside);
        } else {
            files.push(path.clone());
        }
    }
    Ok(files)
}
