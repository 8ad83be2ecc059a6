//! The scene: the one document a person works on, `*.scene.toml`.

use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::edits::{Edit, PointGain, within};
use crate::{FromInput, StudioError};

#[cfg(test)]
mod tests;

/// Suffix of scene files.
pub const EXTENSION: &str = ".scene.toml";
/// Most blocks, pushes and switches of a scene together.
pub const MAX_ITEMS: usize = 5000;
/// Longest time that a scene may name (s).
const MAX_SECONDS: f64 = 3600.0;
/// Largest push (N).
const MAX_NEWTONS: f64 = 1e5;

/// A scene: motion one block after the other, motion laid over it, pushes, switches of conditions, and a camera.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scene {
    /// Robot: a name, or an MJCF or URDF file.
    #[serde(default = "lima")]
    pub robot: String,
    /// Policy; the robot's own that comes with the program where not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub policy: Option<String>,
    /// Random seed of sentences that have none of their own.
    #[serde(default)]
    pub seed: u64,
    /// View of the page.
    #[serde(default, skip_serializing_if = "Camera::is_default")]
    pub camera: Camera,
    /// Blocks that follow each other.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub motion: Vec<Block>,
    /// Blocks laid over these: parts of the body from other motion.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub over: Vec<Block>,
    /// Pushes.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub push: Vec<Push>,
    /// Switches of conditions.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub switch: Vec<Switch>,
}

fn lima() -> String {
    "lima".into()
}

/// View of the page.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Camera {
    /// Azimuth (rad).
    pub azimuth: f64,
    /// Elevation (rad).
    pub elevation: f64,
    /// Distance as a multiple of the robot's height.
    pub distance: f64,
    /// Following of the robot.
    pub follow: bool,
}

impl Default for Camera {
    fn default() -> Self {
        Self { azimuth: -0.9, elevation: 0.2, distance: 2.6, follow: true }
    }
}

impl Camera {
    fn is_default(&self) -> bool {
        *self == Self::default()
    }
}

/// A stretch of motion: of a clip or of a sentence, edited.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Block {
    /// Name, unique within the scene.
    pub id: String,
    /// Clip: a file below the scene's folder, or `builtin:NAME`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub clip: Option<String>,
    /// Sentence in place of a clip.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sentence: Option<String>,
    /// Duration of a sentence (s); the one that its words ask for where not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seconds: Option<f64>,
    /// Random seed of a sentence; the scene's where not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seed: Option<u64>,
    /// Number of motions of a sentence to choose the most feasible from.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub best_of: Option<usize>,
    /// Start within the clip (s).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub start: Option<f64>,
    /// End within the clip (s).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub end: Option<f64>,
    /// Factor on the speed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub speed: Option<f64>,
    /// Left and right exchanged.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub mirror: bool,
    /// Factor on the movements: above 1 is more, below 1 less.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gain: Option<f64>,
    /// Frequency (Hz) above which movements are smoothed away.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub smooth: Option<f64>,
    /// Repair of what cannot be tracked, as by `lifelike motion repair`.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub feasible: bool,
    /// Control points of the motion spline that are changed.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub points: Vec<PointGain>,
    /// Points of the body that are moved.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub edits: Vec<Edit>,
    /// Number of repetitions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub repeat: Option<usize>,
    /// Time for which the robot stands before the block (s).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub wait: Option<f64>,
    /// Time shared with the block before (s).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fade: Option<f64>,
    /// Start in the scene (s), of blocks that are laid over others.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub at: Option<f64>,
    /// Parts of the body or joints, of blocks that are laid over others.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub parts: Vec<String>,
}

/// A force on a body for some time.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Push {
    /// Name, unique within the scene.
    #[serde(default)]
    pub id: String,
    /// Start (s).
    pub at: f64,
    /// Duration (s).
    pub seconds: f64,
    /// The body.
    pub body: String,
    /// Force on its centre of mass (N, world).
    pub newtons: [f64; 3],
}

