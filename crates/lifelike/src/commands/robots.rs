//! `lifelike robots`: the robots that come with the program.

use lifelike_robot::{Robot, load};
use serde_json::{Value, json};

use crate::error::CliError;
use crate::output::{Output, table};

/// List the robots that come with the program.
///
/// Name any other robot by the path of its MJCF or URDF file. A profile beside it (robot.toml beside robot.xml) adds
/// what the file does not contain: actuators, tracked sites, default pose.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  lifelike robots
  lifelike inspect lima                         # one of them in detail
  lifelike inspect third_party/robots/unitree_g1/g1.xml")]
pub struct Args {}

/// Runs the command.
pub fn run(_args: &Args, output: &Output) -> Result<(), CliError> {
    let robots = load::NAMES.iter().map(|name| Robot::load(name)).collect::<Result<Vec<_>, _>>()?;
    let values: Vec<Value> = robots
        .iter()
        .map(|r| {
            json!({
                "name": r.name, "dof": r.joints(), "mass_kg": r.character.mass(),
                "height_m": height(r), "control_hz": r.control_hz, "end_effectors": r.layout.end_effectors,
            })
        })
        .collect();
    output.result(&values, || {
        let row = |r: &Robot| {
            vec![
                r.name.clone(),
                r.joints().to_string(),
                format!("{:.2}", r.character.mass()),
                format!("{:.2}", height(r)),
                format!("{}", r.control_hz),
            ]
        };
        let rows: Vec<Vec<String>> = robots.iter().map(row).collect();
        table(&["robot", "DoF", "mass (kg)", "root height (m)", "policy (Hz)"], &rows)
    })
}

/// Height of the root's frame where the model puts it (m).
pub fn height(robot: &Robot) -> f64 {
    let q = robot.default_position();
    robot.character.root_joint().and_then(|joint| q.get(joint.q_index + 2)).copied().unwrap_or(0.0)
}
