//! Rewards of a frozen policy along sequences, as plain numbers: what a value function of the sequence alone learns from.

use lifelike_checkpoint::Checkpoint;

use crate::gae::{Discounts, advantages};
use crate::{FromInput, TrainError};

/// Consequence of a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum StepEnd {
    /// The next frame of the same sequence.
    Continues = 0,
    /// A failure: nothing.
    Failed = 1,
    /// A cut, by time or by the end of the sequence: another episode, in a fresh state.
    Truncated = 2,
    /// Another sequence, from where the robot was.
    Jumped = 3,
}

impl StepEnd {
    const ALL: [Self; 4] = [Self::Continues, Self::Failed, Self::Truncated, Self::Jumped];
}

/// Rewards of N environments over T steps, all arrays `[T, N]`, step after step.
///
/// The step of row t began at `frame` of `sequence` and was rewarded for the frame after it. The next row of an
/// environment whose episode ended belongs to its next episode.
#[derive(Debug, Clone, PartialEq)]
pub struct RewardRecords {
    /// Names of the sequences.
    pub names: Vec<String>,
    /// Frames per second.
    pub rate: f64,
    /// N.
    pub environments: usize,
    /// Index into [`Self::names`].
    pub sequence: Vec<u32>,
    /// Frame of the sequence at which the step began.
    pub frame: Vec<u32>,
    /// Reward.
    pub reward: Vec<f32>,
    /// Consequence of each step.
    pub end: Vec<StepEnd>,
}

impl RewardRecords {
    /// Returns records of no step.
    pub fn new(names: Vec<String>, rate: f64, environments: usize) -> Self {
        let (sequence, frame) = (Vec::new(), Vec::new());
        Self { names, rate, environments, sequence, frame, reward: Vec::new(), end: Vec::new() }
    }

    /// Returns the number of steps of all environments, T·N.
    pub fn len(&self) -> usize {
        self.reward.len()
    }

    /// Returns true when there are none.
    pub fn is_empty(&self) -> bool {
        self.reward.is_empty()
    }

    /// Returns the targets `v̂_t = v_t + Σ (γλ)^(t'−t) δ_t'` of thesis eqs. 5.3 and 5.4, `[T, N]`, given what the
    /// value function says at (sequence, frame).
    ///
    /// A failed step has no future. A cut one, and an environment's last, is followed by the value of the frame that
    /// it reached. With `across_jumps` a jump goes on with the value of the other sequence, as in the thesis, whose
    /// expectation is over future references too. Else it is a cut.
    pub fn targets(&self, discounts: Discounts, across_jumps: bool, value: impl Fn(u32, u32) -> f32) -> Vec<f32> {
        let n = self.environments;
        let values: Vec<f32> = self.sequence.iter().zip(&self.frame).map(|(s, f)| value(*s, *f)).collect();
        let goes_on = |i: usize| i + n < self.len();
        let cut = |i: usize| match self.end[i] {
            StepEnd::Continues => !goes_on(i),
            StepEnd::Jumped => !(across_jumps && goes_on(i)),
            StepEnd::Failed | StepEnd::Truncated => true,
        };
        let next = |i: usize| if cut(i) { value(self.sequence[i], self.frame[i] + 1) } else { values[i + n] };
        let next: Vec<f32> = (0..self.len()).map(next).collect();
        let terminated: Vec<bool> = self.end.iter().map(|end| *end == StepEnd::Failed).collect();
        let truncated: Vec<bool> = (0..self.len()).map(cut).collect();
        let advantages = advantages(discounts, n, &self.reward, &values, &next, &terminated, &truncated);
        values.iter().zip(advantages).map(|(v, a)| v + a).collect()
    }

    /// Returns the measured returns `Σ γ^k r_{t+k}` of steps, `[T, N]`, up to a failure or over `horizon` steps. NaN
    /// where the records end, are cut or jump before.
    pub fn returns(&self, gamma: f64, horizon: usize) -> Vec<f32> {
        let n = self.environments;
        let of = |first: usize| {
            let (mut sum, mut weight) = (0.0, 1.0);
            for i in (first..self.len()).step_by(n.max(1)).take(horizon) {
                sum += weight * f64::from(self.reward[i]);
                weight *= gamma;
                match self.end[i] {
                    StepEnd::Failed => return sum as f32,
                    StepEnd::Truncated | StepEnd::Jumped if i + n < first + horizon * n => return f32::NAN,
                    _ => {}
                }
            }
            if first + (horizon.max(1) - 1) * n < self.len() { sum as f32 } else { f32::NAN }
        };
        (0..self.len()).map(of).collect()
    }

    /// Writes the records into a file.
    ///
    /// # Errors
    /// A name stands twice in the file.
    pub fn save_into(&self, file: &mut Checkpoint, prefix: &str) -> Result<(), TrainError> {
        let shape = [self.len() / self.environments.max(1), self.environments];
        let wide = |numbers: &[u32]| numbers.iter().map(|x| u64::from(*x)).collect();
        file.set_meta(prefix, &(&self.names, self.rate, self.environments))?;
        file.put_u64(&format!("{prefix}.shape"), &[2], shape.map(|x| x as u64).to_vec())?;
        file.put_u64(&format!("{prefix}.sequence"), &shape, wide(&self.sequence))?;
        file.put_u64(&format!("{prefix}.frame"), &shape, wide(&self.frame))?;
        file.put_f32(&format!("{prefix}.reward"), &shape, self.reward.clone())?;
        Ok(file.put_u8(&format!("{prefix}.end"), &shape, self.end.iter().map(|end| *end as u8).collect())?)
    }

