//! Motions of a method: the data set's own, or one of every sentence and repetition.

use std::path::Path;
use std::time::Instant;

use lifelike_generation::critic::RewardSurrogate;
use lifelike_generation::generator::{Generated, SampleOptions};
use lifelike_generation::representation::FeatureMatrix;
use lifelike_language::CaptionedSet;
use lifelike_motion::{MotionClip, container};
use rayon::prelude::*;

use super::measured::{Motion, Ruler};
use super::method::Method;
use super::task::Task;
use lifelike::CliError;
use lifelike::Output;
use lifelike::commands::best_of::{self, By};
use lifelike::commands::eval::Job;
use lifelike::commands::projection::project;
use lifelike::progress::Progress;

/// Motions between two signs of progress.
const CHUNK: usize = 16;

/// Parts that all methods have in common.
pub struct Making<'a> {
    /// Measures each motion as it is made.
    pub ruler: &'a Ruler<'a>,
    /// The sentences.
    pub tasks: &'a [Task<'a>],
    /// Settings of the sampler; duration and seed are the task's.
    pub options: SampleOptions,
    /// Folder for clips.
    pub keep: Option<&'a Path>,
}

impl Making<'_> {
    /// Returns the data set's own motions, one of each task.
    pub fn of_data(&self, set: &CaptionedSet) -> Result<Vec<Motion>, CliError> {
        let read = |task: &Task| self.ruler.motion(&set.clip(task.entry)?, task.entry);
        self.tasks.par_iter().map(read).collect()
    }

    /// Returns the data set's own motions as a generator's tokens hold them, one of each task.
    pub fn of_tokens(&self, method: &Method, set: &CaptionedSet) -> Result<Vec<Motion>, CliError> {
        let (generator, robot) = (&method.generator, self.ruler.robot);
        let space = generator.space();
        let hold = |task: &Task| {
            let rows = FeatureMatrix::from_clip(&set.clip(task.entry)?, self.ruler.spec)?;
            let rows = space.decode(&space.encode(&rows)?, rows.n)?;
            let clip = generator.clip(&Generated { rows, candidate: 0 }, task.prompt(), robot)?;
            self.ruler.motion(&clip, task.entry)
        };
        self.tasks.par_iter().map(hold).collect()
    }

    /// Returns a method's motions, repetition after repetition, and the time they took (s). `physics` projects those of a
    /// method that asks for it.
    pub fn of(
        &self,
        method: &Method,
        physics: Option<&Job<'_>>,
        output: &Output,
    ) -> Result<(Vec<Motion>, f64), CliError> {
        let folder = self.keep.map(|folder| folder.join(&method.name));
        if let Some(folder) = &folder {
            std::fs::create_dir_all(folder).map_err(CliError::write(folder))?;
        }
        let make = |(task, repetition): &(&Task, u64)| self.candidates(method, task, *repetition);
        let measure = |((task, _), clip): (&(&Task, u64), &MotionClip)| {
            if let Some(folder) = &folder {
                container::write(&folder.join(format!("{}.motion.safetensors", clip.name)), clip)?;
            }
            self.ruler.motion(clip, task.entry)
        };
        let all: Vec<(&Task, u64)> =
            (0..self.ruler.repetitions).flat_map(|r| self.tasks.iter().map(move |task| (task, r))).collect();
        let mut progress = Progress::new(output, "generating", all.len() as u64);
        let (mut made, began) = (Vec::with_capacity(all.len()), Instant::now());
        for chunk in all.chunks(CHUNK) {
            let quiet = Output { quiet: true, ..*output };
            let candidates = chunk.par_iter().map(make).collect::<Result<Vec<_>, CliError>>()?;
            let mut clips = match (method.best_of, physics) {
                (Some((_, By::Physics)), Some(job)) => best_of::chosen(job, candidates, &quiet)?,
                _ => candidates.into_iter().flatten().collect(),
            };
            if let Some(job) = physics.filter(|_| method.projected) {
                clips = project(job, &clips, &quiet)?;
            }
            made.extend(chunk.par_iter().zip(&clips).map(measure).collect::<Result<Vec<_>, CliError>>()?);
            progress.update(made.len() as u64, all.len() as u64, || method.name.clone());
        }
        progress.finish();
        Ok((made, began.elapsed().as_secs_f64()))
    }

    /// Returns the motions of a task among which physics chooses: one where it does not.
    fn candidates(&self, method: &Method, task: &Task, repetition: u64) -> Result<Vec<MotionClip>, CliError> {
        let (generator, prompt) = (&method.generator, task.prompt());
        let seed = task.seed(self.options.seed, repetition);
        let candidates = method.best_of.map_or(1, |(count, _)| count);
        let options = SampleOptions { seconds: Some(task.entry.seconds), seed, candidates, ..self.options };
        let critic = self.ruler.critic.map(|critic| critic as &dyn RewardSurrogate);
        let mut generated = generator.sample_towards(prompt, &options, critic.zip(method.strength))?;
        if let (Some((_, By::Critic)), Some(critic)) = (method.best_of, self.ruler.critic) {
            let costs =
                generated.iter().map(|one| Ok(-critic.realism(&one.rows)?)).collect::<Result<Vec<_>, CliError>>()?;
            generated = best_of::least(&costs).map(|best| generated.swap_remove(best)).into_iter().collect();
        }
        if generated.is_empty() {
            return Err(CliError::Failed(format!("'{prompt}': expected a motion, got none")));
        }
        let file =
            Path::new(&task.entry.file).file_name().map_or_else(String::new, |s| s.to_string_lossy().into_owned());
        let name = format!("{}-{repetition}", file.trim_end_matches(".motion.safetensors"));
        let clip = |one: &Generated| {
            let clip = generator.clip(one, prompt, self.ruler.robot)?;
            Ok(MotionClip { name: name.clone(), ..clip })
        };
        generated.iter().map(clip).collect()
    }
}
