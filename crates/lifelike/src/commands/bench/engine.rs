//! `lifelike bench engine`: physics steps per second.

use std::sync::Arc;
use std::time::Instant;

use lifelike_character::Character;
use lifelike_robot::Robot;
use lifelike_sim::engine::profile::{Cost, costs};
use lifelike_sim::engine::{LifelikeSimulation, self_contacts};
use lifelike_sim::throughput::{Throughput, measure};
use lifelike_sim::{EngineKind, SimulationSpec, Terrain};
use lifelike_simd::InstructionSet;
use serde::Serialize;
use tracing::info;

use crate::commands::machine::{Machine, peak};
use crate::error::CliError;
use crate::output::{Output, table};

/// Count physics steps per second, beside MuJoCo where it was fetched.
///
/// Robots keep their default pose under noise. Every environment is reset once per simulated second, and all observable
/// state is written out. Steps per core-second count processor time, so other programs matter little.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  lifelike bench engine                                     # lima on level ground, one thread
  lifelike bench engine lima humanoid --ground flat,hills --environments 1,8,64,1024,8192
  lifelike bench engine lima --self-collision --threads 2
  lifelike fetch mujoco && lifelike bench engine            # with MuJoCo beside it")]
pub struct Args {
    /// Robots: names, or paths of MJCF or URDF files.
    #[arg(default_value = "lima")]
    robots: Vec<String>,
    /// Numbers of environments.
    #[arg(long, value_delimiter = ',', default_value = "256", value_parser = crate::bounds::environments)]
    environments: Vec<usize>,
    /// Kinds of ground: flat, or hills 15 cm high.
    #[arg(long, value_delimiter = ',', default_value = "flat")]
    ground: Vec<Ground>,
    /// Engines; all that are available where not given.
    #[arg(long, value_delimiter = ',')]
    engine: Vec<EngineKind>,
    /// Let parts of a robot that can touch the ground touch each other too.
    #[arg(long)]
    self_collision: bool,
    /// Threads; 0 for one per processor.
    #[arg(long, default_value_t = 1, value_parser = crate::bounds::threads)]
    threads: usize,
    /// Seconds of each of four rounds; the first one does not count.
    #[arg(long, default_value_t = 1.0)]
    seconds: f64,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum, Serialize)]
#[serde(rename_all = "lowercase")]
enum Ground {
    Flat,
    Hills,
}

/// One engine with so many environments.
#[derive(Debug, Serialize)]
struct Rate {
    robot: String,
    ground: Ground,
    environments: usize,
    engine: String,
    throughput: Throughput,
    /// Of the engine before, on the same problem.
    times: Option<f64>,
    created_s: f64,
    bytes_per_environment: Option<usize>,
}

/// Time of a step of our engine, by stage.
#[derive(Debug, Serialize)]
struct Breakdown {
    robot: String,
    ground: Ground,
    self_contacts: usize,
    stages: Vec<StageCost>,
    operations: f64,
    share_of_peak: f64,
}

#[derive(Debug, Serialize)]
struct StageCost {
    stage: &'static str,
    microseconds: f64,
    operations: f64,
}

#[derive(Debug, Serialize)]
struct Report {
    machine: Machine,
    peak_operations_per_second: f64,
    cache_bytes_per_second: f64,
    rates: Vec<Rate>,
    breakdowns: Vec<Breakdown>,
}

/// Runs the command.
pub fn run(args: &Args, output: &Output) -> Result<(), CliError> {
    if !(args.seconds > 0.0 && args.seconds <= 3600.0) {
        let seconds = args.seconds;
        return Err(CliError::Usage(format!("--seconds: expected a number above 0 and at most 3600, got {seconds}")));
    }
    if args.environments.contains(&0) {
        return Err(CliError::Usage("--environments: expected numbers above 0, got 0".into()));
    }
    let engines = engines(&args.engine)?;
    let hills = Arc::new(Terrain::hills(20.0, 0.1, 0.15, 3.0, 1)?);
    let set = InstructionSet::chosen();
    let mut report = Report {
        machine: Machine::this(),
        peak_operations_per_second: peak::operations(set),
        cache_bytes_per_second: peak::cache_bytes(set),
        rates: Vec::new(),
        breakdowns: Vec::new(),
    };
    for name in &args.robots {
        let robot = Arc::new(load(name, args.self_collision)?);
        for &ground in &args.ground {
            let terrain = (ground == Ground::Hills).then_some(&hills);
            for &environments in &args.environments {
                rates(args, &engines, &robot, (ground, terrain), environments, &mut report.rates)?;
            }
            if engines.contains(&EngineKind::Lifelike) {
                let costs = costs(&robot, terrain, &standing(&robot, terrain), 2000)?;
                report.breakdowns.push(breakdown(&robot, ground, &costs, report.peak_operations_per_second));
            }
        }
    }
    output.result(&report, || text(&report))
}

/// MuJoCo first, so that ours is compared with it.
fn engines(asked: &[EngineKind]) -> Result<Vec<EngineKind>, CliError> {
    for engine in asked {
        engine.available()?;
    }
    let all = [EngineKind::Mujoco, EngineKind::Lifelike].into_iter().filter(|engine| engine.available().is_ok());
    Ok(all.filter(|engine| asked.is_empty() || asked.contains(engine)).collect())
}

