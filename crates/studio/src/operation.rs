//! Operations on a scene: one value for each action of a person.

use serde::{Deserialize, Serialize};

use crate::StudioError;
use crate::edits::{Edit, PointGain};
use crate::scene::{Block, Camera, Push, Scene, Switch, line_at};

mod items;
#[cfg(test)]
mod tests;

use items::{block, free, insert, known, shift, split};

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
    /// Moves a point of the body at a time of a block; the rest follows as little as it takes. Standing feet stay.
    Edit {
        /// The block.
        id: String,
        /// A site, a body, or a role such as `left_hand`.
        body: String,
        /// Time within the block's own clip (s).
        at: f64,
        /// Way: forward, left, up, as the robot is turned (m); added to that of the same point and time.
        by: [f64; 3],
        /// Time before and after it in which the motion deviates (s).
        #[serde(default)]
        reach: Option<f64>,
    },
    /// Sets the style of a block's movements; what is not given is the clip's own.
    Style {
        /// The block.
        id: String,
        /// Factor on the movements.
        #[serde(default)]
        gain: Option<f64>,
        /// Frequency (Hz) above which movements are smoothed away.
        #[serde(default)]
        smooth: Option<f64>,
    },
    /// Changes the control point of the motion spline that is nearest to a time of a block.
    Point {
        /// The block.
        id: String,
        /// Time within the block's own clip (s).
        at: f64,
        /// Factor on the distance from where such points usually are; 1 leaves the point as it is.
        gain: f64,
    },
    /// Repairs what cannot be tracked in a block, or no longer does.
    Feasible {
        /// The block.
        id: String,
        /// Repair.
        value: bool,
    },
    /// Removes a block's style, repair, and changed points.
    Plain {
        /// The block.
        id: String,
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
    /// Sets the policy that performs; without a name, the best for the robot.
    Policy {
        /// Its name.
        #[serde(default)]
        name: Option<String>,
    },
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
        !matches!(self, Self::Push(_) | Self::Grab { .. } | Self::Switch(_) | Self::Camera(_) | Self::Policy { .. })
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
            Self::Edit { id, body, at, by, reach } => {
                let edit = Edit { body, at, by, reach };
                let edits = &mut block(scene, &id)?.edits;
                match edits.iter_mut().find(|known| known.is_of(&edit)) {
                    Some(known) => known.add(&edit),
                    None => edits.push(edit),
                }
            }
            Self::Style { id, gain, smooth } => {
                let block = block(scene, &id)?;
                (block.gain, block.smooth) = (gain.filter(|gain| *gain != 1.0), smooth);
            }
            Self::Point { id, at, gain } => {
                let points = &mut block(scene, &id)?.points;
                points.retain(|known| known.at != at);
                points.extend((gain != 1.0).then_some(PointGain { at, gain }));
            }
            Self::Feasible { id, value } => block(scene, &id)?.feasible = value,
            Self::Plain { id } => {
                let block = block(scene, &id)?;
                *block = Block {
                    gain: None,
                    smooth: None,
                    feasible: false,
                    points: Vec::new(),
                    edits: Vec::new(),
                    ..block.clone()
                };
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
            Self::Policy { name } => scene.policy = name,
            Self::Seed { value } => scene.seed = value,
        }
        Ok(())
    }
}
