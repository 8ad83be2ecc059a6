//! `lifelike bench runtime`: evaluation through the runtime beside plain evaluation.

use std::path::PathBuf;
use std::sync::Arc;

use lifelike_character::rotation::from_wxyz;
use lifelike_character::{Quat, Vec3};
use lifelike_evaluation::fall::{HEIGHT_MARGIN, HEIGHT_SHARE, TILT};
use lifelike_evaluation::{Episode, EpisodeConditions, EvaluationOptions, EvaluationSuite};
use lifelike_robot::{Controller, ReferenceLibrary, Robot};
use lifelike_runtime::phase::Durations;
use lifelike_runtime::{Config, Phase, Playlist, Request, Supervisor, VirtualClock, drive};
use lifelike_sim::BatchState;
use rayon::prelude::*;
use serde_json::json;

use crate::commands::controller_file::Loaded;
use crate::commands::physics::{self, Physics};
use crate::commands::{clips, eval};
use crate::error::CliError;
use crate::output::{Output, table};
use crate::progress::Progress;
use crate::simulated_robot::{MemoryBus, SensorOptions, SimulatedRobot, stepwise};

/// Evaluate a policy through the runtime, beside plain evaluation of the same episodes.
///
/// Commands pass the gate at their own rate, and every physics step has the newest one. The root's state comes from
/// outside, or with --estimate from the runtime's estimator. Interpolation is the share of a policy step in which targets go over to new ones.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  lifelike bench runtime
  lifelike bench runtime --policy lima-blind --noise 0.002
  lifelike bench runtime --policy lima --noise 0.002 --imu-bias 0.01 --estimate
  lifelike bench runtime --policy lima-blind --engine mujoco
  lifelike bench runtime --policy runs/walk --motions data/lima --interpolation 0,0.5,1")]
pub struct Args {
    /// The controller.
    #[arg(short, long, default_value = "lima")]
    policy: PathBuf,
    /// The robot: a name, or an MJCF or URDF file; what the policy was trained for if not given.
    #[arg(short, long)]
    robot: Option<String>,
    /// Clips to follow.
    #[arg(short, long, num_args = 1.., default_value = "builtin")]
    motions: Vec<PathBuf>,
    #[command(flatten)]
    layout: clips::LayoutArgument,
    /// Longest episode (s).
    #[arg(long, default_value_t = 10.0)]
    seconds: f64,
    /// Episodes per clip.
    #[arg(long, default_value_t = 5)]
    starts: usize,
    /// Shares of a policy step in which targets go over.
    #[arg(long, value_delimiter = ',', default_values_t = [0.0, Config::default().interpolation, 1.0])]
    interpolation: Vec<f64>,
    /// Standard deviation of joint positions (rad); other sensors in proportion.
    #[arg(long, default_value_t = 0.0)]
    noise: f32,
    /// Bias of the gyroscope's axes (rad/s); the accelerometer has ten times (m/s²).
    #[arg(long, default_value_t = 0.0)]
    imu_bias: f32,
    /// Estimate the root's state from IMU and legs in place of its true state.
    #[arg(long)]
    estimate: bool,
    /// Engine and threads.
    #[command(flatten)]
    physics: Physics,
}

/// Outcome of one episode through the runtime.
#[derive(Debug, Clone, Default)]
struct Outcome {
    survived: bool,
    /// Clip and reason, where the gate braked.
    braked: Option<String>,
    /// Sum of joint errors (rad) and their number.
    error: f64,
    count: usize,
    hottest: f32,
}

