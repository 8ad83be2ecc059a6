//! Writes a run's folder and a page with a table and a curve: `page [FOLDER]`; open FOLDER/report.html in a browser.

use std::path::PathBuf;

use lifelike_report::run::RunFolder;
use lifelike_report::{Cell, Column, ReportBuilder, Table, curves_from};

#[derive(serde::Serialize)]
struct Plan {
    steps: u64,
    learning_rate: f64,
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = std::env::args().nth(1).map_or_else(|| PathBuf::from("runs/example"), PathBuf::from);
    let plan = Plan { steps: 200, learning_rate: 0.02 };
    let run = RunFolder::create(&folder, &plan)?;
    let mut metrics = run.start_metrics()?;
    // Gradient descent on x².
    let mut x = 3.0;
    for step in 0..plan.steps {
        metrics.log(step, &[("Loss/value", x * x), ("Gradient/norm", 2.0 * x)])?;
        x -= plan.learning_rate * 2.0 * x;
    }
    metrics.sync()?;

    let mut table = Table::new("Result", vec![Column::text("quantity"), Column::number("value", "")]);
    table.caption = "Lower is better.".into();
    table.rows.push(vec![Cell::text("loss"), Cell::number(x * x, 6)]);
    print!("{}", table.to_text());
    let page = ReportBuilder::new("Gradient descent").fact("steps", plan.steps.to_string()).table(table);
    page.curves(curves_from(&run.metrics()?)).write(&run.report_path())?;
    println!("{}", run.report_path().display());
    Ok(())
}
