//! `lifelike generate`: motion of a robot from a sentence.

mod again;
mod live;
mod made;
mod maker;
mod path;
mod play;
mod pose;
mod prompts;
mod softened;
mod spoken;
pub(super) mod verdict;

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

use lifelike_generation::critic::Critic;
use lifelike_generation::generator::{Generator, SampleOptions};
use lifelike_generation::text::familiarity::Familiarity;
use lifelike_generation::text::prompt;
use lifelike_language::grammar::{Grammar, Verb};
use lifelike_language::script::Script;
use lifelike_motion::clip::Provenance;
use lifelike_robot::Robot;
use serde_json::json;

use self::again::Again;
use self::made::Made;
use self::maker::{Kept, Maker, sort_by_realism};
use self::play::{Played, Player};
use self::spoken::{PartReport, Speaker};
use crate::commands::best_of::By;
use crate::commands::motion::container_in;
use crate::commands::physics::Physics;
use crate::destination;
use crate::error::CliError;
use crate::next::NextCommand;
use crate::output::Output;
use crate::shipped::{self, Kind};

/// Strength of guidance where a critic is named and no strength.
const STRENGTH: f64 = 0.02;

/// Make motion of a robot from a sentence (thesis chapter 5).
///
/// A sentence is understood as a script, which is printed and written beside the clip: actions in sequence and at once,
/// with sides, counts, angles and durations. Each clause is made by the network; the grammar's rules make those whose facts
/// do not hold on the network's motion. With --as-is the network gets the sentence itself.
/// The clip's provenance has a verdict without physics. The same sentence, seed and settings give the same motion.
#[derive(Debug, clap::Args)]
#[command(group = clap::ArgGroup::new("tracked").multiple(true), after_help = "\
Examples:
  lifelike generate \"a person waves with the right hand\" --physics   # into runs/generated
  lifelike generate \"take exactly 3 steps, turn 135 degrees left, then bow twice\" --physics
  lifelike generate --script runs/generated/wave.script.toml -o again.motion.safetensors
  lifelike generate \"a person walks\" --then \"a person turns left\" --as-is --candidates 8 \\
      -o walk.motion.safetensors
  lifelike generate \"a person kicks\" --best-of 16 --by physics -o kick.motion.safetensors
  lifelike generate \"a person waves\" --pose builtin:bow:1.2@2 --seconds 4
  lifelike generate \"a person waves\" --keep-legs walk.motion.safetensors \\
      -o both.motion.safetensors
  lifelike generate \"wave with the left hand\" --path \"1,0 1,1 0,1\" --physics
  lifelike generate --live                     # type sentences; the robot does them in physics
  lifelike generate --prompts prompts.txt --generator runs/g/motion.generator.safetensors \\
      -o data/generated")]
