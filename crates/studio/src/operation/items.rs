//! Items of a scene by name: found, inserted, moved, split.

use crate::StudioError;
use crate::scene::{Block, Scene};

/// Returns a name that is free: a letter and the next number.
pub(super) fn free(scene: &Scene, letter: char) -> String {
    let number = |id: &str| id.strip_prefix(letter).and_then(|rest| rest.parse::<u64>().ok());
    let last = scene.ids().filter_map(number).max().unwrap_or(0);
    format!("{letter}{}", last.saturating_add(1))
}

fn unknown(scene: &Scene, id: &str) -> StudioError {
    let all: Vec<&str> = scene.ids().take(20).collect();
    StudioError::Operation(format!("expected one of the scene's ids ({}), got '{id}'", all.join(", ")))
}

pub(super) fn known(scene: &Scene, id: &str) -> Result<(), StudioError> {
    if scene.ids().any(|known| known == id) { Ok(()) } else { Err(unknown(scene, id)) }
}

pub(super) fn block<'a>(scene: &'a mut Scene, id: &str) -> Result<&'a mut Block, StudioError> {
    let missing = unknown(scene, id);
    scene.motion.iter_mut().chain(&mut scene.over).find(|block| block.id == id).ok_or(missing)
}

pub(super) fn insert(scene: &mut Scene, index: Option<usize>, block: Block) -> Result<(), StudioError> {
    let count = scene.motion.len();
    let index = index.unwrap_or(count);
    if index > count {
        return Err(StudioError::Operation(format!("index: expected 0 to {count}, got {index}")));
    }
    scene.motion.insert(index, block);
    Ok(())
}

pub(super) fn shift(scene: &mut Scene, id: &str, index: Option<usize>, at: Option<f64>) -> Result<(), StudioError> {
    known(scene, id)?;
    if let Some(from) = scene.motion.iter().position(|block| block.id == id) {
        let to = index.ok_or_else(|| StudioError::Operation(format!("block '{id}': expected `index`, got `at`")))?;
        let block = scene.motion.remove(from);
        return insert(scene, Some(to), block);
    }
    let at = at.ok_or_else(|| StudioError::Operation(format!("'{id}': expected `at` (s), got `index`")))?;
    scene.over.iter_mut().filter(|block| block.id == id).for_each(|block| block.at = Some(at));
    scene.push.iter_mut().filter(|push| push.id == id).for_each(|push| push.at = at);
    scene.switch.iter_mut().filter(|switch| switch.id == id).for_each(|switch| switch.at = at);
    Ok(())
}

pub(super) fn split(scene: &mut Scene, id: &str, at: f64) -> Result<(), StudioError> {
    let next = free(scene, 'm');
    let missing = unknown(scene, id);
    let index = scene.motion.iter().position(|block| block.id == id).ok_or(missing)?;
    let first = &mut scene.motion[index];
    let (start, end) = (first.start.unwrap_or(0.0), first.end.unwrap_or(f64::INFINITY));
    if !(at > start && at < end) || first.repeat.is_some() {
        let message = format!("block '{id}': expected a time within {start} to {end} s and no repetition, got {at} s");
        return Err(StudioError::Operation(message));
    }
    // Halves of one motion meet in one instant.
    let second = Block { id: next, start: Some(at), fade: Some(0.0), wait: None, ..first.clone() };
    first.end = Some(at);
    scene.motion.insert(index + 1, second);
    Ok(())
}