/// Runs the command.
///
/// # Errors
/// Files or options are wrong, or the physics fails.
pub fn run(args: &Args, output: &Output) -> Result<(), CliError> {
    physics::available(&args.physics.engine)?;
    if !(args.seconds > 0.0 && args.seconds <= 3600.0 && (1..=eval::STARTS).contains(&args.starts)) {
        let most = eval::STARTS;
        return Err(CliError::Usage(format!("--seconds must be above 0 and at most 3600, --starts from 1 to {most}")));
    }
    let loaded = Loaded::load(&args.policy, args.robot.as_deref(), None)?;
    let robot = loaded.controller.robot();
    args.physics.require_ready(robot)?;
    let clips = clips::load_as(&args.motions, args.layout, robot)?;
    let options = EvaluationOptions { seconds: args.seconds, starts: args.starts, ..EvaluationOptions::default() };
    let simulate = |terrain, environments| args.physics.simulate(terrain, robot, environments);
    let setup = loaded.setup(&simulate);
    let suite = EvaluationSuite::new(&setup, &clips, &options)?;
    let simulation = args.physics.simulate(None, robot, suite.episodes().len().min(128))?;
    let plain = suite.run(simulation, |_| EpisodeConditions::default(), |_, _| {})?;
    let controller = Arc::new(loaded.controller.clone());
    let library = Arc::new(suite.library().clone());
    let mut rows = vec![vec![
        "plain evaluation".to_string(),
        format!("{:.1}", 100.0 * plain.overall.survival),
        format!("{:.2}", plain.overall.joint_error_deg),
        String::new(),
        String::new(),
    ]];
    let (mut values, mut reasons) = (Vec::new(), Vec::new());
    let total = (args.interpolation.len() * suite.episodes().len()) as u64;
    let progress = std::sync::Mutex::new((0, Progress::new(output, "evaluating through the runtime", total)));
    let fine = Arc::new(stepwise(robot)?);
    for &interpolation in &args.interpolation {
        let durations = Durations { stand: 0.0, blend_in: 0.0, blend_out: 0.0, damp: 0.0, ..Durations::default() };
        let config = Config { interpolation, durations, ..Config::default() };
        config.check()?;
        let one = |episode: &Episode| {
            let outcome = through_runtime(args, &controller, &library, &fine, &config, episode);
            if let Ok(mut progress) = progress.lock() {
                progress.0 += 1;
                let done = progress.0;
                progress.1.update(done, total, String::new);
            }
            outcome
        };
        let outcomes = suite.episodes().par_iter().map(one).collect::<Result<Vec<_>, _>>()?;
        let share =
            |is: fn(&Outcome) -> bool| outcomes.iter().filter(|o| is(o)).count() as f64 / outcomes.len().max(1) as f64;
        let survival = share(|outcome| outcome.survived);
        let tripped = share(|outcome| outcome.braked.is_some());
        let error = joint_error_deg(&outcomes);
        let braked: Vec<&String> = outcomes.iter().filter_map(|outcome| outcome.braked.as_ref()).collect();
        let hottest = outcomes.iter().map(|outcome| outcome.hottest).fold(0.0, f32::max);
        rows.push(vec![
            format!("runtime, interpolation {interpolation}"),
            format!("{:.1}", 100.0 * survival),
            format!("{error:.2}"),
            format!("{:.1}", 100.0 * tripped),
            format!("{:.0}", 100.0 * hottest),
        ]);
        values.push(json!({ "interpolation": interpolation, "survival": survival, "joint_error_deg": error,
            "braked": braked, "hottest": hottest }));
        reasons.extend(braked.into_iter().map(|reason| format!("interpolation {interpolation}: {reason}\n")));
    }
    if let Ok((_, progress)) = progress.into_inner() {
        progress.finish();
    }
    let value = json!({ "episodes": suite.episodes().len(), "plain": plain.overall, "runtime": values });
    output.result(&value, || {
        let head = ["", "survival (%)", "joint error (deg)", "gate braked (%)", "hottest motor (%)"];
        let reasons = reasons.concat();
        format!("{} episodes of {} s\n{}{reasons}", suite.episodes().len(), args.seconds, table(&head, &rows))
    })
}

/// Returns the mean over all frames (deg), as plain evaluation pools them: long episodes count for more.
fn joint_error_deg(outcomes: &[Outcome]) -> f64 {
    let count: usize = outcomes.iter().map(|outcome| outcome.count).sum();
    (outcomes.iter().map(|outcome| outcome.error).sum::<f64>() / count.max(1) as f64).to_degrees()
}

