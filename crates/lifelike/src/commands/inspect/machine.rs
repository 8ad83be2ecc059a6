//! This machine.

use lifelike_simd::{InstructionSet, VARIABLE};
use serde_json::json;

use crate::commands::machine::{Machine, memory, peak};
use crate::error::CliError;
use crate::output::{Output, table};

/// Prints what this machine has and what one core of it can do.
pub fn inspect(output: &Output) -> Result<(), CliError> {
    let machine = Machine::this();
    let sets: Vec<&str> = InstructionSet::available().into_iter().map(InstructionSet::name).collect();
    let (operations, cache) = (peak::operations(InstructionSet::chosen()), peak::cache_bytes(InstructionSet::chosen()));
    let memory = memory();
    let value = json!({
        "kind": "machine", "machine": machine, "instruction_sets": sets,
        "peak_operations_per_second": operations, "cache_bytes_per_second": cache,
        "memory_bytes": memory.map(|[free, all]| json!({ "free": free, "all": all })),
    });
    output.result(&value, || {
        let row = |name: &str, value: String| vec![name.to_string(), value];
        let unknown = || "unknown".to_string();
        let gib = |bytes: u64| bytes as f64 / f64::from(1 << 30);
        let chosen = machine.instruction_set;
        let rows = [
            row("processor", machine.processor.clone().unwrap_or_else(unknown)),
            row("architecture", machine.architecture.into()),
            row("cores", machine.cores.to_string()),
            row("memory", memory.map_or_else(unknown, |m| format!("{:.1} of {:.1} GiB free", gib(m[0]), gib(m[1])))),
            row("instruction sets", sets.join(", ")),
            row("chosen", chosen.into()),
            row("one core, multiply-adds", format!("{:.1} Gflop/s", 1e-9 * operations)),
            row("one core, second-level cache", format!("{:.0} GB/s", 1e-9 * cache)),
        ];
        let other = sets.iter().copied().find(|set| *set != chosen).unwrap_or(chosen);
        format!(
            "{}\nMultiply-adds are in single precision and rounded once, as in physics; measured with {chosen}.\n\
             {VARIABLE}={other} forces another instruction set.\n",
            table(&["this machine", ""], &rows)
        )
    })
}
