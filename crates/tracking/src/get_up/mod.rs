//! A search for the keyframes by which a robot gets up: the cross-entropy method.
//!
//! Rubinstein, "The cross-entropy method for combinatorial and continuous optimization", Methodology and Computing in
//! Applied Probability 1, 1999. Two stages of a [`GetUpScript`] are searched side by side: `roll` from the back, and `rise` from the
//! belly, whose poses are symmetric. Candidates are drawn around a mean, tried in [`trial`], and the best make the next mean.
//!
//! Each candidate is tried on the nominal robot and on twins with hidden parameters, from states in which the robot lies after the
//! script's `lie`. A candidate's value is the average of its mean over all robots and its worst robot's.

mod trial;

use std::path::PathBuf;
use std::sync::Arc;

use lifelike_character::Symmetry;
use lifelike_checkpoint::Checkpoint;
use lifelike_checkpoint::rng::stream;
use lifelike_report::run::RunFolder;
use lifelike_robot::get_up::Key;
use lifelike_robot::{ActionMap, ActionSpec, GetUpScript, Robot};
use lifelike_train::limits::whole;
use lifelike_train::plan;
use lifelike_train::{Budget, Scalar, Schedule, TrainingTask};
use rand_distr::{Distribution, StandardNormal};

use crate::{FromInput, TrackerError};
use trial::{Outcome, Stage, Trials};

/// Name of the script in a run's folder.
pub const FILE: &str = "get-up.toml";
/// Least and greatest time of a key (s).
const SECONDS: [f64; 2] = [0.08, 1.0];
/// Standard deviation of the logarithm of a key's time, for one of a pose of 1.
const TIME_SPREAD: f64 = 0.7;
/// Share of the elites' mean and deviation that enter the next ones.
const LEARNING: [f64; 2] = [0.7, 0.5];
/// Least standard deviation.
const LEAST: f64 = 0.01;

/// Plan of a search.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GetUpPlan {
    /// Robot: a built-in name, or an MJCF or URDF file.
    pub robot: String,
    /// Script to begin with: a TOML file, or the name of a robot that has one.
    ///
    /// Its stage `lie` is kept.
    pub script: PathBuf,
    /// Seed of everything random.
    #[schemars(extend("unit" = "1"))]
    pub seed: u64,
    /// Seeds of the twins on which candidates are tried, beside the nominal robot.
    #[schemars(extend("unit" = "1"))]
    pub twins: Vec<u64>,
    /// Candidates of an iteration.
    #[schemars(extend("unit" = "1"), range(min = 4, max = 4096))]
    pub candidates: usize,
    /// Best candidates, which make the next mean.
    #[schemars(extend("unit" = "1"), range(min = 2, max = 4096))]
    pub elites: usize,
    /// States from which each candidate is tried on each robot.
    #[schemars(extend("unit" = "1"), range(min = 1, max = 64))]
    pub starts: usize,
    /// Standard deviation of the first poses, as a share of half of a joint's range.
    #[schemars(extend("unit" = "1"), range(min = 1e-3, max = 1.0))]
    pub deviation: f64,
    /// Iterations after which the search ends.
    #[schemars(extend("unit" = "iterations"), range(min = 1, max = 1_000_000))]
    pub iterations: u64,
    /// Wall time after which the search ends (minutes).
    #[schemars(extend("unit" = "min"), range(min = 0.0, max = 1e6))]
    pub minutes: Option<f64>,
}

impl GetUpPlan {
    /// Checks the numbers.
    ///
    /// # Errors
    /// The first that is out of range.
    pub fn check(&self) -> Result<(), TrackerError> {
        plan::check("", self)?;
        whole("elites", self.elites as u64, 2, self.candidates as u64)?;
        Ok(whole("twins", self.twins.len() as u64, 0, 64)?)
    }
}

/// One stage's distribution: independent normal numbers.
#[derive(Debug, Clone, PartialEq)]
struct Search {
    stage: Stage,
    mean: Vec<f64>,
    std: Vec<f64>,
}

/// Map between numbers of a candidate and keys. Per key the logarithm of its time, then a number from -1 to 1 of each free joint.
#[derive(Debug, Clone)]
struct Keyframes {
    /// Middle and half of the targets that each joint may have (rad): a target beyond the range pushes with more torque.
    ranges: Vec<(f64, f64)>,
    /// Joints that are free in a symmetric pose, and their partner with its sign.
    free: Vec<(usize, usize, f64)>,
}

impl Keyframes {
    fn new(robot: &Robot) -> Result<Self, TrackerError> {
        let symmetry = Symmetry::derive(&robot.character)?;
        let pi = std::f64::consts::PI;
        let middle_and_half = |(low, high): &(f32, f32)| {
            let (low, high) = (f64::from(*low).max(-2.0 * pi), f64::from(*high).min(2.0 * pi));
            (0.5 * (low + high), 0.5 * (high - low))
        };
        let ranges = ActionMap::new(ActionSpec::Absolute, robot).limits.iter().map(middle_and_half).collect();
        let pairs = symmetry.joint.iter().zip(&symmetry.sign).enumerate();
        // A joint that is its own partner with another sign is zero in a symmetric pose.
        let is_free =
            |(joint, partner, sign): &(usize, usize, f64)| joint < partner || (joint == partner && *sign > 0.0);
        let free = pairs.map(|(joint, (partner, sign))| (joint, *partner, *sign)).filter(is_free).collect();
        Ok(Self { ranges, free })
    }