    /// Reads records back.
    ///
    /// # Errors
    /// Arrays are missing or of other lengths, or a number is none that [`Self::save_into`] writes.
    pub fn load(file: &Checkpoint, prefix: &str) -> Result<Self, TrainError> {
        let (names, rate, environments): (Vec<String>, f64, usize) = file.meta(prefix)?;
        let steps = file.u64s(&format!("{prefix}.shape"), &[2])?[0] as usize;
        let shape = [steps, environments];
        let narrow = |name: &str, below: u64| -> Result<Vec<u32>, TrainError> {
            let numbers = file.u64s(&format!("{prefix}.{name}"), &shape)?;
            let wrong = numbers.iter().find(|x| **x >= below);
            let mismatch = |got: &u64| {
                TrainError::mismatch(
                    format!("{}: {prefix}.{name}", file.origin()),
                    format!("numbers below {below}"),
                    got,
                )
            };
            wrong.map_or(Ok(()), |got| Err(mismatch(got)))?;
            Ok(numbers.into_iter().map(|x| x as u32).collect())
        };
        let sequence = narrow("sequence", names.len() as u64)?;
        let frame = narrow("frame", u64::from(u32::MAX))?;
        let ends = file.u8s(&format!("{prefix}.end"), &shape)?;
        let end = |byte: u8| StepEnd::ALL.get(usize::from(byte)).copied();
        let end = ends.into_iter().map(end).collect::<Option<Vec<_>>>().ok_or_else(|| {
            TrainError::mismatch(format!("{}: {prefix}.end", file.origin()), "numbers from 0 to 3", "others")
        })?;
        let reward = file.f32s(&format!("{prefix}.reward"), &shape)?;
        Ok(Self { names, rate, environments, sequence, frame, reward, end })
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    const D: Discounts = Discounts { gamma: 0.5, lambda: 0.5 };

    /// Three steps of one environment: sequence 0 from frame 4, the last row perhaps of sequence 1 from frame 0.
    fn records(end: [StepEnd; 3], other: bool) -> RewardRecords {
        let names = vec!["a".into(), "b".into()];
        RewardRecords {
            sequence: vec![0, 0, u32::from(other)],
            frame: vec![4, 5, if other { 0 } else { 6 }],
            reward: vec![1.0, 2.0, 4.0],
            end: end.to_vec(),
            ..RewardRecords::new(names, 50.0, 1)
        }
    }

    /// Values 3, 5, 7, 8 of frames 4, 5, 6, 7 of the first sequence; 20, 30 of frames 0, 1 of the second.
    fn value(sequence: u32, frame: u32) -> f32 {
        if sequence == 0 { [3.0, 5.0, 7.0, 8.0][frame as usize - 4] } else { [20.0, 30.0][frame as usize] }
    }

    #[test]
    fn targets_by_hand() {
        use StepEnd::{Continues, Failed, Jumped, Truncated};
        let targets = |end, other, across| records(end, other).targets(D, across, value);
        // δ2 = 4 + .5·8 − 7 = 1, δ1 = 2 + .5·7 − 5 = .5, δ0 = 1 + .5·5 − 3 = .5; γλ = .25.
        assert_eq!(targets([Continues; 3], false, true), [3.0 + 0.6875, 5.0 + 0.75, 7.0 + 1.0]);
        // A failure at the second: δ1 = 2 − 5 = −3; δ0 = .5 − .25·3 = −.25. The next episode begins at b0.
        // δ2 = 4 + .5·30 − 20 = −1.
        assert_eq!(targets([Continues, Failed, Continues], true, true), [2.75, 2.0, 19.0]);
        // A cut there: δ1 = 2 + .5·v(a6) − 5 = .5, and nothing of the next episode; δ0 = .5 + .25·.5.
        assert_eq!(targets([Continues, Truncated, Continues], true, true), [3.625, 5.5, 19.0]);
        // A jump: δ1 = 2 + .5·v(b0) − 5 = 7, plus .25·(−1): 6.75; δ0 = .5 + .25·6.75 = 2.1875.
        assert_eq!(targets([Continues, Jumped, Continues], true, true), [5.1875, 11.75, 19.0]);
        // The same as a cut.
        assert_eq!(targets([Continues, Jumped, Continues], true, false), [3.625, 5.5, 19.0]);
        // A jump or a failure at the very end of the records.
        assert_eq!(targets([Continues, Continues, Jumped], false, true)[2], 8.0);
        assert_eq!(targets([Continues, Continues, Failed], false, true)[2], 4.0);
    }

    #[test]
    fn measured_returns_by_hand() {
        use StepEnd::{Continues, Failed, Jumped};
        let returns = |end| records(end, false).returns(0.5, 2);
        let whole = returns([Continues; 3]);
        assert_eq!(whole[..2], [2.0, 4.0]);
        assert!(whole[2].is_nan());
        assert_eq!(returns([Continues, Continues, Failed])[2], 4.0);
        assert_eq!(returns([Failed, Continues, Continues])[0], 1.0);
        let jumped = returns([Continues, Jumped, Continues]);
        assert_eq!(jumped[0], 2.0);
        assert!(jumped[1].is_nan());
    }

    #[test]
    fn records_come_back_from_their_file_and_a_wrong_number_is_refused() {
        let whole = records([StepEnd::Continues, StepEnd::Jumped, StepEnd::Failed], true);
        let mut file = Checkpoint::new();
        whole.save_into(&mut file, "records").unwrap();
        assert_eq!(RewardRecords::load(&file, "records").unwrap(), whole);
        let mut file = Checkpoint::new();
        RewardRecords { names: vec!["a".into()], ..whole }.save_into(&mut file, "records").unwrap();
        let error = RewardRecords::load(&file, "records").unwrap_err().to_string();
        assert!(error.contains("records.sequence") && error.contains("below 1"), "{error}");
    }
}
