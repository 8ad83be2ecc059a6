//! Prints how sentences are understood: one a line on standard input.
//!
//! `understand [rules|network]` reads them in one way only.

use std::io::BufRead;

use lifelike_language::grammar::Grammar;
use lifelike_language::script::{Reader, Reading};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let grammar = Grammar::builtin()?;
    let reader = Reader::new(&grammar)?;
    let way = match std::env::args().nth(1).as_deref() {
        Some("rules") => Reading::Rules,
        Some("network") => Reading::Network,
        _ => Reading::Both,
    };
    for line in std::io::stdin().lock().lines() {
        let line = line?;
        let script = reader.read_by(&line, way);
        println!("{line}\n    {script}");
        for one in &script.impossible {
            println!("    cannot: {} ({})", one.said, one.because);
        }
        if !script.unknown.is_empty() {
            println!("    not understood: {}", script.unknown.join(", "));
            for (action, probability) in script.unknown.iter().filter_map(|text| reader.nearest(text)) {
                println!("    likeliest: {action} ({probability:.2})");
            }
        }
        script.notes.iter().for_each(|note| println!("    note: {note}"));
    }
    Ok(())
}
