//! Times the tracking environments without any network: what one step of one environment costs of one core.
//!
//! ```text
//! cargo run --release -p lifelike-tracking --example environment -- experiments/track-all.toml 600
//! ```
//!
//! Plan and number of steps are arguments; the clips are our own keyframed ones. All of the curriculum is in force, and
//! actions are noise of the size that a policy has after its first minutes. Times are the process' own (Linux counts them),
//! so other programs disturb them little. With a third argument, `still`, nothing moves: for a profile of all but physics.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

use lifelike_nn::normalizer::RunningNormalizer;
use lifelike_robot::{ReferenceLibrary, Robot, clips};
use lifelike_sim::constraint_wrenches::ConstraintWrenches;
use lifelike_sim::{
    BatchState, Drive, EnvironmentParameters, IntegrationState, LifelikeSimulation, SimError, Simulation, Terrain,
};
use lifelike_tracking::{Environment, StepOutcome, TrackerPlan};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};

/// A simulation that counts the time it takes itself: steps, and the beginnings of episodes.
struct Timed {
    simulation: LifelikeSimulation,
    spent: Arc<[AtomicU64; 2]>,
    still: bool,
    /// Parameters that wait for the reset which follows them, so that both are timed together.
    parameters: Vec<(usize, EnvironmentParameters)>,
}

impl Timed {
    fn timed<T>(&mut self, what: usize, work: impl FnOnce(&mut LifelikeSimulation) -> T) -> T {
        let begin = processor_time();
        let result = work(&mut self.simulation);
        self.spent[what].fetch_add(processor_time() - begin, Ordering::Relaxed);
        result
    }
}

impl Simulation for Timed {
    fn engine(&self) -> &str {
        self.simulation.engine()
    }
    fn robot(&self) -> &Arc<Robot> {
        self.simulation.robot()
    }
    fn len(&self) -> usize {
        self.simulation.len()
    }
    fn terrain(&self) -> Option<&Arc<Terrain>> {
        self.simulation.terrain()
    }
    fn state(&self) -> &BatchState {
        self.simulation.state()
    }
    fn reset(&mut self, ids: &[usize], positions: &[f64], velocities: &[f64]) -> Result<(), SimError> {
        let parameters = std::mem::take(&mut self.parameters);
        self.timed(1, |simulation| {
            parameters.into_iter().try_for_each(|(id, parameters)| simulation.set_parameters(id, parameters))?;
            simulation.reset(ids, positions, velocities)
        })
    }
    fn set_parameters(&mut self, id: usize, parameters: EnvironmentParameters) -> Result<(), SimError> {
        self.parameters.push((id, parameters));
        Ok(())
    }
    fn push(&mut self, id: usize, body: usize, force_w: [f32; 3], torque_w: [f32; 3]) -> Result<(), SimError> {
        self.simulation.push(id, body, force_w, torque_w)
    }
    fn clear_pushes(&mut self, id: usize) {
        self.simulation.clear_pushes(id);
    }
    fn step(&mut self, drive: Drive<'_>) -> Result<(), SimError> {
        if self.still { Ok(()) } else { self.timed(0, |simulation| simulation.step(drive)) }
    }
    fn constraint_wrenches(&mut self, drive: Drive<'_>) -> Result<ConstraintWrenches, SimError> {
        self.simulation.constraint_wrenches(drive)
    }
    fn save(&self) -> IntegrationState {
        self.simulation.save()
    }
    fn restore(&mut self, state: &IntegrationState) -> Result<(), SimError> {
        self.simulation.restore(state)
    }
}

/// Returns the time (ns) that this process' threads have had of the processors; the wall's where nobody counts it.
fn processor_time() -> u64 {
    // The time of a thread that runs is counted when it gives way.
    std::thread::yield_now();
    let of = |entry: std::fs::DirEntry| -> Option<u64> {
        std::fs::read_to_string(entry.path().join("schedstat")).ok()?.split(' ').next()?.parse().ok()
    };
    match std::fs::read_dir("/proc/self/task") {
        Ok(tasks) => tasks.filter_map(Result::ok).filter_map(of).sum(),
        Err(_) => {
            static START: std::sync::OnceLock<Instant> = std::sync::OnceLock::new();
            START.get_or_init(Instant::now).elapsed().as_nanos() as u64
        }
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let plan = arguments.next().unwrap_or_else(|| "experiments/track-all.toml".into());
    let steps: usize = arguments.next().map_or(Ok(600), |n| n.parse())?;
    let still = arguments.next().is_some_and(|word| word == "still");
    let mut plan = TrackerPlan::read(Path::new(&plan))?;
    plan.curriculum = Default::default();
    let n = plan.ppo.environments;

    let robot = Arc::new(Robot::load(&plan.robot)?);
    let library = Arc::new(ReferenceLibrary::new(&robot, &clips::builtin(&robot).clips, None)?);
    let spent: Arc<[AtomicU64; 2]> = Arc::default();
    let simulation = LifelikeSimulation::new(Arc::clone(&robot), n, 1)?;
    let simulation = Timed { simulation, spent: Arc::clone(&spent), still, parameters: Vec::new() };
    let mut environment = Environment::new(&plan, Arc::clone(&robot), library, Box::new(simulation))?;

    let sizes = [environment.actor_size(), environment.critic_size()];
    let mut seen = sizes.map(RunningNormalizer::new);
    let mut rows = sizes.map(|_| Vec::new());
    let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(1);
    let mut actions = vec![0.0_f32; n * robot.joints()];
    let mut outcome = StepOutcome::default();
    let (mut noise, mut stepping, mut normalising) = (0, 0, 0);
    let before = spent.each_ref().map(|x| x.load(Ordering::Relaxed));
    for _ in 0..steps {
        let begin = processor_time();
        actions.iter_mut().for_each(|y| {
            let z: f32 = StandardNormal.sample(&mut random);
            *y = 0.3 * z;
        });
        noise += processor_time() - begin;

        let begin = processor_time();
        environment.step(&actions, &mut outcome)?;
        stepping += processor_time() - begin;

        let begin = processor_time();
        for ((seen, rows), now) in
            seen.iter_mut().zip(&mut rows).zip([environment.actor_rows(), environment.critic_rows()])
        {
            seen.update(now);
            rows.clear();
            seen.append_normalized(now, rows);
        }
        normalising += processor_time() - begin;
    }
    let [physics, reset] = [0, 1].map(|i| spent[i].load(Ordering::Relaxed) - before[i]);
    let around = stepping - physics - reset;
    let [_, length] = environment.statistics().recent();
    println!(
        "{n} environments of {}, {steps} steps, {} and {} numbers, episodes of {length:.0} steps",
        robot.name, sizes[0], sizes[1]
    );
    for (what, spent) in [
        ("physics: steps", physics),
        ("physics: beginnings of episodes", reset),
        ("noise of the actions", noise),
        ("moments, copies, normalising", normalising),
        ("the environment around", around),
        ("all but physics", around + noise + normalising),
    ] {
        println!("{what:32} {:8.0} ns per environment step", spent as f64 / (n * steps) as f64);
    }
    Ok(())
}
