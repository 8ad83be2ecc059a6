//! Messages to the engine, and the screen that it draws on.

use std::sync::Arc;

use lifelike_motion::MotionClip;
use lifelike_robot::ReferenceLibrary;
use serde::Deserialize;
use tokio::sync::{oneshot, watch};

use crate::operation::Operation;
use crate::scene::Scene;
use crate::similar::Alike;
use crate::workshop::Built;

/// A command of a viewer.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Request {
    /// An operation on the scene.
    Operation(Operation),
    /// Undoes the last operation.
    Undo,
    /// Redoes the operation that was undone last.
    Redo,
    /// Starts or stops the clock.
    Play(bool),
    /// Sets the clock (s).
    Seek(f64),
    /// Goes some frames on, or back.
    Step(i64),
    /// Sets the rate of the clock.
    Rate(f64),
    /// Pulls a body with a force (N, world), until it is let go.
    Pull {
        /// The body.
        body: String,
        /// The force (N, world).
        newtons: [f64; 3],
    },
    /// Keeps what was simulated as a ghost beside what comes, or forgets it.
    Keep(bool),
    /// Lets go; the pull becomes pushes of the scene.
    Release,
    /// Looks for clips that are like the motion at a time (s).
    Similar(f64),
}

/// Work of the second thread.
pub enum Job {
    /// Makes the motion of a scene of this version.
    Build(u64, Box<Scene>),
    /// Looks for clips that are like a motion at a time (s), but for one.
    Similar(Box<MotionClip>, f64, Option<String>),
}

/// A scene to be saved.
pub struct Save {
    /// The scene as TOML.
    pub text: String,
    /// One who waits until it is saved, and the scene for them.
    pub waits: Option<(oneshot::Sender<Result<Scene, String>>, Scene)>,
}

/// A message to the engine.
pub enum Message {
    /// Of a viewer.
    Request(Request),
    /// The motion of a scene of this version was made.
    Built(u64, Result<(Built, Arc<ReferenceLibrary>), String>),
    /// Clips that are like the motion at a time (s).
    Found(f64, Result<Vec<Alike>, String>),
    /// The scene was saved, or not.
    Saved(Result<(), String>),
    /// Asks for the scene.
    Scene(oneshot::Sender<Scene>),
    /// Asks for the scene and for its file: the answer comes when the file has it, or cannot.
    Save(oneshot::Sender<Result<Scene, String>>),
    /// Ends the thread.
    Close,
}

/// Newest frame, view and strips for viewers. Older ones are lost.
#[derive(Debug, Clone)]
pub struct Screen {
    /// Frames.
    pub frame: watch::Receiver<Arc<Vec<u8>>>,
    /// Views as JSON.
    pub view: watch::Receiver<Arc<String>>,
    /// Strips.
    pub strips: watch::Receiver<Arc<Vec<u8>>>,
}
