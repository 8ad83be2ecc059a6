//! The stages of every round, each run once.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use lifelike_generation::critic::CriticTrainer;
use lifelike_generation::generator::{FILE, Generator, SampleOptions};
use lifelike_language::{CaptionedSet, Entry, Split};
use lifelike_motion::{MotionClip, container};
use lifelike_robot::Robot;
use lifelike_tracking::Trainer;
use rayon::prelude::*;

use super::measure::{Pair, episodes};
use super::plan::{CotrainPlan, StagePlan};
use super::progress::Done;
use crate::commands::controller_file::Loaded;
use crate::commands::eval::Job;
use crate::commands::motion::container_in;
use crate::commands::train::hardware::Hardware;
use crate::commands::train::source::Source;
use crate::commands::{align, train};
use crate::error::CliError;
use crate::output::Output;
use crate::shipped::{self, Kind};

/// A co-training under way.
pub struct Stages<'a> {
    /// Its plan.
    pub plan: &'a CotrainPlan,
    /// Its folder.
    pub folder: &'a Path,
    /// Engine, threads, processor.
    pub hardware: &'a Hardware,
    /// Where to tell of progress.
    pub output: &'a Output,
    /// What is complete.
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
        let folder = self.at(round, "motions");
        let made = self.generated(round - 1, Split::Train, self.plan.prompts, self.plan.seed + round as u64)?;
        made.par_iter().try_for_each(|clip| Ok(container::write(&container_in(&folder, &clip.name), clip)?))
    }

    fn tracker(&mut self, round: usize) -> Result<(), CliError> {
        let Some(plan) = &self.plan.tracker else { return Ok(()) };
        // A run has the value function too; a policy alone has to learn one anew before it learns anything else.
        let before = if round == 1 { self.plan.init.clone() } else { self.at(round - 1, "tracker") };
        let init = format!("init={}", before.display());
        let source = self.source(round, "tracker", plan, [self.clips_with_motions(round), init]);
        train::tracker::run(
            &train::tracker::Args { keys: false, source, hardware: self.hardware.clone() },
            &self.progress_only(),
        )
    }

    fn critic_stage(&mut self, round: usize) -> Result<(), CliError> {
        let controller = format!("controller={}", self.policy(round).display());
        let source = self.source(round, "critic", &self.plan.critic, [self.clips_with_motions(round), controller]);
        let physics = self.hardware.physics.clone();
        train::critic::run(&train::critic::Args { source, controller: None, physics }, &self.progress_only())
    }

    fn align(&mut self, round: usize) -> Result<(), CliError> {
        let networks = [("generator", self.generator(round - 1)), ("critic", self.critic(round))];
        let keys = networks.map(|(key, file)| format!("{key}={}", file.display()));
        let dataset = list("clips", [self.plan.dataset.as_path()]);
        let source = self.source(round, "aligned", &self.plan.align, keys.into_iter().chain([dataset]));
        align::run(&align::Args { generator: None, critic: None, source }, &self.progress_only())
    }

    /// Plays the round's generator by all trackers so far, and its tracker on all generators before.
    fn measure(&mut self, round: usize) -> Result<(), CliError> {
        for other in 0..=round {
            for (generator, tracker) in [(other, self.tracker_of(round)), (round, self.tracker_of(other))] {
                let known = |pair: &Pair| (pair.generator, pair.tracker) == (generator, tracker);
                if !self.done.measured.iter().any(known) {
                    let clips = self.generated(generator, self.plan.split, self.plan.measured, self.plan.seed)?;
                    let loaded = Loaded::load(&self.policy(tracker), Some(&self.plan.robot), None)?;
                    let job = Job { loaded: &loaded, physics: &self.hardware.physics };
                    let evaluation = job.run(&clips, &episodes(&clips), self.output)?;
                    self.done.measured.push(Pair::of(generator, tracker, &evaluation));
                }
            }
        }
        Ok(())
    }

    /// Returns motions of sentences, evenly taken from a split, as long as their entries.
    fn generated(&self, round: usize, split: Split, count: usize, seed: u64) -> Result<Vec<MotionClip>, CliError> {
        let robot = Arc::new(Robot::load(&self.plan.robot)?);
        let generator = Generator::load(&shipped::file(&self.generator(round), Kind::Generator)?)?;
        let set = CaptionedSet::read(&self.plan.dataset)?;
        let longest = generator.header().max_seconds;
        let all: Vec<&Entry> =
            set.entries.iter().filter(|entry| entry.split == split && !entry.captions.is_empty()).collect();
        if all.is_empty() {
            let (file, split) = (self.plan.dataset.display(), split.name());
            return Err(CliError::Input(format!("{file}: expected captioned entries of the split {split}, got none")));
        }
        let count = count.min(all.len());
        let make = |i: usize| {
            let entry = all[i * all.len() / count];
            let (prompt, seconds) = (entry.captions[0].as_str(), Some(entry.seconds.min(longest)));
            let options = SampleOptions { seconds, seed: seed.wrapping_add(i as u64), ..SampleOptions::default() };
            let made = generator.sample(prompt, &options)?;
            let mut clip = generator.clip(&made[0], prompt, &robot)?;
            clip.name = format!("generated-{round}-{i:05}");
            Ok(clip)
        };
        (0..count).into_par_iter().map(make).collect()
    }

    /// The tracker's own clips and the motions of all rounds so far, as a change to a plan.
    fn clips_with_motions(&self, round: usize) -> String {
        let motions: Vec<PathBuf> = (1..=round).map(|round| self.at(round, "motions")).collect();
        list("clips", self.plan.clips.iter().chain(&motions).map(PathBuf::as_path))
    }

    /// The plan of a stage with its changes, or the run that was interrupted.
    fn source(&self, round: usize, name: &str, plan: &StagePlan, keys: impl IntoIterator<Item = String>) -> Source {
        let folder = self.at(round, name);
        let resume = folder.join("plan.toml").exists();
        let own = [format!("robot={}", self.plan.robot), format!("seed={}", self.plan.seed)];
        let keys = own.into_iter().chain(plan.keys.iter().cloned()).chain(keys);
        Source {
            plan: Some(plan.plan.clone()),
            output: Some(folder),
            resume,
            overrides: if resume { Vec::new() } else { keys.collect() },
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
