//! The classical alternative to a network: the parameters of a servo's model by least squares on its logs.
//!
//! Fitted parameters: torque constant, resistance of winding and supply, armature, offset of the arm, delay, and the
//! friction of [`ExtendedFriction`] in one of its sizes. Residuals are position errors of whole simulated runs. The
//! method is Levenberg-Marquardt from several starts.

use levenberg_marquardt::{LeastSquaresProblem, LevenbergMarquardt};
use lifelike_checkpoint::rng::stream;
use lifelike_robot::actuator::{DcMotor, ExtendedFriction};
use lifelike_sim::bench::{GRAVITY, PendulumBench};
use nalgebra::storage::Owned;
use nalgebra::{DMatrix, DVector, Dyn};
use rand::Rng;
use rayon::prelude::*;

use crate::logs::bam::{BenchLog, BenchRun};
pub use crate::logs::bam::{DYNAMIXEL_DUTY, FEETECH_DUTY};

/// Extent of the friction that is fitted (Duclusaud et al. 2024).
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum FrictionModel {
    /// Coulomb and viscous: what most simulators have.
    M1,
    /// And Stribeck's.
    M2,
    /// Coulomb, viscous and load.
    M3,
    /// And Stribeck's of both.
    M4,
    /// Load of motor and outside apart.
    M5,
    /// And quadratic terms of load.
    M6,
}

/// A parameter, between its bounds.
struct Parameter {
    low: f64,
    high: f64,
    start: f64,
    set: fn(&mut Servo, f64),
}

impl Parameter {
    /// Returns the parameter with start and bounds in a unit.
    fn in_units(self, unit: f64) -> Self {
        Self { low: self.low * unit, high: self.high * unit, start: self.start * unit, set: self.set }
    }
}

/// Numbers that are fitted, whatever hangs on the servo.
#[derive(Debug, Clone, Copy, PartialEq, Default, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Servo {
    /// Duty for an error of one radian and a gain of 1 in the servo's own unit (1/rad).
    pub duty: f64,
    /// The controller's own reference follows commands no faster (rad/s), if it has such a limit.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub goal_speed: Option<f64>,
    /// Torque constant (N m/A).
    pub torque_constant: f64,
    /// Resistance of the winding (ohm).
    pub resistance: f64,
    /// Resistance of the supply (ohm).
    pub supply_resistance: f64,
    /// Inertia at the output (kg m²).
    pub armature: f64,
    /// Added to the servo's angle it is the arm's (rad).
    pub offset: f64,
    /// Delay of commands (s).
    pub delay: f64,
    /// Friction.
    pub friction: ExtendedFriction,
}

impl Servo {
    /// Names of [`Self::built_in`].
    pub const NAMES: [&str; 2] = ["xl330", "sts3250"];

    /// Returns a servo by its data sheet, which says nothing of friction, rotor and delay.
    pub fn built_in(name: &str) -> Option<Self> {
        match name {
            // Dynamixel XL330-M288-T at 5 V: stall torque 0.52 N m at 1.47 A.
            "xl330" => Some(Self {
                duty: DYNAMIXEL_DUTY,
                torque_constant: 0.52 / 1.47,
                resistance: 5.0 / 1.47,
                ..Self::default()
            }),
            // Feetech STS3250 at 12 V: 0.133 s for 60 degrees without load, stall torque 50 kg cm.
            "sts3250" => {
                let (supply, speed, stall) = (12.0, 60_f64.to_radians() / 0.133, 0.5 * GRAVITY);
                let torque_constant = supply / speed;
                Some(Self {
                    duty: FEETECH_DUTY,
                    goal_speed: Some(speed),
                    torque_constant,
                    resistance: torque_constant * supply / stall,
                    ..Self::default()
                })
            }
            _ => None,
        }
    }

    /// Torque (N m) that it holds at a supply (V) when it cannot turn, without friction.
    fn stall_torque(&self, supply: f64) -> f64 {
        self.torque_constant * supply / (self.resistance + self.supply_resistance)
    }

