//! `lifelike plans`: the training plans that come with the program.

use lifelike_report::{Cell, Column, Table};
use serde_json::json;

use crate::error::CliError;
use crate::output::Output;
use crate::plans::{self, builtin};

/// List the training plans that come with the program, or print one.
///
/// A plan is a TOML file: robot, clips, and whatever differs from the defaults. `--plan` takes a name of this list or a file.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  lifelike plans
  lifelike plans track-walk > my.toml            # a copy to change, for --plan my.toml
  lifelike train tracker --plan track   # by name: needs no data but the program's own clips
  lifelike train tracker --keys                  # every key of a tracker's plan")]
pub struct Args {
    /// A plan's name; its text is printed.
    pub name: Option<std::path::PathBuf>,
}

/// Runs the command.
///
/// # Errors
/// [`CliError::Input`] for a name that is none.
pub fn run(args: &Args, output: &Output) -> Result<(), CliError> {
    if let Some(name) = &args.name {
        let plan = plans::find(name)?;
        return output.result(&json!({ "plan": plan.source, "text": plan.text }), || plan.text.clone());
    }
    let value: Vec<_> = builtin()
        .map(|plan| {
            json!({
                "name": plan.name, "command": plan.command(), "about": plan.about(),
                "stands_alone": plan.stands_alone(),
            })
        })
        .collect();
    output.result(&value, || {
        let row = |plan: plans::BuiltinPlan| {
            let data = if plan.stands_alone() { "none" } else { "yours" };
            [plan.name, data, plan.command(), &plan.about()].map(Cell::text).into()
        };
        let columns = ["plan", "data", "for lifelike", "about"].map(Column::text);
        let mut table = Table::new("Plans", columns.into());
        table.rows = builtin().map(row).collect();
        format!(
            "{}\n`lifelike plans NAME` prints a plan; where data of yours is needed, its first lines say which. Every plan \
             takes other clips and robots:\n  lifelike train tracker --plan track --robot MY_ROBOT.xml 'clips=[\"data/mine\"]'\n",
            crate::output::fitted(&table)
        )
    })
}
