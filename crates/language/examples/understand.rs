//! Prints how sentences are understood: one a line on standard input.

use std::io::BufRead;

use lifelike_language::grammar::Grammar;
use lifelike_language::script::Reader;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let grammar = Grammar::builtin()?;
    let reader = Reader::new(&grammar)?;
    for line in std::io::stdin().lock().lines() {
        let line = line?;
        let script = reader.read(&line);
        println!("{line}\n    {script}");
        for one in &script.impossible {
            println!("    cannot: {} ({})", one.said, one.because);
        }
        if !script.unknown.is_empty() {
            println!("    not understood: {}", script.unknown.join(", "));
            for (phrase, similarity) in script.unknown.iter().filter_map(|text| reader.nearest(text)) {
                println!("    nearest: {phrase} ({similarity:.2})");
            }
        }
        script.notes.iter().for_each(|note| println!("    note: {note}"));
    }
    Ok(())
}
