//! Predictors of a motion's return: the critic, a regression on kinematics, the findings of `motion check`.

use std::ops::Range;
use std::path::Path;

use lifelike_generation::critic::calibration::Ridge;
use lifelike_generation::critic::{Critic, RewardSurrogate};
use lifelike_generation::representation::{FeatureMatrix, RepresentationSpec};
use lifelike_motion::MotionClip;
use lifelike_motion::feasibility::{Feasibility, check};
use lifelike_robot::Robot;
use rayon::prelude::*;

use super::episodes::measured;
use lifelike::CliError;
use lifelike::commands::rollouts::rows_of;
use lifelike::commands::train::critic::CriticTrainingPlan;

/// Penalty of the regression.
const PENALTY: f64 = 1e-3;

/// A number for every row of every clip, higher for what is promised to go well.
pub struct Predictor {
    /// Name in tables.
    pub name: &'static str,
    values: Vec<Vec<f64>>,
    /// An episode is as good as its worst row, not its mean.
    lowest: bool,
}

impl Predictor {
    /// Returns the prediction at a row.
    pub fn at(&self, clip: usize, row: usize) -> f64 {
        self.values[clip][row]
    }

    /// Returns the prediction for an episode over rows.
    pub fn over(&self, clip: usize, rows: Range<usize>) -> f64 {
        let values = &self.values[clip][rows];
        if self.lowest {
            return values.iter().copied().fold(f64::INFINITY, f64::min);
        }
        values.iter().sum::<f64>() / values.len() as f64
    }
}

/// Returns the predictors, the critic first.
pub fn predictors(
    critic: Critic,
    plan: &CriticTrainingPlan,
    run: &Path,
    clips: &[MotionClip],
    robot: &Robot,
) -> Result<Vec<Predictor>, CliError> {
    let (spec, rows) = rows_of(clips, robot)?;
    critic.check(&spec)?;
    let wide = |values: Vec<f32>| values.into_iter().map(f64::from).collect();
    let values =
        rows.iter().map(|motion| Ok(wide(critic.values(motion)?))).collect::<Result<Vec<Vec<f64>>, CliError>>()?;
    let ridge = regression(plan, run, critic.header().radius, robot)?;
    let radius = critic.header().radius;
    let of_ridge = |motion: &FeatureMatrix| {
        (0..motion.n).map(|row| ridge.predict(&kinematics(motion, &spec, row, radius))).collect()
    };
    let by_ridge: Vec<Vec<f64>> = rows.iter().map(of_ridge).collect();
    let speeds = robot.speeds();
    let findings = clips
        .par_iter()
        .zip(&rows)
        .map(|(clip, rows)| Ok(of_findings(&check(clip, &robot.character, &robot.anatomy, &speeds)?, rows.n)));
    Ok(vec![
        Predictor { name: "critic, mean", values: values.clone(), lowest: false },
        Predictor { name: "critic, lowest", values, lowest: true },
        Predictor { name: "ridge on kinematics, mean", values: by_ridge.clone(), lowest: false },
        Predictor { name: "ridge on kinematics, lowest", values: by_ridge, lowest: true },
        Predictor { name: "motion check", values: findings.collect::<Result<_, CliError>>()?, lowest: false },
    ])
}

/// Fits the regression to the windows' returns of the critic's own records.
fn regression(plan: &CriticTrainingPlan, run: &Path, radius: usize, robot: &Robot) -> Result<Ridge, CliError> {
    let records = CriticTrainingPlan::records(run)?;
    let (spec, rows) = rows_of(&plan.motions(robot)?.0, robot)?;
    if rows.len() != records.names.len() {
        let got = format!("{} clips, {} in its records", rows.len(), records.names.len());
        return Err(CliError::Input(format!(
            "{}: expected the clips that the critic learned from, got {got}",
            run.display()
        )));
    }
    let windows = measured(&records, &rows, plan.critic.gamma);
    if windows.is_empty() {
        return Err(CliError::Input(format!("{}: expected records of whole returns, got none", run.display())));
    }
    let features: Vec<Vec<f64>> =
        windows.par_iter().map(|w| kinematics(&rows[w.clip], &spec, w.row.min(rows[w.clip].n - 1), radius)).collect();
    let returns: Vec<f64> = windows.iter().map(|w| w.value).collect();
    Ok(Ridge::fit(&features, &returns, PENALTY))
}

/// Returns plain numbers of a window: means of root height (m), its distance from upright (1 − cos), and speed on the
/// ground (m/s) and of turning (rad/s). Then come mean and greatest joint speed (rad/s) and acceleration (rad/s²).
fn kinematics(motion: &FeatureMatrix, spec: &RepresentationSpec, centre: usize, radius: usize) -> Vec<f64> {
    let rows = centre.saturating_sub(radius)..(centre + radius + 1).min(motion.n);
    let mut sums = [0.0_f64; 8];
    for i in rows.clone() {
        let (row, next) = (motion.row(i), motion.row((i + 1).min(motion.n - 1)));
        let number = |at: usize| f64::from(row[at]);
        let (speeds, after) = (&row[spec.velocities()], &next[spec.velocities()]);
        let speed = || speeds.iter().map(|v| f64::from(v.abs()));
        let acceleration = || speeds.iter().zip(after).map(|(a, b)| f64::from((b - a).abs()) * spec.fps);
        let joints = spec.joints().max(1) as f64;
        sums[0] += number(RepresentationSpec::HEIGHT);
        sums[1] += 1.0 - number(RepresentationSpec::UP.end - 1);
        sums[2] += number(1).hypot(number(2));
        sums[3] += number(RepresentationSpec::YAW_RATE).abs();
        sums[4] += speed().sum::<f64>() / joints;
        sums[5] += speed().fold(0.0, f64::max);
        sums[6] += acceleration().sum::<f64>() / joints;
        sums[7] += acceleration().fold(0.0, f64::max);
    }
    sums.iter().map(|sum| sum / rows.len() as f64).collect()
}

/// Returns −1 at rows that something rules out, so that a mean is the share of such rows.
fn of_findings(found: &Feasibility, rows: usize) -> Vec<f64> {
    let ruled = |row: usize| {
        let second = row as f64 / RepresentationSpec::FPS;
        found.around(second, 0.5 / RepresentationSpec::FPS).any(|finding| finding.rules_out())
    };
    (0..rows).map(|row| if ruled(row) { -1.0 } else { 0.0 }).collect()
}