    /// Returns the numbers of a key.
    fn width(&self, stage: Stage) -> usize {
        1 + if stage == Stage::Rise { self.free.len() } else { self.ranges.len() }
    }

    fn encode(&self, stage: Stage, keys: &[Key]) -> Vec<f64> {
        let mut numbers = Vec::new();
        for key in keys {
            let share = |joint: usize| {
                let (middle, half) = self.ranges[joint];
                ((f64::from(key.pose[joint]) - middle) / half.max(1e-6)).clamp(-1.0, 1.0)
            };
            numbers.push(key.seconds.ln());
            match stage {
                Stage::Rise => numbers.extend(self.free.iter().map(|(joint, ..)| share(*joint))),
                Stage::Roll => numbers.extend((0..self.ranges.len()).map(share)),
            }
        }
        numbers
    }

    fn decode(&self, stage: Stage, numbers: &[f64]) -> Vec<Key> {
        let mut keys = Vec::new();
        for numbers in numbers.chunks_exact(self.width(stage)) {
            let angle = |joint: usize, share: f64| {
                let (middle, half) = self.ranges[joint];
                (middle + half * share.clamp(-1.0, 1.0)) as f32
            };
            let mut pose = vec![0.0; self.ranges.len()];
            match stage {
                Stage::Rise => {
                    for ((joint, partner, sign), share) in self.free.iter().zip(&numbers[1..]) {
                        pose[*joint] = angle(*joint, *share);
                        pose[*partner] = *sign as f32 * pose[*joint];
                    }
                }
                Stage::Roll => {
                    pose.iter_mut().enumerate().for_each(|(joint, own)| *own = angle(joint, numbers[1 + joint]));
                }
            }
            // As the file has them: what is tried is what is written.
            pose.iter_mut().for_each(|angle| *angle = (*angle * 100.0).round() / 100.0);
            let seconds = numbers[0].exp().clamp(SECONDS[0], SECONDS[1]);
            keys.push(Key { seconds: (seconds * 100.0).round() / 100.0, pose });
        }
        keys
    }
}

/// Numbers of one iteration.
#[derive(Debug, Clone)]
pub struct GetUpMetrics {
    /// Of `roll` and of `rise`: value of the mean, share of its trials that succeeded on each robot, mean value of the elites.
    stages: [(f64, Vec<f64>, f64); 2],
}

impl GetUpMetrics {
    /// Returns the least share of trials in which the mean succeeded, over robots: of `roll` and of `rise`.
    pub fn success(&self) -> [f64; 2] {
        [0, 1].map(|stage| self.stages[stage].1.iter().copied().fold(1.0, f64::min))
    }
}

/// A search at work.
pub struct GetUpSearch {
    plan: GetUpPlan,
    script: GetUpScript,
    keyframes: Keyframes,
    trials: Trials,
    searches: [Search; 2],
    iteration: u64,
}

impl GetUpSearch {
    /// Drops the robots, and begins around a script.
    ///
    /// # Errors
    /// The plan is out of range, the script is of another robot, or the robot cannot be simulated.
    pub fn new(
        plan: &GetUpPlan,
        robot: &Arc<Robot>,
        script: GetUpScript,
        threads: usize,
    ) -> Result<Self, TrackerError> {
        plan.check()?;
        lifelike_robot::GetUp::new(&script, Arc::clone(robot))?;
        let keyframes = Keyframes::new(robot)?;
        let begin = |stage: Stage, keys: &[Key]| {
            let mean = keyframes.encode(stage, keys);
            let width = keyframes.width(stage);
            let spread = |i: usize| if i.is_multiple_of(width) { TIME_SPREAD * plan.deviation } else { plan.deviation };
            Search { stage, std: (0..mean.len()).map(spread).collect(), mean }
        };
        let searches = [begin(Stage::Roll, &script.roll), begin(Stage::Rise, &script.rise)];
        let trials = Trials::new(plan, robot, &script, threads)?;
        Ok(Self { plan: plan.clone(), script, keyframes, trials, searches, iteration: 0 })
    }

    /// Returns the script of the present means.
    pub fn script(&self) -> GetUpScript {
        let [roll, rise] = [0, 1].map(|i| self.keyframes.decode(self.searches[i].stage, &self.searches[i].mean));
        GetUpScript { roll, rise, ..self.script.clone() }
    }

