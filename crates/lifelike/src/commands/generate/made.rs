//! Candidates as files, and what is told about them.

use std::path::{Path, PathBuf};

use lifelike_generation::text::familiarity::Familiarity;
use lifelike_language::script::Script;
use lifelike_motion::{MotionClip, container};

use super::maker::Candidate;
use super::spoken::{PartReport, words_of};
use super::verdict::Verdict;
use crate::error::CliError;

/// The written motion of a prompt.
#[derive(serde::Serialize)]
pub struct Made {
    /// Sentences, in their order.
    pub prompts: Vec<String>,
    /// Files, the best first.
    pub files: Vec<PathBuf>,
    /// Duration (s).
    pub seconds: f64,
    /// Time that sampling and judging took (s).
    pub sampling_seconds: f64,
    /// Candidates that were compared.
    pub candidates: usize,
    /// Verdicts on the files.
    pub verdicts: Vec<Verdict>,
    /// Why the motion may be another than its sentences say.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub doubt: Option<String>,
    /// The sentences as they were understood.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub script: Option<Script>,
    /// Clauses of the best, with their facts.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub parts: Vec<PartReport>,
    /// The best clip.
    #[serde(skip)]
    pub best: Option<MotionClip>,
}

impl Made {
    /// Writes the best of the candidates to this file, and with `all` the others beside it, numbered by their rank. The doubt is that
    /// of [`doubt`].
    ///
    /// # Errors
    /// A file that cannot be written; no candidate.
    pub fn write(
        prompts: &[String],
        candidates: Vec<Candidate>,
        path: &Path,
        all: bool,
        sampling_seconds: f64,
        doubt: Option<String>,
    ) -> Result<Self, CliError> {
        let (count, mut files, mut verdicts, mut best) = (candidates.len(), Vec::new(), Vec::new(), None);
        let parts = candidates.first().map(|one| one.parts.clone()).unwrap_or_default();
        for (rank, mut one) in candidates.into_iter().take(if all { count } else { 1 }).enumerate() {
            let file = numbered(path, rank);
            one.clip.name = stem(&file);
            one.clip.provenance.source += &format!("; {}", one.verdict.words());
            container::write(&file, &one.clip)?;
            files.push(file);
            verdicts.push(one.verdict);
            best.get_or_insert(one.clip);
        }
        let best = best.ok_or_else(|| CliError::Failed("expected a candidate, got none".into()))?;
        let (prompts, seconds) = (prompts.to_vec(), best.seconds());
        Ok(Self {
            prompts,
            files,
            seconds,
            sampling_seconds,
            candidates: count,
            verdicts,
            doubt,
            script: None,
            parts,
            best: Some(best),
        })
    }

    /// Returns a line for each file.
    pub fn text(&self) -> String {
        let line = |(file, verdict): (&PathBuf, &Verdict)| {
            let value = verdict.critic.as_ref().map_or(String::new(), |critic| {
                format!("  (Realism {:.2}, lowest {:.2} at {:.1} s)", critic.realism, critic.lowest, critic.at)
            });
            let doubt = self.doubt.as_ref().map_or(String::new(), |doubt| format!(", but {doubt}"));
            format!("{}: {}{doubt}{value}\n", file.display(), verdict.words())
        };
        let understood = self.script.as_ref().map_or_else(String::new, words_of);
        let parts: String = self.parts.iter().enumerate().map(|(i, part)| part.line(i + 1)).collect();
        let lines: String = self.files.iter().zip(&self.verdicts).map(line).collect();
        understood + &parts + &lines
    }
}

/// Returns why a motion may be another than its sentences say: words that no caption has, or no caption that is near.
pub fn doubt(sentences: &[Familiarity]) -> Option<String> {
    let unknown: Vec<String> =
        sentences.iter().flat_map(|one| &one.unknown).map(|(word, _)| format!("'{word}'")).collect();
    match unknown.as_slice() {
        [] if sentences.iter().all(Familiarity::reads_well) => None,
        [] => Some("may not be what was said: no known caption is near".into()),
        [word] => Some(format!("{word} was not understood")),
        words => Some(format!("{} were not understood", words.join(", "))),
    }
}

/// Returns the file of a rank: the best as named, the others with their place before the endings.
fn numbered(path: &Path, rank: usize) -> PathBuf {
    if rank == 0 {
        return path.to_path_buf();
    }
    let name = path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
    let (stem, endings) = name.split_once('.').unwrap_or((&name, "motion.safetensors"));
    path.with_file_name(format!("{stem}-{}.{endings}", rank + 1))
}

/// Returns a file's name without its endings.
pub fn stem(path: &Path) -> String {
    let name = path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
    name.split_once('.').map_or(name.clone(), |(stem, _)| stem.to_string())
}

/// Returns the file of the script of a motion.
pub fn script_file(path: &Path) -> PathBuf {
    path.with_file_name(format!("{}.script.toml", stem(path)))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use lifelike_generation::text::familiarity::KnownCaptions;

    #[test]
    fn a_word_that_nobody_knows_is_in_the_verdict() {
        let known = KnownCaptions::learn(["a person walks forward", "a person waves"], 100);
        let doubt = |sentences: &[&str]| {
            doubt(&sentences.iter().map(|sentence| known.familiarity(sentence).unwrap()).collect::<Vec<_>>())
        };
        assert_eq!(doubt(&["a person walks forward", "a person waves"]), None);
        assert_eq!(doubt(&["a person cartwheels"]).as_deref(), Some("'cartwheels' was not understood"));
        let two = doubt(&["a person cartwheels", "a person somersaults"]);
        assert_eq!(two.as_deref(), Some("'cartwheels', 'somersaults' were not understood"));
        let far = doubt(&["waves forward waves forward"]);
        assert_eq!(far.as_deref(), Some("may not be what was said: no known caption is near"));
    }

    #[test]
    fn others_than_the_best_are_numbered_before_the_endings() {
        let path = Path::new("out/wave.motion.safetensors");
        assert_eq!(numbered(path, 0), path);
        assert_eq!(numbered(path, 2), Path::new("out/wave-3.motion.safetensors"));
        assert_eq!(numbered(Path::new("wave"), 1), Path::new("wave-2.motion.safetensors"));
        assert_eq!(stem(path), "wave");
    }
}
