//! `lifelike motion search`: windows of motion that are alike (thesis Fig. 4.3).

use std::path::PathBuf;

use lifelike_motion::MotionClip;
use lifelike_representation::latent::Codes;
use lifelike_representation::latent::search::{Hit, Origin, SearchSpec, search};
use lifelike_robot::Robot;
use serde_json::{Value, json};

use crate::commands::{clips, prior_file};
use crate::error::CliError;
use crate::output::{Output, table};

/// Find the windows of motion most similar to one of a clip, by the cosine of their latent codes.
///
/// The query may be one of the searched motions; its own surroundings are then left out. It may also be any other clip,
/// such as captured motion that was not used in training.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  lifelike motion search data/lima/cmu_amc/02_01.motion.safetensors --at 1.2 \\
      --prior lima --motions data/lima/deepmimic -k 5
  lifelike motion search kick.bvh --at 0.8 --prior lima --motions @clips.txt --json

Motions may be *.motion.safetensors, or captured motion and keyframes, which are retargeted on the way.")]
pub struct Args {
    /// The clip to search for.
    pub query: PathBuf,
    /// Middle of the window in it (s).
    #[arg(long)]
    pub at: f64,
    /// The motion prior whose codes are compared.
    #[arg(long)]
    pub prior: PathBuf,
    /// Clips to search: files, folders, patterns, or @list.txt with one of them per line.
    #[arg(short, long, required = true, num_args = 1..)]
    pub motions: Vec<PathBuf>,
    /// Layout of the motion.
    #[command(flatten)]
    pub layout: clips::LayoutArgument,
    /// Most hits.
    #[arg(short = 'k', long, default_value_t = 5)]
    pub count: usize,
    /// Hits of one clip are at least so far apart (s).
    #[arg(long, default_value_t = SearchSpec::default().apart)]
    pub apart: f64,
    /// The robot: a name, or an MJCF or URDF file.
    #[arg(short, long, default_value = "lima")]
    pub robot: String,
}

/// Runs the command.
pub fn run(args: &Args, output: &Output) -> Result<(), CliError> {
    if !(args.apart.is_finite() && args.apart >= 0.0) {
        return Err(CliError::Usage(format!("--apart: expected seconds from 0 up, got {}", args.apart)));
    }
    let robot = Robot::load(&args.robot)?;
    let prior = prior_file::load_for(&args.prior, &robot)?;
    let rate = prior.windows().frame_rate;
    let query = clips::load_one_as(&args.query, args.layout.layout, &robot)?;
    if !(args.at >= 0.0 && args.at <= query.seconds()) {
        let text =
            format!("--at: expected a time from 0 to {:.2} s in '{}', got {}", query.seconds(), query.name, args.at);
        return Err(CliError::Usage(text));
    }
    let motions = clips::load_as(&args.motions, args.layout, &robot)?;
    let codes = Codes::of_prior(&prior, &prior_file::frames(&motions, &robot, rate)?)?;
    let sought = Codes::of_prior(&prior, &prior_file::frames(std::slice::from_ref(&query), &robot, rate)?)?;
    let frame = ((args.at * rate).round() as usize).min(sought.len().saturating_sub(1));
    let time = frame as f64 / rate;
    let clip = motions.iter().position(|clip| *clip == query);
    let origin = clip.map(|clip| Origin { clip, time, window: prior.windows().window_seconds });
    let spec = SearchSpec { count: args.count, apart: args.apart };
    let hits = search(&codes, sought.row(frame), origin, &spec)?;
    let caption = |hit: &Hit| motions.iter().find(|c| c.name == hit.clip).map_or("", |clip| caption_at(clip, hit.time));
    let found: Vec<Value> = hits
        .iter()
        .map(|h| json!({ "clip": h.clip, "time": h.time, "similarity": h.similarity, "caption": caption(h) }))
        .collect();
    let value = json!({
        "query": { "clip": query.name, "time": time, "caption": caption_at(&query, time), "among_the_motions": clip.is_some() },
        "prior": args.prior, "clips": motions.len(), "windows": codes.len(), "hits": found,
    });
    output.result(&value, || {
        let said = |caption: &str| if caption.is_empty() { String::new() } else { format!(" ({caption})") };
        let rows: Vec<Vec<String>> = hits
            .iter()
            .map(|h| vec![h.clip.clone() + &said(caption(h)), format!("{:.2}", h.time), format!("{:.3}", h.similarity)])
            .collect();
        format!(
            "{}{} at {time:.2} s among {} windows of {} clips:\n\n{}",
            query.name,
            said(caption_at(&query, time)),
            codes.len(),
            motions.len(),
            table(&["clip", "time (s)", "similarity"], &rows)
        )
    })
}

/// Captions of this instant of a clip; empty where there are none.
fn caption_at(clip: &MotionClip, time: f64) -> &str {
    let captions = clip.provenance.captions.iter();
    captions.filter(|c| c.start <= time && time <= c.end).map(|c| c.text.as_str()).next().unwrap_or("")
}