    /// One iteration of one stage.
    fn iterate(&mut self, index: usize) -> Result<(f64, Vec<f64>, f64), TrackerError> {
        let search = &self.searches[index];
        let draw = |candidate: usize| -> Vec<f64> {
            let mut rng = stream(self.plan.seed, search.stage.name(), candidate as u64, self.iteration);
            let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
            // The first is the mean itself.
            let wide = if candidate == 0 { 0.0 } else { 1.0 };
            search.mean.iter().zip(&search.std).map(|(mean, std)| mean + wide * std * normal()).collect()
        };
        let numbers: Vec<Vec<f64>> = (0..self.plan.candidates).map(draw).collect();
        let keys: Vec<Vec<Key>> = numbers.iter().map(|own| self.keyframes.decode(search.stage, own)).collect();
        let outcomes: Vec<Outcome> = self.trials.run(search.stage, &keys, self.iteration)?;
        let mut order: Vec<usize> = (0..outcomes.len()).collect();
        order.sort_by(|a, b| outcomes[*b].value.total_cmp(&outcomes[*a].value));
        let elites = &order[..self.plan.elites];
        let share = 1.0 / elites.len() as f64;
        let search = &mut self.searches[index];
        for (i, (mean, std)) in search.mean.iter_mut().zip(&mut search.std).enumerate() {
            let center = elites.iter().map(|own| numbers[*own][i]).sum::<f64>() * share;
            let variance = elites.iter().map(|own| (numbers[*own][i] - center).powi(2)).sum::<f64>() * share;
            *mean += LEARNING[0] * (center - *mean);
            *std = (*std + LEARNING[1] * (variance.sqrt() - *std)).max(LEAST);
        }
        let elite = elites.iter().map(|own| outcomes[*own].value).sum::<f64>() * share;
        Ok((outcomes[0].value, outcomes[0].success.clone(), elite))
    }
}

impl TrainingTask for GetUpSearch {
    type Metrics = GetUpMetrics;
    type Error = TrackerError;

    fn iteration(&self) -> u64 {
        self.iteration
    }

    fn budget(&self) -> Budget {
        Budget { done: self.iteration, total: self.plan.iterations, minutes: self.plan.minutes }
    }

    fn schedule(&self) -> Schedule {
        Schedule { checkpoint_every: 5, validate_every: 0, keep: 1 }
    }

    fn identity(&self) -> Vec<(&'static str, String)> {
        vec![("script", text(&self.script))]
    }

    fn step(&mut self) -> Result<GetUpMetrics, TrackerError> {
        let stages = [self.iterate(0)?, self.iterate(1)?];
        self.iteration += 1;
        Ok(GetUpMetrics { stages })
    }

    fn scalars(&self, now: &GetUpMetrics) -> Vec<Scalar> {
        let stage = |search: &Search, (mean, success, elite): &(f64, Vec<f64>, f64)| {
            let name = search.stage.name();
            let spread = search.std.iter().sum::<f64>() / search.std.len().max(1) as f64;
            let robots = success
                .iter()
                .zip(self.trials.names())
                .map(|(share, robot)| (format!("Success/{name}, {robot}"), *share));
            let own = [("mean", *mean), ("elites", *elite), ("deviation", spread)];
            own.map(|(what, value)| (format!("Value/{name} {what}"), value))
                .into_iter()
                .chain(robots)
                .collect::<Vec<_>>()
        };
        self.searches.iter().zip(&now.stages).flat_map(|(search, values)| stage(search, values)).collect()
    }

    fn checkpoint(&self) -> Result<Checkpoint, TrackerError> {
        let mut checkpoint = Checkpoint::new();
        for Search { stage, mean, std } in &self.searches {
            checkpoint.put_f64(&format!("{}.mean", stage.name()), &[mean.len()], mean.clone())?;
            checkpoint.put_f64(&format!("{}.std", stage.name()), &[std.len()], std.clone())?;
        }
        checkpoint.put_u64("progress", &[1], vec![self.iteration])?;
        Ok(checkpoint)
    }

    fn restore(&mut self, checkpoint: &Checkpoint) -> Result<(), TrackerError> {
        for Search { stage, mean, std } in &mut self.searches {
            *mean = checkpoint.f64s(&format!("{}.mean", stage.name()), &[mean.len()])?;
            *std = checkpoint.f64s(&format!("{}.std", stage.name()), &[std.len()])?;
        }
        self.iteration = checkpoint.u64s("progress", &[1])?[0];
        Ok(())
    }

    fn finish(&mut self, folder: &RunFolder) -> Result<(), TrackerError> {
        let path = &folder.path().join(FILE);
        lifelike_checkpoint::write_file(path, text(&self.script()).as_bytes()).map_err(TrackerError::io(path))
    }
}

/// Returns a script as TOML with a line for each key.
pub fn text(script: &GetUpScript) -> String {
    let mut text = format!("joints = {:?}\n", script.joints);
    for (name, keys) in [("lie", &script.lie), ("roll", &script.roll), ("rise", &script.rise)] {
        text += &format!("\n{name} = [\n");
        for Key { seconds, pose } in keys {
            let pose = pose.iter().map(|angle| format!("{angle:.2}")).collect::<Vec<_>>().join(", ");
            text += &format!("  {{ seconds = {seconds:.2}, pose = [{pose}] }},\n");
        }
        text += "]\n";
    }
    text
}

#[cfg(test)]
mod tests;
