//! `lifelike generate`: motion of a robot from a sentence.

use std::path::{Path, PathBuf};

use lifelike_generation::critic::{Critic, RewardSurrogate};
use lifelike_generation::generator::{Generator, SampleOptions};
use lifelike_motion::container;
use lifelike_robot::Robot;
use serde_json::json;

use crate::error::CliError;
use crate::next::NextCommand;
use crate::output::Output;

/// Make motion of a robot from a sentence (thesis chapter 5).
///
/// What comes out is a clip like any other, with the sentence as its caption. The same sentence, seed and settings
/// give the same motion. With --candidates N there are N files, numbered.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  lifelike generate \"a person waves\" --generator motion.generator.safetensors -o wave.motion.safetensors
  lifelike generate \"a person walks\" --generator motion.generator.safetensors -o walk.motion.safetensors \\
      --seconds 6 --seed 3 --candidates 4")]
pub struct Args {
    /// The sentence.
    pub prompt: String,
    /// The generator: what `lifelike train generator` leaves.
    #[arg(long)]
    pub generator: PathBuf,
    /// The robot: a built-in one's name, or its MJCF or URDF file.
    #[arg(long, default_value = "lima")]
    pub robot: String,
    /// The file to write.
    #[arg(short, long)]
    pub output: PathBuf,
    /// Duration (s); as the generator's training data where not given.
    #[arg(long)]
    pub seconds: Option<f64>,
    /// Key of the randomness.
    #[arg(long, default_value_t = 0)]
    pub seed: u64,
    /// Weight of the prompt: 0 ignores it, 1 takes it as it is, more exaggerates.
    #[arg(long, default_value_t = SampleOptions::default().guidance)]
    pub guidance: f64,
    /// Denoising steps; all of the generator's where not given.
    #[arg(long)]
    pub steps: Option<usize>,
    /// Noise that is added again in each step: 1 is DDPM, 0 is DDIM.
    #[arg(long, default_value_t = SampleOptions::default().eta)]
    pub eta: f64,
    /// Number of motions.
    #[arg(long, default_value_t = 1)]
    pub candidates: usize,
    /// A critic that guides sampling towards motion that its policy can execute: what `lifelike train critic` leaves.
    #[arg(long)]
    pub critic: Option<PathBuf>,
    /// Strength of the critic's guidance; 0 only reports its values.
    #[arg(long, default_value_t = 0.02, requires = "critic")]
    pub critic_strength: f64,
}

/// Runs the command.
pub fn run(args: &Args, output: &Output) -> Result<(), CliError> {
    let robot = Robot::load(&args.robot)?;
    let generator = Generator::load(&args.generator)?;
    generator.check_robot(&robot)?;
    let familiarity = generator.header().known.familiarity(&args.prompt)?;
    if !familiarity.reads_well() {
        tracing::warn!("{familiarity}");
    }
    let options = SampleOptions {
        seconds: args.seconds,
        seed: args.seed,
        guidance: args.guidance,
        steps: args.steps,
        eta: args.eta,
        candidates: args.candidates,
    };
    let began = std::time::Instant::now();
    let critic = args.critic.as_deref().map(Critic::load).transpose()?;
    critic.iter().try_for_each(|critic| critic.check(&generator.header().spec))?;
    let guide = critic.as_ref().map(|critic| (critic as &dyn RewardSurrogate, args.critic_strength));
    let generated = generator.sample_towards(&args.prompt, &options, guide)?;
    let sampling_seconds = began.elapsed().as_secs_f64();
    let mut files = Vec::with_capacity(generated.len());
    let mut seconds = 0.0;
    for motion in &generated {
        let mut clip = generator.clip(motion, &args.prompt, &robot)?;
        let path = numbered(&args.output, motion.candidate, generated.len());
        clip.name = stem(&path);
        seconds = clip.seconds();
        container::write(&path, &clip)?;
        files.push(path);
    }
    let realism =
        critic.map(|c| generated.iter().map(|m| c.realism(&m.rows)).collect::<Result<Vec<_>, _>>()).transpose()?;
    let value = json!({
        "realism": realism, "prompt": args.prompt, "robot": robot.name, "files": files, "seconds": seconds,
        "sampling_seconds": sampling_seconds, "familiarity": familiarity,
    });
    output.result(&value, || {
        let value = |i: usize| realism.as_ref().map_or(String::new(), |all| format!("  Realism {:.2}", all[i]));
        let list: String =
            files.iter().enumerate().map(|(i, path)| format!("{}{}\n", path.display(), value(i))).collect();
        let first = files.first().map_or(Path::new(""), PathBuf::as_path);
        let next = NextCommand::new("motion check").word(first.display()).robot(&args.robot);
        let count = files.len();
        format!("{count} motion(s) of {seconds:.1} s, sampled in {sampling_seconds:.2} s:\n{list}next: {next}\n")
    })
}

/// Returns the file of a candidate: as named, or with its number before the endings where there are several.
fn numbered(path: &Path, candidate: usize, count: usize) -> PathBuf {
    if count == 1 {
        return path.to_path_buf();
    }
    let name = path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
    let (stem, endings) = name.split_once('.').unwrap_or((&name, "motion.safetensors"));
    path.with_file_name(format!("{stem}-{candidate}.{endings}"))
}

fn stem(path: &Path) -> String {
    let name = path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
    name.split_once('.').map_or(name.clone(), |(stem, _)| stem.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn candidates_are_numbered_before_the_endings() {
        let path = Path::new("out/wave.motion.safetensors");
        assert_eq!(numbered(path, 0, 1), path);
        assert_eq!(numbered(path, 3, 8), Path::new("out/wave-3.motion.safetensors"));
        assert_eq!(numbered(Path::new("wave"), 1, 2), Path::new("wave-1.motion.safetensors"));
        assert_eq!(stem(path), "wave");
    }
}