    /// Velocity (rad/s) at a supply (V) without load, without friction.
    fn free_speed(&self, supply: f64) -> f64 {
        supply / self.torque_constant
    }

    /// Returns the servo on a log's bench, with its gain.
    pub fn bench(&self, log: &BenchLog) -> PendulumBench {
        PendulumBench {
            mass: log.mass,
            arm_mass: log.arm_mass,
            arm: log.arm,
            goal_speed: self.goal_speed,
            armature: self.armature,
            offset: self.offset,
            motor: DcMotor {
                proportional: log.gain * self.duty,
                integral: 0.0,
                derivative: 0.0,
                duty_max: 1.0,
                supply: log.supply,
                supply_resistance: self.supply_resistance,
                resistance: self.resistance,
                torque_constant: self.torque_constant,
                current_max: f64::INFINITY,
            },
            friction: self.friction,
            delay: self.delay,
        }
    }

    /// Returns the mean absolute error of the position (rad) over runs of logs.
    pub fn error(&self, runs: &[(&BenchLog, &BenchRun)]) -> f64 {
        let each = runs.iter().map(|(log, run)| {
            let motion = self.bench(log).run(run.commands(), run.position[0], run.velocity[0]);
            let pairs = motion.position.iter().zip(&run.position);
            pairs.map(|(a, b)| (a - b).abs()).sum::<f64>() / run.position.len() as f64
        });
        each.sum::<f64>() / runs.len().max(1) as f64
    }
}

impl FrictionModel {
    /// All of them, the smallest first.
    pub const ALL: [Self; 6] = [Self::M1, Self::M2, Self::M3, Self::M4, Self::M5, Self::M6];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::M1 => "m1",
            Self::M2 => "m2",
            Self::M3 => "m3",
            Self::M4 => "m4",
            Self::M5 => "m5",
            Self::M6 => "m6",
        }
    }

    /// Returns the fitted numbers around a servo: electrical numbers in units of its own. Mechanical ones are in those
    /// that fit an XL330 at 7.4 V, scaled to its stall torque and speed at a supply (V). A controller with a limit of
    /// speed is one that was not measured: it is fitted too.
    fn parameters(self, around: &Servo, supply: f64) -> Vec<Parameter> {
        let p = |low: f64, high: f64, start: f64, set: fn(&mut Servo, f64)| Parameter { low, high, start, set };
        let small = Servo::built_in("xl330").unwrap_or_default();
        let torque = around.stall_torque(supply) / small.stall_torque(7.4);
        let speed = around.free_speed(supply) / small.free_speed(7.4);
        let mut all = vec![
            p(0.3, 3.0, 1.0, |s, x| s.torque_constant = x).in_units(around.torque_constant),
            p(0.3, 3.0, 1.2, |s, x| s.resistance = x).in_units(around.resistance),
            p(0.0, 1.5, 0.1, |s, x| s.supply_resistance = x).in_units(around.resistance),
            p(1e-4, 0.01, 1.5e-3, |s, x| s.armature = x).in_units(torque),
            p(-0.1, 0.1, 0.01, |s, x| s.offset = x),
            p(0.0, 0.04, 0.005, |s, x| s.delay = x),
            p(0.0, 0.1, 0.01, |s, x| s.friction.base = x).in_units(torque),
            p(0.0, 0.05, 0.005, |s, x| s.friction.viscous = x).in_units(torque / speed),
        ];
        if let Some(limit) = around.goal_speed {
            all.extend([
                p(0.1, 4.0, 1.0, |s, x| s.duty = x).in_units(around.duty),
                p(0.3, 3.0, 1.0, |s, x| s.goal_speed = Some(x)).in_units(limit),
            ]);
        }
        let stribeck = matches!(self, Self::M2 | Self::M4 | Self::M5 | Self::M6);
        if stribeck {
            all.extend([
                p(0.0, 0.1, 0.01, |s, x| s.friction.stribeck = x).in_units(torque),
                p(0.1, 10.0, 2.0, |s, x| s.friction.stribeck_velocity = x).in_units(speed),
                p(0.3, 8.0, 1.5, |s, x| s.friction.stribeck_exponent = x),
            ]);
        }
        match self {
            Self::M1 | Self::M2 => {}
            Self::M3 => all.push(p(0.0, 0.5, 0.1, |s, x| s.friction.load = [x, x])),
            Self::M4 => all.extend([
                p(0.0, 0.5, 0.1, |s, x| s.friction.load = [x, x]),
                p(0.0, 0.5, 0.05, |s, x| s.friction.load_stribeck = [x, x]),
            ]),
            Self::M5 | Self::M6 => all.extend([
                p(0.0, 0.6, 0.2, |s, x| s.friction.load[0] = x),
                p(0.0, 0.6, 0.05, |s, x| s.friction.load[1] = x),
                p(0.0, 0.6, 0.05, |s, x| s.friction.load_stribeck[0] = x),
                p(0.0, 0.6, 0.1, |s, x| s.friction.load_stribeck[1] = x),
            ]),
        }
        if self == Self::M6 {
            all.extend([
                p(0.0, 0.5, 0.01, |s, x| s.friction.load_quadratic[0] = x).in_units(1.0 / torque),
                p(0.0, 0.5, 0.01, |s, x| s.friction.load_quadratic[1] = x).in_units(1.0 / torque),
            ]);
        }
        all
    }
}

