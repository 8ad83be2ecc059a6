//! Best execution of a motion by a robot: many robots try it at once, and the best followers continue.
//!
//! A controller with an infeasible reference falls, or follows poorly, once. Here `particles` robots get the same
//! reference, each with other noise on its actions (correlated over a tenth of a second). After every window copies of
//! the closest followers replace those that fell (sequential Monte Carlo). If all fell, the search goes back and uses
//! more noise. The result is one simulated motion from beginning to end: no floating, penetration or missing support,
//! whatever the reference.

use lifelike_character::rotation::from_wxyz;
use lifelike_character::{Kinematics, Quat, Vec3};
use lifelike_checkpoint::rng::stream;
use lifelike_motion::{MotionClip, Provenance};
use rand::Rng;
use rand_distr::StandardNormal;

use super::episode::EpisodeConditions;
use super::error::EvaluationError;
use super::fall::fallen;
use super::options::EvaluationOptions;
use super::recorder::Recorder;
use super::rollout::Snapshot;
use super::runner::{Runner, Runs};
use super::setup::EvaluationSetup;
use super::suite::EvaluationSuite;

/// Settings of the search for a motion.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ParticleOptions {
    /// Robots that try at once.
    pub particles: usize,
    /// The largest standard deviation of the noise on actions, in units of the policy's outputs: robots have from none to this.
    pub noise: f64,
    /// Time between selections (s).
    pub window: f64,
    /// Times that it goes back where all fell, before it gives up.
    pub retries: usize,
    /// Key of the noise.
    pub seed: u64,
}

impl Default for ParticleOptions {
    fn default() -> Self {
        Self { particles: 256, noise: 0.2, window: 0.3, retries: 12, seed: 1 }
    }
}

/// A motion that physics made.
#[derive(Debug, Clone, PartialEq)]
pub struct Executed {
    /// The motion, at the controller's rate; as long as somebody was on its feet.
    pub motion: MotionClip,
    /// Share of the clip that was reached without a fall.
    pub reached: f64,
    /// Times that it had to go back.
    pub retried: usize,
}

/// Time over which noise is correlated (s).
const CORRELATED: f64 = 0.1;
/// A robot is this much less likely to be copied (by e) for each unit of cost.
const SELECTION: f64 = 0.1;
/// Units of cost: distance of bodies (m), and of joints (rad).
const BODIES: f64 = 0.05;
const JOINTS: f64 = 0.1;
/// The past is forgotten by this share in each window.
const FORGET: f64 = 0.5;
/// Noise grows by this factor each time that all fell, and by its root less in each window that somebody stands.
const LOUDER: f64 = 1.3;

/// A window of all robots: the frames of each, and whom of the window before it goes on from.
struct Window {
    poses: Vec<Vec<f32>>,
    parents: Vec<usize>,
    /// State from which the window begins again.
    before: Before,
}

struct Before {
    runs: Runs,
    costs: Vec<f64>,
    frame: usize,
}

