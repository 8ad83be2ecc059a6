//! Trains the network that reads sentences: `train_reader SENTENCES OUT.safetensors EPOCHS SEED`.
//!
//! Each line is a sentence with its actions marked (`data/README.md`). Every tenth is held out.

use lifelike_language::grammar::Grammar;
use lifelike_language::script::{ReaderPlan, train_reader};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    lifelike_nn::memory::tune_allocator();
    let arguments: Vec<String> = std::env::args().collect();
    let [_, sentences, out, epochs, seed] = &arguments[..] else {
        return Err("expected SENTENCES OUT.safetensors EPOCHS SEED".into());
    };
    let text = std::fs::read_to_string(sentences)?;
    let (mut train, mut held_out) = (Vec::new(), Vec::new());
    for (number, line) in text.lines().enumerate() {
        let to = if number % 10 == 9 { &mut held_out } else { &mut train };
        to.push(line.to_string());
    }
    let plan = ReaderPlan { epochs: epochs.parse()?, seed: seed.parse()? };
    println!("{} sentences, {} held out", train.len(), held_out.len());
    let start = std::time::Instant::now();
    let share = |n: usize, of: usize| 100.0 * n as f64 / of.max(1) as f64;
    let (file, stored) = train_reader(&Grammar::builtin()?, &train, &held_out, plan, |epoch, loss, score| {
        println!(
            "epoch {epoch}, loss {loss:.3}: {:.1}% of sentences right, {:.1}% of actions named, {:.0} s",
            share(score.right, score.sentences),
            share(score.named[1], score.named[0]),
            start.elapsed().as_secs_f64()
        );
    })?;
    println!(
        "stored: {:.1}% of sentences right, {:.1}% of actions named",
        share(stored.right, stored.sentences),
        share(stored.named[1], stored.named[0])
    );
    file.save(std::path::Path::new(out))?;
    Ok(())
}
