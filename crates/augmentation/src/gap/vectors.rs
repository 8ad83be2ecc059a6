//! Columns that belong together: places as distances, orientations as angles.

use lifelike_character::rotation::from_6d;

/// Name of a body's position, all three coordinates together.
pub const PLACE: &str = "position_xyz";
/// Name of a body's orientation.
pub const ORIENTATION: &str = "orientation";

/// Returns distances between simulated and measured places (m), and angles between orientations (rad; thesis eq. 2.4), row by row,
/// where measured columns are coordinates of either.
pub fn distances(names: &[String], simulated: &[f32], measured: &[f32]) -> Vec<(&'static str, Vec<f64>)> {
    let index = |name: String| names.iter().position(|own| *own == name);
    let rows = || simulated.chunks_exact(names.len()).zip(measured.chunks_exact(names.len()));
    let mut out = Vec::new();
    let place: Vec<usize> = ["x", "y", "z"].iter().filter_map(|axis| index(format!("position_{axis}"))).collect();
    if place.len() == 3 {
        let distance =
            |(s, m): (&[f32], &[f32])| place.iter().map(|i| f64::from(s[*i] - m[*i]).powi(2)).sum::<f64>().sqrt();
        out.push((PLACE, rows().map(distance).collect()));
    }
    let axes = ["a_x", "a_y", "a_z", "b_x", "b_y", "b_z"];
    let turn: Vec<usize> = axes.iter().filter_map(|axis| index(format!("orientation_{axis}"))).collect();
    if turn.len() == 6 {
        let angle = |(s, m): (&[f32], &[f32])| {
            let rotation = |row: &[f32]| from_6d(std::array::from_fn(|i| f64::from(row[turn[i]])));
            match (rotation(s), rotation(m)) {
                (Some(s), Some(m)) => s.angle_to(&m),
                _ => std::f64::consts::PI,
            }
        };
        out.push((ORIENTATION, rows().map(angle).collect()));
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_are_euclids_and_angles_those_of_the_matrices() {
        let names: Vec<String> = ["position_x", "position_y", "position_z"]
            .into_iter()
            .chain(["orientation_a_x", "orientation_a_y", "orientation_a_z"])
            .chain(["orientation_b_x", "orientation_b_y", "orientation_b_z"])
            .map(String::from)
            .collect();
        let simulated = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
        let (sin, cos) = 0.3_f32.sin_cos();
        // Turned about the vertical, one column too long: Gram and Schmidt see no difference.
        let measured = [1.0, 2.0, 2.0, 2.0 * cos, 2.0 * sin, 0.0, -sin, cos, 0.0];
        let out = distances(&names, &simulated, &measured);
        assert_eq!(out[0], (PLACE, vec![3.0]));
        assert!((out[1].1[0] - 0.3).abs() < 1e-6, "{out:?}");
        assert!(distances(&names[..2], &[0.0; 2], &[0.0; 2]).is_empty());
    }
}
