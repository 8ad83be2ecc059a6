//! Split of recordings for training and testing: whole groups of them, so that nobody is tested on who was trained on.

use std::collections::BTreeSet;
use std::ops::Range;

use super::SequencesError;
use super::data_plan::DataPlan;
use super::experiments::Experiment;
use super::humans::{FPS, WIDTH};
use lifelike_representation::spline_transformer::SequencePlan;
use lifelike_representation::spline_transformer::{HeldOut, Sequences};
use lifelike_representation::spline_transformer::{Recording, RecordingWindows, Split};
use lifelike_representation::standardizer::{Moments, Standardizer};
use lifelike_train::limits::{whole, wrong};

/// A training on captured people (thesis 3.3.3).
///
/// A recording's group is its SUBJECT where its name begins with one (CMU: `07_01` is of group `07`): what stands
/// before the first underscore. Bandai-Namco's names do not tell the actor but content and style
/// (`dataset-1_bow_angry_001`): these are the group (`bow_angry`), whichever of its two sets. DeepMimic's clips
/// (`humanoid3d_walk`) are one group, which is trained on.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HumansPlan {
    /// Frames of a window, at 30 a second.
    #[serde(default = "window")]
    pub window: usize,
    /// Groups that the loss is watched on.
    #[serde(default = "validation")]
    pub validation: Vec<String>,
    /// Groups of the table. All that are in neither list are trained on; groups that no recording has do no harm.
    #[serde(default = "test")]
    pub test: Vec<String>,
    /// Network and training.
    pub training: SequencePlan,
}

fn window() -> usize {
    64
}

/// CMU: two who walk and kick; Bandai: five kinds of motion.
fn validation() -> Vec<String> {
    ["08", "11", "walk-turn-right_feminine", "wave-left-hand_normal", "run_exhausted", "bye_happy", "walk_old"]
        .map(String::from)
        .to_vec()
}

/// CMU: three who walk, kick a ball and do tai chi; Bandai: eight kinds of motion in as many styles.
fn test() -> Vec<String> {
    let cmu = ["07", "10", "12"];
    let bandai = [
        "walk-turn-left_masculine",
        "wave-both-hands_youthful",
        "raise-up-right-hand_exhausted",
        "run_active",
        "bow_angry",
        "dash_old",
        "guide_proud",
        "walk_sad",
    ];
    cmu.into_iter().chain(bandai).map(String::from).collect()
}

impl HumansPlan {
    /// Returns the thesis' settings, with a latent dimension.
    pub fn new(latent: usize) -> Self {
        let training = SequencePlan { latent, ..Experiment::Motion.plan() };
        Self { window: window(), validation: validation(), test: test(), training }
    }

    /// Sorts recordings by what they are for.
    pub fn split(&self, recordings: Vec<Recording>) -> Split {
        let mut split = Split { training: vec![], validation: vec![], test: vec![] };
        for recording in recordings {
            let group = group_of(&recording.name);
            let is_in = |groups: &[String]| groups.iter().any(|g| g == group);
            let set = match (is_in(&self.test), is_in(&self.validation)) {
                (true, _) => &mut split.test,
                (_, true) => &mut split.validation,
                _ => &mut split.training,
            };
            set.push(recording);
        }
        split
    }

    /// Windows of people's recordings, normalised by the training recordings' mean and standard deviation of each number.
    ///
    /// # Errors
    /// A plan out of range; no window in one of the sets.
    pub fn windows(&self, recordings: Vec<Recording>) -> Result<PeopleWindows, SequencesError> {
        self.check()?;
        let groups: BTreeSet<String> = recordings.iter().map(|r| group_of(&r.name).to_owned()).collect();
        let what = format!("joint rotations of people, {FPS} Hz");
        let mut split = self.split(recordings);
        let mut moments = Moments::new(WIDTH);
        for row in split.training.iter().flat_map(|recording| recording.rows.chunks_exact(WIDTH)) {
            moments.add(row.iter().map(|x| f64::from(*x)));
        }
        let (mean, mut std) = moments.finish();
        std.iter_mut().for_each(|s| *s = s.max(LEAST_STD));
        let standardizer = Standardizer::new(mean, std);
        for recording in [&mut split.training, &mut split.validation, &mut split.test].into_iter().flatten() {
            recording.rows = converted(&recording.rows, |rows| standardizer.normalize(rows));
        }
        let windows = RecordingWindows::new(&what, WIDTH, self.window, self.training.seed, split)?;
        for (key, set) in [("test", HeldOut::Test), ("validation", HeldOut::Validation)] {
            if windows.held_out_len(set) == 0 {
                let there = groups.into_iter().collect::<Vec<_>>().join(", ");
                let expected = format!("groups with a recording of {} frames", self.window);
                return Err(wrong(key, &expected, format!("none of those that there are: {there}")).into());
            }
        }
        Ok(PeopleWindows { windows, standardizer })
    }
}

/// Smallest standard deviation that a number is divided by: some feet hardly turn.
const LEAST_STD: f64 = 0.02;