/// Runs one episode through the runtime, from the state of its frame.
fn through_runtime(
    args: &Args,
    controller: &Arc<Controller>,
    library: &Arc<ReferenceLibrary>,
    fine: &Arc<Robot>,
    config: &Config,
    episode: &Episode,
) -> Result<Outcome, CliError> {
    let robot = controller.robot();
    let one_thread = Physics { threads: 1, ..args.physics.clone() };
    let options = SensorOptions {
        noise: args.noise,
        bias: args.imu_bias,
        seed: episode.number as u64,
        battery: 24.0,
        has_external: !args.estimate,
        gantry: 0.0,
    };
    let mut machine = SimulatedRobot::new(robot, one_thread.simulate(None, fine, 1)?, options);
    let (mut q, mut v) = (vec![0.0; robot.character.nq], vec![0.0; robot.character.nv]);
    let [x, y, _] = library.position_at(episode.frame);
    let place = [f64::from(x), f64::from(y)];
    library.write_state(episode.frame, robot, place, 0.0, &mut q, &mut v);
    machine.simulation_mut().reset(&[0], &q, &v)?;
    let last = episode.frame + episode.planned - 1;
    let motions = Playlist::of(Arc::clone(library), vec![(episode.frame, last)]);
    let mut supervisor = Supervisor::new(Arc::clone(controller), motions, config.clone())?;
    let ticks_per_step = config.ticks_per_step(robot.control_hz)?;
    let bus = std::cell::RefCell::new(MemoryBus::new(machine, config.command_hz));
    bus.borrow_mut().settle();
    let mut outcome = Outcome { survived: true, ..Outcome::default() };
    let mut tick = 0;
    // The loop asks at the beginning of a tick: the state is that after the ticks before.
    let summary = drive(&mut supervisor, &mut Shared(&bus), &mut VirtualClock::default(), None, |_, phase| {
        let frame = episode.frame + tick / ticks_per_step;
        if tick > 0 && tick % ticks_per_step == 0 && frame <= last {
            let mut bus = bus.borrow_mut();
            let state = bus.robot().simulation().state();
            if has_fallen(library, frame, state) || state.diverged[0] {
                outcome.survived = false;
                return None;
            }
            let pairs = state.joint_position.iter().zip(library.joints_at(frame));
            outcome.error += pairs.map(|(a, b)| f64::from((a - b).abs())).sum::<f64>() / robot.joints() as f64;
            outcome.count += 1;
        }
        tick += 1;
        let is_over = frame >= last || (tick > 1 && phase == Phase::Idle);
        (!is_over).then_some(Request::Run)
    });
    outcome.braked = summary.trip.map(|trip| {
        let seconds = trip.time as f64 * 1e-9;
        let clip = &library.names[library.clip_of(episode.frame)];
        format!("{clip}, after {seconds:.2} s: {}", trip.words(&robot.layout.joints))
    });
    outcome.survived &= outcome.braked.is_none();
    outcome.hottest = summary.hottest;
    Ok(outcome)
}

/// The rule of `lifelike_evaluation::fall`, on level ground.
fn has_fallen(library: &ReferenceLibrary, frame: usize, state: &BatchState) -> bool {
    let asked = library.position_at(frame)[2];
    let done = state.root_position[2];
    let up = |q: [f32; 4]| from_wxyz(q.map(f64::from)).map(|q: Quat| q.inverse() * Vec3::z());
    let own = &state.root_orientation;
    let tilt = match (up(library.orientation_at(frame)), up([own[0], own[1], own[2], own[3]])) {
        (Some(a), Some(b)) => a.angle(&b),
        _ => f64::INFINITY,
    };
    let (asked, done) = (f64::from(asked), f64::from(done));
    tilt > TILT || (done < HEIGHT_SHARE * asked && done < asked - HEIGHT_MARGIN)
}

/// A bus that is looked at between ticks.
struct Shared<'a>(&'a std::cell::RefCell<MemoryBus>);

impl lifelike_runtime::Bus for Shared<'_> {
    fn facts(&mut self) -> Result<lifelike_runtime::Facts, lifelike_runtime::RuntimeError> {
        self.0.borrow_mut().facts()
    }
    fn receive(&mut self, into: &mut lifelike_runtime::Measurement) -> std::io::Result<bool> {
        self.0.borrow_mut().receive(into)
    }
    fn send(&mut self, command: &lifelike_runtime::SafeCommand) -> std::io::Result<()> {
        self.0.borrow_mut().send(command)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_are_pooled_over_frames() {
        // Three frames of 2 rad and one of 6 rad: 3 rad, where the mean of the two episodes would be 4 rad.
        let outcomes = [(6.0, 3), (6.0, 1)].map(|(error, count)| Outcome { error, count, ..Outcome::default() });
        assert!((joint_error_deg(&outcomes) - 3.0_f64.to_degrees()).abs() < 1e-12);
        assert_eq!(joint_error_deg(&[]), 0.0);
    }
}
