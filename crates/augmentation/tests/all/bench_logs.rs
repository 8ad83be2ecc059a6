//! Logs of benches: the arm's mass, units and signs.
use std::f64::consts::TAU;
use std::path::PathBuf;

use lifelike_augmentation::logs::BenchLog;
use serde_json::{Value, json};

/// A servo that follows a sine late, as a proportional controller does; `entry` changes each entry.
fn log(entry: impl Fn(&mut Value)) -> Value {
    let entries: Vec<Value> = (0..400)
        .map(|i| {
            let t = 0.005 * f64::from(i);
            let (goal, position) = (0.6 * (3.0 * t).sin(), 0.5 * (3.0 * t - 0.1).sin());
            let mut row = json!({ "timestamp": t, "goal_position": goal, "position": position,
                "speed": 1.5 * (3.0 * t - 0.1).cos(), "load": 885.0 * 2.0 * (goal - position), "input_volts": 7.5,
                "torque_enable": true });
            entry(&mut row);
            row
        })
        .collect();
    json!({ "mass": 0.1, "length": 0.15, "kp": 400.0, "vin": 7.5, "motor": "xl330", "trajectory": "sine", "entries": entries })
}

fn written(name: &str, text: &str) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, text).unwrap();
    (folder, path)
}

fn read(log: &Value) -> Result<BenchLog, String> {
    let (_folder, path) = written("log.json", &log.to_string());
    BenchLog::read(&path).map_err(|error| error.to_string())
}

fn scaled(key: &str, factor: f64) -> Value {
    log(|row| row[key] = json!(row[key].as_f64().unwrap() * factor))
}

#[track_caller]
fn refused(log: &Value, parts: &[&str]) {
    let error = read(log).unwrap_err();
    assert!(parts.iter().all(|part| error.contains(part)), "{error}");
}

#[test]
fn the_arm_has_a_mass() {
    let mut with = log(|_| {});
    assert_eq!(read(&with).unwrap().arm_mass, 0.0);
    with["arm_mass"] = json!(0.2);
    assert_eq!(read(&with).unwrap().arm_mass, 0.2);
    // An arm alone is a bench, and nothing at all is none.
    with["mass"] = json!(0.0);
    assert_eq!(read(&with).unwrap().mass, 0.0);
    with["arm_mass"] = json!(-0.2);
    refused(&with, &["arm_mass: expected"]);
    with["arm_mass"] = json!(0.0);
    refused(&with, &["arm_mass: expected a number above 0, got 0"]);
}

#[test]
fn a_duty_is_a_duty_in_either_unit() {
    let (units, duty) = (read(&log(|_| {})).unwrap(), read(&scaled("load", 1.0 / 885.0)).unwrap());
    let (units, duty) = (units.voltage.unwrap(), duty.voltage.unwrap());
    assert!(units.iter().any(|volts| volts.abs() > 0.5));
    assert!(units.iter().zip(&duty).all(|(a, b)| (a - b).abs() < 1e-9));
    assert!(read(&scaled("load", 0.0)).unwrap().voltage.is_none(), "a servo that does not tell its duty");
}

/// The gain of a known servo commands a duty, which tells percent from 885ths.
#[test]
fn a_duty_in_percent_is_refused_told_or_read() {
    let percent = || scaled("load", 100.0 / 885.0);
    let parts = ["load: expected 885ths of the duty that kp 400 commands", "0.20 times that", "\"load_unit\": \"%\""];
    refused(&percent(), &parts);
    let (mut stated, mut unknown) = (percent(), percent());
    stated["load_unit"] = json!("%");
    let (stated, plain) = (read(&stated).unwrap(), read(&log(|_| {})).unwrap());
    let volts = stated.voltage.unwrap();
    assert!(volts.iter().zip(plain.voltage.unwrap()).all(|(a, b)| (a - b).abs() < 1e-9));
    assert!(stated.notes.is_empty() && plain.notes.is_empty());
    unknown["motor"] = json!("sm40");
    let note = read(&unknown).unwrap().notes.concat();
    assert!(note.contains("taken for 885ths") && note.contains("load_unit"), "{note}");
    // A weak motion of a known servo is none: its gain says so.
    let weak = log(|row| {
        for key in ["goal_position", "position", "speed", "load"] {
            row[key] = json!(row[key].as_f64().unwrap() * 0.2);
        }
    });
    assert!(read(&weak).unwrap().notes.is_empty());
    let mut other = log(|_| {});
    other["load_unit"] = json!("permille");
    refused(&other, &["885ths", "permille"]);
}

#[test]
fn other_units_and_signs_are_refused_by_name() {
    refused(&scaled("timestamp", 1e3), &["timestamp: expected seconds", "got 5 (milliseconds?"]);
    refused(&scaled("speed", 360.0 / TAU), &["speed: expected rad/s", "57.29", "degrees per second"]);
    refused(&scaled("speed", 60.0 / TAU), &["turns per minute?"]);
    refused(&scaled("speed", -1.0), &["the sign is the other?"]);
    refused(&scaled("load", -1.0), &["load: expected a duty that drives to the goal", "the sign of 'load'?"]);
    let mirrored = log(|row| {
        for key in ["position", "speed", "load"] {
            row[key] = json!(-row[key].as_f64().unwrap());
        }
    });
    refused(&mirrored, &["position: expected a position that follows the goal"]);
    // Filters and noise of real servos are no other unit.
    assert!(read(&scaled("speed", 0.8)).is_ok());
    refused(&scaled("position", 0.0), &["position: expected rad", "one position throughout"]);
    refused(&scaled("speed", 0.0), &["speed: expected rad/s", "one speed throughout while the position moves"]);
}

