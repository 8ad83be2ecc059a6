//! The file of a network: words, labels, and matrices as bytes.

use std::fmt::Display;
use std::path::Path;

use lifelike_checkpoint::Checkpoint;
use lifelike_nn::rows::Entry;

use super::network::Network;
use crate::error::LanguageError;

/// Zero of the stored bytes.
const ZERO: f32 = 128.0;

fn broken(error: &dyn Display) -> LanguageError {
    LanguageError::Grammar(format!("reader: {error}"))
}

impl Network {
    /// Writes words, labels and parameters. Matrices are bytes with one scale a column, everything else is exact.
    pub fn save(&self) -> Result<Checkpoint, LanguageError> {
        let mut file = Checkpoint::default();
        for (name, text) in [("vocabulary", self.words().join("\n")), ("labels", self.labels.join("\n"))] {
            file.put_u8(name, &[text.len()], text.into_bytes()).map_err(|e| broken(&e))?;
        }
        for entry in self.parameters.layout().entries() {
            let values = self.parameters.get(&entry.name);
            let Some(columns) = columns(entry) else {
                file.put_f32(&entry.name, &entry.shape, values.to_vec()).map_err(|e| broken(&e))?;
                continue;
            };
            let most = |j: usize| values.iter().skip(j).step_by(columns).map(|x| x.abs()).fold(1e-9, f32::max);
            let scale: Vec<f32> = (0..columns).map(|j| most(j) / (ZERO - 1.0)).collect();
            let bytes = values.chunks_exact(columns).flat_map(|row| row.iter().zip(&scale).map(byte)).collect();
            file.put_u8(&entry.name, &entry.shape, bytes).map_err(|e| broken(&e))?;
            file.put_f32(&format!("{}.scale", entry.name), &[columns], scale).map_err(|e| broken(&e))?;
        }
        Ok(file)
    }

    /// Reads what [`Self::save`] wrote.
    ///
    /// # Errors
    /// Arrays that are missing or of another shape, numbers that are not finite.
    pub fn load(bytes: &[u8]) -> Result<Self, LanguageError> {
        let file = Checkpoint::from_bytes(bytes, Path::new("reader.safetensors")).map_err(|e| broken(&e))?;
        let lines = |name: &str| -> Result<Vec<String>, LanguageError> {
            let shape = file.entry(name).map(|entry| entry.shape().to_vec()).map_err(|e| broken(&e))?;
            let text = String::from_utf8(file.u8s(name, &shape).map_err(|e| broken(&e))?).map_err(|e| broken(&e))?;
            Ok(text.lines().map(str::to_string).collect())
        };
        let mut own = Self::new(lines("vocabulary")?, lines("labels")?, 0)?;
        let entries = own.parameters.layout().entries().to_vec();
        for entry in &entries {
            let values = match columns(entry) {
                None => file.f32s(&entry.name, &entry.shape).map_err(|e| broken(&e))?,
                Some(columns) => {
                    let bytes = file.u8s(&entry.name, &entry.shape).map_err(|e| broken(&e))?;
                    let scale = file.f32s(&format!("{}.scale", entry.name), &[columns]).map_err(|e| broken(&e))?;
                    bytes
                        .iter()
                        .zip(scale.iter().cycle())
                        .map(|(byte, scale)| (f32::from(*byte) - ZERO) * scale)
                        .collect()
                }
            };
            own.parameters.get_mut(&entry.name).copy_from_slice(&values);
        }
        Ok(own)
    }
}

/// Returns the columns of a matrix.
fn columns(entry: &Entry) -> Option<usize> {
    entry.shape.get(1).copied()
}

fn byte((x, scale): (&f32, &f32)) -> u8 {
    (x / scale + ZERO).round().clamp(0.0, 255.0) as u8
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn a_network_is_read_as_it_was_written() {
        let lines = |text: &str| text.split(' ').map(str::to_string).collect::<Vec<_>>();
        let network = Network::new(lines("bow wave"), lines("bow wave stand"), 5).unwrap();
        let read = Network::load(&network.save().unwrap().to_bytes().unwrap()).unwrap();
        assert_eq!((read.words(), &read.labels), (network.words(), &network.labels));
        for entry in network.parameters.layout().entries() {
            let [before, after] = [&network, &read].map(|network| network.parameters.get(&entry.name));
            let most = before.iter().map(|x| x.abs()).fold(0.0, f32::max);
            let error = before.iter().zip(after).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
            assert!(error <= 0.51 * most / 127.0, "{}: {error} of {most}", entry.name);
        }
        let error = Network::load(b"no file").unwrap_err().to_string();
        assert!(error.contains("reader"), "{error}");
    }
}
