//! Golden vectors: recorded inputs and outputs that a controller's file is tried on whenever it is read.

use lifelike_checkpoint::Checkpoint;

use super::policy::{FrozenPolicy, PolicyWorkspace};
use super::prior::PriorEncoder;
use crate::network::Workspace;
use crate::{FromInput, RobotError};

/// Rows in a file.
pub(super) const ROWS: usize = 64;
/// Greatest difference between the file and a replay, for outputs up to 1 and relative beyond: processors without fused
/// multiplication differ by some 1e-6.
pub(super) const TOLERANCE: f32 = 1e-5;

/// Adds [`ROWS`] observations with their outputs, and windows with their codes where there is an encoder. They are spread
/// over what training has seen: two standard deviations about the means.
pub(super) fn record(
    policy: &FrozenPolicy,
    prior: Option<&PriorEncoder>,
    file: &mut Checkpoint,
) -> Result<(), RobotError> {
    let normalizer = policy.normalizer();
    let size = normalizer.size();
    let observations: Vec<f32> = (0..ROWS * size)
        .map(|i| normalizer.mean()[i % size] + spread(i) / normalizer.inverse_deviation()[i % size])
        .collect();
    let outputs = outputs(policy, &observations);
    file.put_f32("golden.observations", &[ROWS, size], observations)?;
    file.put_f32("golden.outputs", &[ROWS, outputs.len() / ROWS], outputs)?;
    let Some(prior) = prior else { return Ok(()) };
    let (mean, deviation) = prior.statistics();
    let (features, samples) = (mean.len(), prior.header().window().len());
    let windows: Vec<f64> = (0..ROWS * samples * features)
        .map(|i| mean[i % features] + f64::from(spread(i)) * deviation[i % features])
        .collect();
    let codes = codes(prior, &windows);
    file.put_f64("golden.windows", &[ROWS, samples, features], windows)?;
    Ok(file.put_f32("golden.codes", &[ROWS, codes.len() / ROWS], codes)?)
}

/// Checks that the networks give the recorded numbers.
///
/// # Errors
/// Vectors are missing, or a number is off by more than [`TOLERANCE`].
pub(super) fn replay(
    policy: &FrozenPolicy,
    prior: Option<&PriorEncoder>,
    file: &Checkpoint,
    path: &str,
) -> Result<(), RobotError> {
    let rows = file.entry("golden.observations")?.shape().first().copied().unwrap_or(0);
    if rows < ROWS {
        return Err(RobotError::mismatch(format!("{path}: golden vectors"), format!("at least {ROWS}"), rows));
    }
    let observations = file.f32s("golden.observations", &[rows, policy.normalizer().size()])?;
    let got = outputs(policy, &observations);
    let expected = file.f32s("golden.outputs", &[rows, got.len() / rows])?;
    compare("output", &expected, &got, rows, path)?;
    let Some(prior) = prior else { return Ok(()) };
    let window = prior.header().window().len();
    let windows = file.f64s("golden.windows", &[ROWS, window, prior.header().layout.size()])?;
    let got = codes(prior, &windows);
    compare("code", &file.f32s("golden.codes", &[ROWS, prior.header().latent])?, &got, ROWS, path)
}

fn outputs(policy: &FrozenPolicy, observations: &[f32]) -> Vec<f32> {
    let rows = observations.len() / policy.normalizer().size().max(1);
    let mut out = vec![0.0; rows * policy.joints()];
    policy.outputs(&mut observations.to_vec(), &mut PolicyWorkspace::batched(), &mut out);
    out
}

fn codes(prior: &PriorEncoder, windows: &[f64]) -> Vec<f32> {
    let mut out = vec![0.0; ROWS * prior.header().latent];
    prior.encode_windows(windows, &mut Workspace::batched(), &mut out);
    out
}

fn compare(what: &'static str, expected: &[f32], got: &[f32], rows: usize, path: &str) -> Result<(), RobotError> {
    let width = (expected.len() / rows).max(1);
    let off = expected.iter().zip(got).position(|(e, g)| {
        let difference = (e - g).abs();
        // NaN is no reproduction either.
        difference.is_nan() || difference > TOLERANCE * e.abs().max(1.0)
    });
    match off {
        None => Ok(()),
        Some(i) => Err(RobotError::Golden {
            path: path.into(),
            what,
            row: i / width,
            expected: expected[i],
            got: got[i],
            tolerance: TOLERANCE,
        }),
    }
}

/// Numbers within ±2, spread evenly and without a pattern (the golden ratio's multiples).
fn spread(i: usize) -> f32 {
    (4.0 * (i as f64 * 0.618_033_988_749_894_9).fract() - 2.0) as f32
}