pub struct Args {
    /// The sentence.
    #[arg(required_unless_present_any = ["prompts", "script", "verbs", "brief", "live", "path"])]
    pub prompt: Option<String>,
    /// Go on with another sentence, without a seam; may be given several times.
    #[arg(long, value_name = "PROMPT", conflicts_with_all = ["prompts", "keep_legs", "keep_arms"])]
    pub then: Vec<String>,
    /// Go along these points on the ground: metres ahead and to the left of where the robot begins, such as '1,0 1,1'.
    /// The sentence is the gait or the gesture on the way; a plain walk where there is none.
    #[arg(long, value_name = "POINTS", allow_hyphen_values = true, conflicts_with_all = ["prompts", "as_is", "then", "script", "live", "keep_legs", "keep_arms"])]
    pub path: Option<path::Path>,
    /// A file with a sentence per line, each of which becomes a clip in the folder of --output.
    #[arg(long, value_name = "FILE", conflicts_with = "prompt")]
    pub prompts: Option<PathBuf>,
    /// Pass each sentence to the network as it is, without understanding it first.
    #[arg(long)]
    pub as_is: bool,
    /// Do a script instead of a sentence: the file that is written beside every clip, perhaps changed.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["prompt", "prompts", "as_is", "then"])]
    pub script: Option<PathBuf>,
    /// Maker of clauses: the network with the grammar's rules behind it, or one of the two.
    #[arg(long, value_enum, default_value_t = spoken::By::Auto, conflicts_with = "as_is", value_name = "MAKER")]
    pub made_by: spoken::By,
    /// Do the nearest thing that can be done where a sentence asks for more.
    #[arg(long, conflicts_with = "as_is")]
    pub nearest: bool,
    /// Fail (exit code 1) when a fact does not hold in the end, or the robot falls.
    #[arg(long, conflicts_with = "as_is")]
    pub strict: bool,
    /// Read sentences from standard input while the robot moves in physics, in real time; the end of the input ends it.
    #[arg(long, conflicts_with_all = ["prompt", "prompts", "script", "as_is", "then", "play", "project"])]
    pub live: bool,
    /// A command that reads sentences in the program's place, such as a language model: `ollama run qwen3`. It gets --brief and the
    /// sentence on its standard input, and writes a script. Also the variable LIFELIKE_READER.
    #[arg(long, value_name = "COMMAND", conflicts_with_all = ["script", "as_is"])]
    pub reader: Option<String>,
    /// Times that the command of --reader is asked again where the robot falls or a fact does not hold in physics. It gets
    /// what was measured, and the better of the two motions stays.
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub revise: usize,
    /// Print the text by which a language model, or a person, writes scripts: their form, examples and the verbs.
    #[arg(long)]
    pub brief: bool,
    /// List the verbs that sentences can have, with their phrases.
    #[arg(long)]
    pub verbs: bool,
    /// The generator, what `lifelike train generator` leaves; a name, a file, or the robot's own that comes with the program where not given.
    #[arg(long)]
    pub generator: Option<PathBuf>,
    /// The robot: a built-in one's name, or its MJCF or URDF file.
    #[arg(short, long, default_value = "lima")]
    pub robot: String,
    /// The file (NAME.motion.safetensors) or folder to write; with --prompts the folder.
    #[arg(short, long, default_value = "runs/generated", value_parser = crate::destination::motion)]
    pub output: PathBuf,
    /// Duration of each part (s); what its sentence asks for, or that of the clip that is kept, where not given.
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
    /// Number of motions to choose from.
    #[arg(long, default_value_t = 1, value_parser = crate::bounds::candidates)]
    pub candidates: usize,
    /// Make N motions and keep the best, as --candidates; --by says who chooses.
    #[arg(long, value_name = "N", conflicts_with = "candidates", value_parser = crate::bounds::candidates)]
    pub best_of: Option<usize>,
    /// Choose by the critic's mean value, or by physics: the policy follows every candidate. By the verdict where not given.
    #[arg(long, value_enum)]
    pub by: Option<By>,
    /// Write all candidates, those after the best numbered by their rank.
    #[arg(long)]
    pub keep_all: bool,
    /// A critic that ranks and guides towards motion that its policy can execute: what `lifelike train critic` leaves.
    /// The robot's that comes with the program only ranks, unless there is a strength.
    #[arg(long)]
    pub critic: Option<PathBuf>,
    /// Strength of the critic's guidance; 0 only ranks. 0.02 where a critic is named.
    #[arg(long)]
    pub critic_strength: Option<f64>,
    /// Take legs and root from this clip; the rest is made to go with them.
    #[arg(long, value_name = "CLIP", conflicts_with = "keep_arms")]
    pub keep_legs: Option<PathBuf>,
    /// Take the arms from this clip.
    #[arg(long, value_name = "CLIP")]
    pub keep_arms: Option<PathBuf>,
    /// Be in the pose of a clip's frame at this time of the motion (s), and stand there; may be given several times. CLIP:TIME
    /// is the frame at a time of the clip, its first one where not given.
    #[arg(long, value_name = "CLIP@SECONDS", conflicts_with_all = ["prompts", "then", "path", "script", "live", "keep_legs", "keep_arms"])]
    pub pose: Vec<pose::PoseAt>,
    /// Play the result in physics and write a page to look at.
    #[arg(long = "physics", group = "tracked")]
    pub play: bool,
    /// Write what physics makes of the motion in place of the motion itself (PhysDiff's projection). Nothing helps the
    /// robot to stay on its feet.
    #[arg(long, group = "tracked")]
    pub project: bool,
    /// The controller of --physics, --project and --by physics: a name or a file. By default it is the robot's own that comes
    /// with the program.
    #[arg(long)]
    pub policy: Option<PathBuf>,
    /// Folder of that page; beside the output where not given.
    #[arg(long, value_name = "FOLDER", requires = "play")]
    pub report: Option<PathBuf>,
    /// Engine and threads.
    #[command(flatten)]
    pub physics: Physics,
}

