//! Our table: time, root, and the joints by name.

use std::iter::once;

use lifelike_character::Vec3;

use super::quaternions::Order;
use super::table::{self, Table};
use super::{Content, Context, Fit, Layout, Part, Rate, RobotMotion, container, unfit};
use crate::clip::MotionClip;
use crate::error::MotionError;

/// Columns before the joints.
const LEAD: [&str; 8] = ["time_s", "root_x_m", "root_y_m", "root_z_m", "root_qw", "root_qx", "root_qy", "root_qz"];

pub(super) const CSV: Layout = Layout {
    name: "csv",
    title: "lifelike's CSV",
    endings: &[".csv"],
    rate: Rate::Stated,
    holds: &[Part::Names],
    needs_robot: false,
    fits: |content, _| Ok(if is_ours(content) { Fit::Yes } else { Fit::No }),
    read,
    write,
};

/// Returns whether a column is one that only this layout has.
pub(super) fn is_column(name: &str) -> bool {
    name == LEAD[1]
}

fn is_ours(content: &Content<'_>) -> bool {
    let Content::Table(Table { header: Some(header), .. }) = content else { return false };
    LEAD.iter().all(|lead| header.iter().any(|column| column == lead))
}

fn read(content: &mut Content<'_>, context: &Context<'_>) -> Result<RobotMotion, MotionError> {
    let Content::Table(table) = content else { return Err(context.expected("a table of numbers")) };
    let lead: Vec<usize> = LEAD.iter().filter_map(|name| table.column(name)).collect();
    let (Some(header), [time, x, y, z, turn @ ..], 8) = (&table.header, lead.as_slice(), lead.len()) else {
        return Err(context.expected(&format!("columns {}, and the joints by name", LEAD.join(", "))));
    };
    let joints: Vec<usize> = (0..header.len()).filter(|column| !lead.contains(column)).collect();
    let turns: Vec<f64> = table.rows().flat_map(|row| turn.iter().map(|column| row[*column])).collect();
    let times: Vec<f64> = table.rows().map(|row| row[*time]).collect();
    Ok(RobotMotion {
        fps: Some(
            rate(&times)
                .map_err(|got| container(context.file, "times in column time_s that rise evenly".to_owned(), got))?,
        ),
        root_position: table.rows().map(|row| Vec3::new(row[*x], row[*y], row[*z])).collect(),
        root_orientation: Order::Wxyz.rotations(&turns, context.file)?,
        joints: table.rows().flat_map(|row| joints.iter().map(|column| row[*column])).collect(),
        joint_names: joints.iter().map(|column| header[*column].clone()).collect(),
        said: format!("{} columns with names, quaternion w x y z", header.len()),
        ..RobotMotion::default()
    })
}

/// Returns the rate of times with equal distances (frames per second), or the first row with another distance.
fn rate(times: &[f64]) -> Result<f64, String> {
    let mut steps: Vec<f64> = times.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let uneven = |step: f64| {
        let row = times.windows(2).position(|pair| (pair[1] - pair[0] - step).abs() >= 1e-3 * step.abs());
        row.map(|row| format!("{} s after {} s in row {}", times[row + 1], times[row], row + 2))
    };
    let mean = (times.last().unwrap_or(&0.0) - times.first().unwrap_or(&0.0)) / steps.len().max(1) as f64;
    steps.sort_by(f64::total_cmp);
    match (steps.get(steps.len() / 2), uneven(mean)) {
        (None, _) => Err("a single row".to_owned()),
        (Some(step), None) if *step <= 0.0 => Err("times that do not rise".to_owned()),
        (Some(step), Some(got)) => Err(uneven(*step).unwrap_or(got)),
        (Some(_), None) => {
            let rate = 1.0 / mean;
            // Times are rounded, so a rate within a millionth of a whole number is that.
            Ok(if (rate - rate.round()).abs() < 1e-6 * rate { rate.round() } else { rate })
        }
    }
}

fn write(clip: &MotionClip, _: &Context<'_>) -> Result<Vec<u8>, MotionError> {
    let header: Vec<String> = LEAD.into_iter().map(str::to_owned).chain(clip.joint_names.iter().cloned()).collect();
    let rows = (0..clip.len()).map(|frame| {
        let root = clip.root_position[frame].iter().copied().chain(Order::Wxyz.numbers(&clip.root_orientation[frame]));
        once(frame as f64 / clip.fps).chain(root).chain(clip.joints_at(frame).iter().copied()).collect()
    });
    table::write(Some(&header), rows).map_err(|why| unfit(clip, why))
}