fn load(name: &str, self_collision: bool) -> Result<Robot, CliError> {
    let mut robot = Robot::load(name)?;
    if self_collision && self_contacts(&robot) == 0 {
        let text = robot.character.mjcf.clone().unwrap_or_default();
        let text = text.replace(r#"contype="0" conaffinity="1""#, r#"contype="1" conaffinity="1""#);
        robot.character = Character::from_mjcf(&text, name, robot.character.folder.as_deref())?.into();
        if self_contacts(&robot) == 0 {
            return Err(CliError::Usage(format!(
                "--self-collision: '{name}' has no geoms of contype 0 and conaffinity 1"
            )));
        }
    }
    Ok(robot)
}

/// The default pose on the ground.
fn standing(robot: &Robot, terrain: Option<&Arc<Terrain>>) -> Vec<f64> {
    let mut position = robot.default_position();
    if let (Some(terrain), Some(root)) = (terrain, robot.character.root_joint()) {
        position[root.q_index + 2] += terrain.highest(position[root.q_index], position[root.q_index + 1], 0.3);
    }
    position
}

fn rates(
    args: &Args,
    engines: &[EngineKind],
    robot: &Arc<Robot>,
    (ground, terrain): (Ground, Option<&Arc<Terrain>>),
    environments: usize,
    rates: &mut Vec<Rate>,
) -> Result<(), CliError> {
    let mut before: Option<f64> = None;
    for &engine in engines {
        info!("{} x {environments} on {ground:?} ground in {engine}", robot.name);
        let start = Instant::now();
        let spec = SimulationSpec { engine, environments, threads: args.threads, terrain: terrain.cloned() };
        let mut simulation = spec.build(robot.clone())?;
        let created_s = start.elapsed().as_secs_f64();
        let throughput = measure(simulation.as_mut(), &standing(robot, terrain), args.threads, args.seconds)?;
        let bytes = (engine == EngineKind::Lifelike)
            .then(|| LifelikeSimulation::new(robot.clone(), environments, 1).map(|s| s.bytes_per_environment()))
            .transpose()?;
        rates.push(Rate {
            robot: robot.name.clone(),
            ground,
            environments,
            engine: engine.to_string(),
            throughput,
            times: before.map(|before| throughput.core / before),
            created_s,
            bytes_per_environment: bytes,
        });
        before = Some(throughput.core);
    }
    Ok(())
}

fn breakdown(robot: &Robot, ground: Ground, costs: &[Cost], peak: f64) -> Breakdown {
    let sum = |of: fn(&Cost) -> f64| costs.iter().map(of).sum::<f64>();
    let (seconds, operations) = (sum(|c| c.seconds), sum(|c| c.operations));
    let stage = |c: &Cost| StageCost { stage: c.stage.name(), microseconds: 1e6 * c.seconds, operations: c.operations };
    Breakdown {
        robot: robot.name.clone(),
        ground,
        self_contacts: self_contacts(robot),
        stages: costs.iter().map(stage).collect(),
        operations,
        share_of_peak: operations / seconds / peak,
    }
}

fn text(report: &Report) -> String {
    let number = |x: f64| format!("{x:.0}");
    let rows: Vec<Vec<String>> = report
        .rates
        .iter()
        .map(|r| {
            vec![
                r.robot.clone(),
                format!("{:?}", r.ground).to_lowercase(),
                r.environments.to_string(),
                r.engine.clone(),
                number(r.throughput.core),
                number(r.throughput.wall),
                r.times.map_or_else(String::new, |times| format!("{times:.1}")),
                format!("{:.3}", r.created_s),
                r.bytes_per_environment.map_or_else(String::new, |bytes| format!("{:.1}", bytes as f64 / 1024.0)),
            ]
        })
        .collect();
    let head = [
        "robot",
        "ground",
        "environments",
        "engine",
        "steps/core-s",
        "steps/s",
        "times MuJoCo",
        "created (s)",
        "KiB each",
    ];
    let mut text = table(&head, &rows);
    for b in &report.breakdowns {
        let total: f64 = b.stages.iter().map(|s| s.microseconds).sum();
        text += &format!(
            "\n{} on {} ground, {} pairs of its own parts: one physics step of one environment\n",
            b.robot,
            format!("{:?}", b.ground).to_lowercase(),
            b.self_contacts
        );
        let mut rows: Vec<Vec<String>> = b
            .stages
            .iter()
            .map(|s| {
                let share = 100.0 * s.microseconds / total;
                let rate = s.operations / s.microseconds / 1e3;
                vec![
                    s.stage.into(),
                    format!("{:.3}", s.microseconds),
                    format!("{share:.0}"),
                    number(s.operations),
                    format!("{rate:.1}"),
                ]
            })
            .collect();
        rows.push(vec![
            "all".into(),
            format!("{total:.3}"),
            "100".into(),
            number(b.operations),
            format!("{:.1}", b.operations / total / 1e3),
        ]);
        text += &table(&["stage", "us", "% of time", "operations", "Gflop/s"], &rows);
        text += &format!("{:.0}% of what this core multiplies and adds at most\n", 100.0 * b.share_of_peak);
    }
    text += &format!(
        "\none core with {}: {:.1} Gflop/s at most in single precision, {:.0} GB/s from its second-level cache\n",
        report.machine.instruction_set,
        report.peak_operations_per_second / 1e9,
        report.cache_bytes_per_second / 1e9
    );
    text
}
