//! Tables and figures of thesis chapter 2 on twins: a network learns on KickBot that is attached at its pelvis, from random motions, and is
//! tested on authored motions of it, of KickBot attached at a foot, and of DanceBot.
//!
//! `cargo run --release -p lifelike-thesis --example twin_tables -- WHAT [iterations] [seeds] [runs] [FOLDER]`, WHAT one of gap,
//! architectures, architectures-bodies, modular, modular-bodies, outputs, current, bodies, speed, perturbed, attention, losses; or
//! `search [iterations] [trials] [runs] [FOLDER]` (`search-ours` for our form). Rows are written to FOLDER/WHAT.json as they are done: the same
//! command continues. `markdown 0 0 0 FOLDER` prints a folder's sheets as tables.
//!
//! Three forms of the network are compared ([`Form`]): the thesis', its training by teacher forcing alone, and ours.

mod common;
mod figures;
mod search;
mod sheet;
mod tables;

use common::{Form, Outcome, Settings};
use sheet::Sheet;

fn main() -> Outcome<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let number = |i: usize, default: u64| arguments.get(i).map_or(Ok(default), |text| text.parse());
    let what = arguments.first().map_or("gap", String::as_str);
    let settings = Settings { iterations: number(1, 1000)?, seeds: number(2, 3)?, runs: number(3, 60)? as usize };
    let folder = arguments.get(4).map_or("runs/chapter-2", String::as_str);
    if what == "markdown" {
        return sheet::markdown(folder);
    }
    let start = std::time::Instant::now();
    let mut sheet = Sheet::open(folder, what, settings)?;
    match what {
        "gap" => tables::gaps(&mut sheet)?,
        "architectures" => tables::table_2_1(&mut sheet, common::SERVO)?,
        "architectures-bodies" => tables::table_2_1(&mut sheet, common::BODY)?,
        "modular" => tables::not_modular(&mut sheet, common::SERVO)?,
        "modular-bodies" => tables::not_modular(&mut sheet, common::BODY)?,
        "outputs" => tables::figure_2_5(&mut sheet)?,
        "current" => tables::figure_2_6(&mut sheet)?,
        "bodies" => tables::figure_2_8(&mut sheet)?,
        "speed" => figures::figure_2_9(&mut sheet)?,
        "perturbed" => figures::figure_2_10(&mut sheet)?,
        "attention" => figures::figure_2_11(&mut sheet)?,
        "losses" => figures::figure_2_12(&mut sheet)?,
        "search" => search::search(&mut sheet, Form::Thesis)?,
        "search-ours" => search::search(&mut sheet, Form::Ours)?,
        other => {
            let known = "gap, architectures, architectures-bodies, modular, modular-bodies, outputs, current, bodies, speed, \
                         perturbed, attention, losses, search, search-ours or markdown";
            return Err(format!("expected {known}, got '{other}'").into());
        }
    }
    println!("{what}: {:.0} s, {}", start.elapsed().as_secs_f64(), sheet.path().display());
    Ok(())
}
