//! Contents of a study: its file, and the trainings that it asks for.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use lifelike_evaluation::ThesisProtocol;
use serde::Deserialize;

use lifelike::CliError;
use lifelike::commands::eval;
use lifelike::plans;

/// A comparison: the common plan, its variants, and classes of clips.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Study {
    /// The plan that all variants have in common.
    pub plan: PathBuf,
    /// Changes to the plan of all variants, as on the command line.
    #[serde(default)]
    pub set: Vec<String>,
    /// Trainings of every variant one after the other, each beginning with the networks of the one before; one where none is named.
    #[serde(default)]
    pub stage: Vec<Stage>,
    pub variant: Vec<Variant>,
    pub class: Vec<Class>,
    /// Rows from elsewhere to stand above ours.
    #[serde(default)]
    pub published: Vec<Published>,
    /// Protocols that the same policies are evaluated by.
    #[serde(default)]
    pub protocol: StudyProtocol,
    /// Episodes per clip, by our own protocol.
    #[serde(default = "five")]
    pub starts: usize,
    /// Longest episode, by our own protocol (s).
    #[serde(default = "ten")]
    pub seconds: f64,
    /// Extent of the thesis' protocol, for each class.
    #[serde(default)]
    pub thesis: ThesisProtocol,
}

/// Protocols of a study's evaluation.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum StudyProtocol {
    /// Ours: episodes on every clip that end with a fall.
    Clips,
    /// The thesis': fixed-length episodes, errors over all frames.
    Thesis,
    /// Both, side by side.
    #[default]
    Both,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Stage {
    pub name: String,
    /// Changes to the plan, as on the command line.
    #[serde(default)]
    pub set: Vec<String>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Variant {
    pub name: String,
    pub seeds: Vec<u64>,
    /// Changes to the plan, as on the command line.
    #[serde(default)]
    pub set: Vec<String>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Class {
    pub name: String,
    pub clips: Vec<PathBuf>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Published {
    pub name: String,
    /// Joint error (deg) and end-effector error (m) by class.
    pub errors: BTreeMap<String, [f64; 2]>,
}

/// One training of a study.
#[derive(Debug, Clone, PartialEq)]
pub struct Job {
    /// Its number in the study's order.
    pub place: usize,
    /// Its variant's name.
    pub variant: String,
    /// Its stage's name; none where a study has one training only.
    pub stage: Option<String>,
    pub seed: u64,
    /// Its folder's name.
    pub folder: String,
    /// That of the training whose networks it begins with.
    pub begins_with: Option<String>,
    /// Changes to the common plan, as on the command line; seed and beginning are not among them.
    pub changes: Vec<String>,
}

impl Study {
    /// Returns all trainings, in an order in which each comes after the one that it begins with.
    pub fn jobs(&self) -> Vec<Job> {
        let mut jobs = Vec::new();
        for variant in &self.variant {
            for &seed in &variant.seeds {
                let mut before = None;
                for (i, stage) in self.stages().into_iter().enumerate() {
                    let last = i + 1 >= self.stage.len();
                    let folder = match stage.filter(|_| !last) {
                        Some(stage) => format!("{}-{seed}.{}", variant.name, stage.name),
                        None => format!("{}-{seed}", variant.name),
                    };
                    let own = stage.map_or(&[][..], |stage| &stage.set);
                    jobs.push(Job {
                        place: jobs.len(),
                        variant: variant.name.clone(),
                        stage: stage.map(|stage| stage.name.clone()),
                        seed,
                        begins_with: before.replace(folder.clone()),
                        folder,
                        changes: self.set.iter().chain(&variant.set).chain(own).cloned().collect(),
                    });
                }
            }
        }
        jobs
    }

    /// Returns whether it is evaluated by our own protocol, and by the thesis'.
    pub fn protocols(&self) -> (bool, bool) {
        (self.protocol != StudyProtocol::Thesis, self.protocol != StudyProtocol::Clips)
    }

    /// Returns its stages; a study without has one of no name.
    pub fn stages(&self) -> Vec<Option<&Stage>> {
        if self.stage.is_empty() { vec![None] } else { self.stage.iter().map(Some).collect() }
    }

    /// Checks its seeds and the extent of its evaluations; `file` is where it was read from.
    pub fn check(&self, file: &Path) -> Result<(), CliError> {
        let stages = self.stage.iter().map(|stage| &stage.name);
        for name in self.variant.iter().map(|variant| &variant.name).chain(stages) {
            // Names of folders.
            lifelike::destination::named(Path::new(""), name, "")
                .map_err(|error| CliError::Input(format!("{}: variant or stage: {error}", file.display())))?;
        }
        for Variant { name, seeds, .. } in &self.variant {
            if let Some(twice) = named_twice(seeds) {
                let text = format!("{}: expected every seed of {name} once, got {twice} twice", file.display());
                return Err(CliError::Input(text));
            }
        }
        if !(1..=eval::STARTS).contains(&self.starts) {
            let (file, got) = (file.display(), self.starts);
            return Err(CliError::Input(format!("{file}: expected starts from 1 to {}, got {got}", eval::STARTS)));
        }
        eval::checked(&self.thesis).map_err(|e| CliError::Input(format!("{}: [thesis] {e}", file.display())))?;
        if !(self.seconds > 0.0 && self.seconds <= 3600.0) {
            let text = format!("{}: expected seconds above 0 and at most 3600, got {}", file.display(), self.seconds);
            return Err(CliError::Input(text));
        }
        Ok(())
    }
}

/// Returns a seed that is named a second time: its one training would count as two.
pub fn named_twice(seeds: &[u64]) -> Option<u64> {
    (1..seeds.len()).find(|&i| seeds[..i].contains(&seeds[i])).map(|i| seeds[i])
}

fn five() -> usize {
    5
}

fn ten() -> f64 {
    10.0
}

/// Reads a study; its plan is a built-in one by its name, or a file.
pub fn read(path: &Path) -> Result<Study, CliError> {
    let plans::PlanText { source, text, folder } = plans::find(path)?;
    let mut study: Study = toml::from_str(&text).map_err(|e| CliError::Input(format!("{source}: {e}")))?;
    if let Some(folder) = folder {
        study.plan = plans::located(&study.plan, &folder);
    }
    Ok(study)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use lifelike_tracking::TrackerPlan;

    use super::*;
    use lifelike::overrides;

    #[test]
    fn our_own_studies_can_be_read_and_every_variant_is_a_plan() {
        for name in ["study-thesis", "study-humanoid"] {
            let path = &Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("experiments/{name}.toml"));
            let study = read(path).unwrap();
            let common: TrackerPlan = toml::from_str(&plans::find(&study.plan).unwrap().text).unwrap();
            for job in study.jobs() {
                overrides::apply(common.clone(), &job.changes).unwrap().check().unwrap();
            }
            for variant in &study.variant {
                assert!(!variant.seeds.is_empty(), "{}: {}", path.display(), variant.name);
            }
            for row in &study.published {
                let known = |class: &String| study.class.iter().any(|c| c.name == *class);
                assert!(row.errors.keys().all(known), "{}: {}", path.display(), row.name);
            }
        }
    }

    #[test]
    fn a_study_says_which_protocols_and_how_far() {
        let study = |more: &str| toml::from_str::<Study>(&format!("plan = 'p'\nvariant = []\nclass = []\n{more}"));
        let both = study("").unwrap();
        assert_eq!((both.protocols(), both.thesis.seconds, both.thesis.patience), ((true, true), 30.0, 3.0));
        let only = study("protocol = 'thesis'\n[thesis]\nepisodes = 7\ndistance = 0.2").unwrap();
        assert_eq!((only.protocols(), only.thesis.episodes, only.thesis.distance), ((false, true), 7, Some(0.2)));
        let refused = study("[thesis]\nseconds = 0.0").unwrap().check(Path::new("file")).unwrap_err().to_string();
        assert_eq!(refused, "file: [thesis] seconds: expected above 0 and at most 3600, got 0");
        assert!(study("episodes = 200").unwrap_err().to_string().contains("unknown field `episodes`"));
    }

    #[test]
    fn a_seed_named_twice_is_refused() {
        let study = |seeds: &str| -> Study {
            let variant = format!("[[variant]]\nname = 'M'\nseeds = {seeds}\n");
            toml::from_str(&format!("plan = 'p'\n{variant}[[class]]\nname = 'walk'\nclips = []")).unwrap()
        };
        assert!(study("[3, 4]").check(Path::new("file")).is_ok());
        let refused = study("[3, 4, 3]").check(Path::new("file")).unwrap_err().to_string();
        assert_eq!(refused, "file: expected every seed of M once, got 3 twice");
    }

    #[test]
    fn stages_follow_each_other_and_a_study_without_has_one_training_of_each_seed() {
        let text = |stages: &str| {
            format!(
                "plan = 'p'\nset = ['a=1']\n{stages}[[variant]]\nname = 'M'\nseeds = [3, 4]\nset = ['b=2']\n\
                 [[class]]\nname = 'walk'\nclips = []"
            )
        };
        let jobs = |stages: &str| toml::from_str::<Study>(&text(stages)).unwrap().jobs();
        let told = |jobs: Vec<Job>| -> Vec<(String, Option<String>, usize)> {
            jobs.into_iter().map(|job| (job.folder, job.begins_with, job.changes.len())).collect()
        };
        assert_eq!(told(jobs("")), [("M-3".into(), None, 2), ("M-4".into(), None, 2)]);
        let staged = jobs("[[stage]]\nname = 'taught'\nset = ['c=3']\n[[stage]]\nname = 'on'\n");
        assert_eq!(staged[0].changes, ["a=1", "b=2", "c=3"]);
        let taught = |seed: u64| format!("M-{seed}.taught");
        let expected = [
            (taught(3), None, 3),
            ("M-3".into(), Some(taught(3)), 2),
            (taught(4), None, 3),
            ("M-4".into(), Some(taught(4)), 2),
        ];
        assert_eq!(told(staged), expected);
    }
}