/// A change of the conditions, from a time on.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Switch {
    /// Name, unique within the scene.
    #[serde(default)]
    pub id: String,
    /// Time (s).
    pub at: f64,
    /// Sliding friction of the ground.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub friction: Option<f64>,
    /// Additional mass (kg) on [`Self::body`].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub load: Option<f64>,
    /// Body of the load.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub body: Option<String>,
    /// Factor on the torque of the motors of [`Self::joints`]; 0 is a failure.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub strength: Option<f64>,
    /// Joints whose motors change; `*` stands for any characters.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub joints: Option<String>,
}

impl Default for Scene {
    fn default() -> Self {
        Self {
            robot: lima(),
            policy: None,
            seed: 0,
            camera: Camera::default(),
            motion: Vec::new(),
            over: Vec::new(),
            push: Vec::new(),
            switch: Vec::new(),
        }
    }
}

impl Scene {
    /// Reads a scene file.
    ///
    /// # Errors
    /// [`StudioError::Input`], and [`StudioError::Scene`] with file and line.
    pub fn load(path: &Path) -> Result<Self, StudioError> {
        let text = std::fs::read_to_string(path).map_err(StudioError::io(path))?;
        Self::parse(&text, &path.display().to_string())
    }

    /// Parses a scene. `file` is named in errors.
    ///
    /// # Errors
    /// [`StudioError::Scene`] with file and line.
    pub fn parse(text: &str, file: &str) -> Result<Self, StudioError> {
        let scene: Self = toml::from_str(text).map_err(|error| {
            let line = error.span().map_or(1, |span| line_at(text, span.start));
            StudioError::Scene { place: format!("{file}:{line}"), message: error.message().to_string() }
        })?;
        scene
            .check()
            .map_err(|(id, message)| StudioError::Scene { place: format!("{file}:{}", line_of(text, &id)), message })?;
        Ok(scene)
    }

    /// Returns an error at the item of this id in a scene's file, or at its robot where there is no id.
    pub fn refused(path: &Path, id: Option<&str>, message: String) -> StudioError {
        // A file that is gone by now has no lines.
        let text = std::fs::read_to_string(path).unwrap_or_default();
        let line = id.map_or_else(|| line_with(&text, "robot", |_| true), |id| line_of(&text, id));
        StudioError::Scene { place: format!("{}:{line}", path.display()), message }
    }

    /// Adds the file and line of the block to an error of a block.
    pub fn located(path: &Path, error: StudioError) -> StudioError {
        match &error {
            StudioError::Block { id, .. } => Self::refused(path, Some(id), error.to_string()),
            _ => error,
        }
    }

    /// Returns the document.
    pub fn to_toml(&self) -> Result<String, StudioError> {
        toml::to_string(self).map_err(|error| StudioError::Operation(format!("scene: {error}")))
    }

    /// Returns every name of a block, push or switch.
    pub fn ids(&self) -> impl Iterator<Item = &str> {
        let blocks = self.motion.iter().chain(&self.over).map(|block| block.id.as_str());
        blocks.chain(self.push.iter().map(|push| push.id.as_str())).chain(self.switch.iter().map(|s| s.id.as_str()))
    }

    /// Checks ranges and names.
    ///
    /// # Errors
    /// The name of the item, and the reason.
    pub(crate) fn check(&self) -> Result<(), (String, String)> {
        let mut seen = std::collections::BTreeSet::new();
        for id in self.ids() {
            if id.is_empty() {
                return Err((
                    String::new(),
                    "expected an id for every block, push and switch, got an empty one".into(),
                ));
            }
            if !seen.insert(id) {
                return Err((id.into(), format!("duplicate id '{id}'; give each item its own")));
            }
        }
        if seen.len() > MAX_ITEMS {
            return Err((String::new(), format!("expected at most {MAX_ITEMS} items, got {}", seen.len())));
        }
        let camera = [self.camera.azimuth, self.camera.elevation, self.camera.distance];
        if !camera.iter().all(|value| value.is_finite()) {
            return Err((String::new(), "camera: expected finite numbers".into()));
        }
        let told = |id: &str| {
            let id = id.to_string();
            move |message: String| (id, message)
        };
        for block in &self.motion {
            block.check(false).map_err(told(&block.id))?;
        }
        for block in &self.over {
            block.check(true).map_err(told(&block.id))?;
        }
        for push in &self.push {
            push.check().map_err(told(&push.id))?;
        }
        for switch in &self.switch {
            switch.check().map_err(told(&switch.id))?;
        }
        Ok(())
    }
}

