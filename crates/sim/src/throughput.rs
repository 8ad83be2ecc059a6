//! Physics steps per second of an engine.

use std::time::Instant;

use rand::{Rng, SeedableRng};

use crate::error::SimError;
use crate::simulation::{Drive, Simulation};

/// Physics steps per second, over all environments.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Throughput {
    /// Per second of wall time.
    pub wall: f64,
    /// Per second of processor time, all threads together: what one core does, however busy the machine is. If the
    /// system does not tell processor time, wall time times threads is taken for it.
    pub core: f64,
}

/// Steps a simulation for some seconds, three times, and takes the median: noisy targets around the default pose, every
/// environment put back to `position` once a second of its own time, all outputs written.
///
/// # Errors
/// As [`Simulation::reset`] and [`Simulation::step`].
pub fn measure(
    simulation: &mut dyn Simulation,
    position: &[f64],
    threads: usize,
    seconds: f64,
) -> Result<Throughput, SimError> {
    const ROUNDS: usize = 3;
    let threads = match threads {
        0 => std::thread::available_parallelism().map_or(1, std::num::NonZero::get),
        n => n,
    };
    let robot = simulation.robot().clone();
    let velocity = vec![0.0; robot.character.nv];
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(1);
    let noise: Vec<f32> = (0..1 << 16).map(|_| rng.random_range(-0.1..0.1)).collect();
    let (n, joints) = (simulation.len(), robot.joints());
    let period = robot.control_hz.round().max(1.0) as usize;
    let mut targets = vec![0.0; n * joints];
    let mut rates = Vec::new();
    let mut step = 0;
    for round in 0..=ROUNDS {
        let (start, cpu, mut steps) = (Instant::now(), cpu_seconds(), 0);
        while start.elapsed().as_secs_f64() < seconds {
            for (i, target) in targets.iter_mut().enumerate() {
                *target = robot.default_pose[i % joints] as f32 + noise[(i + step * 7919) % noise.len()];
            }
            for id in (step % period..n).step_by(period) {
                simulation.reset(&[id], position, &velocity)?;
            }
            simulation.step(Drive::Targets(&targets))?;
            step += 1;
            steps += n * robot.substeps;
        }
        let wall = start.elapsed().as_secs_f64();
        // The kernel counts in ticks: less than a few say nothing.
        let cores = cpu.zip(cpu_seconds()).map(|(before, after)| after - before).filter(|cores| *cores > 0.05);
        let cores = cores.unwrap_or(wall * threads as f64);
        // The first round warms caches up and lets robots come to stand.
        if round > 0 {
            rates.push(Throughput { wall: steps as f64 / wall, core: steps as f64 / cores });
        }
    }
    rates.sort_by(|a, b| a.core.total_cmp(&b.core));
    Ok(rates[ROUNDS / 2])
}

/// Processor time of this process (s) where the kernel tells it: Linux.
fn cpu_seconds() -> Option<f64> {
    let stat = std::fs::read_to_string("/proc/self/stat").ok()?;
    let fields: Vec<&str> = stat.rsplit(')').next()?.split_whitespace().collect();
    let ticks = |i: usize| fields.get(i).and_then(|f| f.parse::<f64>().ok());
    // The kernel counts in hundredths of a second on every machine it runs on.
    Some((ticks(11)? + ticks(12)?) / 100.0)
}
