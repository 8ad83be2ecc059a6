//! The episode of one environment.

use lifelike_checkpoint::{Checkpoint, CheckpointError};
use lifelike_robot::Alignment;
use lifelike_robot::observation::Memory;

use crate::rewards::{TERMS, TermValues};
use crate::terminations::Cause;

/// One environment's episode, and what its last step gave.
#[derive(Debug, Clone, PartialEq)]
pub struct Episode {
    /// Episodes begun in this environment so far: the address of this one's randomness.
    pub number: u64,
    /// Steps since it began.
    pub length: u64,
    /// The frame of the library that the state was last compared with.
    pub frame: usize,
    /// First frame of the segment that is being followed: where the episode began, or switched to.
    pub segment_start: usize,
    /// The segment, first to last frame, that the last step brought to its end by switching to another clip.
    pub finished_segment: Option<(usize, usize)>,
    /// Steps left in which deviations do not end the episode.
    pub grace: u64,
    /// Steps for which the effector deviation of the persistent rule has lasted.
    pub deviated: u64,
    /// Place of the clip's world in the simulated one.
    pub alignment: Alignment,
    /// Sum of rewards so far.
    pub episode_return: f32,
    /// The policy's last output, clamped, `[J]`.
    pub last: Vec<f32>,
    /// The one before, `[J]`.
    pub before: Vec<f32>,
    /// And the one before that, `[J]`: eq. 4.8's second difference needs it, the policy does not see it.
    pub oldest: Vec<f32>,
    /// The frames whose joints `last` and `before` were to reach: what corrections of the reference were corrections of.
    pub asked: [usize; 2],
    /// Encoder offsets, `[J]` (rad).
    pub offset: Vec<f32>,
    /// Delay of what is measured (policy steps).
    pub observation_delay: u64,
    /// Delay of joint targets on their way to the motors (policy steps).
    pub action_delay: u64,
    /// Measurements of the steps before, the newest first; as many as the greatest delay asks for.
    pub past_measurements: Vec<f32>,
    /// Joint targets of the steps before, the newest first, likewise.
    pub past_targets: Vec<f32>,
    /// Earlier observations, where the policy sees them.
    pub memory: Memory,
    /// Terms of the last step's reward.
    pub terms: TermValues,
    /// Mean absolute joint error at the last step (rad).
    pub joint_error: f32,
    /// Rule by which the last step ended the episode.
    pub failed: Option<Cause>,
    /// True when the last step was the episode's last because time or clip was over.
    pub truncated: bool,
}

impl Episode {
    /// Returns the episode before the first reset.
    pub fn new(joints: usize) -> Self {
        Self {
            number: 0,
            length: 0,
            frame: 0,
            segment_start: 0,
            finished_segment: None,
            grace: 0,
            deviated: 0,
            alignment: Alignment::default(),
            episode_return: 0.0,
            last: vec![0.0; joints],
            before: vec![0.0; joints],
            oldest: vec![0.0; joints],
            asked: [0; 2],
            offset: vec![0.0; joints],
            observation_delay: 0,
            action_delay: 0,
            past_measurements: Vec::new(),
            past_targets: Vec::new(),
            memory: Memory::default(),
            terms: [0.0; TERMS.len()],
            joint_error: 0.0,
            failed: None,
            truncated: false,
        }
    }

    /// Begins the next episode at a frame, with nothing to remember; vectors keep their memory.
    pub fn begin(&mut self, frame: usize) {
        self.number += 1;
        (self.frame, self.segment_start) = (frame, frame);
        (self.length, self.grace, self.deviated) = (0, 0, 0);
        (self.finished_segment, self.failed, self.truncated) = (None, None, false);
        (self.episode_return, self.terms) = (0.0, [0.0; TERMS.len()]);
        [&mut self.offset, &mut self.past_measurements, &mut self.past_targets].into_iter().for_each(|x| x.fill(0.0));
        self.memory.clear();
    }

    /// Returns the last step's reward.
    #[inline]
    pub fn reward(&self) -> f32 {
        self.terms.iter().sum()
    }

