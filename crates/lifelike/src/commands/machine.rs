//! The machine that the program runs on: what it has, what was chosen, what it can do at most.

pub mod peak;

use std::{fs::OpenOptions, io::Write};

use lifelike_report::run::RunFolder;
use lifelike_simd::InstructionSet;
use serde::Serialize;

use crate::error::CliError;

/// Facts about the machine that results and their speed depend on.
#[derive(Debug, Clone, Default, Serialize)]
pub struct Machine {
    /// Name of the processor, where the system tells it.
    pub processor: Option<String>,
    /// Architecture that the program was compiled for.
    pub architecture: &'static str,
    /// Cores that the program may use.
    pub cores: usize,
    /// Vector instructions that this process uses.
    pub instruction_set: &'static str,
}

impl Machine {
    /// Looks at this machine.
    pub fn this() -> Self {
        Self {
            processor: line("/proc/cpuinfo", "model name"),
            architecture: std::env::consts::ARCH,
            cores: std::thread::available_parallelism().map_or(1, std::num::NonZero::get),
            instruction_set: InstructionSet::chosen().name(),
        }
    }

    /// Adds a line to the `machine.jsonl` of a run: one for each sitting, because a run may go on elsewhere.
    pub fn record(&self, run: &RunFolder) -> Result<(), CliError> {
        let path = run.machine_path();
        let line = serde_json::to_string(self).map_err(|e| CliError::Failed(e.to_string()))?;
        let file = OpenOptions::new().create(true).append(true).open(&path);
        file.and_then(|mut file| writeln!(file, "{line}")).map_err(CliError::write(&path))
    }
}

/// Returns the bytes of memory that programs may still take and those of all, where the system tells them (Linux).
pub fn memory() -> Option<[u64; 2]> {
    let bytes = |key| line("/proc/meminfo", key)?.strip_suffix(" kB")?.parse::<u64>().ok().map(|kib| 1024 * kib);
    Some([bytes("MemAvailable")?, bytes("MemTotal")?])
}

/// Returns the largest amount of memory that this process has used so far (bytes), where the system tells it (Linux).
pub fn peak_memory() -> Option<u64> {
    line("/proc/self/status", "VmHWM")?.strip_suffix(" kB")?.trim().parse::<u64>().ok().map(|kib| 1024 * kib)
}

/// Returns the value of the first line `key : value` of a file of the system.
fn line(file: &str, key: &str) -> Option<String> {
    let text = std::fs::read_to_string(file).ok()?;
    let value = |line: &str| line.split_once(':').filter(|(k, _)| k.trim() == key).map(|(_, v)| v.trim().to_string());
    text.lines().find_map(value)
}