/// Returns the clip as the controller's robot executes it at its best, from its first frame.
///
/// # Errors
/// A clip that does not fit the robot, a simulation that fails as a whole.
pub fn execute(
    setup: &EvaluationSetup<'_>,
    clip: &MotionClip,
    options: &ParticleOptions,
    mut progress: impl FnMut(usize, usize),
) -> Result<Executed, EvaluationError> {
    let robot = setup.robot();
    let n = options.particles.max(1);
    let whole = EvaluationOptions { seconds: clip.seconds().max(0.1), starts: 1, ..EvaluationOptions::default() };
    let plain = MotionClip { cyclic: false, ..clip.clone() };
    let suite = EvaluationSuite::new(setup, std::slice::from_ref(&plain), &whole)?;
    let library = suite.library();
    let frames = library.range(0).len();
    let recorder = Recorder::new(robot, library, &[]);
    let mut runner = Runner::new(setup.controller, library, (setup.simulate)(None, n)?)?;
    // Where the clip begins, so that both lie over each other.
    let [x, y, _] = library.position_at(0);
    let here = EpisodeConditions { position: [x.into(), y.into()], ..EpisodeConditions::default() };
    runner.begin(&vec![0; n], &vec![here; n])?;

    let length = ((options.window * robot.control_hz).round() as usize).max(1);
    let mut search = Search {
        noise: Noise::new(n, robot.joints(), options, (-1.0 / (CORRELATED * robot.control_hz)).exp()),
        kinematics: Kinematics::new(&robot.character),
        recorder,
        runner,
    };
    let first = search.poses(n);
    let mut windows: Vec<Window> = Vec::new();
    let (mut costs, mut parents, mut frame, mut retried) = (vec![0.0; n], (0..n).collect::<Vec<usize>>(), 1, 0);
    let mut draw = stream(options.seed, "particles", 0, 0);
    while frame + 1 < frames {
        let before = Before { runs: search.runner.save(), costs: costs.clone(), frame };
        let steps = length.min(frames - 1 - frame);
        let tried = search.window(steps, n)?;
        if tried.costs.iter().all(|cost| cost.is_infinite()) {
            retried += 1;
            if retried > options.retries {
                break;
            }
            // Ever further back, with ever more noise.
            search.noise.louder();
            let mut again = before;
            for _ in 0..retried.div_ceil(2).min(windows.len()) {
                if let Some(window) = windows.pop() {
                    (again, parents) = (window.before, window.parents);
                }
            }
            search.runner.restore(&again.runs)?;
            (costs, frame) = (again.costs, again.frame);
            continue;
        }
        let all: Vec<f64> = costs.iter().zip(&tried.costs).map(|(old, new)| (1.0 - FORGET) * old + new).collect();
        windows.push(Window { poses: tried.poses, parents: std::mem::take(&mut parents), before });
        parents = selected(&all, draw.random());
        costs = parents.iter().map(|parent| all[*parent]).collect();
        search.runner.select(&parents)?;
        frame += steps;
        search.noise.calmer();
        progress(frame, frames);
    }
    // The first of the selected is the best; back from it to the beginning.
    let mut at = parents.first().copied().unwrap_or_default();
    let mut rows: Vec<&[f32]> = Vec::new();
    for window in windows.iter().rev() {
        rows.push(&window.poses[at]);
        at = window.parents[at];
    }
    rows.push(&first[at]);
    rows.reverse();
    let motion = motion(clip, robot.control_hz, &robot.layout.joints, &rows.concat());
    Ok(Executed { reached: motion.len() as f64 / (frames - 1).max(1) as f64, motion, retried })
}

/// The robots, and what is measured on them.
struct Search<'a> {
    runner: Runner<'a>,
    recorder: Recorder<'a>,
    kinematics: Kinematics,
    noise: Noise,
}

/// Frames and costs of a window; a robot that fell costs infinitely much.
struct Tried {
    poses: Vec<Vec<f32>>,
    costs: Vec<f64>,
}

impl Search<'_> {
    fn window(&mut self, steps: usize, n: usize) -> Result<Tried, EvaluationError> {
        let mut tried = Tried { poses: vec![Vec::new(); n], costs: vec![0.0; n] };
        for _ in 0..steps {
            let costs = &tried.costs;
            let noise = &mut self.noise;
            self.runner.step_with(|i| costs[i].is_finite(), |i, outputs| noise.add(i, outputs))?;
            let mut asked: Option<Snapshot> = None;
            for i in 0..n {
                if tried.costs[i].is_infinite() {
                    continue;
                }
                let moment = self.runner.moment(i);
                // All robots are asked for the same.
                let reference = asked.get_or_insert_with(|| self.recorder.asked(&moment, &mut self.kinematics));
                let simulated = self.recorder.done(&moment);
                let fell = moment.state.diverged[i] || fallen(reference, &simulated).is_some();
                tried.costs[i] += if fell { f64::INFINITY } else { distance(reference, &simulated) / steps as f64 };
                tried.poses[i].extend(pose(&simulated));
            }
        }
        Ok(tried)
    }

    /// Returns the pose of each robot.
    fn poses(&self, n: usize) -> Vec<Vec<f32>> {
        (0..n).map(|i| pose(&self.recorder.done(&self.runner.moment(i))).collect()).collect()
    }
}

/// Root and joints of a frame, in a row.
fn pose(snapshot: &Snapshot) -> impl Iterator<Item = f32> + '_ {
    let turn = lifelike_character::rotation::to_wxyz(&snapshot.root_orientation);
    let root = snapshot.root_position.iter().copied().chain(turn).collect::<Vec<f64>>();
    root.into_iter().chain(snapshot.joints.iter().copied()).map(|x| x as f32)
}

/// Returns the distance of a robot from its reference, in units of cost.
fn distance(asked: &Snapshot, done: &Snapshot) -> f64 {
    let bodies = asked.bodies.iter().zip(&done.bodies).skip(1).map(|(a, b)| (a.0 - b.0).norm());
    let joints = asked.joints.iter().zip(&done.joints).map(|(a, b)| (a - b).abs());
    let mean = |sum: f64, count: usize| sum / count.max(1) as f64;
    mean(bodies.sum(), asked.bodies.len().saturating_sub(1)) / BODIES + mean(joints.sum(), asked.joints.len()) / JOINTS
}