#[test]
fn numbers_of_other_units_are_beyond_a_bench() {
    for (key, value, part) in [
        ("mass", 100.0, "mass: expected at most 20 kg (g?), got 100"),
        ("arm_mass", 25.0, "arm_mass: expected at most 20 kg (g?), got 25"),
        ("length", 15.0, "length: expected at most 2 m (cm or mm?), got 15"),
        ("vin", 7500.0, "vin: expected at most 100 V (mV?), got 7500"),
    ] {
        let mut log = log(|_| {});
        log[key] = json!(value);
        refused(&log, &[part]);
    }
    refused(&scaled("input_volts", 0.0), &["input_volts: expected volts above 0"]);
    // 0.1 V is the unit of a Dynamixel's register.
    refused(&scaled("input_volts", 10.0), &["load: expected duty times supply of at most 11.25 V", "0.1 V"]);
}

#[test]
fn epochs_and_byte_order_marks_change_nothing() {
    let plain = read(&log(|_| {})).unwrap();
    let epoch = read(&log(|row| row["timestamp"] = json!(1.7e9 + row["timestamp"].as_f64().unwrap()))).unwrap();
    assert_eq!((plain.at(200.0).goal.len(), epoch.at(200.0).goal.len()), (400, 400));
    let (_folder, path) = written("log.json", &format!("\u{feff}{}", log(|_| {})));
    assert_eq!(BenchLog::read(&path).unwrap().goal, plain.goal);
}

#[test]
fn a_table_says_its_units_and_its_bench() {
    let json = read(&log(|_| {})).unwrap();
    let rows: Vec<String> = (0..400)
        .map(|i| {
            let degrees = |x: f64| x.to_degrees();
            let duty = json.voltage.as_ref().unwrap()[i] / 7.5;
            format!(
                "{},{},{},{},{duty}",
                1e3 * json.time[i],
                degrees(json.goal[i]),
                degrees(json.position[i]),
                json.velocity[i] * 60.0 / TAU
            )
        })
        .collect();
    let head = "# motor = xl330\n# trajectory = sine\n# mass = 0.1 kg\n# length = 0.15 m\n# kp = 400\n# vin = 7.5 V\n";
    let table = |header: &str| format!("{head}{header}\n{}\n", rows.join("\n"));
    let of = |text: &str| {
        let (_folder, path) = written("log.csv", text);
        BenchLog::read(&path).map_err(|error| error.to_string())
    };
    let header = "time [ms], goal [deg], position [deg], speed [rpm], duty [1]";
    let read = of(&table(header)).unwrap();
    let near = |a: &[f64], b: &[f64]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-12);
    assert!(near(&read.time, &json.time) && near(&read.goal, &json.goal) && near(&read.position, &json.position));
    assert!(near(&read.velocity, &json.velocity) && near(&read.voltage.unwrap(), json.voltage.as_ref().unwrap()));
    assert_eq!((read.mass, read.arm, read.gain, read.supply), (0.1, 0.15, 400.0, 7.5));

    let small =
        table(header).replace("0.1 kg", "100 g ; the weight").replace("0.15 m", "15 cm").replace("7.5 V", "7500 mV");
    let read = of(&format!("\u{feff}{small}")).unwrap();
    assert!(near(&[read.mass, read.arm, read.supply], &[0.1, 0.15, 7.5]), "{read:?}");
    let error = of(&table(header).replace("0.1 kg", "0.1 lb")).unwrap_err();
    assert!(error.contains("'# mass': expected a number in kg, g, got '0.1 lb'"), "{error}");
    let error = of(&table("time [ms], goal [deg], position [deg], position [deg], duty [1]")).unwrap_err();
    assert!(error.contains("line 7: expected each column once, got 'position' twice"), "{error}");
    let error = of(&table("time, goal [deg], position [deg], speed [rpm], duty [1]")).unwrap_err();
    assert!(error.contains("line 7: expected 'time [UNIT]' with one of s, ms, us, got 'time'"), "{error}");
    let error = of(&table("time [ms], goal [deg], angle [deg], speed [rpm], duty [1]")).unwrap_err();
    assert!(error.contains("got 'angle [deg]'") && error.contains("position"), "{error}");
    let error = of(&table(header).replace("# vin = 7.5 V\n", "")).unwrap_err();
    assert!(error.contains("expected a line '# vin = NUMBER', got none"), "{error}");
    // Radians under a header of degrees: a speed contradicts them, or else the duty that the gain commands.
    let text = table(header);
    let small: Vec<String> = text.lines().map(|line| radians(line, true)).collect();
    let error = of(&small.join("\n")).unwrap_err();
    assert!(error.contains("position in radians but called degrees"), "{error}");
    let small: Vec<String> = text.lines().map(|line| radians(line, false)).collect();
    let error = of(&small.join("\n")).unwrap_err();
    assert!(error.contains("times that duty (radians that the header calls degrees?)"), "{error}");
    let error = of(&table("time [s], goal [deg], position [deg], speed [rpm], duty [1]")).unwrap_err();
    assert!(error.contains("milliseconds?"), "{error}");
}

/// Returns a table's row with goal and position in radians, with its speed or without.
fn radians(line: &str, with_speed: bool) -> String {
    let mut cells: Vec<String> = line.split(',').map(str::to_owned).collect();
    if cells.len() == 5 {
        for cell in &mut cells[1..3] {
            if let Ok(angle) = cell.parse::<f64>() {
                *cell = angle.to_radians().to_string();
            }
        }
        if !with_speed {
            cells.remove(3);
        }
    }
    cells.join(",")
}
