//! The stages of every round, each run once.

use std::path::{Path, PathBuf};

use lifelike_generation::align::JudgePlan;
use lifelike_generation::critic::CriticTrainer;
use lifelike_generation::generator::{FILE, Generated, Generator};
use lifelike_language::{CaptionedSet, Entry, Split};
use lifelike_motion::MotionClip;
use lifelike_robot::Robot;
use lifelike_tracking::Trainer;

use super::measure::{Pair, best_round, episodes};
use super::plan::{CotrainPlan, StagePlan};
use super::progress::Done;
use crate::commands::controller_file::Loaded;
use crate::commands::eval::Job;
use crate::commands::generated;
use crate::commands::judge::{Judge, Sentence, evenly, motions};
use crate::commands::physics::Physics;
use crate::commands::train::source::Source;
use crate::commands::{align, train};
use crate::error::CliError;
use crate::output::Output;

/// A co-training under way.
pub struct Stages<'a> {
    /// Its plan.
    pub plan: &'a CotrainPlan,
    /// Its folder.
    pub folder: &'a Path,
    /// Engine, threads, processor.
    pub physics: &'a Physics,
    /// Receiver of progress.
    pub output: &'a Output,
    /// Stages that are complete.
    pub done: Done,
}

impl Stages<'_> {
    /// Runs what is not complete yet.
    pub fn all(&mut self) -> Result<(), CliError> {
        self.once("measure".into(), |stages| stages.measure(0))?;
        for round in 1..=self.plan.rounds {
            for (name, stage) in [
                ("motions", Self::motions as fn(&mut Self, usize) -> Result<(), CliError>),
                ("tracker", Self::tracker),
                ("critic", Self::critic_stage),
                ("aligned", Self::align),
                ("measured", Self::measure),
            ] {
                self.once(format!("round-{round}/{name}"), |stages| stage(stages, round))?;
            }
        }
        Ok(())
    }

    /// The generator after a round.
    pub fn generator(&self, round: usize) -> PathBuf {
        if round == 0 { self.plan.generator.clone() } else { self.at(round, "aligned").join(FILE) }
    }

    /// The tracker after a round.
    pub fn policy(&self, round: usize) -> PathBuf {
        match self.tracker_of(round) {
            0 => self.plan.init.clone(),
            round => Trainer::policy_path(&self.at(round, "tracker")),
        }
    }

    /// The round whose tracker there is after a round.
    fn tracker_of(&self, round: usize) -> usize {
        if self.plan.tracker.is_some() { round } else { 0 }
    }

    /// The critic of a round.
    pub fn critic(&self, round: usize) -> PathBuf {
        CriticTrainer::critic_path(&self.at(round, "critic"))
    }

    fn at(&self, round: usize, stage: &str) -> PathBuf {
        self.folder.join(format!("round-{round}")).join(stage)
    }

    fn once(&mut self, name: String, stage: impl FnOnce(&mut Self) -> Result<(), CliError>) -> Result<(), CliError> {
        if self.done.has(&name) {
            return Ok(());
        }
        tracing::info!("{name}");
        stage(self)?;
        self.done.add(name)
    }

    /// Motion of sentences that the generator was trained on.
    fn motions(&mut self, round: usize) -> Result<(), CliError> {
        let made = self.generated(round - 1, Split::Train, self.plan.prompts, self.plan.seed + round as u64)?;
        let spec = Generator::load(&self.generator(round - 1))?.header().spec.clone();
        generated::write(&self.at(round, "motions"), &spec, &made)
    }

    fn tracker(&mut self, round: usize) -> Result<(), CliError> {
        let Some(plan) = &self.plan.tracker else { return Ok(()) };
        // A run has the value function too; a policy alone has to learn one anew before it learns anything else.
        let before = if round == 1 { self.plan.init.clone() } else { self.at(round - 1, "tracker") };
        let init = format!("init={}", before.display());
        let motions = self.motions_so_far(round);
        let clips = list("clips", self.plan.clips.iter().chain(&motions).map(PathBuf::as_path));
        let source = self.source(round, "tracker", plan, [clips, init]);
        train::tracker::run(&train::tracker::Args { source, physics: self.physics.clone() }, &self.progress_only())
    }

    fn critic_stage(&mut self, round: usize) -> Result<(), CliError> {
        let controller = format!("controller={}", self.policy(round).display());
        let motions = self.motions_so_far(round);
        let mut keys = vec![
            controller,
            list("clips", self.plan.clips.iter().map(PathBuf::as_path)),
            list("generated", motions.iter().map(PathBuf::as_path)),
        ];
        // A tracker that was trained here is judged in the environment that it was trained in.
        if self.plan.tracker.is_some() {
            keys.push(format!("environment={}", self.at(round, "tracker").join("plan.toml").display()));
        }
        let source = self.source(round, "critic", &self.plan.critic, keys);
        let physics = self.physics.clone();
        train::critic::run(&train::critic::Args { source, controller: None, physics }, &self.progress_only())
    }

    fn align(&mut self, round: usize) -> Result<(), CliError> {
        // The records of a complete critic are the largest files of a run, and nothing reads them again.
        train::critic::discard_records(&self.at(round, "critic"))?;
        let networks =
            [("generator", self.generator(round - 1)), ("critic", self.critic(round)), ("policy", self.policy(round))];
        let keys = networks.map(|(key, file)| format!("{key}={}", file.display()));
        let JudgePlan { sentences, split, episodes, seconds } = self.plan.judge;
        let judge = [
            format!("judge.sentences={sentences}"),
            format!("judge.split={}", split.name()),
            format!("judge.episodes={episodes}"),
            format!("judge.seconds={seconds:?}"),
        ];
        let dataset = list("clips", [self.plan.dataset.as_path()]);
        let source = self.source(round, "aligned", &self.plan.align, keys.into_iter().chain(judge).chain([dataset]));
        let physics = self.physics.clone();
        let args = align::Args { generator: None, critic: None, policy: None, source, physics };
        align::run(&args, &self.progress_only())
    }

    /// Returns the round whose generator is the best in physics by the last tracker.
    pub fn best(&self) -> usize {
        best_round(&self.done.measured, self.tracker_of(self.plan.rounds))
    }

    /// Plays the round's generator by all trackers so far, and its tracker on all generators before.
    fn measure(&mut self, round: usize) -> Result<(), CliError> {
        for other in 0..=round {
            for (generator, tracker) in [(other, self.tracker_of(round)), (round, self.tracker_of(other))] {
                let known = |pair: &Pair| (pair.generator, pair.tracker) == (generator, tracker);
                if !self.done.measured.iter().any(known) {
                    let pair = self.pair(generator, tracker)?;
                    self.done.measured.push(pair);
                }
            }
        }
        Ok(())
    }

    /// Plays the motion of one generator by one tracker.
    fn pair(&self, generator: usize, tracker: usize) -> Result<Pair, CliError> {
        let made = self.generated(generator, self.plan.split, self.plan.measured, self.plan.seed)?;
        let clips: Vec<MotionClip> = made.into_iter().map(|(_, clip)| clip).collect();
        let loaded = Loaded::load(&self.policy(tracker), Some(&self.plan.robot), None)?;
        let job = || Job { loaded: &loaded, physics: self.physics };
        let evaluation = job().run(&clips, &episodes(&clips), self.output)?;
        let judge = self.plan.judge;
        let sentences = self.sentences(judge.split, judge.sentences)?;
        let judge = Judge { job: job(), sentences, plan: judge, seed: self.plan.seed };
        let physics = Some(judge.play(&Generator::load(&self.generator(generator))?)?);
        Ok(Pair { physics, ..Pair::of(generator, tracker, &evaluation) })
    }

    /// Returns motions of sentences of a split, as long as their entries.
    fn generated(
        &self,
        round: usize,
        split: Split,
        count: usize,
        seed: u64,
    ) -> Result<Vec<(Generated, MotionClip)>, CliError> {
        let robot = Robot::load(&self.plan.robot)?;
        let generator = Generator::load(&self.generator(round))?;
        let sentences = self.sentences(split, count)?;
        Ok(motions(&generator, &robot, &sentences, seed, &format!("generated-{round}"))?)
    }

    /// Returns sentences, evenly taken from a split.
    fn sentences(&self, split: Split, count: usize) -> Result<Vec<Sentence>, CliError> {
        let set = CaptionedSet::read(&self.plan.dataset)?;
        let all: Vec<&Entry> =
            set.entries.iter().filter(|entry| entry.split == split && !entry.captions.is_empty()).collect();
        if all.is_empty() {
            let (file, split) = (self.plan.dataset.display(), split.name());
            return Err(CliError::Input(format!("{file}: expected captioned entries of the split {split}, got none")));
        }
        let sentence = |entry: &&Entry| Sentence { text: entry.captions[0].clone(), seconds: entry.seconds };
        Ok(evenly(&all, count).map(sentence).collect())
    }

    /// Returns the folders of the motions of all rounds so far.
    fn motions_so_far(&self, round: usize) -> Vec<PathBuf> {
        (1..=round).map(|round| self.at(round, "motions")).collect()
    }

    /// The plan of a stage with its changes, or the run that was interrupted.
    fn source(&self, round: usize, name: &str, plan: &StagePlan, keys: impl IntoIterator<Item = String>) -> Source {
        let folder = self.at(round, name);
        let resume = folder.join("plan.toml").exists();
        let own = [format!("robot={}", self.plan.robot), format!("seed={}", self.plan.seed)];
        let keys = own.into_iter().chain(plan.keys.iter().cloned()).chain(keys);
        Source {
            plan: (!resume).then(|| plan.plan.clone()),
            output: Some(folder),
            resume,
            overrides: if resume { Vec::new() } else { keys.collect() },
            ..Source::default()
        }
    }

    /// A stage tells its progress, not its result.
    fn progress_only(&self) -> Output {
        Output { silent: true, ..*self.output }
    }
}

/// A list of paths as a change to a plan.
fn list<'a>(key: &str, paths: impl IntoIterator<Item = &'a Path>) -> String {
    let quoted: Vec<String> = paths.into_iter().map(|path| format!("{:?}", path.display().to_string())).collect();
    format!("{key}=[{}]", quoted.join(", "))
}
