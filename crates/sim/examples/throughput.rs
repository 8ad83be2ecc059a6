//! Physics steps per second: `cargo run --release -p lifelike-sim --example throughput -- \
//! [robot] [environments] [threads] [seconds] [engine]`. Noisy targets around the default pose, each environment reset every
//! second, state extraction included.

use std::sync::Arc;
use std::time::Instant;

use lifelike_robot::Robot;
use lifelike_sim::Drive;
use rand::{Rng, SeedableRng};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let number = |i: usize, otherwise: usize| arguments.get(i).map_or(Ok(otherwise), |a| a.parse());
    let robot = Arc::new(Robot::load(arguments.first().map_or("lima", String::as_str))?);
    let (environments, threads, seconds) = (number(1, 256)?, number(2, 1)?, number(3, 5)?);
    let engine = arguments.get(4).map_or("lifelike", String::as_str);
    let mut simulation = lifelike_sim::create(engine, robot.clone(), environments, threads)?;
    let position = robot.default_position();
    let velocity = vec![0.0; robot.character.nv];
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(1);
    let noise: Vec<f32> = (0..1 << 16).map(|_| rng.random_range(-0.1..0.1)).collect();
    let mut targets = vec![0.0; environments * robot.joints()];
    let mut rates = Vec::new();
    let mut step = 0;
    for _ in 0..seconds {
        let (start, cpu_start, mut control_steps) = (Instant::now(), cpu_seconds()?, 0);
        while start.elapsed().as_secs_f64() < 1.0 {
            for (i, target) in targets.iter_mut().enumerate() {
                let default = robot.default_pose[i % robot.joints()] as f32;
                *target = default + noise[(i + step * 7919) % noise.len()];
            }
            for id in (step % 50..environments).step_by(50) {
                simulation.reset(&[id], &position, &velocity)?;
            }
            simulation.step(Drive::Targets(&targets))?;
            step += 1;
            control_steps += environments;
        }
        let physics = (control_steps * robot.substeps) as f64;
        rates.push((physics / (cpu_seconds()? - cpu_start), physics / start.elapsed().as_secs_f64()));
    }
    rates.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (per_core, wall) = rates[rates.len() / 2];
    println!(
        "{} x {environments}, {threads} threads: {per_core:.0} physics steps per core-second \
         ({:.0} control steps, {:.1} us per physics step); {wall:.0} per second of wall time",
        robot.name,
        per_core / robot.substeps as f64,
        1e6 / per_core,
    );
    Ok(())
}

/// Processor time of this process (s), from the kernel: other processes do not count.
fn cpu_seconds() -> Result<f64, Box<dyn std::error::Error>> {
    let stat = std::fs::read_to_string("/proc/self/stat")?;
    let fields: Vec<&str> = stat.rsplit(')').next().unwrap_or_default().split_whitespace().collect();
    let ticks = |i: usize| fields.get(i).and_then(|f| f.parse::<f64>().ok()).ok_or("unexpected /proc/self/stat");
    Ok((ticks(11)? + ticks(12)?) / 100.0)
}