/// Returns whom each robot goes on from: the best one first, the others by chance, more of those that cost less (systematic resampling).
fn selected(costs: &[f64], at: f64) -> Vec<usize> {
    let best = (0..costs.len()).min_by(|a, b| costs[*a].total_cmp(&costs[*b])).unwrap_or_default();
    let weights: Vec<f64> = costs.iter().map(|cost| ((costs[best] - cost) / SELECTION).exp()).collect();
    let sum: f64 = weights.iter().sum();
    let n = costs.len();
    let (mut i, mut below) = (0, weights[0]);
    let mut out: Vec<usize> = (0..n)
        .map(|k| {
            while below < (k as f64 + at) / n as f64 * sum && i + 1 < n {
                i += 1;
                below += weights[i];
            }
            i
        })
        .collect();
    out[0] = best;
    out
}

/// Noise on actions that changes slowly.
struct Noise {
    /// `[robot, joint]`, of standard deviation 1.
    values: Vec<f64>,
    /// Standard deviation of each robot's.
    sizes: Vec<f64>,
    /// Factor on all of them.
    loud: f64,
    joints: usize,
    /// Share of the noise of a step that the next one has.
    keep: f64,
    draw: rand_chacha::ChaCha8Rng,
}

impl Noise {
    fn new(n: usize, joints: usize, options: &ParticleOptions, keep: f64) -> Self {
        let sizes = (0..n).map(|i| options.noise * i as f64 / (n - 1).max(1) as f64).collect();
        let draw = stream(options.seed, "particles' noise", 0, 0);
        Self { values: vec![0.0; n * joints], sizes, loud: 1.0, joints, keep, draw }
    }

    fn add(&mut self, i: usize, outputs: &mut [f32]) {
        let fresh = (1.0 - self.keep * self.keep).sqrt();
        for (value, output) in self.values[i * self.joints..].iter_mut().zip(outputs) {
            *value = self.keep * *value + fresh * self.draw.sample::<f64, _>(StandardNormal);
            *output += (self.loud * self.sizes[i] * *value) as f32;
        }
    }

    fn louder(&mut self) {
        self.loud *= LOUDER;
    }

    fn calmer(&mut self) {
        self.loud = (self.loud / LOUDER.sqrt()).max(1.0);
    }
}

/// Rows of root and joints as a clip.
fn motion(clip: &MotionClip, fps: f64, joints: &[String], rows: &[f32]) -> MotionClip {
    let width = 7 + joints.len();
    let rows = || rows.chunks_exact(width).map(|row| row.iter().map(|x| f64::from(*x)).collect::<Vec<f64>>());
    MotionClip {
        name: clip.name.clone(),
        fps,
        joint_names: joints.to_vec(),
        root_position: rows().map(|row| Vec3::new(row[0], row[1], row[2])).collect(),
        root_orientation: rows()
            .map(|row| from_wxyz([row[3], row[4], row[5], row[6]]).unwrap_or_else(Quat::identity))
            .collect(),
        joints: rows().flat_map(|row| row[7..].to_vec()).collect(),
        contacts: None,
        cyclic: false,
        provenance: Provenance { source: format!("'{}' as it is executed", clip.name), ..clip.provenance.clone() },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn those_that_cost_less_go_on_and_the_best_leads() {
        let costs = [0.3, f64::INFINITY, 0.1, 0.3];
        let chosen = selected(&costs, 0.5);
        assert_eq!(chosen[0], 2);
        assert!(!chosen.contains(&1), "{chosen:?}");
        // exp(-2) beside 1: in the mean 0.43 of four places; the best has most of them.
        assert!(chosen.iter().filter(|i| **i == 2).count() >= 3, "{chosen:?}");
        assert_eq!(selected(&[1.0, 1.0, 1.0], 0.5), [0, 1, 2], "equals stay as they are");
    }

    #[test]
    fn noise_has_its_size_and_changes_slowly() {
        let options = ParticleOptions { noise: 0.5, ..ParticleOptions::default() };
        let mut noise = Noise::new(2, 1, &options, 0.8);
        let series: Vec<[f32; 2]> = (0..20_000)
            .map(|_| {
                [0, 1].map(|i| {
                    let mut output = [0.0];
                    noise.add(i, &mut output);
                    output[0]
                })
            })
            .collect();
        assert!(series.iter().all(|x| x[0] == 0.0), "the first robot has none");
        let mean = |of: &dyn Fn(usize) -> f32| (1..series.len()).map(of).sum::<f32>() / (series.len() - 1) as f32;
        let variance = mean(&|t| series[t][1] * series[t][1]);
        let lag = mean(&|t| series[t][1] * series[t - 1][1]);
        assert!((variance.sqrt() - 0.5).abs() < 0.03, "{variance}");
        assert!((lag / variance - 0.8).abs() < 0.03, "{lag}");
    }
}