/// Turns any number into one between bounds.
fn bounded(parameter: &Parameter, x: f64) -> f64 {
    parameter.low + (parameter.high - parameter.low) / (1.0 + (-x).exp())
}

fn unbounded(parameter: &Parameter, value: f64) -> f64 {
    let share = ((value - parameter.low) / (parameter.high - parameter.low)).clamp(0.01, 0.99);
    (share / (1.0 - share)).ln()
}

fn servo(around: &Servo, parameters: &[Parameter], x: &[f64]) -> Servo {
    let mut servo = *around;
    parameters.iter().zip(x).for_each(|(parameter, x)| (parameter.set)(&mut servo, bounded(parameter, *x)));
    servo
}

/// Positions of all runs, less those measured.
struct Problem<'a> {
    around: &'a Servo,
    parameters: &'a [Parameter],
    runs: &'a [(&'a BenchLog, &'a BenchRun)],
    x: DVector<f64>,
}

impl Problem<'_> {
    fn at(&self, x: &[f64]) -> Vec<f64> {
        let servo = servo(self.around, self.parameters, x);
        let residuals = |(log, run): &(&BenchLog, &BenchRun)| {
            let motion = servo.bench(log).run(run.commands(), run.position[0], run.velocity[0]);
            motion.position.into_iter().zip(&run.position).map(|(a, b)| soft(a - b)).collect::<Vec<_>>()
        };
        self.runs.iter().flat_map(residuals).collect()
    }
}

/// Returns the cost of a difference: squares of small ones, the size of large ones, since it is the mean absolute
/// error that is compared.
fn soft(difference: f64) -> f64 {
    const KNEE: f64 = 0.01;
    let ratio = difference / KNEE;
    difference.signum() * KNEE * (2.0 * ((1.0 + ratio * ratio).sqrt() - 1.0)).sqrt()
}

/// Step of the finite differences, in the numbers without bounds.
const STEP: f64 = 1e-4;

impl LeastSquaresProblem<f64, Dyn, Dyn> for Problem<'_> {
    type ParameterStorage = Owned<f64, Dyn>;
    type ResidualStorage = Owned<f64, Dyn>;
    type JacobianStorage = Owned<f64, Dyn, Dyn>;

    fn set_params(&mut self, x: &DVector<f64>) {
        self.x.copy_from(x);
    }

    fn params(&self) -> DVector<f64> {
        self.x.clone()
    }

    fn residuals(&self) -> Option<DVector<f64>> {
        let residuals = self.at(self.x.as_slice());
        residuals.iter().all(|x| x.is_finite()).then(|| DVector::from_vec(residuals))
    }

    fn jacobian(&self) -> Option<DMatrix<f64>> {
        let columns: Vec<Vec<f64>> = (0..self.x.len())
            .into_par_iter()
            .map(|i| {
                let at = |step: f64| {
                    let mut x = self.x.as_slice().to_vec();
                    x[i] += step;
                    self.at(&x)
                };
                at(STEP).iter().zip(at(-STEP)).map(|(a, b)| (a - b) / (2.0 * STEP)).collect()
            })
            .collect();
        let rows = columns.first()?.len();
        Some(DMatrix::from_fn(rows, columns.len(), |row, column| columns[column][row]))
    }
}

