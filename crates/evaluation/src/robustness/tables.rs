//! Curves as tables.

use super::curve::{Robustness, RobustnessCurve};
use lifelike_report::{Cell, Column, Table, Tone};

impl Robustness {
    /// One table per disturbance.
    pub fn tables(&self) -> Vec<Table> {
        self.curves.iter().map(RobustnessCurve::table).collect()
    }
}

impl RobustnessCurve {
    /// Survival and errors by size.
    pub fn table(&self) -> Table {
        let columns = vec![
            Column::number(self.name, self.unit),
            Column::number("episodes", ""),
            Column::number("survival", "%"),
            Column::number("lived", "%"),
            Column::number("joints", "deg"),
            Column::number("effectors", "m"),
            Column::number("jerk", "rad/s³"),
        ];
        let mut table = Table::new(self.name, columns);
        table.caption = format!("{}. lived: share of the time before a fall; errors are means over it.", self.what);
        table.rows = self
            .points
            .iter()
            .map(|point| {
                let s = &point.score;
                vec![
                    Cell::number(point.size, decimals(point.size)),
                    Cell::number(s.episodes as f64, 0),
                    Cell::number(100.0 * s.survival, 0).tone((s.survival < 0.5).then_some(Tone::Bad)),
                    Cell::number(100.0 * s.covered, 0),
                    Cell::number(s.joint_error_deg, 2),
                    Cell::number(s.effector_error_m, 3),
                    Cell::number(s.jerk, 0),
                ]
            })
            .collect();
        table
    }
}

/// As many digits as a size was given with: three at most.
fn decimals(size: f64) -> usize {
    (0..3).find(|d| (size * 10.0_f64.powi(*d as i32)).fract().abs() < 1e-9).unwrap_or(3)
}
