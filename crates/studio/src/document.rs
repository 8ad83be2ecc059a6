//! A scene with its history: undo and redo without limit.

use std::path::{Path, PathBuf};

use crate::operation::Operation;
use crate::scene::Scene;
use crate::{FromInput, StudioError};

/// The difference of two texts: at a place, one part for another.
#[derive(Debug, Clone)]
struct Change {
    at: usize,
    before: String,
    after: String,
}

impl Change {
    fn between(before: &str, after: &str) -> Self {
        let same = before.bytes().zip(after.bytes()).take_while(|(a, b)| a == b).count();
        let at = (0..=same).rev().find(|at| before.is_char_boundary(*at) && after.is_char_boundary(*at)).unwrap_or(0);
        let (a, b) = (&before[at..], &after[at..]);
        let same = a.bytes().rev().zip(b.bytes().rev()).take_while(|(a, b)| a == b).count();
        let fits = |n: &usize| a.is_char_boundary(a.len() - n) && b.is_char_boundary(b.len() - n);
        let end = (0..=same).rev().find(fits).unwrap_or(0);
        Self { at, before: a[..a.len() - end].into(), after: b[..b.len() - end].into() }
    }
}

/// A scene, its file, and its history. Each step of the history is only the changed part of the text.
#[derive(Debug)]
pub struct Document {
    scene: Scene,
    text: String,
    path: PathBuf,
    done: Vec<Change>,
    undone: Vec<Change>,
}

impl Document {
    /// Opens a scene file; a file that is missing becomes an empty scene with the first change.
    ///
    /// # Errors
    /// As [`Scene::load`].
    pub fn open(path: &Path, otherwise: impl FnOnce() -> Scene) -> Result<Self, StudioError> {
        let scene = if path.exists() { Scene::load(path)? } else { otherwise() };
        Ok(Self { text: scene.to_toml()?, scene, path: path.into(), done: Vec::new(), undone: Vec::new() })
    }

    /// Returns the scene.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// Returns the file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Returns the numbers of steps that can be undone and redone.
    pub fn steps(&self) -> [usize; 2] {
        [self.done.len(), self.undone.len()]
    }

    /// Returns the document as it is saved.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Applies an operation.
    ///
    /// # Errors
    /// As [`Operation::apply`]; the scene is then as it was.
    pub fn apply(&mut self, operation: Operation) -> Result<(), StudioError> {
        let mut scene = self.scene.clone();
        operation.apply(&mut scene)?;
        let text = scene.to_toml()?;
        if text != self.text {
            self.done.push(Change::between(&self.text, &text));
            self.undone.clear();
        }
        (self.scene, self.text) = (scene, text);
        Ok(())
    }

    /// Takes the last change back; returns whether there was one.
    ///
    /// # Errors
    /// Never, but for a fault of the history.
    pub fn undo(&mut self) -> Result<bool, StudioError> {
        let Some(change) = self.done.pop() else { return Ok(false) };
        self.replace(change.at, change.after.len(), &change.before)?;
        self.undone.push(change);
        Ok(true)
    }

    /// Makes the last change that was taken back again; returns whether there was one.
    ///
    /// # Errors
    /// Never, but for a fault of the history.
    pub fn redo(&mut self) -> Result<bool, StudioError> {
        let Some(change) = self.undone.pop() else { return Ok(false) };
        self.replace(change.at, change.before.len(), &change.after)?;
        self.done.push(change);
        Ok(true)
    }

    fn replace(&mut self, at: usize, length: usize, part: &str) -> Result<(), StudioError> {
        let text = format!("{}{part}{}", &self.text[..at], &self.text[at + length..]);
        let scene = Scene::parse(&text, &self.path.display().to_string())?;
        (self.scene, self.text) = (scene, text);
        Ok(())
    }

    /// Saves: a crash at any moment leaves the old content or the new.
    ///
    /// # Errors
    /// [`StudioError::Input`] where the file cannot be written.
    pub fn save(&self) -> Result<(), StudioError> {
        lifelike_checkpoint::write_file(&self.path, self.text.as_bytes()).map_err(StudioError::io(&self.path))
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn every_step_is_undone_and_redone() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.scene.toml");
        let mut document = Document::open(&path, Scene::default).unwrap();
        let mut states = vec![document.scene().clone()];
        for i in 0..300 {
            let text = match i % 3 {
                0 => format!("say text = \"a person wälks {i}\""),
                1 => format!("seed value = {i}"),
                _ => format!("move id = \"m1\", index = {}", i / 3),
            };
            document.apply(Operation::parse(&text).unwrap()).unwrap();
            states.push(document.scene().clone());
        }
        let last = document.steps()[0];
        states.dedup();
        assert_eq!(states.len(), last + 1);
        for state in states.iter().rev().skip(1) {
            assert!(document.undo().unwrap());
            assert_eq!(document.scene(), state);
            document.save().unwrap();
            assert_eq!(Scene::load(&path).unwrap(), *state, "saved");
        }
        assert!(!document.undo().unwrap());
        for state in &states[1..] {
            assert!(document.redo().unwrap());
            assert_eq!(document.scene(), state);
        }
        assert!(!document.redo().unwrap());
    }
}
