//! Floor 7: the studio. A scene is one document of motion, pushes and conditions; physics answers to every change of it.
//!
//! The main path: [`Scene`] → [`Operation`] → [`Document`] → [`Stage::perform`], or [`Studio`] with a page.
//!
//! | type | role |
//! | --- | --- |
//! | [`Scene`] | the text under version control |
//! | [`Operation`] | one value for each action of a person |
//! | [`Document`] | undo and redo without limit, saving |
//! | [`Stage`] | robot, controller and generator; performs a scene from start to end |
//! | [`Studio`] | a local page in which the scene plays while it is edited |
//! | [`Live`] | the same without a page: sentences go in, physics plays in real time |
//!
//! A scene is deterministic. A grab of the mouse becomes pushes of the document, so a session replays to the same bytes.

mod access;
mod assets;
mod document;
mod edited;
mod edits;
mod engine;
mod error;
pub mod examples;
mod files;
mod history;
mod live;
mod operation;
mod packet;
mod performer;
mod request;
mod scene;
mod sentence;
mod server;
mod similar;
mod socket;
mod stage;
#[cfg(test)]
mod tests;
mod view;
mod workers;
mod workshop;

pub use document::Document;
pub use edits::{Edit, PointGain};
pub use error::StudioError;
use lifelike_checkpoint::FromInput;
pub use live::{Down, Live, Said, Status};
pub use operation::Operation;
pub use performer::Fall;
pub use scene::{Block, Camera, EXTENSION, Push, Scene, Switch};
pub use sentence::read_by;
pub use server::{RunCommand, Studio};
pub use similar::Alike;
pub use stage::{Policies, Stage, Take, name_of};
pub use workshop::{Built, Span};
