//! `lifelike studio`: a scene in a browser, where physics answers to every change.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::Arc;

use lifelike_robot::Robot;
use lifelike_studio::{Document, EXTENSION, Operation, Scene, Studio};
use serde_json::json;

use crate::bounds;
use crate::commands::stage;
use crate::error::CliError;
use crate::next::NextCommand;
use crate::output::Output;
use crate::shipped::{self, Kind};

/// Direct a robot in a browser: type sentences, drop clips, push, edit; physics answers at once.
///
/// The scene is a text (*.scene.toml) that is saved after every change. The page is served on this machine only, under an
/// address with a random word; a second address may only watch. Files are read and written below the scene's folder.
/// Every action of the page is an operation, which --do applies without a browser.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  lifelike studio
  lifelike studio examples/hello
  lifelike studio dance.scene.toml --do 'say text = \"a person waves\"' \\
      --do 'push at = 1, seconds = 0.2, body = \"pelvis\", newtons = [40, 0, 0]'
  lifelike play dance.scene.toml")]
pub struct Args {
    /// The scene, which is created where it is missing; or examples/NAME.
    #[arg(default_value = "untitled.scene.toml")]
    pub scene: PathBuf,
    /// Robot of a new scene: a name, or an MJCF or URDF file.
    #[arg(short, long)]
    pub robot: Option<String>,
    /// Policy of a new scene; the robot's own that comes with the program where not given.
    #[arg(long)]
    pub policy: Option<String>,
    /// Apply an operation to the scene and end, without a page; may be given several times.
    #[arg(long = "do", value_name = "OPERATION")]
    pub operations: Vec<String>,
    /// Print the address only.
    #[arg(long)]
    pub no_browser: bool,
    /// Let viewers watch, and nobody change the scene.
    #[arg(long)]
    pub read_only: bool,
    /// Port of this machine; any free one for 0.
    #[arg(long, default_value = "0", allow_hyphen_values = true)]
    pub port: String,
}

/// Runs the command.
pub fn run(args: &Args, output: &Output) -> Result<(), CliError> {
    let port = bounds::port("--port", &args.port)?;
    let file = match stage::file(&args.scene) {
        Ok(file) => file,
        Err(_) if args.scene.to_str().is_some_and(|text| text.ends_with(EXTENSION)) => args.scene.clone(),
        Err(error) => return Err(error),
    };
    if file.exists() && (args.robot.is_some() || args.policy.is_some()) {
        let message = "--robot and --policy are those of a new scene; change `robot` and `policy` in the file";
        return Err(CliError::Usage(format!("{}: {message}", file.display())));
    }
    let new = || Scene {
        robot: args.robot.clone().unwrap_or_else(|| Scene::default().robot),
        policy: args.policy.clone(),
        ..Scene::default()
    };
    let mut document = Document::open(&file, new)?;
    if !args.operations.is_empty() {
        for text in &args.operations {
            document.apply(Operation::parse(text)?)?;
        }
        document.save()?;
        let value = json!({ "scene": document.path(), "document": document.scene() });
        let next = NextCommand::new("play").word(file.display());
        let count = args.operations.len();
        return output.result(&value, || format!("{}: {count} operations\nnext: {next}\n", file.display()));
    }
    let stage = stage::open(document.scene(), &file)?;
    let whole = std::path::absolute(&file).unwrap_or_else(|_| file.clone());
    let command = Arc::new(move |scene: &Scene| on_robot(scene, &whole));
    let studio = Studio::new(stage, document, port, args.read_only, command)?;
    let [edit, watch] = studio.addresses();
    let value = json!({ "scene": file, "address": edit, "watch": watch });
    output.result(&value, || {
        let edit = if args.read_only { String::new() } else { format!("open in a browser: {edit}\n") };
        format!("{edit}to watch only:     {watch}\nCtrl-C ends it; {} is saved after every change", file.display())
    })?;
    if !args.no_browser {
        browse(if args.read_only { &watch } else { &edit });
    }
    Ok(studio.serve()?)
}

/// Returns the command line that runs a scene on a simulated robot, by the policy that performs it.
fn on_robot(scene: &Scene, file: &Path) -> String {
    let best = || Robot::load(&scene.robot).ok().and_then(|robot| shipped::of_robot(&robot, Kind::Controller));
    let policy = match &scene.policy {
        Some(name) if stage::folder(file).join(name).is_file() => stage::folder(file).join(name).display().to_string(),
        Some(name) => name.clone(),
        None => best().map_or_else(|| "CONTROLLER".into(), |network| network.stem().into()),
    };
    let line = NextCommand::new("run").word(policy).robot(&scene.robot);
    line.word("--bus").word("sim:127.0.0.1:9870").path("--scene", file).to_string()
}

/// Opens an address in the user's browser, where there is one.
fn browse(address: &str) {
    let (program, before): (&str, &[&str]) = match std::env::consts::OS {
        "macos" => ("open", &[]),
        "windows" => ("cmd", &["/C", "start", ""]),
        _ => ("xdg-open", &[]),
    };
    let mut command = Command::new(program);
    command.args(before).arg(address).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    if command.spawn().is_err() {
        tracing::info!("no browser was found; open the address yourself");
    }
}
