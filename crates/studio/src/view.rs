//! The state of the studio as a viewer reads it.

use serde::Serialize;

use crate::performer::Fall;
use crate::scene::Scene;
use crate::similar::Alike;
use crate::workshop::Span;

/// Everything but frames and strips.
#[derive(Debug, Serialize)]
pub struct View<'a> {
    /// Number that grows with every change.
    pub version: u64,
    /// Name of the scene.
    pub name: String,
    /// The document.
    pub scene: &'a Scene,
    /// Places of blocks in the motion that was made last.
    pub spans: &'a [Span],
    /// Falls.
    pub falls: &'a [Fall],
    /// Reason for which the last request was refused.
    pub problem: &'a str,
    /// Steps that can be undone and redone.
    pub steps: [usize; 2],
    /// Frames per second.
    pub hz: f64,
    /// Duration (s).
    pub seconds: f64,
    /// Motion of the clock.
    pub playing: bool,
    /// Rate of the clock.
    pub rate: f64,
    /// Motion is being made.
    pub building: bool,
    /// A take is kept beside the present one.
    pub kept: bool,
    /// Clips that are like the motion at a time (s), as asked last.
    pub similar: Option<&'a (f64, Vec<Alike>)>,
    /// Sentences are understood.
    pub speaks: bool,
}

impl View<'_> {
    /// Returns it as JSON.
    pub fn to_json(&self) -> String {
        serde_json::to_string(self).unwrap_or_default()
    }
}
