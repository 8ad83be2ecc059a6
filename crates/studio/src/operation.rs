//! Operations on a scene: one value for each action of a person.

use serde::{Deserialize, Serialize};

use crate::StudioError;
use crate::scene::{Block, Camera, Push, Scene, Switch, line_at};

/// An action of a person. The page sends it as JSON, the command line writes it as `WORD key = value, ...`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "do", rename_all = "snake_case", deny_unknown_fields)]
pub enum Operation {
    /// Adds a sentence to the motion, at the end where no index is given.
    Say {
        /// The sentence.
        text: String,
        /// Duration (s).
        #[serde(default)]
        seconds: Option<f64>,
        /// Time for which the robot stands before (s).
        #[serde(default)]
        wait: Option<f64>,
        /// Place among the blocks, from 0.
        #[serde(default)]
        index: Option<usize>,
    },
    /// Adds a clip to the motion.
    Add {
        /// File below the scene's folder, or `builtin:NAME`.
        clip: String,
        /// Time for which the robot stands before (s).
        #[serde(default)]
        wait: Option<f64>,
        /// Place among the blocks, from 0.
        #[serde(default)]
        index: Option<usize>,
    },
    /// Lays parts of the body of a clip or sentence over the motion.
    Lay {
        /// The clip.
        #[serde(default)]
        clip: Option<String>,
        /// The sentence.
        #[serde(default)]
        text: Option<String>,
        /// Start in the scene (s).
        at: f64,
        /// Parts of the body or joints.
        parts: Vec<String>,
    },
    /// Removes a block, push or switch.
    Remove {
        /// Its name.
        id: String,
    },
    /// Moves a block of the motion to another place, or anything else to another time.
    Move {
        /// Its name.
        id: String,
        /// Place among the blocks, from 0.
        #[serde(default)]
        index: Option<usize>,
        /// Time (s).
        #[serde(default)]
        at: Option<f64>,
    },
    /// Sets start and end within a block's clip (s); without them the whole clip is played.
    Trim {
        /// The block.
        id: String,
        /// Start (s).
        #[serde(default)]
        start: Option<f64>,
        /// End (s).
        #[serde(default)]
        end: Option<f64>,
    },
    /// Splits a block of the motion at a time of its clip (s).
    Split {
        /// The block.
        id: String,
        /// Time within the clip (s).
        at: f64,
    },
    /// Sets the factor on a block's speed.
    Speed {
        /// The block.
        id: String,
        /// The factor.
        value: f64,
    },
    /// Exchanges left and right.
    Mirror {
        /// The block.
        id: String,
    },
    /// Sets the number of repetitions.
    Repeat {
        /// The block.
        id: String,
        /// The number.
        times: usize,
    },
    /// Sets the time for which the robot stands before a block (s).
    Wait {
        /// The block.
        id: String,
        /// Duration (s).
        seconds: f64,
    },
    /// Sets the time that a block shares with the one before (s).
    Fade {
        /// The block.
        id: String,
        /// Duration (s).
        seconds: f64,
    },
    /// Changes a block's sentence, its seed, or the number of motions to choose from.
    Sentence {
        /// The block.
        id: String,
        /// The sentence.
        #[serde(default)]
        text: Option<String>,
        /// Random seed.
        #[serde(default)]
        seed: Option<u64>,
        /// Number of motions to choose the most feasible from.
        #[serde(default)]
        best_of: Option<usize>,
        /// Duration (s).
        #[serde(default)]
        seconds: Option<f64>,
    },
    /// Pushes a body.
    Push(Push),
    /// Adds the pushes of one grab.
    Grab {
        /// The pushes.
        pushes: Vec<Push>,
    },
    /// Switches a condition.
    Switch(Switch),
    /// Sets the camera.
    Camera(Camera),
    /// Sets the random seed of the scene.
    Seed {
        /// The seed.
        value: u64,
    },
}

impl Operation {
    /// Parses `WORD key = value, ...`, values as in TOML.
    ///
    /// # Errors
    /// [`StudioError::Operation`] with the reason.
    ///
    /// ```
    /// use lifelike_studio::Operation;
    ///
    /// let operation = Operation::parse("trim id = \"m1\", start = 0.5")?;
    /// assert_eq!(operation, Operation::Trim { id: "m1".into(), start: Some(0.5), end: None });
    /// # Ok::<(), lifelike_studio::StudioError>(())
    /// ```
    pub fn parse(text: &str) -> Result<Self, StudioError> {
        let text = text.trim();
        let (word, rest) = text.split_once(char::is_whitespace).unwrap_or((text, ""));
        let comma = if rest.trim().is_empty() { "" } else { "," };
        let line = format!("operation = {{ do = \"{}\"{comma} {rest} }}", word.escape_default());
        #[derive(Deserialize)]
        #[serde(deny_unknown_fields)]
        struct Line {
            operation: Operation,
        }
        let parsed: Result<Line, _> = toml::from_str(&line);
        parsed.map(|line| line.operation).map_err(|error| {
            let many = error.span().is_some_and(|span| line_at(&line, span.start) > 1);
            let hint = if many { "one line, " } else { "" };
            let form = "such as: trim id = \"m1\", start = 0.5";
            StudioError::Operation(format!("operation '{text}': {}; expected {hint}{form}", error.message()))
        })
    }

