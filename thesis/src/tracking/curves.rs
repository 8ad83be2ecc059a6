//! Learning curves of a study: mean and range over seeds against samples.

use std::path::Path;

use lifelike_report::run::{MetricsRow, RunFolder, read_metrics};
use lifelike_report::{Chart, Series};
use serde::Serialize;

use super::study::{Job, Study};
use lifelike::CliError;

/// Points of a curve: each is the mean over its share of the samples.
const POINTS: usize = 60;
/// Metrics of a run, their names here, and the factor to their unit.
const METRICS: [(&str, &str, f64); 3] = [
    ("Train/survival", "survival in training [%]", 100.0),
    ("Train/mean_step_reward", "reward per step", 1.0),
    ("Train/joint_error_deg", "joint error in training [deg]", 1.0),
];

/// A metric of a variant, over its seeds.
#[derive(Debug, Clone, Serialize)]
pub struct SeedCurve {
    /// The variant.
    pub variant: String,
    /// Stage of its training, where the study has several.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stage: Option<String>,
    /// The metric, with its unit.
    pub metric: &'static str,
    /// Seeds that have a run.
    pub seeds: Vec<u64>,
    /// Samples (environment steps), mean, least and largest value over the seeds.
    #[serde(flatten)]
    pub series: Series,
}

/// Samples and values of a metric in one run.
type Points = Vec<[f64; 2]>;

/// Returns the curves of all variants that have runs below this folder.
pub fn of(study: &Study, jobs: &[Job], folder: &Path) -> Result<Vec<SeedCurve>, CliError> {
    let mut curves = Vec::new();
    for stage in study.stages() {
        let stage = stage.map(|stage| stage.name.clone());
        for variant in &study.variant {
            let own = jobs.iter().filter(|job| job.variant == variant.name && job.stage == stage);
            let mut runs: Vec<(u64, Vec<MetricsRow>)> = Vec::new();
            for job in own {
                let path = folder.join(&job.folder);
                if path.join("plan.toml").exists() {
                    runs.push((job.seed, read_metrics(&RunFolder::open(&path)?.metrics_path())?));
                }
            }
            for (name, metric, factor) in METRICS {
                let points: Vec<Points> = runs.iter().map(|(_, rows)| points(rows, name, factor)).collect();
                if points.iter().all(Vec::is_empty) {
                    continue;
                }
                let series = Series { name: variant.name.clone(), ..band(&points) };
                let seeds = runs.iter().map(|(seed, _)| *seed).collect();
                curves.push(SeedCurve { variant: variant.name.clone(), stage: stage.clone(), metric, seeds, series });
            }
        }
    }
    Ok(curves)
}

/// Returns a chart for each stage and metric, the variants in one frame.
pub fn charts(study: &Study, curves: &[SeedCurve]) -> Vec<Chart> {
    let mut charts = Vec::new();
    for stage in study.stages() {
        let stage = stage.map(|stage| &stage.name);
        for (_, metric, _) in METRICS {
            let own = curves.iter().filter(|curve| curve.metric == metric && curve.stage.as_ref() == stage);
            let series: Vec<Series> = own.map(named).collect();
            if !series.is_empty() {
                let title = stage.map_or_else(|| metric.into(), |stage| format!("{metric}, {stage}"));
                charts.push(Chart {
                    title,
                    x: "samples; line: mean over seeds; band: least to largest".into(),
                    series,
                });
            }
        }
    }
    charts
}

fn named(curve: &SeedCurve) -> Series {
    let seeds = if curve.seeds.len() == 1 { "seed" } else { "seeds" };
    Series { name: format!("{} ({} {seeds})", curve.variant, curve.seeds.len()), ..curve.series.clone() }
}

fn points(rows: &[MetricsRow], name: &str, factor: f64) -> Points {
    let value = |row: &MetricsRow, name: &str| row.values.iter().find(|(own, _)| own == name).map(|(_, value)| *value);
    let pair = |row: &MetricsRow| Some([value(row, "Train/steps")?, factor * value(row, name)?]);
    rows.iter().filter_map(pair).filter(|p| p[1].is_finite()).collect()
}

/// Returns mean and range over runs on common shares of the samples; a share counts the runs that have a point in it.
fn band(runs: &[Points]) -> Series {
    let last = runs.iter().flatten().map(|p| p[0]).fold(0.0, f64::max);
    let mut series = Series::default();
    for share in 0..POINTS {
        let (from, to) = (last * share as f64 / POINTS as f64, last * (share + 1) as f64 / POINTS as f64);
        let mean = |run: &Points| {
            let own: Vec<f64> = run.iter().filter(|p| p[0] > from && p[0] <= to).map(|p| p[1]).collect();
            (!own.is_empty()).then(|| own.iter().sum::<f64>() / own.len() as f64)
        };
        let means: Vec<f64> = runs.iter().filter_map(mean).collect();
        if !means.is_empty() {
            series.x.push(0.5 * (from + to));
            series.mean.push(means.iter().sum::<f64>() / means.len() as f64);
            series.low.push(means.iter().copied().fold(f64::INFINITY, f64::min));
            series.high.push(means.iter().copied().fold(f64::NEG_INFINITY, f64::max));
        }
    }
    series
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bands_run_from_the_worst_to_the_best_seed_over_the_same_samples() {
        // 120 points each, two to a share; the second run stops half way and is 2 higher.
        let run = |n: u32, above: f64| (1..=n).map(|i| [f64::from(i), f64::from(i) + above]).collect::<Points>();
        let series = band(&[run(120, 0.0), run(60, 2.0)]);
        assert_eq!(series.x.len(), POINTS);
        // Samples 1 and 2: means 1.5 and 3.5.
        assert_eq!((series.x[0], series.low[0], series.mean[0], series.high[0]), (1.0, 1.5, 2.5, 3.5));
        assert_eq!((series.low[59], series.mean[59], series.high[59]), (119.5, 119.5, 119.5));
    }

    #[test]
    fn a_metric_that_is_not_there_or_no_number_is_left_out() {
        let row = |values: &[(&str, f64)]| MetricsRow {
            iteration: 1,
            values: values.iter().map(|(n, v)| ((*n).to_string(), *v)).collect(),
        };
        let rows = [row(&[("Train/steps", 8.0), ("a", 0.5)]), row(&[("Train/steps", 16.0), ("a", f64::NAN)])];
        assert_eq!(points(&rows, "a", 100.0), [[8.0, 50.0]]);
        assert!(points(&rows, "b", 1.0).is_empty());
    }
}
