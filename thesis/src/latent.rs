//! `lifelike-thesis latent`: what a space of latent codes is worth (thesis 4.3.2, Table 4.2).

use std::path::{Path, PathBuf};
use std::sync::Arc;

use lifelike_motion::MotionClip;
use lifelike_representation::MotionPrior;
use lifelike_representation::latent::codes::features_of;
use lifelike_representation::latent::probe::{self, Probe, probes};
use lifelike_representation::latent::{Codes, Encoded, LatentScore, comparison};
use lifelike_representation::prior::{ReconstructionReport, Windows};
use lifelike_robot::{Controller, ControllerFile, ReferenceLibrary, Robot};
use serde_json::{Value, json};

use lifelike::CliError;
use lifelike::commands::reconstruction::{self, HEAD};
use lifelike::commands::{clips, prior_file};
use lifelike::progress::Progress;
use lifelike::{Output, table};

/// Measure latent codes: how well they tell motions apart, how much they know of the motion, what comes back from them.
///
/// The first table has linear discriminant analysis and mutual information, as thesis Table 4.2, whose rows are
/// repeated above. The second has reconstruction errors of the motions, and of motions that were not used in training.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  lifelike-thesis latent --prior lima --motions data/lima/cmu_amc data/lima/deepmimic
  lifelike-thesis latent --prior a.prior.safetensors b.prior.safetensors --motions @clips.txt \\
      -o latent
  lifelike-thesis latent --prior lima \\
      --motions @thesis/experiments/latent-lima.txt \\
      --unseen @experiments/track-20-test.txt --json | jq .table

Motions may be *.motion.safetensors, or captured motion and keyframes, which are retargeted on the way.")]
pub struct Args {
    /// Motion priors to compare.
    #[arg(long, required = true, num_args = 1..)]
    prior: Vec<PathBuf>,
    /// Policies with an encoder of their own, trained end to end (network.encoder of their plans).
    #[arg(long, num_args = 1..)]
    policy: Vec<PathBuf>,
    /// Clips to encode: files, folders, patterns, or @list.txt with one of them per line.
    #[arg(short, long, required = true, num_args = 1..)]
    motions: Vec<PathBuf>,
    /// Clips that the priors were not trained on: for their reconstruction, and for probes of the near future.
    #[arg(long, num_args = 1..)]
    unseen: Vec<PathBuf>,
    /// Folder for latent.json.
    #[arg(short, long, value_parser = lifelike::destination::folder)]
    output: Option<PathBuf>,
    /// Key of the shuffled codes.
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// The robot: a name, or an MJCF or URDF file.
    #[arg(short, long, default_value = "lima")]
    robot: String,
}

/// Reconstruction errors of a prior on some clips.
struct Reconstruction {
    prior: String,
    motions: &'static str,
    report: ReconstructionReport,
}

/// Runs the command.
pub fn run(args: &Args, output: &Output) -> Result<(), CliError> {
    let robot = Robot::load(&args.robot)?;
    let priors = args.prior.iter().map(|path| Ok((path.display().to_string(), prior_file::load_for(path, &robot)?)));
    let priors = priors.collect::<Result<Vec<_>, CliError>>()?;
    let motions = clips::load(&args.motions, &robot)?;
    let unseen = if args.unseen.is_empty() { Vec::new() } else { clips::load(&args.unseen, &robot)? };
    let mut progress = Progress::new(output, "encoding", priors.len() as u64);
    let mut spaces = Vec::with_capacity(priors.len());
    let (mut reconstructions, mut probed) = (Vec::new(), Vec::new());
    for (i, (name, prior)) in priors.iter().enumerate() {
        let space = encoded(name, prior, &motions, &robot)?;
        if !unseen.is_empty() {
            probed.extend(probes(&space, &encoded(name, prior, &unseen, &robot)?, prior.layout(), args.seed)?);
        }
        spaces.push(space);
        for (title, clips) in [("motions", &motions), ("unseen", &unseen)] {
            if !clips.is_empty() {
                let report = reconstruct(prior, clips, &robot)?;
                reconstructions.push(Reconstruction { prior: name.clone(), motions: title, report });
            }
        }
        progress.update(i as u64 + 1, priors.len() as u64, String::new);
    }
    progress.finish();
    spaces.extend(spaces.first().map(state_itself).transpose()?);
    for path in &args.policy {
        spaces.push(end_to_end(path, &motions, &robot)?);
    }
    let scores = comparison::compare(&spaces, args.seed)?;
    let value = value(&scores, &reconstructions, &probed, motions.len());
    if let Some(folder) = &args.output {
        save(&value, folder)?;
    }
    output.result(&value, || text(&scores, &reconstructions, &probed, motions.len()))
}

