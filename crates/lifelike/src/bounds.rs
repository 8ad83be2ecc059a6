//! Bounds of options: numbers of things are checked while arguments are parsed, rates and ports when a command begins.

use std::ops::RangeInclusive;

use crate::error::CliError;

/// Most threads: more than any machine has cores for.
const THREADS: usize = 1024;
/// Most environments of one simulation.
const ENVIRONMENTS: usize = 1 << 20;
/// Most motions to choose from.
const CANDIDATES: usize = 4096;
/// Rates of motion that are read and written (frames per second).
const RATES: RangeInclusive<f64> = 0.01..=10_000.0;
/// Rates of a film (pictures per second).
const PICTURES: RangeInclusive<f64> = 1.0..=120.0;
/// Rates of a simulation's rows (Hz).
const ROWS: RangeInclusive<f64> = 1.0..=10_000.0;

/// Parses a number of threads; 0 stands for one per processor.
///
/// # Errors
/// No number, or too many.
pub fn threads(text: &str) -> Result<usize, String> {
    number(text, 0, THREADS)
}

/// Parses a number of environments.
///
/// # Errors
/// No number, none, or too many.
pub fn environments(text: &str) -> Result<usize, String> {
    number(text, 1, ENVIRONMENTS)
}

/// Parses a number of motions to choose from.
///
/// # Errors
/// No number, none, or too many.
pub fn candidates(text: &str) -> Result<usize, String> {
    number(text, 1, CANDIDATES)
}

/// Checks an option's frames per second.
///
/// # Errors
/// [`CliError::Input`] for a rate that no motion has.
pub fn frame_rate(option: &str, rate: Option<f64>) -> Result<(), CliError> {
    rate.map_or(Ok(()), |rate| within(option, rate, &RATES, "frames per second"))
}

/// Checks an option's pictures per second, which are whole.
///
/// # Errors
/// [`CliError::Input`] for a rate that no film has.
pub fn picture_rate(option: &str, rate: Option<f64>) -> Result<(), CliError> {
    match rate.filter(|rate| !PICTURES.contains(rate) || rate.fract() != 0.0) {
        Some(rate) => Err(CliError::Input(format!("{option}: expected a whole number from 1 to 120, got {rate}"))),
        None => Ok(()),
    }
}

/// Checks an option's rows per second.
///
/// # Errors
/// [`CliError::Input`] for a rate that no simulation has.
pub fn row_rate(option: &str, rate: f64) -> Result<(), CliError> {
    within(option, rate, &ROWS, "Hz")
}

fn within(option: &str, rate: f64, rates: &RangeInclusive<f64>, unit: &str) -> Result<(), CliError> {
    if rates.contains(&rate) {
        return Ok(());
    }
    let (least, most) = (rates.start(), rates.end());
    Err(CliError::Input(format!("{option}: expected {least} to {most} {unit}, got {rate}")))
}

/// Returns a port of this machine.
///
/// # Errors
/// [`CliError::Input`] for a text that is none.
pub fn port(option: &str, text: &str) -> Result<u16, CliError> {
    let wrong = |_| CliError::Input(format!("{option}: expected a port from 0 (any free one) to 65535, got '{text}'"));
    text.parse().map_err(wrong)
}

fn number(text: &str, least: usize, most: usize) -> Result<usize, String> {
    let found = text.parse().ok().filter(|number| (least..=most).contains(number));
    found.ok_or_else(|| format!("expected a number from {least} to {most}"))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn rates_and_ports_that_cannot_be_are_bad_input() {
        for rate in [0.0, -1.0, f64::NAN, f64::INFINITY, 99_999_999.0] {
            let error = frame_rate("--fps", Some(rate)).unwrap_err();
            let expected = format!("--fps: expected 0.01 to 10000 frames per second, got {rate}");
            assert_eq!((error.code(), error.to_string()), (3, expected));
            assert!(row_rate("--rate", rate).is_err_and(|error| error.code() == 3), "{rate}");
        }
        assert!(frame_rate("--fps", None).is_ok() && frame_rate("--fps", Some(1.0)).is_ok());
        for rate in [0.0, -1.0, 29.97, 121.0, f64::NAN] {
            assert!(picture_rate("--fps", Some(rate)).is_err_and(|error| error.code() == 3), "{rate}");
        }
        assert!(picture_rate("--fps", Some(120.0)).is_ok());
        for text in ["-1", "nan", "99999999", ""] {
            assert!(port("--port", text).is_err_and(|error| error.code() == 3), "{text}");
        }
        assert_eq!(port("--port", "8080").ok(), Some(8080));
    }

    #[test]
    fn numbers_beyond_any_machine_are_refused() {
        assert_eq!((threads("0"), threads("1024"), environments("1")), (Ok(0), Ok(1024), Ok(1)));
        for text in ["10000000", "-1", "18446744073709551615", "18446744073709551616", "two"] {
            assert!(threads(text).is_err() && environments(text).is_err(), "{text}");
        }
        assert!(environments("0").is_err() && candidates("0").is_err() && candidates("4096") == Ok(4096));
    }
}
