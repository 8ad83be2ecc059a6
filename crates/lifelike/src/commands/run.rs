//! `lifelike run`: a controller on a machine.

use std::collections::BTreeMap;
use std::io::IsTerminal;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use lifelike_motion::{MotionClip, container};
use lifelike_robot::GetUpScript;
use lifelike_runtime::record::{Attachment, Recorder};
use lifelike_runtime::timing::Quantiles;
use lifelike_runtime::{
    Bus, Clock, Config, Facts, Limits, Phase, Playlist, Request, Summary, Supervisor, drive, handshake, scheduling,
    wiggle,
};
use serde_json::json;

use self::scene::SceneMotion;
use crate::commands::bus::{self, Connection};
use crate::commands::controller_file::Loaded;
use crate::commands::export::Source;
use crate::commands::{clips, script};
use crate::error::CliError;
use crate::next::{self, NextCommand};
use crate::output::{Output, table};

mod scene;

/// Run a controller on a robot: refuse mismatches, limit every command, record everything.
///
/// The machine is asked what it is, and refused with a line for each difference from the controller's robot. It stands
/// up, the policy follows the motions, and motors brake at the end. A scene is followed as `lifelike play` composes it;
/// its pushes and switches are left out, and motion that no robot can follow is refused. A gate limits position, speed, acceleration and
/// torque of every command. It brakes when the robot tilts, packets are late or lost, a motor is hot or the stop
/// button is pressed. Ctrl-C blends out; Enter brakes at once.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  lifelike run lima-blind --bus sim:127.0.0.1:9870     # after: lifelike simulate-robot lima
  lifelike run runs/walk --bus sim:127.0.0.1:9870 --motions walk.motion.safetensors
  lifelike run lima-blind --bus sim:127.0.0.1:9870 --scene dance.scene.toml    # or examples/hello
  lifelike run lima-blind --bus sim:127.0.0.1:9870 --record walk.mcap
  lifelike run lima-blind --bus sim:127.0.0.1:9870 --get-up lima
  lifelike run lima-blind --bus sim:127.0.0.1:9870 --wiggle     # on a stand: tries every motor
  lifelike run lima-blind --bus replay:walk.mcap                # packets of a record
  lifelike run lima-blind --bus dynamixel:/dev/ttyUSB0,imu=0.0.0.0:9871   # servos of servos.toml
  lifelike run g1-deploy --bus unitree:eth0                     # a G1; needs a build with DDS
  lifelike run lima-blind --bus ros2:0,imu=/imu                 # a robot under ROS 2

Settings (TOML) and their defaults: lifelike run --print-settings")]
pub struct Args {
    /// The controller: its file, the folder of a run, or the name of one that comes with the program.
    #[arg(required_unless_present = "print_settings")]
    pub controller: Option<PathBuf>,
    /// The machine: sim:HOST:PORT (UDP), replay:FILE (a record), dynamixel:PORT (servos), unitree:INTERFACE or ros2:DOMAIN (DDS).
    #[arg(long, required_unless_present = "print_settings")]
    pub bus: Option<String>,
    /// The robot: a name, or an MJCF or URDF file; what the policy was trained for if not given.
    #[arg(short, long)]
    pub robot: Option<String>,
    /// Clips to follow, one after the other; without them the robot stands.
    #[arg(short, long, num_args = 1..)]
    pub motions: Vec<PathBuf>,
    /// Layout of the motion.
    #[command(flatten)]
    pub layout: clips::LayoutArgument,
    /// Scene of `lifelike studio` whose motion to follow (*.scene.toml), or examples/NAME.
    #[arg(long, value_name = "SCENE", conflicts_with_all = ["motions", "layout"])]
    pub scene: Option<PathBuf>,
    /// Time of standing before and after the clips (s).
    #[arg(long, default_value_t = 1.0)]
    pub standing: f64,
    /// Get up after a fall and go on: a script (TOML), or the name of a robot that has one. Without it the robot brakes and the
    /// run ends.
    #[arg(long, value_name = "SCRIPT")]
    pub get_up: Option<PathBuf>,
    /// File of settings (TOML): rate, phases, limits.
    #[arg(long, value_name = "FILE")]
    pub settings: Option<PathBuf>,
    /// Record the run in a new file (MCAP).
    #[arg(long, value_name = "FILE")]
    pub record: Option<PathBuf>,
    /// Try every motor by a small motion on a stand, and do nothing else.
    #[arg(long)]
    pub wiggle: bool,
    /// Print the settings and their defaults.
    #[arg(long)]
    pub print_settings: bool,
}

/// Name of the get-up script in a record.
pub(super) const SCRIPT: &str = "get-up.toml";

/// Everything that a run is made of.
pub(super) struct Prepared {
    pub(super) loaded: Loaded,
    pub(super) clips: Vec<MotionClip>,
    pub(super) config: Config,
    pub(super) standing: f64,
    pub(super) get_up: Option<GetUpScript>,
}

