//! What a network, and what parameters, make of real logs of a servo's test bench: folds by trajectory and by gain.
//!
//! `cargo run --release -p lifelike-augmentation --example bench_logs -- FOLDER [iterations] [seeds] [architectures] [PARAMETERS]` with BAM's
//! raw logs of one servo in the folder, architectures from sat, lstm, attention, dense with commas between, and in PARAMETERS the servo as BAM
//! published it (m1.json to m6.json). `TWIN=1`: the logs' measurements are replaced by those of a simulated servo, to choose settings on.

use std::collections::BTreeMap;
use std::error::Error;
use std::path::PathBuf;

use lifelike_augmentation::identification::{DYNAMIXEL_DUTY, FrictionModel, Servo, fit};
use lifelike_augmentation::logs::{BenchLog, BenchRun};
use lifelike_augmentation::model::{Backbone, SatSizes};
use lifelike_augmentation::training::{AugmentationPlan, AugmentationTrainer};
use lifelike_augmentation::{Feedback, gap};
use lifelike_robot::actuator::ExtendedFriction;
use lifelike_sim::trace::Trace;

/// Rows per second (Hz).
const RATE: f64 = 200.0;
struct Recorded {
    log: BenchLog,
    run: BenchRun,
}

/// Mean absolute error of the position (deg) of each log.
type Errors = BTreeMap<String, f64>;

fn errors(traces: &[Trace]) -> Errors {
    let position = |trace: &Trace| {
        let gaps = gap::gaps(trace);
        gaps.iter().find(|gap| gap.column == "position").map_or(f64::NAN, |gap| gap.mae.to_degrees())
    };
    traces.iter().map(|trace| (trace.name.clone(), position(trace))).collect()
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let folder = arguments.first().ok_or("name the folder of the raw logs")?;
    let iterations = arguments.get(1).map_or(Ok(600), |text| text.parse())?;
    let seeds: u64 = arguments.get(2).map_or(Ok(1), |text| text.parse())?;
    let names: Vec<&str> = arguments.get(3).map_or("sat", String::as_str).split(',').collect();
    let architectures = names.into_iter().map(architecture).collect::<Result<Vec<_>, _>>()?;
    let mut files: Vec<PathBuf> =
        std::fs::read_dir(folder)?.map(|entry| Ok(entry?.path())).collect::<Result<_, std::io::Error>>()?;
    files.sort();
    let twin = std::env::var_os("TWIN").is_some();
    let mut recorded = Vec::new();
    for file in files {
        let log = BenchLog::read(&file)?;
        let mut run = log.at(RATE);
        if twin {
            let real = Servo {
                duty: DYNAMIXEL_DUTY,
                goal_speed: None,
                friction: ExtendedFriction {
                    base: 0.005,
                    viscous: 0.009,
                    stribeck: 0.01,
                    stribeck_velocity: 0.4,
                    stribeck_exponent: 1.2,
                    load: [0.3, 0.06],
                    load_stribeck: [0.0, 0.3],
                    load_quadratic: [0.0, 0.0],
                },
                supply_resistance: 0.6,
                armature: 1.8e-3,
                offset: 0.02,
                delay: 0.008,
                resistance: 3.5,
                torque_constant: 0.33,
            };
            let motion = real.bench(&log).run(run.commands(), run.position[0], run.velocity[0]);
            let quantum = std::f64::consts::TAU / 4096.0;
            run.position = motion.position.iter().map(|q| (q / quantum).round() * quantum).collect();
            run.velocity = motion.velocity.iter().map(|v| (v / 0.024).round() * 0.024).collect();
            run.voltage = Some(motion.voltage);
        }
        recorded.push(Recorded { log, run });
    }
    let sheet =
        recorded.first().and_then(|r| Servo::built_in(&r.log.motor)).ok_or("no log of a servo that is known")?;
    let trajectories: Vec<String> = distinct(recorded.iter().map(|r| r.log.trajectory.clone()));
    let gains: Vec<String> = distinct(recorded.iter().map(|r| format!("kp {}", r.log.gain)));
    for (title, folds, key) in [
        ("trajectory held out", trajectories, (|log: &BenchLog| log.trajectory.clone()) as fn(&BenchLog) -> String),
        ("gain held out", gains, |log: &BenchLog| format!("kp {}", log.gain)),
    ] {
        if folds.len() < 2 {
            continue;
        }
        let mut rows: BTreeMap<String, Vec<Errors>> = BTreeMap::new();
        if let Some(parameters) = arguments.get(4) {
            for model in FrictionModel::ALL {
                let servo = published(&sheet, &PathBuf::from(parameters).join(format!("{}.json", model.name())))?;
                let traces: Vec<Trace> =
                    recorded.iter().map(|r| r.run.simulated(&r.log, &servo.bench(&r.log))).collect();
                rows.entry(format!("BAM's {}, as published", model.name())).or_default().push(errors(&traces));
            }
        }
        for fold in folds {
            let (test, train): (Vec<&Recorded>, Vec<&Recorded>) = recorded.iter().partition(|r| key(&r.log) == fold);
            let runs: Vec<(&BenchLog, &BenchRun)> = train.iter().map(|r| (&r.log, &r.run)).collect();
            let mut servos = vec![("data sheet".to_string(), sheet)];
            for model in [FrictionModel::M1, FrictionModel::M3, FrictionModel::M6] {
                servos.push((format!("fitted {}", model.name()), fit(model, &sheet, &runs, 6, 1)));
            }
            for (name, servo) in servos {
                let traces = |of: &[&Recorded]| -> Vec<Trace> {
                    of.iter().map(|r| r.run.simulated(&r.log, &servo.bench(&r.log))).collect()
                };
                let (learn, held_out) = (traces(&train), traces(&test));
                rows.entry(name.clone()).or_default().push(errors(&held_out));
                let late: Vec<Trace> = held_out.iter().map(persistent).collect();
                rows.entry(format!("{name} + the error measured before")).or_default().push(errors(&late));
                if name == "fitted m1" || name == "fitted m3" {
                    continue;
                }
                // What the data sheet leaves is compared with the first architecture only.
                let compared = if name == "data sheet" { &architectures[..1] } else { &architectures[..] };
                for ((architecture, model), seed) in
                    compared.iter().flat_map(|own| (0..seeds).map(move |seed| (own, seed)))
                {
                    let outputs = vec!["position".into(), "velocity".into()];
                    let plan =
                        AugmentationPlan { seed, iterations, outputs, model: *model, ..AugmentationPlan::default() };
                    let mut trainer = AugmentationTrainer::new(&plan, &learn, &[])?;
                    for _ in 0..iterations {
                        trainer.iterate();
                    }
                    let augmentation = trainer.augmentation();
                    for feedback in [Feedback::None, Feedback::Predicted, Feedback::Measured] {
                        let corrected: Result<Vec<Trace>, _> =
                            held_out.iter().map(|trace| augmentation.corrected(trace, feedback)).collect();
                        let name = format!("{name} + {architecture}, {feedback:?}");
                        rows.entry(name).or_default().push(errors(&corrected?));
                    }
                }
            }
        }
        println!("\n{title}: mean absolute error of the position, deg");
        for (name, folds) in rows {
            let mut all: BTreeMap<String, Vec<f64>> = BTreeMap::new();
            folds.iter().flatten().for_each(|(log, error)| all.entry(log.clone()).or_default().push(*error));
            let means: Vec<f64> = all.values().map(|own| own.iter().sum::<f64>() / own.len() as f64).collect();
            let each: Vec<String> = means.iter().map(|mae| format!("{mae:.2}")).collect();
            println!("{name:40} {:.3}   ({})", means.iter().sum::<f64>() / means.len() as f64, each.join(" "));
        }
    }
    Ok(())
}

