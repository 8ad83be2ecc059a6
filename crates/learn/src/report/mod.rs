//! One page that shows a run: playback of physics and reference in 3D, the tables, the curves.
//!
//! `report.html` needs nothing but a browser: no network, no other file. Its parts lie in `page/` as plain HTML, CSS and
//! JavaScript and are put together here; numbers travel inside it as JSON and base64.
//!
//! The main path: [`ReportBuilder::new`] → [`ReportBuilder::playback`], [`ReportBuilder::table`],
//! [`ReportBuilder::curves`] → [`ReportBuilder::write`].
//!
//! The query `?strip` turns the page into a picture for documents: physics above reference at evenly spaced instants
//! (`clip`, `n`, `from`, `to`, `azimuth`, `elevation`, `theme` choose what is seen). `?clip=NAME&t=SECONDS` opens a clip
//! at an instant, paused.

mod base64;
mod builder;
mod curve;
mod drawing;
mod playback;
mod scene;
mod table;

pub use builder::ReportBuilder;
pub use curve::{Curve, curves_from};
pub use drawing::{Drawing, Panel, Picture};
pub use playback::{BodyPose, Playback};
pub use table::{Align, Cell, Column, Table, Tone};
