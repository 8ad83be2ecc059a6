//! The tables of thesis chapters 4.3.3 and 5.3.3.

use lifelike_report::{Cell, Column, Table};

use super::ThesisErrors;

/// Returns a row for each name: joints, end effectors and terminations (Table 4.3), and root and limbs (Table 5.3).
pub fn thesis_tables<'a>(rows: impl IntoIterator<Item = (&'a str, &'a ThesisErrors)> + Clone) -> [Table; 2] {
    let numbers = |columns: &[(&str, &str)]| {
        let columns = columns.iter().map(|(name, unit)| Column::number(name, unit));
        [Column::text("motion")].into_iter().chain(columns).collect::<Vec<_>>()
    };
    let head =
        numbers(&[("joints", "deg"), ("95%", "deg"), ("effectors", "m"), ("survival", "%"), ("terminations", "1/min")]);
    let mut errors = Table::new("Thesis protocol: joints and end effectors (Table 4.3)", head);
    errors.caption = "Means over all frames of fixed-length episodes that begin at random frames. An episode goes on with another motion \
                      where its own ends, and from a reference state where an end effector stays beyond t^p for f. 95%: interval \
                      over episodes. survival: episodes without a fall."
        .into();
    let head = numbers(&[
        ("lin.", "m/s"),
        ("ang.", "rad/s"),
        ("root", "deg"),
        ("tilt", "deg"),
        ("upper", "deg"),
        ("lower", "deg"),
    ]);
    let mut root = Table::new("Thesis protocol: root and limbs (Table 5.3)", head);
    root.caption = "Over the same frames. lin., ang.: velocities; root: rotation, heading included; tilt: without heading, as in eq. 4.6; upper, \
                    lower: joints.".into();
    for (name, e) in rows {
        let [low, high] = e.joint_error_interval_deg;
        let known = low.is_finite() && high.is_finite();
        errors.rows.push(vec![
            Cell::text(name),
            Cell::number(e.joint_error_deg, 2),
            Cell::text(if known { format!("{low:.2} to {high:.2}") } else { "–".into() }),
            Cell::number(e.effector_error_m, 3),
            Cell::number(100.0 * e.survival, 1),
            Cell::number(e.terminations_per_minute, 2),
        ]);
        root.rows.push(vec![
            Cell::text(name),
            Cell::number(e.root_velocity_error, 3),
            Cell::number(e.root_angular_velocity_error, 3),
            Cell::number(e.root_rotation_error_deg, 2),
            Cell::number(e.root_tilt_error_deg, 2),
            Cell::number(e.upper_joint_error_deg, 2),
            Cell::number(e.lower_joint_error_deg, 2),
        ]);
    }
    [errors, root]
}