    /// Returns whether it changes the reference motion; otherwise it changes only events or the view.
    pub fn changes_motion(&self) -> bool {
        !matches!(self, Self::Push(_) | Self::Grab { .. } | Self::Switch(_) | Self::Camera(_))
    }

    /// Applies it to a scene; on failure the scene is as it was.
    ///
    /// # Errors
    /// [`StudioError::Operation`] for names and values that the scene does not allow.
    pub fn apply(self, scene: &mut Scene) -> Result<(), StudioError> {
        let mut changed = scene.clone();
        self.change(&mut changed)?;
        changed.check().map_err(|(_, message)| StudioError::Operation(message))?;
        *scene = changed;
        Ok(())
    }

    fn change(self, scene: &mut Scene) -> Result<(), StudioError> {
        match self {
            Self::Say { text, seconds, wait, index } => {
                let block = Block { id: free(scene, 'm'), sentence: Some(text), seconds, wait, ..Block::default() };
                insert(scene, index, block)?;
            }
            Self::Add { clip, wait, index } => {
                let block = Block { id: free(scene, 'm'), clip: Some(clip), wait, ..Block::default() };
                insert(scene, index, block)?;
            }
            Self::Lay { clip, text, at, parts } => {
                let id = free(scene, 'o');
                scene.over.push(Block { id, clip, sentence: text, at: Some(at), parts, ..Block::default() });
            }
            Self::Remove { id } => {
                known(scene, &id)?;
                scene.motion.retain(|block| block.id != id);
                scene.over.retain(|block| block.id != id);
                scene.push.retain(|push| push.id != id);
                scene.switch.retain(|switch| switch.id != id);
            }
            Self::Move { id, index, at } => shift(scene, &id, index, at)?,
            Self::Trim { id, start, end } => {
                let block = block(scene, &id)?;
                (block.start, block.end) = (start, end);
            }
            Self::Split { id, at } => split(scene, &id, at)?,
            Self::Speed { id, value } => block(scene, &id)?.speed = (value != 1.0).then_some(value),
            Self::Mirror { id } => {
                let block = block(scene, &id)?;
                block.mirror = !block.mirror;
            }
            Self::Repeat { id, times } => block(scene, &id)?.repeat = (times != 1).then_some(times),
            Self::Wait { id, seconds } => block(scene, &id)?.wait = (seconds > 0.0).then_some(seconds),
            Self::Fade { id, seconds } => block(scene, &id)?.fade = Some(seconds),
            Self::Sentence { id, text, seed, best_of, seconds } => {
                let block = block(scene, &id)?;
                if block.sentence.is_none() {
                    return Err(StudioError::Operation(format!("block '{id}': expected a sentence, got a clip")));
                }
                block.sentence = text.or(block.sentence.take());
                block.seed = seed.or(block.seed);
                block.best_of = best_of.or(block.best_of);
                block.seconds = seconds.or(block.seconds);
            }
            Self::Push(push) => {
                let id = free(scene, 'p');
                scene.push.push(Push { id, ..push });
            }
            Self::Grab { pushes } => {
                for push in pushes {
                    let id = free(scene, 'p');
                    scene.push.push(Push { id, ..push });
                }
            }
            Self::Switch(switch) => {
                let id = free(scene, 's');
                scene.switch.push(Switch { id, ..switch });
            }
            Self::Camera(camera) => scene.camera = camera,
            Self::Seed { value } => scene.seed = value,
        }
        Ok(())
    }
}

/// Returns a name that is free: a letter and the next number.
fn free(scene: &Scene, letter: char) -> String {
    let number = |id: &str| id.strip_prefix(letter).and_then(|rest| rest.parse::<u64>().ok());
    let last = scene.ids().filter_map(number).max().unwrap_or(0);
    format!("{letter}{}", last.saturating_add(1))
}