impl Block {
    fn check(&self, over: bool) -> Result<(), String> {
        if self.clip.is_some() == self.sentence.is_some() {
            return Err("expected either `clip` or `sentence`, got both or neither".into());
        }
        if over && (self.at.is_none() || self.parts.is_empty()) {
            return Err("expected `at` and `parts` of a block that is laid over others".into());
        }
        if !over && (self.at.is_some() || !self.parts.is_empty()) {
            return Err("`at` and `parts` belong to [[over]]; blocks of [[motion]] follow each other".into());
        }
        let times = [("seconds", self.seconds), ("start", self.start), ("end", self.end)];
        for (what, value) in times.into_iter().chain([("fade", self.fade), ("at", self.at), ("wait", self.wait)]) {
            value.map_or(Ok(()), |value| within(what, value, 0.0, MAX_SECONDS))?;
        }
        self.gain.map_or(Ok(()), |gain| within("gain", gain, 0.0, 4.0))?;
        self.smooth.map_or(Ok(()), |hertz| within("smooth", hertz, 0.5, 25.0))?;
        self.points.iter().try_for_each(PointGain::check)?;
        self.edits.iter().try_for_each(Edit::check)?;
        self.speed.map_or(Ok(()), |speed| within("speed", speed, 0.1, 10.0))?;
        self.repeat.map_or(Ok(()), |times| within("repeat", times as f64, 1.0, 1000.0))?;
        self.best_of.map_or(Ok(()), |count| within("best_of", count as f64, 1.0, 256.0))
    }
}

impl Push {
    fn check(&self) -> Result<(), String> {
        within("at", self.at, 0.0, MAX_SECONDS)?;
        within("seconds", self.seconds, 0.0, MAX_SECONDS)?;
        self.newtons.iter().try_for_each(|force| within("newtons", *force, -MAX_NEWTONS, MAX_NEWTONS))
    }
}

impl Switch {
    fn check(&self) -> Result<(), String> {
        within("at", self.at, 0.0, MAX_SECONDS)?;
        self.friction.map_or(Ok(()), |friction| within("friction", friction, 0.0, 10.0))?;
        self.load.map_or(Ok(()), |load| within("load", load, 0.0, 1000.0))?;
        self.strength.map_or(Ok(()), |strength| within("strength", strength, 0.0, 10.0))?;
        if self.load.is_some() != self.body.is_some() {
            return Err("expected `load` (kg) and `body` together".into());
        }
        if self.strength.is_some() != self.joints.is_some() {
            return Err("expected `strength` and `joints` together".into());
        }
        if self.friction.is_none() && self.load.is_none() && self.strength.is_none() {
            return Err("expected `friction`, `load` or `strength`".into());
        }
        Ok(())
    }
}

/// Returns the line of the item of this id in the text of a scene, from 1; the first where there is none.
fn line_of(text: &str, id: &str) -> usize {
    line_with(text, "id", |value| value.trim_matches(['"', '\'']) == id)
}

/// Returns the first line `key = value` whose value is accepted, from 1; the first line where there is none.
fn line_with(text: &str, key: &str, accepts: impl Fn(&str) -> bool) -> usize {
    let value = |line: &str| {
        let rest = line.trim_start().strip_prefix(key)?.trim_start().strip_prefix('=')?;
        Some(rest.split('#').next().unwrap_or_default().trim().to_owned())
    };
    text.lines().position(|line| value(line).is_some_and(|value| accepts(&value))).map_or(1, |line| line + 1)
}

/// Returns the line of a place in a text, from 1.
pub(crate) fn line_at(text: &str, at: usize) -> usize {
    text.as_bytes().iter().take(at).filter(|byte| **byte == b'\n').count() + 1
}
