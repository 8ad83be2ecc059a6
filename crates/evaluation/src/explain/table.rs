//! Explanations as a table.

use super::Explanation;
use lifelike_report::{Cell, Column, Table, Tone};

/// One row per clip that fell; `None` when none did.
pub fn table(explanations: &[Explanation]) -> Option<Table> {
    let columns = vec![
        Column::text("clip"),
        Column::number("falls", ""),
        Column::number("at", "s"),
        Column::text("how"),
        Column::text("what came before"),
        Column::text("the clip itself"),
        Column::text("proposal"),
    ];
    let mut table = Table::new("Why it falls, and what would help", columns);
    table.caption =
        "The first fall of each clip, what is wrong with the clip's own kinematics within a second of it, and the \
                     mildest of slowing down and attenuation with which it survives from all starts, tried in physics."
            .into();
    let row = |e: &Explanation| {
        let tone = if e.modification.is_some() { Tone::Good } else { Tone::Bad };
        vec![
            Cell::text(&e.clip),
            Cell::text(format!("{} of {}", e.falls, e.episodes)),
            Cell::number(e.failure.clip_second, 2),
            Cell::text(e.failure.cause.words()),
            Cell::text(e.failure.why()),
            Cell::text(e.clip_words()),
            Cell::text(e.proposal()).tone(Some(tone)),
        ]
    };
    table.rows = explanations.iter().map(row).collect();
    if table.rows.is_empty() { None } else { Some(table) }
}