impl Prepared {
    /// Makes the supervisor.
    pub(super) fn supervisor(&self) -> Result<Supervisor, CliError> {
        let controller = Arc::new(self.loaded.controller.clone());
        let motions = Playlist::new(&controller, &self.clips, self.standing)?;
        let supervisor = Supervisor::new(controller, motions, self.config.clone())?;
        Ok(match &self.get_up {
            Some(script) => supervisor.with_get_up(script)?,
            None => supervisor,
        })
    }
}

/// Runs the command.
///
/// # Errors
/// The machine is not the controller's; a file cannot be read or written; the gate braked.
pub fn run(args: &Args, output: &Output) -> Result<(), CliError> {
    let (Some(controller), Some(bus)) = (&args.controller, &args.bus) else {
        let defaults = toml::to_string(&Config::default()).map_err(|error| CliError::Failed(error.to_string()))?;
        return output.result(&Config::default(), || defaults);
    };
    if !(0.0..=3600.0).contains(&args.standing)
        || (args.standing == 0.0 && args.motions.is_empty() && args.scene.is_none())
    {
        return Err(CliError::Usage(format!(
            "--standing: expected 0 to 3600 s, and above 0 without --motions or --scene, got {}",
            args.standing
        )));
    }
    let loaded = Loaded::load(controller, args.robot.as_deref(), None)?;
    let scene =
        args.scene.as_deref().map(|scene| SceneMotion::of(scene, &loaded.controller, controller)).transpose()?;
    let left_out = scene.as_ref().map_or_else(Vec::new, |scene| scene.left_out.clone());
    left_out.iter().for_each(|line| tracing::warn!("{line}"));
    let clips = match scene {
        Some(scene) => vec![scene.clip],
        None if args.motions.is_empty() => Vec::new(),
        None => clips::load_as(&args.motions, args.layout, loaded.controller.robot())?,
    };
    let config = match &args.settings {
        Some(path) => settings(path)?,
        None => {
            let default = Config::default();
            let suits = bus::command_hz(bus, loaded.controller.robot())?;
            Config { command_hz: suits.unwrap_or(default.command_hz), ..default }
        }
    };
    let get_up = args.get_up.as_deref().map(script::read).transpose()?;
    let prepared = Prepared { loaded, clips, config, standing: args.standing, get_up };
    let mut supervisor = prepared.supervisor()?;
    let Connection { mut bus, mut clock } = bus::connect(bus, prepared.loaded.controller.robot(), &prepared.config)?;
    let facts = bus.facts()?;
    handshake::check(supervisor.controller(), &facts, supervisor.config())?;
    if args.wiggle {
        return wiggled(&prepared, bus.as_mut(), clock.as_mut(), output);
    }
    let recorder = args.record.as_deref().map(|path| begin_record(path, args, &prepared, controller, &facts));
    let mut recorder = recorder.transpose()?;
    let stop = crate::interrupt::flag()?;
    let brake = listen_for_enter();
    let ask = |_: u64, _: Phase| {
        Some(match (brake.load(Ordering::Relaxed), stop.load(Ordering::Relaxed)) {
            (true, _) => Request::Damp,
            (_, true) => Request::Stop,
            _ => Request::Run,
        })
    };
    scheduling::real_time().iter().for_each(|line| tracing::warn!("{line}"));
    // A robot that never answers ends the run, too.
    let patience = (3.0 * supervisor.config().command_hz) as u64;
    let mut idle = 0;
    let patient = |now, phase| {
        idle += u64::from(phase == Phase::Idle);
        if idle > patience { None } else { ask(now, phase) }
    };
    let summary = drive(&mut supervisor, bus.as_mut(), clock.as_mut(), recorder.as_mut(), patient);
    if let Some(recorder) = recorder {
        recorder.finish()?;
    }
    report(args, &left_out, &supervisor, &summary, output)
}

/// Prints the account; a run that the gate ended is a failure.
fn report(
    args: &Args,
    left_out: &[String],
    supervisor: &Supervisor,
    summary: &Summary,
    output: &Output,
) -> Result<(), CliError> {
    let joints = &supervisor.controller().robot().layout.joints;
    let reason = summary.trip.map(|trip| trip.words(joints));
    let next: Vec<NextCommand> = args
        .record
        .iter()
        .flat_map(|record| {
            [
                NextCommand::new("replay").word(record.display()),
                NextCommand::new("augment report").word(record.display()),
            ]
        })
        .collect();
    let value = json!({ "summary": summary, "trip": reason, "record": args.record, "left_out": left_out,
        "next": next::texts(&next) });
    output.result(&value, || format!("{}{}", text(summary), next::lines(&next)))?;
    match (reason, supervisor.failed()) {
        (_, Some(error)) => Err(CliError::Input(error.to_string())),
        (Some(reason), None) => Err(CliError::Failed(format!("the gate braked: {reason}"))),
        (None, None) if summary.steps == 0 => Err(CliError::Failed(
            "the policy made no step: expected measurements from the machine within 3 s, or was stopped before".into(),
        )),
        (None, None) => Ok(()),
    }
}