fn unknown(scene: &Scene, id: &str) -> StudioError {
    let all: Vec<&str> = scene.ids().take(20).collect();
    StudioError::Operation(format!("expected one of the scene's ids ({}), got '{id}'", all.join(", ")))
}

fn known(scene: &Scene, id: &str) -> Result<(), StudioError> {
    if scene.ids().any(|known| known == id) { Ok(()) } else { Err(unknown(scene, id)) }
}

fn block<'a>(scene: &'a mut Scene, id: &str) -> Result<&'a mut Block, StudioError> {
    let missing = unknown(scene, id);
    scene.motion.iter_mut().chain(&mut scene.over).find(|block| block.id == id).ok_or(missing)
}

fn insert(scene: &mut Scene, index: Option<usize>, block: Block) -> Result<(), StudioError> {
    let count = scene.motion.len();
    let index = index.unwrap_or(count);
    if index > count {
        return Err(StudioError::Operation(format!("index: expected 0 to {count}, got {index}")));
    }
    scene.motion.insert(index, block);
    Ok(())
}

fn shift(scene: &mut Scene, id: &str, index: Option<usize>, at: Option<f64>) -> Result<(), StudioError> {
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

fn split(scene: &mut Scene, id: &str, at: f64) -> Result<(), StudioError> {
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

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn after(operations: &[&str]) -> Scene {
        let mut scene = Scene::default();
        operations.iter().for_each(|text| Operation::parse(text).unwrap().apply(&mut scene).unwrap());
        scene
    }

    #[test]
    fn every_action_is_a_line() {
        let scene = after(&[
            "say text = \"a person walks\"",
            "add clip = \"builtin:wave\", index = 0",
            "lay clip = \"builtin:wave\", at = 1, parts = [\"arms\"]",
            "trim id = \"m2\", start = 0.5, end = 2.5",
            "split id = \"m2\", at = 1.5",
            "speed id = \"m1\", value = 2",
            "mirror id = \"m1\"",
            "repeat id = \"m1\", times = 3",
            "fade id = \"m1\", seconds = 0.2",
            "wait id = \"m1\", seconds = 1",
            "sentence id = \"m1\", seed = 7, best_of = 4",
            "push at = 1, seconds = 0.2, body = \"torso\", newtons = [40, 0, 0]",
            "switch at = 2, friction = 0.3",
            "move id = \"p1\", at = 3",
            "move id = \"m1\", index = 2",
            "camera azimuth = 1, follow = false",
            "seed value = 5",
        ]);
        let ids: Vec<&str> = scene.motion.iter().map(|block| block.id.as_str()).collect();
        assert_eq!(ids, ["m2", "m3", "m1"]);
        let part = |i: usize| (scene.motion[i].start, scene.motion[i].end, scene.motion[i].fade);
        assert_eq!((part(0), part(1)), ((Some(0.5), Some(1.5), None), (Some(1.5), Some(2.5), Some(0.0))));
        assert_eq!((scene.motion[2].speed, scene.motion[2].mirror, scene.motion[2].repeat), (Some(2.0), true, Some(3)));
        assert_eq!((scene.motion[2].seed, scene.motion[2].best_of), (Some(7), Some(4)));
        assert_eq!((scene.push[0].at, scene.switch[0].friction, scene.seed), (3.0, Some(0.3), 5));
        assert!(!scene.camera.follow && scene.camera.azimuth == 1.0);
        let removed = after(&["say text = \"a\"", "say text = \"b\"", "remove id = \"m1\""]);
        assert_eq!(removed.motion.len(), 1);
    }

    #[test]
    fn refused_operations_change_nothing() {
        let mut scene = after(&["add clip = \"builtin:walk\""]);
        let before = scene.clone();
        for (text, told) in [
            ("remove id = \"x\"", "expected one of the scene's ids (m1), got 'x'"),
            ("speed id = \"m1\", value = 0", "speed: expected 0.1 to 10, got 0"),
            ("move id = \"m1\", index = 4", "index: expected 0 to 0, got 4"),
            ("split id = \"m1\", at = -1", "expected a time within"),
            ("sentence id = \"m1\", text = \"a\"", "expected a sentence, got a clip"),
            ("push at = 1, seconds = inf, body = \"b\", newtons = [0, 0, 0]", "seconds: expected"),
        ] {
            let error = Operation::parse(text).unwrap().apply(&mut scene).unwrap_err().to_string();
            assert!(error.contains(told), "{text}: {error}");
            assert_eq!(scene, before, "{text}");
        }
        for text in ["", "fly", "trim id = 3", "trim id = \"m1\", stert = 1", "seed value = 1 } x = {"] {
            assert!(Operation::parse(text).is_err(), "{text}");
        }
    }
}
