//! Curves of a run: a number per iteration.

use crate::run::MetricsRow;

/// The most points that a curve is drawn with; more are averaged in groups.
const MOST_POINTS: usize = 1500;

/// One metric over the iterations. A name like `reward/joints` puts it into the group `reward`.
#[derive(Debug, Clone, PartialEq, Default, serde::Serialize)]
pub struct Curve {
    /// Name. Curves of one name share a panel and its axis.
    pub name: String,
    /// Name among the curves of one panel, such as `measured`; empty where it is alone.
    pub series: String,
    /// Iterations, or whatever stands below the curve; ascending.
    pub x: Vec<f64>,
    /// Values; what is not finite leaves a gap.
    pub y: Vec<f64>,
}

impl Curve {
    /// Returns the curve with at most `most` points: means of neighbouring values, those that are not finite left out.
    pub(super) fn thinned(&self, most: usize) -> Self {
        let group = self.x.len().div_ceil(most.max(1)).max(1);
        let mean = |values: &[f64]| {
            let good: Vec<f64> = values.iter().copied().filter(|v| v.is_finite()).collect();
            if good.is_empty() { f64::NAN } else { good.iter().sum::<f64>() / good.len() as f64 }
        };
        Self {
            name: self.name.clone(),
            series: self.series.clone(),
            x: self.x.chunks(group).map(mean).collect(),
            y: self.y.chunks(group).map(mean).collect(),
        }
    }
}

/// Returns the curves in a run's metrics, one per name. Names without a group come first, then group after group, in the order
/// in which they first appear.
pub fn curves_from(rows: &[MetricsRow]) -> Vec<Curve> {
    let mut curves: Vec<Curve> = Vec::new();
    for row in rows {
        for (name, value) in &row.values {
            let at = curves.iter().position(|c| c.name == *name).unwrap_or_else(|| {
                curves.push(Curve { name: name.clone(), ..Curve::default() });
                curves.len() - 1
            });
            curves[at].x.push(row.iteration as f64);
            curves[at].y.push(*value);
        }
    }
    curves.sort_by_key(|c| c.name.contains('/'));
    curves.iter().map(|c| c.thinned(MOST_POINTS)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn metrics_become_curves_and_late_ones_start_late() {
        let row = |iteration, values: &[(&str, f64)]| MetricsRow {
            iteration,
            values: values.iter().map(|(n, v)| ((*n).to_string(), *v)).collect(),
        };
        let curves =
            curves_from(&[row(0, &[("reward/a", 1.0), ("loss", 5.0)]), row(1, &[("loss", 4.0), ("late", 3.0)])]);
        let names: Vec<&str> = curves.iter().map(|c| c.name.as_str()).collect();
        assert_eq!(names, ["loss", "late", "reward/a"]);
        assert_eq!((curves[0].x.clone(), curves[0].y.clone()), (vec![0.0, 1.0], vec![5.0, 4.0]));
        assert_eq!(curves[1].x, [1.0]);
    }

    #[test]
    fn thinning_averages_what_is_finite() {
        let curve = Curve {
            name: "a".into(),
            x: vec![0.0, 1.0, 2.0, 3.0, 4.0],
            y: vec![1.0, 3.0, f64::NAN, 5.0, f64::NAN],
            ..Curve::default()
        };
        let thin = curve.thinned(3);
        assert_eq!(thin.x, [0.5, 2.5, 4.0]);
        assert_eq!(thin.y[..2], [2.0, 5.0]);
        assert!(thin.y[2].is_nan());
    }
}