/// Normalised windows of people's rotations.
#[derive(Debug)]
pub struct PeopleWindows {
    windows: RecordingWindows,
    standardizer: Standardizer,
}

impl PeopleWindows {
    /// Returns rows of sequences in the 6D numbers that [`super::humans`] has.
    ///
    /// # Shapes
    /// `[frames, WIDTH]` to the same.
    pub fn rotations(&self, rows: &[f32]) -> Vec<f32> {
        converted(rows, |rows| self.standardizer.denormalize(rows))
    }
}

/// Returns numbers changed in double precision.
fn converted(rows: &[f32], change: impl Fn(&mut [f64])) -> Vec<f32> {
    let mut numbers: Vec<f64> = rows.iter().map(|x| f64::from(*x)).collect();
    change(&mut numbers);
    numbers.into_iter().map(|x| x as f32).collect()
}

impl Sequences for PeopleWindows {
    fn describe(&self) -> String {
        self.windows.describe()
    }

    fn width(&self) -> usize {
        self.windows.width()
    }

    fn tokens(&self) -> usize {
        self.windows.tokens()
    }

    fn batch(&self, iteration: u64, count: usize) -> Vec<f32> {
        self.windows.batch(iteration, count)
    }

    fn held_out_len(&self, set: HeldOut) -> usize {
        self.windows.held_out_len(set)
    }

    fn held_out(&self, set: HeldOut, range: Range<usize>) -> Vec<f32> {
        self.windows.held_out(set, range)
    }
}

impl DataPlan for HumansPlan {
    fn training(&self) -> &SequencePlan {
        &self.training
    }

    fn training_mut(&mut self) -> &mut SequencePlan {
        &mut self.training
    }

    fn check(&self) -> Result<(), SequencesError> {
        whole("window", self.window as u64, 2, 1 << 14)?;
        if let Some(both) = self.test.iter().find(|group| self.validation.contains(group)) {
            return Err(wrong("test", "groups that are not in validation", format!("'{both}'")).into());
        }
        Ok(self.training.check()?)
    }
}

/// Returns the group of a recording.
pub fn group_of(name: &str) -> &str {
    if let Some(rest) = name.strip_prefix("dataset-") {
        let kind = rest.split_once('_').and_then(|(_, rest)| rest.rsplit_once('_')).map(|(kind, _)| kind);
        return kind.unwrap_or(name);
    }
    name.split_once('_').map_or(name, |(subject, _)| subject)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn recording(name: &str, frames: usize) -> Recording {
        Recording { name: name.into(), rows: vec![0.5; frames * WIDTH] }
    }

    #[test]
    fn groups_are_subjects_or_kinds_of_motion() {
        let names =
            ["07_01", "135_11", "dataset-1_bow_not-confident_001", "dataset-2_walk_active_054", "humanoid3d_run"];
        let groups = names.map(group_of);
        assert_eq!(groups, ["07", "135", "bow_not-confident", "walk_active", "humanoid3d"]);
        assert_eq!(["walk", "dataset-1", ""].map(group_of), ["walk", "dataset-1", ""]);
    }

    #[test]
    fn no_group_is_in_two_sets() {
        let names =
            ["07_01", "07_02", "08_01", "02_01", "humanoid3d_walk", "dataset-1_walk_sad_001", "dataset-2_walk_sad_009"];
        let plan = HumansPlan::new(16);
        plan.check().unwrap();
        let split = plan.split(names.map(|name| recording(name, 70)).into());
        let of = |set: &[Recording]| set.iter().map(|r| r.name.clone()).collect::<Vec<_>>();
        assert_eq!(of(&split.test), ["07_01", "07_02", "dataset-1_walk_sad_001", "dataset-2_walk_sad_009"]);
        assert_eq!(of(&split.validation), ["08_01"]);
        assert_eq!(of(&split.training), ["02_01", "humanoid3d_walk"]);
        let groups = |set: &[Recording]| set.iter().map(|r| group_of(&r.name).to_owned()).collect::<BTreeSet<_>>();
        assert!(groups(&split.test).is_disjoint(&groups(&split.training)));
        let windows = plan.windows(names.map(|name| recording(name, 70)).to_vec()).unwrap();
        assert_eq!(windows.held_out_len(HeldOut::Test), 4);
    }

    #[test]
    fn sets_without_a_window_are_named_with_the_groups_there_are() {
        let plan = HumansPlan::new(16);
        let error = plan.windows(vec![recording("02_01", 70), recording("08_01", 70)]).unwrap_err().to_string();
        assert_eq!(
            error,
            "plan: test: expected groups with a recording of 64 frames, got none of those that there are: 02, 08"
        );
        let error = plan.windows(vec![recording("07_01", 70)]).unwrap_err().to_string();
        assert!(error.contains("a training recording of 64 frames"), "{error}");
        let both = HumansPlan { test: vec!["08".into()], ..plan.clone() };
        assert_eq!(
            both.check().unwrap_err().to_string(),
            "plan: test: expected groups that are not in validation, got '08'"
        );
        assert_eq!(toml::from_str::<HumansPlan>(&toml::to_string(&plan).unwrap()).unwrap(), plan);
    }
}
