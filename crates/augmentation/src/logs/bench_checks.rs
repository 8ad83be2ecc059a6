//! Plausibility of a bench's log: numbers, units, signs.

use std::f64::consts::TAU;

use super::bam::BenchLog;

/// Place, expected, got.
pub(super) type Fault = (String, String, String);

/// No bench turns further (rad): what does is in degrees or ticks.
const FARTHEST: f64 = 4.0 * TAU;
/// No bench is slower (s): what is has other units of time.
const LONGEST_STEP: f64 = 0.5;
/// No bench has more, in SI: what does is in g, mm or mV.
const MOST: [(&str, f64, &str); 4] = [
    ("mass", 20.0, "kg (g?)"),
    ("arm_mass", 20.0, "kg (g?)"),
    ("length", 2.0, "m (cm or mm?)"),
    ("vin", 100.0, "V (mV?)"),
];
/// Largest voltage as a multiple of the supply's.
const OVERVOLTAGE: f64 = 1.5;
/// Least deviation of a position that moves (rad), and of a speed that was measured while it does (rad/s).
const MOVES: f64 = 0.05;
const MEASURED: f64 = 1e-3;
/// Slopes of a measured velocity over the change of the position that are right, whatever filters it.
const RIGHT_SLOPE: std::ops::Range<f64> = 0.4..2.5;
/// Correlation from which two signals say the same.
pub(super) const SAME: f64 = 0.7;
/// Correlation below which two signals contradict each other.
const OPPOSITE: f64 = -0.5;

/// Checks that numbers are finite and within what a bench can do.
pub(super) fn numbers(log: &BenchLog) -> Result<(), Fault> {
    let positive =
        [("length", log.arm), ("kp", log.gain), ("vin", log.supply), ("mass + arm_mass", log.mass + log.arm_mass)];
    for (key, value) in positive {
        if !(value.is_finite() && value > 0.0) {
            return Err((key.into(), "a number above 0".into(), value.to_string()));
        }
    }
    for (key, value) in [("mass", log.mass), ("arm_mass", log.arm_mass)] {
        if value.is_nan() || value < 0.0 {
            return Err((key.into(), "a number of at least 0".into(), value.to_string()));
        }
    }
    for (key, most, unit) in MOST {
        let value = match key {
            "mass" => log.mass,
            "arm_mass" => log.arm_mass,
            "length" => log.arm,
            _ => log.supply,
        };
        if value > most {
            return Err((key.into(), format!("at most {most} {unit}"), value.to_string()));
        }
    }
    let columns = [
        ("timestamp", Some(&log.time)),
        ("goal_position", Some(&log.goal)),
        ("position", Some(&log.position)),
        ("speed", Some(&log.velocity)),
        ("load", log.voltage.as_ref()),
    ];
    for (key, column) in columns {
        let wrong = column.into_iter().flatten().enumerate().find(|(_, value)| !value.is_finite());
        if let Some((i, value)) = wrong {
            return Err((format!("entry {i}, {key}"), "a finite number".into(), value.to_string()));
        }
    }
    if log.voltage.as_ref().is_some_and(|voltage| voltage.iter().all(|value| *value == 0.0)) {
        let got = "0 V in all entries: duty times a supply of 0";
        return Err(("input_volts".into(), "volts above 0".into(), got.into()));
    }
    let most = OVERVOLTAGE * log.supply;
    let beyond = log.voltage.iter().flatten().enumerate().find(|(_, value)| value.abs() > most);
    if let Some((i, value)) = beyond {
        let expected = format!("duty times supply of at most {most} V, {OVERVOLTAGE} times vin");
        return Err((
            format!("entry {i}, load"),
            expected,
            format!("{value} V (duty in percent, or volts in mV or 0.1 V?)"),
        ));
    }
    for (key, column) in [("goal_position", &log.goal), ("position", &log.position)] {
        if let Some((i, value)) = column.iter().enumerate().find(|(_, value)| value.abs() > FARTHEST) {
            let expected = format!("radians, at most two turns ({FARTHEST:.1})");
            return Err((format!("entry {i}, {key}"), expected, format!("{value} (degrees, or raw ticks?)")));
        }
    }
    Ok(())
}