    /// Returns true when the last step ended the episode.
    pub fn ended(&self) -> bool {
        self.truncated || self.failed.is_some()
    }
}

/// Counters of an episode in a checkpoint.
const COUNTERS: usize = 8;

/// Writes all episodes between two steps (no outcome is pending then).
pub fn save(episodes: &[Episode], checkpoint: &mut Checkpoint, prefix: &str) -> Result<(), CheckpointError> {
    let n = episodes.len();
    let joints = episodes.first().map_or(0, |e| e.last.len());
    let [measured, waiting, seen] = memory(episodes);
    let (mut counters, mut numbers) = (Vec::new(), Vec::new());
    for e in episodes {
        counters.extend([e.number, e.length, e.frame as u64, e.segment_start as u64, e.grace, e.deviated]);
        counters.extend([e.observation_delay, e.action_delay]);
        let a = e.alignment;
        numbers.extend([a.yaw, a.from[0], a.from[1], a.to[0], a.to[1], e.episode_return]);
        numbers.extend(e.last.iter().chain(&e.before).chain(&e.oldest).chain(&e.offset));
        numbers.extend(e.past_measurements.iter().chain(&e.past_targets));
        numbers.extend(e.memory.numbers());
    }
    checkpoint.put_u64(&format!("{prefix}.counters"), &[n, COUNTERS], counters)?;
    let asked = episodes.iter().flat_map(|e| e.asked).map(|frame| frame as u64).collect();
    checkpoint.put_u64(&format!("{prefix}.asked"), &[n, 2], asked)?;
    checkpoint.put_f32(&format!("{prefix}.numbers"), &[n, 6 + 4 * joints + measured + waiting + seen], numbers)
}

/// Returns how many numbers episodes keep: of measurements and of joint targets for the sake of delays, and of observations.
fn memory(episodes: &[Episode]) -> [usize; 3] {
    episodes.first().map_or([0; 3], |e| [e.past_measurements.len(), e.past_targets.len(), e.memory.numbers().count()])
}

/// Reads as many episodes back as `now` are, which tell how much each keeps. The last numbers are the joints, and the numbers
/// of a step that its memory has.
///
/// # Errors
/// The checkpoint is of another number of environments or joints, or of other delays.
pub fn load(
    checkpoint: &Checkpoint,
    prefix: &str,
    now: &[Episode],
    (joints, remembered): (usize, usize),
) -> Result<Vec<Episode>, CheckpointError> {
    let (n, [measured, waiting, seen]) = (now.len(), memory(now));
    let own = 6 + 4 * joints;
    let width = own + measured + waiting + seen;
    let counters = checkpoint.u64s(&format!("{prefix}.counters"), &[n, COUNTERS])?;
    let numbers = checkpoint.f32s(&format!("{prefix}.numbers"), &[n, width])?;
    let asked = checkpoint.u64s(&format!("{prefix}.asked"), &[n, 2])?;
    let rows = counters.chunks_exact(COUNTERS).zip(numbers.chunks_exact(width)).zip(asked.chunks_exact(2));
    let episodes = rows.map(|((c, x), asked)| Episode {
        asked: [asked[0] as usize, asked[1] as usize],
        number: c[0],
        length: c[1],
        frame: c[2] as usize,
        segment_start: c[3] as usize,
        grace: c[4],
        deviated: c[5],
        alignment: Alignment { yaw: x[0], from: [x[1], x[2]], to: [x[3], x[4]] },
        episode_return: x[5],
        last: x[6..6 + joints].to_vec(),
        before: x[6 + joints..6 + 2 * joints].to_vec(),
        oldest: x[6 + 2 * joints..6 + 3 * joints].to_vec(),
        offset: x[6 + 3 * joints..own].to_vec(),
        observation_delay: c[6],
        action_delay: c[7],
        past_measurements: x[own..own + measured].to_vec(),
        past_targets: x[own + measured..width - seen].to_vec(),
        memory: Memory::from_numbers(&x[width - seen..], remembered),
        ..Episode::new(0)
    });
    Ok(episodes.collect())
}