/// Runs the command.
pub fn run(args: &Args, output: &Output) -> Result<(), CliError> {
    let grammar = Grammar::builtin()?;
    if args.verbs {
        return verbs(&grammar, output);
    }
    if args.live {
        return live::run(args, output);
    }
    let robot = Arc::new(Robot::load(&args.robot)?);
    if args.brief {
        let brief = grammar.brief(&robot.anatomy);
        return output.result(&json!({ "brief": brief }), || brief.clone());
    }
    let as_is = args.as_is || args.keep_legs.is_some() || args.keep_arms.is_some() || !args.pose.is_empty();
    let maker = match maker(args, &robot) {
        Ok(maker) => Some(maker),
        // The grammar's rules need no network.
        Err(_) if !as_is && args.generator.is_none() && shipped::of_robot(&robot, Kind::Generator).is_none() => None,
        Err(error) => return Err(error),
    };
    if maker.is_none() && args.made_by == spoken::By::Network {
        return Err(no_generator(&robot, &args.robot));
    }
    let jobs = jobs(args)?;
    let scripts = jobs.iter().filter(|_| !as_is).map(|(prompts, _)| {
        prompts.iter().try_for_each(|text| prompt::check(text).map(|_| ()))?;
        if args.path.is_some() && prompts.is_empty() {
            return Ok(Script::default());
        }
        spoken::understand(&grammar, &robot, prompts, args)
    });
    let mut scripts = scripts.collect::<Result<Vec<_>, _>>()?;
    if let (Some(path), Some(script)) = (&args.path, scripts.first_mut()) {
        *script = path.script(script, &grammar)?;
    }
    let speaker = if as_is { None } else { Some(Speaker::new(&grammar, &robot, &mut scripts, args.made_by)?) };
    let mut familiarity = Vec::new();
    let mut doubts = Vec::with_capacity(jobs.len());
    for (prompts, _) in &jobs {
        let Some(known) = maker.as_ref().filter(|_| as_is).map(|maker| &maker.generator.header().known) else {
            doubts.push(None);
            continue;
        };
        let found: Vec<Familiarity> =
            prompts.iter().map(|prompt| known.familiarity(prompt)).collect::<Result<_, _>>()?;
        for (prompt, found) in prompts.iter().zip(&found).filter(|(_, found)| !found.reads_well()) {
            tracing::warn!("\"{prompt}\" {found}");
        }
        doubts.push(made::doubt(&found));
        familiarity.extend(found);
    }
    let chosen_in_physics = args.by == Some(By::Physics);
    let tracked = args.play || args.project || chosen_in_physics;
    if args.policy.is_some() && !tracked {
        return Err(CliError::Usage("--policy needs --physics, --project or --by physics".into()));
    }
    if args.by == Some(By::Critic) && maker.as_ref().is_none_or(|maker| maker.critic.is_none()) {
        let text = format!("--by critic: '{}' has no critic in assets/; name one with --critic", robot.name);
        return Err(CliError::Usage(text));
    }
    let player = tracked.then(|| Player::new(args.policy.as_deref(), &robot, &args.robot, &args.physics));
    let player = player.transpose()?;
    let mut made = Vec::with_capacity(jobs.len());
    let mut first_clip = None;
    for (number, ((prompts, file), doubt)) in jobs.iter().zip(doubts).enumerate() {
        let began = Instant::now();
        let mut candidates = match (&speaker, &maker) {
            (Some(speaker), maker) => {
                let count = args.best_of.unwrap_or(args.candidates);
                speaker.make(&scripts[number], prompts, maker.as_ref(), args.seed, count)?
            }
            (None, Some(maker)) => maker.make(prompts)?,
            (None, None) => return Err(no_generator(&robot, &args.robot)),
        };
        if let (Some(player), Some(maker)) = (player.as_ref().filter(|_| args.project), &maker) {
            candidates = maker.projected(candidates, |clips| player.project(clips, output))?;
        }
        match (args.by, &player) {
            (Some(By::Critic), _) => sort_by_realism(&mut candidates),
            (Some(By::Physics), Some(player)) => candidates = player.sorted(candidates, output)?,
            _ => {}
        }
        let took = began.elapsed().as_secs_f64();
        let mut one = Made::write(prompts, candidates, file, args.keep_all, took, doubt)?;
        if let Some(script) = scripts.get(number) {
            crate::output::write(&made::script_file(file), script.to_toml()?)?;
            one.script = Some(script.clone());
        }
        if args.path.is_some() {
            first_clip.clone_from(&one.best);
        }
        // Thousands of prompts would fill the memory with clips that nobody plays.
        one.best = one.best.filter(|_| args.play);
        made.push(one);
    }
    let play = |player: &Player<'_>, made: &[Made]| {
        let clips: Vec<_> = made.iter().filter_map(|one| one.best.clone()).collect();
        let beside = match &args.prompts {
            Some(_) => args.output.join("physics"),
            None => jobs[0].1.with_file_name(format!("{}-physics", made::stem(&jobs[0].1))),
        };
        player.play(&clips, args.report.as_deref().unwrap_or(&beside), output)
    };
    let player = player.filter(|_| args.play);
    let mut played = player.as_ref().map(|player| play(player, &made)).transpose()?;
    let mut speaker = speaker;
    if let (Some(player), Some(own), Some(first)) = (&player, &speaker, &played) {
        let again = Again { grammar: &grammar, robot: &robot, player, maker: maker.as_ref(), args, output };
        let fell: Vec<usize> = (0..made.len()).filter(|number| first.fell(*number)).collect();
        if again.drawn(own, &jobs, &scripts, &mut made, &fell)? {
            played = Some(play(player, &made)?);
        }
        let seen = played.as_ref().map(|played| &played.evaluation);
        if let Some(seen) = seen.filter(|_| args.script.is_none() && args.path.is_none())
            && again.read(own, &jobs, &mut scripts, &mut made, seen)?
        {
            speaker = Some(Speaker::new(&grammar, &robot, &mut scripts, args.made_by)?);
            played = Some(play(player, &made)?);
        }
    }
    let mut all_true = made.iter().flat_map(|one| &one.parts).all(PartReport::is_true);
    if let (Some(played), Some(speaker)) = (&mut played, &speaker) {
        for (one, rollout) in made.iter().zip(&played.evaluation.rollouts) {
            let clip = rollout.played(Provenance::default());
            let (line, untrue) = speaker.in_physics(&one.parts, &clip)?;
            played.lines.push(line);
            played.lines.extend(args.path.as_ref().map(|path| path.line(&clip, " in physics")));
            all_true &= untrue == 0 && rollout.survived();
        }
    }
    let value = json!({ "robot": robot.name, "motions": made, "familiarity": familiarity, "physics": played });
    output.result(&value, || {
        let took: f64 = made.iter().map(|one| one.sampling_seconds).sum();
        let seconds: f64 = made.iter().map(|one| one.seconds).sum();
        let mut lines: String = made.iter().map(Made::text).collect();
        if let (Some(path), Some(clip)) = (&args.path, &first_clip) {
            lines += &format!("{}\n", path.line(clip, ""));
        }
        let end = match (&played, made.first()) {
            (Some(played), _) => {
                let page = played.report.display();
                format!(
                    "{}\nopen this in a browser: {page}\n{}",
                    played.lines.join("\n"),
                    played.next(args, &robot, &made)
                )
            }
            (None, Some(first)) => {
                let next = NextCommand::new("motion check").word(first.files[0].display());
                format!("next: {}\n", next.robot(&args.robot))
            }
            (None, None) => String::new(),
        };
        format!("{lines}{seconds:.1} s of motion made in {took:.2} s\n{end}")
    })?;
    if args.strict && !all_true {
        return Err(CliError::Failed("--strict: a fact does not hold, or the robot fell".into()));
    }
    Ok(())
}

