//! All blocks of a class as one: the alternative that is not modular (thesis 2.5.1).

use lifelike_sim::trace::{BlockTrace, Columns, Selected, Trace};

/// Returns the trace with one block in place of all of a class, `all`, whose columns are named `BLOCK.COLUMN`. A
/// network that learns from it sees every block at once, knows each by its place, and serves this robot alone.
pub fn merged(trace: &Trace, class: &str) -> Trace {
    let own: Vec<&BlockTrace> = trace.blocks.iter().filter(|block| block.class == class).collect();
    let side_by_side = |part: fn(&BlockTrace) -> &Columns| {
        let mut names = Vec::new();
        own.iter()
            .for_each(|block| names.extend(part(block).names.iter().map(|name| format!("{}.{name}", block.name))));
        let rows = own.iter().map(|block| part(block).rows().len()).max().unwrap_or(0);
        let row = |row: usize| {
            own.iter().flat_map(move |block| {
                let columns = part(block);
                let width = columns.names.len();
                columns.values[row * width..][..width].iter().copied()
            })
        };
        Columns { names, values: (0..rows).flat_map(row).collect() }
    };
    let selected = |block: &&BlockTrace| {
        let named = |name: &String| format!("{}.{name}", block.name);
        let row = |row: &Selected| Selected {
            measured: named(&row.measured),
            state: row.state.iter().map(|(name, factor)| (named(name), *factor)).collect(),
        };
        block.selection.iter().map(row).collect::<Vec<_>>()
    };
    let block = BlockTrace {
        name: "all".into(),
        class: class.into(),
        simulated: side_by_side(|block| &block.simulated),
        force: side_by_side(|block| &block.force),
        reference: side_by_side(|block| &block.reference),
        measured: side_by_side(|block| &block.measured),
        selection: own.iter().flat_map(selected).collect(),
        ..BlockTrace::default()
    };
    Trace { blocks: vec![block], ..trace.clone() }
}

/// Puts the simulated columns of a merged trace back into the blocks that they came from.
pub fn split(merged: &Trace, into: &mut Trace) {
    let Some(all) = merged.blocks.first() else { return };
    for block in into.blocks.iter_mut().filter(|block| block.class == all.class) {
        let width = block.simulated.names.len();
        for (i, name) in block.simulated.names.iter().enumerate() {
            let Some(column) = all.simulated.column(&format!("{}.{name}", block.name)) else { continue };
            let own = block.simulated.values.iter_mut().skip(i).step_by(width);
            own.zip(column).for_each(|(own, x)| *own = x);
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn numbers_stay_with_their_names() {
        let block = |name: &str, by: f64| {
            let mut block = BlockTrace {
                name: name.into(),
                class: "servo".into(),
                simulated: Columns::new(&[("position", &[by, by + 1.0]), ("torque", &[0.5, 0.5])]),
                measured: Columns::new(&[("position", &[by + 0.1, by + 1.2])]),
                ..BlockTrace::default()
            };
            block.selection = block.by_name();
            block
        };
        let other = BlockTrace { class: "body".into(), ..block("foot", 9.0) };
        let blocks = vec![block("hip", 1.0), other, block("knee", 5.0)];
        let trace = Trace { name: "run".into(), source: String::new(), rate: 10.0, blocks };
        let merged = merged(&trace, "servo");
        merged.check().unwrap();
        let block = &merged.blocks[0];
        assert_eq!(block.simulated.names, ["hip.position", "hip.torque", "knee.position", "knee.torque"]);
        assert_eq!(block.simulated.column("knee.position").unwrap().collect::<Vec<_>>(), [5.0, 6.0]);
        let mut back = trace.clone();
        back.blocks[2].simulated.values.fill(0.0);
        split(&merged, &mut back);
        assert_eq!(back, trace);
        let error = block.error();
        assert!((error[2] - 0.2).abs() < 1e-6 && (error[3] - 0.2).abs() < 1e-6, "{error:?}");
    }
}