/// Checks that columns agree with each other: times with speeds, speeds with positions, duty and position with the goal.
pub(super) fn units(log: &BenchLog) -> Result<(), Fault> {
    if log.clock.step > LONGEST_STEP {
        let got = format!("{} (milliseconds? divide timestamps by 1000)", log.clock.step);
        return Err(("entry 1, timestamp".into(), format!("seconds, steps of at most {LONGEST_STEP}"), got));
    }
    let rates: Vec<f64> = (1..log.time.len().saturating_sub(1))
        .map(|i| (log.position[i + 1] - log.position[i - 1]) / (log.time[i + 1] - log.time[i - 1]))
        .collect();
    let speeds = log.velocity.get(1..log.velocity.len().saturating_sub(1)).unwrap_or_default();
    if deviation(&log.position) < MEASURED && deviation(&log.velocity) > MOVES {
        let got = "one position throughout while the speed changes (not measured?)";
        return Err(("position".into(), "rad: a position that moves with its speed".into(), got.into()));
    }
    if deviation(&log.position) > MOVES && deviation(&log.velocity) < MEASURED {
        let got = "one speed throughout while the position moves (not measured? leave the column out of a table)";
        return Err(("speed".into(), "rad/s: the change of the position in time".into(), got.into()));
    }
    let (slope, agreement) = fit(&rates, speeds);
    if agreement.abs() > SAME && !RIGHT_SLOPE.contains(&slope) {
        let near = |factor: f64| (0.8..1.25).contains(&(slope / factor));
        let guess = match slope {
            s if s < 0.0 => "the sign is the other",
            _ if near(180.0 / std::f64::consts::PI) => {
                "degrees per second, or the position in radians but called degrees"
            }
            _ if near(60.0 / TAU) => "turns per minute",
            _ => "another unit of speed or of time",
        };
        let got = format!("{slope:.3} times that ({guess}?)");
        return Err(("speed".into(), "rad/s: the change of the position in time".into(), got));
    }
    let on: Vec<usize> = (0..log.time.len()).filter(|i| log.enabled[*i]).collect();
    let chosen = |of: &dyn Fn(usize) -> f64| on.iter().map(|i| of(*i)).collect::<Vec<f64>>();
    if fit(&chosen(&|i| log.goal[i]), &chosen(&|i| log.position[i])).1 < OPPOSITE {
        let got = "one that goes the other way (its sign, or the goal's?)";
        return Err(("position".into(), "a position that follows the goal".into(), got.into()));
    }
    if let Some(voltage) = &log.voltage
        && fit(&chosen(&|i| log.goal[i] - log.position[i]), &chosen(&|i| voltage[i])).1 < OPPOSITE
    {
        let got = "one that drives away from it (the sign of 'load'?)";
        return Err(("load".into(), "a duty that drives to the goal".into(), got.into()));
    }
    Ok(())
}

/// Returns the standard deviation.
fn deviation(values: &[f64]) -> f64 {
    let n = values.len().max(1) as f64;
    let mean = values.iter().sum::<f64>() / n;
    (values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / n).sqrt()
}

/// Returns the slope of `y` over `x` and their correlation, both zero where one of them hardly changes.
pub(super) fn fit(x: &[f64], y: &[f64]) -> (f64, f64) {
    let n = x.len().max(1) as f64;
    let (mx, my) = (x.iter().sum::<f64>() / n, y.iter().sum::<f64>() / n);
    let sum = |of: &dyn Fn(f64, f64) -> f64| x.iter().zip(y).map(|(a, b)| of(a - mx, b - my)).sum::<f64>();
    let (xx, yy, xy) = (sum(&|a, _| a * a), sum(&|_, b| b * b), sum(&|a, b| a * b));
    if xx < 1e-6 * n || yy < 1e-9 * n { (0.0, 0.0) } else { (xy / xx, xy / (xx * yy).sqrt()) }
}