/// Lists verbs and their phrases.
fn verbs(grammar: &Grammar, output: &Output) -> Result<(), CliError> {
    let plain = |text: &String| text.replace(['[', ']', '{', '}'], "");
    let value: Vec<_> = grammar.verbs.iter().map(|verb| json!({ "verb": verb.name, "phrases": verb.say })).collect();
    output.result(&value, || {
        let line = |verb: &Verb| {
            let phrases: Vec<String> = verb.say.iter().take(3).map(plain).collect();
            format!("{:16} {}\n", verb.name, phrases.join(", "))
        };
        grammar.verbs.iter().map(line).collect()
    })
}

impl Played {
    /// Returns whether this motion fell.
    fn fell(&self, number: usize) -> bool {
        self.evaluation.episodes.get(number).is_some_and(|episode| episode.failure.is_some())
    }

    /// Returns the line with the next command: why the first motion falls or lags.
    fn next(&self, args: &Args, robot: &Robot, made: &[Made]) -> String {
        let Some(first) = made.first() else { return String::new() };
        let shipped = || shipped::name_of(robot).map_or_else(|| self.policy.clone(), PathBuf::from);
        let policy = args.policy.clone().unwrap_or_else(shipped);
        let eval = NextCommand::new("eval").path("--policy", &policy).robot(&args.robot);
        let eval = eval.word("--motions").word(first.files[0].display()).word("--explain");
        format!("next: {}\n", eval.word("-o").word("runs/explained"))
    }
}