/// Codes and features of the same frames.
fn encoded(name: &str, prior: &MotionPrior, clips: &[MotionClip], robot: &Robot) -> Result<Encoded, CliError> {
    let frames = prior_file::frames(clips, robot, prior.windows().frame_rate)?;
    let codes = Codes::of_prior(prior, &frames)?;
    Ok(Encoded { name: name.into(), codes, features: features_of(&frames, prior.layout())? })
}

/// The features of the frames as if they were codes: what an encoder of windows has to beat.
fn state_itself(space: &Encoded) -> Result<Encoded, CliError> {
    let (codes, features) = (&space.codes, space.features.clone());
    let starts = codes.clips().map(|rows| rows.start).chain([codes.len()]).collect();
    let width = features.len() / codes.len().max(1);
    let codes = Codes::new(codes.names().to_vec(), starts, features.clone(), width, codes.fps())?;
    Ok(Encoded { name: "features of the frame itself".into(), codes, features })
}

/// Codes of a policy's own encoder, and the features of the same frames.
fn end_to_end(path: &Path, clips: &[MotionClip], robot: &Robot) -> Result<Encoded, CliError> {
    let file = ControllerFile::read(path)?;
    let Some((_, size)) = file.header().encoder else {
        let text = format!("{}: expected a policy with an encoder of its own, got one without", path.display());
        return Err(CliError::Input(text));
    };
    let library = ReferenceLibrary::new(robot, clips, None)?;
    let controller = Controller::new(file, Arc::new(robot.clone()))?;
    let rows = own_codes(&controller, &library)?;
    let codes = Codes::new(library.names.clone(), library.starts.clone(), rows, size, robot.control_hz)?;
    Ok(Encoded { name: path.display().to_string(), codes, features: library.features })
}

/// Returns the codes of a policy's own encoder for every frame of a library, `[T, code]`.
fn own_codes(controller: &Controller, library: &ReferenceLibrary) -> Result<Vec<f32>, CliError> {
    const CHUNK: usize = 256;
    let spec = controller.observation();
    let (width, window) = (spec.size(), spec.window_size());
    let mut codes = Vec::new();
    for first in (0..library.len()).step_by(CHUNK) {
        let last = (first + CHUNK).min(library.len());
        let mut rows = vec![0.0; (last - first) * width];
        for (frame, row) in (first..last).zip(rows.chunks_exact_mut(width)) {
            let frames = library.window_at(frame, &spec.reference.window);
            spec.write_frames(&frames, &mut row[width - window..])?;
        }
        codes.extend(controller.file().policy().codes(&mut rows));
    }
    Ok(codes)
}

fn reconstruct(prior: &MotionPrior, clips: &[MotionClip], robot: &Robot) -> Result<ReconstructionReport, CliError> {
    let frames = prior_file::frames(clips, robot, prior.windows().frame_rate)?;
    Ok(prior.reconstruct(&Windows::new(prior.windows(), prior.layout(), frames)?)?)
}

fn value(scores: &[LatentScore], reconstructions: &[Reconstruction], probes: &[Probe], clips: usize) -> Value {
    let of = |r: &Reconstruction| json!({ "prior": r.prior, "motions": r.motions, "errors": reconstruction::value(&r.report) });
    let reconstructions: Vec<Value> = reconstructions.iter().map(of).collect();
    json!({ "clips": clips, "table": scores, "reconstruction": reconstructions, "probes": probes })
}

fn save(value: &Value, folder: &Path) -> Result<(), CliError> {
    std::fs::create_dir_all(folder).map_err(CliError::write(folder))?;
    lifelike::output::write_json(&folder.join("latent.json"), value)
}

fn text(scores: &[LatentScore], reconstructions: &[Reconstruction], probes: &[Probe], clips: usize) -> String {
    let compared = comparison::table(scores);
    let mut text =
        format!("{}, {clips} clips\n\n{}\n{}\n", compared.title, lifelike::output::fitted(&compared), compared.caption);
    for r in reconstructions {
        let rows = [
            reconstruction::row("whole windows", &r.report.window),
            reconstruction::row("their centres", &r.report.centre),
        ];
        text += &format!(
            "\nreconstruction by {} of {} windows of {}:\n\n{}",
            r.prior,
            r.report.windows,
            if r.motions == "unseen" { "motions never trained on" } else { "the motions" },
            table(&HEAD, &rows)
        );
    }
    if !probes.is_empty() {
        let probed = probe::table(probes);
        text += &format!("\n{}\n\n{}\n{}\n", probed.title, probed.to_text(), probed.caption);
    }
    text
}
