//! Records of a frozen controller beside the rows of the clips that it followed.

use lifelike_train::RewardRecords;
use sha2::{Digest, Sha256};

use crate::representation::{FeatureMatrix, RepresentationSpec};
use crate::{FromInput, GenerationError};

/// Other rows of a sequence that the same rewards are learned for: a generated motion before it was put on the ground.
#[derive(Debug, Clone)]
pub struct OtherRows {
    /// Number of the sequence in the records.
    pub sequence: usize,
    /// Its rows, in SI units, at the same times.
    pub rows: FeatureMatrix,
}

/// Records and rows that a critic learns from.
#[derive(Debug, Clone)]
pub struct CriticData {
    /// Name of the robot.
    pub robot: String,
    /// SHA-256 of the controller's file, hexadecimal.
    pub controller: String,
    /// Layout of the rows.
    pub representation: RepresentationSpec,
    /// Rows of each of the records' sequences, in SI units.
    pub motions: Vec<FeatureMatrix>,
    /// Other rows of some of the sequences.
    pub others: Vec<OtherRows>,
    /// Rewards along them.
    pub records: RewardRecords,
}

impl CriticData {
    /// Checks that records and rows belong together.
    ///
    /// # Errors
    /// [`GenerationError::Input`] for another number of sequences, rows of another width, a frame beyond a
    /// sequence's end, a reward that is not finite, or no record.
    pub fn check(&self) -> Result<(), GenerationError> {
        self.representation.check()?;
        let (records, width) = (&self.records, self.representation.width());
        if records.names.len() != self.motions.len() {
            return Err(GenerationError::mismatch("motions of the records", records.names.len(), self.motions.len()));
        }
        if let Some((name, motion)) =
            records.names.iter().zip(&self.motions).find(|(_, m)| m.width != width || m.n == 0)
        {
            let got = format!("{} x {}", motion.n, motion.width);
            return Err(GenerationError::mismatch(
                format!("rows of '{name}'"),
                format!("at least one of {width}"),
                got,
            ));
        }
        for OtherRows { sequence, rows } in &self.others {
            let own = self.motions.get(*sequence).map_or(0, |motion| motion.n);
            // Rounding of a duration may add or take a row.
            if rows.width != width || rows.n == 0 || own == 0 || rows.n.abs_diff(own) > 1 {
                let name = records.names.get(*sequence).map_or("no sequence", String::as_str);
                let expected = format!("{own} rows of {width}");
                let got = format!("{} of {}", rows.n, rows.width);
                return Err(GenerationError::mismatch(format!("other rows of '{name}'"), expected, got));
            }
        }
        if records.is_empty() {
            return Err(GenerationError::mismatch("records of rewards", "at least one step", 0));
        }
        for (sequence, frame) in records.sequence.iter().zip(&records.frame) {
            let (name, rows) = (&records.names[*sequence as usize], self.motions[*sequence as usize].n);
            // Rounding may put the last frame half a row beyond the last row.
            if self.place(*frame) > rows as f64 {
                let got = format!("frame {frame} at {} Hz", records.rate);
                return Err(GenerationError::mismatch(
                    format!("record of '{name}'"),
                    format!("a frame of {rows} rows"),
                    got,
                ));
            }
        }
        match records.reward.iter().find(|reward| !reward.is_finite()) {
            Some(reward) => Err(GenerationError::mismatch("rewards of the records", "finite numbers", reward)),
            None => Ok(()),
        }
    }

    /// Returns the row that is nearest to a frame of the records: rows are fewer than control steps, and the critic's
    /// windows stand at rows, as they do in what is generated.
    pub fn row(&self, sequence: u32, frame: u32) -> usize {
        (self.place(frame).round() as usize).min(self.motions[sequence as usize].n - 1)
    }

    /// Returns the number of rows of a motion: of the sequences, then of [`Self::others`].
    pub(super) fn rows_of(&self, motion: usize) -> usize {
        match motion.checked_sub(self.motions.len()) {
            None => self.motions[motion].n,
            Some(other) => self.others[other].rows.n,
        }
    }

    fn place(&self, frame: u32) -> f64 {
        f64::from(frame) * self.representation.fps / self.records.rate
    }

    /// Returns SHA-256 over everything, hexadecimal.
    pub fn digest(&self) -> String {
        let mut hash = Sha256::new();
        for text in [&self.robot, &self.controller].into_iter().chain(&self.records.names) {
            hash.update((text.len() as u64).to_le_bytes());
            hash.update(text.as_bytes());
        }
        let rows = self.motions.iter().chain(self.others.iter().map(|other| &other.rows));
        let rows = rows.flat_map(|motion| &motion.rows);
        rows.chain(&self.records.reward).for_each(|x| hash.update(x.to_le_bytes()));
        let places = self.records.sequence.iter().chain(&self.records.frame);
        places.for_each(|x| hash.update(x.to_le_bytes()));
        self.records.end.iter().for_each(|end| hash.update([*end as u8]));
        hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
    }
}