/// Returns the account as tables.
fn text(summary: &Summary) -> String {
    let row = |name: &str, q: &Quantiles| {
        let numbers = [q.mean_us, q.p50_us, q.p99_us, q.p999_us, q.max_us].map(|x| format!("{x:.1}"));
        [vec![name.to_string(), q.count.to_string()], numbers.to_vec()].concat()
    };
    let rows = [
        row("wake-up after the deadline", &summary.latency),
        row("period", &summary.period),
        row("tick", &summary.tick),
        row("tick with policy step", &summary.step),
    ];
    let packets = &summary.packets;
    format!(
        "{}{} ticks, {} missed; {} policy steps\n\
         packets: {} used, {} lost, {} repeated, {} reordered, {} not finite\n\
         hottest motor: {:.0}% of its continuous rating\n{}",
        table(&["time (µs)", "count", "mean", "p50", "p99", "p99.9", "max"], &rows),
        summary.ticks,
        summary.missed,
        summary.steps,
        packets.used,
        packets.lost,
        packets.repeated,
        packets.reordered,
        packets.non_finite,
        100.0 * summary.hottest,
        if summary.falls > 0 { format!("falls: {}\n", summary.falls) } else { String::new() },
    )
}

/// Tries every motor on a stand.
fn wiggled(prepared: &Prepared, bus: &mut dyn Bus, clock: &mut dyn Clock, output: &Output) -> Result<(), CliError> {
    let robot = prepared.loaded.controller.robot();
    let joints = &robot.layout.joints;
    let config = &prepared.config;
    let limits = Limits::of(robot, config.limits.clone())?;
    scheduling::real_time().iter().for_each(|line| tracing::warn!("{line}"));
    let (responses, trip) = wiggle::identify(joints, limits, config.command_hz, bus, clock);
    let defects = wiggle::defects(&responses, joints);
    let trip = trip.map(|trip| trip.words(joints));
    let value = json!({ "responses": responses, "defects": defects, "trip": trip });
    output.result(&value, || {
        let rows: Vec<Vec<String>> = responses
            .iter()
            .enumerate()
            .map(|(i, response)| vec![response.joint.clone(), format!("{:.0}", 100.0 * response.encoders[i])])
            .collect();
        table(&["motor", "response of its encoder (%)"], &rows)
    })?;
    match (trip, defects.is_empty()) {
        (None, true) => Ok(()),
        (trip, _) => {
            let braked = trip.map(|trip| format!("the gate braked: {trip}"));
            Err(CliError::Input(defects.into_iter().chain(braked).collect::<Vec<_>>().join("\n  ")))
        }
    }
}

/// Reads settings.
fn settings(path: &Path) -> Result<Config, CliError> {
    let text =
        std::fs::read_to_string(path).map_err(|error| CliError::Input(format!("{}: {error}", path.display())))?;
    Config::from_toml(&text).map_err(|error| CliError::Input(format!("{}: {error}", path.display())))
}

/// Begins a record that holds all that a replay needs.
fn begin_record(
    path: &Path,
    args: &Args,
    prepared: &Prepared,
    controller: &Path,
    facts: &Facts,
) -> Result<Recorder, CliError> {
    let json = |value: serde_json::Result<String>| value.map_err(|error| CliError::Failed(error.to_string()));
    let robot = prepared.loaded.controller.robot();
    let Source { policy, .. } = Source::of(controller)?;
    let metadata = BTreeMap::from([
        ("format".to_string(), "lifelike-record 1".to_string()),
        ("joints".to_string(), json(serde_json::to_string(&robot.layout.joints))?),
        ("robot".to_string(), args.robot.clone().unwrap_or_default()),
        ("facts".to_string(), json(serde_json::to_string(facts))?),
        ("config".to_string(), json(serde_json::to_string(&prepared.config))?),
        ("standing".to_string(), prepared.standing.to_string()),
        ("motions".to_string(), prepared.supervisor()?.motions().digest()),
        ("version".to_string(), env!("CARGO_PKG_VERSION").to_string()),
    ]);
    let bytes = std::fs::read(&policy).map_err(|error| CliError::Input(format!("{}: {error}", policy.display())))?;
    let name = policy.file_name().map_or("controller".into(), |name| name.to_string_lossy().into_owned());
    let mut attachments = vec![Attachment { name, bytes }];
    for clip in &prepared.clips {
        let name = format!("{}{}", clip.name, container::EXTENSION);
        attachments.push(Attachment { name, bytes: container::to_bytes(clip)? });
    }
    if let Some(script) = &prepared.get_up {
        let text = toml::to_string(script).map_err(|error| CliError::Failed(error.to_string()))?;
        attachments.push(Attachment { name: SCRIPT.into(), bytes: text.into_bytes() });
    }
    Ok(Recorder::create(path, robot.joints(), metadata, &attachments)?)
}

/// Returns a flag that Enter sets, where somebody sits at a terminal.
fn listen_for_enter() -> Arc<AtomicBool> {
    let flag = Arc::new(AtomicBool::new(false));
    if std::io::stdin().is_terminal() {
        let seen = Arc::clone(&flag);
        std::thread::spawn(move || {
            if std::io::stdin().read_line(&mut String::new()).is_ok() {
                seen.store(true, Ordering::Relaxed);
            }
        });
    }
    flag
}
