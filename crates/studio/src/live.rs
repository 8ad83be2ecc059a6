//! The studio without a page: sentences go in while physics runs in real time.

use std::sync::mpsc::Sender;

use serde::Deserialize;

use crate::StudioError;
use crate::document::Document;
use crate::engine::Engine;
use crate::operation::Operation;
use crate::packet::Head;
use crate::request::{Message, Request, Screen};
use crate::stage::Stage;

/// A running scene.
#[derive(Debug)]
pub struct Live {
    engine: Sender<Message>,
    screen: Screen,
}

/// The state of a running scene.
#[derive(Debug, Clone, PartialEq, Default, Deserialize)]
pub struct Status {
    /// Blocks in the order of time.
    pub spans: Vec<Said>,
    /// Falls so far.
    pub falls: Vec<Down>,
    /// Reason for which the last request was refused; empty where it was not.
    pub problem: String,
    /// Number of changes.
    pub version: u64,
    /// Duration of the scene (s).
    pub seconds: f64,
    /// Frames per second.
    pub hz: f64,
    /// Motion is being made.
    pub building: bool,
    /// The clock runs.
    pub playing: bool,
    /// Frame of the clock.
    #[serde(skip)]
    pub frame: usize,
    /// Frames that physics has simulated.
    #[serde(skip)]
    pub simulated: usize,
}

/// A block of a running scene.
#[derive(Debug, Clone, PartialEq, Default, Deserialize)]
pub struct Said {
    /// Name of the block.
    pub id: String,
    /// Start (s).
    pub from: f64,
    /// End (s).
    pub to: f64,
    /// The script that was understood, and its maker.
    pub source: String,
}

/// A fall of a running scene.
#[derive(Debug, Clone, PartialEq, Default, Deserialize)]
pub struct Down {
    /// Time (s).
    pub second: f64,
    /// Sign by which it is known, in words.
    pub cause: String,
}

impl Live {
    /// Starts the engine; its clock stands.
    ///
    /// # Errors
    /// [`StudioError`] where the robot cannot be simulated.
    pub fn start(stage: Stage, document: Document) -> Result<Self, StudioError> {
        let (engine, screen) = Engine::start(stage, document)?;
        Ok(Self { engine, screen })
    }

    /// Appends a sentence; it begins where the motion before it ends, or now.
    ///
    /// # Errors
    /// [`StudioError::Server`] where the engine has ended.
    pub fn say(&self, text: &str) -> Result<(), StudioError> {
        self.send(Request::Operation(Operation::Say { text: text.into(), seconds: None, wait: None, index: None }))
    }

    /// Starts the clock, which stops at the end of the motion.
    ///
    /// # Errors
    /// As [`Live::say`].
    pub fn play(&self) -> Result<(), StudioError> {
        self.send(Request::Play(true))
    }

    /// Takes the last sentence back, such as one that cannot be done.
    ///
    /// # Errors
    /// As [`Live::say`].
    pub fn take_back(&self) -> Result<(), StudioError> {
        self.send(Request::Undo)
    }

    /// Returns the state now; an empty one before the engine has drawn its first.
    ///
    /// # Errors
    /// [`StudioError::Server`] where the engine has ended.
    pub fn status(&self) -> Result<Status, StudioError> {
        if self.screen.view.has_changed().is_err() {
            return Err(StudioError::Server("the engine has ended".into()));
        }
        let view = self.screen.view.borrow().clone();
        if view.is_empty() {
            return Ok(Status::default());
        }
        let mut status: Status = serde_json::from_str(&view).map_err(|e| StudioError::Server(e.to_string()))?;
        let counts = Head::counts_of(&self.screen.frame.borrow());
        (status.frame, status.simulated) = (counts[0] as usize, counts[1] as usize);
        Ok(status)
    }

    fn send(&self, request: Request) -> Result<(), StudioError> {
        let ended = |_| StudioError::Server("the engine has ended".into());
        self.engine.send(Message::Request(request)).map_err(ended)
    }
}

impl Drop for Live {
    fn drop(&mut self) {
        let _ = self.engine.send(Message::Close);
    }
}