/// The plainest use of measurements: the error of the step before is taken to be that of this step.
fn persistent(trace: &Trace) -> Trace {
    let mut out = trace.clone();
    for block in &mut out.blocks {
        let (error, measured, width) = (block.error(), block.measured.names.len(), block.simulated.names.len());
        for (i, name) in block.measured.names.iter().enumerate() {
            let Some(column) = block.simulated.index(name) else { continue };
            for (row, state) in block.simulated.values.chunks_exact_mut(width).enumerate().skip(1) {
                state[column] += error[(row - 1) * measured + i];
            }
        }
    }
    out
}

/// An architecture by its name.
fn architecture(name: &str) -> Result<(&str, SatSizes), String> {
    let (backbone, attention) = match name {
        "sat" => (Backbone::Lstm, true),
        "lstm" => (Backbone::Lstm, false),
        "attention" => (Backbone::None, true),
        "dense" => (Backbone::Dense, true),
        other => return Err(format!("expected sat, lstm, attention or dense, got '{other}'")),
    };
    Ok((name, SatSizes { backbone, attention, ..SatSizes::default() }))
}

/// A servo as BAM publishes it.
fn published(sheet: &Servo, path: &std::path::Path) -> Result<Servo, Box<dyn Error>> {
    let file: BTreeMap<String, serde_json::Value> = serde_json::from_str(&std::fs::read_to_string(path)?)?;
    let number = |name: &str| file.get(name).and_then(serde_json::Value::as_f64).unwrap_or(0.0);
    let both = |motor: &str, outside: &str, one: &str| [number(motor) + number(one), number(outside) + number(one)];
    Ok(Servo {
        duty: sheet.duty,
        goal_speed: sheet.goal_speed,
        torque_constant: number("kt"),
        resistance: number("R"),
        supply_resistance: 0.0,
        armature: number("armature"),
        offset: number("q_offset"),
        delay: 0.0,
        friction: ExtendedFriction {
            base: number("friction_base"),
            stribeck: number("friction_stribeck"),
            stribeck_velocity: number("dtheta_stribeck"),
            stribeck_exponent: number("alpha"),
            load: both("load_friction_motor", "load_friction_external", "load_friction_base"),
            load_stribeck: both(
                "load_friction_motor_stribeck",
                "load_friction_external_stribeck",
                "load_friction_stribeck",
            ),
            load_quadratic: [number("load_friction_motor_quad"), number("load_friction_external_quad")],
            viscous: number("friction_viscous"),
        },
    })
}

fn distinct(values: impl Iterator<Item = String>) -> Vec<String> {
    let mut out: Vec<String> = values.collect();
    out.sort();
    out.dedup();
    out
}