/// Loads what motions are made with.
fn maker(args: &Args, robot: &Arc<Robot>) -> Result<Maker, CliError> {
    let generator = match &args.generator {
        Some(given) => shipped::file(given, Kind::Generator)?,
        None => shipped::of_robot(robot, Kind::Generator).ok_or_else(|| no_generator(robot, &args.robot))?.file()?,
    };
    let generator = Generator::load(&generator)?;
    generator.check_robot(robot)?;
    let spec = &generator.header().spec;
    let (critic, strength) = match &args.critic {
        Some(file) => {
            let critic = Critic::load(&shipped::file(file, Kind::Critic)?)?;
            critic.check(spec)?;
            (Some(critic), args.critic_strength.unwrap_or(STRENGTH))
        }
        None => {
            let own = shipped::of_robot(robot, Kind::Critic).map(shipped::Shipped::file).transpose()?;
            let own = own.map(|file| Critic::load(&file)).transpose()?;
            // A generator of other rows is judged without it.
            (own.filter(|critic| critic.check(spec).is_ok()), args.critic_strength.unwrap_or(0.0))
        }
    };
    if critic.is_none() && strength != 0.0 {
        let text = format!(
            "--critic-strength needs a critic: no critic for '{}' comes with the program; name one with --critic",
            robot.name
        );
        return Err(CliError::Usage(text));
    }
    let mut options = SampleOptions {
        seconds: args.seconds,
        seed: args.seed,
        guidance: args.guidance,
        steps: args.steps,
        eta: args.eta,
        candidates: args.best_of.unwrap_or(args.candidates),
    };
    let legs = args.keep_legs.as_deref().map(|file| (file, "legs", true));
    let part = legs.or(args.keep_arms.as_deref().map(|file| (file, "arms", false)));
    let kept = part.map(|(file, part, root)| Kept::read(file, part, root, robot, &generator)).transpose()?;
    let kept = kept.map(|(kept, seconds)| {
        options.seconds.get_or_insert(seconds);
        kept
    });
    let kept = match &args.pose[..] {
        [] => kept,
        poses => Some(pose::read(poses, robot, &generator)?),
    };
    Ok(Maker { robot: Arc::clone(robot), generator, critic, strength, options, kept })
}

/// Returns the sentences of each motion, and its file.
fn jobs(args: &Args) -> Result<Vec<(Vec<String>, PathBuf)>, CliError> {
    if args.prompts.is_some() && destination::is_motion(&args.output) {
        let file = args.output.display();
        return Err(CliError::Usage(format!("-o: expected a folder with --prompts, got '{file}'")));
    }
    if let Some(script) = &args.script {
        let name = made::stem(script);
        let named = || container_in(&args.output, &name);
        return Ok(vec![(
            Vec::new(),
            if destination::is_motion(&args.output) { args.output.clone() } else { named()? },
        )]);
    }
    let Some(file) = &args.prompts else {
        let prompts: Vec<String> =
            args.prompt.iter().chain(&args.then).map(|prompt| prompt.trim().to_string()).collect();
        let words = if prompts.is_empty() { "path".to_string() } else { prompts.join(" then ") };
        let named = || container_in(&args.output, &prompts::slug(&words));
        let file = if destination::is_motion(&args.output) { args.output.clone() } else { named()? };
        return Ok(vec![(prompts, file)]);
    };
    let named = |(i, prompt): (usize, String)| {
        let file = container_in(&args.output, &prompts::name(i + 1, &prompt))?;
        Ok((vec![prompt], file))
    };
    prompts::read(file)?.into_iter().enumerate().map(named).collect()
}

fn no_generator(robot: &Robot, file: &str) -> CliError {
    let train = NextCommand::new("train generator").word("--plan").word("generator").word("--robot").word(file);
    let again = NextCommand::new("generate").word("a person walks").word("--generator");
    CliError::Input(format!(
        "no pretrained generator for '{}' comes with the program: none has its joints. Train one and name it:\n\
         \x20 {}\n\
         \x20 {}",
        robot.name,
        train.word("-o").word("runs/generator"),
        again
            .word("runs/generator/motion.generator.safetensors")
            .robot(file)
            .word("-o")
            .word("walk.motion.safetensors")
    ))
}