/// Fits a servo to runs of its logs, from `starts` starts drawn around what is usual for a servo like `around`, a data
/// sheet's say. It returns the best of them by its mean absolute error on these runs.
pub fn fit(model: FrictionModel, around: &Servo, runs: &[(&BenchLog, &BenchRun)], starts: u64, seed: u64) -> Servo {
    let supply = runs.iter().map(|(log, _)| log.supply).fold(0.0, f64::max);
    let parameters = model.parameters(around, supply);
    let fitted = (0..starts.max(1)).map(|start| {
        let mut rng = stream(seed, "identification", 0, start);
        let x = parameters.iter().map(|p| {
            let around = if start == 0 { 0.0 } else { rng.random_range(-1.5..1.5) };
            unbounded(p, p.start) + around
        });
        let problem = Problem { around, parameters: &parameters, runs, x: DVector::from_iterator(parameters.len(), x) };
        let (problem, _) = LevenbergMarquardt::new().with_patience(40).minimize(problem);
        servo(around, &parameters, problem.x.as_slice())
    });
    let scored = fitted.map(|servo| (servo.error(runs), servo));
    let best = scored.min_by(|a, b| a.0.total_cmp(&b.0));
    best.map_or(*around, |(_, servo)| servo)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::logs::Clock;

    /// A servo that simulated its own log is found again, by what it does.
    #[test]
    fn a_simulated_servo_is_found_again() {
        let sheet = Servo::built_in("xl330").unwrap();
        let real = Servo {
            duty: sheet.duty,
            goal_speed: None,
            torque_constant: 0.33,
            resistance: 3.6,
            supply_resistance: 0.5,
            armature: 1.8e-3,
            offset: 0.02,
            delay: 0.01,
            friction: ExtendedFriction { base: 0.012, viscous: 0.009, ..ExtendedFriction::default() },
        };
        let time: Vec<f64> = (0..500).map(|i| f64::from(i) * 0.005).collect();
        let log = |frequency: f64| BenchLog {
            notes: Vec::new(),
            name: format!("{frequency} rad/s"),
            motor: "servo".into(),
            trajectory: "sine".into(),
            mass: 0.4,
            arm_mass: 0.0,
            arm: 0.1,
            gain: 300.0,
            supply: 7.4,
            goal: time.iter().map(|t| 0.8 * (frequency * t).sin()).collect(),
            position: vec![0.0; time.len()],
            velocity: vec![0.0; time.len()],
            voltage: None,
            enabled: vec![true; time.len()],
            clock: Clock::of(&time).unwrap(),
            time: time.clone(),
        };
        let logs = [2.0, 5.0, 9.0].map(log);
        let runs = logs.each_ref().map(|log| {
            let mut run = log.at(200.0);
            run.position = real.bench(log).run(run.commands(), 0.0, 0.0).position;
            run
        });
        let pairs: Vec<(&BenchLog, &BenchRun)> = logs.iter().zip(&runs).collect();
        // Two of three are fitted to, the third is new.
        let found = fit(FrictionModel::M1, &sheet, &pairs[..2], 3, 1);
        let plain = sheet.error(&pairs[2..]);
        let error = found.error(&pairs[2..]);
        assert!(error < 0.05 * plain && error < 2e-3, "{error} rad of {plain}: {found:?}");
        assert!((found.offset - real.offset).abs() < 5e-3 && (found.delay - real.delay).abs() < 3e-3, "{found:?}");
    }
}
