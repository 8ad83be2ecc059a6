//! `lifelike play`: a scene in physics, from start to end.

use std::path::PathBuf;
use std::time::Instant;

use lifelike_motion::container;
use lifelike_studio::{Scene, name_of};
use serde_json::json;

use crate::commands::stage;
use crate::error::CliError;
use crate::next::NextCommand;
use crate::output::{Output, fitted};

/// Play a scene in physics and print a verdict: survival, falls with their causes, errors.
///
/// The same scene gives the same bytes. Clips are read below the folder of the scene only.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  lifelike play examples/hello
  lifelike play dance.scene.toml -o runs/dance       # and a page and a clip
  lifelike play dance.scene.toml --json")]
pub struct Args {
    /// The scene (*.scene.toml), or examples/NAME.
    pub scene: PathBuf,
    /// Folder for the page that plays it and for the clip that physics made of it.
    #[arg(short, long, value_parser = crate::destination::folder)]
    pub output: Option<PathBuf>,
}

/// Runs the command.
pub fn run(args: &Args, output: &Output) -> Result<(), CliError> {
    let file = stage::file(&args.scene)?;
    let scene = Scene::load(&file)?;
    let stage = stage::open(&scene, &file)?;
    let name = name_of(&file);
    let began = Instant::now();
    let take = stage.perform(&scene).map_err(|error| Scene::located(&file, error))?;
    let took = began.elapsed().as_secs_f64();
    let evaluation = take.evaluation(&name);
    let mut files = Vec::new();
    if let Some(folder) = &args.output {
        std::fs::create_dir_all(folder).map_err(CliError::write(folder))?;
        let page = folder.join("report.html");
        take.page(&name).write(&page)?;
        let clip = folder.join(format!("{name}.motion.safetensors"));
        container::write(&clip, &take.clip(&name))?;
        files = vec![page, clip];
    }
    let seconds = (take.rollout().simulated.len() - 1) as f64 / take.rollout().fps;
    let value = json!({
        "scene": file, "robot": evaluation.robot, "seconds": seconds, "wall_seconds": took, "falls": take.falls,
        "blocks": take.built.spans, "evaluation": evaluation, "files": files,
    });
    output.result(&value, || {
        let falls: String = take.falls.iter().map(|fall| format!("{}\n", words(fall))).collect();
        let doubts = take.built.spans.iter().filter(|span| !span.doubt.is_empty());
        let doubts: String = doubts.map(|span| format!("block '{}': {}\n", span.id, span.doubt)).collect();
        let verdict = if take.falls.is_empty() { "stays on its feet" } else { "falls" };
        let next = match files.first() {
            Some(page) => format!("open this in a browser: {}\n", page.display()),
            None => format!("next: {}\n", NextCommand::new("studio").word(file.display())),
        };
        format!(
            "{}{doubts}{falls}'{name}' {verdict}: {seconds:.1} s in {took:.2} s\n{next}",
            fitted(&evaluation.table())
        )
    })
}

fn words(fall: &lifelike_studio::Fall) -> String {
    let why = if fall.why.is_empty() { String::new() } else { format!(": {}", fall.why) };
    format!("falls at {:.2} s, {}{why}", fall.second, fall.cause)
}
