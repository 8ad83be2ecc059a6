//! `lifelike replay`: the controller of a record sees its packets again, and must send the same bytes.

use std::path::{Path, PathBuf};

use lifelike_motion::container;
use lifelike_robot::GetUpScript;
use lifelike_runtime::record::{Attachment, Record};
use lifelike_runtime::replay::replay;
use serde_json::json;

use crate::commands::controller_file::Loaded;
use crate::commands::run::{Prepared, SCRIPT};
use crate::error::CliError;
use crate::output::Output;

/// Replay a record: check that the same controller sends the same commands, bit for bit.
///
/// A record contains the controller, the clips, the settings and every packet, so nothing else is needed. The first
/// difference is named with its tick and joint. With --policy, another controller sees the same packets.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  lifelike replay walk.mcap
  lifelike replay walk.mcap --policy runs/walk     # another controller: where does it differ?
  lifelike --json replay walk.mcap | jq .difference")]
pub struct Args {
    /// The record: what `lifelike run --record` writes.
    pub record: PathBuf,
    /// Another controller than that of the record.
    #[arg(long)]
    pub policy: Option<PathBuf>,
    /// The robot, where the record was made with a file that is elsewhere now.
    #[arg(short, long)]
    pub robot: Option<String>,
}

/// Runs the command.
///
/// # Errors
/// The record is damaged, or a command differs.
pub fn run(args: &Args, output: &Output) -> Result<(), CliError> {
    let record = Record::read(&args.record)?;
    let prepared = prepared(&record, args.policy.as_deref(), args.robot.as_deref())?;
    let mut supervisor = prepared.supervisor()?;
    if args.policy.is_none() && supervisor.motions().digest() != record.meta("motions")? {
        return Err(CliError::Input(format!(
            "{}: expected the reference of the record, got another one from its clips; replay it with the version \
             that recorded it",
            args.record.display()
        )));
    }
    let outcome = replay(&record, &mut supervisor);
    let value = json!({ "ticks": outcome.ticks, "packets": outcome.packets, "difference": outcome.difference,
        "cut_off": record.is_cut_off });
    let cut = if record.is_cut_off { "; the record was cut off" } else { "" };
    match &outcome.difference {
        None => output.result(&value, || {
            format!("{} ticks and {} packets: every command has the same bits{cut}\n", outcome.ticks, outcome.packets)
        }),
        Some(difference) => {
            output.result(&value, String::new)?;
            Err(CliError::Failed(format!(
                "tick {} ({:.3} s), {}: recorded {}, replayed {}{cut}",
                difference.tick, difference.seconds, difference.what, difference.recorded, difference.replayed
            )))
        }
    }
}

/// Makes a run of what a record holds.
pub(super) fn prepared(record: &Record, policy: Option<&Path>, robot: Option<&str>) -> Result<Prepared, CliError> {
    let bad =
        |what: &str| CliError::Input(format!("{}: expected {what} in the record, got none", record.path.display()));
    let robot =
        robot.map(str::to_string).or_else(|| record.metadata.get("robot").cloned()).filter(|name| !name.is_empty());
    let loaded = match policy {
        Some(path) => Loaded::load(path, robot.as_deref(), None)?,
        None => {
            let is_clip = |attachment: &&Attachment| attachment.name.ends_with(container::EXTENSION);
            let file = record.attachments.iter().find(|file| !is_clip(file)).ok_or_else(|| bad("a controller"))?;
            // Readers of controllers take files.
            let folder = tempfile::tempdir().map_err(|error| CliError::Failed(error.to_string()))?;
            let name = Path::new(&file.name).file_name().ok_or_else(|| bad("a controller"))?;
            let path = folder.path().join(name);
            crate::output::write(&path, &file.bytes)?;
            Loaded::load(&path, robot.as_deref(), None)?
        }
    };
    let clips = record
        .attached(container::EXTENSION)
        .map(|clip| Ok(container::from_bytes(&clip.bytes, Path::new(&clip.name))?))
        .collect::<Result<Vec<_>, CliError>>()?;
    let config = serde_json::from_str(record.meta("config")?).map_err(|_| bad("settings"))?;
    let standing = record.meta("standing")?.parse().map_err(|_| bad("the time of standing"))?;
    let script = record.attached(SCRIPT).next().map(|file| GetUpScript::parse(&String::from_utf8_lossy(&file.bytes)));
    Ok(Prepared { loaded, clips, config, standing, get_up: script.transpose()? })
}
