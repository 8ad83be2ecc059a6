//! Run folders with plan, metrics and checkpoints, and one self-contained page that shows a run: 3D playback of simulation and
//! reference, tables, curves (floor 2).
//!
//! [`run`] is the folder of a run: plan, metrics, checkpoints.
//!
//! `report.html` needs only a browser: no network, no other file. Its parts are plain HTML, CSS and JavaScript in
//! `page/`, assembled here; it embeds numbers as JSON and base64.
//!
//! The main path: [`ReportBuilder::new`] → [`ReportBuilder::playback`], [`ReportBuilder::table`],
//! [`ReportBuilder::curves`] → [`ReportBuilder::write`].
//!
//! The query `?strip` turns the page into a picture for documents: physics above reference at evenly spaced instants
//! (`clip`, `n`, `from`, `to`, `azimuth`, `elevation`, `theme` choose what is seen). `?clip=NAME&t=SECONDS` opens a clip
//! at an instant, paused.
//!
//! [`film`] makes pictures and films of a page's motion: [`film::Film`] → [`film::Camera`] → PNG, GIF, MP4.

mod atomic;
mod base64;
pub mod browser;
mod builder;
mod chart;
mod curve;
mod drawing;
mod error;
pub mod film;
mod live;
mod look;
mod playback;
mod png;
pub mod run;
mod scene;
mod surface;
mod table;
mod terminal;

pub use atomic::write_atomically;
pub use builder::{ReportBuilder, renderer_module};
pub use chart::{Chart, Series};
pub use curve::{Curve, curves_from};
pub use drawing::{Drawing, Panel, Picture};
pub use error::ReportError;
use lifelike_checkpoint::FromInput;
pub use live::LivePage;
pub use look::RobotLook;
pub use playback::{BodyPose, Foot, Playback};
pub use scene::character_json;
pub use table::{Align, Cell, Column, Table, Tone};
pub use terminal::{Screen, wrapped};

/// The README's examples, run as tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
